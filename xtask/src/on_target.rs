//! Runs an image of embedded-test's tests in QEMU: one machine per test, as many at a time as there are processors.
//!
//! The tests are listed in the ELF's section `.embedded_test`: each is a symbol whose *name* is a JSON object and whose value is
//! the entry function's address and the module path. The machine gets `run_addr ADDRESS` as its semihosting command line.

use crate::crossing::Crossing;
use anyhow::{Context, Result, bail};
use fre_log::Log;
use fre_qemu::{Machine, Pace};
use object::{Object, ObjectSection, ObjectSymbol};
use std::io::Read;
use std::num::NonZero;
use std::path::Path;
use std::process::Stdio;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Exit status of an image that panicked (the board support's choice).
const PANICKED: i32 = 101;
/// 4 ns per instruction, so that runs repeat; waiting still takes its time.
const PACE: Pace = Pace::Counted { shift: 2 };
const DEFAULT_TIMEOUT: Duration = Duration::from_secs(60);

#[derive(Debug, PartialEq)]
struct Test {
    name: String,
    entry: u32,
    ignored: bool,
    should_panic: bool,
    timeout: Duration,
}

/// Whether an ELF file has tests.
pub fn holds_tests(elf: &[u8]) -> Result<bool> {
    let file = object::File::parse(elf).context("not an ELF file")?;
    Ok(file.section_by_name(".embedded_test").is_some())
}

/// Runs every test; prints a line for each, the log of those that failed, and the usual count.
pub fn run(elf: &Path) -> Result<()> {
    let bytes = std::fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let tests = list(&bytes)?;
    if tests.is_empty() {
        bail!("{} lists no tests", elf.display());
    }
    let log = Log::of(&bytes)?;
    println!("running {} tests", tests.len());
    let start = Instant::now();
    let next = AtomicUsize::new(0);
    let failures = Mutex::new(Vec::new());
    let ignored = tests.iter().filter(|test| test.ignored).count();
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, NonZero::get) {
            scope.spawn(|| {
                while let Some(test) = tests.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if test.ignored {
                        println!("test {} ... ignored", test.name);
                        continue;
                    }
                    let failure = run_one(elf, test, &log).unwrap_or_else(|error| Some(format!("{error:#}")));
                    println!("test {} ... {}", test.name, if failure.is_some() { "FAILED" } else { "ok" });
                    if let (Some(failure), Ok(mut failures)) = (failure, failures.lock()) {
                        failures.push((&test.name, failure));
                    }
                }
            });
        }
    });
    let mut failures = failures.into_inner().map_err(|_| anyhow::anyhow!("the runner itself failed"))?;
    failures.sort();
    if !failures.is_empty() {
        println!("\nfailures:");
    }
    for (name, failure) in &failures {
        println!("\n---- {name} ----\n{failure}");
    }
    println!(
        "\ntest result: {}. {} passed; {} failed; {ignored} ignored; 0 measured; 0 filtered out; finished in {:.2}s",
        if failures.is_empty() { "ok" } else { "FAILED" },
        tests.len() - ignored - failures.len(),
        failures.len(),
        start.elapsed().as_secs_f64()
    );
    if !failures.is_empty() {
        bail!("tests failed on the target");
    }
    Ok(())
}

/// The tests of an ELF file, by name.
fn list(elf: &[u8]) -> Result<Vec<Test>> {
    let file = object::File::parse(elf).context("not an ELF file")?;
    let section = file.section_by_name(".embedded_test").context("no section `.embedded_test`")?;
    let mut tests = Vec::new();
    for symbol in file.symbols().filter(|symbol| symbol.section_index() == Some(section.index())) {
        let name = symbol.name()?;
        if !name.starts_with('{') {
            continue; // the protocol's version
        }
        let description: serde_json::Value =
            serde_json::from_str(name).with_context(|| format!("`{name}` does not describe a test"))?;
        let words = section.data_range(symbol.address(), 12)?.with_context(|| format!("`{name}` has no value"))?;
        let word =
            |index: usize| words[4 * index..][..4].iter().rev().fold(0, |value, byte| value << 8 | u32::from(*byte));
        let [entry, path, length] = [word(0), word(1), word(2)];
        let path = text(&file, path, length).with_context(|| format!("`{name}` has no module path"))?;
        let module = path.split_once("::").map_or("", |(_, module)| module).trim_end_matches("::tests");
        let function = description["name"].as_str().context("a test without a name")?;
        tests.push(Test {
            name: format!("{module}::{function}"),
            entry,
            ignored: description["ignored"].as_bool().unwrap_or(false),
            should_panic: description["should_panic"].as_bool().unwrap_or(false),
            timeout: description["timeout"].as_u64().map_or(DEFAULT_TIMEOUT, Duration::from_secs),
        });
    }
    tests.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(tests)
}

/// A string in the image's read-only data.
fn text(file: &object::File, address: u32, length: u32) -> Option<String> {
    let bytes = file.sections().find_map(|section| section.data_range(address.into(), length.into()).ok().flatten())?;
    String::from_utf8(bytes.to_vec()).ok()
}

/// Runs one test in a machine of its own; `Some` says what went wrong.
fn run_one(elf: &Path, test: &Test, log: &Log) -> Result<Option<String>> {
    let mut crossing = Crossing::new(format!("fre-on-target-{}-{}", std::process::id(), test.entry))?;
    let machine = Machine::new(elf).arguments(&["run_addr", &test.entry.to_string()]).pace(PACE);
    let mut machine = machine.uarts(crossing.uart(), crossing.uart()).boot(Stdio::piped())?;
    let output = machine.output();
    let frames = thread::spawn(move || read_all(output));
    let status = machine.end(Some(test.timeout), || crossing.attend())?;
    let frames = frames.join().unwrap_or_default();

    let verdict = match status.map(|status| (status.code(), status)) {
        None => format!("no end after {} s", test.timeout.as_secs()),
        Some((Some(0), _)) if !test.should_panic => return Ok(None),
        Some((Some(PANICKED), _)) if test.should_panic => return Ok(None),
        Some((Some(0), _)) => "did not panic as expected".to_owned(),
        Some((Some(PANICKED), _)) => "panicked".to_owned(),
        Some((_, status)) => format!("ended with {status}"),
    };
    let mut lines: Vec<String> = log.lines(&frames).iter().map(ToString::to_string).collect();
    lines.extend([format!("QEMU said: {}", machine.words()), verdict]);
    Ok(Some(lines.join("\n")))
}

fn read_all(source: Option<impl Read>) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Some(mut source) = source {
        // A pipe that breaks has given what it had.
        let _ = source.read_to_end(&mut bytes);
    }
    bytes
}
