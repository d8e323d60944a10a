//! Strains of a deformed finger along its beams and in its hinges, against what the material bears.

use model_core::equilibrium::Follower;
use model_core::real::Real;
use model_core::size::Size;
use model_core::solution::Place;
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
    /// Largest strain of each rib, base to tip; empty for rigid lamellae.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ribs: Vec<f64>,
}

impl Strains {
    /// Of what a follower is at.
    pub fn of<T: Real, S: Size>(follower: &Follower<T, S>) -> Self {
        let mut all = Self::default();
        for strain in follower.solution().strains() {
            let (stretch, bending) = (strain.stretch.to_f64(), strain.bending.to_f64());
            let section =
                Section { arc_mm: strain.arc.to_f64(), object_side: stretch + bending, back_side: stretch - bending };
            match strain.place {
                Place::Front(_) => all.front.push(section),
                Place::Back(_) => all.back.push(section),
                Place::FrontHinge(_) | Place::BackHinge(_) | Place::Rib(_) => {}
            }
            let most = match strain.place {
                Place::Front(span) => &mut pair(&mut all.spans, span).front,
                Place::Back(span) => &mut pair(&mut all.spans, span).back,
                Place::FrontHinge(lamella) => &mut pair(&mut all.hinges, lamella).front,
                Place::BackHinge(lamella) => &mut pair(&mut all.hinges, lamella).back,
                Place::Rib(rib) => {
                    if all.ribs.len() <= rib {
                        all.ribs.resize(rib + 1, 0.0);
                    }
                    &mut all.ribs[rib]
                }
            };
            *most = most.max(section.largest());
        }
        all
    }

    /// The hinge with the largest strain: its side and its lamella, from 0; `None` without hinges.
    pub fn worst_hinge(&self) -> Option<(Side, usize)> {
        let all = self
            .hinges
            .iter()
            .enumerate()
            .flat_map(|(k, pair)| [(Side::Front, k, pair.front), (Side::Back, k, pair.back)]);
        let (side, lamella, _) = all.max_by(|a, b| a.2.total_cmp(&b.2)).filter(|worst| worst.2 > 0.0)?;
        Some((side, lamella))
    }

    /// What is strained beyond a limit, the worst first: the beams at their worst section, every hinge and rib.
    pub fn beyond(&self, limit: Limit) -> Vec<Beyond> {
        let worst = |sections: &[Section]| sections.iter().copied().max_by(|a, b| a.largest().total_cmp(&b.largest()));
        let beam = |side: Side, sections: &[Section]| {
            let section = worst(sections)?;
            Some(Beyond { part: Part::Beam { side, arc_mm: section.arc_mm }, strain: section.largest(), limit })
        };
        let hinge =
            |side: Side, lamella: usize, strain: f64| Beyond { part: Part::Hinge { side, lamella }, strain, limit };
        let hinges = self.hinges.iter().enumerate();
        let hinges = hinges.flat_map(|(k, pair)| [hinge(Side::Front, k, pair.front), hinge(Side::Back, k, pair.back)]);
        let ribs = self.ribs.iter().enumerate();
        let ribs = ribs.map(|(lamella, &strain)| Beyond { part: Part::Rib { lamella }, strain, limit });
        let beams = [beam(Side::Front, &self.front), beam(Side::Back, &self.back)].into_iter().flatten();
        let mut found: Vec<Beyond> = beams.chain(hinges).chain(ribs).filter(|one| one.strain > limit.share()).collect();
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

/// Which beam a part belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The contact beam.
    Front,
    /// The other one.
    Back,
}

impl Side {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Back => "back",
        }
    }
}

/// A part of a finger that has a strain of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Part {
    /// A beam, at its worst section.
    Beam {
        /// Which one.
        side: Side,
        /// Arc length of the section from the base, mm.
        arc_mm: f64,
    },
    /// A hinge.
    Hinge {
        /// At which beam.
        side: Side,
        /// Of which lamella, from 0 at the base.
        lamella: usize,
    },
    /// A rib.
    Rib {
        /// Which one, from 0 at the base.
        lamella: usize,
    },
}

impl Part {
    /// True for sections of the same beam, and for the same hinge.
    pub fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::Beam { side, .. }, Self::Beam { side: other, .. }) => side == other,
            _ => self == other,
        }
    }
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Beam { side, arc_mm } => write!(f, "{} beam at {arc_mm:.1} mm", side.word()),
            Self::Hinge { side, lamella } => write!(f, "{} hinge of lamella {}", side.word(), lamella + 1),
            Self::Rib { lamella } => write!(f, "rib {}", lamella + 1),
        }
    }
}

/// Strain beyond which results carry a warning where the material's own limit is not known: rubbers and TPU are far from linear there,
/// and an object that was put in the wrong place strains a finger more than this.
const PLAUSIBLE: f64 = 0.3;

/// The strain beyond which a result carries a warning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// What the material bears, as the case says.
    Material(f64),
    /// The case does not say: 30 %.
    Plausible,
}

impl Limit {
    /// That of a material whose limit is known or not.
    pub fn of(max_strain: Option<f64>) -> Self {
        max_strain.map_or(Self::Plausible, Self::Material)
    }

    /// The strain, dimensionless.
    pub fn share(self) -> f64 {
        match self {
            Self::Material(share) => share,
            Self::Plausible => PLAUSIBLE,
        }
    }
}

/// A part that is strained beyond a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beyond {
    /// Which part and where.
    pub part: Part,
    /// Its strain.
    pub strain: f64,
    /// What it exceeds.
    pub limit: Limit,
}

impl std::fmt::Display for Beyond {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (part, strain, limit) = (self.part, 100.0 * self.strain, percent(self.limit.share()));
        match self.limit {
            Limit::Material(_) => write!(f, "{part}: strain {strain:.2} %, the material bears {limit} %"),
            Limit::Plausible => write!(
                f,
                "{part}: strain {strain:.2} %, more than {limit} %: check where the case has its object and how far the finger moves; \
                 finger.material.max_strain sets another limit"
            ),
        }
    }
}

/// A share in percent, without trailing zeros.
pub fn percent(share: f64) -> f64 {
    (1e6 * share).round() / 1e4
}
