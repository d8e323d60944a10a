//! The deformed finger, thinned for the link.

use heapless::Vec;
use model_core::equilibrium::Follower;
use model_core::real::Real;
use model_core::size::Size;

use crate::{Contact, Report, Shape};

impl Shape {
    /// What the model shows that has made this report. The contacts' forces are those of the elastic finger, scaled to what is reported of a
    /// material with memory.
    pub fn of<T: Real, S: Size>(follower: &Follower<T, S>, report: &Report) -> Self {
        let solution = follower.solution();
        let single = |point: [T; 2]| point.map(|x| x.to_f64() as f32);
        let part = faded(single(solution.force_world()), report);
        let contact = |contact: model_core::contact::Contact<T>| Contact {
            position: single(contact.position),
            force: single(contact.on_object()).map(|force| part * force),
        };
        let (shift, turn) = solution.base();
        Self {
            sequence: report.sequence,
            finger: report.finger,
            status: report.estimate.status,
            motor_angle: turn.to_f64() as f32,
            shift: single(shift),
            front: thinned(solution.front().count(), solution.front().map(single)),
            back: thinned(solution.back().count(), solution.back().map(single)),
            lamella_front: first(solution.lamellae().map(|[front, _]| single(front))),
            lamella_back: first(solution.lamellae().map(|[_, back]| single(back))),
            contacts: first(solution.contacts().map(contact)),
        }
    }
}

/// What a trustworthy report has left of an elastic finger's force, where that is less.
fn faded([x, y]: [f32; 2], report: &Report) -> f32 {
    let estimate = &report.estimate;
    let part = estimate.force_magnitude() / libm::sqrtf(x * x + y * y);
    let is_new = estimate.status.is_trustworthy() && estimate.age == 0;
    if is_new && part < 1.0 { part } else { 1.0 }
}

/// As many as fit.
fn first<X, const N: usize>(items: impl Iterator<Item = X>) -> Vec<X, N> {
    let mut kept = Vec::new();
    for item in items.take(N) {
        // There is room for N.
        let _ = kept.push(item);
    }
    kept
}

/// First, last, and so many evenly between that all fit.
fn thinned<X, const N: usize>(count: usize, items: impl Iterator<Item = X>) -> Vec<X, N> {
    let (gaps, room) = (count.saturating_sub(1), N.saturating_sub(1));
    let mut kept = 0;
    let keep = |&(index, _): &(usize, X)| {
        let due = count <= N || index * room >= kept * gaps;
        kept += usize::from(due);
        due
    };
    first(items.enumerate().filter(keep).map(|(_, item)| item))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_ends_and_fills_the_room() {
        for count in 0..500 {
            let kept: Vec<usize, 64> = thinned(count, 0..count);
            assert_eq!(kept.len(), count.min(64));
            assert_eq!(kept.first().copied(), (count > 0).then_some(0));
            assert_eq!(kept.last().copied(), count.checked_sub(1));
            let widest = kept.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
            assert!(widest <= count.div_ceil(63), "{count}: {widest}");
        }
    }
}
