//! What a person reads, whole: the help of every command, and the messages of what goes wrong. `TRYCMD=overwrite cargo test -p fre-cli
//! --test words` writes the files anew; what changed is then seen in the difference.

use trycmd::TestCases;

/// Programs at a terminal's usual width, without what this machine's own user has set.
fn cases() -> TestCases {
    let cases = TestCases::new();
    cases.env("COLUMNS", "100").env("FRE_LINK", "").env("FRE_JOBS", "0");
    cases
}

#[test]
fn help() {
    cases().case("tests/words/help/*.trycmd");
}

#[test]
fn errors() {
    cases().case("tests/words/errors.trycmd");
}
