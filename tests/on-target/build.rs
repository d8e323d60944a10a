//! Links the test image.

fn main() {
    for script in ["link.x", "defmt.x", "embedded-test.x"] {
        println!("cargo::rustc-link-arg=-T{script}");
    }
    println!("cargo::rustc-check-cfg=cfg(rust_analyzer)");
}
