//! In which order measured places are visited.

/// Order in which measured places are visited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Ascending, whatever the file's order.
    Closing,
    /// The file's: closing and opening again, with the finger's hysteresis.
    File,
}
