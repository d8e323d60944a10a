//! What is asked of a gripper, one function per request, and the gripper as a source.

use std::sync::mpsc::Receiver;

use messages::{
    BootReport, Carry, CarryTo, Close, CloseTo, Counters, Finger, For, GetBoot, GetCounters, GetFinger, GetObject,
    GetServo, GetSettings, GetUncertainty, GetVersion, Grip, GripTo, Heed, Heeds, Hold, Object, Open, PlaceObject,
    Provocation, Provoke, Relax, Scan, ServoSetup, SetFinger, SetObject, SetSettings, SetUncertainty, Settings,
    Version, Which,
};
use model_core::size::Lists;
use model_core::uncertainty::Uncertainty;
use postcard_rpc::Endpoint;
use postcard_rpc::header::VarKey;

use super::{Link, LinkError};
use crate::source::{Modelled, Order, OrderError, Origin, Setup, Source, Statistics, Told};

/// The gripper's requests.
impl Link {
    /// Who answers.
    ///
    /// # Errors
    /// As [`Link::ask`], as with all that follow.
    pub fn version(&self) -> Result<Version, LinkError> {
        self.ask::<GetVersion>(&())
    }

    /// How long the lists of a description may be there.
    fn lists(&self) -> Result<Lists, LinkError> {
        if let Some(lists) = self.lists.get() {
            return Ok(*lists);
        }
        let lists = self.version()?.lists;
        Ok(*self.lists.get_or_init(|| lists))
    }

    /// How its program started.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn boot(&self) -> Result<BootReport, LinkError> {
        self.ask::<GetBoot>(&())
    }

    /// A finger's object in its memory; fingers count from 0.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn object(&self, finger: u8) -> Result<Option<Object>, LinkError> {
        self.ask::<GetObject>(&finger)
    }

    /// Gives a finger an object, in that finger's world frame; the estimate starts anew.
    ///
    /// # Errors
    /// As [`Link::ask`], and what is wrong with the object.
    pub fn set_object(&self, finger: u8, object: impl Into<Object>) -> Result<(), LinkError> {
        let object = object.into();
        object.design.fits(self.lists()?)?;
        Ok(self.ask::<SetObject>(&For { finger, what: object })??)
    }

    /// The same for now only: it is not stored, so that it may be done at any rate.
    ///
    /// # Errors
    /// As [`Link::set_object`].
    pub fn place_object(&self, finger: u8, object: impl Into<Object>) -> Result<(), LinkError> {
        let object = object.into();
        object.design.fits(self.lists()?)?;
        Ok(self.ask::<PlaceObject>(&For { finger, what: object })??)
    }

    /// A finger's design in its memory.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn finger(&self, finger: u8) -> Result<Option<Finger>, LinkError> {
        self.ask::<GetFinger>(&finger)
    }

    /// Gives a finger a design; the estimate starts anew.
    ///
    /// # Errors
    /// As [`Link::ask`], and what is wrong with the design or its discretisation.
    pub fn set_finger(&self, finger: u8, design: &Finger) -> Result<(), LinkError> {
        design.design.fits(self.lists()?)?;
        Ok(self.ask::<SetFinger>(&For { finger, what: design.clone() })??)
    }

    /// What a calibration has left uncertain of a finger, if one was sent.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn uncertainty(&self, finger: u8) -> Result<Option<Uncertainty>, LinkError> {
        self.ask::<GetUncertainty>(&finger)
    }

    /// Says how uncertain a finger's parameters are, which its forces' standard deviations then follow; none: what is usual.
    ///
    /// # Errors
    /// As [`Link::ask`], and the first value that is not allowed.
    pub fn set_uncertainty(&self, finger: u8, uncertainty: Option<Uncertainty>) -> Result<(), LinkError> {
        Ok(self.ask::<SetUncertainty>(&For { finger, what: uncertainty })??)
    }

    /// How a finger's servo was found set, if one was found since the start.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn servo(&self, finger: u8) -> Result<Option<ServoSetup>, LinkError> {
        self.ask::<GetServo>(&finger)
    }

    /// Its settings.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn settings(&self) -> Result<Settings, LinkError> {
        self.ask::<GetSettings>(&())
    }

    /// Changes its settings.
    ///
    /// # Errors
    /// As [`Link::ask`], and the first value that is not allowed.
    pub fn set_settings(&self, settings: &Settings) -> Result<(), LinkError> {
        Ok(self.ask::<SetSettings>(settings)??)
    }

    /// Opens each finger to the settings' open angle, those whose servo answers. Returns when it begins, as all that follow.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo.
    pub fn open_fingers(&self, fingers: Which) -> Result<Heeds, LinkError> {
        Ok(self.ask::<Open>(&fingers)??)
    }

    /// Closes to a motor angle (rad) with a speed (rad/s; `None`: the settings' own).
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo; an angle or speed out of range.
    pub fn close(&self, fingers: Which, angle: f32, speed: Option<f32>) -> Result<(), LinkError> {
        Ok(self.ask::<Close>(&CloseTo { fingers, angle, speed })??)
    }

    /// Closes all fingers until together they bear a weight.
    ///
    /// # Errors
    /// As [`Link::ask`]; fewer than two fingers; no servo; no design or object; a number out of range.
    pub fn carry(&self, to: &CarryTo) -> Result<(), LinkError> {
        Ok(self.ask::<Carry>(to)??)
    }

    /// Closes until a force is reached, and keeps it.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo; no design or object; a number out of range.
    pub fn grip(&self, to: &GripTo) -> Result<(), LinkError> {
        Ok(self.ask::<Grip>(to)??)
    }

    /// Stops each finger where it is, those whose servo answers.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo.
    pub fn hold(&self, fingers: Which) -> Result<Heeds, LinkError> {
        Ok(self.ask::<Hold>(&fingers)??)
    }

    /// Switches the torque off: each finger yields, and lets go of what it holds. The next motion switches it on.
    ///
    /// # Errors
    /// As [`Link::ask`]; no servo.
    pub fn relax(&self, fingers: Which) -> Result<Heeds, LinkError> {
        Ok(self.ask::<Relax>(&fingers)??)
    }

    /// Has it search its bus for devices at every rate, which takes some seconds: events tell what is found, and the end.
    ///
    /// # Errors
    /// As [`Link::ask`]; another master leads the servos, or a finger grips.
    pub fn scan(&self) -> Result<(), LinkError> {
        Ok(self.ask::<Scan>(&())??)
    }

    /// Has it start anew, or go wrong on purpose if it was built for that; the link may end before the answer.
    ///
    /// # Errors
    /// As [`Link::ask`]; a program that is not for tests.
    pub fn provoke(&self, what: Provocation) -> Result<(), LinkError> {
        Ok(self.ask::<Provoke>(&what)??)
    }

    /// What it has counted.
    ///
    /// # Errors
    /// As [`Link::ask`].
    pub fn counters(&self) -> Result<Counters, LinkError> {
        self.ask::<GetCounters>(&())
    }

    /// Another program has asked for this: a changed set-up goes to all listeners here.
    pub(super) fn was_set(&self, key: VarKey) {
        let set = [
            SetObject::REQ_KEY,
            PlaceObject::REQ_KEY,
            SetFinger::REQ_KEY,
            SetSettings::REQ_KEY,
            SetUncertainty::REQ_KEY,
        ];
        if set.into_iter().any(|of| key == VarKey::Key8(of))
            && let Ok(setup) = Source::setup(self)
        {
            self.spread(&Told::Setup(Box::new(setup)));
        }
    }
}

/// That all fingers obey, or which of them do not.
fn heeded(heeds: Heeds) -> Result<(), OrderError> {
    let silent: Vec<u8> =
        (0..).zip(heeds).filter(|(_, heed)| *heed == Some(Heed::NoServo)).map(|(number, _)| number).collect();
    if silent.is_empty() { Ok(()) } else { Err(OrderError::Silent(silent)) }
}

impl Source for Link {
    fn setup(&self) -> Result<Setup, OrderError> {
        let version = self.version()?;
        let settings = self.settings()?;
        let mut models = Vec::new();
        for number in 0..settings.count() as u8 {
            let mut model = Modelled {
                finger: self.finger(number)?,
                uncertainty: self.uncertainty(number)?,
                ..Modelled::default()
            };
            model.grasp(self.object(number)?);
            models.push(model);
        }
        Ok(Setup {
            origin: Origin::Gripper,
            place: self.place().to_owned(),
            board: version.board.as_str().to_owned(),
            firmware: version.firmware.as_str().to_owned(),
            protocol: version.protocol,
            cost_hz: version.cost_hz,
            settings,
            models,
        })
    }

    fn hear(&self, waiting: usize) -> Receiver<Told> {
        self.listen_with(waiting)
    }

    fn statistics(&self) -> Statistics {
        Self::statistics(self)
    }

    fn counters(&self) -> Result<Option<Counters>, OrderError> {
        Ok(Some(Self::counters(self)?))
    }

    fn sign(&self) {
        // The shortest question with the shortest answer: the object of a finger that no gripper has.
        self.ask_idly::<GetObject>(&u8::MAX);
    }

    fn order(&self, order: &Order) -> Result<(), OrderError> {
        match order {
            Order::Object(finger, object) => self.set_object(*finger, *object)?,
            Order::Finger(finger, design) => self.set_finger(*finger, design)?,
            Order::Settings(settings) => self.set_settings(settings)?,
            Order::Open(which) => return heeded(self.open_fingers(*which)?),
            Order::Close(to) => return Ok(self.close(to.fingers, to.angle, to.speed)?),
            Order::Grip(to) => return Ok(self.grip(to)?),
            Order::Hold(which) => return heeded(self.hold(*which)?),
            Order::Relax(which) => return heeded(self.relax(*which)?),
        }
        let setup = Source::setup(self)?;
        self.spread(&Told::Setup(Box::new(setup)));
        Ok(())
    }

    fn is_closed(&self) -> bool {
        Self::is_closed(self)
    }
}
