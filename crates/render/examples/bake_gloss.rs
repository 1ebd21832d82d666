//! Writes the tables of `bsdf/gloss.rs` and `bsdf/sheen.rs`: what layers of a principled material
//! reflect and lose.
//!
//! ```sh
//! cargo run --release -p rutilant --example bake_gloss -- crates/render/src/bsdf/gloss.bin
//! ```
//!
//! Everything is computed in double precision and apart from the renderer's own code: facets are
//! taken as often as they are seen (Dupuy and Benyoub 2023), and what each sends on is what
//! Smith's masking leaves of it. The same bytes come out on every machine.

mod tables;

use std::f64::consts::PI;
use std::process::ExitCode;
use tables::{part, write};

/// In the order of the file: indices, roughnesses and angles of what Fresnel's equations add to
/// the reflection at normal incidence; then the means over angles.
const GLOSS: [usize; 3] = [16, 24, 41];
/// Roughnesses, anisotropies, directions around the normal and angles of what is lost by metal
/// that is rougher one way than the other; then the means over angles.
const STRETCHED: [usize; 4] = [12, 11, 6, 28];
/// Roughnesses and angles of sheen.
const SHEEN: [usize; 2] = [16, 32];

/// The least index of refraction, and the largest.
const INDICES: [f64; 2] = [1.04, 10.0];

/// The least roughness of sheen.
const LEAST_SHEEN: f64 = 0.3;

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: bake_gloss FILE");
        return ExitCode::from(2);
    };
    let mut bytes = Vec::new();
    let mut put = |part: f64| {
        let fraction = (part.clamp(0.0, 1.0) * f64::from(u16::MAX)).round() as u16;
        bytes.extend(fraction.to_le_bytes());
    };

    // The mean of what Fresnel's equations add, over what single scattering sends on.
    let [indices, roughnesses, angles] = GLOSS;
    let mut means = Vec::new();
    for n in 0..indices {
        let rise = Rise::new(index(n, indices));
        for r in 0..roughnesses {
            let alpha = alpha(part(r, roughnesses));
            for a in 0..angles {
                // Denser towards grazing.
                let mu = (part(a, angles) * part(a, angles)).max(1e-5);
                let all = sent_on([alpha; 2], [mu, 0.0], 64, |_| 1.0);
                put(sent_on([alpha; 2], [mu, 0.0], 64, |cos| rise.at(cos)) / all);
            }
            means.push(mean(|mu| sent_on([alpha; 2], [mu, 0.0], 48, |cos| rise.at(cos))));
        }
    }
    means.into_iter().for_each(&mut put);

    // What is lost by facets that are steeper one way than the other.
    let [roughnesses, anisotropies, turns, angles] = STRETCHED;
    let mut means = Vec::new();
    for r in 0..roughnesses {
        for s in 0..anisotropies {
            let across = alpha(part(r, roughnesses));
            let strength = part(s, anisotropies);
            let along = across + (1.0 - across) * strength * strength;
            // Steps are even in the steepness that is seen.
            let turn = |t: f64| {
                let seen = across + (along - across) * t;
                let cos2 = (seen * seen - across * across) / (along * along - across * across);
                if along > across { libm::acos(cos2.clamp(0.0, 1.0).sqrt()) } else { 0.0 }
            };
            for t in 0..turns {
                let seen = across + (along - across) * part(t, turns);
                let half_way = seen / (1.0 + 2.0 * seen * seen);
                for a in 0..angles {
                    let ratio = part(a, angles) / (1.0 + half_way);
                    let mu = (half_way * ratio / (1.0 - ratio)).clamp(1e-7 * seen, 1.0);
                    let around = turn(part(t, turns));
                    put(1.0 - sent_on([along, across], [mu, around], 96, |_| 1.0));
                }
            }
            let steps = 12;
            let over_turns = (0..steps).map(|i| {
                let around = 0.5 * PI * (f64::from(i) + 0.5) / f64::from(steps);
                mean(|mu| 1.0 - sent_on([along, across], [mu, around], 48, |_| 1.0))
            });
            let mean = over_turns.sum::<f64>() / f64::from(steps);
            means.push(mean / usual((0.5 * (along * along + across * across)).sqrt()));
        }
    }
    means.into_iter().for_each(&mut put);

    // What sheen sends back.
    let [roughnesses, angles] = SHEEN;
    for r in 0..roughnesses {
        let roughness = LEAST_SHEEN + (1.0 - LEAST_SHEEN) * part(r, roughnesses);
        for a in 0..angles {
            let step = part(a, angles);
            put(sheen(roughness * roughness, (step * step).max(1e-4)));
        }
    }
    write(&path, &bytes)
}

/// α of a roughness; that of roughness 0 is a limit.
fn alpha(roughness: f64) -> f64 {
    roughness.max(0.01) * roughness.max(0.01)
}

/// About what facets lose in the mean. Means are stored in parts of it: they change little.
fn usual(alpha: f64) -> f64 {
    alpha * alpha * (1.0 - 2.0 * libm::log(alpha))
}

/// Indices are stepped evenly in the logarithm of index - 1.
fn index(i: usize, n: usize) -> f64 {
    let [least, most] = INDICES.map(|index| libm::log(index - 1.0));
    1.0 + libm::exp(least + (most - least) * part(i, n))
}

/// The mean over the cosine-weighted hemisphere, in steps that are denser towards grazing.
fn mean(of: impl Fn(f64) -> f64) -> f64 {
    let steps = 64;
    let parts = (0..steps).map(|i| {
        let x = (f64::from(i) + 0.5) / f64::from(steps);
        // μ = x², so 2 μ dμ = 4 x³ dx.
        4.0 * x * x * x * of(x * x) / f64::from(steps)
    });
    parts.sum()
}

/// What facets send on of the light that leaves at a cosine and an angle around the normal, each
/// weighed by what it reflects at its own cosine; so many facets times so many.
fn sent_on(
    [along, across]: [f64; 2],
    [mu, around]: [f64; 2],
    facets: usize,
    reflects: impl Fn(f64) -> f64,
) -> f64 {
    let length = |v: [f64; 3]| {
        (along * along * v[0] * v[0] + across * across * v[1] * v[1] + v[2] * v[2]).sqrt()
    };
    let (sin_around, cos_around) = libm::sincos(around);
    let sin = (1.0 - mu * mu).sqrt();
    let wo = [sin * cos_around, sin * sin_around, mu];
    let length_o = length(wo);
    let from = [along * wo[0] / length_o, across * wo[1] / length_o, mu / length_o];
    let mut sum = 0.0;
    for (m, weight) in seen_facets([along, across], from, facets) {
        let cos = wo[0] * m[0] + wo[1] * m[1] + wo[2] * m[2];
        let wi = [0, 1, 2].map(|k| 2.0 * cos * m[k] - wo[k]);
        if wi[2] > 0.0 {
            // G2 / G1, heights correlated.
            let hidden = mu * length(wi) + wi[2] * length_o;
            sum += weight * reflects(cos.clamp(0.0, 1.0)) * wi[2] * (mu + length_o) / hidden;
        }
    }
    sum / (facets * facets) as f64
}

/// The normals of facets as often as they are seen from a direction that is squeezed already, with
/// their weights: steep ones, of which much depends, are more and weigh less.
fn seen_facets(
    [along, across]: [f64; 2],
    from: [f64; 3],
    facets: usize,
) -> impl Iterator<Item = ([f64; 3], f64)> {
    (0..facets * facets).map(move |i| {
        let turn = 2.0 * PI * ((i / facets) as f64 + 0.5) / facets as f64;
        let left = 1.0 - ((i % facets) as f64 + 0.5) / facets as f64;
        let z = left * left * left * (1.0 + from[2]) - from[2];
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (s, c) = libm::sincos(turn);
        let m = [along * (r * c + from[0]), across * (r * s + from[1]), z + from[2]];
        let length = (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]).sqrt();
        (m.map(|x| x / length), 3.0 * left * left)
    })
}

/// How Fresnel's equations rise, from 0 at normal incidence to 1 at grazing.
struct Rise {
    eta: f64,
    normal: f64,
}

impl Rise {
    fn new(eta: f64) -> Self {
        Self { eta, normal: fresnel(1.0, eta).0 }
    }

    fn at(&self, cos: f64) -> f64 {
        (fresnel(cos, self.eta).0 - self.normal) / (1.0 - self.normal)
    }
}

/// The Fresnel equations: the part reflected, and the cosine beyond.
fn fresnel(cos: f64, eta: f64) -> (f64, f64) {
    let sin2_t = (1.0 - cos * cos) / (eta * eta);
    if sin2_t >= 1.0 {
        return (1.0, 0.0);
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular), cos_t)
}

/// What sheen sends back of the light that leaves at a cosine: Estevez and Kulla 2017, equations
/// 2 to 4, without their softening of the terminator.
fn sheen(alpha: f64, mu: f64) -> f64 {
    let softness = (1.0 - alpha) * (1.0 - alpha);
    let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|k| {
        let soft = [25.3245, 3.32435, 0.16801, -1.27393, -4.85967][k];
        let hard = [21.5473, 3.82987, 0.19823, -1.97760, -4.32054][k];
        softness * soft + (1.0 - softness) * hard
    });
    let curve = |x: f64| a / (1.0 + b * libm::pow(x, c)) + d * x + e;
    let lambda = |cos: f64| {
        libm::exp(if cos < 0.5 { curve(cos) } else { 2.0 * curve(0.5) - curve(1.0 - cos) })
    };
    let (steps, x) = (400, (1.0 - mu * mu).sqrt());
    let hidden_o = lambda(mu);
    let mut sum = 0.0;
    for i in 0..steps {
        // Denser towards grazing: z = t².
        let t = (f64::from(i) + 0.5) / f64::from(steps);
        let z = t * t;
        let (r, hidden) = ((1.0 - z * z).sqrt(), 1.0 + hidden_o + lambda(z));
        for k in 0..steps {
            let (s, co) = libm::sincos(PI * (f64::from(k) + 0.5) / f64::from(steps));
            let half = [x + r * co, r * s, mu + z];
            let length2 = half[0] * half[0] + half[1] * half[1] + half[2] * half[2];
            let sin2 = (half[0] * half[0] + half[1] * half[1]) / length2;
            let density = (2.0 + 1.0 / alpha) * libm::pow(sin2, 0.5 / alpha) / (2.0 * PI);
            sum += density / (hidden * 4.0 * mu) * 2.0 * t;
        }
    }
    sum * 2.0 * PI / f64::from(steps * steps)
}
