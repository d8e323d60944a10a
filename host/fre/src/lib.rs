//! Fin-Ray fingers on a PC: cases, solving, sweeps, comparison, calibration, finite elements and pictures. The library behind the
//! `fre` command.
//!
//! Folders, each using only those after it:
//!
//! - [`compare`] – a case against finite elements or measurements
//! - [`optimise`] – designs searched for goals
//! - [`fit`] – measurements, calibration, the front beam's outline from a photograph
//! - [`fea`] – finite elements by CalculiX
//! - [`study`] – a case solved: runs, sweeps, the paper's table; reports, warnings and pictures of them
//! - [`draw`] – pictures
//! - [`finger`] – a finger as a plane figure, and its outline; `cad` (feature) – outlines in files
//! - [`case`] – case files
//! - [`files`], [`lock`] – files that are read and written, locks
//! - [`spreadsheet`], [`delimited`], [`visible`] – tables that are read, lines of CSV that are written, pieces of files in messages
//! - [`urdf`] – a gripper as robots' programs describe it
//! - [`table`] – tables of typed columns; `parquet` (feature) – as Parquet files
//! - [`drive`], [`metrics`], [`shape`], [`faces`], [`heap`] – how a motor moves its finger, distances and errors, the deformed finger, the
//!   faces of its beams, the model's size on a PC

#[cfg(feature = "cad")]
pub mod cad;
pub mod case;
pub mod compare;
pub mod delimited;
pub mod draw;
pub mod drive;
pub mod faces;
pub mod fea;
pub mod files;
pub mod finger;
pub mod fit;
pub mod heap;
pub mod lock;
pub mod metrics;
pub mod optimise;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod shape;
pub mod spreadsheet;
pub mod study;
pub mod table;
pub mod urdf;
pub mod visible;
