//! The grid: what is solved, point by point.

use std::ops::Range;
use std::sync::Arc;

use model_core::discretise::DiscretiseError;
use model_core::equilibrium::Follower;
use model_core::object::Motion;

use super::axis::Axis;
use super::error::SweepError;
use super::shard::Shard;
use crate::case::{Case, CaseError, Document, MotionPath};
use crate::heap::Host;
use crate::study::model::Options;
use crate::study::run::{Run, solve};

/// The most rows of a sweep.
const MOST_ROWS: usize = 10_000_000;

/// A sweep: the grid is the product of the axes (the last one changes fastest), each point is followed through the
/// places of the motion. Cheap to share between threads.
#[derive(Clone, Debug)]
pub struct Sweep {
    pub(super) document: Document,
    pub(super) axes: Vec<Axis>,
    pub(super) options: Options,
    pub(super) path: Arc<MotionPath>,
    shard: Option<Shard>,
    between: Option<Range<usize>>,
    pub(super) shapes: bool,
}

impl Sweep {
    /// A sweep of a case over axes; `angles_deg` replaces the case's own motor angles.
    ///
    /// # Errors
    /// An unknown or repeated key, a grid that is too large, or angles that the case cannot have.
    pub fn new(
        mut document: Document,
        angles_deg: Option<&[f64]>,
        axes: Vec<Axis>,
        options: Options,
    ) -> Result<Self, SweepError> {
        for (index, axis) in axes.iter().enumerate() {
            if let Axis::Key { key, .. } = axis {
                document.need(key)?;
            }
            if axes[..index].iter().any(|earlier| earlier.name() == axis.name()) {
                return Err(SweepError::Twice { key: axis.name().to_owned() });
            }
            for earlier in &axes[..index] {
                for (whole, part) in [(axis.name(), earlier.name()), (earlier.name(), axis.name())] {
                    if part.strip_prefix(whole).is_some_and(|rest| rest.starts_with('.')) {
                        return Err(SweepError::Within { part: part.to_owned(), whole: whole.to_owned() });
                    }
                }
            }
        }
        if let Some(angles) = angles_deg {
            if matches!(document.case()?.path.motion, Motion::Translating { .. }) {
                return Err(SweepError::Translating);
            }
            document.set_angles(angles);
        }
        let path = document.case()?.path;
        let rows = axes.iter().fold(path.places.len() as u128, |rows, axis| rows.saturating_mul(axis.len() as u128));
        if rows > MOST_ROWS as u128 {
            return Err(SweepError::TooMany { rows, max: MOST_ROWS });
        }
        Ok(Self { document, axes, options, path: path.into(), shard: None, between: None, shapes: false })
    }

    /// The part of it that is one machine's.
    #[must_use]
    pub fn only(self, shard: Option<Shard>) -> Self {
        Self { shard, ..self }
    }

    /// Only the points between two numbers, for a task of a larger work; its rows cannot be kept in a file of their own.
    #[must_use]
    pub fn between(self, points: Option<Range<usize>>) -> Self {
        Self { between: points, ..self }
    }

    /// With the points of both centrelines in every row, or without them.
    #[must_use]
    pub fn with_shapes(self, shapes: bool) -> Self {
        Self { shapes, ..self }
    }

    /// The part that it is; none for the whole.
    pub fn shard(&self) -> Option<Shard> {
        self.shard
    }

    /// True if a point belongs to this part.
    pub fn has(&self, point: usize) -> bool {
        self.shard.is_none_or(|shard| shard.has(point))
            && self.between.as_ref().is_none_or(|points| points.contains(&point))
    }

    /// The points of this part.
    pub fn own_points(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.points()).filter(|&point| self.has(point))
    }

    /// Number of rows of this part.
    pub fn own_rows(&self) -> usize {
        self.own_points().count() * self.places().len()
    }

    /// Number of points of the grid.
    pub fn points(&self) -> usize {
        self.axes.iter().map(Axis::len).product()
    }

    /// Motor angles (degrees) or distances (mm) at every point.
    pub fn places(&self) -> &[f64] {
        &self.path.places
    }

    /// What follows the number of a place: "°" or " mm".
    pub fn unit(&self) -> &'static str {
        self.path.unit()
    }

    /// True if several resolutions are compared.
    pub fn has_resolutions(&self) -> bool {
        self.axes.iter().any(|axis| matches!(axis, Axis::Elements(values) if values.len() > 1))
    }

    /// Number of rows of the result.
    pub fn rows(&self) -> usize {
        self.points() * self.places().len()
    }

    /// Index of a point's value on every axis.
    pub(super) fn indices(&self, mut point: usize) -> Vec<usize> {
        let mut indices: Vec<usize> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let count = axis.len().max(1);
                let index = point % count;
                point /= count;
                index
            })
            .collect();
        indices.reverse();
        indices
    }

    /// A point's values, as written in its rows.
    pub fn words(&self, point: usize) -> Vec<String> {
        self.axes.iter().zip(self.indices(point)).map(|(axis, index)| axis.words(index)).collect()
    }

    /// A point's keys with their values, for people.
    pub fn describe(&self, point: usize) -> String {
        let parts = self.axes.iter().zip(self.words(point)).map(|(axis, words)| format!("{}={words}", axis.name()));
        parts.collect::<Vec<_>>().join(" ")
    }

    /// The case and the options of a point.
    ///
    /// # Errors
    /// The point is not a case: a value is out of its range or does not fit the others.
    pub fn point(&self, point: usize) -> Result<(Case, Options), SweepError> {
        let mut document = self.document.clone();
        let mut options = self.options;
        for (axis, index) in self.axes.iter().zip(self.indices(point)) {
            match axis {
                Axis::Key { key, values } => {
                    if let Some(&value) = values.get(index) {
                        document.set_known(key, value);
                    }
                }
                Axis::Elements(values) => {
                    if let Some(&(_, elements)) = values.get(index) {
                        options.discretisation.elements = elements;
                    }
                }
            }
        }
        let refused = |error: CaseError| self.refused(point, error.key(), error.without_place());
        let case = document.case().map_err(refused)?;
        Ok((case, options))
    }

    /// Fails as [`Self::solve`] would, without solving.
    ///
    /// # Errors
    /// As there.
    pub fn check(&self, point: usize) -> Result<(), SweepError> {
        let (case, options) = self.point(point)?;
        let mut follower = Follower::<f64, Host>::EMPTY;
        follower
            .configure(&case.finger.design, &options.discretisation)
            .map_err(|error| self.not_discretised(point, &error))
    }

    /// Solves a point.
    ///
    /// # Errors
    /// The point is not a case, or cannot be discretised as asked.
    pub fn solve(&self, point: usize) -> Result<Run, SweepError> {
        let (case, options) = self.point(point)?;
        solve(&case, &options).map_err(|error| self.not_discretised(point, &error))
    }

    fn not_discretised(&self, point: usize, error: &DiscretiseError) -> SweepError {
        match error {
            DiscretiseError::Design(error) => self.refused(point, Some("finger"), format!("finger.{error}")),
            other => self.refused(point, None, format!("--{other}")),
        }
    }

    fn refused(&self, point: usize, key: Option<&str>, reason: String) -> SweepError {
        let point = self.describe(point);
        let point = if point.is_empty() { "the case".to_owned() } else { point };
        SweepError::Point { point, key: key.map(str::to_owned), reason }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use model_core::discretise::Elements;

    use super::Sweep;
    use crate::case::Document;
    use crate::study::model::Options;
    use crate::study::sweep::axis::Axis;
    use crate::study::sweep::error::SweepError;

    fn sweep(axes: Vec<Axis>, angles: Option<&[f64]>) -> Result<Sweep, SweepError> {
        let text = "finger = \"preset:ladder-80\"\n[object]\nshape = \"circle\"\nradius_mm = 40\ncentre_mm = [41, 45]\n\
            [motion]\nmotor_angles_deg = [2, 4]\n";
        Sweep::new(Document::resolve("case.toml", text, Path::new(""))?, angles, axes, Options::default())
    }

    fn key(key: &str, values: &[f64]) -> Axis {
        Axis::Key { key: key.to_owned(), values: values.to_vec() }
    }

    #[test]
    fn the_grid_is_the_product_of_its_axes() {
        let elements = Axis::Elements(vec![("24/3".into(), Elements::PerBeam { beam: 24, hinge: 3 })]);
        let axes =
            vec![key("object.radius_mm", &[20.0, 30.0, 40.0]), key("object.centre_mm.1", &[30.0, 45.0]), elements];
        let sweep = sweep(axes, Some(&[1.0, 2.0, 3.0, 4.0])).unwrap();
        assert_eq!((sweep.points(), sweep.rows()), (6, 24));
        let all: Vec<String> = (0..6).map(|point| sweep.words(point).join(" ")).collect();
        assert_eq!(all, ["20 30 24/3", "20 45 24/3", "30 30 24/3", "30 45 24/3", "40 30 24/3", "40 45 24/3"]);
        let (case, options) = sweep.point(3).unwrap();
        let wanted = model_core::object::ObjectDesign::Circle { centre: [41.0, 45.0], radius: 30.0 };
        assert_eq!(case.object, wanted);
        assert_eq!(options.discretisation.elements, Elements::PerBeam { beam: 24, hinge: 3 });
        assert_eq!(case.path.places, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn without_axes_there_is_one_point() {
        let sweep = sweep(Vec::new(), None).unwrap();
        assert_eq!((sweep.points(), sweep.rows()), (1, 2));
        assert!(sweep.words(0).is_empty() && sweep.point(0).is_ok());
    }

    #[test]
    fn impossible_grids_are_refused() {
        let message = |axes, angles| sweep(axes, angles).err().map_or_else(String::new, |error| error.to_string());
        let mut said = message(vec![key("object.radius", &[1.0])], None);
        let twice = vec![key("object.radius_mm", &[20.0]), key("object.radius_mm", &[30.0])];
        said += &format!("\n{}", message(twice, None));
        let hinge = || key("finger.hinge.length_mm", &[2.0]);
        assert!(sweep(vec![hinge()], None).is_ok());
        let text = "finger = \"preset:ladder-80\"\nobject = { shape = \"circle\", radius_mm = 40, centre_mm = [41, 45] }\n\
            motion.motor_angles_deg = [2]\n";
        let mut document = Document::resolve("case.toml", text, Path::new("")).unwrap();
        document.set("finger.width_mm", 20.0).unwrap();
        let tapered = document.text().replace("width_mm = 20.0", "width_mm = [[0, 24], [80, 16]]");
        for order in [["finger.width_mm", "finger.width_mm.1.1"], ["finger.width_mm.1.1", "finger.width_mm"]] {
            let document = Document::resolve("case.toml", &tapered, Path::new("")).unwrap();
            let axes = order.map(|name| key(name, &[20.0])).to_vec();
            let error = Sweep::new(document, None, axes, Options::default()).unwrap_err().to_string();
            said += &format!("\n{error}");
        }
        let many = vec![key("object.radius_mm", &[20.0; 4000]), key("object.centre_mm.0", &[50.0; 4000])];
        said += &format!("\n{}", message(many, None));
        said += &format!("\n{}", message(Vec::new(), Some(&[1.0, 200.0])));
        snapbox::assert_data_eq!(
            said,
            snapbox::str![[r#"
--vary: "object.radius" is not a number of this case; the nearest are object.radius_mm, finger.lamellae.gap_mm, object.friction, finger.back.base_mm.0, elements
--vary: object.radius_mm is given twice; allowed is once, with all its values
--vary: finger.width_mm.1.1 is a part of finger.width_mm, which is varied as well; allowed is one of them
--vary: finger.width_mm.1.1 is a part of finger.width_mm, which is varied as well; allowed is one of them
the grid has 32000000 rows; allowed are 10000000
case.toml:42: motion.motor_angles_deg[1] = 200.0: allowed is -180 to 180 degrees
"#]]
        );
        let sweep = sweep(vec![key("object.radius_mm", &[20.0, -5.0])], None).unwrap();
        assert!(sweep.point(0).is_ok());
        let message = sweep.point(1).unwrap_err().to_string();
        assert!(message.starts_with("at object.radius_mm=-5: object.radius_mm = -5.0: allowed is"), "{message}");
    }
}
