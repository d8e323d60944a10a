//! A photograph in linear light.

use std::path::Path;

use image::{DynamicImage, GrayImage, ImageDecoder, ImageReader, RgbImage};

use super::OutlineError;

/// A photograph, upright as its EXIF orientation says. Pixel coordinates: x to the right, y down, the middle of the upper
/// left pixel at (0, 0).
pub struct Photo {
    /// Name for messages.
    pub name: String,
    width: usize,
    height: usize,
    /// Luminance, linear light, 0 to 1, row by row. Cameras blur light, not the values that files keep: an edge's middle
    /// is half-way in light only.
    light: Vec<f32>,
    picture: RgbImage,
}

impl Photo {
    /// Reads PNG, JPEG, TIFF, BMP or WebP.
    ///
    /// # Errors
    /// The file cannot be read or is no such picture.
    pub fn read(path: &Path) -> Result<Self, OutlineError> {
        let name = path.display().to_string();
        let unreadable = |reason: String| OutlineError::Unreadable { file: name.clone(), reason };
        let reader = ImageReader::open(path).and_then(ImageReader::with_guessed_format);
        let reader = reader.map_err(|error| unreadable(error.to_string()))?;
        let decode = || -> Result<DynamicImage, image::ImageError> {
            let mut decoder = reader.into_decoder()?;
            let orientation = decoder.orientation()?;
            let mut image = DynamicImage::from_decoder(decoder)?;
            image.apply_orientation(orientation);
            Ok(image)
        };
        let image = decode().map_err(|error| unreadable(error.to_string()))?;
        Ok(Self::new(name, &image))
    }

    /// Takes a picture with sRGB values.
    pub fn new(name: String, image: &DynamicImage) -> Self {
        let values = image.to_rgb32f();
        let (width, height) = (values.width() as usize, values.height() as usize);
        // Weights of ITU-R BT.709, whose primaries sRGB has.
        let light =
            values.pixels().map(|p| 0.2126 * linear(p.0[0]) + 0.7152 * linear(p.0[1]) + 0.0722 * linear(p.0[2]));
        Self { name, width, height, light: light.collect(), picture: image.to_rgb8() }
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
        DynamicImage::ImageRgb8(self.picture.clone()).to_luma8()
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

/// Light behind an sRGB value (IEC 61966-2-1), both 0 to 1.
fn linear(value: f32) -> f32 {
    if value <= 0.040_45 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}
