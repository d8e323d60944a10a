//! A photograph in linear light.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Seek};
use std::path::Path;
use std::sync::Arc;

use image::{DynamicImage, GrayImage, ImageDecoder, ImageFormat, ImageReader, Rgb, RgbImage};

use super::error::OutlineError;
use super::limits::MOST_PIXELS;

/// What of the light is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// All of it, as the eye weighs it.
    White,
    /// One primary of sRGB.
    Red,
    /// One primary of sRGB.
    Green,
    /// One primary of sRGB.
    Blue,
}

impl Colour {
    /// The primaries.
    pub const PRIMARIES: [Self; 3] = [Self::Red, Self::Green, Self::Blue];

    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Self::White => "white",
            Self::Red => "red",
            Self::Green => "green",
            Self::Blue => "blue",
        }
    }

    /// Weights of red, green and blue; for white those of ITU-R BT.709, whose primaries sRGB has.
    fn weights(self) -> [f32; 3] {
        match self {
            Self::White => [0.2126, 0.7152, 0.0722],
            Self::Red => [1.0, 0.0, 0.0],
            Self::Green => [0.0, 1.0, 0.0],
            Self::Blue => [0.0, 0.0, 1.0],
        }
    }

    fn of([r, g, b]: [f32; 3], weights: [f32; 3]) -> f32 {
        weights[0] * linear(r) + weights[1] * linear(g) + weights[2] * linear(b)
    }
}

/// A photograph, upright as its EXIF orientation says. Pixel coordinates: x to the right, y down, the middle of the upper
/// left pixel at (0, 0).
pub struct Photo {
    /// Name for messages.
    pub name: String,
    width: usize,
    height: usize,
    /// Which light.
    colour: Colour,
    /// Linear light of that colour, 0 to 1, row by row. Cameras blur light, not the values that files keep: an edge's middle
    /// is half-way in light only.
    light: Vec<f32>,
    picture: Arc<RgbImage>,
    transparent: bool,
}

impl Photo {
    /// Reads PNG, JPEG, TIFF, BMP or WebP.
    ///
    /// # Errors
    /// The file cannot be read, is not such a picture, or has too many pixels.
    pub fn read(path: &Path) -> Result<Self, OutlineError> {
        let name = path.display().to_string();
        let unreadable = |error: io::Error| OutlineError::Unreadable { file: name.clone(), reason: error.to_string() };
        let file = File::open(path).map_err(unreadable)?;
        Self::decode(name, BufReader::new(file))
    }

    /// The same from any source; `name` stands for it in messages.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn decode(name: String, mut source: impl BufRead + Seek) -> Result<Self, OutlineError> {
        let unreadable = |error: image::ImageError| {
            let formats = match error {
                image::ImageError::Unsupported(_) => "; allowed are PNG, JPEG, TIFF, BMP and WebP",
                _ => "",
            };
            OutlineError::Unreadable { file: name.clone(), reason: format!("{error}{formats}") }
        };
        let reader = ImageReader::new(&mut source).with_guessed_format();
        let format = reader.map_err(|error| unreadable(error.into()))?.format();
        // The decoder makes grey of what is missing, in which no finger would be found.
        if format == Some(ImageFormat::Jpeg) {
            let mut bytes = Vec::new();
            let read = source.read_to_end(&mut bytes).and_then(|_| source.rewind());
            read.map_err(|error| unreadable(error.into()))?;
            if !jpeg_ends(&bytes) {
                let reason = "it is truncated: the file ends before the picture does".to_owned();
                return Err(OutlineError::Unreadable { file: name, reason });
            }
        }
        let reader = ImageReader::new(source).with_guessed_format();
        let reader = reader.map_err(|error| unreadable(error.into()))?;
        let mut decoder = reader.into_decoder().map_err(unreadable)?;
        let (width, height) = decoder.dimensions();
        if u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(OutlineError::TooManyPixels { file: name, width, height });
        }
        let orientation = decoder.orientation().map_err(unreadable)?;
        let mut image = DynamicImage::from_decoder(decoder).map_err(unreadable)?;
        image.apply_orientation(orientation);
        Ok(Self::new(name, &image))
    }

    /// Takes a picture with sRGB values, in white light. What is transparent gets a white background, as picture viewers show it: the
    /// colour that a file keeps under it means nothing.
    pub fn new(name: String, image: &DynamicImage) -> Self {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let colour = Colour::White;
        let weights = colour.weights();
        if image.color().has_alpha() {
            let values = image.to_rgba32f();
            let shown = |p: &image::Rgba<f32>| {
                let [r, g, b, alpha] = p.0;
                [r, g, b].map(|value| 1.0 + alpha * (value - 1.0))
            };
            let light = values.pixels().map(|p| Colour::of(shown(p), weights)).collect();
            let byte = |value: f32| (255.0 * value).round() as u8;
            let picture =
                RgbImage::from_fn(values.width(), values.height(), |x, y| Rgb(shown(values.get_pixel(x, y)).map(byte)));
            let transparent = values.pixels().any(|p| p.0[3] < 1.0);
            return Self { name, width, height, colour, light, picture: Arc::new(picture), transparent };
        }
        let light = image.to_rgb32f().pixels().map(|p| Colour::of(p.0, weights)).collect();
        Self { name, width, height, colour, light, picture: Arc::new(image.to_rgb8()), transparent: false }
    }

    /// True if white was put behind some of it.
    pub fn is_transparent(&self) -> bool {
        self.transparent
    }

    /// The same photograph in light of another colour, in 256 steps of each primary.
    pub fn in_light(&self, colour: Colour) -> Self {
        let weights = colour.weights();
        let of = |p: &image::Rgb<u8>| Colour::of(p.0.map(|value| f32::from(value) / 255.0), weights);
        let light = self.picture.pixels().map(of).collect();
        Self { name: self.name.clone(), colour, light, picture: self.picture.clone(), ..*self }
    }

    /// The colour of its light.
    pub fn colour(&self) -> Colour {
        self.colour
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.width as u32, self.height as u32]
    }

    /// The picture as it is shown.
    pub fn picture(&self) -> &RgbImage {
        &self.picture
    }

    /// The picture in 256 greys.
    pub fn grey(&self) -> GrayImage {
        image::imageops::grayscale(self.picture.as_ref())
    }

    /// True for a place between the middles of the outermost pixels.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        (0.0..=self.width as f64 - 1.0).contains(&x) && (0.0..=self.height as f64 - 1.0).contains(&y)
    }

    /// Light of a pixel; none outside.
    pub fn pixel(&self, x: i64, y: i64) -> Option<f64> {
        let (x, y) = (usize::try_from(x).ok()?, usize::try_from(y).ok()?);
        if x >= self.width {
            return None;
        }
        self.light.get(y * self.width + x).map(|&light| f64::from(light))
    }

    /// Light at a place between the pixels, bilinear; none outside.
    pub fn at(&self, place: [f64; 2]) -> Option<f64> {
        if !self.contains(place) {
            return None;
        }
        let [x, y] = place;
        let (left, top) = (x.floor(), y.floor());
        let (u, v) = (x - left, y - top);
        let (left, top) = (left as i64, top as i64);
        // On the last row or column the neighbour beyond has no weight.
        let pixel = |dx, dy| self.pixel(left + dx, top + dy).unwrap_or(0.0);
        Some((1.0 - v) * ((1.0 - u) * pixel(0, 0) + u * pixel(1, 0)) + v * ((1.0 - u) * pixel(0, 1) + u * pixel(1, 1)))
    }
}

/// True if a JPEG goes on to the mark of its end (ITU-T T.81, B.1 and B.2); what a camera puts behind that does not count.
fn jpeg_ends(bytes: &[u8]) -> bool {
    const END: u8 = 0xd9;
    const SCAN: u8 = 0xda;
    let mut at = 2;
    let mut in_scan = false;
    while let Some(&[first, marker]) = bytes.get(at..at + 2) {
        match (first, marker) {
            (0xff, END) => return true,
            // Filling, restarts and what is not coded have no length; in a scan a zero behind 0xff makes it data.
            (0xff, 0xff) => at += 1,
            (0xff, 0x00 | 0x01 | 0xd0..=0xd8) => at += 2,
            (0xff, marker) => {
                let Some(&[high, low]) = bytes.get(at + 2..at + 4) else { return false };
                at += 2 + usize::from(u16::from_be_bytes([high, low]));
                in_scan = marker == SCAN;
            }
            _ if in_scan => at += 1,
            // Not what the standard has: for the decoder to judge.
            _ => return true,
        }
    }
    false
}

/// Light behind an sRGB value (IEC 61966-2-1), both 0 to 1.
fn linear(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
