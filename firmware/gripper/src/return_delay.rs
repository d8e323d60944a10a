//! Which return delays a device keeps: 0, which promises nothing, and those that last as long as an answer takes.

use dynamixel::xm430;
use messages::{Outcome, Role, Settings, SettingsField};

/// The longest one that the register holds, 2 µs.
const LONGEST: u32 = xm430::RETURN_DELAY_TIME.item.max as u32;

/// The shortest one above 0 at a rate of the bus, 2 µs; more than [`LONGEST`]: there is none. An answer is ready `answer_us` after the
/// question is known to have ended ([`crate::Board::ANSWER_US`]), and that takes a byte's time.
fn shortest(baud_rate: u32, answer_us: u32) -> u32 {
    let byte_us = 10_000_000_u32.div_ceil(baud_rate.max(1));
    answer_us.saturating_add(byte_us).div_ceil(xm430::RETURN_DELAY_US_PER_UNIT)
}

/// Whether one is kept, in 2 µs.
#[inline(never)]
pub(crate) fn is_kept(return_delay: u8, baud_rate: u32, answer_us: u32) -> bool {
    return_delay == 0 || u32::from(return_delay) >= shortest(baud_rate, answer_us)
}

/// Refuses settings with one that is not kept.
pub(crate) fn check(settings: &Settings, answer_us: u32) -> Outcome {
    match settings.role {
        Role::Device { return_delay: delay @ 1.., .. } => {
            let shortest = shortest(settings.baud_heard(), answer_us);
            SettingsField::ReturnDelay.check(f32::from(delay), shortest as f32, LONGEST as f32)
        }
        _ => Ok(()),
    }
}

/// Lets go of one that is not kept: the answer then comes as soon as it can.
pub(crate) fn drop_unkept(settings: &mut Settings, answer_us: u32) {
    let baud_rate = settings.baud_heard();
    if let Role::Device { return_delay, .. } = &mut settings.role
        && !is_kept(*return_delay, baud_rate, answer_us)
    {
        *return_delay = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_kept_if_the_answer_is_ready_and_the_question_known_to_have_ended() {
        // 290 µs, and 10 µs of a byte.
        assert_eq!([0, 1, 149, 150, 254].map(|delay| is_kept(delay, 1_000_000, 290)), [true, false, false, true, true]);
        // 174 µs of a byte: the register's 508 µs are too short for 335 more.
        let [long, longer] = [334, 335].map(|answer_us| [0, 1, 254].map(|delay| is_kept(delay, 57_600, answer_us)));
        assert_eq!((long, longer), ([true, false, true], [true, false, false]));
        assert!(!is_kept(254, 0, u32::MAX));
    }

    #[test]
    fn the_page_has_every_boards_shortest_one() {
        let page = include_str!("../../../docs/real-time.md");
        for board in fre_boards::ALL.iter().filter(|board| board.probe.is_some()) {
            let cells = [57_600, 115_200, 1_000_000].map(|baud_rate| match shortest(baud_rate, board.answer_us) {
                units @ ..=LONGEST => format!("{} µs", units * xm430::RETURN_DELAY_US_PER_UNIT),
                _ => "0 only".into(),
            });
            let row = format!("| {} | {} |", board.name, cells.join(" | "));
            assert!(page.contains(&row), "docs/real-time.md lacks the row\n{row}");
        }
    }

    #[test]
    fn what_is_not_kept_is_refused_or_dropped() {
        for (delay, baud, answer_us, after) in [
            (0, None, 290, 0),
            (149, None, 290, 0),
            (150, None, 290, 150),
            (253, Some(57_600), 334, 0),
            (254, Some(57_600), 334, 254),
            (254, Some(57_600), 335, 0),
        ] {
            let role = Role::Device { id: 100, return_delay: delay };
            let mut settings = Settings { role, baud, ..Settings::DEFAULT };
            let refused = check(&settings, answer_us);
            drop_unkept(&mut settings, answer_us);
            assert_eq!(settings.role, Role::Device { id: 100, return_delay: after });
            assert_eq!(refused.is_ok(), delay == after, "{delay}: {refused:?}");
            assert_eq!(check(&settings, answer_us), Ok(()));
        }
        let tap = Settings { role: Role::Tap, ..Settings::DEFAULT };
        assert_eq!(check(&tap, u32::MAX), Ok(()));
    }
}
