//! A run as CSV: one line per place.

use crate::case::Coordinate;
use crate::delimited::line;
use crate::study::columns::{CSV, Cell};
use crate::study::place::Place;
use crate::study::run::Run;

/// The names of the columns.
pub fn head(along: Coordinate) -> Vec<String> {
    CSV.iter().map(|column| column.name(along)).collect()
}

/// The values of the columns, place by place. What is not known is empty.
pub fn records(run: &Run) -> impl Iterator<Item = Vec<String>> {
    run.places.iter().map(|place| CSV.iter().map(|column| Cell::csv(column.value(run, place))).collect())
}

/// The names of the columns of a shape: points of both centrelines, base to tip, finger frame.
pub const SHAPES: [&str; 4] = ["front_x_mm", "front_y_mm", "back_x_mm", "back_y_mm"];

/// The values of these columns: lists separated by blanks, as `fre compare --measured` reads them.
pub fn shape(place: &Place) -> [String; 4] {
    let shape = place.state.as_ref().map(|state| &state.shape);
    let list = |points: Option<&Vec<[f64; 2]>>, axis: usize| {
        let words: Vec<String> = points.into_iter().flatten().map(|point| point[axis].to_string()).collect();
        words.join(" ")
    };
    let (front, back) = (shape.map(|shape| &shape.front), shape.map(|shape| &shape.back));
    [list(front, 0), list(front, 1), list(back, 0), list(back, 1)]
}

/// Head and lines.
pub fn csv(run: &Run) -> String {
    let Some(first) = run.places.first() else { return String::new() };
    std::iter::once(head(first.at.along())).chain(records(run)).map(line).collect()
}
