//! A control table with the items of the XM430-W350 and no motor: what is written can be read.

use dynamixel::{
    Backup, ControlTable, Id, Register, ResetScope, StatusError, StatusReturn, Value, check_read, writes, xm430,
};

/// The table, byte by byte.
#[derive(Clone)]
pub struct Servo {
    pub memory: [u8; 148],
    pub reads: u32,
    pub reboots: u32,
    pub clears: u32,
    pub resets: Vec<ResetScope>,
    pub backups: Vec<Backup>,
}

impl Servo {
    pub fn new(id: u8) -> Self {
        let mut servo =
            Servo { memory: [0; 148], reads: 0, reboots: 0, clears: 0, resets: Vec::new(), backups: Vec::new() };
        for item in xm430::ITEMS {
            let bytes = item.default.to_le_bytes();
            let (from, length) = (usize::from(item.address), usize::from(item.length));
            servo.memory[from..from + length].copy_from_slice(&bytes[..length]);
        }
        servo.put(xm430::ID, id);
        servo.put(xm430::FIRMWARE_VERSION, 45);
        servo.put(xm430::RETURN_DELAY_TIME, 0);
        servo
    }

    pub fn put<T: Value>(&mut self, register: Register<T>, value: T) {
        let from = usize::from(register.address());
        let length = usize::from(T::LENGTH);
        self.memory[from..from + length].copy_from_slice(&value.to_bytes()[..length]);
    }

    pub fn value<T: Value>(&self, register: Register<T>) -> T {
        let from = usize::from(register.address());
        let mut bytes = [0; 4];
        bytes[..usize::from(T::LENGTH)].copy_from_slice(&self.memory[from..from + usize::from(T::LENGTH)]);
        T::from_bytes(bytes)
    }
}

impl ControlTable for Servo {
    fn id(&self) -> Id {
        Id::new(self.value(xm430::ID)).unwrap()
    }

    fn model_number(&self) -> u16 {
        self.value(xm430::MODEL_NUMBER)
    }

    fn firmware_version(&self) -> u8 {
        self.value(xm430::FIRMWARE_VERSION)
    }

    fn alert(&self) -> bool {
        self.value(xm430::HARDWARE_ERROR_STATUS) != 0
    }

    fn status_return(&self) -> StatusReturn {
        StatusReturn::from_value(self.value(xm430::STATUS_RETURN_LEVEL)).unwrap()
    }

    fn return_delay_us(&self) -> u32 {
        u32::from(self.value(xm430::RETURN_DELAY_TIME)) * xm430::RETURN_DELAY_US_PER_UNIT
    }

    fn read(&mut self, address: u16, bytes: &mut [u8]) -> Result<(), StatusError> {
        check_read(&xm430::ITEMS, address, bytes.len())?;
        self.reads += 1;
        let from = usize::from(address);
        bytes.copy_from_slice(&self.memory[from..from + bytes.len()]);
        Ok(())
    }

    fn write(&mut self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        let locked = self.value(xm430::TORQUE_ENABLE) == 1;
        for part in writes(&xm430::ITEMS, locked, address, bytes) {
            let part = part?;
            let least = i64::from(self.value(xm430::MIN_POSITION_LIMIT));
            let greatest = i64::from(self.value(xm430::MAX_POSITION_LIMIT));
            if part.item == xm430::GOAL_POSITION.item && !(least..=greatest).contains(&part.value) {
                return Err(StatusError::DataLimit);
            }
        }
        let from = usize::from(address);
        self.memory[from..from + bytes.len()].copy_from_slice(bytes);
        Ok(())
    }

    fn registered(&mut self, waiting: bool) {
        self.put(xm430::REGISTERED_INSTRUCTION, u8::from(waiting));
    }

    fn reboot(&mut self) -> Result<(), StatusError> {
        self.reboots += 1;
        Ok(())
    }

    fn factory_reset(&mut self, scope: ResetScope) -> Result<(), StatusError> {
        self.resets.push(scope);
        Ok(())
    }

    fn clear_turns(&mut self) -> Result<(), StatusError> {
        self.clears += 1;
        Ok(())
    }

    fn check(&self, address: u16, bytes: &[u8]) -> Result<(), StatusError> {
        let locked = self.value(xm430::TORQUE_ENABLE) == 1;
        writes(&xm430::ITEMS, locked, address, bytes).try_for_each(|part| part.map(|_| ()))
    }

    fn backup(&mut self, what: Backup) -> Result<(), StatusError> {
        if self.value(xm430::TORQUE_ENABLE) == 1 {
            return Err(StatusError::ResultFail);
        }
        self.backups.push(what);
        Ok(())
    }
}
