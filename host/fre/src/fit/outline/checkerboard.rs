//! The inner corners of a checkerboard in a picture.

use std::collections::{HashMap, VecDeque};

use chess_corners::{Detector, DetectorConfig, ImageRefiner};
use image::GrayImage;

/// Part of a lattice step within which the next corner must lie.
const REACH: f64 = 0.3;
/// The most corners that are looked at: far more than a board has.
const MOST: usize = 4000;

/// A corner: its place on the board, squares from the first inner corner, and its pixel.
pub type Corner = ([f64; 2], [f64; 2]);

/// Why a picture has no board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoBoard {
    /// No lattice of that size.
    #[error("found is a lattice of {} by {} inner corners; needed is {} by {} (squares less one each way), all in the picture", .found[0], .found[1], .needed[0], .needed[1])]
    Size {
        /// The largest lattice.
        found: [usize; 2],
        /// The board's.
        needed: [usize; 2],
    },
    /// The detector gave up.
    #[error("no corners can be looked for: the picture is too small")]
    TooSmall,
}

/// Inner corners of a board of so many squares.
///
/// # Errors
/// The board is not in the picture as a whole.
pub fn corners(picture: &GrayImage, squares: [usize; 2]) -> Result<Vec<Corner>, NoBoard> {
    let config = DetectorConfig::chess().with_refiner(ImageRefiner::saddle_point()).without_orientation();
    let mut detector = Detector::new(config).map_err(|_| NoBoard::TooSmall)?;
    let mut found = detector.detect(picture).map_err(|_| NoBoard::TooSmall)?;
    found.sort_by(|a, b| b.response.total_cmp(&a.response));
    found.truncate(MOST);
    let places: Vec<[f64; 2]> = found.iter().map(|corner| [f64::from(corner.x), f64::from(corner.y)]).collect();
    lattice(&places, [squares[0] - 1, squares[1] - 1])
}

/// Finds the lattice of so many corners among places, strongest first.
fn lattice(places: &[[f64; 2]], needed: [usize; 2]) -> Result<Vec<Corner>, NoBoard> {
    let mut largest = [0, 0];
    // A seed on something else than the board grows a small lattice only.
    for seed in 0..places.len().min(64) {
        let Some(grown) = grow(places, seed) else { continue };
        let low = |axis: usize| grown.keys().map(|at| at[axis]).min().unwrap_or(0);
        let high = |axis: usize| grown.keys().map(|at| at[axis]).max().unwrap_or(0);
        let (low, high) = ([low(0), low(1)], [high(0), high(1)]);
        let size = [(high[0] - low[0] + 1) as usize, (high[1] - low[1] + 1) as usize];
        if size[0] * size[1] > largest[0] * largest[1] {
            largest = size;
        }
        let turned = size != needed && size == [needed[1], needed[0]];
        if (size == needed || turned) && grown.len() == needed[0] * needed[1] {
            let corner = |(at, &index): (&[i32; 2], &usize)| {
                let (i, j) = (f64::from(at[0] - low[0]), f64::from(at[1] - low[1]));
                (if turned { [j, i] } else { [i, j] }, places[index])
            };
            let mut corners: Vec<Corner> = grown.iter().map(corner).collect();
            corners.sort_by(|a, b| a.0[1].total_cmp(&b.0[1]).then(a.0[0].total_cmp(&b.0[0])));
            return Ok(corners);
        }
    }
    Err(NoBoard::Size { found: largest, needed })
}

/// Lattice places (by index) that follow each other from a seed with slowly changing steps.
fn grow(places: &[[f64; 2]], seed: usize) -> Option<HashMap<[i32; 2], usize>> {
    let from = places[seed];
    let mut near: Vec<usize> = (0..places.len()).filter(|&i| i != seed).collect();
    near.sort_by(|&a, &b| distance(places[a], from).total_cmp(&distance(places[b], from)));
    let first = step(from, places[*near.first()?]);
    let length = first[0].hypot(first[1]);
    // The second direction: the nearest that stands across the first, neither diagonal nor twice as far.
    let second = near.iter().take(12).map(|&i| step(from, places[i])).find(|s| {
        let size = s[0].hypot(s[1]);
        let sine = (first[0] * s[1] - first[1] * s[0]).abs() / (length * size);
        size < 2.0 * length && sine > 0.8
    })?;
    let mut at = HashMap::from([([0, 0], seed)]);
    let mut steps = HashMap::from([([0, 0], [first, second])]);
    let mut taken = vec![false; places.len()];
    taken[seed] = true;
    let mut front = VecDeque::from([[0, 0]]);
    while let Some(here) = front.pop_front() {
        let Some(&local) = steps.get(&here) else { continue };
        let place = places[at[&here]];
        for axis in 0..2 {
            for sign in [1.0, -1.0] {
                let mut there = here;
                there[axis] += sign as i32;
                if at.contains_key(&there) {
                    continue;
                }
                let wanted = [place[0] + sign * local[axis][0], place[1] + sign * local[axis][1]];
                let size = local[axis][0].hypot(local[axis][1]);
                let best = (0..places.len())
                    .filter(|&i| !taken[i])
                    .map(|i| (i, distance(places[i], wanted)))
                    .min_by(|a, b| a.1.total_cmp(&b.1));
                let Some((found, off)) = best else { continue };
                if off > REACH * size {
                    continue;
                }
                let mut next = local;
                let moved = step(place, places[found]);
                next[axis] = [sign * moved[0], sign * moved[1]];
                taken[found] = true;
                at.insert(there, found);
                steps.insert(there, next);
                front.push_back(there);
            }
        }
    }
    Some(at)
}

fn step(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    [to[0] - from[0], to[1] - from[1]]
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::outline::homography::Homography;

    #[test]
    fn a_lattice_is_ordered_whatever_lies_around_it() {
        // In perspective, with three stray corners, the strongest of all among them.
        let see = |i: f64, j: f64| {
            let w = 1.0 + 0.03 * i + 0.02 * j;
            [(100.0 + 40.0 * i + 6.0 * j) / w, (80.0 - 5.0 * i + 42.0 * j) / w]
        };
        let mut places = vec![[500.0, 20.0]];
        for k in 0..35 {
            // An order that has nothing to do with the lattice.
            let k = (k * 11 + 3) % 35;
            places.push(see(f64::from(k % 7), f64::from(k / 7)));
        }
        places.extend([[20.0, 400.0], [530.0, 390.0]]);
        let corners = lattice(&places, [7, 5]).unwrap();
        assert_eq!(corners.len(), 35);
        // Any of the board's symmetries may come out; a wrong label would fit no perspective.
        let map = Homography::fit(&corners).unwrap();
        for (at, pixel) in &corners {
            assert!(distance(map.apply(*at).unwrap(), *pixel) < 1e-6, "{at:?} is not at {pixel:?}");
        }
        let wrong = lattice(&places, [8, 5]).unwrap_err().to_string();
        assert!(wrong.contains("by 8") || wrong.contains("8 by"), "{wrong}");
    }
}
