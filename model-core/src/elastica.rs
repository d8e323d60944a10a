//! A single rod as a cantilever under a transverse dead load, against the textbook elastica and for the schemes' orders.

use std::boxed::Box;
use std::vec::Vec;

use nalgebra::{DMatrix, DVector};

use crate::discretise::{Discretisation, Elements, Physics, Sampling, Scheme, Softness, discretise};
use crate::model::Model;
use crate::size::Paper;

/// Tip (w/L, u/L) and tip angle of the front beam of a finger without lamellae, alone, under P L²/EI = `load`, by dense
/// Newton on the discretised rod's own constants.
fn cantilever(scheme: Scheme, elements: u16, load: f64) -> [f64; 3] {
    let mut design = crate::design::ladder_80();
    crate::design::tests::set_heights(&mut design, 0);
    let how = Discretisation {
        scheme,
        elements: Elements::PerBeam { beam: elements, hinge: 1 },
        sampling: Sampling::Nodes,
        softness: Softness::Fixed(0.0),
        physics: Physics::Paper,
    };
    let mut model: Box<Model<f64, Paper>> = Box::new(Model::EMPTY);
    discretise(&design, &how, &mut model).expect("a valid design");
    let nodes = model.members()[0].nodes();
    let (length, stiffness) = (80.0, 49.5 * 20.0 * 8.0 / 12.0);
    let full = load * stiffness / (length * length);
    let n = nodes.len() - 1;
    let mut theta = vec![0.0; n + 1];
    for part in 1..=20 {
        let force = full * f64::from(part) / 20.0;
        for _ in 0..30 {
            let mut gradient = DVector::<f64>::zeros(n);
            let mut hessian = DMatrix::<f64>::zeros(n, n);
            for i in 0..n {
                for (ahead, &k) in model.coupling[nodes.start + i].iter().enumerate() {
                    let j = i + ahead + 1;
                    if j > n || k == 0.0 {
                        continue;
                    }
                    let pull = -k * (theta[j] - theta[i]);
                    gradient[j - 1] += pull;
                    hessian[(j - 1, j - 1)] -= k;
                    if i > 0 {
                        gradient[i - 1] -= pull;
                        hessian[(i - 1, i - 1)] -= k;
                        hessian[(i - 1, j - 1)] += k;
                        hessian[(j - 1, i - 1)] += k;
                    }
                }
            }
            // The load acts along −x on a beam along y: potential +P x, x = Σ l cos(90° + θ) = −Σ l sin θ.
            for i in 1..=n {
                let weight = model.weight[nodes.start + i];
                gradient[i - 1] -= force * weight * libm::cos(theta[i]);
                hessian[(i - 1, i - 1)] += force * weight * libm::sin(theta[i]);
            }
            let step = hessian.lu().solve(&gradient).expect("a stable rod");
            for i in 1..=n {
                theta[i] -= step[i - 1];
            }
            if step.amax() < 1e-14 {
                break;
            }
        }
    }
    let sum = |f: &dyn Fn(f64) -> f64| -> f64 { (0..=n).map(|i| model.weight[nodes.start + i] * f(theta[i])).sum() };
    [sum(&libm::sin) / length, 1.0 - sum(&libm::cos) / length, theta[n]]
}

fn textbook() -> Vec<[f64; 4]> {
    let text = include_str!("../../tests/reference/elastica.csv");
    let row = |line: &str| {
        let mut numbers = line.split(',').map(|x| x.parse().expect("a number"));
        [0; 4].map(|_| numbers.next().expect("four columns"))
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn a_fine_rod_is_the_elastica() {
    let mut worst = 0.0_f64;
    for [load, w, u, angle] in textbook() {
        let found = cantilever(Scheme::Simpson, 60, load);
        for (found, expected) in found.into_iter().zip([w, u, angle]) {
            worst = worst.max((found - expected).abs());
            assert!((found - expected).abs() < 1.5e-6, "load {load}: {found} against {expected}");
        }
    }
    std::println!("a fine rod: worst error {worst:.1e}");
}

#[test]
fn the_schemes_converge_at_their_orders() {
    for load in [1.0, 5.0] {
        let limit = cantilever(Scheme::Simpson, 80, load);
        for (scheme, coarse, range) in
            [(Scheme::Paper, 40, 0.95..1.05), (Scheme::Trapezoid, 40, 1.95..2.05), (Scheme::Simpson, 6, 3.5..4.2)]
        {
            let error = [coarse, 2 * coarse].map(|elements| {
                let tip = cantilever(scheme, elements, load);
                (tip[0] - limit[0]).hypot(tip[1] - limit[1])
            });
            let order = (error[0] / error[1]).log2();
            std::println!("{scheme:?} load {load}: errors {error:?}, order {order:.3}");
            assert!(range.contains(&order), "{scheme:?} at load {load}: order {order}");
        }
    }
}
