//! Photographs that were never taken: a solved finger through a known camera. Nothing here uses the code under test.
//!
//! A crate of its own: what draws is optimised, and the tests that use it need not be.

use std::path::Path;

use image::{GrayImage, Luma};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};
use rayon::prelude::*;
use tiny_skia::{FillRule, LineCap, Paint, PathBuilder, Pixmap, Stroke, Transform};

/// Pixels per mm of the sheet on which the plane is drawn.
const SHEET: f64 = 40.0;
/// Corner of the sheet with the least x and y, mm.
const CORNER: [f64; 2] = [-55.0, -30.0];
/// Extent of the sheet, mm.
const EXTENT: [f64; 2] = [130.0, 140.0];
/// Samples per pixel, each way.
const SAMPLES: usize = 3;

/// Light of what is in the plane, 0 to 255.
#[derive(Clone, Copy)]
pub struct Lights {
    /// Of the background.
    pub ground: u8,
    /// Of the finger.
    pub finger: u8,
    /// Of the object.
    pub object: u8,
    /// Of the marks.
    pub dots: u8,
}

/// A dark finger before a bright background.
pub const DARK_FINGER: Lights = Lights { ground: 215, finger: 28, object: 95, dots: 15 };
/// A bright finger before a dark background.
pub const BRIGHT_FINGER: Lights = Lights { ground: 30, finger: 205, object: 110, dots: 235 };

/// A plane with light on it, mm.
pub struct Sheet {
    width: usize,
    light: Vec<u8>,
    ground: f32,
}

impl Sheet {
    /// A plane with the background's light, and what is drawn on it.
    pub fn draw(lights: Lights, draw: impl FnOnce(&mut Pen)) -> Self {
        let size = EXTENT.map(|mm| (mm * SHEET) as u32);
        let mut pixmap = Pixmap::new(size[0], size[1]).unwrap();
        pixmap.fill(tiny_skia::Color::from_rgba8(lights.ground, lights.ground, lights.ground, 255));
        let mut pen = Pen { pixmap };
        draw(&mut pen);
        let light = pen.pixmap.data().chunks(4).map(|rgba| rgba[0]).collect();
        Self { width: size[0] as usize, light, ground: f32::from(lights.ground) }
    }

    /// Light at a place, 0 to 1.
    fn at(&self, mm: [f64; 2]) -> f32 {
        // A sheet's pixel covers a square: its middle lies half a pixel inside.
        let x = (mm[0] - CORNER[0]) * SHEET - 0.5;
        let y = (mm[1] - CORNER[1]) * SHEET - 0.5;
        let (left, below) = (x.floor(), y.floor());
        let (u, v) = ((x - left) as f32, (y - below) as f32);
        let pixel = |dx: i64, dy: i64| {
            let (column, row) = (left as i64 + dx, below as i64 + dy);
            let inside = (0..self.width as i64).contains(&column) && row >= 0;
            let index = (row * self.width as i64 + column) as usize;
            if inside { self.light.get(index).map_or(self.ground, |&l| f32::from(l)) } else { self.ground }
        };
        let low = pixel(0, 0) + u * (pixel(1, 0) - pixel(0, 0));
        let high = pixel(0, 1) + u * (pixel(1, 1) - pixel(0, 1));
        (low + v * (high - low)) / 255.0
    }
}

/// Draws in mm.
pub struct Pen {
    pixmap: Pixmap,
}

impl Pen {
    /// A line through points, of a width (mm) and a light.
    pub fn line(&mut self, points: &[[f64; 2]], width: f64, light: u8) {
        let mut path = PathBuilder::new();
        for (i, p) in points.iter().enumerate() {
            let [x, y] = [((p[0] - CORNER[0]) * SHEET) as f32, ((p[1] - CORNER[1]) * SHEET) as f32];
            if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
        }
        let stroke = Stroke { width: (width * SHEET) as f32, line_cap: LineCap::Butt, ..Stroke::default() };
        self.pixmap.stroke_path(&path.finish().unwrap(), &paint(light), &stroke, Transform::identity(), None);
    }

    /// A disc of a radius (mm) and a light.
    pub fn disc(&mut self, centre: [f64; 2], radius: f64, light: u8) {
        let [x, y] = [((centre[0] - CORNER[0]) * SHEET) as f32, ((centre[1] - CORNER[1]) * SHEET) as f32];
        let path = PathBuilder::from_circle(x, y, (radius * SHEET) as f32).unwrap();
        self.pixmap.fill_path(&path, &paint(light), FillRule::Winding, Transform::identity(), None);
    }
}

fn paint(light: u8) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(light, light, light, 255);
    paint
}

/// A camera: focal length and principal point in pixels, distortion (k1, k2, p1, p2), and where the plane lies.
#[derive(Clone, Copy)]
pub struct Eye {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Focal length along x and y, pixels.
    pub focal: [f64; 2],
    /// Principal point, pixels.
    pub centre: [f64; 2],
    /// Distortion: k1, k2, p1, p2.
    pub lens: [f64; 4],
    /// Columns of the plane's pose: its x axis, its y axis, its origin, in the camera's frame (x right, y down, z ahead).
    pub pose: [[f64; 3]; 3],
}

impl Eye {
    /// Looks at a place (mm) from a distance, tilted about the picture's x and y axes and rolled, degrees.
    pub fn looking_at(mut self, place: [f64; 2], distance: f64, tilt: [f64; 3], mirrored: bool) -> Self {
        let [a, b, c] = tilt.map(f64::to_radians);
        let turn = |p: [f64; 3]| {
            let [x, y, z] = p;
            let (x, y) = (c.cos() * x - c.sin() * y, c.sin() * x + c.cos() * y);
            let (x, z) = (b.cos() * x + b.sin() * z, -b.sin() * x + b.cos() * z);
            let (y, z) = (a.cos() * y - a.sin() * z, a.sin() * y + a.cos() * z);
            [x, y, z]
        };
        let x_axis = turn([if mirrored { -1.0 } else { 1.0 }, 0.0, 0.0]);
        let y_axis = turn([0.0, -1.0, 0.0]);
        let origin: Vec<f64> = (0..3).map(|i| -place[0] * x_axis[i] - place[1] * y_axis[i]).collect();
        self.pose = [x_axis, y_axis, [origin[0], origin[1], origin[2] + distance]];
        self
    }

    fn distorted(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [k1, k2, p1, p2] = self.lens;
        let r2 = x * x + y * y;
        let radial = 1.0 + k1 * r2 + k2 * r2 * r2;
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// Pixel of a place of the plane.
    pub fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [a, b, o] = self.pose;
        let p: Vec<f64> = (0..3).map(|i| x * a[i] + y * b[i] + o[i]).collect();
        let [u, v] = self.distorted([p[0] / p[2], p[1] / p[2]]);
        [self.focal[0] * u + self.centre[0], self.focal[1] * v + self.centre[1]]
    }

    /// Place of the plane that a pixel sees: the distortion undone by fixed point, then the ray cut with the plane.
    fn place(&self, pixel: [f64; 2]) -> [f64; 2] {
        let wanted = [(pixel[0] - self.centre[0]) / self.focal[0], (pixel[1] - self.centre[1]) / self.focal[1]];
        let mut at = wanted;
        if self.lens != [0.0; 4] {
            for _ in 0..12 {
                let [x, y] = self.distorted(at);
                at = [at[0] + wanted[0] - x, at[1] + wanted[1] - y];
            }
        }
        // x·(a₀ − u a₂) + y·(b₀ − u b₂) = u o₂ − o₀, and the same with v.
        let ([a, b, o], [u, v]) = (self.pose, at);
        let (m, n, r) = (a[0] - u * a[2], b[0] - u * b[2], u * o[2] - o[0]);
        let (p, q, s) = (a[1] - v * a[2], b[1] - v * b[2], v * o[2] - o[1]);
        let determinant = m * q - n * p;
        [(r * q - n * s) / determinant, (m * s - r * p) / determinant]
    }

    /// A photograph of what `light` (0 to 1) tells of the plane, blurred (pixels) and with noise (of 255).
    pub fn photograph(&self, light: impl Fn([f64; 2]) -> f32 + Sync, blur: f64, noise: f64, seed: u64) -> GrayImage {
        self.taken(&light, blur, noise, seed)
    }

    fn taken(&self, light: &(dyn Fn([f64; 2]) -> f32 + Sync), blur: f64, noise: f64, seed: u64) -> GrayImage {
        let [width, height] = self.size;
        let sharp: Vec<f32> = (0..width * height)
            .into_par_iter()
            .map(|index| {
                let (x, y) = ((index % width) as f64, (index / width) as f64);
                let mut sum = 0.0;
                for i in 0..SAMPLES * SAMPLES {
                    let offset = |k: usize| (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
                    sum += light(self.place([x + offset(i % SAMPLES), y + offset(i / SAMPLES)]));
                }
                sum / (SAMPLES * SAMPLES) as f32
            })
            .collect();
        let light = blurred(&blurred(&sharp, width, blur, 1), width, blur, width);
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        // The sum of twelve uniform numbers is normal enough, its variance is 1.
        let mut normal = || (0..12).map(|_| f64::from(random.next_u32()) / f64::from(u32::MAX)).sum::<f64>() - 6.0;
        GrayImage::from_fn(width as u32, height as u32, |x, y| {
            let light = f64::from(light[y as usize * width + x as usize]);
            let code = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
            Luma([(255.0 * code + noise * normal()).round().clamp(0.0, 255.0) as u8])
        })
    }
}

/// Gaussian blur along rows (`stride` 1) or columns (`stride` the width).
fn blurred(light: &[f32], width: usize, sigma: f64, stride: usize) -> Vec<f32> {
    let reach = (3.0 * sigma).ceil() as i64;
    let weights: Vec<f32> = (-reach..=reach).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp() as f32).collect();
    let sum: f32 = weights.iter().sum();
    let height = light.len() / width;
    (0..light.len())
        .into_par_iter()
        .map(|index| {
            let (x, y) = (index % width, index / width);
            let (at, last) = if stride == 1 { (x, width - 1) } else { (y, height - 1) };
            let start = index - at * stride;
            let each = weights.iter().zip(-reach..).map(|(w, i)| {
                let at = (at as i64 + i).clamp(0, last as i64) as usize;
                w * light[start + at * stride]
            });
            each.sum::<f32>() / sum
        })
        .collect()
}

impl Sheet {
    /// Light of the plane's places, 0 to 1.
    pub fn light(&self) -> impl Fn([f64; 2]) -> f32 + Sync + '_ {
        |mm| self.at(mm)
    }
}

/// Light of a checkerboard of 10 by 7 squares of 12 mm with its first inner corner at the origin, on white.
pub fn checkerboard([x, y]: [f64; 2]) -> f32 {
    let (i, j) = ((x / 12.0).floor() + 1.0, (y / 12.0).floor() + 1.0);
    let dark = (0.0..10.0).contains(&i) && (0.0..7.0).contains(&j) && (i + j).rem_euclid(2.0) < 0.5;
    if dark { 0.04 } else { 0.8 }
}

/// Writes a picture in the format of the file's name.
pub fn save(picture: &GrayImage, path: &Path) {
    picture.save(path).unwrap();
}
