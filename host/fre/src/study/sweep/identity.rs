//! Which sweep a file of rows belongs to: a small file beside it, so that the rows are a plain table.
//!
//! `rows.csv` has `rows.csv.sweep`. Earlier versions wrote the same as a first line of the rows, beginning with [`MAGIC`]; such a
//! file is continued as it is.

use std::ffi::OsString;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::SweepError;
use super::grid::Sweep;
use super::shard::Shard;

/// How a file of rows of an earlier version begins.
pub(super) const MAGIC: &str = "# fre sweep ";

/// Which sweep it is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Identity {
    /// Version of the program.
    pub(super) fre: String,
    /// A hash of case, values and options.
    pub(super) identity: String,
    /// Points of the grid.
    pub(super) points: usize,
    /// Rows of the whole sweep.
    pub(super) rows: usize,
    /// What is varied.
    pub(super) axes: Vec<String>,
    /// Which part of the points is in the file; all of them if it is absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) shard: Option<Shard>,
}

impl Sweep {
    /// What says which sweep it is, as JSON: what is beside its file.
    pub fn name(&self) -> String {
        // A model of texts and numbers is always JSON.
        serde_json::to_string(&Identity::of(self)).unwrap_or_default()
    }

    /// A text that says everything the results depend on.
    fn identity(&self) -> String {
        let axes: Vec<String> = self
            .axes
            .iter()
            .map(|axis| {
                let values: Vec<String> = (0..axis.len()).map(|index| axis.words(index)).collect();
                format!("{}={}", axis.name(), values.join(","))
            })
            .collect();
        let shapes = if self.shapes { "\nshapes" } else { "" };
        let (case, options, axes) = (self.document.text(), self.options, axes.join("\n"));
        format!("{}\n{case}\n{options:?}\n{axes}{shapes}", env!("CARGO_PKG_VERSION"))
    }
}

impl Identity {
    /// Of a sweep.
    pub(super) fn of(sweep: &Sweep) -> Self {
        Self {
            fre: env!("CARGO_PKG_VERSION").to_owned(),
            identity: format!("{:016x}", fnv(sweep.identity().as_bytes())),
            points: sweep.points(),
            rows: sweep.rows(),
            axes: sweep.axes.iter().map(|axis| axis.name().to_owned()).collect(),
            shard: sweep.shard(),
        }
    }

    /// The first line of a file of an earlier version.
    pub(super) fn first_line(&self) -> String {
        format!(
            "{MAGIC}{} {}: {} points, {} rows; to be read from the next line on\n",
            self.fre, self.identity, self.points, self.rows
        )
    }

    /// Of such a first line and the names of the columns below it.
    pub(super) fn of_first_lines(text: &str) -> Option<Self> {
        let mut lines = text.lines();
        let (names, rest) = lines.next()?.strip_prefix(MAGIC)?.split_once(": ")?;
        let (fre, identity) = names.split_once(' ')?;
        let (points, rest) = rest.split_once(" points, ")?;
        let (rows, _) = rest.split_once(" rows;")?;
        let columns = lines.next().unwrap_or_default().strip_prefix("row,").unwrap_or_default();
        Some(Self {
            fre: fre.to_owned(),
            identity: identity.to_owned(),
            points: points.parse().ok()?,
            rows: rows.parse().ok()?,
            axes: columns.split(',').take_while(|column| *column != "status").map(str::to_owned).collect(),
            shard: None,
        })
    }

    /// Reads the file beside a file of rows; none if there is none or it is something else.
    pub(super) fn read(rows: &Path) -> Result<Option<Self>, SweepError> {
        let path = beside(rows);
        match std::fs::read(&path) {
            Ok(bytes) => Ok(serde_json::from_slice(&bytes).ok()),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(source) => Err(SweepError::File { file: path.display().to_string(), source }),
        }
    }

    /// Writes it beside a file of rows, at once.
    pub(super) fn write(&self, rows: &Path) -> Result<(), SweepError> {
        let path = beside(rows);
        let failed = |source| SweepError::File { file: path.display().to_string(), source };
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut file = tempfile::NamedTempFile::new_in(folder).map_err(failed)?;
        // A model of texts and numbers is always JSON.
        let text = serde_json::to_string_pretty(self).unwrap_or_default() + "\n";
        file.write_all(text.as_bytes()).map_err(failed)?;
        // As readable as the rows.
        if let Ok(rows) = std::fs::metadata(rows) {
            file.as_file().set_permissions(rows.permissions()).map_err(failed)?;
        }
        file.persist(&path).map(drop).map_err(|error| failed(error.error))
    }

    /// What makes another sweep of it, in words; none if it is the same.
    pub(super) fn difference(&self, own: &Self) -> Option<String> {
        let named = |axes: &[String]| if axes.is_empty() { "nothing".to_owned() } else { axes.join(", ") };
        let part = |shard: Option<Shard>| shard.map_or("all of it".to_owned(), |shard| format!("shard {shard}"));
        let what = if self == own {
            return None;
        } else if self.fre != own.fre {
            format!("was written by fre {}, this is fre {}", self.fre, own.fre)
        } else if self.axes != own.axes {
            format!("varies {}, asked for is {}", named(&self.axes), named(&own.axes))
        } else if (self.points, self.rows) != (own.points, own.rows) {
            format!(
                "has {} points, {} rows, asked for are {} points, {} rows",
                self.points, self.rows, own.points, own.rows
            )
        } else if self.identity == own.identity {
            format!("is {}, asked for is {}", part(self.shard), part(own.shard))
        } else {
            "has another case, other values or other model options".to_owned()
        };
        Some(format!("holds another sweep: it {what}"))
    }
}

/// The file beside a file of rows.
pub(super) fn beside(rows: &Path) -> PathBuf {
    let mut name = OsString::from(rows);
    name.push(".sweep");
    name.into()
}

/// The FNV-1a hash of 64 bits (Fowler, Noll, Vo): short, and the same on every machine.
fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::{Axis, Sweep, SweepError};
    use super::{Identity, fnv};
    use crate::case::Document;
    use crate::study::model::Options;

    fn sweep(axes: Vec<Axis>, angles: Option<&[f64]>) -> Result<Sweep, SweepError> {
        let text = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
            [motion]\nmotor_angles_deg = [2, 4]\n";
        Sweep::new(Document::resolve("case.toml", text, Path::new(""))?, angles, axes, Options::default())
    }

    fn key(key: &str, values: &[f64]) -> Axis {
        Axis::Key { key: key.to_owned(), values: values.to_vec() }
    }

    #[test]
    fn the_hash_is_fnv_1a() {
        assert_eq!(fnv(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(fnv(b"a"), 0xaf63_dc4c_8601_ec8c);
    }

    #[test]
    fn a_first_line_of_an_earlier_version_is_read_again() {
        let identity = Identity {
            fre: "0.1.0".to_owned(),
            identity: "00ff".to_owned(),
            points: 2,
            rows: 6,
            axes: vec!["object.radius_mm".to_owned()],
            shard: None,
        };
        let text = format!("{}row,object.radius_mm,status,force_n\n", identity.first_line());
        assert_eq!(Identity::of_first_lines(&text), Some(identity));
        assert_eq!(Identity::of_first_lines("row,status\n"), None);
    }

    #[test]
    fn everything_that_matters_is_in_the_identity() {
        let one = sweep(vec![key("object.radius_mm", &[20.0])], None).unwrap();
        let same = sweep(vec![key("object.radius_mm", &[20.0])], Some(&[2.0, 4.0])).unwrap();
        let others = [
            sweep(vec![key("object.radius_mm", &[20.5])], None),
            sweep(vec![key("object.centre_mm.0", &[20.0])], None),
            sweep(vec![key("object.radius_mm", &[20.0])], Some(&[2.0, 5.0])),
        ];
        // Angles given by the option and by the file are the same angles, in another spelling.
        assert_eq!(one.places(), same.places());
        for other in others {
            assert_ne!(other.unwrap().identity(), one.identity());
        }
    }
}
