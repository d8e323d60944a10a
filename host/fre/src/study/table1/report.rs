//! What is written of the table: report, Markdown, CSV and pictures.

use std::path::PathBuf;

use super::error::Table1Error;
use super::row::Row;
use super::series::Series;
use super::table::markdown;
use super::variant::variants;
use super::{bars, page};
use crate::case::Coordinate;
use crate::delimited::line;
use crate::draw;
use crate::files::Folder;
use crate::study::csv::{head, records};

/// Names of the files that [`write()`] makes.
pub const FILES: [&str; 5] = ["report.html", "table1.md", "table1.csv", "errors.svg", "errors.png"];

/// Writes report, table and data ([`FILES`]) into a folder; gives their paths.
///
/// # Errors
/// A file cannot be written.
pub fn write(folder: &mut Folder, rows: &[Row]) -> Result<Vec<PathBuf>, Table1Error> {
    let bars = bars::scene(rows);
    let picture = |format| draw::encode(&bars, format, draw::Theme::Light);
    let contents = [
        page::html(rows).into_bytes(),
        markdown(rows).into_bytes(),
        csv(rows).into_bytes(),
        picture(draw::Format::Svg)?,
        picture(draw::Format::Png)?,
    ];
    FILES.iter().zip(contents).map(|(name, bytes)| Ok(folder.write(name, &bytes)?)).collect()
}

/// One line per case and variant, with the columns of `fre solve`.
pub fn csv(rows: &[Row]) -> String {
    let own = ["diameter_mm", "height", "height_mm", "angle", "model"].map(str::to_owned);
    let mut out = line(own.into_iter().chain(head(Coordinate::Angle)));
    for row in rows {
        let Series { diameter_mm, height, height_mm, .. } = row.series;
        for (run, variant) in row.runs.iter().zip(variants()) {
            let angle = (row.angle + 1).to_string();
            let own =
                [diameter_mm.to_string(), height.to_owned(), height_mm.to_string(), angle, variant.name.to_owned()];
            for record in records(run) {
                out += &line(own.iter().cloned().chain(record));
            }
        }
    }
    out
}
