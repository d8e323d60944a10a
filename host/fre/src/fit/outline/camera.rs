//! A camera with lens distortion, after Brown ("Decentering Distortion of Lenses", 1966) and Zhang ("A Flexible New Technique
//! for Camera Calibration", 2000).

use serde::{Deserialize, Serialize};

/// Most Newton steps for a distorted place's undistorted one.
const STEPS: usize = 50;

/// Focal lengths, principal point and distortion; of one picture size and one focus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Width and height of its pictures, pixels.
    pub size_px: [u32; 2],
    /// Focal lengths f_x, f_y, pixels.
    pub focal_px: [f64; 2],
    /// Principal point, pixels.
    pub centre_px: [f64; 2],
    /// Radial distortion k₁, k₂.
    pub radial: [f64; 2],
    /// Tangential distortion p₁, p₂.
    pub tangential: [f64; 2],
}

impl Camera {
    /// Pixel of a normalised place (x/z, y/z of a point before the camera).
    pub fn pixel(&self, place: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.distort(place);
        [self.focal_px[0] * x + self.centre_px[0], self.focal_px[1] * y + self.centre_px[1]]
    }

    /// Normalised place of a pixel; none if the distortion has no inverse there.
    pub fn normalised(&self, pixel: [f64; 2]) -> Option<[f64; 2]> {
        let wanted =
            [(pixel[0] - self.centre_px[0]) / self.focal_px[0], (pixel[1] - self.centre_px[1]) / self.focal_px[1]];
        let mut place = wanted;
        for _ in 0..STEPS {
            let [x, y] = self.distort(place);
            let (ex, ey) = (wanted[0] - x, wanted[1] - y);
            if ex.hypot(ey) < 1e-13 {
                break;
            }
            let [[a, b], [c, d]] = self.derivative(place);
            let determinant = a * d - b * c;
            // Beyond the fold of a barrel distortion there is no place to be found.
            if determinant <= 0.0 {
                return None;
            }
            place[0] += (d * ex - b * ey) / determinant;
            place[1] += (a * ey - c * ex) / determinant;
        }
        let [x, y] = self.distort(place);
        ((wanted[0] - x).hypot(wanted[1] - y) < 1e-9).then_some(place)
    }

    fn distort(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let ([k1, k2], [p1, p2]) = (self.radial, self.tangential);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * k2);
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    fn derivative(&self, [x, y]: [f64; 2]) -> [[f64; 2]; 2] {
        let ([k1, k2], [p1, p2]) = (self.radial, self.tangential);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * k2);
        let slope = 2.0 * (k1 + 2.0 * k2 * r2);
        let mixed = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        [
            [radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, mixed],
            [mixed, radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x],
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: Camera = Camera {
        size_px: [1600, 1200],
        focal_px: [1800.0, 1790.0],
        centre_px: [810.0, 590.0],
        radial: [-0.28, 0.11],
        tangential: [0.002, -0.001],
    };

    #[test]
    fn a_pixel_leads_back_to_its_place() {
        for place in [[0.0, 0.0], [0.4, 0.3], [-0.42, 0.32], [0.1, -0.3]] {
            let back = CAMERA.normalised(CAMERA.pixel(place)).unwrap();
            assert!((back[0] - place[0]).hypot(back[1] - place[1]) < 1e-12, "{place:?} {back:?}");
        }
    }

    #[test]
    fn beyond_the_fold_there_is_no_place() {
        let barrel = Camera { radial: [-0.5, 0.0], tangential: [0.0; 2], ..CAMERA };
        // r(1 − 0.5 r²) is at most 0.544: no place has a distorted radius of 0.7.
        assert_eq!(barrel.normalised([810.0 + 0.7 * 1800.0, 590.0]), None);
    }
}
