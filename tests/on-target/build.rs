//! Links the test image, and computes on the PC what the target must reproduce bit for bit.

#[path = "src/sweep.rs"]
mod sweep;

use model_core::discretise::Physics;
use model_core::estimator::Estimator;
use model_core::size::Rubbing;
use std::path::PathBuf;

fn main() {
    for script in ["link.x", "defmt.x", "embedded-test.x"] {
        println!("cargo::rustc-link-arg=-T{script}");
    }
    println!("cargo::rustc-check-cfg=cfg(rust_analyzer)");

    let mut estimator = Box::new(Estimator::EMPTY);
    let mut digests = Vec::new();
    for physics in [Physics::Paper, Physics::Extended] {
        for height in sweep::HEIGHTS {
            let mut digest = sweep::DIGEST;
            let lost = sweep::closing_and_opening(&mut estimator, physics, height, |numbers| {
                digest = numbers.into_iter().fold(digest, sweep::mix);
            });
            digests.push((digest, lost));
        }
    }
    let mut rubbing = Box::new(Estimator::<f32, Rubbing>::EMPTY);
    let campaigns = sweep::CASES.map(|case| {
        let mut digest = sweep::DIGEST;
        let mix = |numbers: [f32; 3], _, ()| digest = numbers.into_iter().fold(digest, sweep::mix);
        let sound = if case.friction > 0.0 {
            sweep::campaign(&mut rubbing, &case, |work| work(), mix)
        } else {
            sweep::campaign(&mut estimator, &case, |work| work(), mix)
        };
        assert!(sound, "the campaign's finger and objects are sound");
        digest
    });
    let folder = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    let text = format!(
        "/// Digest and lost ticks per physics and height, as the PC computes them.\npub const ON_THE_PC: [(u64, usize); {}] = {digests:?};\n\
         /// The campaign's digest of each case.\npub const CAMPAIGN_ON_THE_PC: [u64; 5] = {campaigns:?};\n",
        digests.len()
    );
    std::fs::write(folder.join("on_the_pc.rs"), text).expect("the build folder can be written");
}
