//! An edge between the pixels: a blurred step is fitted to the light across it.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Most Gauss–Newton steps of a fit.
const STEPS: usize = 30;

/// A blurred step: light = low + height·Φ((u − at)/blur).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Where, in the unit of the profile's places.
    pub at: f64,
    /// Standard deviation of the blur, same unit.
    pub blur: f64,
    /// Light beyond the edge less light before it.
    pub height: f64,
    /// Root mean square of what the step does not explain.
    pub rms: f64,
}

/// Fits a step to light at increasing places; none if the light does not change, or not within the places.
pub fn fit(profile: &[(f64, f64)]) -> Option<Edge> {
    let (&(first, _), &(last, _)) = (profile.first()?, profile.last()?);
    let span = last - first;
    if profile.len() < 8 || span <= 0.0 {
        return None;
    }
    let fifth = profile.len() / 5;
    let mean = |part: &[(f64, f64)]| part.iter().map(|p| p.1).sum::<f64>() / part.len() as f64;
    let (low, high) = (mean(&profile[..fifth]), mean(&profile[profile.len() - fifth..]));
    if low == high {
        return None;
    }
    // Where a sharp step would leave as much light on either side.
    let share =
        profile.iter().map(|p| ((p.1 - low) / (high - low)).clamp(0.0, 1.0)).sum::<f64>() / profile.len() as f64;
    let narrowest = span / profile.len() as f64;
    let (mut at, mut blur) = (last - share * span, span / 10.0);
    let mut best = levels(profile, at, blur)?;
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        // Variable projection: the two levels follow from place and blur; here their derivatives are fitted along.
        let mut normal = [[0.0; 2]; 2];
        let mut right = [0.0; 2];
        let columns = derivatives(profile, at, blur, best.height);
        for (&(u, light), d) in profile.iter().zip(&columns) {
            let residual = light - best.low - best.height * normal_cdf((u - at) / blur);
            for i in 0..2 {
                right[i] += d[i] * residual;
                for j in 0..2 {
                    normal[i][j] += d[i] * d[j];
                }
            }
        }
        let [[a, b], [_, c]] = normal;
        let (a, c) = (a * (1.0 + damping), c * (1.0 + damping));
        let determinant = a * c - b * b;
        if determinant <= 0.0 || !determinant.is_finite() {
            break;
        }
        let step = [(c * right[0] - b * right[1]) / determinant, (a * right[1] - b * right[0]) / determinant];
        let next_at = at + step[0].clamp(-0.25 * span, 0.25 * span);
        let next_blur = (blur + step[1]).clamp(narrowest, 0.5 * span);
        match levels(profile, next_at, next_blur) {
            Some(next) if next.squares <= best.squares => {
                let small = (next_at - at).abs() + (next_blur - blur).abs() < 1e-6 * span;
                (at, blur, best) = (next_at, next_blur, next);
                damping = (0.2 * damping).max(1e-9);
                if small {
                    break;
                }
            }
            _ => {
                damping *= 10.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
    }
    let rms = (best.squares / profile.len() as f64).sqrt();
    // A step that is higher than the light ever changes is the beginning of something else.
    let (least, most) = profile.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, m), p| (l.min(p.1), m.max(p.1)));
    let seen = best.height.abs() < 1.3 * (most - least);
    (seen && first < at && at < last).then_some(Edge { at, blur, height: best.height, rms })
}

struct Levels {
    low: f64,
    height: f64,
    squares: f64,
}

/// The best low level and height for a place and blur.
fn levels(profile: &[(f64, f64)], at: f64, blur: f64) -> Option<Levels> {
    let count = profile.len() as f64;
    let (mut s, mut ss, mut y, mut sy) = (0.0, 0.0, 0.0, 0.0);
    for &(u, light) in profile {
        let step = normal_cdf((u - at) / blur);
        s += step;
        ss += step * step;
        y += light;
        sy += step * light;
    }
    let determinant = count * ss - s * s;
    if determinant <= 1e-9 * count * count {
        return None;
    }
    let height = (count * sy - s * y) / determinant;
    let low = (y - height * s) / count;
    let square = |&(u, light): &(f64, f64)| (light - low - height * normal_cdf((u - at) / blur)).powi(2);
    Some(Levels { low, height, squares: profile.iter().map(square).sum() })
}

/// Derivatives of the step by place and blur, less what the levels explain of them.
fn derivatives(profile: &[(f64, f64)], at: f64, blur: f64, height: f64) -> Vec<[f64; 2]> {
    let raw: Vec<([f64; 2], f64)> = profile
        .iter()
        .map(|&(u, _)| {
            let x = (u - at) / blur;
            let density = (-0.5 * x * x).exp() / (2.0 * PI).sqrt();
            ([-height * density / blur, -height * density * x / blur], normal_cdf(x))
        })
        .collect();
    let count = raw.len() as f64;
    let (s, ss) = raw.iter().fold((0.0, 0.0), |(s, ss), (_, step)| (s + step, ss + step * step));
    let determinant = count * ss - s * s;
    let project = |column: usize| {
        let (y, sy) = raw.iter().fold((0.0, 0.0), |(y, sy), (d, step)| (y + d[column], sy + step * d[column]));
        let slope = (count * sy - s * y) / determinant;
        [(y - slope * s) / count, slope]
    };
    let [p, q] = [project(0), project(1)];
    raw.iter().map(|(d, step)| [d[0] - p[0] - p[1] * step, d[1] - q[0] - q[1] * step]).collect()
}

fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x * FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blurred_step_is_found_to_a_thousandth() {
        for (at, blur, height) in [(0.13, 0.15, 0.6), (-0.4, 0.05, -0.3), (0.3, 0.2, 0.02)] {
            let light = |u: f64| 0.2 + height * normal_cdf((u - at) / blur);
            let profile: Vec<_> = (0..37).map(|i| -0.9 + 0.05 * f64::from(i)).map(|u| (u, light(u))).collect();
            let edge = fit(&profile).unwrap();
            assert!((edge.at - at).abs() < 1e-3 && (edge.blur - blur).abs() < 1e-3, "{edge:?} {at} {blur}");
            assert!((edge.height - height).abs() < 1e-3 * height.abs() && edge.rms < 1e-3 * height.abs(), "{edge:?}");
        }
    }

    #[test]
    fn light_that_does_not_change_has_no_edge() {
        let flat: Vec<_> = (0..37).map(|i| (f64::from(i), 0.5)).collect();
        assert_eq!(fit(&flat), None);
        assert_eq!(fit(&flat[..3]), None);
        let slope: Vec<_> = flat.iter().map(|&(u, _)| (u, 0.01 * u)).collect();
        assert!(fit(&slope).is_none_or(|edge| edge.rms > 0.02 * edge.height.abs() || edge.blur > 7.0));
    }
}
