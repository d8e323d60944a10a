//! A case solved: at the places of its motion, over a grid of its numbers, and as the paper's table.

pub mod branch;
pub mod buckling;
pub mod choice;
mod columns;
pub mod course;
pub mod csv;
mod fade;
pub mod follow;
pub mod friction;
pub mod headline;
pub mod idle;
pub mod json;
pub mod model;
pub mod number;
pub mod overlap;
pub mod pictures;
pub mod place;
pub mod pressure;
pub mod remedy;
pub mod run;
pub mod self_contact;
pub mod sensitivity;
pub mod strains;
pub mod sweep;
pub mod table1;
pub mod text;
pub mod warnings;
