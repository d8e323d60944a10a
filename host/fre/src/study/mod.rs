//! A case solved: at the places of its motion, over a grid of its numbers, and as the paper's table.

pub mod branch;
pub mod overlap;
pub mod pictures;
pub mod pressure;
pub mod report;
pub mod run;
pub mod strains;
pub mod sweep;
pub mod table1;
pub mod warnings;
