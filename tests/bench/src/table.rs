//! The figures as a person reads them.

use std::fmt::Write;

use crate::ladder::word;
use crate::pc::{PAPER, REDUCED, Time};
use crate::peer::Peer;
use crate::spread::Spread;
use crate::target::Row;

/// The target's table, instructions in thousands.
pub fn target(rows: &[Row]) -> String {
    let mut text = format!(
        "ladder-80, cylinder of 80 mm at Mid height, 0 → 11 → 0°, ticks in contact; instructions in thousands, f32\n\
         {:<13} {:>7} {:<9} {:<13} {:<13} {:>6} {:>6} {:>11} {:>15} {:>15} {:>8} {:>8} {:>6} {:>9}\n",
        "model",
        "samples",
        "physics",
        "hessian",
        "mode",
        "ticks",
        "failed",
        "iterations",
        "a count",
        "a degree",
        "flash",
        "RAM",
        "stack",
        "error, N"
    );
    for row in rows {
        let spread = |of: Spread| format!("{:.0} / {:.0}", of.mean / 1e3, of.max / 1e3);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<13} {:>7} {:<9} {:<13} {:<13} {:>6} {:>6} {:>11} {:>15} {:>15} {:>8} {:>8} {:>6} {:>9.1e}",
            row.model.name,
            row.model.samples,
            word(row.model.physics),
            row.hessian,
            row.mode,
            row.ticks,
            row.failed_ticks,
            format!("{:.2} / {:.0}", row.iterations_per_count.mean, row.iterations_per_count.max),
            spread(row.per_count),
            spread(row.per_degree),
            row.flash_bytes,
            row.static_ram_bytes,
            row.stack_peak_bytes,
            row.force_error_n,
        );
    }
    text.push_str("mean / max; error: largest distance to the f64 solution of the same model\n");
    for row in rows {
        if let Some(derivatives) = row.derivatives {
            let _ = writeln!(
                text,
                "{}, {} samples, {}: derivatives with respect to angle, object and modulus take {:.0} / {:.0}, a Newton step {:.0} \
                 (ratio {:.2}); no room for them in {} ticks",
                row.model.name,
                row.model.samples,
                word(row.model.physics),
                derivatives.cost.mean / 1e3,
                derivatives.cost.max / 1e3,
                derivatives.newton_step / 1e3,
                derivatives.cost.mean / derivatives.newton_step,
                derivatives.refused
            );
        }
    }
    let compared: Vec<usize> = rows.iter().filter_map(|row| row.differs_from_pc).collect();
    let different: usize = compared.iter().sum();
    let _ = writeln!(
        text,
        "forces of {} sweeps compared bit for bit with f32 on this PC: {different} ticks differ",
        compared.len()
    );
    text
}

/// The peer beside us.
pub fn peer(peer: &Peer) -> String {
    format!(
        "paper 170/20, inextensible, f64; 0 to 11° in steps of 1° {:.0} µs, a count {:.0} µs of its processor time (medians)\n\
         our forces are the same within {:.1e} at {} places of the branch; it takes {:.0} times as long cold, {:.0} times warm\n",
        peer.cold_us, peer.warm_us, peer.apart, peer.compared, peer.ratio_cold, peer.ratio_warm
    )
}

/// The PC's table.
pub fn pc(times: &[Time]) -> String {
    let mut text = format!(
        "{:<17} {:<9} {:<9} {:>12} {:>16} {:>18}\n",
        "model", "physics", "precision", "a count, µs", "0 to 11°, µs", "places of 1° per s"
    );
    for time in times {
        let _ = writeln!(
            text,
            "{:<17} {:<9} {:<9} {:>12.1} {:>16.1} {:>18.0}",
            time.model,
            word(time.physics),
            time.precision,
            time.warm_us,
            time.cold_us,
            time.places_per_s
        );
    }
    text.push_str(&ratios(times));
    text
}

/// How much the reduced model saves against the paper's resolution, times of the same run.
fn ratios(times: &[Time]) -> String {
    let mut text = String::new();
    for full in times.iter().filter(|time| time.model == PAPER) {
        let reduced = times
            .iter()
            .find(|time| time.model == REDUCED && (time.physics, time.precision) == (full.physics, full.precision));
        if let Some(reduced) = reduced {
            let _ = writeln!(
                text,
                "{}, {}: {PAPER} takes {:.1} times as long as {REDUCED} warm, {:.1} times cold",
                word(full.physics),
                full.precision,
                full.warm_us / reduced.warm_us,
                full.cold_us / reduced.cold_us
            );
        }
    }
    text
}
