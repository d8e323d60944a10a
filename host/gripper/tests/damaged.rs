//! A recording with damaged bytes is read past them, and what is missing is named.

use std::fs;
use std::path::Path;

use fre_gripper::record::{Damage, Recorded, Recorder, Recording};
use fre_gripper::source::{Modelled, Origin, Setup, Told};
use messages::{PROTOCOL_VERSION, Phase, Report, Settings};
use model_core::estimator::Estimate;
use model_core::status::Status;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// Enough for several chunks.
const REPORTS: u32 = 12_000;

fn recorder(path: &Path) -> Recorder {
    let setup = Setup {
        origin: Origin::Gripper,
        place: "nowhere".to_owned(),
        board: "none".to_owned(),
        firmware: "none".to_owned(),
        protocol: PROTOCOL_VERSION,
        cost_hz: 1_000_000,
        settings: Settings::DEFAULT,
        models: vec![Modelled::default()],
    };
    Recorder::create(path, Some(setup)).unwrap()
}

fn report(sequence: u32, random: &mut ChaCha8Rng) -> Told {
    // Digits that do not compress away.
    let mut number = || f32::from_bits(0x3F00_0000 | random.next_u32() >> 9);
    let estimate = Estimate {
        force: [number(), number()],
        torque: number(),
        residual: number(),
        ..Estimate::blank(Status::Converged)
    };
    Told::Report(Report {
        sequence,
        finger: 0,
        phase: Phase::Moving,
        time_us: 2_000 * u64::from(sequence),
        estimate,
        goal: number(),
        position: sequence as i32,
        current: number(),
        cost: 7,
    })
}

fn record(path: &Path) {
    let (mut recorder, mut random) = (recorder(path), ChaCha8Rng::seed_from_u64(1));
    (1..=REPORTS).for_each(|sequence| recorder.take(&report(sequence, &mut random)).unwrap());
    recorder.finish().unwrap();
}

/// What a recording holds.
#[derive(Debug, Default)]
struct Read {
    reports: u32,
    last: u32,
    missing: u32,
    damages: Vec<Damage>,
}

fn read(path: &Path) -> Result<Read, String> {
    let mut read = Read::default();
    for recorded in Recording::open(path).map_err(|error| error.to_string())? {
        match recorded.map_err(|error| error.to_string())?.1 {
            Recorded::Told(Told::Report(report)) => {
                assert!(report.sequence > read.last && report.position == report.sequence as i32, "{report:?}");
                read.reports += 1;
                read.last = report.sequence;
            }
            Recorded::Gap(gap) => read.missing += gap.missing,
            Recorded::Damage(damage) => read.damages.push(damage),
            Recorded::Told(_) => {}
        }
    }
    Ok(read)
}

/// Places where the file's chunks begin.
fn chunks(bytes: &[u8]) -> Vec<usize> {
    let mut at = 8;
    let mut found = Vec::new();
    while let Some(head) = bytes.get(at..at + 9) {
        if head[0] == 6 {
            found.push(at);
        }
        at += 9 + u64::from_le_bytes(head[1..].try_into().unwrap()) as usize;
    }
    found
}

#[test]
fn a_damaged_chunk_is_skipped_and_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.mcap");
    record(&path);
    let whole = read(&path).unwrap();
    assert!(whole.reports == REPORTS && whole.missing == 0 && whole.damages.is_empty(), "{whole:?}");
    let bytes = fs::read(&path).unwrap();
    let chunks = chunks(&bytes);
    assert!(chunks.len() > 3, "{} chunks", chunks.len());
    let (second, third) = (chunks[1], chunks[2]);
    let path = folder.path().join("damaged.mcap");
    // In the compressed messages, the checksum, the length, the kind.
    for place in [second + 2_000, second + 9 + 24, second + 6, second] {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x40;
        fs::write(&path, damaged).unwrap();
        let found = read(&path).unwrap_or_else(|error| panic!("{}: {error}", place - second));
        let what = format!("byte {} of the chunk: {found:?}", place - second);
        // One chunk is lost, no more, and every report of it is counted.
        assert!(found.missing > 0 && found.reports + found.missing == REPORTS, "{what}");
        let [damage] = found.damages[..] else { panic!("{what}") };
        assert!(damage.from == second as u64 && damage.to <= third as u64, "{what}");
        assert!(damage.to_string().contains(&second.to_string()), "{damage}");
    }
}

/// What the recorder has missed behind a damaged chunk hides nothing that is lost with it.
#[test]
fn reports_lost_before_a_gap_are_counted() {
    const PART: u32 = 300;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gaps.mcap");
    let (mut recorder, mut random) = (recorder(&path), ChaCha8Rng::seed_from_u64(1));
    // Every chunk but the first begins with a gap of ten.
    for part in 0..4 {
        let first = 1 + part * (PART + 10);
        (first..first + PART).for_each(|sequence| recorder.take(&report(sequence, &mut random)).unwrap());
        recorder.flush().unwrap();
    }
    recorder.finish().unwrap();
    let (bytes, last) = (fs::read(&path).unwrap(), 4 * PART + 30);
    let whole = read(&path).unwrap();
    assert_eq!((whole.reports, whole.missing, whole.last), (4 * PART, 30, last));
    let chunks = chunks(&bytes);
    for pair in chunks.windows(2).skip(1) {
        let mut damaged = bytes.clone();
        damaged[usize::midpoint(pair[0], pair[1])] ^= 0x40;
        fs::write(&path, damaged).unwrap();
        let found = read(&path).unwrap();
        assert!(found.damages.len() == 1 && found.missing > 30, "{found:?}");
        assert_eq!((found.reports + found.missing, found.last), (last, last), "{found:?}");
    }
}

#[test]
fn a_flipped_byte_anywhere_stops_no_reading() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.mcap");
    record(&path);
    let bytes = fs::read(&path).unwrap();
    let chunks = chunks(&bytes);
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let path = folder.path().join("damaged.mcap");
    // Behind the first chunk, which has the set-up and the channels.
    for _ in 0..40 {
        let place = chunks[1] + random.next_u32() as usize % (bytes.len() - chunks[1]);
        let mut damaged = bytes.clone();
        damaged[place] ^= 1 << (random.next_u32() % 8);
        fs::write(&path, damaged).unwrap();
        let found = read(&path).unwrap_or_else(|error| panic!("byte {place}: {error}"));
        // What is lost at the very end nobody can count.
        assert_eq!(found.reports + found.missing, found.last, "byte {place}: {found:?}");
        assert!(found.reports > REPORTS / 2, "byte {place}: {found:?}");
        assert!(found.last == REPORTS || !found.damages.is_empty(), "byte {place}: {found:?}");
    }
    // The first chunk's channels are described at the end once more.
    let mut damaged = bytes.clone();
    damaged[chunks[0] + 500] ^= 0x40;
    fs::write(&path, damaged).unwrap();
    let found = read(&path).unwrap();
    assert!(found.reports > REPORTS / 2 && found.last == REPORTS && found.damages.len() == 1, "{found:?}");
}
