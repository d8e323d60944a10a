//! The finger and the object that the costs are quoted for: `ladder-80`, a cylinder of 80 mm at Mid height.

use anyhow::{Context, Result};
use model_core::design::Design;
use model_core::discretise::{Discretisation, Physics};
use model_core::equilibrium::Follower;
use model_core::real::Real;
use model_core::size::Size;
use reference_tests::closing::{Closing, LADDER};

/// Both physics and their words in tables and documents.
pub const PHYSICS: [Physics; 2] = [Physics::Paper, Physics::Extended];

/// A physics' word in tables and documents.
pub fn word(physics: Physics) -> &'static str {
    match physics {
        Physics::Paper => "paper",
        Physics::Extended => "extended",
    }
}

/// A follower of the finger on the object.
pub fn follower<T: Real, S: Size>(how: &Discretisation) -> Result<Box<Follower<T, S>>> {
    follower_on(&LADDER, how)
}

/// A follower of a finger on its object.
pub fn follower_on<T: Real, S: Size>(closing: &Closing, how: &Discretisation) -> Result<Box<Follower<T, S>>> {
    made(&(closing.design)(), closing, how)
}

/// A follower of another finger on the same object.
pub fn follower_of<T: Real, S: Size>(design: &Design, how: &Discretisation) -> Result<Box<Follower<T, S>>> {
    made(design, &LADDER, how)
}

fn made<T: Real, S: Size>(design: &Design, closing: &Closing, how: &Discretisation) -> Result<Box<Follower<T, S>>> {
    let mut follower = Box::new(Follower::EMPTY);
    follower.configure(design, how).with_context(|| format!("{how:?}"))?;
    follower.set_object((closing.object)(), closing.motion(design));
    Ok(follower)
}

/// Counts of closing to the last one and opening again.
pub fn counts(last: i32) -> impl Iterator<Item = i32> {
    (0..=last).chain((0..last).rev())
}

#[cfg(test)]
mod tests {
    use fre::case::Case;
    use reference_tests::closing::UMI;

    /// The finger on the target is the preset.
    #[test]
    fn umi_is_the_preset() {
        let text = "finger = \"preset:umi\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [40.9, 65]\n\
            [motion]\ndirection = [1, 0]\ndistances_mm = [10]\n";
        let case = Case::parse("umi.toml", text).unwrap();
        assert_eq!(case.finger.design, (UMI.design)());
    }
}
