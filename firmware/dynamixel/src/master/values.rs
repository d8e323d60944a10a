//! Reading and writing numbers.

use embedded_hal_async::delay::DelayNs;
use embedded_io_async::{Read, Write};

use super::{Answer, Error, Master};
use crate::item::{Register, Value};
use crate::packet::Id;

impl<U, D, const N: usize> Master<U, D, N>
where
    U: Read + Write,
    D: DelayNs,
{
    /// Reads a number.
    pub async fn read_value<T: Value>(&mut self, id: Id, address: u16) -> Result<Answer<T>, Error<U::Error>> {
        let mut bytes = [0; 4];
        let part = bytes.get_mut(..usize::from(T::LENGTH)).unwrap_or_default();
        let Answer { alert, .. } = self.read(id, address, part).await?;
        Ok(Answer { value: T::from_bytes(bytes), alert })
    }

    /// Writes a number.
    pub async fn write_value<T: Value>(
        &mut self,
        id: Id,
        address: u16,
        value: T,
    ) -> Result<Answer<()>, Error<U::Error>> {
        let bytes = value.to_bytes();
        self.write(id, address, bytes.get(..usize::from(T::LENGTH)).unwrap_or_default()).await
    }

    /// Reads a register, as in `master.get(id, xm430::PRESENT_POSITION)`.
    pub async fn get<T: Value>(&mut self, id: Id, register: Register<T>) -> Result<Answer<T>, Error<U::Error>> {
        self.read_value(id, register.address()).await
    }

    /// Writes a register.
    pub async fn set<T: Value>(
        &mut self,
        id: Id,
        register: Register<T>,
        value: T,
    ) -> Result<Answer<()>, Error<U::Error>> {
        self.write_value(id, register.address(), value).await
    }

    /// Reads one unsigned byte.
    pub async fn read_u8(&mut self, id: Id, address: u16) -> Result<Answer<u8>, Error<U::Error>> {
        self.read_value(id, address).await
    }

    /// Reads two bytes as an unsigned number.
    pub async fn read_u16(&mut self, id: Id, address: u16) -> Result<Answer<u16>, Error<U::Error>> {
        self.read_value(id, address).await
    }

    /// Reads four bytes as an unsigned number.
    pub async fn read_u32(&mut self, id: Id, address: u16) -> Result<Answer<u32>, Error<U::Error>> {
        self.read_value(id, address).await
    }

    /// Reads two bytes as a signed number.
    pub async fn read_i16(&mut self, id: Id, address: u16) -> Result<Answer<i16>, Error<U::Error>> {
        self.read_value(id, address).await
    }

    /// Reads four bytes as a signed number.
    pub async fn read_i32(&mut self, id: Id, address: u16) -> Result<Answer<i32>, Error<U::Error>> {
        self.read_value(id, address).await
    }
}
