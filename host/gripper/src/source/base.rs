//! Where the base of a deformed finger is.

use messages::Shape;

/// From the finger frame of a [`Shape`] into the finger's world frame.
#[derive(Clone, Copy, Debug)]
pub struct Base {
    axis: [f64; 2],
    sin: f64,
    cos: f64,
    shift: [f64; 2],
}

impl Base {
    /// Of a shape whose design has this motor axis, mm.
    pub fn of(shape: &Shape, axis: [f64; 2]) -> Self {
        let (sin, cos) = f64::from(shape.motor_angle).sin_cos();
        Self { axis, sin, cos, shift: shape.shift.map(f64::from) }
    }

    /// A vector: R(−α), as positive angles close, clockwise.
    pub fn vector(&self, [x, y]: [f32; 2]) -> [f64; 2] {
        self.turned([f64::from(x), f64::from(y)])
    }

    /// A point, mm.
    pub fn point(&self, [x, y]: [f32; 2]) -> [f64; 2] {
        let [mx, my] = self.axis;
        let [x, y] = self.turned([f64::from(x) - mx, f64::from(y) - my]);
        [x + mx + self.shift[0], y + my + self.shift[1]]
    }

    fn turned(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [x * self.cos + y * self.sin, y * self.cos - x * self.sin]
    }
}
