//! What a photograph must be like, for those who look at it and for the messages.

/// The least thickness of the beam in the picture, pixels: with less, its two edges blur into one line.
pub const THINNEST_PX: f64 = 5.0;
/// The faintest edge, in linear light of 0 to 1.
pub const FAINTEST: f64 = 0.02;
/// The most pixels of a picture: about 2 GB while it is read.
pub const MOST_PIXELS: u64 = 120_000_000;
