//! Where one frame is in another, and an object seen from both.

use super::ObjectDesign;

/// Where a frame is in an outer one: p ↦ R(angle) p′ + translation, with p′ = p, or p reflected in the y axis where it is mirrored.
/// In a grasp the frame is a finger's own world (its frame with the base at coordinate 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Reflected, x ↦ −x: the other finger of a pair.
    pub mirrored: bool,
    /// Turn, rad, counter-clockwise.
    pub angle: f64,
    /// Where its origin is, mm.
    pub translation: [f64; 2],
}

impl Placement {
    /// Both frames are one.
    pub const HERE: Self = Self { mirrored: false, angle: 0.0, translation: [0.0; 2] };

    /// −1 where it is mirrored: what turns one way here turns the other way there.
    pub(crate) fn sense(&self) -> f64 {
        if self.mirrored { -1.0 } else { 1.0 }
    }

    /// A vector of the placed frame in the outer one.
    pub fn vector(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.angle);
        let x = self.sense() * x;
        [cos * x - sin * y, sin * x + cos * y]
    }

    /// A point of the placed frame in the outer one, mm.
    pub fn point(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.vector(p);
        [x + self.translation[0], y + self.translation[1]]
    }

    /// A vector of the outer frame in the placed one.
    pub fn vector_back(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.angle);
        [self.sense() * (cos * x + sin * y), cos * y - sin * x]
    }

    /// A point of the outer frame in the placed one, mm.
    pub fn point_back(&self, p: [f64; 2]) -> [f64; 2] {
        self.vector_back([p[0] - self.translation[0], p[1] - self.translation[1]])
    }

    /// An object of the outer frame as the placed one sees it.
    pub fn object_back(&self, object: &ObjectDesign) -> ObjectDesign {
        match *object {
            ObjectDesign::Circle { centre, radius } => ObjectDesign::Circle { centre: self.point_back(centre), radius },
            ObjectDesign::Ellipse { centre, semi_axes, angle } => ObjectDesign::Ellipse {
                centre: self.point_back(centre),
                semi_axes,
                angle: self.sense() * (angle - self.angle),
            },
            ObjectDesign::Polygon { corners, rounding } => {
                ObjectDesign::Polygon { corners: corners.map(|corner| self.point_back(corner)), rounding }
            }
            ObjectDesign::HalfPlane { point, normal } => {
                ObjectDesign::HalfPlane { point: self.point_back(point), normal: self.vector_back(normal) }
            }
            ObjectDesign::Bore { centre, radius } => ObjectDesign::Bore { centre: self.point_back(centre), radius },
        }
    }
}

impl ObjectDesign {
    /// What a free object is held by: its reference point (the centre, or the mean of a polygon's corners), and how far it reaches
    /// from there, mm; none for a half-plane.
    pub fn reference(&self) -> Option<([f64; 2], f64)> {
        match self {
            Self::Circle { centre, radius } | Self::Bore { centre, radius } => Some((*centre, *radius)),
            Self::Ellipse { centre, semi_axes, .. } => Some((*centre, semi_axes[0].max(semi_axes[1]))),
            Self::Polygon { corners, rounding } => {
                let part = 1.0 / corners.len() as f64;
                let middle = corners.iter().fold([0.0; 2], |sum, p| [sum[0] + part * p[0], sum[1] + part * p[1]]);
                let far = corners.iter().map(|p| libm::hypot(p[0] - middle[0], p[1] - middle[1])).fold(0.0, f64::max);
                Some((middle, far + rounding))
            }
            Self::HalfPlane { .. } => None,
        }
    }

    /// The object after a motion that takes one point to another and turns it about that by an angle, rad.
    pub fn moved(&self, from: [f64; 2], to: [f64; 2], turn: f64) -> Self {
        // Seen from a frame in which the motion has not happened.
        let (sin, cos) = libm::sincos(turn);
        let image = [cos * from[0] - sin * from[1], sin * from[0] + cos * from[1]];
        let motion = Placement { mirrored: false, angle: turn, translation: [to[0] - image[0], to[1] - image[1]] };
        let back = motion.vector_back([-motion.translation[0], -motion.translation[1]]);
        Placement { mirrored: false, angle: -turn, translation: back }.object_back(self)
    }
}
