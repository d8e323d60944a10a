#![allow(missing_docs)]
#[path = "explore.rs"]
#[allow(dead_code)]
mod explore;
use model_core::{discretise::*, equilibrium::*, object::*, size::*};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
fn main() {
    let want: usize = std::env::args().nth(1).unwrap().parse().unwrap();
    let mut r = ChaCha8Rng::seed_from_u64(1);
    let mut it = None;
    for _ in 0..=want {
        it = Some(explore::random(&mut r));
    }
    let (d, o, ind) = it.unwrap();
    let mut f = Box::new(Follower::<f64, Reduced>::EMPTY);
    f.configure(&d, &Discretisation::reduced(Physics::Paper)).unwrap();
    f.set_object(o, Motion::Rotating { axis: d.motor_axis });
    f.start(0.5);
    let at = f.coordinate();
    println!("{:?}", f.follow(at + ind.to_radians()));
}
