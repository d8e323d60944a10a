//! A camera from the files of a checkerboard's pictures.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::checkerboard::{self, Corner};
use super::error::OutlineError;
use super::photo::Photo;
use super::zhang::{self, Calibration};

/// How far the pictures are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Pictures whose corners are found.
    pub done: usize,
    /// All pictures.
    pub total: usize,
}

/// The board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Board {
    /// Squares along both sides.
    pub squares: [usize; 2],
    /// Side of a square, mm; affects the board's distance only.
    pub square_mm: f64,
}

/// Calibrates a camera by pictures of a checkerboard, for photographs of a size in pixels. `watch` is called after every picture; it
/// stops the work by [`ControlFlow::Break`].
///
/// # Errors
/// A picture cannot be read, has another size or no board; the pictures determine no camera; or the work was stopped.
pub fn calibrate(
    files: &[PathBuf],
    board: Board,
    size_px: [u32; 2],
    watch: impl FnMut(Progress) -> ControlFlow<()> + Send,
) -> Result<Calibration, OutlineError> {
    let told = Mutex::new((0, watch));
    let corners = |file: &PathBuf| -> Result<Vec<Corner>, OutlineError> {
        let picture = Photo::read(file)?;
        if picture.size() != size_px {
            return Err(OutlineError::OtherSize { camera: picture.size(), photo: size_px });
        }
        let corners = checkerboard::corners(&picture.grey(), board.squares)
            .map_err(|reason| OutlineError::Board { file: picture.name.clone(), reason })?;
        let (done, watch) = &mut *told.lock().unwrap_or_else(PoisonError::into_inner);
        *done += 1;
        match watch(Progress { done: *done, total: files.len() }) {
            ControlFlow::Continue(()) => Ok(corners),
            ControlFlow::Break(()) => Err(OutlineError::Stopped),
        }
    };
    let found = files.par_iter().map(corners).collect::<Result<Vec<_>, _>>()?;
    Ok(zhang::calibrate(&found, size_px, board.square_mm)?)
}
