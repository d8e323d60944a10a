//! The figures as a person reads them.

use std::fmt::Write;

use crate::ladder::word;
use crate::pc::{PAPER, REDUCED, REMEMBERING, RIBS, RUBBING, Time};
use crate::peer::Peer;
use crate::spread::Spread;
use crate::target::Row;

/// The target's table, instructions in thousands.
pub fn target(rows: &[Row]) -> String {
    let mut text = format!(
        "cylinder of 80 mm, 0 → 11 → 0° in counts of 0.088°, or 0 → 10 → 0 mm of jaw in counts of 0.05 mm (umi; 0.5 mm for a degree); ticks \
         in contact; instructions in thousands, f32\n\
         {:<17} {:<20} {:>7} {:<9} {:>8} {:<13} {:<13} {:>6} {:>6} {:>11} {:>15} {:>15} {:>8} {:>8} {:>6} {:>9}\n",
        "case",
        "model",
        "samples",
        "physics",
        "friction",
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
            "{:<17} {:<20} {:>7} {:<9} {:>8} {:<13} {:<13} {:>6} {:>6} {:>11} {:>15} {:>15} {:>8} {:>8} {:>6} {:>9.1e}",
            row.model.case,
            row.model.name,
            row.model.samples,
            word(row.model.physics),
            f64::from(row.model.friction) / 100.0,
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
                "{}, {}, {} samples, {}: derivatives with respect to angle, object and modulus take {:.0} / {:.0}, a Newton step {:.0} \
                 (ratio {:.2}); no room for them in {} ticks",
                row.model.case,
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
    for (row, without) in rows.iter().filter_map(|row| Some((row, plain(rows, row)?))) {
        let _ = writeln!(
            text,
            "{}, {}, {} samples, friction {}: {:.2} times the mean and {:.2} times the worst count of {REDUCED}, {:+} bytes",
            row.model.case,
            row.model.name,
            row.model.samples,
            f64::from(row.model.friction) / 100.0,
            row.per_count.mean / without.per_count.mean,
            row.per_count.max / without.per_count.max,
            row.static_ram_bytes as i64 - without.static_ram_bytes as i64
        );
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

/// The row of hinges without room for friction or memory that one with room, or with ribs, is compared with.
fn plain<'a>(rows: &'a [Row], row: &Row) -> Option<&'a Row> {
    let same = |other: &&Row| {
        let models = (other.model.name, other.model.samples, other.model.physics);
        models == (REDUCED, row.model.samples, row.model.physics)
            && (&other.mode, &other.hessian) == (&row.mode, &row.hessian)
    };
    rows.iter().find(same).filter(|_| [RUBBING, REMEMBERING, RIBS].contains(&row.model.name))
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
        "{:<17} {:<20} {:<9} {:>8} {:<9} {:>12} {:>13} {:>16} {:>18}\n",
        "case",
        "model",
        "physics",
        "friction",
        "precision",
        "a count, µs",
        "mean / max",
        "0 to 11°, µs",
        "places of 1° per s"
    );
    for time in times {
        let _ = writeln!(
            text,
            "{:<17} {:<20} {:<9} {:>8} {:<9} {:>12.1} {:>13} {:>16.1} {:>18.0}",
            time.case,
            time.model,
            word(time.physics),
            f64::from(time.friction) / 100.0,
            time.precision,
            time.warm_us,
            format!("{:.1} / {:.1}", time.ticks_us.mean, time.ticks_us.max),
            time.cold_us,
            time.places_per_s
        );
    }
    text.push_str(&ratios(times));
    text.push_str(&rubbing(times));
    text
}

/// What friction costs, times of the same run.
fn rubbing(times: &[Time]) -> String {
    let mut text = String::new();
    for time in times.iter().filter(|time| time.model == RUBBING) {
        let same =
            |other: &&Time| (other.model, other.physics, other.precision) == (REDUCED, time.physics, time.precision);
        if let Some(without) = times.iter().find(same) {
            let _ = writeln!(
                text,
                "room for friction, {}, coefficient {}: {:.2} times the mean and {:.2} times the worst count without",
                time.precision,
                f64::from(time.friction) / 100.0,
                time.ticks_us.mean / without.ticks_us.mean,
                time.ticks_us.max / without.ticks_us.max
            );
        }
    }
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
