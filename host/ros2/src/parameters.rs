//! The node's parameters: how `~/grip` grips, and the gripper's settings by the keys of `fre gripper get`.

use std::collections::BTreeSet;

use fre_gripper::link::{pairs, set};
use fre_gripper::source::Setup;
use messages::{GripTo, Settings, Which};
use ros2_client::ParameterValue;
use ros2_client::parameters::raw::{ParameterDescriptor, ParameterType};
use ros2_client::rcl_interfaces::ListParametersResult;

use crate::wrench;

/// Separates the parts of a name.
const DOT: char = '.';

/// Names and values.
#[derive(Clone, Debug)]
pub struct Parameters {
    force_n: f64,
    speed_deg_per_s: f64,
    limit_deg: f64,
    finger: i64,
    place: String,
    settings: Settings,
}

/// Sets a value, or says what is allowed.
type Change = fn(&mut Parameters, f64) -> Result<(), &'static str>;

/// A parameter of the node itself.
struct Own {
    name: &'static str,
    description: &'static str,
    get: fn(&Parameters) -> ParameterValue,
    /// Nothing if it cannot be set.
    set: Option<Change>,
}

const OWN: [Own; 6] = [
    Own {
        name: "grip_force_n",
        description: "Force of each finger on the object when ~/grip is called, N.",
        get: |own| ParameterValue::Double(own.force_n),
        set: Some(|own, value| {
            let fits = (0.01..=1000.0).contains(&value);
            fits.then(|| own.force_n = value).ok_or("0.01 to 1000")
        }),
    },
    Own {
        name: "grip_speed_deg_per_s",
        description: "Greatest speed of the motor when ~/grip is called; 0: that of the settings.",
        get: |own| ParameterValue::Double(own.speed_deg_per_s),
        set: Some(|own, value| {
            let fits = value == 0.0 || (0.06..=1145.0).contains(&value);
            fits.then(|| own.speed_deg_per_s = value).ok_or("0, or 0.06 to 1145")
        }),
    },
    Own {
        name: "grip_limit_deg",
        description: "Motor angle beyond which ~/grip does not close; 180: the end of the settings' range.",
        get: |own| ParameterValue::Double(own.limit_deg),
        set: Some(|own, value| {
            let radians = value.to_radians() as f32;
            let mut ranges = own.settings.fingers.iter().flatten().map(|mount| mount.range);
            let fits = value == 180.0 || ranges.all(|[least, most]| (least..=most).contains(&radians));
            fits.then(|| own.limit_deg = value)
                .ok_or("180, or an angle in the range of every finger (least_deg to most_deg)")
        }),
    },
    Own {
        name: "finger",
        description: "Which finger ~/grip, ~/release, ~/stop and ~/relax are for, from 0; -1: all.",
        get: |own| ParameterValue::Integer(own.finger),
        set: Some(|own, value| {
            let fits = value.fract() == 0.0 && (-1.0..own.settings.count() as f64).contains(&value);
            fits.then(|| own.finger = value as i64).ok_or("-1 or the number of a finger")
        }),
    },
    Own {
        name: "source",
        description: "Where the forces come from.",
        get: |own| ParameterValue::String(own.place.clone()),
        set: None,
    },
    Own {
        name: "wrench",
        description: "What the topic ~/finger_N/wrench says.",
        get: |_| ParameterValue::String(wrench::DESCRIPTION.to_owned()),
        set: None,
    },
];

impl Parameters {
    /// Of a source.
    pub fn new(setup: &Setup) -> Self {
        Self {
            force_n: 1.0,
            speed_deg_per_s: 0.0,
            limit_deg: 180.0,
            finger: -1,
            place: setup.place.clone(),
            settings: setup.settings,
        }
    }

    /// The gripper's settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The gripper has these now.
    pub fn now(&mut self, settings: Settings) {
        self.settings = settings;
    }

    /// Which fingers are meant.
    pub fn which(&self) -> Which {
        u8::try_from(self.finger).map_or(Which::All, Which::One)
    }

    /// How is gripped.
    pub fn grip(&self) -> GripTo {
        let speed = (self.speed_deg_per_s > 0.0).then(|| self.speed_deg_per_s.to_radians() as f32);
        let limit = (self.limit_deg < 180.0).then(|| self.limit_deg.to_radians() as f32);
        GripTo { fingers: self.which(), force: self.force_n as f32, speed, limit }
    }

    /// All names, in order.
    pub fn names(&self) -> Vec<String> {
        let own = OWN.iter().map(|own| own.name.to_owned());
        own.chain(pairs(&self.settings).into_iter().map(|(key, _)| key)).collect()
    }

    /// A value; not set if there is no such parameter.
    pub fn get(&self, name: &str) -> ParameterValue {
        if let Some(own) = OWN.iter().find(|own| own.name == name) {
            return (own.get)(self);
        }
        let found = pairs(&self.settings).into_iter().find(|(key, _)| key == name);
        found.map_or(ParameterValue::NotSet, |(key, value)| typed(&key, value))
    }

    /// Changes a value.
    ///
    /// # Errors
    /// There is no such parameter, or it cannot be that. (What is out of a setting's range the gripper refuses.)
    pub fn set(&mut self, name: &str, value: &ParameterValue) -> Result<(), String> {
        let words = words(value).ok_or_else(|| format!("{name}: lists are not allowed"))?;
        let Some(own) = OWN.iter().find(|own| own.name == name) else {
            return set(&mut self.settings, &format!("{name}={words}")).map_err(|error| error.to_string());
        };
        let change = own.set.ok_or_else(|| format!("{name} cannot be set"))?;
        let number = match value {
            ParameterValue::Double(number) => *number,
            ParameterValue::Integer(number) => *number as f64,
            _ => return Err(format!("{name}: `{words}` is not a number")),
        };
        change(self, number).map_err(|allowed| format!("{name} is {number}; allowed is {allowed}"))
    }

    /// What there is to know of a parameter beside its value.
    pub fn describe(&self, name: &str) -> ParameterDescriptor {
        let own = OWN.iter().find(|own| own.name == name);
        let value = self.get(name);
        let kind = value.to_parameter_type() as u8;
        ParameterDescriptor {
            name: name.to_owned(),
            r#type: kind,
            description: match own {
                Some(own) => own.description.to_owned(),
                None if kind == ParameterType::NOT_SET => String::new(),
                None => "A setting of the gripper, as `fre gripper get` prints it.".to_owned(),
            },
            additional_constraints: String::new(),
            read_only: own.is_some_and(|own| own.set.is_none()),
            dynamic_typing: own.is_none(),
            floating_point_range: Vec::new(),
            integer_range: Vec::new(),
        }
    }

    /// The names below some prefixes, at most `depth` levels deep; 0: any.
    pub fn list(&self, prefixes: &[String], depth: u64) -> ListParametersResult {
        let shallow = |rest: &str| depth == 0 || (rest.matches(DOT).count() as u64) < depth;
        let wanted = |name: &String| {
            let below = |prefix: &String| {
                name == prefix
                    || name.strip_prefix(prefix.as_str()).and_then(|rest| rest.strip_prefix(DOT)).is_some_and(shallow)
            };
            if prefixes.is_empty() { shallow(name) } else { prefixes.iter().any(below) }
        };
        let names: Vec<String> = self.names().into_iter().filter(wanted).collect();
        let parents = names.iter().filter_map(|name| Some(name.rsplit_once(DOT)?.0.to_owned()));
        let prefixes: BTreeSet<String> = parents.collect();
        ListParametersResult { names, prefixes: prefixes.into_iter().collect() }
    }
}

/// A setting's value with the type that its key has whatever the value is.
fn typed(key: &str, value: String) -> ParameterValue {
    let whole = ["rate_hz", "shape_every", "device_id", "return_delay_us", "baud", "servo_id"];
    let last = key.rsplit(DOT).next().unwrap_or(key);
    match (value.parse::<i64>(), value.parse::<f64>(), value.parse::<bool>()) {
        (Ok(number), _, _) if whole.contains(&last) => ParameterValue::Integer(number),
        (_, Ok(number), _) => ParameterValue::Double(number),
        (_, _, Ok(truth)) => ParameterValue::Boolean(truth),
        _ => ParameterValue::String(value),
    }
}

/// A value as people write it.
fn words(value: &ParameterValue) -> Option<String> {
    match value {
        ParameterValue::Boolean(value) => Some(value.to_string()),
        ParameterValue::Integer(value) => Some(value.to_string()),
        ParameterValue::Double(value) => Some(value.to_string()),
        ParameterValue::String(value) => Some(value.clone()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> Parameters {
        Parameters {
            force_n: 1.0,
            speed_deg_per_s: 0.0,
            limit_deg: 180.0,
            finger: -1,
            place: String::new(),
            settings: Settings::DEFAULT,
        }
    }

    /// What is taken here is what the gripper takes.
    #[test]
    fn what_no_grip_takes_is_refused_here() {
        let mut own = parameters();
        let [least, most] = Settings::DEFAULT.fingers[0].unwrap().range.map(f32::to_degrees);
        let angle = |angle: f32| ParameterValue::Double(f64::from(angle));
        for (name, value) in [
            ("grip_limit_deg", angle(most + 1.0)),
            ("grip_limit_deg", angle(least - 1.0)),
            ("grip_speed_deg_per_s", ParameterValue::Double(0.01)),
            ("grip_force_n", ParameterValue::String("2.5".to_owned())),
            ("grip_force_n", ParameterValue::Double(f64::NAN)),
        ] {
            let refused = own.set(name, &value).unwrap_err();
            assert!(refused.starts_with(name), "{refused}");
        }
        assert_eq!(own.grip(), parameters().grip());
        for (name, value) in [
            ("grip_limit_deg", angle(most - 1.0)),
            ("grip_limit_deg", ParameterValue::Integer(180)),
            ("grip_speed_deg_per_s", ParameterValue::Integer(0)),
            ("grip_force_n", ParameterValue::Integer(2)),
        ] {
            own.set(name, &value).unwrap();
        }
        assert_eq!((own.force_n, own.limit_deg), (2.0, 180.0));
    }
}
