//! The targets without a fuzzer: `cargo run -p fuzz-targets -- …`
//!
//!     list              the targets' names
//!     seeds FOLDER      writes NAME/seed-N and NAME.dict for every target
//!     NAME FILE …       runs the inputs one after the other: reproduces what the fuzzer found

use std::io;
use std::path::Path;
use std::process::ExitCode;

use fuzz_targets::{TARGETS, Target, target};

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match arguments.as_slice() {
        ["list"] => {
            TARGETS.iter().for_each(|target| println!("{}", target.name));
            Ok(())
        }
        ["seeds", folder] => TARGETS.iter().try_for_each(|target| write_seeds(target, Path::new(folder))),
        [name, files @ ..] if !files.is_empty() && target(name).is_some() => run(name, files),
        _ => Err(io::Error::other("usage: list | seeds FOLDER | TARGET FILE …")),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(name: &str, files: &[&str]) -> io::Result<()> {
    for file in files {
        let bytes = std::fs::read(file).map_err(|error| io::Error::other(format!("{file}: {error}")))?;
        println!("{name}: {file}: {} bytes", bytes.len());
        if let Some(target) = target(name) {
            (target.run)(&bytes);
        }
    }
    Ok(())
}

/// Seeds as libFuzzer's corpus, words as its dictionary.
fn write_seeds(target: &Target, folder: &Path) -> io::Result<()> {
    let corpus = folder.join(target.name);
    std::fs::create_dir_all(&corpus)?;
    for (index, seed) in (target.seeds)().into_iter().enumerate() {
        std::fs::write(corpus.join(format!("seed-{index}")), seed)?;
    }
    let quoted = |word: &String| {
        let letters = word.bytes().map(|byte| match byte {
            b'"' | b'\\' => format!("\\{}", char::from(byte)),
            b' '..=b'~' => char::from(byte).to_string(),
            other => format!("\\x{other:02x}"),
        });
        format!("\"{}\"\n", letters.collect::<String>())
    };
    std::fs::write(
        folder.join(format!("{}.dict", target.name)),
        (target.words)().iter().map(quoted).collect::<String>(),
    )
}
