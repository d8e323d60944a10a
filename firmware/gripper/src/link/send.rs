//! The writing task: answers first, then events, reports, grasps, shapes.

use embassy_futures::select::{Either, Either5, select, select5};
use embassy_time::Timer;
use embedded_io_async::Write;
use messages::frame::FrameError;
use messages::{EstimateTopic, EventTopic, GraspTopic, ShapeTopic};
use postcard_rpc::Topic;
use postcard_rpc::header::{VarHeader, VarKey, VarSeq};

use super::answer::KEY;
use super::wire::framed;
use crate::alive::Task;
use crate::shared::{Frame, Shared};
use crate::write::write_all;

/// Writes to the link for ever, and waits for it as long as it takes.
pub async fn send<W: Write>(shared: &'static Shared, port: W) -> ! {
    match select(shared.alive.beat(Task::Send), write_for_ever(shared, port)).await {
        Either::First(never) | Either::Second(never) => never,
    }
}

async fn write_for_ever<W: Write>(shared: &'static Shared, mut port: W) -> ! {
    let mut events: u16 = 0;
    loop {
        let next = select5(
            shared.answers.receive(),
            shared.notices.receive(),
            shared.reports.receive(),
            shared.grasps.receive(),
            shared.shapes.receive(),
        )
        .await;
        let frame = match next {
            Either5::First(answer) => Ok(answer),
            Either5::Second(notice) => {
                events = events.wrapping_add(1);
                topic::<EventTopic>(events, &notice)
            }
            Either5::Third(report) => topic::<EstimateTopic>(report.sequence as u16, &report),
            Either5::Fourth(grasp) => topic::<GraspTopic>(grasp.sequence as u16, &grasp),
            Either5::Fifth(shape) => topic::<ShapeTopic>(shape.sequence as u16, &shape),
        };
        match frame {
            Ok(frame) => {
                if !write_all(&mut port, &frame).await {
                    // A port that fails at once must not take the processor.
                    Timer::after_millis(10).await;
                }
            }
            Err(_) => shared.add(|counters| &mut counters.link_oversize),
        }
    }
}

fn topic<T: Topic>(sequence: u16, message: &T::Message) -> Result<Frame, FrameError>
where
    T::Message: serde::Serialize,
{
    let mut key = VarKey::Key8(T::TOPIC_KEY);
    key.shrink_to(KEY);
    framed(&VarHeader { key, seq_no: VarSeq::Seq2(sequence) }, message)
}
