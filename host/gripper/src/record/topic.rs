//! Topics of a recording, and what their messages look like.

use serde_json::{Map, Value, json};

use super::foxglove;
use super::message::{EstimateMessage, GraspMessage, ShapeMessage};

/// What a topic carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Topic {
    /// `/finger_N/estimate`
    Estimate(u8),
    /// `/finger_N/shape`
    Shape(u8),
    /// `/finger_N/scene`
    Scene(u8),
    /// `/finger_N/object`
    Object(u8),
    /// `/grasp`
    Grasp,
    /// `/events`, for people
    Log,
    /// `/event_data`, for programs
    Event,
    /// `/gaps`
    Gap,
    /// `/setup`
    Setup,
}

impl Topic {
    /// Its name.
    pub(super) fn name(self) -> String {
        match self {
            Self::Estimate(finger) => format!("/finger_{finger}/estimate"),
            Self::Shape(finger) => format!("/finger_{finger}/shape"),
            Self::Scene(finger) => format!("/finger_{finger}/scene"),
            Self::Object(finger) => format!("/finger_{finger}/object"),
            Self::Grasp => "/grasp".to_owned(),
            Self::Log => "/events".to_owned(),
            Self::Event => "/event_data".to_owned(),
            Self::Gap => "/gaps".to_owned(),
            Self::Setup => "/setup".to_owned(),
        }
    }

    /// The topic of a name, among those that are read back; the pictures are made from the others.
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "/grasp" => return Some(Self::Grasp),
            "/event_data" => return Some(Self::Event),
            "/gaps" => return Some(Self::Gap),
            "/setup" => return Some(Self::Setup),
            _ => {}
        }
        let (finger, what) = name.strip_prefix("/finger_")?.split_once('/')?;
        let finger: u8 = finger.parse().ok()?;
        match what {
            "estimate" => Some(Self::Estimate(finger)),
            "shape" => Some(Self::Shape(finger)),
            _ => None,
        }
    }

    /// Name and JSON Schema of its messages.
    pub(super) fn schema(self) -> (&'static str, Value) {
        match self {
            Self::Estimate(_) => ("fre.Estimate", flat::<EstimateMessage>()),
            Self::Shape(_) => ("fre.Shape", flat::<ShapeMessage>()),
            Self::Scene(_) | Self::Object(_) => ("foxglove.SceneUpdate", foxglove::scene_schema()),
            Self::Grasp => ("fre.Grasp", flat::<GraspMessage>()),
            Self::Log => ("foxglove.Log", foxglove::log_schema()),
            Self::Event => ("fre.Event", some(&[("time_us", "integer"), ("event", "object")])),
            Self::Gap => ("fre.Gap", some(&[("first", "integer"), ("missing", "integer")])),
            Self::Setup => {
                let words = ["origin", "place", "board", "firmware"].map(|name| (name, "string"));
                let numbers = ["protocol", "cost_hz"].map(|name| (name, "integer"));
                let rest = [("settings", "object"), ("models", "objects")];
                ("fre.Setup", some(&[&words[..], &numbers[..], &rest[..]].concat()))
            }
        }
    }
}

/// A message whose fields are numbers, words or lists of numbers.
trait Flat {
    /// Its fields and their types.
    fn fields() -> Vec<(&'static str, &'static str)>;
}

fn flat<M: Flat>() -> Value {
    some(&M::fields())
}

fn some(fields: &[(&str, &str)]) -> Value {
    let field = |kind: &str| match kind {
        "numbers" => json!({ "type": "array", "items": { "type": "number" } }),
        "objects" => json!({ "type": "array", "items": { "type": "object", "properties": {} } }),
        "object" => json!({ "type": "object", "properties": {} }),
        kind => json!({ "type": kind }),
    };
    let properties: Map<String, Value> = fields.iter().map(|(name, kind)| ((*name).to_owned(), field(kind))).collect();
    json!({ "type": "object", "properties": properties })
}

/// Lists the fields once more, as types; the test compares them with what is written.
macro_rules! fields {
    ($message:ident: $($kind:literal: $($name:literal)*;)*) => {
        impl Flat for $message {
            fn fields() -> Vec<(&'static str, &'static str)> {
                vec![$($(($name, $kind),)*)*]
            }
        }
    };
}

fields!(EstimateMessage:
    "integer": "sequence" "finger" "time_us" "age" "position_counts" "iterations" "cost" "sensitivity_age"
        "loaded_rib" "rib_load_percent";
    "string": "status" "phase";
    "number": "force_magnitude_n" "force_x_n" "force_y_n" "motor_angle_deg" "goal_deg" "current_ma" "contact_x_mm" "contact_y_mm"
        "contact_extent_mm" "torque_nmm" "distance_mm" "residual_nmm" "force_x_per_deg_n" "force_y_per_deg_n"
        "standard_deviation_n" "force_interval_low_n" "force_interval_high_n" "normal_interval_low_n" "normal_interval_high_n"
        "torque_interval_low_nmm" "torque_interval_high_nmm";
);
fields!(GraspMessage:
    "integer": "sequence" "object_iterations" "object_cost" "margin_slips" "margin_age";
    "boolean": "is_trustworthy" "is_free" "has_margin" "is_carried";
    "string": "object_status";
    "number": "sum_x_n" "sum_y_n" "squeeze_n" "balance" "object_shift_x_mm" "object_shift_y_mm" "object_turn_deg"
        "object_residual_n" "margin_n" "margin_direction_deg" "margin_across_n" "margin_couple_nmm" "margin_carried_n";
);
fields!(ShapeMessage:
    "integer": "sequence" "finger";
    "string": "status";
    "number": "motor_angle_deg" "shift_x_mm" "shift_y_mm";
    "numbers": "front_x_mm" "front_y_mm" "back_x_mm" "back_y_mm" "lamella_front_x_mm" "lamella_front_y_mm" "lamella_back_x_mm"
        "lamella_back_y_mm" "contact_x_mm" "contact_y_mm" "contact_force_x_n" "contact_force_y_n";
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_back() {
        for topic in [Topic::Estimate(3), Topic::Shape(0), Topic::Grasp, Topic::Event, Topic::Gap, Topic::Setup] {
            assert_eq!(Topic::named(&topic.name()), Some(topic));
        }
        for pictures in [Topic::Scene(1), Topic::Object(1), Topic::Log] {
            assert_eq!(Topic::named(&pictures.name()), None);
        }
    }
}
