//! A sweep in shards, and the one file that is made of theirs.

use std::process::{Command, Output};

use crate::{Folder, timeless, words};

fn merge(folder: &Folder, words: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
    command.args(["sweep", "merge"]).args(words.split_whitespace()).current_dir(folder.0.path()).output().unwrap()
}

#[test]
fn shards_make_the_file_of_the_whole_sweep() {
    let folder = Folder::new();
    let options = "--vary object.radius_mm=36:42:1 --shapes";
    assert_eq!(folder.fre(&format!("{options} --out whole.csv")).status.code(), Some(0));
    for shard in 1..=3 {
        let output = folder.fre(&format!("{options} --shard {shard}/3 --out {shard}.csv"));
        assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    }
    let merge = |words: &str| merge(&folder, words);
    let output = merge("3.csv 1.csv 2.csv --out all.csv");
    assert_eq!(output.status.code(), Some(0), "{}", words(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(folder.file(name)).unwrap();
    assert_eq!(timeless(&read("all.csv")), timeless(&read("whole.csv")));
    assert_eq!(read("all.csv.sweep"), read("whole.csv.sweep"));
    let output = merge("1.csv 2.csv 3.csv --out -");
    assert_eq!(words(&output.stdout), read("all.csv"));
    // The whole sweep finds every row there.
    let output = folder.fre(&format!("{options} --out all.csv"));
    snapbox::assert_data_eq!(
        words(&output.stderr),
        snapbox::str![[r#"
fre: 14 of 14 rows are known already
fre: 14 rows (0 computed, 14 from before): 12 converged, 2 no-contact

"#]]
    );
    let mut said = String::new();
    let mut refused = |what: &str, output: &Output| {
        assert_eq!(output.status.code(), Some(1), "{what}: {}", words(&output.stderr));
        said += &format!("$ fre sweep {what}\n{}\n", words(&output.stderr));
    };
    for arguments in [
        "1.csv 2.csv --out two.csv",
        "1.csv 1.csv 2.csv 3.csv --out two.csv",
        "1.csv whole.csv --out two.csv",
        "case.toml --out two.csv",
        "1.csv 2.csv 3.csv --out 1.csv",
        "1.csv 2.csv 3.csv --out all.csv",
        "1.csv 2.csv 3.csv --out - --parquet all.parquet",
    ] {
        refused(&format!("merge {arguments}"), &merge(arguments));
    }
    // The file that says of which sweep a shard is belongs to what is read.
    let before = read("2.csv.sweep");
    let output = merge("1.csv 2.csv 3.csv --out 2.csv.sweep --force");
    snapbox::assert_data_eq!(
        words(&output.stderr),
        snapbox::str![[r#"
fre: --out: 2.csv.sweep is the same file as the file beside a shard (2.csv.sweep); an output needs a file of its own

"#]]
    );
    assert_eq!((output.status.code(), read("2.csv.sweep")), (Some(1), before));
    // A shard that was stopped is named by the row that is missing.
    let torn = read("2.csv");
    let last = torn.trim_end().rfind('\n').unwrap() + 1;
    std::fs::write(folder.file("2.csv"), &torn[..last]).unwrap();
    refused("merge 1.csv 2.csv 3.csv --out two.csv", &merge("1.csv 2.csv 3.csv --out two.csv"));
    assert!(!folder.file("two.csv").exists());
    let printed = merge("1.csv 2.csv 3.csv --out -");
    assert_eq!((printed.status.code(), words(&printed.stdout)), (Some(1), String::new()), "rows before the error");
    refused("case.toml --shard 4/3", &folder.fre("--vary object.radius_mm=36:42:1 --shard 4/3"));
    snapbox::assert_data_eq!(said, snapbox::file!["../words/shards.txt"].raw());
}

/// What a sweep says at its end, of all shards: its statuses, its failures by their places, its warnings, its exit status.
#[test]
fn a_merge_counts_what_the_shards_could_not_solve() {
    let folder = Folder::new();
    // The larger cylinder surrounds the finger and the motor axis.
    let options = "--vary object.radius_mm=5,200 --angles 0,5";
    let whole = folder.fre(&format!("{options} --out whole.csv"));
    for shard in 1..=2 {
        folder.fre(&format!("{options} --shard {shard}/2 --out {shard}.csv"));
    }
    let merged = merge(&folder, "1.csv 2.csv --out all.csv");
    assert_eq!((merged.status.code(), whole.status.code()), (Some(2), Some(2)));
    snapbox::assert_data_eq!(
        words(&merged.stderr),
        snapbox::str![[r#"
fre: 4 rows of 2 shards are in all.csv: 2 no-contact, 2 out-of-range
fre: row 2: out-of-range: object.radius_mm=200 at 0°
fre: row 3: out-of-range: object.radius_mm=200 at 5°
fre: warning: 2 of 4 rows have the object inside a part of the finger that the model lets it pass through (column overlap_mm); the first is row 2: object.radius_mm=200 at 0°

"#]]
    );
    // But for the first line as the whole sweep.
    let rest = |output: &Output| words(&output.stderr).lines().skip(1).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(rest(&merged), rest(&whole));
    let printed = merge(&folder, "1.csv 2.csv --out -");
    assert_eq!((printed.status.code(), rest(&printed)), (Some(2), rest(&whole)));
    assert_eq!(words(&printed.stdout), std::fs::read_to_string(folder.file("all.csv")).unwrap());
}
