//! What survives the loss of power: settings, designs, objects and what a calibration left uncertain, each a record of its own in flash.
//!
//! [`sequential_storage`] keeps several generations of every record, each with a CRC, and takes a write that was cut short
//! for none: until the new record is whole, the old one counts. A record begins with the version of its layout. If one is of an unknown
//! version, damaged, or not of the others' generation, none of them counts, which is reported: a gripper without settings is idle.

mod blocking;
mod earlier;
mod seal;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod torn;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use messages::{FINGERS, Finger, Object, Settings};
use model_core::uncertainty::Uncertainty;
use postcard_rpc::postcard;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::quiet::Quiet;
use crate::setup::{Key, Setup};
use blocking::Blocking;
use seal::Digests;

/// Version of the records' layout. A change of [`Settings`], [`Finger`], [`Object`] or [`Uncertainty`] needs another.
const VERSION: u8 = 11;
/// The first version that is read as well: settings, fingers and objects had another layout, uncertainties the same.
const EARLIEST: u8 = 3;
/// Longest record, version and key included, in words of any flash (32 bytes at most).
const RECORD: usize = 1088;
/// Number of the seal in flash.
const SEAL: u8 = 0x40;

/// What was found at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Found {
    pub(crate) records: u8,
    pub(crate) damaged: u8,
}

/// The flash does not take it, or what was asked does not fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NotKept;

type Map<F> = MapStorage<u8, Blocking<F>, Cache<Uncached, Uncached, Uncached, u8>>;

/// The records. None: the flash is too small or of a strange make.
pub(crate) struct Store<F: NorFlash> {
    map: Option<Map<F>>,
    record: [u8; RECORD],
    buffer: [u8; RECORD],
    /// Of what is in flash.
    digests: Digests,
    /// A record of this version was read.
    is_current: bool,
    /// What is in flash does not count: it is erased before anything is kept.
    is_void: bool,
    /// Records ever written, as far as the flash knows.
    writes: u32,
}

impl<F: NorFlash> Store<F> {
    pub(crate) fn new(flash: F) -> Self {
        let flash = Blocking { flash, quiet: None };
        let all = 0..u32::try_from(ReadNorFlash::capacity(&flash.flash)).unwrap_or(0);
        let config = MapConfig::try_new(all).ok();
        let map = config.map(|config| MapStorage::new(flash, config, Cache::new_uncached()));
        Self {
            map,
            record: [0; RECORD],
            buffer: [0; RECORD],
            digests: Digests::default(),
            is_current: false,
            is_void: false,
            writes: 0,
        }
    }

    /// Writes in moments without a transaction only: the flash holds the processor.
    pub(crate) fn wait_for(&mut self, quiet: &'static Quiet) {
        if let Some(map) = &mut self.map {
            map.flash().quiet = Some(quiet);
        }
    }

    /// Reads everything; what is absent stays as it is, and everything does if a part of it cannot be trusted.
    pub(crate) async fn restore(&mut self, setup: &mut Setup) -> Found {
        let mut kept = setup.clone();
        let mut found = self.read_all(&mut kept).await;
        if found.damaged == 0 && !self.is_sealed().await {
            found.damaged = 1;
        }
        self.is_void = found.damaged > 0;
        if self.is_void {
            found.records = 0;
        } else {
            *setup = kept;
        }
        found
    }

    /// Records that were ever written to this flash.
    pub(crate) fn writes(&self) -> u32 {
        self.writes
    }

    /// Whether all records are of one generation. (Versions before the fifth had no seal.)
    async fn is_sealed(&mut self) -> bool {
        let Some(map) = self.map.as_mut() else { return true };
        match map.fetch_item::<&[u8]>(&mut self.buffer, &SEAL).await {
            Ok(Some(seal)) => {
                self.writes = self.writes.max(Digests::writes(seal));
                self.digests.are_sealed_by(seal)
            }
            Ok(None) => !self.is_current,
            Err(_) => false,
        }
    }

    async fn read_all(&mut self, setup: &mut Setup) -> Found {
        let mut found = Found::default();
        if let Some(settings) = self.read::<Settings>(Key::Settings, earlier::settings, &mut found).await {
            setup.settings = settings;
        }
        for finger in 0..FINGERS as u8 {
            let design = self.read::<Option<Finger>>(Key::Finger(finger), earlier::finger, &mut found).await;
            let object = self.read::<Option<Object>>(Key::Object(finger), earlier::object, &mut found).await;
            let uncertainty = self.read::<Option<Uncertainty>>(Key::Uncertainty(finger), unchanged, &mut found).await;
            if let (Some(place), Some(uncertainty)) = (setup.uncertainties.get_mut(usize::from(finger)), uncertainty) {
                *place = uncertainty;
            }
            if let (Some(place), Some(design)) = (setup.fingers.get_mut(usize::from(finger)), design) {
                *place = design;
            }
            if let (Some(place), Some(object)) = (setup.objects.get_mut(usize::from(finger)), object) {
                *place = object;
            }
        }
        found
    }

    /// Keeps one record of what is set, unless it is kept already.
    pub(crate) async fn keep(&mut self, key: Key, setup: &Setup) -> Result<(), NotKept> {
        let length = encode(key, setup, &mut self.record)?;
        if !self.is_void && self.write(key, length).await.is_ok() {
            return Ok(());
        }
        // The flash holds something that cannot be repaired: everything is written anew.
        let Some(map) = &mut self.map else {
            return Err(NotKept);
        };
        map.erase_all().await.map_err(|_| NotKept)?;
        (self.digests, self.is_void) = (Digests::default(), false);
        for key in Key::all() {
            let length = encode(key, setup, &mut self.record)?;
            self.write(key, length).await?;
        }
        Ok(())
    }

    async fn write(&mut self, key: Key, length: usize) -> Result<(), NotKept> {
        let (Some(map), Some(record)) = (&mut self.map, self.record.get(..length)) else {
            return Err(NotKept);
        };
        let number = key.number();
        if let Ok(Some(kept)) = map.fetch_item::<&[u8]>(&mut self.buffer, &number).await
            && kept == record
        {
            return Ok(());
        }
        let next = self.digests.with(key, record);
        self.writes = self.writes.saturating_add(1);
        let seal = self.digests.seal(&next, self.writes);
        map.store_item::<&[u8]>(&mut self.buffer, &SEAL, &&seal[..]).await.map_err(|_| NotKept)?;
        map.store_item::<&[u8]>(&mut self.buffer, &number, &record).await.map_err(|_| NotKept)?;
        (self.digests, self.is_current) = (next, true);
        // A flash that is damaged where it should be erased takes a write and gives something else.
        if self.reads_back().await { Ok(()) } else { Err(NotKept) }
    }

    /// Whether the flash gives what is taken to be in it, all of it and sealed: the next start finds it so.
    async fn reads_back(&mut self) -> bool {
        let mut digests = Digests::default();
        for key in Key::all() {
            let Some(map) = self.map.as_mut() else { return false };
            match map.fetch_item::<&[u8]>(&mut self.buffer, &key.number()).await {
                Ok(Some(record)) => digests = digests.with(key, record),
                Ok(None) => {}
                Err(_) => return false,
            }
        }
        digests == self.digests && self.is_sealed().await
    }

    /// Reads a record; `earlier` reads one of an earlier version.
    async fn read<T: DeserializeOwned>(
        &mut self,
        key: Key,
        earlier: fn(u8, &[u8]) -> Option<T>,
        found: &mut Found,
    ) -> Option<T> {
        let record = match self.map.as_mut()?.fetch_item::<&[u8]>(&mut self.buffer, &key.number()).await {
            Ok(Some(record)) => record,
            Ok(None) => return None,
            Err(_) => {
                found.damaged += 1;
                return None;
            }
        };
        self.digests = self.digests.with(key, record);
        self.is_current |= record.first() == Some(&VERSION);
        let value = match record.split_first() {
            Some((&VERSION, rest)) => same(rest),
            Some((&version @ EARLIEST..VERSION, rest)) => earlier(version, rest),
            _ => None,
        };
        if value.is_some() {
            found.records += 1
        } else {
            found.damaged += 1
        }
        value
    }
}

/// A value of this version's layout.
fn same<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

/// A value whose layout no version has changed.
fn unchanged<T: DeserializeOwned>(_: u8, bytes: &[u8]) -> Option<T> {
    same(bytes)
}

/// Encodes one record; gives its length.
fn encode(key: Key, setup: &Setup, record: &mut [u8]) -> Result<usize, NotKept> {
    fn put<T: Serialize>(value: &T, into: &mut [u8]) -> Result<usize, NotKept> {
        postcard::to_slice(value, into).map(|used| used.len()).map_err(|_| NotKept)
    }
    let (version, rest) = record.split_first_mut().ok_or(NotKept)?;
    *version = VERSION;
    let length = match key {
        Key::Settings => put(&setup.settings, rest)?,
        Key::Finger(finger) => put(setup.fingers.get(usize::from(finger)).ok_or(NotKept)?, rest)?,
        Key::Object(finger) => put(setup.objects.get(usize::from(finger)).ok_or(NotKept)?, rest)?,
        Key::Uncertainty(finger) => put(setup.uncertainties.get(usize::from(finger)).ok_or(NotKept)?, rest)?,
    };
    Ok(1 + length)
}
