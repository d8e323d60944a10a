//! The CalculiX input deck: mesh, material, contact, and one step per place of the motion, in increments of half a degree
//! (or half a millimetre). CalculiX extrapolates from increment to increment, not from step to step: fewer iterations.
//!
//! What was learned by measuring: `CPS8R` with a thickness behaves nearly as plane strain, so plane stress is made from
//! `CPE8R` with E′ = E(1+2ν)/(1+ν)² and ν′ = ν/(1+ν). Contact is surface to surface with a linear penalty; its projection is
//! frozen within an increment, so the object holds still for two increments before results are read. Friction is its own `*FRICTION`.

use std::collections::BTreeMap;
use std::fmt::Write;

use model_core::design::{Design, PlaneStrain};
use model_core::discretise::{Plate, plate_factor};

use super::mesh::{Mesh, Part, Side};
use super::plan::Plan;
use super::region::{Faces, is_layered, minus};

/// Contact penalty, multiples of Young's modulus per mm; with friction that of a point that sticks as well.
const PENALTY: f64 = 2.0;
/// Stiffness of a pinned lamella's rigid link, multiples of Young's modulus times width: a hundred times that of as long a
/// piece of a beam, and the elements beside its pins give more.
const LINK: f64 = 100.0;

/// The deck of a design pressed on an object as a plan has it.
pub fn deck(title: &str, design: &Design, plan: &Plan) -> String {
    let mut text = String::with_capacity(200 * plan.mesh.nodes.len());
    // Writing to a string cannot fail.
    let _ = write(&mut text, title, design, plan);
    text
}

fn write(out: &mut String, title: &str, design: &Design, plan: &Plan) -> std::fmt::Result {
    let Plan { mesh, surface, path, turns, pivot, stops, friction } = plan;
    writeln!(out, "*HEADING\n{}", heading(title))?;
    let ring = surface.nodes();
    writeln!(out, "*NODE,NSET=NALL")?;
    for (i, [x, y]) in mesh.nodes.iter().chain(&ring).enumerate() {
        writeln!(out, "{},{x:.9},{y:.9},0.", i + 1)?;
    }
    let width = design.width.at(0.0);
    let mut groups: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for element in 0..mesh.elements.len() {
        groups.entry((stiffness(design, mesh, element) * 1e4).round() as u64).or_default().push(element);
    }
    for (group, (_, members)) in groups.iter().enumerate() {
        writeln!(out, "*ELEMENT,TYPE=CPE8R,ELSET=E{group}")?;
        for &element in members {
            write!(out, "{}", element + 1)?;
            for node in mesh.elements[element] {
                write!(out, ",{}", node + 1)?;
            }
            writeln!(out)?;
        }
    }
    let (first_node, first_element) = (mesh.nodes.len() + 1, mesh.elements.len() + 1);
    let arcs = surface.elements();
    writeln!(out, "*ELEMENT,TYPE=CPE8R,ELSET=ERING")?;
    for i in 0..arcs {
        // Per element five nodes: outer corner, inner corner, middle of the radial side, outer and inner middle.
        let [outer, inner, radial, outer_middle, inner_middle] = [0, 1, 2, 3, 4].map(|k| first_node + 5 * i + k);
        writeln!(
            out,
            "{},{outer},{},{},{inner},{outer_middle},{},{inner_middle},{radial}",
            first_element + i,
            outer + 5,
            inner + 5,
            radial + 5
        )?;
    }
    for (link, ends) in mesh.links.iter().enumerate() {
        let number = first_element + arcs + link;
        writeln!(out, "*ELEMENT,TYPE=SPRINGA,ELSET=ELINKS\n{number},{},{}", ends[0] + 1, ends[1] + 1)?;
    }
    set(out, "*NSET,NSET=NCLAMP", mesh.clamped.iter().map(|n| n + 1))?;
    set(out, "*NSET,NSET=NRING", first_node..first_node + ring.len())?;
    set(out, "*NSET,NSET=NLINES", lines(mesh).map(|n| n + 1))?;

    let youngs_modulus = design.material.youngs_modulus;
    let nu = design.material.poissons_ratio;
    let plane_strain = design.plane_strain == PlaneStrain::Strain;
    for (group, (&key, _)) in groups.iter().enumerate() {
        let e = youngs_modulus * key as f64 * 1e-4;
        let (e, nu) = if plane_strain { (e, nu) } else { (e * (1.0 + 2.0 * nu) / (1.0 + nu).powi(2), nu / (1.0 + nu)) };
        writeln!(out, "*MATERIAL,NAME=M{group}\n*ELASTIC\n{e:.9},{nu:.9}")?;
        writeln!(out, "*SOLID SECTION,ELSET=E{group},MATERIAL=M{group}\n{width}")?;
    }
    writeln!(out, "*SOLID SECTION,ELSET=ERING,MATERIAL=M0\n{width}")?;
    if !mesh.links.is_empty() {
        writeln!(out, "*SPRING,ELSET=ELINKS\n\n{:.6}", LINK * youngs_modulus * width)?;
    }

    write_surface(out, "SFINGER", &mesh.contact_face)?;
    writeln!(out, "*SURFACE,NAME=SRING,TYPE=ELEMENT")?;
    for i in 0..arcs {
        writeln!(out, "{},S1", first_element + i)?;
    }
    writeln!(out, "*SURFACE INTERACTION,NAME=TOUCH\n*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR")?;
    writeln!(out, "{:.6}", PENALTY * youngs_modulus)?;
    if *friction != 0.0 {
        writeln!(out, "*FRICTION\n{friction},{:.6}", PENALTY * youngs_modulus)?;
    }
    writeln!(out, "*CONTACT PAIR,INTERACTION=TOUCH,TYPE=SURFACE TO SURFACE\nSFINGER,SRING")?;
    if !mesh.rib_ends.is_empty() {
        write_surface(out, "SENDS", &mesh.rib_ends)?;
        write_surface(out, "SWALL", &mesh.wall)?;
        writeln!(out, "*SURFACE INTERACTION,NAME=GAP\n*SURFACE BEHAVIOR,PRESSURE-OVERCLOSURE=LINEAR")?;
        writeln!(out, "{:.6}", PENALTY * youngs_modulus)?;
        writeln!(out, "*CONTACT PAIR,INTERACTION=GAP,TYPE=SURFACE TO SURFACE\nSENDS,SWALL")?;
    }
    writeln!(out, "*BOUNDARY\nNCLAMP,1,2")?;
    // An object that turns moves every node of its own; one that does not (or is round) moves as a whole.
    let turning = turns.iter().any(|&turn| turn != 0.0);
    let amplitude = |out: &mut String, name: &str, moved: &dyn Fn(usize) -> f64| -> std::fmt::Result {
        writeln!(out, "*AMPLITUDE,NAME={name},TIME=TOTAL TIME\n0.,0.")?;
        (0..path.len()).try_for_each(|i| writeln!(out, "{}.,{:.9}", i + 1, moved(i)))
    };
    if turning {
        for (k, &node) in ring.iter().enumerate() {
            let [x, y] = minus(node, *pivot);
            for (axis, name) in ["AX", "AY"].into_iter().enumerate() {
                amplitude(out, &format!("{name}{k}"), &|i| {
                    let (sin, cos) = turns[i].sin_cos();
                    path[i][axis] + [(cos - 1.0) * x - sin * y, sin * x + (cos - 1.0) * y][axis]
                })?;
            }
        }
    } else {
        amplitude(out, "AX", &|i| path[i][0])?;
        amplitude(out, "AY", &|i| path[i][1])?;
    }

    for (begin, end) in [0].into_iter().chain(stops.iter().copied()).zip(stops.iter().copied()) {
        writeln!(out, "*STEP,NLGEOM,INC=1000\n*STATIC\n1.,{}.,1e-4,1.", end - begin)?;
        if turning {
            for k in 0..ring.len() {
                let node = first_node + k;
                writeln!(out, "*BOUNDARY,AMPLITUDE=AX{k}\n{node},1,1,1.\n*BOUNDARY,AMPLITUDE=AY{k}\n{node},2,2,1.")?;
            }
        } else {
            writeln!(out, "*BOUNDARY,AMPLITUDE=AX\nNRING,1,1,1.\n*BOUNDARY,AMPLITUDE=AY\nNRING,2,2,1.")?;
        }
        writeln!(out, "*NODE PRINT,NSET=NLINES\nU\n*NODE PRINT,NSET=NRING,TOTALS=ONLY\nRF")?;
        // The whole mesh, at the end of the step alone.
        writeln!(out, "*NODE FILE,OUTPUT=2D,FREQUENCY=1000000\nU\n*END STEP")?;
    }
    Ok(())
}

/// Nodes whose displacements are printed: the front line, then the back line.
pub fn lines(mesh: &Mesh) -> impl Iterator<Item = usize> {
    mesh.front_line.iter().chain(&mesh.back_line).copied()
}

/// Most characters of a finger's name in the deck: CalculiX reads 132 of a line.
const HEADING: usize = 60;

/// A finger's name as a line of its own that CalculiX takes for nothing else: a card begins with an asterisk, a comma parts
/// fields, and letters beyond ASCII are several characters to it.
fn heading(title: &str) -> String {
    let harmless = |c: char| if c.is_ascii_alphanumeric() || "-_. ".contains(c) { c } else { '_' };
    format!("finger {}", title.chars().take(HEADING).map(harmless).collect::<String>().trim())
}

/// Factor on Young's modulus of an element: the beam's own, a width that differs from the base's, and its layer's. A free wide
/// strip bends as a plate but stretches as a bar does, and so it is in the model: the layers together have the plate's factor in
/// bending alone. In plane strain proper, which is the elements' own, a strip cannot narrow and is stiffer in stretch as well.
fn stiffness(design: &Design, mesh: &Mesh, element: usize) -> f64 {
    let middle = mesh.middle(element);
    let width = design.width.at(middle[1]);
    let beside = |side: usize| {
        let faces = [Faces::front, Faces::back][side](design);
        Plate { width, ..Plate::of_beam(design, side, faces.arc_beside(middle)) }
    };
    let ([bending, stretch], plate) = match mesh.parts[element] {
        Part::Front => (design.front.factors(), beside(0)),
        Part::Back => (design.back.factors(), beside(1)),
        // A neck's where there are some: of a rigid bar it matters little.
        Part::Lamella(lamella) => {
            let factors = design.lamellae.ribs().map_or([1.0; 2], |ribs| [ribs.bending_factor, ribs.stretch_factor]);
            (factors, Plate { width, ..Plate::of_rung(design, lamella) })
        }
    };
    let plate = match design.plane_strain {
        PlaneStrain::Auto => plate_factor(design, &plate),
        PlaneStrain::Stress | PlaneStrain::Strain => 1.0,
    };
    let layers = if is_layered(design) { mesh.layers[element].factor(plate * bending / stretch) } else { 1.0 };
    stretch * layers * width / design.width.at(0.0)
}

/// A surface of sides of the mesh's elements.
fn write_surface(out: &mut String, name: &str, sides: &[Side]) -> std::fmt::Result {
    writeln!(out, "*SURFACE,NAME={name},TYPE=ELEMENT")?;
    sides.iter().try_for_each(|side| writeln!(out, "{},S{}", side.element + 1, side.side + 1))
}

/// A set, sixteen numbers a line.
fn set(out: &mut String, heading: &str, members: impl Iterator<Item = usize>) -> std::fmt::Result {
    writeln!(out, "{heading}")?;
    let members: Vec<String> = members.map(|n| n.to_string()).collect();
    for line in members.chunks(16) {
        writeln!(out, "{},", line.join(","))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_never_a_card_nor_too_long_for_a_line() {
        for name in ["*STEP nonsense", "a\n*STEP", "\u{6307}, **", "", &"x".repeat(500)] {
            let line = heading(name);
            assert!(line.starts_with("finger") && line.len() <= 80 && line.is_ascii(), "{line:?}");
            assert!(!line.contains(['*', '\n', ',']), "{line:?}");
        }
        assert_eq!(heading("fea-80 (mine)"), "finger fea-80 _mine_");
    }
}
