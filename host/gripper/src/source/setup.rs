//! What the source is, and how its numbers come about.

use messages::{Finger, FreeObject, Object, Settings, Side};
use model_core::grasp::Place;
use model_core::object::ObjectDesign;
use model_core::uncertainty::Uncertainty;
use serde::{Deserialize, Serialize};

/// What kind of source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Origin {
    /// A gripper, which estimates itself.
    Gripper,
    /// Servos on a bus of this PC, which estimates.
    Bus,
    /// A recording.
    Recording,
}

/// A finger's model.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Modelled {
    /// Its design, if it has one.
    pub finger: Option<Finger>,
    /// Its object, world frame, if it has one.
    pub object: Option<ObjectDesign>,
    /// The object's coefficient of friction. (Recordings of versions before it have none: 0.)
    #[serde(default)]
    pub friction: f64,
    /// What a calibration has left uncertain, if there was one. (Recordings of versions before it have none.)
    #[serde(default)]
    pub uncertainty: Option<Uncertainty>,
}

impl Modelled {
    /// The object with its friction.
    pub fn grasped(&self) -> Option<Object> {
        self.object.map(|design| Object { design, friction: self.friction })
    }

    /// Takes an object, or none.
    pub fn grasp(&mut self, object: Option<Object>) {
        (self.object, self.friction) =
            (object.map(|object| object.design), object.map_or(0.0, |object| object.friction));
    }
}

/// Everything that the numbers depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// What kind of source.
    pub origin: Origin,
    /// Where it is: an address, a port, a file.
    pub place: String,
    /// The gripper's board; for a bus its servos.
    pub board: String,
    /// Version of the program that estimates.
    pub firmware: String,
    /// Version of what its messages mean.
    pub protocol: u16,
    /// Ticks per second of the clock in which costs are reported.
    pub cost_hz: u32,
    /// Its settings; a finger's number is its place in them.
    pub settings: Settings,
    /// One model per finger of the settings.
    pub models: Vec<Modelled>,
}

impl Setup {
    /// A finger's object where a free one has come to, in the finger's own world frame; where it was set if it is fixed.
    pub fn object(&self, finger: u8, free: Option<&FreeObject>) -> Option<ObjectDesign> {
        let object = self.models.get(usize::from(finger))?.object?;
        let is_mirrored = self.settings.finger(finger).is_some_and(|mount| mount.side == Side::Right);
        Some(placed(&object, free, is_mirrored))
    }
}

/// A finger's object where a free one has come to.
pub(super) fn placed(object: &ObjectDesign, free: Option<&FreeObject>, is_mirrored: bool) -> ObjectDesign {
    let Some(free) = free else { return *object };
    let place = Place { shift: free.shift.map(f64::from), turn: f64::from(free.turn) };
    if is_mirrored { place.mirrored() } else { place }.of(object)
}

#[cfg(test)]
mod tests {
    use model_core::discretise::{Discretisation, Physics};

    use super::*;

    /// A recording of a version before memory has fingers without the key.
    #[test]
    fn a_finger_of_an_earlier_recording_is_elastic() {
        let design = fre::case::preset("ladder-80").unwrap().unwrap().design;
        let finger = Finger::elastic(design, Discretisation::estimator(Physics::Extended));
        let model = Modelled { finger: Some(finger.clone().relaxing(&[[0.2, 5.0]])), ..Modelled::default() };
        let mut words = serde_json::to_value(&model).unwrap();
        assert_eq!(serde_json::from_value::<Modelled>(words.clone()).unwrap(), model);
        assert!(words["finger"].as_object_mut().unwrap().remove("prony").is_some());
        assert_eq!(serde_json::from_value::<Modelled>(words).unwrap().finger, Some(finger));
    }
}
