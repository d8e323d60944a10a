//! The library behind the `fre` command: cases, solving, pictures.

pub mod branch;
pub mod bus;
pub mod calibrate;
pub mod case;
pub mod cli;
pub mod demo;
pub mod draw;
pub mod estimator;
pub mod fea;
pub mod heap;
pub mod link;
pub mod measured;
pub mod metrics;
pub mod pictures;
pub mod pressure;
pub mod probe;
pub mod record;
pub mod report;
pub mod run;
pub mod servo;
pub mod shape;
pub mod source;
pub mod strains;
pub mod sweep;
pub mod table1;
