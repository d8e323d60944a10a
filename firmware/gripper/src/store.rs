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
use heapless::Vec;
use messages::{Finger, Object, Settings};
use model_core::size::Lists;
use model_core::uncertainty::Uncertainty;
use postcard_rpc::postcard;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::quiet::Quiet;
use crate::setup::{Key, Place, Setup};
use blocking::Blocking;
use seal::Digests;

/// Version of the records' layout. A change of [`Settings`], [`Finger`], [`Object`] or [`Uncertainty`] needs another.
const VERSION: u8 = 12;
/// The first version that is read as well: every value had another layout.
const EARLIEST: u8 = 3;
/// Longest record, version and key included, in words of any flash (32 bytes at most): a finger's.
const RECORD: usize = record_bytes(Lists::HERE);

/// Longest record where descriptions have such lists.
const fn record_bytes(lists: Lists) -> usize {
    (Finger::bytes(lists) + 2).next_multiple_of(32)
}

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
    /// A store in a place where there is none yet.
    // Its buffers are on the stack in here only: a value that is returned lies on the caller's as well.
    #[inline(never)]
    pub(crate) fn begun(place: &mut Vec<Self, 1>, flash: F) -> Option<&mut Self> {
        // There is room for one.
        let _ = place.push(Self::new(flash));
        place.first_mut()
    }

    fn new(flash: F) -> Self {
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
    pub(crate) async fn restore(&mut self, place: &mut impl Place) -> Found {
        // Once to see whether it can be trusted, and again to take it: there is no room for a second setup.
        let mut found = self.read_all(None::<&mut Setup>).await;
        if found.damaged == 0 && !self.is_sealed().await {
            found.damaged = 1;
        }
        self.is_void = found.damaged > 0;
        if self.is_void {
            found.records = 0;
        } else {
            let again = self.read_all(Some(place)).await;
            debug_assert_eq!(again.records, found.records);
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

    /// Reads every record, and takes them to a place, if there is one.
    async fn read_all<P: Place>(&mut self, mut place: Option<&mut P>) -> Found {
        let mut found = Found::default();
        self.digests = Digests::default();
        for key in Key::all() {
            let mut taken = Ok(false);
            if let Some(record) = self.fetch(key, &mut found).await {
                taken = take(key, record, place.as_deref_mut());
            }
            match taken {
                Ok(true) => found.records += 1,
                Ok(false) => {}
                Err(Damaged) => found.damaged += 1,
            }
        }
        found
    }

    /// Keeps one record of what is set, unless it is kept already.
    pub(crate) async fn keep(&mut self, key: Key, place: &impl Place) -> Result<(), NotKept> {
        let length = encode(key, place, &mut self.record)?;
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
            let length = encode(key, place, &mut self.record)?;
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

    /// The bytes of a record, if there is one.
    async fn fetch(&mut self, key: Key, found: &mut Found) -> Option<&[u8]> {
        match self.map.as_mut()?.fetch_item::<&[u8]>(&mut self.buffer, &key.number()).await {
            Ok(Some(record)) => {
                self.digests = self.digests.with(key, record);
                self.is_current |= record.first() == Some(&VERSION);
                Some(record)
            }
            Ok(None) => None,
            Err(_) => {
                found.damaged += 1;
                None
            }
        }
    }
}

/// A record is of no known version, or its bytes are no value.
struct Damaged;

/// Takes a record to its place, if there is one.
// One value at a time is on the stack, in the function that it is read in.
#[inline(never)]
fn take<P: Place>(key: Key, record: &[u8], place: Option<&mut P>) -> Result<bool, Damaged> {
    #[inline(never)]
    fn one<T: DeserializeOwned, P: Place>(
        record: &[u8],
        earlier: fn(u8, &[u8]) -> Option<T>,
        place: Option<&mut P>,
        put: impl FnOnce(&mut Setup, T),
    ) -> Result<bool, Damaged> {
        let value = match record.split_first() {
            Some((&VERSION, rest)) => same(rest),
            Some((&version @ EARLIEST..VERSION, rest)) => earlier(version, rest),
            _ => None,
        };
        let value = value.ok_or(Damaged)?;
        if let Some(place) = place {
            place.change(|setup| put(setup, value));
        }
        Ok(true)
    }
    fn at<T>(list: &mut [T], finger: u8, value: T) {
        if let Some(place) = list.get_mut(usize::from(finger)) {
            *place = value;
        }
    }
    match key {
        Key::Settings => {
            one::<Settings, P>(record, earlier::settings, place, |setup, settings| setup.settings = settings)
        }
        Key::Finger(finger) => one::<Option<Finger>, P>(record, earlier::finger, place, |setup, design| {
            at(&mut setup.fingers, finger, design);
        }),
        Key::Object(finger) => one::<Option<Object>, P>(record, earlier::object, place, |setup, object| {
            at(&mut setup.objects, finger, object);
        }),
        Key::Uncertainty(finger) => {
            one::<Option<Uncertainty>, P>(record, earlier::uncertainty, place, |setup, given| {
                at(&mut setup.uncertainties, finger, given);
            })
        }
    }
}

/// A value of this version's layout.
fn same<T: DeserializeOwned>(bytes: &[u8]) -> Option<T> {
    postcard::from_bytes(bytes).ok()
}

/// Encodes one record; gives its length.
fn encode(key: Key, place: &impl Place, record: &mut [u8]) -> Result<usize, NotKept> {
    // A copy of the one value: encoding it takes longer than the place may be held.
    #[inline(never)]
    fn put<T: Serialize>(value: Option<&T>, into: &mut [u8]) -> Result<usize, NotKept> {
        let value = value.ok_or(NotKept)?;
        postcard::to_slice(value, into).map(|used| used.len()).map_err(|_| NotKept)
    }
    let (version, rest) = record.split_first_mut().ok_or(NotKept)?;
    *version = VERSION;
    let length = match key {
        Key::Settings => put(Some(&place.look(|setup| setup.settings)), rest)?,
        Key::Finger(finger) => put(place.look(|setup| setup.fingers.get(usize::from(finger)).cloned()).as_ref(), rest)?,
        Key::Object(finger) => put(place.look(|setup| setup.objects.get(usize::from(finger)).copied()).as_ref(), rest)?,
        Key::Uncertainty(finger) => {
            put(place.look(|setup| setup.uncertainties.get(usize::from(finger)).copied()).as_ref(), rest)?
        }
    };
    Ok(1 + length)
}
