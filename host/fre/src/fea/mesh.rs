//! A mapped mesh of second-order quadrilaterals over the finger's region and the object's edge.
//!
//! Every part (beam, neck, bar, half of the tip wedge) is a patch of rows and columns; patches share the points of their
//! common edges, and points that coincide become one node. Sizes are graded towards the corners where necks begin.

use std::collections::HashMap;

use model_core::design::HingeKind;

use super::fillet::Fillet;
use super::grading::{CORE, Sizes, lerp, stations, through_thickness};
use super::region::{Faces, Joint, Point, Region, cross, minus};

/// Nodes closer than this are one, mm.
const SAME: f64 = 1e-6;

/// An eight-node quadrilateral: four corners counter-clockwise, then the middles of its sides.
pub type Element = [usize; 8];

/// A part of the finger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Part {
    /// Front beam with its half of the tip wedge.
    Front,
    /// Back beam with its half of the tip wedge.
    Back,
    /// Necks and bars of a lamella, from 0 at the base.
    Lamella(usize),
}

/// Where an element lies in the thickness of a part that bends as a plate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// The part has one stiffness throughout: it hardly stretches, and yields only near the necks and beams that it holds; or it is a
    /// junction, whose stresses change within a thickness and so find the finger as wide as bending does.
    Whole,
    /// In the middle layer.
    Core,
    /// In one of the two outer layers.
    Skin,
}

impl Layer {
    /// Factor on Young's modulus that makes all layers together bend `plate` times as stiff and stretch as before: with the
    /// core's share c, (1 − c)·skin + c·core = 1 and (1 − c³)·skin + c³·core = plate.
    pub fn factor(self, plate: f64) -> f64 {
        let c = CORE;
        let skin = (plate - c * c) / (1.0 - c * c);
        match self {
            Self::Whole => plate,
            Self::Skin => skin,
            Self::Core => (1.0 - (1.0 - c) * skin) / c,
        }
    }

    /// That of an element, counted across the thickness.
    fn across(index: usize, count: usize, refinement: usize) -> Self {
        if (refinement..count - refinement).contains(&index) { Self::Core } else { Self::Skin }
    }
}

/// A side of an element, from 0: side i joins corners i and i + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    /// Index of the element.
    pub element: usize,
    /// Which of its sides.
    pub side: usize,
}

/// The mesh of a finger, finger frame, mm.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Positions.
    pub nodes: Vec<Point>,
    /// Elements.
    pub elements: Vec<Element>,
    /// The part that each element belongs to.
    pub parts: Vec<Part>,
    /// The layer that each element lies in.
    pub layers: Vec<Layer>,
    /// Sides that may touch: the front beam's outer face, base to tip, then the tip's end face, front to back.
    pub contact_face: Vec<Side>,
    /// Free ends of ribs.
    pub rib_ends: Vec<Side>,
    /// The back beam's inner face, which they may touch.
    pub wall: Vec<Side>,
    /// Clamped nodes.
    pub clamped: Vec<usize>,
    /// Front beam's centreline, base to tip (the tip's corner where the centreline ends).
    pub front_line: Vec<usize>,
    /// Back beam's centreline up to where the beams merge.
    pub back_line: Vec<usize>,
    /// Rigid links of pinned lamellae between the beams' centrelines (front, back), base to tip.
    pub links: Vec<[usize; 2]>,
    places: HashMap<[i64; 2], usize>,
}

/// Elements through the thickness of a beam at refinement 1.
const THROUGH_BEAM: usize = 2;
/// The same of a beam in layers: two elements in its core, one in each skin.
const THROUGH_LAYERS: usize = 4;
/// Elements through the thickness of a neck at refinement 1.
const THROUGH_NECK: usize = 3;
/// How far a junction reaches into what leaves it, over the smaller of the thicknesses that meet.
const JUNCTION: f64 = 0.5;
/// Part of the arc of a fillet at which the rib begins and the beam ends.
const HALVED: f64 = 0.5;
/// The same on a held beam, which has no elements: the rib begins so near the face that only a sliver of its foot is left out.
const ON_HELD: f64 = 0.15;

impl Mesh {
    /// Sides that belong to one element only, in no order: corner, middle, corner.
    pub fn outer_edges(&self) -> Vec<[usize; 3]> {
        let sides = |element: &Element| {
            let e = *element;
            [0, 1, 2, 3].map(|side| [e[side], e[4 + side], e[(side + 1) % 4]])
        };
        let mut times: HashMap<usize, usize> = HashMap::new();
        for [_, middle, _] in self.elements.iter().flat_map(sides) {
            *times.entry(middle).or_default() += 1;
        }
        self.elements.iter().flat_map(sides).filter(|[_, middle, _]| times[middle] == 1).collect()
    }

    /// Meshes a finger; `refinement` divides every element into as many parts in both directions. In layers, what bends can be
    /// given another stiffness in bending than in stretch.
    pub fn finger(region: &Region<'_>, thickness: f64, layered: bool, refinement: usize) -> Self {
        let mut mesh = Self::default();
        let through = refinement * if layered { THROUGH_LAYERS } else { THROUGH_BEAM };
        let across = through_thickness(through / refinement, layered, refinement);
        let neck = through_thickness(THROUGH_NECK, layered, refinement);
        let mut end_face = Vec::new();
        let fine = region.joints.iter().map(|j| 2.0 * j.neck).fold(thickness, f64::min) / THROUGH_NECK as f64;
        let beam_size = (0.5 * thickness).max(region.front.length() / 120.0);
        let sizes = |largest: f64| Sizes { fine, largest: largest.max(fine), refinement };

        let tip = sizes(beam_size).fractions(length(region.notch, region.top[1]), [true, false]);
        for front in [true, false] {
            let (faces, merge) = if front { (region.front, region.merge[0]) } else { (region.back, region.merge[1]) };
            let free = region.joints.iter().filter(|joint| front || !joint.held);
            let beam = usize::from(!front);
            let joints: Vec<Seat<'_>> = free.map(|joint| Seat::of(joint, &faces, beam)).collect();
            let edges: Vec<[[f64; 2]; 2]> = joints.iter().map(|seat| [seat.edges, seat.extent]).collect();
            // What is held is no part of the mesh.
            let held = region.joints.iter().filter(|joint| !front && joint.held);
            let held = held.map(|joint| joint.extent(&faces, beam)[1]);
            let clamp = held.fold(faces.clamp(), f64::max);
            let arcs = stations(clamp, &edges, merge, &sizes(beam_size), &neck);
            // The wedge: from the notch to the middle of the tip on one side, along the outer face on the other. Where it begins below the
            // notch, the beam goes on in it, and something fills what is between the beams.
            let end = region.ends[if front { 0 } else { 1 }];
            let outer_corner = region.top[if front { 0 } else { 2 }];
            let (inner, thickness) = (faces.inner(merge), faces.thickness(merge));
            let room = length(inner, region.notch);
            let inner_end = mix(outer_corner, region.top[1], thickness / (thickness + room));
            let middle = |t: f64| mix(region.notch, region.top[1], t);
            let beside = |t: f64| if room > SAME { mix(inner, inner_end, t) } else { middle(t) };
            let wedge = |&t: &f64| [faces.outer(lerp([merge, end], t)), beside(t)];
            let row = |[a, b]: [Point; 2]| across.iter().map(|&t| mix(a, b, t)).collect::<Vec<_>>();
            let section = |&arc: &f64| match joints.iter().find_map(|seat| seat.rounded(arc)) {
                // Thicker by the fillet, on the inner side of the centreline only.
                Some(inner) => {
                    let (outer, centre) = (faces.outer(arc), faces.centre(arc));
                    let side = |&t: &f64| match t <= 0.5 {
                        true => mix(outer, centre, 2.0 * t),
                        false => mix(centre, inner, 2.0 * t - 1.0),
                    };
                    across.iter().map(side).collect()
                }
                None => row([faces.outer(arc), faces.inner(arc)]),
            };
            let mut rows: Vec<Vec<Point>> = arcs.iter().map(section).collect();
            rows.extend(tip.iter().skip(1).map(wedge).map(row));
            let part = if front { Part::Front } else { Part::Back };
            // The wedge hardly bends.
            let layer = |r: usize, c: usize| match arcs.get(r) {
                Some(&arc) if layered && !joints.iter().any(|seat| seat.is_near(arc, faces.thickness(arc))) => {
                    Layer::across(c / 2, through, refinement)
                }
                _ => Layer::Whole,
            };
            let ids = mesh.add_patch(&rows, part, layer);
            mesh.clamped.extend(ids[0].iter().flatten());
            let mut end: Vec<usize> = ids.last().into_iter().flatten().flatten().copied().collect();
            if room > SAME {
                let columns = sizes(beam_size).fractions(room, [true, false]);
                let fill = |&t: &f64| columns.iter().map(|&at| mix(beside(t), middle(t), at)).collect::<Vec<_>>();
                let ids = mesh.add_patch(&tip.iter().map(fill).collect::<Vec<_>>(), part, |_, _| Layer::Whole);
                end.extend(ids.last().into_iter().flatten().flatten().skip(1));
            }
            let corner = end.last().copied();
            if front {
                let outer = mesh.sides(ids.iter().filter_map(|row| row[0]));
                mesh.contact_face.extend(outer);
                end_face.extend(end);
                // In the wedge the columns run apart; it hardly bends, so its line is straight to the tip.
                mesh.front_line = ids[..arcs.len()].iter().filter_map(|row| row[through]).collect();
                mesh.front_line.extend(corner);
            } else {
                mesh.back_line = ids[..arcs.len()].iter().filter_map(|row| row[through]).collect();
                if region.joints.iter().any(|joint| joint.gap.is_some()) {
                    mesh.wall = mesh.sides(ids[..arcs.len()].iter().filter_map(|row| *row.last()?));
                }
                // Both halves of the end face share the node on the front centreline, where the second one begins.
                end_face.extend(end.into_iter().rev().skip(1));
            }
        }
        let end_face = mesh.sides(end_face.into_iter());
        mesh.contact_face.extend(end_face);
        for k in 0..region.joints.len() {
            mesh.add_lamella(region, k, &sizes, layered, refinement);
        }
        mesh.clamped.sort_unstable();
        mesh.clamped.dedup();
        mesh
    }

    fn add_lamella(
        &mut self,
        region: &Region<'_>,
        k: usize,
        sizes: &impl Fn(f64) -> Sizes,
        layered: bool,
        refinement: usize,
    ) {
        let joint = &region.joints[k];
        if region.kind == HingeKind::Pinned {
            let middle = |faces: &Faces<'_>, [low, high]: [f64; 2]| faces.centre(0.5 * (low + high));
            let ends = [middle(&region.front, joint.front), middle(&region.back, joint.back)];
            let link = ends.map(|end| self.node(end));
            if joint.held {
                self.clamped.push(link[1]);
            }
            self.links.push(link);
            return;
        }
        let neck = through_thickness(THROUGH_NECK, layered, refinement);
        let steps = neck.len() - 1;
        let at = |along: f64, up: f64| [0, 1].map(|i| joint.start[i] + along * joint.along[i] + up * joint.up[i]);
        let front: Vec<Point> = neck.iter().map(|&t| region.front.inner(lerp(joint.front, t))).collect();
        let short = joint.gap.unwrap_or(0.0);
        let end = |t: f64| region.back.inner(lerp(joint.back, t));
        let back: Vec<Point> = neck.iter().map(|&t| [0, 1].map(|i| end(t)[i] - short * joint.along[i])).collect();
        let middle: Vec<f64> = neck.iter().map(|&t| lerp([-joint.neck, joint.neck], t)).collect();
        if region.kind == HingeKind::Welded
            && let Some(fillets) = joint.fillets
        {
            self.add_filleted(k, joint, fillets, sizes, &neck, layered.then_some(refinement));
            return;
        }
        if region.kind == HingeKind::Welded {
            let columns = sizes(joint.bar).fractions(length(front[0], back[0]), [true, true]);
            self.add_band(&front, &back, &columns, k, layered.then_some(refinement));
            if joint.gap.is_some() {
                let end: Vec<usize> = back.iter().map(|&point| self.node(point)).collect();
                let sides = self.sides(end.into_iter());
                self.rib_ends.extend(sides);
            } else {
                self.hold(&back, joint.held);
            }
            return;
        }
        // Necks, between a beam's face and an end of the bar.
        let ends = [0.0, joint.length].map(|along| middle.iter().map(|&up| at(along, up)).collect::<Vec<_>>());
        for (face, end) in [(&front, &ends[0]), (&back, &ends[1])] {
            let columns = sizes(joint.neck).fractions(length(face[steps / 2], end[steps / 2]), [true, true]);
            self.add_band(face, end, &columns, k, layered.then_some(refinement));
        }
        self.hold(&back, joint.held);
        let mut ups = middle;
        let rest = joint.bar - joint.neck;
        if rest > 1e-3 {
            let outer = sizes(joint.bar).fractions(rest, [true, false]);
            let above: Vec<f64> = outer.iter().skip(1).map(|t| joint.neck + t * rest).collect();
            let below = above.iter().rev().map(|up| -up);
            ups = below.chain(ups).chain(above.iter().copied()).collect();
        }
        let columns = sizes(joint.bar).fractions(joint.length, [true, true]);
        let end = |along: f64| ups.iter().map(|&up| at(along, up)).collect::<Vec<_>>();
        // A bar between two necks hardly bends.
        self.add_band(&end(0.0), &end(joint.length), &columns, k, None);
    }

    /// A patch between two edges of equally many points, in layers along it if their refinement is given.
    fn add_band(&mut self, from: &[Point], to: &[Point], columns: &[f64], lamella: usize, layered: Option<usize>) {
        let rows: Vec<Vec<Point>> =
            from.iter().zip(to).map(|(&a, &b)| columns.iter().map(|&t| mix(a, b, t)).collect()).collect();
        let count = from.len() / 2;
        let edges = [[from[0], to[0]], [from[from.len() - 1], to[to.len() - 1]]].map(|[a, b]| length(a, b));
        let least = JUNCTION * length(from[0], from[from.len() - 1]).min(length(to[0], to[to.len() - 1]));
        let layer = |r: usize, c: usize| {
            let along = lerp(edges, r as f64 / (from.len() - 1) as f64);
            match layered {
                Some(refinement) if columns[c].min(1.0 - columns[c]) * along > least => {
                    Layer::across(r / 2, count, refinement)
                }
                _ => Layer::Whole,
            }
        };
        self.add_patch(&rows, Part::Lamella(lamella), layer);
    }

    /// A welded rib with its halves of the fillets, in layers between them.
    fn add_filleted(
        &mut self,
        k: usize,
        joint: &Joint,
        fillets: [[Fillet; 2]; 2],
        sizes: &impl Fn(f64) -> Sizes,
        neck: &[f64],
        layered: Option<usize>,
    ) {
        let begins = [HALVED, if joint.held { ON_HELD } else { HALVED }];
        let ends = fillets.map(|pair| pair.map(|fillet| fillet.at(1.0)));
        let straight = [0, 1].map(|edge| length(ends[0][edge], ends[1][edge]));
        let arc = |end: usize| 0.5 * (1.0 - begins[end]) * (fillets[end][0].length() + fillets[end][1].length());
        let lengths = [arc(0), 0.5 * (straight[0] + straight[1]), arc(1)];
        // Positions along: the part, and where in it.
        let mut columns = vec![(0, 0.0)];
        for (part, length) in lengths.into_iter().enumerate() {
            let fractions = sizes(joint.bar).fractions(length, [true, true]);
            columns.extend(fractions.into_iter().skip(1).map(|at| (part, at)));
        }
        let edge = |edge: usize, (part, at): (usize, f64)| match part {
            0 => fillets[0][edge].at(lerp([begins[0], 1.0], at)),
            1 => mix(ends[0][edge], ends[1][edge], at),
            _ => fillets[1][edge].at(lerp([1.0, begins[1]], at)),
        };
        let row = |&t: &f64| columns.iter().map(|&at| mix(edge(0, at), edge(1, at), t)).collect::<Vec<_>>();
        let rows: Vec<Vec<Point>> = neck.iter().map(row).collect();
        let least = JUNCTION * 2.0 * joint.bar;
        let layer = |r: usize, c: usize| {
            let (part, at) = columns[c];
            let along = lerp(straight, neck[r]);
            let reach = |end: usize| lerp(fillets[end].map(|fillet| fillet.reach), neck[r]);
            let from_corner = (reach(0) + at * along).min(reach(1) + (1.0 - at) * along);
            match layered {
                Some(refinement) if part == 1 && from_corner > least => {
                    Layer::across(r / 2, neck.len() / 2, refinement)
                }
                _ => Layer::Whole,
            }
        };
        self.add_patch(&rows, Part::Lamella(k), layer);
        let last: Vec<Point> = rows.iter().filter_map(|row| row.last().copied()).collect();
        self.hold(&last, joint.held);
    }

    /// Clamps the points of a lamella's end that lies on a held beam.
    fn hold(&mut self, end: &[Point], held: bool) {
        if held {
            let nodes: Vec<usize> = end.iter().map(|&point| self.node(point)).collect();
            self.clamped.extend(nodes);
        }
    }

    /// Adds a patch given at half steps (odd counts of rows and columns); returns its nodes, none in element centres.
    /// The layer names an element by the row and column of its centre.
    fn add_patch(
        &mut self,
        rows: &[Vec<Point>],
        part: Part,
        layer: impl Fn(usize, usize) -> Layer,
    ) -> Vec<Vec<Option<usize>>> {
        let ids: Vec<Vec<Option<usize>>> = rows
            .iter()
            .enumerate()
            .map(|(r, row)| {
                let node = |(c, &p): (usize, &Point)| (r % 2 == 0 || c % 2 == 0).then(|| self.node(p));
                row.iter().enumerate().map(node).collect()
            })
            .collect();
        for r in (1..rows.len()).step_by(2) {
            for c in (1..rows[r].len()).step_by(2) {
                let around = [(0, 0), (0, 2), (2, 2), (2, 0), (0, 1), (1, 2), (2, 1), (1, 0)];
                let mut element = [0; 8];
                for (slot, (dr, dc)) in element.iter_mut().zip(around) {
                    *slot = ids[r + dr - 1][c + dc - 1].unwrap_or(0);
                }
                let turned = area(&[0, 1, 2, 3].map(|i| self.nodes[element[i]])) < 0.0;
                if turned {
                    let e = element;
                    element = [e[0], e[3], e[2], e[1], e[7], e[6], e[5], e[4]];
                }
                self.elements.push(element);
                self.parts.push(part);
                self.layers.push(layer(r, c));
            }
        }
        ids
    }

    fn node(&mut self, p: Point) -> usize {
        // Twice the tolerance as cell size: equal points lie in the same or a neighbouring cell.
        let cell = p.map(|x| (x / (2.0 * SAME)).floor() as i64);
        for dx in -1..=1 {
            for dy in -1..=1 {
                if let Some(&id) = self.places.get(&[cell[0] + dx, cell[1] + dy])
                    && length(self.nodes[id], p) < SAME
                {
                    return id;
                }
            }
        }
        self.places.insert(cell, self.nodes.len());
        self.nodes.push(p);
        self.nodes.len() - 1
    }

    /// The sides along a line of nodes (corner, middle, corner, …).
    fn sides(&self, line: impl Iterator<Item = usize>) -> Vec<Side> {
        let middles: HashMap<usize, Side> = self
            .elements
            .iter()
            .enumerate()
            .flat_map(|(element, nodes)| (0..4).map(move |side| (nodes[4 + side], Side { element, side })))
            .collect();
        line.skip(1).step_by(2).filter_map(|middle| middles.get(&middle).copied()).collect()
    }

    /// Area of the elements (corners only), mm².
    pub fn area(&self) -> f64 {
        self.elements.iter().map(|e| area(&[0, 1, 2, 3].map(|i| self.nodes[e[i]]))).sum()
    }

    /// Middle of an element, mm.
    pub fn middle(&self, element: usize) -> Point {
        let e = &self.elements[element];
        [0, 1].map(|axis| 0.25 * e[..4].iter().map(|&n| self.nodes[n][axis]).sum::<f64>())
    }
}

/// Where a beam has a joint.
struct Seat<'j> {
    /// Arcs of its lower and upper edge.
    edges: [f64; 2],
    /// Arcs between which it and its fillets lie.
    extent: [f64; 2],
    /// The fillets below and above.
    fillets: Option<&'j [Fillet; 2]>,
}

impl<'j> Seat<'j> {
    fn of(joint: &'j Joint, faces: &Faces<'_>, beam: usize) -> Self {
        let edges = if beam == 0 { joint.front } else { joint.back };
        Self { edges, extent: joint.extent(faces, beam), fillets: joint.fillets.as_ref().map(|all| &all[beam]) }
    }

    /// The end of the section at an arc, if a fillet or the rib between two of them lies there.
    fn rounded(&self, arc: f64) -> Option<Point> {
        let fillets = self.fillets?;
        let ([low, high], [start, end]) = (self.edges, self.extent);
        let halves = |arc: f64, [from, to]: [f64; 2]| HALVED * (arc - from) / (to - from);
        if arc <= start || arc >= end {
            None
        } else if arc < low {
            Some(fillets[0].at(halves(arc, [start, low])))
        } else if arc > high {
            Some(fillets[1].at(halves(arc, [end, high])))
        } else {
            let middles = fillets.map(|fillet| fillet.at(HALVED));
            Some(mix(middles[0], middles[1], (arc - low) / (high - low)))
        }
    }

    /// That an arc of a beam of this thickness lies at the joint or near it.
    fn is_near(&self, arc: f64, thickness: f64) -> bool {
        let ([low, high], [start, end]) = (self.edges, self.extent);
        let near = JUNCTION * thickness.min(high - low);
        ((low - near).min(start)..=(high + near).max(end)).contains(&arc)
    }
}

fn mix(a: Point, b: Point, t: f64) -> Point {
    [lerp([a[0], b[0]], t), lerp([a[1], b[1]], t)]
}

fn length(a: Point, b: Point) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

/// Signed area of a quadrilateral, positive counter-clockwise.
fn area(corners: &[Point; 4]) -> f64 {
    0.5 * cross(minus(corners[2], corners[0]), minus(corners[3], corners[1]))
}
