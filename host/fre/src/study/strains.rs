//! Strains of a deformed finger along its beams and in its hinges, against what the material bears.

use model_core::equilibrium::{Follower, Place};
use model_core::real::Real;
use model_core::size::Size;
use serde::{Deserialize, Serialize};

/// Strains (bending plus stretch, dimensionless, positive where material is drawn out) of a cross-section's two faces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// Arc length from the beam's base, mm.
    pub arc_mm: f64,
    /// Of the face on the object's side: the front beam's outer face, the back beam's inner one.
    pub object_side: f64,
    /// Of the other face.
    pub back_side: f64,
}

impl Section {
    /// The larger magnitude.
    pub fn largest(&self) -> f64 {
        self.object_side.abs().max(self.back_side.abs())
    }
}

/// Largest magnitudes on both sides of a cell or lamella.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pair {
    /// In the front beam's span, or in the front hinge.
    pub front: f64,
    /// In the back beam's span, or in the back hinge.
    pub back: f64,
}

/// Strains of a whole finger.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Strains {
    /// Along the front beam, base to tip. At a joint and between elements two sections may share an arc.
    pub front: Vec<Section>,
    /// Along the back beam.
    pub back: Vec<Section>,
    /// Largest strain of each span, base to tip.
    pub spans: Vec<Pair>,
    /// Largest strain of each lamella's hinges, base to tip; empty for pins and welds.
    pub hinges: Vec<Pair>,
}

impl Strains {
    /// Of what a follower stands at.
    pub fn of<T: Real, S: Size>(follower: &Follower<T, S>) -> Self {
        let mut all = Self::default();
        for strain in follower.strains() {
            let (stretch, bending) = (strain.stretch.to_f64(), strain.bending.to_f64());
            let section =
                Section { arc_mm: strain.arc.to_f64(), object_side: stretch + bending, back_side: stretch - bending };
            match strain.place {
                Place::Front(_) => all.front.push(section),
                Place::Back(_) => all.back.push(section),
                Place::FrontHinge(_) | Place::BackHinge(_) => {}
            }
            let most = match strain.place {
                Place::Front(span) => &mut pair(&mut all.spans, span).front,
                Place::Back(span) => &mut pair(&mut all.spans, span).back,
                Place::FrontHinge(lamella) => &mut pair(&mut all.hinges, lamella).front,
                Place::BackHinge(lamella) => &mut pair(&mut all.hinges, lamella).back,
            };
            *most = most.max(section.largest());
        }
        all
    }

    /// The hinge with the largest strain, in words; none without hinges.
    pub fn worst_hinge(&self) -> Option<String> {
        let all =
            self.hinges.iter().enumerate().flat_map(|(k, pair)| [(k, "front", pair.front), (k, "back", pair.back)]);
        let (lamella, side, _) = all.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|worst| worst.2 > 0.0)?;
        Some(format!("{side} of lamella {}", lamella + 1))
    }

    /// What is strained beyond a limit, the worst first: the beams at their worst section, every hinge.
    pub fn beyond(&self, limit: f64) -> Vec<Beyond> {
        let worst = |sections: &[Section]| sections.iter().copied().max_by(|a, b| a.largest().total_cmp(&b.largest()));
        let beam = |part: &str, sections: &[Section]| {
            worst(sections).map(|section| Beyond {
                part: format!("{part} beam at {:.1} mm", section.arc_mm),
                strain: section.largest(),
                limit,
            })
        };
        let hinge = |part: &str, lamella: usize, strain: f64| Beyond {
            part: format!("{part} hinge of lamella {}", lamella + 1),
            strain,
            limit,
        };
        let hinges = self.hinges.iter().enumerate();
        let hinges = hinges.flat_map(|(k, pair)| [hinge("front", k, pair.front), hinge("back", k, pair.back)]);
        let beams = [beam("front", &self.front), beam("back", &self.back)].into_iter().flatten();
        let mut found: Vec<Beyond> = beams.chain(hinges).filter(|one| one.strain > limit).collect();
        found.sort_by(|a, b| b.strain.total_cmp(&a.strain));
        found
    }
}

fn pair(pairs: &mut Vec<Pair>, index: usize) -> &mut Pair {
    if pairs.len() <= index {
        pairs.resize(index + 1, Pair::default());
    }
    &mut pairs[index]
}

/// A part that is strained more than its material bears.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beyond {
    /// Which part and where; lamellae are counted from 1 at the base.
    pub part: String,
    /// Its strain.
    pub strain: f64,
    /// What the material bears.
    pub limit: f64,
}

impl std::fmt::Display for Beyond {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: strain {:.2} %, the material bears {} %", self.part, 100.0 * self.strain, percent(self.limit))
    }
}

/// A share in percent, without trailing zeros.
pub fn percent(share: f64) -> f64 {
    (1e6 * share).round() / 1e4
}
