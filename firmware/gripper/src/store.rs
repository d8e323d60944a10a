//! What survives the loss of power: settings, designs, objects and what a calibration left uncertain, each a record of its own in flash.
//!
//! [`sequential_storage`] keeps several generations of every record, each with a CRC, and takes a write that was cut short
//! for none: until the new record is whole, the old one counts. A record begins with the version of its layout. If one is of an unknown
//! version, damaged, or not of the others' generation, none of them counts, which is reported: a gripper without settings is idle.

mod earlier;
mod seal;
#[cfg(test)]
mod torn;

use core::future::Future;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use embedded_storage_async::nor_flash as waiting;
use messages::{FINGERS, Finger, Object, Settings};
use model_core::uncertainty::Uncertainty;
use postcard_rpc::postcard;
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::quiet::Quiet;
use crate::shared::Setup;
use seal::Digests;

/// Version of the records' layout. A change of [`Settings`], [`Finger`], [`Object`] or [`Uncertainty`] needs another.
const VERSION: u8 = 9;
/// The first version that is read as well: settings, fingers and objects had another layout, uncertainties the same.
const EARLIEST: u8 = 3;
/// Longest record, version and key included, in words of any flash (32 bytes at most).
const RECORD: usize = 1088;
/// Number of the seal in flash.
const SEAL: u8 = 0x40;

/// Which record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    Settings,
    Finger(u8),
    Object(u8),
    Uncertainty(u8),
}

impl Key {
    /// Every record; the settings, without which the gripper is idle, last.
    fn all() -> impl Iterator<Item = Self> {
        let of = |finger| [Self::Finger(finger), Self::Object(finger), Self::Uncertainty(finger)];
        (0..FINGERS as u8).flat_map(of).chain([Self::Settings])
    }

    /// Its number in flash.
    fn number(self) -> u8 {
        match self {
            Self::Settings => 0,
            Self::Finger(finger) => 0x10 + finger,
            Self::Object(finger) => 0x20 + finger,
            Self::Uncertainty(finger) => 0x30 + finger,
        }
    }
}

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

/// A flash that holds the processor until it is done, for who would wait for it.
///
/// A word whose programming or erasing lost its power cannot be read where the flash corrects errors: the board says so by an error. It
/// counts as zeros, which are part of no sound record and cannot be taken for erased.
struct Blocking<F> {
    flash: F,
    /// What a change waits for, if it holds more than the task that asks for it.
    quiet: Option<&'static Quiet>,
}

impl<F> Blocking<F> {
    async fn change<R>(&mut self, mut change: impl FnMut(&mut F) -> R) -> R {
        let flash = &mut self.flash;
        match self.quiet {
            Some(quiet) => quiet.when(|| change(flash)).await,
            None => change(flash),
        }
    }
}

impl<F: NorFlash> Blocking<F> {
    fn read_torn(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), F::Error> {
        let Err(error) = self.flash.read(offset, bytes) else { return Ok(()) };
        if error.kind() == NorFlashErrorKind::OutOfBounds || error.kind() == NorFlashErrorKind::NotAligned {
            return Err(error);
        }
        let word = F::WRITE_SIZE.max(F::READ_SIZE);
        let (mut at, mut rest) = (offset, bytes);
        while !rest.is_empty() {
            let left = (word - at as usize % word).min(rest.len());
            let Some((part, behind)) = rest.split_at_mut_checked(left) else { return Err(error) };
            if self.flash.read(at, part).is_err() {
                part.fill(0);
            }
            at += part.len() as u32;
            rest = behind;
        }
        Ok(())
    }
}

impl<F: NorFlash> ErrorType for Blocking<F> {
    type Error = F::Error;
}

impl<F: NorFlash> waiting::ReadNorFlash for Blocking<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> impl Future<Output = Result<(), F::Error>> {
        core::future::ready(self.read_torn(offset, bytes))
    }

    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl<F: NorFlash> waiting::NorFlash for Blocking<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), F::Error> {
        self.change(|flash| flash.erase(from, to)).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), F::Error> {
        self.change(|flash| flash.write(offset, bytes)).await
    }
}

#[cfg(test)]
mod tests {
    use embassy_futures::block_on;
    use embedded_storage::nor_flash::{check_erase, check_read, check_write};
    use messages::{Mount, Reaction};
    use model_core::design::{
        Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, LamellaKind, Lamellae, Material, MaterialLaw,
        PlaneStrain, Profile, Ribs,
    };
    use model_core::discretise::{Discretisation, Physics};
    use model_core::object::ObjectDesign;
    use model_core::size::Lists;

    use super::*;

    /// NOR flash that loses power after so many bytes written or erased; it stays as it is then.
    #[derive(Clone)]
    struct Flash<const WORD: usize> {
        bytes: Vec<u8>,
        left: usize,
        done: usize,
    }

    const SECTOR: usize = 2048;

    impl<const WORD: usize> Flash<WORD> {
        fn new() -> Self {
            Self { bytes: vec![0xFF; 4 * SECTOR], left: usize::MAX, done: 0 }
        }

        fn change(&mut self, at: usize, to: u8) -> Result<(), NorFlashErrorKind> {
            self.left = self.left.checked_sub(1).ok_or(NorFlashErrorKind::Other)?;
            self.done += 1;
            self.bytes[at] = to;
            Ok(())
        }
    }

    impl<const WORD: usize> ErrorType for &mut Flash<WORD> {
        type Error = NorFlashErrorKind;
    }

    impl<const WORD: usize> ReadNorFlash for &mut Flash<WORD> {
        const READ_SIZE: usize = 1;

        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
            check_read(self, offset, bytes.len())?;
            bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
            Ok(())
        }

        fn capacity(&self) -> usize {
            self.bytes.len()
        }
    }

    impl<const WORD: usize> NorFlash for &mut Flash<WORD> {
        const WRITE_SIZE: usize = WORD;
        const ERASE_SIZE: usize = SECTOR;

        fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
            check_erase(self, from, to)?;
            (from as usize..to as usize).try_for_each(|at| self.change(at, 0xFF))
        }

        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
            check_write(self, offset, bytes.len())?;
            bytes.iter().enumerate().try_for_each(|(at, byte)| {
                let at = offset as usize + at;
                self.change(at, self.bytes[at] & byte)
            })
        }
    }

    pub(super) fn with(zero: f32, objects: u32) -> Setup {
        let mut setup = Setup::DEFAULT;
        setup.settings = Settings { on_fault: Reaction::Release, ..Settings::of(Mount { zero, ..Mount::DEFAULT }) };
        for finger in 0..FINGERS {
            let radius = f64::from(objects) + finger as f64;
            let design = ObjectDesign::Circle { centre: [41.0, 45.0], radius };
            setup.objects[finger] = Some(Object { design, friction: 0.25 });
            setup.uncertainties[finger] = Some(Uncertainty { radius: radius as f32, ..Uncertainty::DEFAULT });
        }
        setup
    }

    fn filled<X: Clone, const N: usize>(value: X, entries: usize) -> heapless::Vec<X, N> {
        core::iter::repeat_n(value, entries).collect()
    }

    /// A finger with as much of everything as a microcontroller has room for.
    pub(super) fn longest() -> Finger {
        let profile = || Profile { knots: filled([1.5, 2.5], Lists::TARGET.knots) };
        let beam = || Beam {
            base: [1.5; 2],
            tip: [2.5; 2],
            sagitta: 0.1,
            via: filled([1.5, -2.5], Lists::TARGET.points),
            thickness: profile(),
            stiffness_factor: 1.1,
            bending_factor: 1.2,
            stretch_factor: 0.9,
            clamp: 3.5,
        };
        let arcs =
            Attachments::Arcs { front: filled(0.1, Lists::TARGET.lamellae), back: filled(0.2, Lists::TARGET.lamellae) };
        let design = Design {
            width: profile(),
            plane_strain: PlaneStrain::Auto,
            material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48, law: MaterialLaw::default() },
            front: beam(),
            back: beam(),
            lamellae: Lamellae {
                attachments: arcs,
                thickness: filled([1.2, 1.1], Lists::TARGET.thicknesses),
                kind: LamellaKind::Rib(Ribs::WELDED),
            },
            hinge: Hinge {
                kind: HingeKind::Welded,
                length: filled(2.5, Lists::TARGET.lamellae),
                thickness: 0.8,
                from: HingeFrom::Face,
            },
            rigid_above: Some(70.0),
            motor_axis: [-14.0, -20.0],
        };
        Finger { design, how: Discretisation::estimator(Physics::Extended) }
    }

    pub(super) fn keep<F>(flash: &mut F, key: Key, setup: &Setup) -> Result<(), NotKept>
    where
        for<'f> &'f mut F: NorFlash,
    {
        let mut store = Store::new(flash);
        block_on(async {
            // As the program does: what is there is read first.
            store.restore(&mut Setup::DEFAULT.clone()).await;
            store.keep(key, setup).await
        })
    }

    pub(super) fn restore<F>(flash: &mut F) -> (Setup, Found)
    where
        for<'f> &'f mut F: NorFlash,
    {
        let mut setup = Setup::DEFAULT;
        let found = block_on(Store::new(flash).restore(&mut setup));
        (setup, found)
    }

    #[test]
    fn what_is_kept_comes_back() {
        let mut flash = Flash::<8>::new();
        assert_eq!(restore(&mut flash).1, Found { records: 0, damaged: 0 });
        // Many times: the sectors fill and are used anew.
        for round in 1..200_u32 {
            let setup = with(round as f32, round);
            keep(&mut flash, Key::Settings, &setup).unwrap();
            keep(&mut flash, Key::Object((round % 4) as u8), &setup).unwrap();
            keep(&mut flash, Key::Uncertainty((round % 4) as u8), &setup).unwrap();
            let (back, found) = restore(&mut flash);
            assert_eq!(back.settings, setup.settings);
            assert_eq!(back.objects[(round % 4) as usize], setup.objects[(round % 4) as usize]);
            assert_eq!(back.uncertainties[(round % 4) as usize], setup.uncertainties[(round % 4) as usize]);
            assert_eq!(found, Found { records: 1 + 2 * round.min(4) as u8, damaged: 0 });
        }
    }

    #[test]
    fn what_is_kept_already_is_not_written_again() {
        let mut flash = Flash::<4>::new();
        let setup = with(7.0, 3);
        keep(&mut flash, Key::Settings, &setup).unwrap();
        let done = flash.done;
        keep(&mut flash, Key::Settings, &setup).unwrap();
        assert_eq!(flash.done, done);
    }

    /// Power lost after every single byte of a write: afterwards there is the old record or the new one, never anything
    /// else, the other records are as they were, and the next one can be kept. Of every flash's turn, the writes around the
    /// one that erases a sector.
    fn cut_everywhere<const WORD: usize>(key: Key, make: fn(u32) -> Setup) {
        let part = |setup: &Setup| match key {
            Key::Settings => format!("{:?}", setup.settings),
            Key::Finger(finger) => format!("{:?}", setup.fingers[usize::from(finger)]),
            Key::Object(finger) => format!("{:?}", setup.objects[usize::from(finger)]),
            Key::Uncertainty(finger) => format!("{:?}", setup.uncertainties[usize::from(finger)]),
        };
        let mut flash = Flash::<WORD>::new();
        let mut old = make(0);
        keep(&mut flash, key, &old).unwrap();
        keep(&mut flash, Key::Object(1), &old).unwrap();
        let written = |flash: &Flash<WORD>, setup: &Setup| {
            let mut whole = flash.clone();
            keep(&mut whole, key, setup).unwrap();
            (whole.done - flash.done, whole)
        };
        let (mut cuts, mut erasures, mut round) = (0, 0, 1);
        while erasures < 3 {
            assert!(round < 1_000, "nothing is ever erased");
            let (next, new) = (make(round + 1), make(round));
            let (bytes, whole) = written(&flash, &new);
            let erases = bytes > SECTOR;
            // This write, or the one behind it, erases; or the first of all, onto a fresh flash.
            if erases || round == 1 || written(&whole, &next).0 > SECTOR {
                erasures += usize::from(erases);
                for cut in 0..bytes {
                    let mut broken = flash.clone();
                    broken.left = cut;
                    let kept = keep(&mut broken, key, &new);
                    broken.left = usize::MAX;
                    let place = format!("cut after {cut} of {bytes} bytes in round {round}");
                    let (back, found) = restore(&mut broken);
                    assert_eq!(found, Found { records: 2, damaged: 0 }, "{place}");
                    let is_old = part(&back) == part(&old);
                    assert!(is_old || part(&back) == part(&new), "{place}");
                    assert!(!(is_old && kept.is_ok()), "kept, it said, {place}");
                    assert_eq!(back.objects[1], old.objects[1], "{place}");
                    keep(&mut broken, key, &next).unwrap();
                    assert_eq!(part(&restore(&mut broken).0), part(&next), "{place}");
                    cuts += 1;
                }
            }
            (flash, old) = (whole, new);
            round += 1;
        }
        assert!(cuts > 3 * SECTOR, "{cuts} cuts");
    }

    #[test]
    fn a_write_cut_at_any_byte_leaves_the_old() {
        let make = |round| with(round as f32, 0);
        cut_everywhere::<1>(Key::Settings, make);
        cut_everywhere::<4>(Key::Settings, make);
        cut_everywhere::<8>(Key::Settings, make);
        cut_everywhere::<32>(Key::Settings, make);
        // The objects stay as they are.
        cut_everywhere::<8>(Key::Uncertainty(2), |round| Setup { objects: with(0.0, 0).objects, ..with(0.0, round) });
    }

    /// The longest records: a whole finger.
    #[test]
    fn a_long_write_cut_at_any_byte_leaves_the_old() {
        let make = |round: u32| {
            let mut setup = with(0.0, 0);
            let mut finger = longest();
            finger.design.material.youngs_modulus += f64::from(round);
            setup.fingers[2] = Some(finger);
            setup
        };
        assert!(encode(Key::Finger(2), &make(0), &mut [0; RECORD]).unwrap() > 500);
        cut_everywhere::<1>(Key::Finger(2), make);
        cut_everywhere::<8>(Key::Finger(2), make);
        cut_everywhere::<32>(Key::Finger(2), make);
    }

    /// Noise instead of flash: told, survived, and written anew.
    #[test]
    fn damage_is_told_and_survived() {
        let mut random = 1_u32;
        let mut noise = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 24) as u8
        };
        let good = with(3.0, 5);
        for round in 0..300 {
            let mut flash = Flash::<8>::new();
            keep(&mut flash, Key::Settings, &good).unwrap();
            keep(&mut flash, Key::Object(2), &good).unwrap();
            for _ in 0..=round {
                let at = usize::from(noise()) * 32 + usize::from(noise()) % 32;
                flash.bytes[at % (4 * SECTOR)] = noise();
            }
            if round % 10 == 0 {
                flash.bytes.iter_mut().for_each(|byte| *byte = noise());
            }
            let (back, _) = restore(&mut flash);
            assert!(back.settings == good.settings || back.settings == Settings::DEFAULT);
            assert!(back.objects[2].is_none() || back.objects[2] == good.objects[2]);
            let new = with(9.0, 1);
            keep(&mut flash, Key::Settings, &new).unwrap();
            assert_eq!(restore(&mut flash).0.settings, new.settings);
        }
    }

    /// A gripper that was updated: objects and uncertainties of earlier versions are there, the objects without friction.
    #[test]
    fn records_of_earlier_versions_come_back() {
        for version in EARLIEST..VERSION {
            let mut flash = Flash::<4>::new();
            let mut store = Store::new(&mut flash);
            let setup = with(3.0, 5);
            for key in [Key::Object(1), Key::Uncertainty(2)] {
                let mut length = encode(key, &setup, &mut store.record).unwrap();
                if key == Key::Object(1) {
                    let design = setup.objects[1].map(|object| object.design);
                    length = 1 + postcard::to_slice(&design, &mut store.record[1..]).unwrap().len();
                }
                store.record[0] = version;
                // Without a seal, as the first of these versions had none.
                let record = store.record[..length].to_vec();
                let map = store.map.as_mut().unwrap();
                block_on(map.store_item::<&[u8]>(&mut store.buffer, &key.number(), &record.as_slice())).unwrap();
            }
            let (back, found) = restore(&mut flash);
            assert_eq!(found, Found { records: 2, damaged: 0 });
            let smooth = setup.objects[1].map(|object| Object::from(object.design));
            assert_eq!((back.objects[1], back.uncertainties[2]), (smooth, setup.uncertainties[2]));
        }
    }

    /// A mount of one time and a finger of another: nothing comes back, and the next record is kept without them.
    #[test]
    fn records_of_different_generations_count_as_absent() {
        let mut flash = Flash::<8>::new();
        keep(&mut flash, Key::Settings, &with(3.0, 5)).unwrap();
        keep(&mut flash, Key::Object(1), &with(3.0, 6)).unwrap();
        keep(&mut flash, Key::Settings, &with(4.0, 6)).unwrap();
        keep(&mut flash, Key::Object(1), &with(4.0, 7)).unwrap();
        assert_eq!(restore(&mut flash).1, Found { records: 2, damaged: 0 });
        // The settings are lost, those before them come to light; object and seal are as they were.
        let mut store = Store::new(&mut flash);
        let length = encode(Key::Settings, &with(3.0, 5), &mut store.record).unwrap();
        let record = store.record[..length].to_vec();
        let map = store.map.as_mut().unwrap();
        block_on(map.store_item::<&[u8]>(&mut store.buffer, &Key::Settings.number(), &record.as_slice())).unwrap();
        let (back, found) = restore(&mut flash);
        assert_eq!(
            (back.settings, back.objects[1], found),
            (Settings::DEFAULT, None, Found { records: 0, damaged: 1 })
        );
        keep(&mut flash, Key::Settings, &Setup { settings: with(9.0, 0).settings, ..Setup::DEFAULT }).unwrap();
        let (back, found) = restore(&mut flash);
        assert_eq!((back.settings, back.objects[1], found.damaged), (with(9.0, 0).settings, None, 0));
    }

    #[test]
    fn another_version_counts_as_absent() {
        let mut flash = Flash::<4>::new();
        let mut store = Store::new(&mut flash);
        let length = encode(Key::Settings, &with(3.0, 5), &mut store.record).unwrap();
        store.record[0] = VERSION + 1;
        block_on(store.write(Key::Settings, length)).unwrap();
        let (back, found) = restore(&mut flash);
        assert_eq!((back.settings, found), (Settings::DEFAULT, Found { records: 0, damaged: 1 }));
    }
}
