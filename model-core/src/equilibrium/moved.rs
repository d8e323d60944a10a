//! How the object has moved in the world since the accepted state, besides the finger's own motion.

use crate::object::Displacement;
use crate::real::{Real, Vec2};

/// A rigid displacement of the object in the world.
#[derive(Clone, Copy)]
pub(crate) struct Moved<T> {
    /// The point that it turns about, mm.
    pub about: [T; 2],
    /// By how much, rad, counter-clockwise.
    pub turn: T,
    /// By how much that point is shifted, mm.
    pub shift: [T; 2],
}

impl<T: Real> Moved<T> {
    /// None.
    pub const NONE: Self = Self { about: [T::ZERO; 2], turn: T::ZERO, shift: [T::ZERO; 2] };

    /// As it maps the world's points.
    pub fn displacement(&self) -> Displacement<T> {
        let nowhere = Displacement { rotation: Vec2::new(T::one(), T::ZERO), translation: Vec2::new(T::ZERO, T::ZERO) };
        self.before(&nowhere, &nowhere, T::ZERO).0
    }

    /// How the object's points move in the finger's frame, and by how much they turn: first as the object moves in the world, which `here` maps
    /// into that frame, then as the frame does, `by` and `turned`.
    pub fn before(&self, here: &Displacement<T>, by: &Displacement<T>, turned: T) -> (Displacement<T>, T) {
        let stands = self.turn == T::ZERO && self.shift == [T::ZERO; 2];
        if stands {
            return (*by, turned);
        }
        let [[x, y], [u, v]] = [self.about, self.shift];
        let from = here.point(Vec2::new(x, y));
        let step = here.vector(Vec2::new(u, v));
        let (sin, cos) = self.turn.sin_cos();
        let rotation = Vec2::new(by.rotation.x * cos - by.rotation.y * sin, by.rotation.y * cos + by.rotation.x * sin);
        let moved = Displacement { rotation, translation: step + by.moves(from + step) };
        (moved.about(from), turned + self.turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::object::Motion;

    /// A point that goes with the object, seen from the finger before and after a step of both.
    #[test]
    fn a_point_of_the_object_goes_where_object_and_frame_take_it() {
        let moved = Moved { about: [30.0, 44.0], turn: 0.2, shift: [1.5, -0.7] };
        let (sin, cos) = 0.2_f64.sin_cos();
        let [x, y] = [12.0, 51.0];
        let now = [30.0 + 1.5 + cos * (x - 30.0) - sin * (y - 44.0), 44.0 - 0.7 + sin * (x - 30.0) + cos * (y - 44.0)];
        let image = moved.displacement().point(Vec2::new(x, y));
        assert!((image.x - now[0]).hypot(image.y - now[1]) < 1e-12);
        for motion in [Motion::Rotating { axis: [-14.0, -20.0] }, Motion::Translating { direction: [0.6, 0.8] }] {
            let (here, there) = (motion.world_to_finger(0.1), motion.world_to_finger(0.25));
            let turned = if matches!(motion, Motion::Rotating { .. }) { 0.15 } else { 0.0 };
            let (by, angle) = moved.before(&here, &motion.world_to_finger(0.15), turned);
            let found = by.point(here.point(Vec2::new(x, y)));
            let expected = there.point(Vec2::new(now[0], now[1]));
            assert!((found.x - expected.x).hypot(found.y - expected.y) < 1e-12, "{motion:?}");
            assert!((angle - turned - 0.2).abs() < 1e-15);
            assert!((by.rotation.y.atan2(by.rotation.x) - angle).abs() < 1e-12);
        }
    }
}
