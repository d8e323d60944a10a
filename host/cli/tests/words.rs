//! The messages of what goes wrong, whole. `TRYCMD=overwrite cargo test -p fre-cli --test words` writes the file anew; what changed is
//! then seen in the difference. (The help is held by `docs/cli.md`.)

use trycmd::TestCases;

#[test]
fn errors() {
    // At a terminal's usual width, without what this machine's own user has set.
    let cases = TestCases::new();
    cases.env("COLUMNS", "100").env("FRE_LINK", "").env("FRE_JOBS", "0");
    cases.case("tests/words/errors.trycmd");
}
