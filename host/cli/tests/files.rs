//! No command loses a file: outputs that are inputs, or there already, are refused; results are whole or not there; nothing panics
//! on a full disk or a closed pipe.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

const CASE: &str = "finger = \"finger.toml\"\n[object]\nshape = \"circle\"\nradius_mm = 40.0\ncentre_mm = [41.0, 45.0]\n\
    [motion]\nmotor_angles_deg = [4.0, 6.0, 8.0]\n";
const FINGER: &str = "width_mm = 20.0\nplane_strain = \"stress\"\nmaterial = { youngs_modulus_pa = 4.95e7, poissons_ratio = 0.48 }\n\
    front = { base_mm = [0.0, 0.0], tip_mm = [0.0, 80.0], thickness_mm = 2.0 }\n\
    back = { base_mm = [-28.0, 0.0], tip_mm = [0.0, 80.0], thickness_mm = 2.0 }\n\
    lamellae = { heights_mm = [20, 40, 60], thickness_mm = 3.0 }\n\
    hinge = { kind = \"flexible\", length_mm = 2.5, thickness_mm = 0.8, from = \"centreline\" }\n\
    motor = { axis_mm = [-14.0, -20.0] }\n";
const MEASURED: &str = "motor_angle_deg,force_n\n4,1.0\n6,2.0\n8,3.0\n";

/// A folder with a case, its finger and measurements, in which commands run.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("case.toml", &CASE.replace("finger.toml", "preset:ladder-80"));
        folder.write("measured.csv", MEASURED);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fre"));
        command.args(words.split(' ')).current_dir(self.0.path());
        command
    }

    fn fre(&self, words: &str) -> Output {
        self.command(words).output().unwrap()
    }

    /// What a command says that refuses; every file is as it was.
    fn refusal(&self, words: &str) -> String {
        let before = self.contents();
        let output = self.fre(words);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{words}: {said}");
        assert!(self.contents() == before, "{words}: a file has changed: {said}");
        said
    }

    fn contents(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let mut files: Vec<_> = fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .filter(|path| path.is_file())
            .map(|path| (path.clone(), fs::read(path).unwrap()))
            .collect();
        files.sort();
        files
    }
}

#[test]
fn no_output_is_an_input() {
    let folder = Folder::new();
    #[cfg(unix)]
    for (target, link) in [("case.toml", "case.svg"), ("measured.csv", "measured.svg")] {
        std::os::unix::fs::symlink(target, folder.path(link)).unwrap();
    }
    fs::hard_link(folder.path("case.toml"), folder.path("hard.svg")).unwrap();
    let calibrate = "calibrate measured.csv --case case.toml --fit youngs-modulus --elements reduced";
    let mut said = String::new();
    for words in [
        format!("{calibrate} --write measured.csv"),
        format!("{calibrate} --write ./case.toml"),
        format!("{calibrate} --write fitted.svg --plot fitted.svg"),
        "solve case.toml --plot case.svg".to_owned(),
        "solve case.toml --plot hard.svg".to_owned(),
        "compare case.toml --measured measured.csv --plot measured.svg".to_owned(),
        "sweep case.toml --out case.toml".to_owned(),
        "monitor --bus unix:none --case case.toml --log case.toml".to_owned(),
        "monitor --bus unix:none --settings measured.csv --log measured.csv".to_owned(),
        "monitor --link unix:none --log x --record ./x".to_owned(),
    ] {
        for words in [words.clone(), format!("{words} --force")] {
            if words.starts_with("sweep") && words.ends_with("--force") {
                continue; // it overwrites nothing, and has no such option
            }
            said += &format!("$ fre {words}\n{}\n", folder.refusal(&words));
        }
    }
    // The finger that a case names is read as well.
    folder.write("case.toml", CASE);
    folder.write("finger.toml", FINGER);
    let words = "calibrate measured.csv --case case.toml --write finger.toml --force";
    said += &format!("$ fre {words}\n{}\n", folder.refusal(words));
    snapbox::assert_data_eq!(said, snapbox::file!["words/same_file.txt"].raw());
}

#[test]
fn what_is_there_is_overwritten_on_request_only() {
    let folder = Folder::new();
    folder.write("a.svg", "mine");
    fs::create_dir(folder.path("case-fea")).unwrap();
    folder.write("case-fea/finger.inp", "mine");
    fs::create_dir(folder.path("report")).unwrap();
    folder.write("report/table1.csv", "mine");
    let mut said = String::new();
    for words in [
        "solve case.toml --plot a.svg",
        "calibrate measured.csv --case case.toml --write a.svg",
        "monitor --link unix:none --log a.svg",
        "monitor --link unix:none --record a.svg",
        "compare case.toml --fea",
        "table1 --out report",
    ] {
        said += &format!("$ fre {words}\n{}\n", folder.refusal(words));
    }
    snapbox::assert_data_eq!(said, snapbox::file!["words/exists.txt"].raw());
    let output = folder.fre("solve case.toml --elements reduced --plot a.svg --force");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.read("a.svg").starts_with("<svg"));
}

#[cfg(unix)]
#[test]
fn standard_output_has_room_for_one_document() {
    let folder = Folder::new();
    for (words, one, other) in [
        ("solve case.toml --plot - --format json", "--plot -", "--format json"),
        ("solve case.toml --animate - --format csv", "--animate -", "--format csv"),
        ("solve case.toml --plot - --animate -", "--plot -", "--animate -"),
        ("compare case.toml -m measured.csv --plot - --format json", "--plot -", "--format json"),
        ("compare case.toml -m measured.csv --plot - --format csv", "--plot -", "--format csv"),
        ("calibrate measured.csv -c case.toml --plot - --format json", "--plot -", "--format json"),
    ] {
        let refused = format!("fre: {one} and {other}: standard output has room for one of them\n");
        assert_eq!(folder.refusal(words), refused, "{words}");
    }
}

#[test]
fn standard_output_is_no_folder() {
    let folder = Folder::new();
    for words in [
        "man --out -",
        "schema --page -",
        "table1 --out -",
        "optimise case.toml --goal mass --vary finger.width_mm=15:25 --out -",
        "compare case.toml --fea --folder -",
    ] {
        let said = folder.refusal(words);
        assert!(said.contains("allowed is a folder; - is standard output"), "{words}: {said}");
        assert!(!folder.path("-").exists(), "{words}");
    }
}

#[test]
fn a_full_disk_leaves_nothing_torn() {
    let folder = Folder::new();
    folder.write("old.png", "mine");
    for (plot, force) in [("new.png", ""), ("old.png", " --force")] {
        let words = format!("solve case.toml --elements reduced --plot {plot}{force}");
        // A file must not be longer than some kilobytes: writing fails in the middle, as on a full disk.
        let limited = "trap '' XFSZ; ulimit -f 4; exec \"$0\" \"$@\"";
        let output = Command::new("sh")
            .args(["-c", limited, env!("CARGO_BIN_EXE_fre")])
            .args(words.split(' '))
            .current_dir(folder.0.path())
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        // The file beside it has a name of its own.
        let (before, _) = said.split_once(" at path").unwrap_or((&said, ""));
        assert_eq!(before, format!("fre: --plot: {plot} cannot be written: File too large (os error 27)"));
    }
    assert_eq!(folder.read("old.png"), "mine");
    let names: Vec<String> = fs::read_dir(folder.0.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.contains("png"))
        .collect();
    assert_eq!(names, ["old.png"], "nothing else is left");
}

/// Standard output on a full disk is an error; a reader that has gone is none.
#[cfg(unix)]
#[test]
fn a_full_disk_or_a_closed_pipe_panics_no_command() {
    let folder = Folder::new();
    for words in ["solve case.toml --elements reduced", "sweep case.toml --elements reduced", "--help", "--version"] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = folder.command(words).stdout(full).stderr(Stdio::piped()).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let full = "fre: standard output: No space left on device (os error 28)\n";
        assert_eq!((output.status.code(), said.as_str()), (Some(1), full), "{words}");
        let mut child = folder.command(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{words}: {said}");
    }
}
