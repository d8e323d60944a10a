//! What a source tells, kept in a file: every estimate and event, none left out.

mod csv;

pub use csv::Csv;
