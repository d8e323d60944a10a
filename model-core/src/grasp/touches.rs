//! Where a finger touches, as a grip's margin takes it.

use super::Touch;
use crate::equilibrium::Follower;
use crate::object::Object;
use crate::real::{Real, Vec2};
use crate::size::Size;

/// The places where a finger touches, in the axes of a grasp's world, around a point of the finger's own world (the object's reference
/// point), mm. `finger`: its number; `mirrored`: it is the mirror image (x ↦ −x). `force`: magnitude of its whole force, N, to which the
/// places' forces are scaled: an estimate with friction follows the angle with a play, and its force is corrected for the rest.
pub fn touches<T: Real, S: Size, O: Object<T>>(
    follower: &Follower<T, S, O>,
    finger: usize,
    mirrored: bool,
    about: [f64; 2],
    force: T,
) -> impl Iterator<Item = Touch<T>> {
    let about = about.map(T::of);
    let seen = move |[x, y]: [T; 2]| if mirrored { [-x, y] } else { [x, y] };
    let displacement = follower.displacement();
    let [x, y] = follower.solution().force_finger();
    let whole = (x * x + y * y).sqrt();
    let scale = if whole > T::ZERO { force / whole } else { T::of(1.0) };
    follower.solution().contacts().map(move |contact| {
        let [x, y] = follower.solution().to_world(contact.position);
        let [u, v] = contact.normal;
        let out = displacement.vector_back(Vec2::new(u, v));
        Touch {
            finger,
            point: seen([x - about[0], y - about[1]]),
            normal: seen([-out.x, -out.y]),
            force: scale * contact.force,
            friction: follower.friction(),
        }
    })
}
