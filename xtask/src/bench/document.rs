//! The figures as JSON, with keys that others rely on.

use super::pc::Time;
use super::peer::Peer;
use super::target::{Row, Spread};
use anyhow::{Result, bail};
use serde_json::{Value, json};

const CASE: &str = "ladder-80 R40-Mid";

/// The whole document.
pub fn write(rustc: &str, opt_level: &str, rows: &[Row], times: &[Time], peer: Option<&Peer>) -> Value {
    let mut document = json!({
        "rustc": rustc,
        "opt_level": opt_level,
        "target": rows.iter().map(row).collect::<Vec<_>>(),
        "pc": times.iter().map(time).collect::<Vec<_>>(),
    });
    // Absent where it could not be measured.
    if let Some(peer) = peer {
        document["peer"] = json!({
            "name": "casadi-ipopt",
            "cold_us": peer.cold_us,
            "warm_us": peer.warm_us,
            "ratio_cold": peer.ratio_cold,
            "ratio_warm": peer.ratio_warm,
            "force_apart": peer.apart,
        });
    }
    document
}

fn row(row: &Row) -> Value {
    let mut value = json!({
        "board": "mps2",
        "case": CASE,
        "model": row.model.name,
        "mode": row.mode,
        "hessian": row.hessian,
        "physics": row.model.physics,
        "samples_per_element": row.model.samples,
        "ticks": row.ticks,
        "failed_ticks": row.failed_ticks,
        "instructions_per_count": whole(row.per_count),
        "instructions_per_degree": whole(row.per_degree),
        "iterations_per_count": { "mean": row.iterations_per_count.mean, "max": row.iterations_per_count.max as u64 },
        "flash_bytes": row.flash_bytes,
        "static_ram_bytes": row.static_ram_bytes,
        "stack_peak_bytes": row.stack_peak_bytes,
        "force_error_vs_f64_n": row.force_error_n,
    });
    if let Some(derivatives) = row.derivatives {
        value["derivatives"] = json!({
            "instructions": whole(derivatives.cost),
            "newton_step_instructions": derivatives.newton_step.round() as u64,
            "refused": derivatives.refused,
        });
    }
    if let Some(count) = row.differs_from_pc {
        value["ticks_differing_from_pc_f32"] = count.into();
    }
    value
}

fn whole(spread: Spread) -> Value {
    json!({ "mean": spread.mean.round() as u64, "max": spread.max.round() as u64 })
}

fn time(time: &Time) -> Value {
    json!({
        "model": time.model,
        "physics": time.physics,
        "precision": time.precision,
        "warm_us": time.warm_us,
        "cold_us": time.cold_us,
    })
}

/// What a key must hold.
#[derive(Clone, Copy)]
enum Kind {
    Text,
    OneOf(&'static [&'static str]),
    Positive,
    NotNegative,
    /// `mean` and `max`.
    Spread,
}

const PHYSICS: Kind = Kind::OneOf(&["paper", "extended"]);

const TARGET: &[(&str, Kind)] = &[
    ("board", Kind::OneOf(&["mps2"])),
    ("case", Kind::OneOf(&[CASE])),
    ("model", Kind::OneOf(&["simpson-17-1", "paper-170-20"])),
    ("mode", Kind::OneOf(&["converged", "one-iteration"])),
    ("hessian", Kind::OneOf(&["newton", "gauss-newton"])),
    ("physics", PHYSICS),
    ("samples_per_element", Kind::Positive),
    ("failed_ticks", Kind::NotNegative),
    ("instructions_per_count", Kind::Spread),
    ("instructions_per_degree", Kind::Spread),
    ("flash_bytes", Kind::Positive),
    ("static_ram_bytes", Kind::Positive),
    ("stack_peak_bytes", Kind::Positive),
    ("force_error_vs_f64_n", Kind::NotNegative),
];

const PC: &[(&str, Kind)] = &[
    ("model", Kind::Text),
    ("physics", PHYSICS),
    ("precision", Kind::OneOf(&["f32", "f64"])),
    ("warm_us", Kind::Positive),
    ("cold_us", Kind::Positive),
];

const PEER: &[(&str, Kind)] = &[
    ("name", Kind::Text),
    ("cold_us", Kind::Positive),
    ("warm_us", Kind::Positive),
    ("ratio_cold", Kind::Positive),
    ("ratio_warm", Kind::Positive),
];

/// Says which key is missing or holds what it must not.
pub fn check(document: &Value) -> Result<()> {
    keys(document, "", &[("rustc", Kind::Text), ("opt_level", Kind::Text)])?;
    for (list, expected) in [("target", TARGET), ("pc", PC)] {
        let Some(rows) = document[list].as_array().filter(|rows| !rows.is_empty()) else {
            bail!("`{list}` is not a list with rows");
        };
        for (index, row) in rows.iter().enumerate() {
            keys(row, &format!("{list}[{index}]."), expected)?;
        }
    }
    match &document["peer"] {
        Value::Null => Ok(()),
        peer => keys(peer, "peer.", PEER),
    }
}

fn keys(value: &Value, place: &str, expected: &[(&str, Kind)]) -> Result<()> {
    for (key, kind) in expected {
        if !holds(&value[*key], *kind) {
            bail!("`{place}{key}` is missing or out of range: {}", value[*key]);
        }
    }
    Ok(())
}

fn holds(value: &Value, kind: Kind) -> bool {
    let number = |value: &Value| value.as_f64().filter(|number| number.is_finite());
    match kind {
        Kind::Text => value.as_str().is_some_and(|text| !text.is_empty()),
        Kind::OneOf(words) => value.as_str().is_some_and(|text| words.contains(&text)),
        Kind::Positive => number(value).is_some_and(|number| number > 0.0),
        Kind::NotNegative => number(value).is_some_and(|number| number >= 0.0),
        Kind::Spread => matches!(
            (number(&value["mean"]), number(&value["max"])),
            (Some(mean), Some(max)) if 0.0 < mean && mean <= max
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::pc::Model;
    use super::*;

    fn document() -> Value {
        let spread = Spread { mean: 100.4, max: 200.0 };
        let row = Row {
            model: Model { name: "simpson-17-1".into(), samples: 4, physics: "extended".into() },
            mode: "converged".into(),
            hessian: "newton".into(),
            ticks: 250,
            failed_ticks: 0,
            per_count: spread,
            per_degree: spread,
            iterations_per_count: Spread { mean: 1.8, max: 3.0 },
            flash_bytes: 1,
            static_ram_bytes: 2,
            stack_peak_bytes: 3,
            force_error_n: 1e-4,
            derivatives: None,
            differs_from_pc: Some(0),
        };
        let time = Time {
            model: "fine".into(),
            physics: "paper".into(),
            precision: "f64".into(),
            warm_us: 1.5,
            cold_us: 20.0,
        };
        let peer = Peer { cold_us: 4e4, warm_us: 2e4, ratio_cold: 20.0, ratio_warm: 200.0, apart: 1e-9, compared: 31 };
        write("rustc 1.95.0", "3", &[row], &[time], Some(&peer))
    }

    #[test]
    fn what_is_written_holds_every_key() {
        let document = document();
        check(&document).unwrap();
        assert_eq!(document["target"][0]["instructions_per_count"], json!({ "mean": 100, "max": 200 }));
        assert_eq!(document["pc"][0]["cold_us"], 20.0);
        assert_eq!(document["peer"]["ratio_warm"], 200.0);
        let without = write("rustc 1.95.0", "3", &[], &[], None);
        assert!(without.get("peer").is_none());
    }

    #[test]
    fn every_missing_key_is_found() {
        for (list, expected) in [("target", TARGET), ("pc", PC)] {
            for (key, _) in expected {
                let mut broken = document();
                broken[list][0].as_object_mut().unwrap().remove(*key);
                let error = check(&broken).unwrap_err().to_string();
                assert!(error.contains(&format!("{list}[0].{key}")), "{error}");
            }
        }
        for key in ["rustc", "opt_level", "target", "pc"] {
            let mut broken = document();
            broken.as_object_mut().unwrap().remove(key);
            assert!(check(&broken).is_err(), "{key}");
        }
    }

    #[test]
    fn values_out_of_range_are_found() {
        let broken = |change: fn(&mut Value)| {
            let mut document = document();
            change(&mut document);
            check(&document).is_err()
        };
        assert!(broken(|d| d["target"][0]["mode"] = "warm".into()));
        assert!(broken(|d| d["target"][0]["instructions_per_count"]["max"] = 3.into()), "less than the mean");
        assert!(broken(|d| d["target"][0]["force_error_vs_f64_n"] = f64::NAN.into()));
        assert!(broken(|d| d["pc"][0]["warm_us"] = 0.into()));
        assert!(broken(|d| d["pc"] = json!([])));
        assert!(broken(|d| d["peer"] = json!({ "name": "casadi-ipopt" })), "a peer without times");
    }
}
