//! The tap on another master's bus: it learns what was told, from whom, and nothing else.

mod traffic;

use dynamixel::{Heard, Id, Instruction, StatusError, Tap};
use traffic::{BYTE_US, Frame, SERVOS, TIMING, Traffic, is_position};

type Listener = Tap<256, 4>;

fn id(id: u8) -> Id {
    Id::new(id).unwrap()
}

fn listener() -> Listener {
    let mut tap = Tap::new(TIMING);
    assert!(SERVOS.into_iter().all(|servo| tap.watch(id(servo))));
    tap
}

/// What a tap hears of a frame: reads as (id, address, bytes), the rest in words.
fn hear(tap: &mut Listener, frame: &Frame) -> Vec<String> {
    let mut said = Vec::new();
    let mut bytes = frame.bytes.as_slice();
    while let Some(heard) = tap.hear(frame.end_us(), &mut bytes) {
        said.push(match heard {
            Heard::Read { id, address, bytes, .. } => format!("{id} at {address}: {bytes:?}"),
            Heard::Written { id, address, bytes } => format!("{id} takes at {address}: {bytes:?}"),
            Heard::Found { id, model, firmware } => format!("{id} is {model}/{firmware}"),
            Heard::Refused { id, error, .. } => format!("{id} refuses: {}", error.code()),
            Heard::Stray { id } => format!("stray {id}"),
            Heard::Damaged(_) => "damaged".into(),
        });
    }
    said
}

fn position(tap: &Listener, servo: u8) -> Option<(i32, u64)> {
    tap.servo(id(servo)).unwrap().position.map(|seen| (seen.value, seen.at_us))
}

/// Everything that is told is learned, at once, in pieces of any size.
#[test]
fn all_that_is_told_is_learned() {
    let mut traffic = Traffic::new(1);
    let mut tap = listener();
    let mut learned = 0;
    let mut missed = 0;
    for _ in 0..20_000 {
        let before = SERVOS.map(|servo| traffic.servo(servo).told.len());
        let known = SERVOS.map(|servo| position(&tap, servo));
        let frames = traffic.anything();
        for frame in &frames {
            let mut rest = frame.bytes.as_slice();
            let mut at = frame.start_us;
            while !rest.is_empty() {
                let (piece, behind) = rest.split_at(1 + traffic.below(rest.len()));
                at += piece.len() as u64 * BYTE_US;
                let mut piece = piece;
                while let Some(heard) = tap.hear(at, &mut piece) {
                    assert!(!matches!(heard, Heard::Stray { .. } | Heard::Damaged(_)), "{heard:?} in {frames:02X?}");
                }
                rest = behind;
            }
        }
        for ((servo, before), known) in SERVOS.into_iter().zip(before).zip(known) {
            let told = &traffic.servo(servo).told;
            let now = position(&tap, servo);
            if told.len() == before {
                assert_eq!(now, known);
                continue;
            }
            match now.filter(|_| now != known) {
                Some((value, at_us)) => {
                    assert_eq!(Some(&value), told.last(), "{frames:02X?}");
                    assert!(frames.iter().any(|frame| frame.end_us() == at_us || frame.start_us < at_us));
                    learned += 1;
                }
                None => missed += 1,
            }
        }
    }
    assert!(learned > 9_000 && missed == 0, "{learned} learned, {missed} missed");
}

/// Damage of every kind between the bus and the tap. What it learns is true, and what comes whole is learned.
#[test]
fn damage_costs_what_is_damaged_and_teaches_nothing_wrong() {
    for (seed, percent, kind) in
        [(1, 30, "drop"), (2, 30, "double"), (3, 100, "bits"), (4, 30, "cut"), (5, 30, "noise")]
    {
        // Whoever does not hear that indirect addresses change cannot know.
        let mut traffic = Traffic { redirects: kind != "drop", ..Traffic::new(seed) };
        let mut tap = listener();
        let (mut learned, mut whole, mut missed, mut damaged) = (0u32, 0u32, 0u32, 0u32);
        for _ in 0..20_000 {
            // Direct reads only, where what is whole can be told from what is not by its own question and answer.
            let servo = SERVOS[traffic.below(3)];
            let what = traffic.below(3);
            let frames = match what {
                0 => traffic.ask(servo, Instruction::Read, &[132, 0, 4, 0]),
                1 => traffic.ask(254, Instruction::FastSyncRead, &[132, 0, 4, 0, servo]),
                _ => traffic.anything(),
            };
            let told = traffic.servo(servo).told.last().copied();
            let mut intact = true;
            for frame in &frames {
                let heard = damage(&mut traffic, frame, percent, kind);
                intact &= heard.len() == 1 && heard[0].bytes == frame.bytes;
                heard.iter().for_each(|frame| drop(hear(&mut tap, frame)));
            }
            damaged += u32::from(!intact);
            if intact && what < 2 {
                whole += 1;
                let now = position(&tap, servo).map(|(value, _)| value);
                missed += u32::from(now != told);
            }
            for servo in SERVOS {
                if let Some((value, _)) = position(&tap, servo) {
                    assert!(is_position(servo, value), "{kind}: {servo} at {value:#x} after {frames:02X?}");
                    learned += 1;
                }
            }
        }
        println!("{kind}: {damaged} of 20000 dialogues damaged; {whole} positions came whole, {missed} of them missed");
        assert!(learned > 0 && whole > 2_000 && damaged > 2_000, "{kind}: {whole} whole, {damaged} damaged");
        assert_eq!(missed, 0, "{kind}: of {whole}");
    }
}

/// What the tap hears instead of a frame.
fn damage(traffic: &mut Traffic, frame: &Frame, percent: usize, kind: &str) -> Vec<Frame> {
    let mut frame = frame.clone();
    if traffic.below(100) >= percent {
        return vec![frame];
    }
    match kind {
        "drop" => vec![],
        "double" => {
            let again = Frame { start_us: frame.end_us(), ..frame.clone() };
            vec![frame, again]
        }
        "bits" => {
            // One bit in a thousand.
            for byte in &mut frame.bytes {
                for bit in 0..8 {
                    *byte ^= u8::from(traffic.below(1000) == 0) << bit;
                }
            }
            vec![frame]
        }
        "cut" => {
            frame.bytes.truncate(1 + traffic.below(frame.bytes.len() - 1));
            vec![frame]
        }
        _ => {
            let noise: Vec<u8> = (0..1 + traffic.below(30)).map(|_| traffic.below(256) as u8).collect();
            let start_us = frame.start_us.saturating_sub(noise.len() as u64 * BYTE_US);
            vec![Frame { start_us, bytes: noise }, frame]
        }
    }
}

#[test]
fn answers_belong_to_their_questions() {
    let mut traffic = Traffic::new(2);
    let mut tap = listener();
    let [question, answer] = traffic.ask(1, Instruction::Read, &[132, 0, 4, 0]).try_into().unwrap();
    // Without its question an answer is nobody's.
    assert_eq!(hear(&mut tap, &answer), ["stray 1"]);
    assert_eq!(hear(&mut tap, &question), [""; 0]);
    assert_eq!(hear(&mut tap, &answer).len(), 1);
    let known = position(&tap, 1);
    assert!(known.is_some());
    // Once answered, a question is over.
    let [_, further] = traffic.ask(1, Instruction::Read, &[132, 0, 4, 0]).try_into().unwrap();
    assert_eq!(hear(&mut tap, &further), ["stray 1"]);
    // Another servo's answer, one of another length and one that is late are not the answer to it.
    let [question, _] = traffic.ask(1, Instruction::Read, &[132, 0, 4, 0]).try_into().unwrap();
    let [_, other] = traffic.ask(2, Instruction::Read, &[132, 0, 4, 0]).try_into().unwrap();
    let [_, long] = traffic.ask(1, Instruction::Read, &[132, 0, 8, 0]).try_into().unwrap();
    let at = |frame: &Frame, start_us| Frame { start_us, ..frame.clone() };
    for wrong in [at(&other, question.end_us()), at(&long, question.end_us()), at(&further, question.end_us() + 200)] {
        assert_eq!(hear(&mut tap, &question), [""; 0]);
        assert_eq!(hear(&mut tap, &wrong).last().unwrap().split(' ').next(), Some("stray"));
        // From then on nothing is certain before the next question.
        assert!(hear(&mut tap, &at(&further, question.end_us()))[0].starts_with("stray"));
        assert_eq!((position(&tap, 1), position(&tap, 2)), (known, None));
    }
    // Two bytes of noise as the line turns around are none of anybody's question, more may have been one.
    for (noise, learned) in [(2, true), (9, false)] {
        assert_eq!(hear(&mut tap, &question), [""; 0]);
        hear(&mut tap, &Frame { start_us: question.end_us(), bytes: vec![0; noise] });
        let told = hear(&mut tap, &at(&further, question.end_us() + 20));
        assert_eq!(told[0].starts_with("1 at 132"), learned, "{told:?}");
    }
}

#[test]
fn the_order_of_several_is_kept() {
    let mut traffic = Traffic::new(3);
    let mut tap = listener();
    let [question, two, seven, one] =
        traffic.ask(254, Instruction::SyncRead, &[132, 0, 4, 0, 2, 7, 1]).try_into().unwrap();
    // One answer is not heard: the others are in their places all the same.
    for frame in [&question, &two, &one] {
        hear(&mut tap, frame);
    }
    assert!(position(&tap, 2).is_some() && position(&tap, 7).is_none() && position(&tap, 1).is_some());
    // An answer out of its order is not one to this question.
    let mut tap = listener();
    hear(&mut tap, &question);
    hear(&mut tap, &Frame { start_us: question.end_us(), ..seven.clone() });
    assert_eq!(hear(&mut tap, &Frame { start_us: seven.start_us, ..two.clone() }), ["stray 2"]);
    // A fast answer that breaks off has told what is whole.
    let [question, front, block, _] =
        traffic.ask(254, Instruction::FastSyncRead, &[132, 0, 4, 0, 2, 7, 1]).try_into().unwrap();
    let mut tap = listener();
    hear(&mut tap, &question);
    assert_eq!(hear(&mut tap, &front).len(), 1);
    let mut broken = block.clone();
    broken.bytes[3] ^= 4;
    assert_eq!(hear(&mut tap, &broken), [""; 0]);
    assert!(position(&tap, 2).is_some() && position(&tap, 7).is_none());
    let next = traffic.ask(7, Instruction::Read, &[132, 0, 4, 0]);
    next.iter().for_each(|frame| drop(hear(&mut tap, frame)));
    assert_eq!(position(&tap, 7).map(|(value, _)| value), traffic.servo(7).told.last().copied());
}

#[test]
fn writes_pings_and_refusals_are_told() {
    let mut traffic = Traffic::new(4);
    let mut tap = listener();
    let mut told = |id, instruction, parameters: &[u8]| -> Vec<String> {
        traffic.ask(id, instruction, parameters).iter().flat_map(|frame| hear(&mut tap, frame)).collect()
    };
    assert_eq!(told(7, Instruction::Write, &[64, 0, 1]), ["7 takes at 64: [1]"]);
    assert_eq!(told(254, Instruction::Write, &[65, 0, 1]), ["broadcast takes at 65: [1]"]);
    assert_eq!(told(2, Instruction::Ping, &[]), ["2 is 1020/45"]);
    assert_eq!(told(1, Instruction::Read, &[0xE8, 3, 1, 0]), ["1 refuses: 7"]);
    assert_eq!(told(1, Instruction::RegWrite, &[64, 0, 1]), [""; 0]);
    assert_eq!(told(254, Instruction::SyncWrite, &[64, 0, 1, 0, 1, 1, 2, 1]), [""; 0]);
    assert_eq!(StatusError::Access.code(), 7);
    let torque = |tap: &Listener, servo| tap.servo(id(servo)).unwrap().torque.map(|seen| seen.value);
    assert_eq!([1, 2, 7].map(|servo| torque(&tap, servo)), [Some(1), Some(1), Some(1)]);
    assert_eq!(tap.servo(id(2)).unwrap().answers, 1);
}

#[test]
fn there_is_room_for_so_many() {
    let mut tap = Tap::<64, 2>::new(TIMING);
    assert!(tap.watch(id(1)) && tap.watch(id(2)) && tap.watch(id(1)));
    assert!(!tap.watch(id(3)) && !tap.watch(Id::BROADCAST));
    assert_eq!(tap.servos().map(|servo| servo.id.get()).collect::<Vec<_>>(), [1, 2]);
    tap.forget();
    assert!(tap.watch(id(3)) && tap.servo(id(1)).is_none());
}

/// Indirect data are what they show, once that is known; a servo that may have restarted shows nothing.
#[test]
fn indirect_data_are_followed() {
    let mut traffic = Traffic::new(5);
    let mut tap = listener();
    let mut run = |tap: &mut Listener, id, instruction, parameters: &[u8]| {
        let frames = traffic.ask(id, instruction, parameters);
        frames.iter().for_each(|frame| drop(hear(tap, frame)));
        (traffic.servo(1).told.last().copied(), frames)
    };
    let shown: Vec<u8> = (132u16..136).flat_map(u16::to_le_bytes).collect();
    let write = [&168u16.to_le_bytes(), shown.as_slice()].concat();
    let data = [224, 0, 4, 0];
    run(&mut tap, 1, Instruction::Read, &data);
    assert_eq!(position(&tap, 1), None, "nobody knows what they show");
    let (_, frames) = run(&mut tap, 1, Instruction::Write, &write);
    let [question, answer] = frames.try_into().unwrap();
    let (told, _) = run(&mut tap, 1, Instruction::Read, &data);
    assert_eq!(position(&tap, 1).map(|(value, _)| value), told);
    // A write whose answer was not heard may have been refused.
    let mut deaf = listener();
    hear(&mut deaf, &question);
    run(&mut deaf, 1, Instruction::Read, &data);
    assert_eq!(position(&deaf, 1), None);
    // Reading the addresses is as good as having seen them written.
    run(&mut deaf, 1, Instruction::Read, &[168, 0, 8, 0]);
    let (told, _) = run(&mut deaf, 1, Instruction::Read, &data);
    assert_eq!(position(&deaf, 1).map(|(value, _)| value), told);
    assert_eq!(answer.bytes[8], 0);
    // A restart returns them to the factory's.
    run(&mut tap, 1, Instruction::Reboot, &[]);
    let known = position(&tap, 1);
    run(&mut tap, 1, Instruction::Read, &data);
    assert_eq!(position(&tap, 1), known);
}
