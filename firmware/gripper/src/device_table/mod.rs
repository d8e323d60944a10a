//! The gripper as a device on the Dynamixel bus: its control table.
//!
#![doc = include_str!("../../../../docs/device.md")]
// The page's blocks say to the book's tests why they are not run.
#![allow(rustdoc::invalid_codeblock_attributes)]

mod registers;

pub use registers::{
    BAUD_RATE, BLOCK, BLOCKS, FINGERS, FIRMWARE_VERSION, FIRST_BLOCK, FingerBlock, HARDWARE_ERROR_STATUS, ID, ITEMS,
    LENGTH, MARGIN, MARGIN_ACROSS, MARGIN_AGE, MARGIN_COUPLE, MARGIN_DIRECTION, MARGIN_KNOWN, MARGIN_SLIPS, MODEL,
    MODEL_NUMBER, NO_FINGER, PROTOCOL_TYPE, REGISTERED_INSTRUCTION, RETURN_DELAY_TIME, STATUS_RETURN_LEVEL,
    TABLE_VERSION, VERSION,
};

use dynamixel::{ControlTable, Id, Item, Register, StatusError, StatusReturn, Value, check_read, writes, xm430};
use messages::{Direction, GripMargin, Mount, Role, Settings};
use model_core::estimator::Estimate;
use model_core::object::ObjectDesign;
use model_core::status::Status;

use crate::return_delay;

/// Units of the registers per unit of the settings: thousandths of a gear ratio, hundredths of a count, µm.
const GEAR_SCALE: f32 = 1e3;
const ZERO_SCALE: f32 = 1e2;
const OBJECT_SCALE: f32 = 1e3;

/// Age up to which a position counts though no newer one was heard, µs.
pub(crate) const YOUNG_US: u64 = 100_000;

/// What the table shows of a finger at one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerState {
    /// Force, contact and their status.
    pub estimate: Estimate,
    /// The servo's position, counts.
    pub position: i32,
    /// The servo's current, mA.
    pub current: f32,
    /// Time since that position was heard, µs; none if there is no position.
    pub age_us: Option<u32>,
    /// The servo has a hardware error.
    pub alert: bool,
}

/// What the table can change of a finger.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerSettings {
    /// Address of its servo.
    pub servo_id: u8,
    /// Counts fall as the finger closes.
    pub reversed: bool,
    /// Revolutions of the servo per revolution of the finger.
    pub gear_ratio: f32,
    /// Position at motor angle 0, counts.
    pub zero: f32,
}

/// How the gripper takes part in the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusSettings {
    /// Its address.
    pub id: Id,
    /// Bits per second: one of [`xm430::BAUD_RATES`] from 57,600 on.
    pub baud_rate: u32,
    /// 2 µs.
    pub return_delay: u8,
}

impl FingerSettings {
    /// Those of a mount.
    pub(crate) fn of(mount: &Mount) -> Self {
        let &Mount { servo_id, direction, gear_ratio, zero, .. } = mount;
        Self { servo_id, reversed: direction == Direction::Reversed, gear_ratio, zero }
    }

    /// Changes of a mount what was changed in the table: a number that still shows as it did keeps the digits that the table does not have.
    pub(crate) fn put_into(&self, mount: &mut Mount) {
        let direction = if self.reversed { Direction::Reversed } else { Direction::Same };
        let gear_ratio = changed(self.gear_ratio, mount.gear_ratio, GEAR_SCALE);
        let zero = changed(self.zero, mount.zero, ZERO_SCALE);
        // A zero that was set is of no calibration any more.
        let is_calibrated = zero == mount.zero && direction == mount.direction;
        let calibration = if is_calibrated { mount.calibration } else { 0 };
        *mount = Mount { servo_id: self.servo_id, direction, gear_ratio, zero, calibration, ..*mount };
    }
}

impl BusSettings {
    /// Those of a gripper in role `device`; nothing in any other.
    pub fn of(settings: &Settings) -> Option<Self> {
        let Role::Device { id, return_delay } = settings.role else { return None };
        let id = Id::new(id).unwrap_or(Id::MAX);
        Some(Self { id, baud_rate: settings.baud_heard(), return_delay })
    }

    /// Changes of the settings what was changed in the table: a rate that was not chosen stays so.
    pub(crate) fn put_into(&self, settings: &mut Settings) {
        settings.role = Role::Device { id: self.id.get(), return_delay: self.return_delay };
        if self.baud_rate != settings.baud_heard() {
            settings.baud = Some(self.baud_rate);
        }
    }
}

/// What the bus's master has changed. It holds in the table already; the gripper has to follow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The gripper is to restart.
    Reboot,
    /// Address, rate or return delay.
    Bus(BusSettings),
    /// How a finger's servo is found and read.
    Finger(usize, FingerSettings),
    /// What a finger grasps.
    Object(usize, ObjectDesign),
}

/// The gripper's control table.
#[derive(Clone, Debug)]
pub struct DeviceTable {
    memory: [u8; LENGTH],
    /// [`crate::Board::ANSWER_US`].
    answer_us: u32,
    reboot: bool,
    bus_changed: bool,
    /// Bit k: finger k.
    fingers_changed: u8,
    objects_changed: u8,
}

/// The registers of each finger.
const FINGER: [FingerBlock; BLOCKS] = [FingerBlock::of(0), FingerBlock::of(1), FingerBlock::of(2), FingerBlock::of(3)];

impl DeviceTable {
    /// A gripper with so many fingers, at most [`BLOCKS`], all of them without object and without a force, whose answers are ready after
    /// `answer_us` ([`crate::Board::ANSWER_US`]).
    pub fn new(bus: &BusSettings, firmware: u8, fingers: usize, answer_us: u32) -> Self {
        let mut table = Self {
            memory: [0; LENGTH],
            answer_us,
            reboot: false,
            bus_changed: false,
            fingers_changed: 0,
            objects_changed: 0,
        };
        for item in &ITEMS {
            let from = usize::from(item.address);
            if let Some(place) = table.memory.get_mut(from..from + usize::from(item.length)) {
                place.iter_mut().zip(item.default.to_le_bytes()).for_each(|(to, byte)| *to = byte);
            }
        }
        table.put(FIRMWARE_VERSION, firmware);
        table.set_bus(bus, fingers);
        table
    }

    /// Shows how the gripper takes part in the bus, and with how many fingers.
    pub fn set_bus(&mut self, bus: &BusSettings, fingers: usize) {
        self.put(ID, bus.id.get());
        self.put(BAUD_RATE, xm430::baud_code(bus.baud_rate).unwrap_or(BAUD_RATE.item.default as u8));
        self.put(RETURN_DELAY_TIME, bus.return_delay);
        self.put(FINGERS, fingers.min(BLOCKS) as u8);
        // Nobody shows the others' any more.
        self.put(HARDWARE_ERROR_STATUS, self.get(HARDWARE_ERROR_STATUS) & !u8::MAX.unbounded_shl(fingers as u32));
    }

    /// Shows what a finger feels. To be called once per tick and finger, and [`Self::show_age`] before each answer.
    pub fn show(&mut self, finger: usize, state: &FingerState) {
        let Some(block) = FINGER.get(finger) else {
            return;
        };
        let FingerState { estimate, position, current, age_us, alert } = state;
        for (register, value) in block.force.into_iter().zip(estimate.force) {
            self.put(register, scaled(value, 1e3));
        }
        self.put(block.magnitude, scaled(estimate.force_magnitude(), 1e3) as u32);
        for (register, value) in block.contact_centre.into_iter().zip(estimate.contact_centre) {
            self.put(register, scaled(value, 1e3));
        }
        self.put(block.torque, scaled(estimate.torque, 1e3));
        self.put(block.status, code(estimate.status));
        let trustworthy = estimate.status.is_trustworthy() && age_us.is_some();
        self.put(block.trustworthy, u8::from(trustworthy));
        self.put(block.current, scaled(*current, 1.0).clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16);
        self.put(block.age, age_us.unwrap_or(u32::MAX));
        self.put(block.motor_angle, scaled(estimate.motor_angle, 1e6));
        self.put(block.position, *position);
        let bit = 1u8.checked_shl(finger as u32).unwrap_or(0);
        let errors = self.get(HARDWARE_ERROR_STATUS);
        self.put(HARDWARE_ERROR_STATUS, if *alert { errors | bit } else { errors & !bit });
    }

    /// Shows how long ago a finger's position was heard, µs; none where none was. Numbers of one that is no longer young are old at once, not
    /// only when the period ends.
    pub fn show_age(&mut self, finger: usize, age_us: Option<u32>) {
        let Some(block) = FINGER.get(finger) else {
            return;
        };
        self.put(block.age, age_us.unwrap_or(u32::MAX));
        if age_us.is_some_and(|age_us| u64::from(age_us) > YOUNG_US) {
            self.put(block.status, code(Status::Stale));
            self.put(block.trustworthy, 0);
        }
    }

    /// Shows what the grip bears, if that is known.
    pub fn show_margin(&mut self, margin: Option<&GripMargin>) {
        self.put(MARGIN_KNOWN, u8::from(margin.is_some()));
        let Some(margin) = margin else {
            return;
        };
        self.put(MARGIN, scaled(margin.least, 1e3) as u32);
        self.put(MARGIN_DIRECTION, scaled(margin.direction, 1e6));
        self.put(MARGIN_ACROSS, scaled(margin.across, 1e3) as u32);
        self.put(MARGIN_COUPLE, scaled(margin.couple, 1e3) as u32);
        self.put(MARGIN_SLIPS, margin.slips.unwrap_or(NO_FINGER));
        self.put(MARGIN_AGE, margin.age);
    }

    /// Shows how a finger's servo is found and read.
    pub fn set_finger(&mut self, finger: usize, settings: &FingerSettings) {
        let Some(block) = FINGER.get(finger) else {
            return;
        };
        self.put(block.servo_id, settings.servo_id);
        self.put(block.reversed, u8::from(settings.reversed));
        self.put(block.gear_ratio, scaled(settings.gear_ratio, GEAR_SCALE) as u32);
        self.put(block.zero, scaled(settings.zero, ZERO_SCALE));
    }

    /// Shows what a finger grasps.
    pub fn set_object(&mut self, finger: usize, object: Option<&ObjectDesign>) {
        let Some(block) = FINGER.get(finger) else {
            return;
        };
        match object {
            Some(&ObjectDesign::Circle { centre, radius }) => {
                self.put(block.object_shape, 1);
                for (register, value) in block.object_centre.into_iter().zip(centre) {
                    self.put(register, scaled(value as f32, OBJECT_SCALE));
                }
                self.put(block.object_radius, scaled(radius as f32, OBJECT_SCALE) as u32);
            }
            Some(_) => self.put(block.object_shape, 2),
            None => self.put(block.object_shape, 0),
        }
    }

    /// What has been changed through the bus and not been taken: one thing at a time. To be asked when the answer to the
    /// write has been sent.
    pub fn take(&mut self) -> Option<Change> {
        if core::mem::take(&mut self.reboot) {
            return Some(Change::Reboot);
        }
        if core::mem::take(&mut self.bus_changed) {
            let baud_rate = xm430::bits_per_second(self.get(BAUD_RATE)).unwrap_or(57_600);
            let bus = BusSettings { id: self.id(), baud_rate, return_delay: self.get(RETURN_DELAY_TIME) };
            return Some(Change::Bus(bus));
        }
        if let Some(finger) = first(&mut self.fingers_changed) {
            let block = FINGER.get(finger)?;
            let settings = FingerSettings {
                servo_id: self.get(block.servo_id),
                reversed: self.get(block.reversed) != 0,
                gear_ratio: self.get(block.gear_ratio) as f32 / GEAR_SCALE,
                zero: self.get(block.zero) as f32 / ZERO_SCALE,
            };
            return Some(Change::Finger(finger, settings));
        }
        let finger = first(&mut self.objects_changed)?;
        let block = FINGER.get(finger)?;
        Some(Change::Object(finger, circle(block, |item| self.number(item))))
    }

    fn get<T: Value>(&self, register: Register<T>) -> T {
        let from = usize::from(register.address());
        let mut bytes = [0; 4];
        let stored = self.memory.get(from..from + usize::from(T::LENGTH)).unwrap_or_default();
        bytes.iter_mut().zip(stored).for_each(|(to, byte)| *to = *byte);
        T::from_bytes(bytes)
    }

    fn put<T: Value>(&mut self, register: Register<T>, value: T) {
        let from = usize::from(register.address());
        if let Some(place) = self.memory.get_mut(from..from + usize::from(T::LENGTH)) {
            place.iter_mut().zip(value.to_bytes()).for_each(|(to, byte)| *to = byte);
        }
    }

    fn number(&self, item: Item) -> i64 {
        let from = usize::from(item.address);
        self.memory.get(from..from + usize::from(item.length)).and_then(|bytes| item.decode(bytes)).unwrap_or(0)
    }

    /// Where the blocks of the gripper's own fingers end.
    fn end(&self) -> usize {
        usize::from(FIRST_BLOCK) + usize::from(self.get(FINGERS)) * usize::from(BLOCK)
    }

    /// Nobody else on the bus may have the address of the gripper or of a finger's servo.
    fn addresses_differ(&self, after: &impl Fn(Item) -> i64) -> bool {
        let fingers = usize::from(self.get(FINGERS));
        let address = |place: usize| match place.checked_sub(1) {
            None => Some(after(ID.item)),
            Some(finger) => FINGER.get(finger).map(|block| after(block.servo_id.item)),
        };
        (0..=fingers).all(|one| (0..one).all(|other| address(one) != address(other)))
    }
}

impl ControlTable for DeviceTable {
    fn id(&self) -> Id {
        Id::new(self.get(ID)).unwrap_or(Id::MAX)
    }

    fn model_number(&self) -> u16 {
        self.get(MODEL_NUMBER)
    }

    fn firmware_version(&self) -> u8 {
        self.get(FIRMWARE_VERSION)
    }

    fn alert(&self) -> bool {
        self.get(HARDWARE_ERROR_STATUS) != 0
    }

    fn status_return(&self) -> StatusReturn {
        StatusReturn::from_value(self.get(STATUS_RETURN_LEVEL)).unwrap_or_default()
    }

    fn return_delay_us(&self) -> u32 {
        u32::from(self.get(RETURN_DELAY_TIME)) * xm430::RETURN_DELAY_US_PER_UNIT
    }

    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        check_read(&ITEMS, address, bytes.len())?;
        let from = usize::from(address);
        let stored = self.memory.get(from..from + bytes.len()).filter(|_| from + bytes.len() <= self.end());
        bytes.copy_from_slice(stored.ok_or(StatusError::Access)?);
        Ok(())
    }

    fn check(&self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        if usize::from(address) + bytes.len() > self.end() {
            return Err(StatusError::Access);
        }
        writes(&ITEMS, false, address, bytes).try_for_each(|part| part.map(|_| ()))?;
        let written = |item: Item| {
            let part = writes(&ITEMS, false, address, bytes).flatten().find(|part| part.item == item);
            part.map(|part| part.value)
        };
        let after = |item: Item| written(item).unwrap_or_else(|| self.number(item));
        let baud_rate = xm430::bits_per_second(after(BAUD_RATE.item) as u8).unwrap_or(57_600);
        if !return_delay::is_kept(after(RETURN_DELAY_TIME.item) as u8, baud_rate, self.answer_us) {
            return Err(StatusError::DataRange);
        }
        let objects = FINGER.iter().filter(|block| describes_object(block, |item| written(item).is_some()));
        for block in objects {
            let object = circle(block, after);
            // A radius that was never set is 0: the object is not described before it is.
            if after(block.object_radius.item) > 0 && object.validate().is_err() {
                return Err(StatusError::DataLimit);
            }
        }
        if self.addresses_differ(&after) { Ok(()) } else { Err(StatusError::DataLimit) }
    }

    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        self.check(address, bytes)?;
        let from = usize::from(address);
        self.memory.get_mut(from..from + bytes.len()).ok_or(StatusError::Access)?.copy_from_slice(bytes);
        let touched = |item: Item| usize::from(item.address) >= from && usize::from(item.address) < from + bytes.len();
        self.bus_changed |= [ID.item, BAUD_RATE.item, RETURN_DELAY_TIME.item].into_iter().any(touched);
        for (finger, block) in FINGER.iter().enumerate() {
            let settings = [block.servo_id.item, block.reversed.item, block.gear_ratio.item, block.zero.item];
            if settings.into_iter().any(touched) {
                self.fingers_changed |= 1 << finger;
            }
            if describes_object(block, touched) && self.get(block.object_radius) > 0 {
                self.put(block.object_shape, 1);
                self.objects_changed |= 1 << finger;
            }
        }
        Ok(())
    }

    fn registered(&mut self, waiting: bool) {
        self.put(REGISTERED_INSTRUCTION, u8::from(waiting));
    }

    fn reboot(&mut self) -> Result<(), StatusError> {
        self.reboot = true;
        Ok(())
    }
}

/// Whether any register of a circle is among these.
fn describes_object(block: &FingerBlock, among: impl Fn(Item) -> bool) -> bool {
    let [x, y] = block.object_centre;
    [x.item, y.item, block.object_radius.item].into_iter().any(among)
}

/// The circle that these numbers describe.
fn circle(block: &FingerBlock, number: impl Fn(Item) -> i64) -> ObjectDesign {
    let millimetres = |item| number(item) as f64 / 1e3;
    let [x, y] = block.object_centre;
    ObjectDesign::Circle {
        centre: [millimetres(x.item), millimetres(y.item)],
        radius: millimetres(block.object_radius.item),
    }
}

/// What a circle of the table makes of an object: of one that was a circle, what still shows as it did keeps its digits.
pub(crate) fn put_circle(table: ObjectDesign, object: Option<&ObjectDesign>) -> ObjectDesign {
    let (
        ObjectDesign::Circle { centre: [x, y], radius },
        Some(&ObjectDesign::Circle { centre: [u, v], radius: other }),
    ) = (&table, object)
    else {
        return table;
    };
    let [x, y, radius] = [(*x, u), (*y, v), (*radius, other)].map(|(now, before)| {
        // The table's numbers are whole µm of single precision.
        let is_same = scaled(now as f32, OBJECT_SCALE) == scaled(before as f32, OBJECT_SCALE);
        if is_same { before } else { now }
    });
    ObjectDesign::Circle { centre: [x, y], radius }
}

/// A number of the table: the one before, if the table shows that so.
fn changed(now: f32, before: f32, scale: f32) -> f32 {
    if now == scaled(before, scale) as f32 / scale { before } else { now }
}

/// The lowest bit that is set, which is cleared.
fn first(bits: &mut u8) -> Option<usize> {
    let place = bits.trailing_zeros();
    *bits &= !(1u8.checked_shl(place)?);
    Some(place as usize)
}

/// The nearest whole number of units; what does not fit becomes the greatest, what is not a number becomes 0.
fn scaled(value: f32, per_unit: f32) -> i32 {
    let value = value * per_unit;
    (if value < 0.0 { value - 0.5 } else { value + 0.5 }) as i32
}

/// The number of a status in the table.
const fn code(status: Status) -> u8 {
    match status {
        Status::Converged => 0,
        Status::Tracking => 1,
        Status::NoContact => 2,
        Status::Snapped => 3,
        Status::MaxIterations => 4,
        Status::Stagnated => 5,
        Status::Folded => 6,
        Status::ContactCapacity => 7,
        Status::OutOfRange => 8,
        Status::Stale => 9,
        Status::Precision => 10,
        Status::Unsettled => 11,
        Status::Updating => 12,
    }
}
