//! The columns of a run's results: name, kind, heading, decimals and value of each, defined once for CSV and text.

use crate::case::Coordinate;
use crate::study::friction::Friction;
use crate::study::model::{physics_word, scheme_word};
use crate::study::number::fixed;
use crate::study::place::{MaxStrain, Place, State};
use crate::study::run::Run;
use crate::study::sensitivity::Sensitivity;
use crate::study::strains::Strains;
use crate::table::Kind;

/// A value in a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Cell {
    /// Not known.
    Unknown,
    /// A number with as many digits as it has.
    Number(f64),
    /// A number of things.
    Count(usize),
    /// A word.
    Word(String),
}

impl Cell {
    /// As CSV has it: all digits; empty if it is not known.
    pub(super) fn csv(self) -> String {
        match self {
            Self::Unknown => String::new(),
            Self::Number(value) => value.to_string(),
            Self::Count(count) => count.to_string(),
            Self::Word(word) => word,
        }
    }
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        value.map_or(Self::Unknown, Self::Number)
    }
}

/// Name of a column in CSV files.
#[derive(Clone, Copy, Debug)]
enum Name {
    /// Always this one.
    Fixed(&'static str),
    /// What places are counted by.
    Place,
    /// With the unit of places between its two parts.
    Per(&'static str, &'static str),
}

/// A column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    name: Name,
    /// Two lines above the column in tables: what it is, and its unit.
    heading: fn(Coordinate) -> [&'static str; 2],
    /// Decimals in tables, and what the value is multiplied by there.
    decimals: usize,
    scale: f64,
    /// What it holds.
    kind: Kind,
    value: fn(&Run, &Place) -> Cell,
}

impl Column {
    const fn new(name: &'static str, value: fn(&Run, &Place) -> Cell) -> Self {
        Self { name: Name::Fixed(name), heading: |_| [""; 2], decimals: 0, scale: 1.0, kind: Kind::Number, value }
    }

    /// A column of words that is shown in tables, too.
    const fn words(self, heading: fn(Coordinate) -> [&'static str; 2]) -> Self {
        Self { heading, kind: Kind::Word, ..self }
    }

    /// A column that is shown in tables, too.
    const fn shown(self, heading: fn(Coordinate) -> [&'static str; 2], decimals: usize) -> Self {
        Self { heading, decimals, ..self }
    }

    /// Shown in another unit.
    const fn times(self, scale: f64) -> Self {
        Self { scale, ..self }
    }

    /// A column that holds something else than numbers.
    const fn of(self, kind: Kind) -> Self {
        Self { kind, ..self }
    }

    const fn per(before: &'static str, after: &'static str, value: fn(&Run, &Place) -> Cell) -> Self {
        Self { name: Name::Per(before, after), ..Self::new("", value) }
    }

    /// Its name in a CSV file; every name carries its unit.
    pub(super) fn name(&self, along: Coordinate) -> String {
        match self.name {
            Name::Fixed(name) => name.to_owned(),
            Name::Place => along.column().to_owned(),
            Name::Per(before, after) => format!("{before}{}{after}", along.per()),
        }
    }

    /// Its two lines of heading in a table.
    pub(super) fn heading(&self, along: Coordinate) -> [&'static str; 2] {
        (self.heading)(along)
    }

    /// Its value at a place.
    pub(super) fn value(&self, run: &Run, place: &Place) -> Cell {
        (self.value)(run, place)
    }

    /// What it holds.
    pub(super) fn kind(&self) -> Kind {
        self.kind
    }

    /// True if it is aligned to the left.
    pub(super) fn is_words(&self) -> bool {
        self.kind == Kind::Word
    }

    /// Its value as a table shows it.
    pub(super) fn cell(&self, run: &Run, place: &Place) -> String {
        match self.value(run, place) {
            Cell::Unknown => "–".to_owned(),
            Cell::Number(value) => fixed(self.scale * value, self.decimals),
            Cell::Count(count) => count.to_string(),
            Cell::Word(word) => word,
        }
    }
}

/// A number of the state, if there is one.
fn of(place: &Place, value: impl FnOnce(&State) -> f64) -> Cell {
    place.state.as_ref().map(value).into()
}

/// A number of the friction, if there is any.
fn rubbing(place: &Place, value: impl FnOnce(&Friction) -> f64) -> Cell {
    place.state.as_ref().and_then(|state| state.friction.as_ref()).map(value).into()
}

/// A component of a derivative.
fn derivative(place: &Place, axis: usize, of: impl FnOnce(&Sensitivity) -> Option<[f64; 2]>) -> Cell {
    place.state.as_ref().and_then(|state| state.sensitivity.as_ref()).and_then(of).map(|vector| vector[axis]).into()
}

/// What the force's magnitude gains by a derivative of the force.
fn gain(place: &Place, of: impl FnOnce(&Sensitivity) -> Option<[f64; 2]>) -> Cell {
    let Some(state) = &place.state else { return Cell::Unknown };
    state.sensitivity.as_ref().and_then(of).and_then(|vector| state.along_force(vector)).into()
}

pub(super) const PLACE: Column = Column {
    name: Name::Place,
    ..Column::new("", |_, place| Cell::Number(place.at.value()))
        .shown(|along| [along.word(), along.unit().trim_ascii_start()], 3)
};
/// Where time passes along a case's motion.
pub(super) const AT_TIME: Column = Column::new("time_s", |_, place| place.time_s.into()).shown(|_| ["at time", "s"], 3);
pub(super) const STATUS: Column =
    Column::new("status", |_, place| Cell::Word(place.status.to_string())).words(|_| ["status", ""]);
pub(super) const FORCE: Column =
    Column::new("force_n", |_, place| place.force_magnitude_n().into()).shown(|_| ["force", "N"], 4);
pub(super) const FORCE_X: Column =
    Column::new("force_x_n", |_, place| of(place, |s| s.force_n[0])).shown(|_| ["fx", "N"], 4);
pub(super) const FORCE_Y: Column =
    Column::new("force_y_n", |_, place| of(place, |s| s.force_n[1])).shown(|_| ["fy", "N"], 4);
pub(super) const TORQUE: Column = Column::new("motor_torque_nmm", |_, place| of(place, |s| s.motor_torque_nmm)).shown(
    |along| match along {
        Coordinate::Angle | Coordinate::Time => ["torque", "N·mm"],
        Coordinate::Distance => ["drive", "N"],
    },
    2,
);
pub(super) const ENERGY: Column =
    Column::new("energy_nmm", |_, place| place.state.as_ref().and_then(|s| s.energy_nmm).into())
        .shown(|_| ["energy", "N·mm"], 3);
pub(super) const TIP_X: Column =
    Column::new("tip_x_mm", |_, place| of(place, |s| s.tip_mm[0])).shown(|_| ["tip x", "mm"], 3);
pub(super) const TIP_Y: Column =
    Column::new("tip_y_mm", |_, place| of(place, |s| s.tip_mm[1])).shown(|_| ["tip y", "mm"], 3);
pub(super) const GAP: Column = Column::new("gap_mm", |_, place| of(place, |s| s.gap_mm)).shown(|_| ["gap", "mm"], 3);
pub(super) const CONTACTS: Column =
    Column::new("contacts", |_, place| Cell::Count(place.state.as_ref().map_or(0, |s| s.shape.contacts.len())))
        .of(Kind::Integer)
        .shown(|_| ["contacts", ""], 0);
pub(super) const ITERATIONS: Column =
    Column::new("iterations", |_, place| Cell::Count(place.effort.iterations as usize))
        .of(Kind::Integer)
        .shown(|_| ["iterations", ""], 0);
pub(super) const TIME: Column = Column::new("elapsed_us", |_, place| Cell::Number(place.effort.elapsed_us))
    .shown(|_| ["time", "ms"], 2)
    .times(1e-3);
/// The largest of the finger.
pub(super) const STRAIN: Column =
    Column::new("max_strain", |_, place| of(place, |s| MaxStrain::largest(&s.max_strain)))
        .shown(|_| ["strain", "%"], 2)
        .times(100.0);
pub(super) const STRAIN_FRONT: Column = Column::new("max_strain_front", |_, place| of(place, |s| s.max_strain.front))
    .shown(|_| ["front", "strain %"], 2)
    .times(100.0);
pub(super) const STRAIN_BACK: Column = Column::new("max_strain_back", |_, place| of(place, |s| s.max_strain.back))
    .shown(|_| ["back", "strain %"], 2)
    .times(100.0);
pub(super) const STRAIN_HINGE: Column = Column::new("max_strain_hinge", |_, place| of(place, |s| s.max_strain.hinge))
    .shown(|_| ["hinges", "strain %"], 2)
    .times(100.0);
pub(super) const WORST_HINGE: Column = Column::new("worst_hinge", |_, place| {
    let worst = place.state.as_ref().and_then(|state| Strains::worst_hinge(&state.strains));
    worst.map_or(Cell::Unknown, |(side, lamella)| Cell::Word(format!("{} of lamella {}", side.word(), lamella + 1)))
})
.words(|_| ["worst hinge", ""]);
pub(super) const PRESSURE: Column = Column::new("max_pressure_n_per_mm2", |_, place| {
    of(place, |state| state.peak_pressure().map_or(0.0, |peak| peak.pressure_n_per_mm2))
})
.shown(|_| ["pressure", "N/mm²"], 4);
pub(super) const STIFFNESS_XX: Column =
    Column::new("force_x_per_centre_x_mm_n", |_, place| derivative(place, 0, |d| Some(d.force_per_centre_mm_n[0])))
        .shown(|_| ["dFx/dx", "N/mm"], 3);
pub(super) const STIFFNESS_YX: Column =
    Column::new("force_y_per_centre_x_mm_n", |_, place| derivative(place, 1, |d| Some(d.force_per_centre_mm_n[0])))
        .shown(|_| ["dFy/dx", "N/mm"], 3);
pub(super) const STIFFNESS_XY: Column =
    Column::new("force_x_per_centre_y_mm_n", |_, place| derivative(place, 0, |d| Some(d.force_per_centre_mm_n[1])))
        .shown(|_| ["dFx/dy", "N/mm"], 3);
pub(super) const STIFFNESS_YY: Column =
    Column::new("force_y_per_centre_y_mm_n", |_, place| derivative(place, 1, |d| Some(d.force_per_centre_mm_n[1])))
        .shown(|_| ["dFy/dy", "N/mm"], 3);

pub(super) const NORMAL: Column =
    Column::new("friction_normal_n", |_, place| rubbing(place, |f| f.normal_n)).shown(|_| ["normal", "N"], 4);
pub(super) const TANGENTIAL: Column =
    Column::new("friction_tangential_n", |_, place| rubbing(place, |f| f.tangential_n)).shown(|_| ["tangent", "N"], 4);
pub(super) const MOBILISED: Column =
    Column::new("friction_mobilised", |_, place| rubbing(place, |f| f.mobilised)).shown(|_| ["mobilised", ""], 3);
pub(super) const DISSIPATED: Column =
    Column::new("friction_dissipated_nmm", |_, place| rubbing(place, |f| f.dissipated_nmm))
        .shown(|_| ["dissipated", "N·mm"], 3);

/// Columns of CSV files. New ones are added at the end only: files that were written before are read on.
pub(super) const CSV: [Column; 45] = [
    STATUS,
    PLACE,
    FORCE_X,
    FORCE_Y,
    FORCE,
    Column::new("force_finger_frame_x_n", |_, place| of(place, |s| s.force_finger_frame_n[0])),
    Column::new("force_finger_frame_y_n", |_, place| of(place, |s| s.force_finger_frame_n[1])),
    TORQUE,
    ENERGY,
    TIP_X,
    TIP_Y,
    CONTACTS,
    ITERATIONS,
    Column::new("steps", |_, place| Cell::Count(place.effort.steps as usize)).of(Kind::Integer),
    TIME,
    Column::new("scheme", |run, _| Cell::Word(scheme_word(run.model.scheme).to_owned())).of(Kind::Word),
    Column::new("elements_per_beam", |run, _| Cell::Count(run.model.elements_per_beam as usize)).of(Kind::Integer),
    Column::new("elements_per_hinge", |run, _| Cell::Count(run.model.elements_per_hinge as usize)).of(Kind::Integer),
    Column::new("unknowns", |run, _| Cell::Count(run.model.unknowns)).of(Kind::Integer),
    Column::new("physics", |run, _| Cell::Word(physics_word(run.model.physics).to_owned())).of(Kind::Word),
    Column::new("precision", |run, _| Cell::Word(run.model.precision.word().to_owned())).of(Kind::Word),
    STRAIN_FRONT,
    STRAIN_BACK,
    STRAIN_HINGE,
    Column::per("force_x_per_", "_n", |_, place| derivative(place, 0, Sensitivity::force_along_motion)),
    Column::per("force_y_per_", "_n", |_, place| derivative(place, 1, Sensitivity::force_along_motion)),
    GAP,
    STIFFNESS_XX,
    STIFFNESS_YX,
    STIFFNESS_XY,
    STIFFNESS_YY,
    PRESSURE,
    Column::new("beyond_max_strain", |_, place| {
        if place.state.is_some() { Cell::Word(place.is_overstrained().to_string()) } else { Cell::Unknown }
    })
    .of(Kind::Flag),
    Column::new("branch", |_, place| place.branch.map_or(Cell::Unknown, |branch| Cell::Count(branch as usize)))
        .of(Kind::Integer),
    Column::new("first_branch_max_force_n", |run, _| run.first_branch.map(|first| first.max_force_n).into()),
    Column::per("first_branch_max_force_at_", "", |run, _| {
        run.first_branch.and_then(|first| first.max_force_at()).into()
    }),
    Column::per("snap_after_", "", |run, _| snap(run, 0)),
    Column::per("snap_before_", "", |run, _| snap(run, 1)),
    Column::new("overlap_mm", |_, place| place.overlap_mm.into()),
    // What `force_n` is, by the name that it has in JSON, where `force_n` has two components.
    Column::new("force_magnitude_n", |_, place| place.force_magnitude_n().into()),
    NORMAL,
    TANGENTIAL,
    MOBILISED,
    DISSIPATED,
    AT_TIME,
];

/// One of the places between which the finger snaps through.
fn snap(run: &Run, end: usize) -> Cell {
    run.first_branch.and_then(|first| first.snap_between()).map(|between| between[end]).into()
}

/// Results for everybody.
pub(super) const RESULTS: [Column; 14] =
    [PLACE, STATUS, FORCE, FORCE_X, FORCE_Y, TORQUE, ENERGY, TIP_X, TIP_Y, STRAIN, GAP, CONTACTS, ITERATIONS, TIME];

/// Friction.
pub(super) const RUBBING: [Column; 5] = [PLACE, NORMAL, TANGENTIAL, MOBILISED, DISSIPATED];

/// Results for a finger's designer.
pub(super) const DESIGN: [Column; 10] = [
    PLACE,
    STRAIN_FRONT,
    STRAIN_BACK,
    STRAIN_HINGE,
    WORST_HINGE,
    PRESSURE,
    STIFFNESS_XX,
    STIFFNESS_XY,
    STIFFNESS_YX,
    STIFFNESS_YY,
];

/// What the force's magnitude gains per unit of what it depends on.
pub(super) const GAINS: [Column; 12] = [
    PLACE,
    Column::per("gain_per_", "_n", |_, place| gain(place, Sensitivity::force_along_motion)).shown(
        |along| match along {
            Coordinate::Angle => ["angle", "N/°"],
            Coordinate::Distance => ["distance", "N/mm"],
            Coordinate::Time => ["time", "N/s"],
        },
        4,
    ),
    Column::new("", |_, place| gain(place, |d| Some(d.force_per_centre_mm_n[0]))).shown(|_| ["centre x", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| Some(d.force_per_centre_mm_n[1]))).shown(|_| ["centre y", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| Some(d.force_per_radius_mm_n))).shown(|_| ["radius", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| Some(d.force_per_youngs_modulus_mpa_n))).shown(|_| ["E", "N/MPa"], 4),
    Column::new("", |_, place| gain(place, |d| d.force_per_front_thickness_mm_n)).shown(|_| ["front thk.", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| d.force_per_back_thickness_mm_n)).shown(|_| ["back thk.", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| d.force_per_hinge_thickness_mm_n)).shown(|_| ["hinge thk.", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| d.force_per_hinge_length_mm_n)).shown(|_| ["hinge len.", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| Some(d.force_per_motor_axis_mm_n[0]))).shown(|_| ["axis x", "N/mm"], 4),
    Column::new("", |_, place| gain(place, |d| Some(d.force_per_motor_axis_mm_n[1]))).shown(|_| ["axis y", "N/mm"], 4),
];
