//! Mass and inertia of an extruded outline.

use crate::finger::{Loop, cross};

/// Mass, centre and inertia of a solid of one density, in the finger frame, SI units. Its middle plane is z = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass in the plane, m.
    pub centre: [f64; 2],
    /// Moments about the centre of mass, kg·m²: xx, yy, zz.
    pub moments: [f64; 3],
    /// Product of inertia xy as URDF has it, −∫xy dm, kg·m².
    pub product: f64,
}

impl Solid {
    /// Of loops around material (counter-clockwise) and around windows (clockwise), mm; `width` mm; `density` kg/m³.
    ///
    /// Every moment of the plane figure is a sum over its edges (Green's theorem), exact for polygons.
    pub fn of(loops: &[Loop], width: f64, density: f64) -> Self {
        let mut area = 0.0;
        let (mut first, mut second, mut mixed) = ([0.0; 2], [0.0; 2], 0.0);
        for points in loops {
            for (&a, &b) in points.iter().zip(points.iter().cycle().skip(1)) {
                let turn = cross(a, b);
                area += turn / 2.0;
                for axis in [0, 1] {
                    first[axis] += turn * (a[axis] + b[axis]) / 6.0;
                    second[axis] += turn * (a[axis] * a[axis] + a[axis] * b[axis] + b[axis] * b[axis]) / 12.0;
                }
                mixed += turn * (a[0] * b[1] + 2.0 * a[0] * a[1] + 2.0 * b[0] * b[1] + b[0] * a[1]) / 24.0;
            }
        }
        let [x, y] = first.map(|moment| moment / area);
        // mm to m: an area's mass is mm² · mm · kg/m³ · 1e-9, a second moment has two more lengths.
        let plane = 1e-9 * density * width;
        let mass = plane * area;
        let [xx, yy] = [(second[0], x), (second[1], y)].map(|(second, at)| 1e-6 * plane * (second - area * at * at));
        let thick = mass * (1e-3 * width).powi(2) / 12.0;
        Self {
            mass,
            centre: [1e-3 * x, 1e-3 * y],
            moments: [yy + thick, xx + thick, xx + yy],
            product: -1e-6 * plane * (mixed - area * x * y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Solid;

    /// A box of 20 × 40 × 10 mm with a window of 10 × 20 mm in its middle: sums of boxes are in every handbook.
    #[test]
    fn a_box_with_a_window_has_the_moments_of_a_handbook() {
        let around = vec![[5.0, 7.0], [25.0, 7.0], [25.0, 47.0], [5.0, 47.0]];
        let window = vec![[10.0, 17.0], [10.0, 37.0], [20.0, 37.0], [20.0, 17.0]];
        let solid = Solid::of(&[around, window], 10.0, 1000.0);
        let near = |found: f64, wanted: f64| {
            assert!((found - wanted).abs() < 1e-12 * wanted.abs().max(1e-3), "{found} {wanted}")
        };
        near(solid.mass, 0.006);
        near(solid.centre[0], 0.015);
        near(solid.centre[1], 0.027);
        let moment = |mass: f64, a: f64, b: f64| mass * (a * a + b * b) / 12.0;
        let [whole, cut] = [0.008, 0.002];
        near(solid.moments[0], moment(whole, 0.04, 0.01) - moment(cut, 0.02, 0.01));
        near(solid.moments[1], moment(whole, 0.02, 0.01) - moment(cut, 0.01, 0.01));
        near(solid.moments[2], moment(whole, 0.02, 0.04) - moment(cut, 0.01, 0.02));
        near(solid.product, 0.0);
    }

    /// A right triangle's product of inertia about its centre is −m·a·b/36 as an integral, with the sign of URDF +.
    #[test]
    fn a_right_triangle_has_its_product_of_inertia() {
        let solid = Solid::of(&[vec![[0.0, 0.0], [30.0, 0.0], [0.0, 60.0]]], 2.0, 1000.0);
        let mass = 0.0018;
        assert!((solid.mass - mass).abs() < 1e-15);
        assert!((solid.product - mass * 0.03 * 0.06 / 36.0).abs() < 1e-18, "{}", solid.product);
    }
}
