//! Writes the table of `bsdf/energy.rs`: what rough surfaces lose by single scattering.
//!
//! ```sh
//! cargo run --release -p rutilant --example bake_energy -- crates/render/src/bsdf/energy.bin
//! ```
//!
//! Everything is computed in double precision and apart from the renderer's own code: facets are
//! taken as often as they are seen (Dupuy and Benyoub 2023), and what each sends on is what
//! Smith's masking leaves of it. Between entries never more is told than is lost, or else more would
//! be given back. The same bytes come out on every machine.

mod tables;

use std::f64::consts::PI;
use std::process::ExitCode;
use tables::{bounding, write};

/// Facets for an entry: so many turns times so many heights.
const FACETS: usize = 128;

/// In the order of the file: angles, roughnesses, and indices of refraction, if any.
const CONDUCTOR: [usize; 2] = [64, 32];
const DIELECTRIC: [usize; 3] = [49, 24, 30];

/// The part of the angles up to the critical one, where there is one.
const UP_TO_CRITICAL: f64 = 0.625;

/// The least index of refraction, and the largest.
const INDICES: [f64; 2] = [1.04, 10.0];

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: bake_energy FILE");
        return ExitCode::from(2);
    };
    let mut bytes = Vec::new();
    let mut put = |lost: f64| {
        let fraction = (lost.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16;
        bytes.extend(fraction.to_le_bytes());
    };
    let [angles, roughnesses] = CONDUCTOR;
    let metal = |[roughness, step]: [f64; 2]| entry(roughness, step, 1.0, |_| (1.0, None));
    bounding([roughnesses, angles], -1.0, metal).into_iter().for_each(&mut put);
    let [angles, roughnesses, indices] = DIELECTRIC;
    for inside in [false, true] {
        let glass = |[index, roughness, step]: [f64; 3]| {
            let [least, most] = INDICES.map(|index| libm::log(index - 1.0));
            let index = 1.0 + libm::exp(least + (most - least) * index);
            let eta = if inside { 1.0 / index } else { index };
            let critical = if inside { (1.0 - eta * eta).sqrt() } else { 1.0 };
            entry(roughness, step, critical, |cos| glass(cos, eta))
        };
        let lost = bounding([indices, roughnesses, angles], -1.0, glass);
        lost.into_iter().for_each(&mut put);
    }
    write(&path, &bytes)
}

/// What is lost at a roughness, and at a step between 0 and 1 of the angles.
///
/// Steps are even in μ (1 + β) / (μ + β) with β = α / (1 + 2 α²), up to the cosine of the
/// `critical` angle, if that is below 1, and then in μ. At roughness 0 stands the limit, where
/// only μ / α counts.
fn entry(
    roughness: f64,
    step: f64,
    critical: f64,
    facet: impl Fn(f64) -> (f64, Option<[f64; 2]>),
) -> f64 {
    let alpha = roughness.max(0.01) * roughness.max(0.01);
    let half_way = alpha / (1.0 + 2.0 * alpha * alpha);
    let up_to = if critical < 1.0 { UP_TO_CRITICAL } else { 1.0 };
    // μ / (μ + β), in parts of what it is at the critical angle.
    let bent = step / up_to;
    let mu = if roughness == 0.0 {
        if bent >= 1.0 {
            return 0.0;
        }
        alpha * bent / (1.0 - bent)
    } else if bent <= 1.0 {
        let ratio = bent * critical / (critical + half_way);
        half_way * ratio / (1.0 - ratio)
    } else {
        critical + (1.0 - critical) * (step - up_to) / (1.0 - up_to)
    };
    lost(alpha, mu.clamp(1e-7 * alpha, 1.0), facet)
}

/// 1 - E(μ) for facets that reflect a part, and, where they refract the rest, bend it:
/// `facet(cos)` gives the part, and 1 / η with the cosine beyond.
fn lost(alpha: f64, mu: f64, facet: impl Fn(f64) -> (f64, Option<[f64; 2]>)) -> f64 {
    let squeezed = |z: f64| (z * z + alpha * alpha * (1.0 - z * z).max(0.0)).sqrt();
    let (x, length_o) = ((1.0 - mu * mu).sqrt(), squeezed(mu));
    let from = [alpha * x / length_o, mu / length_o];
    let mut sent_on = 0.0;
    for i in 0..FACETS {
        // The two halves mirror each other.
        let turn = PI * (i as f64 + 0.5) / FACETS as f64;
        let (sin_turn, cos_turn) = libm::sincos(turn);
        for k in 0..FACETS {
            let u = (k as f64 + 0.5) / FACETS as f64;
            let z = (1.0 - u) * (1.0 + from[1]) - from[1];
            let r = (1.0 - z * z).max(0.0).sqrt();
            let m = [alpha * (r * cos_turn + from[0]), alpha * r * sin_turn, z + from[1]];
            let length = (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]).sqrt();
            let (mx, mz) = (m[0] / length, m[2] / length);
            let cos = (x * mx + mu * mz).clamp(0.0, 1.0);
            let (reflected, bent) = facet(cos);
            let up = 2.0 * cos * mz - mu;
            if up > 0.0 {
                // G2 / G1, heights correlated.
                let length_i = squeezed(up);
                sent_on += reflected * up * (mu + length_o) / (mu * length_i + up * length_o);
            }
            if let Some([inverse_eta, cos_t]) = bent {
                let down = mu * inverse_eta - (cos * inverse_eta - cos_t) * mz;
                if down > 0.0 {
                    // G1 of the far side.
                    sent_on += (1.0 - reflected) * 2.0 * down / (down + squeezed(down));
                }
            }
        }
    }
    1.0 - sent_on / (FACETS * FACETS) as f64
}

/// The Fresnel equations.
fn glass(cos: f64, eta: f64) -> (f64, Option<[f64; 2]>) {
    let sin2_t = (1.0 - cos * cos) / (eta * eta);
    if sin2_t >= 1.0 {
        return (1.0, None);
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular), Some([1.0 / eta, cos_t]))
}
