//! Contact samples of the front beam.

use super::rung::weld;
use super::{Discretisation, DiscretiseError, Sampling, Scheme};
use crate::access::Access as _;
use crate::contact::Sample;
use crate::design::Design;
use crate::design::junction::flexible_ends;
use crate::element::hermite_weights;
use crate::model::Model;
use crate::real::Real;
use crate::size::{Size, Storage};

/// Places the contact samples along the front beam, base to tip, and on the face of the rigid wedge.
pub(super) fn write_samples<T: Real, S: Size>(
    model: &mut Model<T, S>,
    design: &Design,
    how: &Discretisation,
    counts: &[u16],
) -> Result<(), DiscretiseError> {
    let ends = flexible_ends(design);
    let beam = &design.front;
    let mut total = 0;
    let mut push = |model: &mut Model<T, S>, sample: Sample<T>| {
        total += 1;
        let fits = model.samples.fit(total);
        if fits {
            model.samples.as_mut().put(total - 1, sample);
            model.sample_count = total;
        }
        fits.then_some(()).ok_or(DiscretiseError::Capacity)
    };
    let per_element = match how.sampling {
        Sampling::Nodes => 1,
        Sampling::PerElement(n) => usize::from(n),
    };
    let cells = counts.len();
    // Where the present span's elements begin.
    let (mut from, mut start) = (beam.clamp, beam.clamp);
    for (cell, &count) in counts.iter().enumerate() {
        // A weld lies about the lamella's axis; it turns with the joint at the span's end.
        let (to, rigid) = if cell + 1 == cells {
            (ends[0], 0.0)
        } else {
            let [down, up] = weld(design, how, cell).reach[0];
            (design.attachment_arcs(cell)[0] - down, down + up)
        };
        model.first_samples.as_mut().put(cell, model.sample_count as u16);
        let h = (to - from) / f64::from(count);
        let first = usize::from(model.topology.members.as_ref().at(cell).first);
        start = from;
        for element in 0..usize::from(count) {
            for k in 1..=per_element {
                let xi = k as f64 / per_element as f64;
                let arc = from + (element as f64 + xi) * h;
                let (node, weights) = match how.scheme {
                    Scheme::Paper | Scheme::Trapezoid => (first + element + 1, [h, 0.0, 0.0]),
                    Scheme::Simpson => {
                        let [a, m, b] = hermite_weights::<f64>(xi, h);
                        let shared = if element > 0 { h / 6.0 } else { 0.0 };
                        (first + 2 * element, [shared + a, m, b])
                    }
                };
                push(
                    model,
                    Sample {
                        cell: cell as u16,
                        node: node as u16,
                        weights: weights.map(T::of),
                        rigid: T::ZERO,
                        arc: T::of(arc),
                        half_thickness: T::of(0.5 * beam.thickness.at(arc)),
                    },
                )?;
            }
        }
        if rigid > 0.0 {
            // About as densely as on the elements, up to where the next span begins.
            let pieces = (libm::round(rigid * per_element as f64 / h) as usize).max(1);
            let nodes = model.topology.members.as_ref().at(cell).nodes();
            for k in 1..=pieces {
                let part = k as f64 / pieces as f64;
                let arc = to + part * rigid;
                let half_thickness = T::of(0.5 * beam.thickness.at(arc));
                let (cell, node) = (cell as u16, nodes.end as u16);
                push(
                    model,
                    Sample { cell, node, weights: [T::ZERO; 3], rigid: T::of(part), arc: T::of(arc), half_thickness },
                )?;
            }
        }
        from = to + rigid;
    }
    (model.per_element, model.fineness) = (per_element, 1);
    let wedge = beam.length() - ends[0];
    if design.rigid_above.is_some() && wedge > 1e-9 {
        // The wedge is sampled about as densely as the elements below it.
        let h = (ends[0] - start) / f64::from(counts.at(cells - 1));
        let pieces = libm::ceil(wedge / h) as usize * per_element;
        let last = model.topology.members.as_ref().at(cells - 1);
        for k in 1..=pieces {
            let part = k as f64 / pieces as f64;
            let arc = ends[0] + part * wedge;
            push(
                model,
                Sample {
                    cell: (cells - 1) as u16,
                    node: last.first + last.interior + 2,
                    weights: [T::ZERO; 3],
                    rigid: T::of(part),
                    arc: T::of(arc),
                    half_thickness: T::of(0.5 * beam.thickness.at(arc)),
                },
            )?;
        }
    }
    Ok(())
}
