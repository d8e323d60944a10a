//! The library behind the `fre` command: cases, solving, pictures.

pub mod case;
