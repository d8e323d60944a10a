//! The figures as JSON, with keys that others rely on.

use anyhow::{Result, bail};
use serde_json::{Value, json};

use crate::ladder::word;
use crate::pc::Time;
use crate::peer::Peer;
use crate::rates::Rates;
use crate::spread::Spread;
use crate::target::Row;

const CASE: Kind = Kind::OneOf(&["ladder-80 R40-Mid", "ribs-7", "umi"]);

/// What was measured; parts that were not asked for are absent.
#[derive(Clone, Copy)]
pub struct Figures<'a> {
    /// Compiler and optimisation level of the target's images.
    pub rustc: &'a str,
    pub opt_level: &'a str,
    pub target: Option<&'a [Row]>,
    pub pc: Option<&'a [Time]>,
    /// Absent where the peer is not installed, too.
    pub peer: Option<Peer>,
    pub rates: Option<&'a Rates>,
}

impl Figures<'_> {
    /// The figures as JSON.
    pub fn document(&self) -> Value {
        let mut document = json!({ "rustc": self.rustc, "opt_level": self.opt_level });
        if let Some(rows) = self.target {
            document["target"] = rows.iter().map(row).collect();
        }
        if let Some(times) = self.pc {
            document["pc"] = times.iter().map(time).collect();
        }
        if let Some(peer) = self.peer {
            document["peer"] = json!({
                "name": "casadi-ipopt",
                "cold_us": peer.cold_us,
                "warm_us": peer.warm_us,
                "ratio_cold": peer.ratio_cold,
                "ratio_warm": peer.ratio_warm,
                "force_apart": peer.apart,
            });
        }
        if let Some(rates) = self.rates {
            document["worst_tick"] = rates.document();
        }
        document
    }

    /// Names the key that is missing from what was measured, or holds what it must not.
    pub fn check(&self, document: &Value) -> Result<()> {
        keys(document, "", &[("rustc", Kind::Text), ("opt_level", Kind::Text)])?;
        let lists = [
            ("target", TARGET, self.target.is_some()),
            ("pc", PC, self.pc.is_some()),
            ("worst_tick", WORST_TICK, self.rates.is_some()),
        ];
        for (list, expected, _) in lists.iter().filter(|(.., measured)| *measured) {
            let Some(rows) = document[*list].as_array().filter(|rows| !rows.is_empty()) else {
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
}

fn row(row: &Row) -> Value {
    let mut value = json!({
        "board": "mps2",
        "case": row.model.case,
        "model": row.model.name,
        "mode": row.mode,
        "hessian": row.hessian,
        "physics": word(row.model.physics),
        "friction": f64::from(row.model.friction) / 100.0,
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
        "case": time.case,
        "model": time.model,
        "physics": word(time.physics),
        "friction": f64::from(time.friction) / 100.0,
        "precision": time.precision,
        "warm_us": time.warm_us,
        "warm_mean_us": time.ticks_us.mean,
        "warm_max_us": time.ticks_us.max,
        "cold_us": time.cold_us,
        "places_per_s": time.places_per_s,
    })
}

/// What a key must hold.
#[derive(Clone, Copy)]
enum Kind {
    Text,
    OneOf(&'static [&'static str]),
    /// A board's name.
    Board,
    Positive,
    NotNegative,
    /// `mean` and `max`.
    Spread,
    /// `low` and `high`, positive and in this order.
    Bounds,
}

const PHYSICS: Kind = Kind::OneOf(&["paper", "extended"]);

const TARGET: &[(&str, Kind)] = &[
    ("board", Kind::OneOf(&["mps2"])),
    ("case", CASE),
    (
        "model",
        Kind::OneOf(&["simpson-17-1", "simpson-17-1-rubbing", "simpson-17-1-memory", "simpson-ribs", "paper-170-20"]),
    ),
    ("mode", Kind::OneOf(&["converged", "one-iteration"])),
    ("hessian", Kind::OneOf(&["newton", "gauss-newton"])),
    ("physics", PHYSICS),
    ("friction", Kind::NotNegative),
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
    ("case", CASE),
    ("model", Kind::Text),
    ("physics", PHYSICS),
    ("friction", Kind::NotNegative),
    ("precision", Kind::OneOf(&["f32", "f64"])),
    ("warm_us", Kind::Positive),
    ("warm_mean_us", Kind::Positive),
    ("warm_max_us", Kind::Positive),
    ("cold_us", Kind::Positive),
    ("places_per_s", Kind::Positive),
];

const WORST_TICK: &[(&str, Kind)] = &[
    ("board", Kind::Board),
    ("layout", Kind::Text),
    ("fingers", Kind::Positive),
    ("samples", Kind::Positive),
    ("instructions", Kind::Spread),
    ("cycles", Kind::Bounds),
    ("late_ticks", Kind::NotNegative),
    ("rate_hz", Kind::Positive),
];

const PEER: &[(&str, Kind)] = &[
    ("name", Kind::Text),
    ("cold_us", Kind::Positive),
    ("warm_us", Kind::Positive),
    ("ratio_cold", Kind::Positive),
    ("ratio_warm", Kind::Positive),
];

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
        Kind::Board => value.as_str().is_some_and(|text| fre_boards::named(text).is_some()),
        Kind::Positive => number(value).is_some_and(|number| number > 0.0),
        Kind::NotNegative => number(value).is_some_and(|number| number >= 0.0),
        Kind::Bounds => matches!(
            (number(&value["low"]), number(&value["high"])),
            (Some(low), Some(high)) if 0.0 < low && low <= high
        ),
        Kind::Spread => matches!(
            (number(&value["mean"]), number(&value["max"])),
            (Some(mean), Some(max)) if 0.0 < mean && mean <= max
        ),
    }
}

#[cfg(test)]
mod tests {
    use model_core::discretise::Physics;

    use super::*;
    use crate::pc::{Model, REDUCED};

    fn with<T>(take: impl FnOnce(Figures<'_>) -> T) -> T {
        let spread = Spread { mean: 100.4, max: 200.0 };
        let row = Row {
            model: Model { case: "umi", name: REDUCED, samples: 4, physics: Physics::Extended, friction: 0 },
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
            case: "ribs-7",
            model: "fine",
            physics: Physics::Paper,
            friction: 0,
            precision: "f64",
            warm_us: 1.5,
            ticks_us: spread,
            cold_us: 20.0,
            places_per_s: 9e4,
        };
        let peer = Peer { cold_us: 4e4, warm_us: 2e4, ratio_cold: 20.0, ratio_warm: 200.0, apart: 1e-9, compared: 31 };
        take(Figures {
            rustc: "rustc 1.95.0",
            opt_level: "3",
            target: Some(&[row]),
            pc: Some(&[time]),
            peer: Some(peer),
            rates: Some(&crate::rates::example()),
        })
    }

    /// Whether a document that was changed so is refused, and why.
    fn refused(change: impl FnOnce(&mut Value)) -> Option<String> {
        with(|figures| {
            let mut document = figures.document();
            change(&mut document);
            figures.check(&document).err().map(|error| error.to_string())
        })
    }

    #[test]
    fn what_is_written_holds_every_key() {
        assert_eq!(refused(|_| {}), None);
        let document = with(|figures| figures.document());
        assert_eq!(document["target"][0]["instructions_per_count"], json!({ "mean": 100, "max": 200 }));
        assert_eq!(document["target"][0]["physics"], "extended");
        assert_eq!((&document["target"][0]["case"], &document["pc"][0]["case"]), (&json!("umi"), &json!("ribs-7")));
        assert_eq!(document["pc"][0]["cold_us"], 20.0);
        assert_eq!(document["peer"]["ratio_warm"], 200.0);
    }

    #[test]
    fn parts_that_were_not_measured_are_absent() {
        with(|figures| {
            let some = Figures { target: None, peer: None, rates: None, ..figures };
            let document = some.document();
            some.check(&document).unwrap();
            let keys: Vec<&String> = document.as_object().unwrap().keys().collect();
            assert_eq!(keys, ["rustc", "opt_level", "pc"]);
            assert!(figures.check(&document).is_err(), "measured, and not written");
        });
    }

    #[test]
    fn every_missing_key_is_found() {
        for (list, expected) in [("target", TARGET), ("pc", PC), ("worst_tick", WORST_TICK)] {
            for (key, _) in expected {
                let error = refused(|document| drop(document[list][0].as_object_mut().unwrap().remove(*key))).unwrap();
                assert!(error.contains(&format!("{list}[0].{key}")), "{error}");
            }
        }
        for key in ["rustc", "opt_level", "target", "pc", "worst_tick"] {
            assert!(refused(|document| drop(document.as_object_mut().unwrap().remove(key))).is_some(), "{key}");
        }
    }

    #[test]
    fn values_out_of_range_are_found() {
        let is_refused = |change: fn(&mut Value)| refused(change).is_some();
        assert!(is_refused(|d| d["target"][0]["mode"] = "warm".into()));
        assert!(is_refused(|d| d["pc"][0]["case"] = "ladder-90".into()));
        assert!(is_refused(|d| d["target"][0]["instructions_per_count"]["max"] = 3.into()), "less than the mean");
        assert!(is_refused(|d| d["target"][0]["force_error_vs_f64_n"] = f64::NAN.into()));
        assert!(is_refused(|d| d["pc"][0]["warm_us"] = 0.into()));
        assert!(is_refused(|d| d["pc"] = json!([])));
        assert!(is_refused(|d| d["worst_tick"][0]["cycles"]["low"] = 1e12.into()), "above the upper bound");
        assert!(is_refused(|d| d["peer"] = json!({ "name": "casadi-ipopt" })), "a peer without times");
    }
}
