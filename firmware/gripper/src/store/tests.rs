//! Records in flash: kept, restored, damaged, of earlier versions.

use std::vec::Vec;

use embassy_futures::block_on;
use embedded_storage::nor_flash::{ErrorType, NorFlashErrorKind, check_erase, check_read, check_write};
use messages::{FINGERS, Mount, Reaction};
use model_core::design::{
    Attachments, Beam, Design, Hinge, HingeFrom, HingeKind, LamellaKind, Lamellae, Material, MaterialLaw, PlaneStrain,
    Profile, RibEnds, Ribs,
};
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::PRONY_TERMS;
use model_core::object::ObjectDesign;
use model_core::size::Lists;

use super::*;

/// NOR flash of four sectors that loses power after so many bytes written or erased; it stays as it is then.
#[derive(Clone)]
struct Flash<const WORD: usize, const SECTOR: usize = 2048> {
    bytes: Vec<u8>,
    left: usize,
    done: usize,
}

/// Bytes of a sector as most tests have it.
const SECTOR: usize = 2048;
/// Bytes of a sector that a finger with [`Lists::RIBS`] fits into.
const WIDE: usize = 4096;

impl<const WORD: usize, const SECTOR: usize> Flash<WORD, SECTOR> {
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

impl<const WORD: usize, const SECTOR: usize> ErrorType for &mut Flash<WORD, SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<const WORD: usize, const SECTOR: usize> ReadNorFlash for &mut Flash<WORD, SECTOR> {
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

impl<const WORD: usize, const SECTOR: usize> NorFlash for &mut Flash<WORD, SECTOR> {
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

fn filled<X: Clone, const N: usize>(value: X, entries: u8) -> heapless::Vec<X, N> {
    core::iter::repeat_n(value, entries.into()).collect()
}

/// A finger with as much of everything as a microcontroller with such lists has room for.
pub(super) fn longest(lists: Lists) -> Finger {
    let profile = || Profile { knots: filled([1.5, 2.5], lists.knots) };
    let beam = || Beam {
        base: [1.5; 2],
        tip: [2.5; 2],
        sagitta: 0.1,
        via: filled([1.5, -2.5], lists.points),
        thickness: profile(),
        stiffness_factor: 1.1,
        bending_factor: 1.2,
        stretch_factor: 0.9,
        clamp: 3.5,
    };
    let arcs = Attachments::Arcs { front: filled(0.1, lists.lamellae), back: filled(0.2, lists.lamellae) };
    let design = Design {
        width: profile(),
        plane_strain: PlaneStrain::Auto,
        material: Material { youngs_modulus: 49.5, poissons_ratio: 0.48, law: MaterialLaw::default() },
        front: beam(),
        back: beam(),
        lamellae: Lamellae {
            attachments: arcs,
            thickness: filled([1.2, 1.1], lists.thicknesses),
            kind: LamellaKind::Rib(Ribs { ends: RibEnds::Gap(0.4), ..Ribs::WELDED }),
        },
        hinge: Hinge {
            kind: HingeKind::Welded,
            length: filled(2.5, lists.lamellae),
            thickness: 0.8,
            from: HingeFrom::Face,
        },
        rigid_above: Some(70.0),
        motor_axis: [-14.0, -20.0],
    };
    Finger::elastic(design, Discretisation::estimator(Physics::Extended)).relaxing(&[[0.1, 1e5]; PRONY_TERMS])
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
    cut_every::<WORD, SECTOR>(1, key, make);
}

/// The same after every so many bytes.
fn cut_every<const WORD: usize, const SECTOR: usize>(every: usize, key: Key, make: fn(u32) -> Setup) {
    let part = |setup: &Setup| match key {
        Key::Settings => format!("{:?}", setup.settings),
        Key::Finger(finger) => format!("{:?}", setup.fingers[usize::from(finger)]),
        Key::Object(finger) => format!("{:?}", setup.objects[usize::from(finger)]),
        Key::Uncertainty(finger) => format!("{:?}", setup.uncertainties[usize::from(finger)]),
    };
    let mut flash = Flash::<WORD, SECTOR>::new();
    let mut old = make(0);
    keep(&mut flash, key, &old).unwrap();
    keep(&mut flash, Key::Object(1), &old).unwrap();
    let written = |flash: &Flash<WORD, SECTOR>, setup: &Setup| {
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
            for cut in (0..bytes).step_by(every) {
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
    assert!(cuts > 3 * SECTOR / every, "{cuts} cuts");
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
    fn make(lists: Lists, round: u32) -> Setup {
        let mut setup = with(0.0, 0);
        let mut finger = longest(lists);
        finger.design.material.youngs_modulus += f64::from(round);
        setup.fingers[2] = Some(finger);
        setup
    }
    for (lists, least) in [(Lists::TARGET, 900), (Lists::RIBS, SECTOR)] {
        let length = encode(Key::Finger(2), &make(lists, 0), &mut [0; RECORD]).unwrap();
        assert!((least..=record_bytes(lists)).contains(&length), "{lists:?}: {length} bytes");
    }
    cut_everywhere::<1>(Key::Finger(2), |round| make(Lists::TARGET, round));
    cut_everywhere::<8>(Key::Finger(2), |round| make(Lists::TARGET, round));
    cut_everywhere::<32>(Key::Finger(2), |round| make(Lists::TARGET, round));
    // Of a sector twice as large: not every byte, but no pattern either.
    cut_every::<8, WIDE>(29, Key::Finger(2), |round| make(Lists::RIBS, round));
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

/// A gripper that was updated: objects and uncertainties of earlier versions are there, the objects of versions before 9 without friction.
#[test]
fn records_of_earlier_versions_come_back() {
    for version in EARLIEST..VERSION {
        let mut flash = Flash::<4>::new();
        let mut store = Store::new(&mut flash);
        let setup = with(3.0, 5);
        for key in [Key::Object(1), Key::Uncertainty(2)] {
            let mut length = encode(key, &setup, &mut store.record).unwrap();
            if key == Key::Object(1) && version < 9 {
                let design = setup.objects[1].map(|object| object.design);
                length = 1 + postcard::to_slice(&design, &mut store.record[1..]).unwrap().len();
            }
            if matches!(key, Key::Uncertainty(_)) {
                // Those of the terms, its last 100 bytes, came with version 12.
                length -= 100;
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
        let expected = if version < 9 { smooth } else { setup.objects[1] };
        assert_eq!((back.objects[1], back.uncertainties[2]), (expected, setup.uncertainties[2]));
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
    assert_eq!((back.settings, back.objects[1], found), (Settings::DEFAULT, None, Found { records: 0, damaged: 1 }));
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
