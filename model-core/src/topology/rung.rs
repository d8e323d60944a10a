//! A rung as a chain of parts, front to back.

/// A part of a rung. `R` describes a flexible one.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part<R> {
    /// A rigid link, undeformed, mm: it turns with the joint it lies at.
    Link([f64; 2]),
    /// A pin: beyond it another angle.
    Pin,
    /// A rod that bends, from one joint to the next.
    Rod(R),
    /// The gap between the end of what lies before and the back beam's face, undeformed: its width, mm, and the unit vector across it. It
    /// turns with what lies behind: beyond it another angle.
    Gap(f64, [f64; 2]),
}

/// A member of a rung: its joints counted from the front end, its rigid parts, and the rod between, if there is one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rung<R> {
    pub joints: [usize; 2],
    pub rigid_start: [f64; 2],
    pub rigid_end: [f64; 2],
    pub rod: Option<R>,
    /// Width of the gap that it begins with, and the unit vector across it.
    pub gap: Option<(f64, [f64; 2])>,
}

impl<R: Copy> Rung<R> {
    /// Joints that a chain has: one at its front end, and one behind every rod, pin and gap. A weld has one alone.
    pub fn joints(parts: &[Part<R>]) -> usize {
        1 + parts.iter().filter(|part| !matches!(part, Part::Link(_))).count()
    }

    /// Hands on a chain's members, front to back: a rod with the links before it, and behind it if nothing follows; links between pins, or
    /// welded to both beams, as a member from their joint to itself.
    pub fn members(parts: &[Part<R>], mut member: impl FnMut(Self)) {
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let is_link = |part: &Part<R>| matches!(part, Part::Link(_));
        let point =
            |joint, rigid_start, gap| Self { joints: [joint; 2], rigid_start, rigid_end: [0.0; 2], rod: None, gap };
        let last_rod = parts.iter().rposition(|part| !is_link(part));
        let mut before = [0.0; 2];
        let mut joint = 0;
        let mut rest = parts.iter().enumerate();
        while let Some((at, part)) = rest.next() {
            match *part {
                Part::Link(link) => before = sum(before, link),
                Part::Pin => {
                    if before != [0.0; 2] {
                        member(point(joint, before, None));
                    }
                    (before, joint) = ([0.0; 2], joint + 1);
                }
                Part::Gap(width, across) => {
                    let links = rest
                        .by_ref()
                        .filter_map(|(_, part)| if let Part::Link(link) = part { Some(*link) } else { None });
                    member(point(joint + 1, links.fold([0.0; 2], sum), Some((width, across))));
                    before = [0.0; 2];
                }
                Part::Rod(rod) => {
                    let mut behind = [0.0; 2];
                    if last_rod == Some(at) {
                        for (_, part) in rest.by_ref() {
                            if let Part::Link(link) = part {
                                behind = sum(behind, *link);
                            }
                        }
                    }
                    let joints = [joint, joint + 1];
                    member(Self { joints, rigid_start: before, rigid_end: behind, rod: Some(rod), gap: None });
                    (before, joint) = ([0.0; 2], joint + 1);
                }
            }
        }
        if before != [0.0; 2] {
            member(point(joint, before, None));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn members(parts: &[Part<char>]) -> Vec<([usize; 2], f64, Option<char>, f64)> {
        let mut found = Vec::new();
        Rung::members(parts, |m| found.push((m.joints, m.rigid_start[0], m.rod, m.rigid_end[0])));
        found
    }

    #[test]
    fn hinges_and_bar_are_two_members_that_share_the_bars_joint() {
        let parts = [
            Part::Link([-1.0, 0.0]),
            Part::Rod('f'),
            Part::Link([-20.0, 0.0]),
            Part::Rod('b'),
            Part::Link([-2.0, 0.0]),
        ];
        assert_eq!(Rung::joints(&parts), 3);
        assert_eq!(members(&parts), [([0, 1], -1.0, Some('f'), 0.0), ([1, 2], -20.0, Some('b'), -2.0)]);
    }

    #[test]
    fn a_rib_is_one_member_between_the_beams() {
        let parts = [Part::Link([-1.0, 0.0]), Part::Rod('r'), Part::Link([-2.0, 0.0])];
        assert_eq!((Rung::joints(&parts), members(&parts)), (2, [([0, 1], -1.0, Some('r'), -2.0)].to_vec()));
        // Pinned at one end.
        let parts = [Part::Pin, Part::Link([-1.0, 0.0]), Part::Rod('r')];
        assert_eq!((Rung::joints(&parts), members(&parts)), (3, [([1, 2], -1.0, Some('r'), 0.0)].to_vec()));
    }

    #[test]
    fn a_rib_before_a_gap_has_a_joint_at_its_end_and_the_gap_turns_with_the_back_beam() {
        let parts = [Part::Link([-1.0, 0.0]), Part::Rod('r'), Part::Gap(0.4, [-1.0, 0.0]), Part::Link([-2.0, 0.0])];
        assert_eq!(Rung::joints(&parts), 3);
        assert_eq!(members(&parts), [([0, 1], -1.0, Some('r'), 0.0), ([2, 2], -2.0, None, 0.0)]);
        Rung::members(&parts, |member| assert_eq!(member.gap.is_some(), member.rod.is_none()));
    }

    #[test]
    fn a_bar_between_pins_has_an_angle_of_its_own_and_a_welded_one_that_of_both_beams() {
        let bar = Part::Link([-28.0, 0.0]);
        let pinned = [Part::Pin, bar, Part::Pin];
        assert_eq!((Rung::joints(&pinned), members(&pinned)), (3, [([1, 1], -28.0, None, 0.0)].to_vec()));
        assert_eq!((Rung::joints(&[bar]), members(&[bar])), (1, [([0, 0], -28.0, None, 0.0)].to_vec()));
    }
}
