//! What is reported, as JSON: one flat object per message, units in the names.

use messages::{Contact, Event, FreeObject, Grasp, GripMargin, Notice, Phase, Report, Shape, Why};
use model_core::estimator::{Estimate, Interval};
use model_core::solution::LoadedRib;
use model_core::status::Status;
use serde::{Deserialize, Serialize};

use super::number::{Degrees, Exact, PerDegree};
use crate::source::Gap;

/// A report, with the columns of the CSV.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct EstimateMessage {
    sequence: u32,
    finger: u8,
    time_us: u64,
    status: Status,
    age: u32,
    /// For people and plots; from the components.
    #[serde(default)]
    force_magnitude_n: Exact,
    force_x_n: Exact,
    force_y_n: Exact,
    motor_angle_deg: Degrees,
    goal_deg: Degrees,
    position_counts: i32,
    current_ma: Exact,
    contact_x_mm: Exact,
    contact_y_mm: Exact,
    contact_extent_mm: Exact,
    torque_nmm: Exact,
    distance_mm: Exact,
    iterations: u16,
    residual_nmm: Exact,
    cost: u32,
    force_x_per_deg_n: PerDegree,
    force_y_per_deg_n: PerDegree,
    standard_deviation_n: Exact,
    sensitivity_age: u16,
    #[serde(with = "phase_words")]
    phase: Phase,
    // With friction, where both ends are known. (Recordings of versions before it have none of these.)
    #[serde(default = "unknown", skip_serializing_if = "Exact::is_nan")]
    force_interval_low_n: Exact,
    #[serde(default = "unknown", skip_serializing_if = "Exact::is_nan")]
    force_interval_high_n: Exact,
    #[serde(default = "unknown", skip_serializing_if = "Exact::is_nan")]
    normal_interval_low_n: Exact,
    #[serde(default = "unknown", skip_serializing_if = "Exact::is_nan")]
    normal_interval_high_n: Exact,
    #[serde(default = "unknown", skip_serializing_if = "Exact::is_nan")]
    torque_interval_low_nmm: Exact,
    #[serde(default = "unknown", skip_serializing_if = "Exact::is_nan")]
    torque_interval_high_nmm: Exact,
    // While a rib is near its buckling load: the rib, from 1 at the base, and its load.
    #[serde(default, skip_serializing_if = "is_zero")]
    loaded_rib: u8,
    #[serde(default, skip_serializing_if = "is_zero")]
    rib_load_percent: u8,
}

// By reference, as serde asks for it.
fn is_zero(number: &u8) -> bool {
    *number == 0
}

/// A number that is left out.
fn unknown() -> Exact {
    Exact(f32::NAN)
}

impl From<&Report> for EstimateMessage {
    fn from(report: &Report) -> Self {
        let Report { sequence, finger, phase, time_us, estimate, goal, position, current, cost } = *report;
        let end =
            |of: fn(&Interval) -> f32| estimate.interval.as_ref().map_or_else(unknown, |interval| Exact(of(interval)));
        Self {
            sequence,
            finger,
            time_us,
            status: estimate.status,
            age: estimate.age,
            force_magnitude_n: Exact(estimate.force_magnitude()),
            force_x_n: Exact(estimate.force[0]),
            force_y_n: Exact(estimate.force[1]),
            motor_angle_deg: Degrees(estimate.motor_angle),
            goal_deg: Degrees(goal),
            position_counts: position,
            current_ma: Exact(current),
            contact_x_mm: Exact(estimate.contact_centre[0]),
            contact_y_mm: Exact(estimate.contact_centre[1]),
            contact_extent_mm: Exact(estimate.contact_extent),
            torque_nmm: Exact(estimate.torque),
            distance_mm: Exact(estimate.distance),
            iterations: estimate.iterations,
            residual_nmm: Exact(estimate.residual),
            cost,
            force_x_per_deg_n: PerDegree(estimate.force_per_angle[0]),
            force_y_per_deg_n: PerDegree(estimate.force_per_angle[1]),
            standard_deviation_n: Exact(estimate.standard_deviation),
            sensitivity_age: estimate.sensitivity_age,
            phase,
            force_interval_low_n: end(|interval| interval.magnitude[0]),
            force_interval_high_n: end(|interval| interval.magnitude[1]),
            normal_interval_low_n: end(|interval| interval.normal[0]),
            normal_interval_high_n: end(|interval| interval.normal[1]),
            torque_interval_low_nmm: end(|interval| interval.torque[0]),
            torque_interval_high_nmm: end(|interval| interval.torque[1]),
            loaded_rib: estimate.loaded_rib.map_or(0, |loaded| loaded.rib.saturating_add(1)),
            rib_load_percent: estimate.loaded_rib.map_or(0, |loaded| loaded.percent),
        }
    }
}

impl From<EstimateMessage> for Report {
    fn from(message: EstimateMessage) -> Self {
        let interval = Interval {
            magnitude: [message.force_interval_low_n.0, message.force_interval_high_n.0],
            normal: [message.normal_interval_low_n.0, message.normal_interval_high_n.0],
            torque: [message.torque_interval_low_nmm.0, message.torque_interval_high_nmm.0],
        };
        let estimate = Estimate {
            status: message.status,
            motor_angle: message.motor_angle_deg.0,
            force: [message.force_x_n.0, message.force_y_n.0],
            contact_centre: [message.contact_x_mm.0, message.contact_y_mm.0],
            contact_extent: message.contact_extent_mm.0,
            torque: message.torque_nmm.0,
            distance: message.distance_mm.0,
            iterations: message.iterations,
            residual: message.residual_nmm.0,
            age: message.age,
            force_per_angle: [message.force_x_per_deg_n.0, message.force_y_per_deg_n.0],
            standard_deviation: message.standard_deviation_n.0,
            sensitivity_age: message.sensitivity_age,
            interval: (!interval.magnitude[0].is_nan()).then_some(interval),
            loaded_rib: message
                .loaded_rib
                .checked_sub(1)
                .map(|rib| LoadedRib { rib, percent: message.rib_load_percent }),
        };
        Self {
            sequence: message.sequence,
            finger: message.finger,
            phase: message.phase,
            time_us: message.time_us,
            estimate,
            goal: message.goal_deg.0,
            position: message.position_counts,
            current: message.current_ma.0,
            cost: message.cost,
        }
    }
}

/// A phase as its word, and why: `held: the servo reports a hardware error`.
mod phase_words {
    use super::{Phase, Why};
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serializer};

    const WHYS: [Why; 12] = [
        Why::Asked,
        Why::Bus,
        Why::ServoLost,
        Why::Alert,
        Why::Estimate,
        Why::Stall,
        Why::Current,
        Why::Force,
        Why::Angle,
        Why::Host,
        Why::Heat,
        Why::Supply,
    ];

    /// Every phase there is.
    fn all() -> impl Iterator<Item = Phase> {
        let because = WHYS.into_iter().flat_map(|why| [Phase::Waiting(why), Phase::Held(why), Phase::Released(why)]);
        [Phase::Moving, Phase::Gripping, Phase::Gripped, Phase::Relaxed].into_iter().chain(because)
    }

    pub(super) fn serialize<S: Serializer>(phase: &Phase, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(phase)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Phase, D::Error> {
        let words = <&str>::deserialize(from)?;
        all()
            .find(|phase| phase.to_string() == words)
            .ok_or_else(|| D::Error::custom(format!("`{words}` is not a phase")))
    }
}

/// What stands for no finger.
const NO_FINGER: i16 = -1;

/// The grasp.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct GraspMessage {
    sequence: u32,
    is_trustworthy: bool,
    sum_x_n: Exact,
    sum_y_n: Exact,
    squeeze_n: Exact,
    balance: Exact,
    /// Of a free object; older recordings have none of these.
    #[serde(default)]
    is_free: bool,
    #[serde(default = "fixed")]
    object_status: Status,
    #[serde(default)]
    object_shift_x_mm: Exact,
    #[serde(default)]
    object_shift_y_mm: Exact,
    #[serde(default)]
    object_turn_deg: Degrees,
    #[serde(default)]
    object_residual_n: Exact,
    #[serde(default)]
    object_iterations: u16,
    #[serde(default)]
    object_cost: u32,
    /// What the grip bears, while it is known; older recordings have none of these.
    #[serde(default)]
    has_margin: bool,
    #[serde(default)]
    margin_n: Exact,
    #[serde(default)]
    margin_direction_deg: Degrees,
    #[serde(default)]
    margin_across_n: Exact,
    #[serde(default)]
    margin_couple_nmm: Exact,
    /// −1: no finger.
    #[serde(default)]
    margin_slips: i16,
    #[serde(default)]
    margin_age: u16,
    #[serde(default)]
    is_carried: bool,
    #[serde(default)]
    margin_carried_n: Exact,
}

/// What stands for the status of an object that is fixed: it is where it was set.
fn fixed() -> Status {
    Status::Converged
}

impl From<&Grasp> for GraspMessage {
    fn from(grasp: &Grasp) -> Self {
        let status = fixed();
        let still = FreeObject { status, shift: [0.0; 2], turn: 0.0, residual: 0.0, iterations: 0, cost: 0 };
        let object = grasp.free.unwrap_or(still);
        let nothing =
            GripMargin { least: 0.0, direction: 0.0, across: 0.0, couple: 0.0, slips: None, carried: None, age: 0 };
        let margin = grasp.margin.unwrap_or(nothing);
        Self {
            sequence: grasp.sequence,
            is_trustworthy: grasp.is_trustworthy,
            sum_x_n: Exact(grasp.sum[0]),
            sum_y_n: Exact(grasp.sum[1]),
            squeeze_n: Exact(grasp.squeeze),
            balance: Exact(grasp.balance),
            is_free: grasp.free.is_some(),
            object_status: object.status,
            object_shift_x_mm: Exact(object.shift[0]),
            object_shift_y_mm: Exact(object.shift[1]),
            object_turn_deg: Degrees(object.turn),
            object_residual_n: Exact(object.residual),
            object_iterations: object.iterations,
            object_cost: object.cost,
            has_margin: grasp.margin.is_some(),
            margin_n: Exact(margin.least),
            margin_direction_deg: Degrees(margin.direction),
            margin_across_n: Exact(margin.across),
            margin_couple_nmm: Exact(margin.couple),
            margin_slips: margin.slips.map_or(NO_FINGER, i16::from),
            margin_age: margin.age,
            is_carried: margin.carried.is_some(),
            margin_carried_n: Exact(margin.carried.unwrap_or(0.0)),
        }
    }
}

impl From<GraspMessage> for Grasp {
    fn from(message: GraspMessage) -> Self {
        Self {
            sequence: message.sequence,
            is_trustworthy: message.is_trustworthy,
            sum: [message.sum_x_n.0, message.sum_y_n.0],
            squeeze: message.squeeze_n.0,
            balance: message.balance.0,
            free: message.is_free.then_some(FreeObject {
                status: message.object_status,
                shift: [message.object_shift_x_mm.0, message.object_shift_y_mm.0],
                turn: message.object_turn_deg.0,
                residual: message.object_residual_n.0,
                iterations: message.object_iterations,
                cost: message.object_cost,
            }),
            margin: message.has_margin.then_some(GripMargin {
                least: message.margin_n.0,
                direction: message.margin_direction_deg.0,
                across: message.margin_across_n.0,
                couple: message.margin_couple_nmm.0,
                slips: u8::try_from(message.margin_slips).ok(),
                carried: message.is_carried.then_some(message.margin_carried_n.0),
                age: message.margin_age,
            }),
        }
    }
}

/// The deformed finger: x and y by themselves, for tools that know no nested lists.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ShapeMessage {
    sequence: u32,
    finger: u8,
    status: Status,
    motor_angle_deg: Degrees,
    /// Missing in recordings of grippers that knew no finger but one that is turned.
    #[serde(default)]
    shift_x_mm: Exact,
    #[serde(default)]
    shift_y_mm: Exact,
    front_x_mm: Vec<Exact>,
    front_y_mm: Vec<Exact>,
    back_x_mm: Vec<Exact>,
    back_y_mm: Vec<Exact>,
    lamella_front_x_mm: Vec<Exact>,
    lamella_front_y_mm: Vec<Exact>,
    lamella_back_x_mm: Vec<Exact>,
    lamella_back_y_mm: Vec<Exact>,
    contact_x_mm: Vec<Exact>,
    contact_y_mm: Vec<Exact>,
    contact_force_x_n: Vec<Exact>,
    contact_force_y_n: Vec<Exact>,
}

impl From<&Shape> for ShapeMessage {
    fn from(shape: &Shape) -> Self {
        let list = |points: &[[f32; 2]], axis: usize| points.iter().map(|point| Exact(point[axis])).collect();
        let contacts = |of: fn(&Contact) -> f32| shape.contacts.iter().map(|contact| Exact(of(contact))).collect();
        Self {
            sequence: shape.sequence,
            finger: shape.finger,
            status: shape.status,
            motor_angle_deg: Degrees(shape.motor_angle),
            shift_x_mm: Exact(shape.shift[0]),
            shift_y_mm: Exact(shape.shift[1]),
            front_x_mm: list(&shape.front, 0),
            front_y_mm: list(&shape.front, 1),
            back_x_mm: list(&shape.back, 0),
            back_y_mm: list(&shape.back, 1),
            lamella_front_x_mm: list(&shape.lamella_front, 0),
            lamella_front_y_mm: list(&shape.lamella_front, 1),
            lamella_back_x_mm: list(&shape.lamella_back, 0),
            lamella_back_y_mm: list(&shape.lamella_back, 1),
            contact_x_mm: contacts(|contact| contact.position[0]),
            contact_y_mm: contacts(|contact| contact.position[1]),
            contact_force_x_n: contacts(|contact| contact.force[0]),
            contact_force_y_n: contacts(|contact| contact.force[1]),
        }
    }
}

impl From<ShapeMessage> for Shape {
    fn from(message: ShapeMessage) -> Self {
        fn pairs<'a>(x: &'a [Exact], y: &'a [Exact]) -> impl Iterator<Item = [f32; 2]> + 'a {
            x.iter().zip(y).map(|(x, y)| [x.0, y.0])
        }
        // As many as there is room for: more were never written.
        fn first<X, const N: usize>(items: impl Iterator<Item = X>) -> heapless::Vec<X, N> {
            items.take(N).collect()
        }
        let positions = pairs(&message.contact_x_mm, &message.contact_y_mm);
        let forces = pairs(&message.contact_force_x_n, &message.contact_force_y_n);
        Self {
            sequence: message.sequence,
            finger: message.finger,
            status: message.status,
            motor_angle: message.motor_angle_deg.0,
            shift: [message.shift_x_mm.0, message.shift_y_mm.0],
            front: first(pairs(&message.front_x_mm, &message.front_y_mm)),
            back: first(pairs(&message.back_x_mm, &message.back_y_mm)),
            lamella_front: first(pairs(&message.lamella_front_x_mm, &message.lamella_front_y_mm)),
            lamella_back: first(pairs(&message.lamella_back_x_mm, &message.lamella_back_y_mm)),
            contacts: first(positions.zip(forces).map(|(position, force)| Contact { position, force })),
        }
    }
}

/// An event as the program knows it; [`super::foxglove::log`] says it in words.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct EventMessage {
    time_us: u64,
    event: Event,
}

impl From<&Notice> for EventMessage {
    fn from(notice: &Notice) -> Self {
        Self { time_us: notice.time_us, event: notice.event }
    }
}

impl From<EventMessage> for Notice {
    fn from(message: EventMessage) -> Self {
        Self { time_us: message.time_us, event: message.event }
    }
}

/// Reports that did not come.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct GapMessage {
    first: u32,
    missing: u32,
}

impl From<&Gap> for GapMessage {
    fn from(gap: &Gap) -> Self {
        Self { first: gap.first, missing: gap.missing }
    }
}

impl From<GapMessage> for Gap {
    fn from(message: GapMessage) -> Self {
        Self { first: message.first, missing: message.missing }
    }
}
