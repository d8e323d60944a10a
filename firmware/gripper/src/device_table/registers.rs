//! The registers of the gripper's control table, with their addresses.

use dynamixel::{Area, Item, Register};

use Area::{Eeprom, Ram};

/// Fingers that the table has a block for.
pub const BLOCKS: usize = 4;
/// Address of the first finger's block.
pub const FIRST_BLOCK: u16 = 128;
/// Addresses from one finger's block to the next.
pub const BLOCK: u16 = 96;
/// Bytes of the table.
pub const LENGTH: usize = FIRST_BLOCK as usize + BLOCKS * BLOCK as usize;

/// What [`MODEL_NUMBER`] reads: "FR".
pub const MODEL: u16 = u16::from_le_bytes(*b"FR");
/// What [`TABLE_VERSION`] reads: the version of this table.
pub const VERSION: u32 = 2;

/// Which device this is.
pub const MODEL_NUMBER: Register<u16> = Register::read(0, false, Eeprom, MODEL as i64);
/// Version of the table's layout.
pub const TABLE_VERSION: Register<u32> = Register::read(2, false, Eeprom, VERSION as i64);
/// Version of the gripper's firmware.
pub const FIRMWARE_VERSION: Register<u8> = Register::read(6, false, Eeprom, 1);
/// Address on the bus; not that of a finger's servo.
pub const ID: Register<u8> = Register::write(7, false, Eeprom, 100, 0, 252);
/// Speed of the bus, as a code: [`dynamixel::xm430::bits_per_second`], 57,600 to 4.5 M.
pub const BAUD_RATE: Register<u8> = Register::write(8, false, Eeprom, 1, 1, 7);
/// Time between an instruction's end and the answer, 2 µs.
pub const RETURN_DELAY_TIME: Register<u8> = Register::write(9, false, Eeprom, 0, 0, 254);
/// How many fingers the gripper has: so many blocks mean something.
pub const FINGERS: Register<u8> = Register::read(10, false, Eeprom, 0);
/// Protocol of the bus.
pub const PROTOCOL_TYPE: Register<u8> = Register::read(13, false, Eeprom, 2);
/// Which instructions are answered: 0 Ping, 1 and reading ones, 2 all.
pub const STATUS_RETURN_LEVEL: Register<u8> = Register::write(68, false, Ram, 2, 0, 2);
/// 1 while a Reg Write waits for its Action.
pub const REGISTERED_INSTRUCTION: Register<u8> = Register::read(69, false, Ram, 0);
/// Bit k: the servo of finger k reports a hardware error. Not 0: every answer has the alert bit.
pub const HARDWARE_ERROR_STATUS: Register<u8> = Register::read(70, false, Ram, 0);

/// What the grip bears before the object slips: force in the weakest direction in the fingers' plane, mN.
pub const MARGIN: Register<u32> = Register::read(72, false, Ram, 0);
/// That direction, gripper frame, µrad from x, counter-clockwise.
pub const MARGIN_DIRECTION: Register<i32> = Register::read(76, true, Ram, 0);
/// Force across the plane, mN.
pub const MARGIN_ACROSS: Register<u32> = Register::read(80, false, Ram, 0);
/// Couple, the weaker one of both ways, mN·mm.
pub const MARGIN_COUPLE: Register<u32> = Register::read(84, false, Ram, 0);
/// The finger that slips first, from 0; 255: none.
pub const MARGIN_SLIPS: Register<u8> = Register::read(88, false, Ram, NO_FINGER as i64);
/// 1 if what the grip bears is known.
pub const MARGIN_KNOWN: Register<u8> = Register::read(89, false, Ram, 0);
/// Ticks since the contact forces behind it were estimated.
pub const MARGIN_AGE: Register<u16> = Register::read(90, false, Ram, 0);

/// What [`MARGIN_SLIPS`] reads without a finger.
pub const NO_FINGER: u8 = 255;

/// The registers of one finger.
#[derive(Clone, Copy, Debug)]
pub struct FingerBlock {
    /// Force of the finger on the object, world frame, mN.
    pub force: [Register<i32>; 2],
    /// Magnitude of that force, mN.
    pub magnitude: Register<u32>,
    /// Centre of the contact, world frame, µm; 0 without contact.
    pub contact_centre: [Register<i32>; 2],
    /// Torque that the contact demands of the motor, mN·mm; positive when it must push to close.
    pub torque: Register<i32>,
    /// Status of the numbers above: 0 converged, 1 tracking, 2 no-contact, 3 snapped (up to here they may be used),
    /// 4 max-iterations, 5 stagnated, 6 folded, 7 contact-capacity, 8 out-of-range, 9 stale,
    /// 10 precision, 11 unsettled, 12 updating.
    pub status: Register<u8>,
    /// 1 if the numbers may be used.
    pub trustworthy: Register<u8>,
    /// Present Current of the servo, mA.
    pub current: Register<i16>,
    /// Time since the servo's position that the numbers belong to, µs; the greatest number if there was none.
    pub age: Register<u32>,
    /// Motor angle, µrad.
    pub motor_angle: Register<i32>,
    /// Position of the servo, counts.
    pub position: Register<i32>,
    /// Address of the finger's servo; no two fingers, nor the gripper itself, share one.
    pub servo_id: Register<u8>,
    /// 1 if counts fall as the finger closes.
    pub reversed: Register<u8>,
    /// Revolutions of the servo per revolution of the finger, thousandths.
    pub gear_ratio: Register<u32>,
    /// Position of the servo at motor angle 0, hundredths of a count.
    pub zero: Register<i32>,
    /// Shape of the object: 0 none, 1 circle, 2 one that this table cannot describe. To make it a circle write centre and
    /// radius, in one write if they belong together.
    pub object_shape: Register<u8>,
    /// Centre of the circle, world frame, µm.
    pub object_centre: [Register<i32>; 2],
    /// Radius of the circle, µm.
    pub object_radius: Register<u32>,
}

/// Registers in a [`FingerBlock`].
const PER_BLOCK: usize = 20;

impl FingerBlock {
    /// The registers of finger `number`, from 0.
    pub const fn of(number: usize) -> Self {
        let at = FIRST_BLOCK + BLOCK * number as u16;
        let far = 10_000_000;
        Self {
            force: [Register::read(at, true, Ram, 0), Register::read(at + 4, true, Ram, 0)],
            magnitude: Register::read(at + 8, false, Ram, 0),
            contact_centre: [Register::read(at + 12, true, Ram, 0), Register::read(at + 16, true, Ram, 0)],
            torque: Register::read(at + 20, true, Ram, 0),
            status: Register::read(at + 24, false, Ram, 9),
            trustworthy: Register::read(at + 25, false, Ram, 0),
            current: Register::read(at + 26, true, Ram, 0),
            age: Register::read(at + 28, false, Ram, u32::MAX as i64),
            motor_angle: Register::read(at + 32, true, Ram, 0),
            position: Register::read(at + 36, true, Ram, 0),
            servo_id: Register::write(at + 40, false, Eeprom, 1 + number as i64, 0, 252),
            reversed: Register::write(at + 41, false, Eeprom, 0, 0, 1),
            gear_ratio: Register::write(at + 44, false, Eeprom, 1000, 10, 100_000),
            zero: Register::write(at + 48, true, Eeprom, 204_800, -104_447_900, 104_447_900),
            object_shape: Register::read(at + 64, false, Eeprom, 0),
            object_centre: [
                Register::write(at + 68, true, Eeprom, 0, -far, far),
                Register::write(at + 72, true, Eeprom, 0, -far, far),
            ],
            object_radius: Register::write(at + 76, false, Eeprom, 0, 1, far),
        }
    }

    const fn items(&self) -> [Item; PER_BLOCK] {
        let [force_x, force_y] = self.force;
        let [centre_x, centre_y] = self.contact_centre;
        let [object_x, object_y] = self.object_centre;
        [
            force_x.item,
            force_y.item,
            self.magnitude.item,
            centre_x.item,
            centre_y.item,
            self.torque.item,
            self.status.item,
            self.trustworthy.item,
            self.current.item,
            self.age.item,
            self.motor_angle.item,
            self.position.item,
            self.servo_id.item,
            self.reversed.item,
            self.gear_ratio.item,
            self.zero.item,
            self.object_shape.item,
            object_x.item,
            object_y.item,
            self.object_radius.item,
        ]
    }
}

/// Registers before the fingers' blocks.
const HEAD: [Item; 18] = [
    MODEL_NUMBER.item,
    TABLE_VERSION.item,
    FIRMWARE_VERSION.item,
    ID.item,
    BAUD_RATE.item,
    RETURN_DELAY_TIME.item,
    FINGERS.item,
    PROTOCOL_TYPE.item,
    STATUS_RETURN_LEVEL.item,
    REGISTERED_INSTRUCTION.item,
    HARDWARE_ERROR_STATUS.item,
    MARGIN.item,
    MARGIN_DIRECTION.item,
    MARGIN_ACROSS.item,
    MARGIN_COUPLE.item,
    MARGIN_SLIPS.item,
    MARGIN_KNOWN.item,
    MARGIN_AGE.item,
];

/// Every item, in the order of the addresses.
// Computed by the compiler: an index outside would be its error.
#[allow(clippy::indexing_slicing)]
pub static ITEMS: [Item; HEAD.len() + BLOCKS * PER_BLOCK] = {
    let mut items = [HEAD[0]; HEAD.len() + BLOCKS * PER_BLOCK];
    let mut place = 0;
    while place < items.len() {
        items[place] = if place < HEAD.len() {
            HEAD[place]
        } else {
            let place = place - HEAD.len();
            FingerBlock::of(place / PER_BLOCK).items()[place % PER_BLOCK]
        };
        place += 1;
    }
    items
};
