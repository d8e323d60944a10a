//! What a grip bears in every direction, found over several ticks: one short step at a time, on the contact forces of one tick.
//!
//! A round freezes the places of contact and goes through the loads one after another: the one that is asked for, then forces in the plane
//! every 15°, one across it, and a couple both ways. Each step is one pass over the places, so that a round can end a tick wherever the
//! tick's time does. The cones are in single precision, which the target computes in hardware; the few numbers of the portal in double.

use core::f64::consts::TAU;

use heapless::Vec;

use super::margin::{Cone, Margin, Pull, Search, Touch, force_of};

/// Directions in the plane in which the weakest one is looked for: every 15°.
const DIRECTIONS: usize = 24;
/// Loads of a round: the one that is asked for, those in the plane, across it, and a couple both ways.
const LOADS: usize = 1 + DIRECTIONS + 3;

/// What a grip bears before the object slips: the largest loads at the object's reference point (centre; of a polygon, the mean of its
/// corners) for which there are forces within the friction cones, none pressing harder than now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bears {
    /// Force in the weakest direction in the plane, N.
    pub least: f32,
    /// That direction, rad from x, counter-clockwise.
    pub direction: f32,
    /// Force across the plane, N.
    pub across: f32,
    /// Couple about the reference point, N·mm: the weaker one of both ways.
    pub couple: f32,
    /// The finger that slips first, from 0, in the weakest direction in the plane or across it. `None` where none slides, or where nothing
    /// is borne.
    pub slips: Option<u8>,
}

/// Nothing looked at yet.
const BLANK: Bears = Bears { least: f32::INFINITY, direction: 0.0, across: 0.0, couple: f32::INFINITY, slips: None };

/// A survey of one grip after another, with room for so many places of contact.
#[derive(Clone, Debug)]
pub struct Survey<const PLACES: usize> {
    cones: Vec<Cone<f32>, PLACES>,
    arm: f64,
    asked: Option<Pull>,
    /// All normal forces.
    all: f64,
    /// Which load is looked at; [`LOADS`]: the round is over.
    next: usize,
    search: Option<Search>,
    found: Bears,
    /// What was found of the load that is asked for.
    load: Option<f32>,
}

impl<const PLACES: usize> Default for Survey<PLACES> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const PLACES: usize> Survey<PLACES> {
    /// Nothing to look at.
    pub const fn new() -> Self {
        Self { cones: Vec::new(), arm: 0.0, asked: None, all: 0.0, next: LOADS, search: None, found: BLANK, load: None }
    }

    /// Begins a round without places; a load that is asked for comes first. `arm`: how far the object reaches from its reference point, mm.
    pub fn begin(&mut self, arm: f64, asked: Option<Pull>) {
        self.cones.clear();
        (self.arm, self.asked, self.load, self.all) = (arm, asked, None, 0.0);
        (self.next, self.found, self.search) = (0, BLANK, None);
    }

    /// Takes places of contact around the object's reference point, before the first step of a round. Returns false if there are too many:
    /// then the round is over, and nothing was found.
    pub fn take_places(&mut self, mut places: impl Iterator<Item = Touch<f32>>) -> bool {
        let arm = self.arm as f32;
        let has_room = places.all(|place| self.cones.push(Cone::of(&place, [0.0; 2], arm)).is_ok());
        self.all = force_of(self.cones.iter().copied());
        if !has_room {
            self.next = LOADS;
        }
        has_room
    }

    /// Nothing is under way.
    pub fn is_idle(&self) -> bool {
        self.next >= LOADS
    }

    /// How much of the load that is asked for is borne, in units of its [`Pull`], once that is known in this round.
    pub fn load(&self) -> Option<f32> {
        self.load
    }

    /// One pass over the places. What the grip bears, at the end of a round.
    pub fn step(&mut self) -> Option<Bears> {
        if self.is_idle() {
            return None;
        }
        let cones = self.cones.iter().copied();
        match &mut self.search {
            None => match self.pull().and_then(|pull| Search::new(self.all, self.arm, &pull)) {
                Some(search) => self.search = Some(search),
                // Nothing is asked for, or nothing presses.
                None => self.take(Margin::NONE),
            },
            Some(search) => {
                if !search.step(cones.clone()) {
                    let margin = search.found(cones);
                    self.search = None;
                    self.take(margin);
                }
            }
        }
        self.is_idle().then_some(self.found)
    }

    /// The load that is looked at.
    fn pull(&self) -> Option<Pull> {
        match self.next {
            0 => self.asked,
            at if at <= DIRECTIONS => {
                let (sin, cos) = libm::sincos(direction(at));
                Some(Pull { force: [cos, sin], ..Pull::default() })
            }
            at if at == DIRECTIONS + 1 => Some(Pull { across: 1.0, ..Pull::default() }),
            at => Some(Pull { couple: if at == LOADS - 1 { 1.0 } else { -1.0 }, ..Pull::default() }),
        }
    }

    fn take(&mut self, margin: Margin) {
        let bears = margin.bears as f32;
        let slips = margin.slips.map(|finger| finger as u8);
        let found = &mut self.found;
        match self.next {
            0 => self.load = self.asked.map(|_| bears),
            at if at <= DIRECTIONS => {
                if bears < found.least {
                    (found.least, found.direction, found.slips) = (bears, direction(at) as f32, slips);
                }
            }
            at if at == DIRECTIONS + 1 => {
                found.across = bears;
                if bears < found.least {
                    found.slips = slips;
                }
            }
            _ => found.couple = found.couple.min(bears),
        }
        self.next += 1;
    }
}

/// The direction of a round's load, rad.
fn direction(at: usize) -> f64 {
    TAU * (at - 1) as f64 / DIRECTIONS as f64
}

#[cfg(test)]
mod tests {
    use super::super::margin;
    use super::super::margin::tests::{ARM, at};
    use super::*;

    fn single(place: Touch) -> Touch<f32> {
        let pair = |of: [f64; 2]| of.map(|part| part as f32);
        let Touch { finger, point, normal, force, friction } = place;
        Touch { finger, point: pair(point), normal: pair(normal), force: force as f32, friction: friction as f32 }
    }

    /// A whole round, and its steps.
    fn round(survey: &mut Survey<24>, places: &[Touch], asked: Option<Pull>) -> (Bears, usize) {
        survey.begin(ARM, asked);
        assert!(survey.take_places(places.iter().copied().map(single)));
        let mut steps = 0;
        loop {
            steps += 1;
            assert!(steps <= 66 * LOADS, "a bounded round");
            if let Some(found) = survey.step() {
                return (found, steps);
            }
        }
    }

    /// In single precision as in double precision, whatever a round looks at.
    #[test]
    fn a_round_finds_the_margins_of_double_precision() {
        let mut state = 5_u64;
        let mut number = |low: f64, high: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut survey = Survey::new();
        let (mut most, mut passes) = (0, 0);
        for grip in 0..60 {
            let count = 2 + grip % 23;
            let places: std::vec::Vec<Touch> = (0..count)
                .map(|i| {
                    let degrees = 360.0 * i as f64 / count as f64 + number(-40.0, 40.0);
                    at(i % 4, degrees, number(0.1, 8.0), number(0.0, 1.0))
                })
                .collect();
            let exact = |pull: &Pull| margin(places.iter().copied(), [0.0; 2], ARM, pull).bears;
            let asked = Pull { force: [number(-1.0, 1.0), number(-1.0, 1.0)], across: number(0.0, 1.0), couple: 0.0 };
            let (found, steps) = round(&mut survey, &places, Some(asked));
            (most, passes) = (most.max(steps), passes + steps);
            let all: f64 = places.iter().map(|place| place.force).sum();
            let near = |found: f32, exact: f64, scale: f64, what: &str| {
                let off = (f64::from(found) - exact).abs();
                assert!(off <= 1e-3 * exact + 1e-5 * scale, "{grip}, {what}: {found} instead of {exact}");
            };
            let plane = (1..=DIRECTIONS).map(|at| {
                let (sin, cos) = libm::sincos(direction(at));
                exact(&Pull { force: [cos, sin], ..Pull::default() })
            });
            near(found.least, plane.fold(f64::INFINITY, f64::min), all, "least");
            near(found.across, exact(&Pull { across: 1.0, ..Pull::default() }), all, "across");
            let turned = [1.0, -1.0].map(|couple| exact(&Pull { couple, ..Pull::default() }));
            near(found.couple, turned[0].min(turned[1]), ARM * all, "couple");
            near(survey.load().expect("asked for"), exact(&asked), all, "the load asked for");
        }
        std::println!("passes of a round: {} in the mean, {most} at most", passes / 60);
    }

    #[test]
    fn the_load_that_is_asked_for_is_known_first_and_the_weakest_finger_named() {
        let pair = [at(0, 180.0, 5.0, 0.6), at(1, 0.0, 5.0, 0.3)];
        let mut survey = Survey::<24>::new();
        let across = Pull { across: 1.0, ..Pull::default() };
        survey.begin(ARM, Some(across));
        assert!(pair.iter().all(|place| survey.take_places(core::iter::once(single(*place)))));
        while survey.load().is_none() {
            assert_eq!(survey.step(), None);
        }
        assert!((survey.load().unwrap() - 4.5).abs() < 1e-3 && !survey.is_idle());
        let (found, _) = round(&mut survey, &pair, None);
        assert_eq!((found.slips, survey.load()), (Some(1), None));
        assert!((found.across - 4.5).abs() < 1e-3 && found.least <= 4.5, "{found:?}");
        // Nothing presses, nothing is borne; and more places than there is room for are refused.
        let nothing = round(&mut survey, &[], Some(across)).0;
        assert_eq!((nothing.least, nothing.across, nothing.couple, nothing.slips), (0.0, 0.0, 0.0, None));
        let mut small = Survey::<1>::new();
        small.begin(ARM, None);
        assert!(!small.take_places(pair.iter().copied().map(single)) && small.is_idle() && small.step().is_none());
    }
}
