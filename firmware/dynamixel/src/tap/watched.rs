//! What is known of one servo from its answers to another master.

use super::indirect::Indirect;
use crate::item::{Register, Value};
use crate::models::Model;
use crate::packet::{Id, StatusReturn};

/// Answers in a row that did not come, after which a servo may have been without power.
const LOST_AFTER: u32 = 3;

/// A value and when it was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Seen<T> {
    /// The value.
    pub value: T,
    /// When the packet with it had come, µs.
    pub at_us: u64,
}

impl<T> Seen<T> {
    /// How old it is, µs.
    pub fn age_us(&self, now_us: u64) -> u64 {
        now_us.saturating_sub(self.at_us)
    }
}

/// A servo that another master leads.
#[derive(Clone, Debug)]
pub struct Watched {
    /// Its address.
    pub id: Id,
    /// What it is: by which control table it is understood.
    pub model: &'static Model,
    /// Present Position, counts.
    pub position: Option<Seen<i32>>,
    /// Present Velocity, [`Model::velocity`].
    pub velocity: Option<Seen<i32>>,
    /// Present Current or Present Load, [`Model::effort`].
    pub effort: Option<Seen<i16>>,
    /// Torque Enable, read or written.
    pub torque: Option<Seen<u8>>,
    /// Goal Position, read or written.
    pub goal: Option<Seen<i32>>,
    /// Hardware Error Status.
    pub hardware_error: Option<Seen<u8>>,
    /// The last answer said that there is a hardware error.
    pub alert: bool,
    /// Answers heard; wraps.
    pub answers: u32,
    /// Questions since the last answer to which nothing came at all.
    pub silent: u32,
    /// Which instructions it answers, if that was heard.
    status_return: Option<StatusReturn>,
    indirect: Indirect,
}

impl Watched {
    pub(super) const fn new(id: Id, model: &'static Model) -> Self {
        Self {
            id,
            model,
            position: None,
            velocity: None,
            effort: None,
            torque: None,
            goal: None,
            hardware_error: None,
            alert: false,
            answers: 0,
            silent: 0,
            status_return: None,
            indirect: Indirect::unknown(model.indirect),
        }
    }

    /// Whether it answers an instruction with this code, if that is known.
    pub(super) fn answers(&self, code: u8) -> Option<bool> {
        self.status_return.map(|level| level.answers(code))
    }

    pub(super) fn answered(&mut self, alert: bool) {
        self.alert = alert;
        self.answers = self.answers.wrapping_add(1);
        self.silent = 0;
    }

    /// It has said what it is. What another control table seemed to say is forgotten.
    pub(super) fn is(&mut self, model: u16) {
        if let Some(model) = Model::of(model).filter(|model| **model != *self.model) {
            let Self { id, answers, alert, .. } = *self;
            *self = Self { answers, alert, ..Self::new(id, model) };
        }
    }

    pub(super) fn was_silent(&mut self) {
        self.silent = self.silent.saturating_add(1);
        if self.silent >= LOST_AFTER {
            self.restarted();
        }
    }

    /// What RAM holds is not known any more.
    pub(super) fn restarted(&mut self) {
        self.indirect = Indirect::unknown(self.model.indirect);
        self.torque = None;
        self.goal = None;
        self.status_return = None;
    }

    /// Bytes that the servo has read out.
    pub(super) fn read(&mut self, address: u16, bytes: &[u8], now_us: u64) {
        self.indirect.learn(address, bytes);
        self.stands(address, bytes, now_us);
        let registers = self.model.layout.followed();
        let seen = Present { indirect: &self.indirect, address, bytes, now_us };
        seen.show(registers.position, &mut self.position);
        seen.show(registers.velocity, &mut self.velocity);
        seen.show(registers.effort, &mut self.effort);
        seen.show(registers.hardware_error, &mut self.hardware_error);
    }

    /// Bytes that the servo has taken.
    pub(super) fn written(&mut self, address: u16, bytes: &[u8], now_us: u64) {
        self.indirect.learn(address, bytes);
        self.stands(address, bytes, now_us);
    }

    /// Bytes that the servo may have taken, or may take later.
    pub(super) fn doubt(&mut self, address: u16, length: usize) {
        self.indirect.doubt(address, length);
    }

    /// It may have received anything.
    pub(super) fn doubt_all(&mut self) {
        self.indirect = Indirect::unknown(self.model.indirect);
    }

    fn stands(&mut self, address: u16, bytes: &[u8], now_us: u64) {
        let registers = self.model.layout.followed();
        let seen = Present { indirect: &self.indirect, address, bytes, now_us };
        seen.show(registers.torque, &mut self.torque);
        seen.show(registers.goal, &mut self.goal);
        let mut level = None;
        seen.show(registers.status_return, &mut level);
        if let Some(level) = level {
            self.status_return = StatusReturn::from_value(level.value);
        }
    }
}

/// A part of a servo's control table as it was heard.
struct Present<'a> {
    indirect: &'a Indirect,
    address: u16,
    bytes: &'a [u8],
    now_us: u64,
}

impl Present<'_> {
    /// The register's value, if all of it is there.
    fn show<T: Value>(&self, register: Register<T>, into: &mut Option<Seen<T>>) {
        let mut value = [0; 4];
        for (place, to) in value.iter_mut().take(usize::from(T::LENGTH)).enumerate() {
            match self.byte(register.address().wrapping_add(place as u16)) {
                Some(byte) => *to = byte,
                None => return,
            }
        }
        *into = Some(Seen { value: T::from_bytes(value), at_us: self.now_us });
    }

    fn byte(&self, register: u16) -> Option<u8> {
        let direct = register.checked_sub(self.address).and_then(|offset| self.bytes.get(usize::from(offset)));
        if let Some(&byte) = direct {
            // No register that is looked for lies where others are shown.
            return Some(byte);
        }
        if !self.indirect.covers(self.address, self.bytes.len()) {
            return None;
        }
        let shows = |&(offset, _): &(usize, &u8)| {
            let address = usize::from(self.address) + offset;
            let address = u16::try_from(address).ok();
            address.is_some_and(|address| address != register && self.indirect.register(address) == Some(register))
        };
        self.bytes.iter().enumerate().find(shows).map(|(_, &byte)| byte)
    }
}
