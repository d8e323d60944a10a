//! Error against time: what the resolutions of a sweep cost and how far their forces are from the finest one's.

use std::collections::HashMap;

use super::axis::Axis;
use super::grid::Sweep;
use super::ledger::status_of;

/// What a resolution came to, over all other values of the grid and all places.
#[derive(Clone, Debug, PartialEq)]
pub struct Tuned {
    /// As it was given: beam/hinge.
    pub elements: String,
    /// Unknowns of the model.
    pub unknowns: u64,
    /// Median time of a place, ms.
    pub time_ms: f64,
    /// Rows in contact that both this resolution and the finest have a trustworthy solution of.
    pub compared: usize,
    /// Mean and largest size of the difference of the force's magnitude, percent of the finest one's; none without rows.
    pub error_percent: Option<[f64; 2]>,
}

/// A place of a point of the grid without its resolution.
type Place = (Vec<usize>, usize);

struct Read {
    trustworthy: bool,
    force: Option<f64>,
    unknowns: u64,
    time_us: f64,
}

/// Compares the resolutions in a sweep's complete CSV with the one of the most unknowns, in the order in which they were
/// given; none without at least two.
pub fn study(sweep: &Sweep, csv: &str) -> Option<Vec<Tuned>> {
    let (along, words) = sweep.axes.iter().enumerate().find_map(|(index, axis)| match axis {
        Axis::Elements(values) if values.len() > 1 => Some((index, values)),
        _ => None,
    })?;
    let mut lines = csv.lines().filter(|line| !line.starts_with('#'));
    let columns: Vec<&str> = lines.next()?.split(',').collect();
    let column = |name: &str| columns.iter().position(|found| *found == name);
    let [row, status, force, unknowns, time] =
        ["row", "status", "force_n", "unknowns", "elapsed_us"].map(column).map(|found| found.unwrap_or(usize::MAX));
    // Per resolution: what was read of each place of each point of the rest of the grid.
    let mut read: Vec<HashMap<Place, Read>> = (0..words.len()).map(|_| HashMap::new()).collect();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |column: usize| cells.get(column).and_then(|cell| cell.parse::<f64>().ok());
        let row = cells.get(row)?.parse::<usize>().ok()?;
        let mut point = sweep.indices(row / sweep.places().len());
        let resolution = point.get(along).copied()?;
        point.remove(along);
        let trustworthy = status_of(cells.get(status)?)?.is_trustworthy();
        let found =
            Read { trustworthy, force: number(force), unknowns: number(unknowns)? as u64, time_us: number(time)? };
        read.get_mut(resolution)?.insert((point, row % sweep.places().len()), found);
    }
    let size = |of: &HashMap<Place, Read>| of.values().map(|row| row.unknowns).max().unwrap_or(0);
    let finest = read.iter().max_by_key(|of| size(of))?;
    let tuned = |(word, of): (&(String, _), &HashMap<Place, Read>)| {
        let mut times: Vec<f64> = of.values().map(|row| row.time_us).collect();
        times.sort_by(f64::total_cmp);
        let errors: Vec<f64> = of
            .iter()
            .filter_map(|(key, row)| {
                let reference = finest.get(key).filter(|reference| reference.trustworthy && row.trustworthy)?;
                let force = reference.force.filter(|&force| force > 0.0)?;
                Some(100.0 * (row.force? / force - 1.0).abs())
            })
            .collect();
        let most = errors.iter().copied().fold(0.0, f64::max);
        Tuned {
            elements: word.0.clone(),
            unknowns: size(of),
            time_ms: times.get(times.len() / 2).map_or(f64::NAN, |time| 1e-3 * time),
            compared: errors.len(),
            error_percent: (!errors.is_empty()).then(|| [errors.iter().sum::<f64>() / errors.len() as f64, most]),
        }
    };
    Some(words.iter().zip(&read).map(tuned).collect())
}

#[cfg(test)]
mod tests {
    use std::ops::ControlFlow;
    use std::path::Path;

    use model_core::discretise::Elements;

    use super::super::{Axis, Sweep, run};
    use super::study;
    use crate::case::Document;
    use crate::study::model::Options;

    fn sweep(resolutions: &[(usize, usize)]) -> Sweep {
        let text = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
            [motion]\nmotor_angles_deg = [-2, 2, 4, 2]\n";
        let elements = resolutions.iter().map(|&(beam, hinge)| {
            (format!("{beam}/{hinge}"), Elements::PerBeam { beam: beam as u16, hinge: hinge as u16 })
        });
        let axes = vec![
            Axis::Elements(elements.collect()),
            Axis::Key { key: "object.radius_mm".into(), values: vec![38.0, 40.0] },
        ];
        Sweep::new(Document::resolve("case.toml", text, Path::new("")).unwrap(), None, axes, Options::default())
            .unwrap()
    }

    #[test]
    fn the_finest_resolution_is_what_others_are_held_against() {
        let sweep = sweep(&[(24, 1), (96, 4), (48, 2)]);
        let mut csv = Vec::new();
        run(&sweep, None, &mut csv, 1, |_| ControlFlow::Continue(())).unwrap();
        let found = study(&sweep, std::str::from_utf8(&csv).unwrap()).unwrap();
        assert_eq!(found.iter().map(|of| of.elements.as_str()).collect::<Vec<_>>(), ["24/1", "96/4", "48/2"]);
        // Three of the four angles touch, for each of two radii.
        assert!(found.iter().all(|of| of.compared == 6 && of.time_ms > 0.0), "{found:?}");
        assert_eq!(found[1].error_percent, Some([0.0, 0.0]));
        let mean = |of: usize| found[of].error_percent.unwrap()[0];
        assert!(mean(0) > mean(2) && mean(2) > 0.0 && mean(0) < 1.0, "{found:?}");
        assert!(found[0].unknowns < found[2].unknowns && found[2].unknowns < found[1].unknowns);
    }

    #[test]
    fn one_resolution_is_no_study() {
        assert_eq!(study(&sweep(&[(24, 1)]), "row,status\n"), None);
    }
}
