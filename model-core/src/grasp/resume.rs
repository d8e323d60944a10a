//! A grasp taken up where it was left: one balance after another, each in bounded time, while the fingers go on moving.

use heapless::Vec;

use super::{Course, Finger, Grasp, GraspError, Load, Placement};
use crate::equilibrium::Follower;
use crate::object::ObjectDesign;
use crate::real::Real;
use crate::size::Size;

/// A finger on an object that may have moved.
pub struct Held<'a, T: Real, S: Size> {
    /// Its model, which has followed the object to its place.
    pub follower: &'a mut Follower<T, S>,
    /// The finger is the mirror image (x ↦ −x): the other one of a pair.
    pub mirrored: bool,
    /// The object where it was at first, in the finger's own world.
    pub object: ObjectDesign,
}

/// How far an object has come from where it was at first. Grasp's world: the axes of a finger that is not mirrored.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Of its reference point, mm.
    pub shift: [f64; 2],
    /// Turn, rad, counter-clockwise.
    pub turn: f64,
}

impl Place {
    /// The object when it has come this far, turned about its reference point (its centre, or the mean of a polygon's corners;
    /// a half-plane has none, and turns about the origin).
    pub fn of(&self, object: &ObjectDesign) -> ObjectDesign {
        let from = object.reference().map_or([0.0; 2], |(point, _)| point);
        object.moved(from, [from[0] + self.shift[0], from[1] + self.shift[1]], self.turn)
    }

    /// The same as a mirrored finger's own world has it.
    pub fn mirrored(self) -> Self {
        Self { shift: [-self.shift[0], self.shift[1]], turn: -self.turn }
    }
}

/// Difference in size or direction (mm, rad) up to which two fingers' objects are the same.
const ALIKE: f64 = 1e-3;

impl<'a, T: Real, S: Size> Grasp<'a, T, S> {
    /// Takes up fingers that are on an object at a place, without changing anything. The grasp's origin is where the
    /// object's reference point was at first.
    ///
    /// # Errors
    /// What is wrong with the number of fingers, the objects or the load.
    pub fn resume(
        held: impl IntoIterator<Item = Held<'a, T, S>>,
        load: Load,
        place: Place,
    ) -> Result<Self, GraspError> {
        let mut given = None;
        let mut fingers = Vec::new();
        for (number, Held { follower, mirrored, object }) in held.into_iter().enumerate() {
            object.validate().map_err(GraspError::Object)?;
            let (middle, _) = object.reference().ok_or(GraspError::Endless)?;
            let here = Placement { mirrored, ..Placement::HERE };
            // The same world, seen from the grasp's: the way there is the way back of its mirror image.
            let seen = Placement { translation: middle, ..here }.object_back(&object);
            if !are_alike(&seen, given.get_or_insert(seen)) {
                return Err(GraspError::Different { finger: number });
            }
            let placement = Placement { translation: here.vector(middle).map(|x| -x), ..here };
            let motion = follower.motion;
            let pushed = fingers.push(Finger { follower, placement, motion });
            pushed.map_err(|_| GraspError::Fingers { count: number + 1 })?;
        }
        let object = given.ok_or(GraspError::Fingers { count: 0 })?;
        let (origin, size) = object.reference().ok_or(GraspError::Endless)?;
        let [x, y] = place.shift;
        let mut grasp = Self {
            fingers,
            given: object,
            origin,
            size,
            load: Load::default(),
            centre: [origin[0] + x, origin[1] + y],
            turn: place.turn,
            begun: true,
            allowed: u32::MAX,
            spent: 0,
            course: Course::default(),
        };
        grasp.set_load(load)?;
        Ok(grasp)
    }

    /// Takes up what the last balance knew of the way: with friction the object then goes on as it went.
    pub fn with_course(self, course: Course) -> Self {
        Self { course, ..self }
    }

    /// What this balance leaves for the next one.
    pub fn course(&self) -> Course {
        self.course
    }

    /// How far the object has come.
    pub fn place(&self) -> Place {
        Place { shift: [self.centre[0] - self.origin[0], self.centre[1] - self.origin[1]], turn: self.turn }
    }
}

impl Place {
    /// Where an object is that was elsewhere at first, as a finger's own world sees it.
    pub fn seen(&self, object: &ObjectDesign, mirrored: bool) -> ObjectDesign {
        let Some((middle, _)) = object.reference() else { return *object };
        let here = Placement { mirrored, ..Placement::HERE };
        let [x, y] = here.vector_back(self.shift);
        object.moved(middle, [middle[0] + x, middle[1] + y], here.sense() * self.turn)
    }
}

/// Whether two objects with the same reference point are the same.
fn are_alike(one: &ObjectDesign, other: &ObjectDesign) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= ALIKE;
    match (one, other) {
        (ObjectDesign::Circle { radius: a, .. }, ObjectDesign::Circle { radius: b, .. })
        | (ObjectDesign::Bore { radius: a, .. }, ObjectDesign::Bore { radius: b, .. }) => near(*a, *b),
        (
            ObjectDesign::Ellipse { semi_axes: a, angle: at, .. },
            ObjectDesign::Ellipse { semi_axes: b, angle: by, .. },
        ) => {
            // Half a turn changes nothing.
            near(a[0], b[0]) && near(a[1], b[1]) && libm::sin(at - by).abs() <= ALIKE
        }
        (ObjectDesign::Polygon { corners: a, rounding: r }, ObjectDesign::Polygon { corners: b, rounding: s }) => {
            let is_there = |p: &[f64; 2]| b.iter().any(|q| near(p[0], q[0]) && near(p[1], q[1]));
            near(*r, *s) && a.len() == b.len() && a.iter().all(is_there)
        }
        _ => false,
    }
}
