//! Reports as a table of comma-separated values: every report, a row each.

use std::io::{self, Write};

use messages::Report;

const HEADER: &str = "sequence,time_us,motor_angle_deg,goal_deg,position_counts,current_ma,status,age,force_x_n,force_y_n,\
                      contact_x_mm,contact_y_mm,contact_extent_mm,torque_nmm,distance_mm,iterations,residual_nmm,cost,finger,\
                      phase,force_x_per_deg_n,force_y_per_deg_n,standard_deviation_n,sensitivity_age";

/// A table of reports.
#[derive(Debug)]
pub struct Csv<W: Write>(W);

impl<W: Write> Csv<W> {
    /// Begins it with its header.
    ///
    /// # Errors
    /// The file's.
    pub fn new(mut out: W) -> io::Result<Self> {
        writeln!(out, "{HEADER}")?;
        Ok(Self(out))
    }

    /// One row. Numbers have the digits that single precision needs.
    ///
    /// # Errors
    /// The file's.
    pub fn write(&mut self, report: &Report) -> io::Result<()> {
        let Report { sequence, finger, phase, time_us, estimate, goal, position, current, cost } = report;
        let (angle, goal) = (estimate.motor_angle.to_degrees(), goal.to_degrees());
        let ([fx, fy], [cx, cy]) = (estimate.force, estimate.contact_centre);
        writeln!(
            self.0,
            "{sequence},{time_us},{angle},{goal},{position},{current},{},{},{fx},{fy},{cx},{cy},{},{},{},{},{},{cost},{finger},{},\
             {},{},{},{}",
            estimate.status,
            estimate.age,
            estimate.contact_extent,
            estimate.torque,
            estimate.distance,
            estimate.iterations,
            estimate.residual,
            phase.word(),
            // Per degree: a radian's worth times π/180.
            estimate.force_per_angle[0].to_radians(),
            estimate.force_per_angle[1].to_radians(),
            estimate.standard_deviation,
            estimate.sensitivity_age
        )
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// The file's.
    pub fn finish(mut self) -> io::Result<W> {
        self.0.flush()?;
        Ok(self.0)
    }
}
