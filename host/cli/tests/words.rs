//! The messages of what goes wrong, and each command's short help, whole. `TRYCMD=overwrite cargo test -p fre-cli --test words` writes
//! the files anew; what changed is then seen in the difference. (`docs/cli.md` has the long help.)

use trycmd::TestCases;

/// At a terminal's usual width, without what this machine's own user has set.
fn said(file: &str) {
    let cases = TestCases::new();
    cases.env("COLUMNS", "100").env("FRE_JOBS", "0");
    for unset in ["FRE_LINK", "FRE_BUS", "FRE_PROBE"] {
        cases.env(unset, "");
    }
    cases.case(file);
}

#[test]
fn errors() {
    said("tests/words/errors.trycmd");
}

/// Where the environment says where something is.
#[test]
fn what_the_environment_names_is_used_or_refused() {
    let said = |variables: &[(&str, &str)], words: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_fre"));
        for unset in ["FRE_LINK", "FRE_BUS"] {
            command.env_remove(unset);
        }
        let output = command.envs(variables.iter().copied()).args(words.split(' ')).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{words}");
        String::from_utf8(output.stderr).unwrap()
    };
    let (link, bus) = (("FRE_LINK", "unix:nowhere"), ("FRE_BUS", "unix:elsewhere"));
    assert_eq!(
        said(&[link, bus], "monitor"),
        "fre: FRE_LINK and FRE_BUS are both set; --link or --bus says which of them is meant\n"
    );
    let opened = "cannot be opened: No such file or directory (os error 2)\n";
    assert_eq!(said(&[link], "monitor"), format!("fre: the link unix:nowhere {opened}"));
    assert_eq!(said(&[link, bus], "monitor --link unix:third"), format!("fre: the link unix:third {opened}"));
    // Which serial ports there are instead depends on this machine.
    let unopened = said(&[bus], "monitor");
    assert_eq!(unopened.split(';').next(), Some(format!("fre: the bus unix:elsewhere {}", opened.trim_end()).as_str()));
    assert_eq!(
        said(&[("FRE_BUS", "tcp:")], "monitor"),
        "fre: FRE_BUS in the environment: `tcp:` is not a link: host or port is missing; allowed are unix:PATH, tcp:HOST:PORT, \
         PORT and PORT@BAUD\n"
    );
    assert_eq!(
        said(&[link], "monitor --case case.toml"),
        "fre: --case is for --bus only; here the source is a gripper (--link, or FRE_LINK in the environment)\n"
    );
}

#[test]
fn short_help() {
    said("tests/words/help.trycmd");
}
