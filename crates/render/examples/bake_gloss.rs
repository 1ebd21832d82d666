//! Writes the tables of `bsdf/gloss.rs` and `bsdf/sheen.rs`: what layers of a principled material
//! reflect and lose.
//!
//! ```sh
//! cargo run --release -p rutilant --example bake_gloss -- crates/render/src/bsdf/gloss.bin
//! ```
//!
//! Everything is computed in double precision and apart from the renderer's own code: facets are
//! taken as often as they are seen (Dupuy and Benyoub 2023), and what each sends on is what
//! Smith's masking leaves of it. Between entries never less is told than is reflected, and never
//! more than is lost, or else light would be made. The same bytes come out on every machine.

mod tables;

use std::f64::consts::PI;
use std::process::ExitCode;
use tables::{bounding, grid, part, write};

/// In the order of the file: indices, roughnesses and angles of what Fresnel's equations add to
/// the reflection at normal incidence; then the means over angles.
const GLOSS: [usize; 3] = [16, 24, 41];
/// Roughnesses and angles of sheen.
const SHEEN: [usize; 2] = [16, 32];
/// Roughnesses and angles of the cosines under which facets are seen; then the means over angles.
const SEEN: [usize; 2] = [24, 32];
const SEEN_COSINES: usize = 17;
/// Roughnesses, anisotropies, directions around the normal and angles of the same for facets that
/// are steeper one way than the other, and of what they lose; then the means over directions.
const STRETCHED: [usize; 4] = [10, 9, 7, 18];
const STRETCHED_COSINES: usize = 9;

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
    let rise = bounding(GLOSS, 1.0, |[index, roughness, angle]| {
        let (rise, alpha) = (Rise::new(index_at(index)), alpha(roughness));
        // Denser towards grazing.
        let wo = [(angle * angle).max(1e-5), 0.0];
        let [sent_on, all] = sent_on([alpha; 2], wo, 64, |cos| [rise.at(cos), 1.0]);
        sent_on / all
    });
    rise.iter().copied().for_each(&mut put);
    for n in 0..indices {
        for r in 0..roughnesses {
            let alpha = alpha(part(r, roughnesses));
            let row = &rise[(n * roughnesses + r) * angles..][..angles];
            put(mean(|mu| {
                let [all] = sent_on([alpha; 2], [mu, 0.0], 48, |_| [1.0]);
                all * between(mu.sqrt(), angles, |a| row[a])
            }));
        }
    }

    // What sheen sends back.
    let [roughnesses, angles] = SHEEN;
    for r in 0..roughnesses {
        let roughness = LEAST_SHEEN + (1.0 - LEAST_SHEEN) * part(r, roughnesses);
        for a in 0..angles {
            let step = part(a, angles);
            put(sheen(roughness * roughness, (step * step).max(1e-4)));
        }
    }

    // How often facets are seen under which cosines, of what they send on, and how much more is to
    // be taken as seen at grazing, for what the numbers between entries leave out.
    let seen = |[roughness, angle]: [f64; 2]| {
        let (alpha, mu) = (alpha(roughness), (angle * angle).max(1e-5));
        seen_cosines::<{ SEEN_COSINES }>([alpha; 2], [mu, 0.0], 64)
    };
    let (entries, more) = seen_table(SEEN, seen);
    entries.iter().flatten().chain(&more).copied().for_each(&mut put);
    let [roughnesses, angles] = SEEN;
    for r in 0..roughnesses {
        let alpha = alpha(part(r, roughnesses));
        let start = r * angles;
        let over_angles = |of: &dyn Fn(usize) -> f64| {
            mean(|mu| {
                let [all] = sent_on([alpha; 2], [mu, 0.0], 48, |_| [1.0]);
                all * between(mu.sqrt(), angles, |a| of(start + a))
            })
        };
        let parts: [f64; SEEN_COSINES] = std::array::from_fn(|k| over_angles(&|i| entries[i][k]));
        parts.into_iter().for_each(&mut put);
        put(over_angles(&|i| more[i]));
    }

    // The same for facets that are steeper one way than the other, and what they lose: denser where
    // they are smooth, and where light comes across them.
    let stretched = |[roughness, strength, turn, angle]: [f64; 4]| {
        let (across, strength) = (alpha(roughness * roughness), strength * strength);
        let along = across + (1.0 - across) * strength * strength;
        ([along, across], [(angle * angle * angle).max(1e-6), libm::acos(turn * turn)])
    };
    let (entries, more) = seen_table(STRETCHED, |at| {
        let (alphas, wo) = stretched(at);
        seen_cosines::<{ STRETCHED_COSINES }>(alphas, wo, 64)
    });
    let lost = bounding(STRETCHED, -1.0, |at| {
        let (alphas, wo) = stretched(at);
        let [all] = sent_on(alphas, wo, 96, |_| [1.0]);
        1.0 - all
    });
    let lost: Vec<f64> = lost.into_iter().map(|lost| lost.max(0.0)).collect();
    entries.iter().flatten().chain(&more).copied().for_each(&mut put);
    // Small numbers count as well.
    lost.iter().for_each(|lost| put(lost.sqrt()));
    let [roughnesses, anisotropies, turns, angles] = STRETCHED;
    let mut means = Vec::new();
    for row in 0..roughnesses * anisotropies {
        let start = row * turns * angles;
        let over_directions = |of: &dyn Fn(usize) -> f64| {
            let steps = 24;
            let means = (0..steps).map(|i| {
                let turn = libm::cos(0.5 * PI * (f64::from(i) + 0.5) / f64::from(steps)).sqrt();
                mean(|mu| {
                    between(turn, turns, |t| {
                        let row = start + t * angles;
                        between(libm::cbrt(mu), angles, |a| of(row + a))
                    })
                })
            });
            means.sum::<f64>() / f64::from(steps)
        };
        let parts: [f64; STRETCHED_COSINES] =
            std::array::from_fn(|k| over_directions(&|i| (1.0 - lost[i]) * entries[i][k]));
        parts.into_iter().for_each(&mut put);
        put(over_directions(&|i| (1.0 - lost[i]) * more[i]));
        means.push(over_directions(&|i| lost[i]));
    }
    means.into_iter().for_each(|lost| put(lost.sqrt()));
    write(&path, &bytes)
}

/// α of a roughness; that of roughness 0 is a limit.
fn alpha(roughness: f64) -> f64 {
    roughness.max(0.01) * roughness.max(0.01)
}

/// Indices are stepped evenly in the logarithm of index - 1.
fn index_at(part: f64) -> f64 {
    let [least, most] = INDICES.map(|index| libm::log(index - 1.0));
    1.0 + libm::exp(least + (most - least) * part)
}

/// What lies between two of `n` even steps, at a part of the way over all of them.
fn between(part: f64, n: usize, of: impl Fn(usize) -> f64) -> f64 {
    let place = part.clamp(0.0, 1.0) * (n - 1) as f64;
    let first = (place as usize).min(n - 2);
    let (a, b) = (of(first), of(first + 1));
    a + (b - a) * (place - first as f64)
}

/// The cosines at which a reflection will be told, `K` of them, denser towards grazing.
fn cosine<const K: usize>(k: usize) -> f64 {
    part(k, K) * part(k, K)
}

/// How often facets are seen under `K` cosines, of all that they send on: what lies between two
/// cosines counts for both of them, the more the nearer it is.
fn seen_cosines<const K: usize>(alphas: [f64; 2], wo: [f64; 2], facets: usize) -> [f64; K] {
    let (mut parts, mut all) = ([0.0; K], 0.0);
    each_sent_on(alphas, wo, facets, |cos, sent_on| {
        let first = ((cos.sqrt() * (K - 1) as f64) as usize).min(K - 2);
        let along = (cos - cosine::<K>(first)) / (cosine::<K>(first + 1) - cosine::<K>(first));
        parts[first] += sent_on * (1.0 - along);
        parts[first + 1] += sent_on * along;
        all += sent_on;
    });
    parts.map(|part| part / all)
}

/// A table of [`seen_cosines`], and how much less straight lines between its entries may tell of
/// what rises towards grazing than there is.
fn seen_table<const N: usize, const K: usize>(
    sizes: [usize; N],
    seen: impl Fn([f64; N]) -> [f64; K],
) -> (Vec<[f64; K]>, Vec<f64>) {
    let told = |parts: [f64; K]| -> f64 {
        parts.iter().enumerate().map(|(k, part)| part * schlick(cosine::<K>(k))).sum()
    };
    let entries = grid(sizes, &seen);
    let enough = bounding(sizes, 1.0, |at| told(seen(at)));
    let more = entries.iter().zip(enough).map(|(&parts, enough)| enough - told(parts)).collect();
    (entries, more)
}

fn schlick(cos: f64) -> f64 {
    let m = 1.0 - cos;
    (m * m) * (m * m) * m
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
/// weighed by numbers that its own cosine has; so many facets times so many.
fn sent_on<const K: usize>(
    alphas: [f64; 2],
    wo: [f64; 2],
    facets: usize,
    weights: impl Fn(f64) -> [f64; K],
) -> [f64; K] {
    let mut sums = [0.0; K];
    each_sent_on(alphas, wo, facets, |cos, sent_on| {
        for (sum, weight) in sums.iter_mut().zip(weights(cos)) {
            *sum += sent_on * weight;
        }
    });
    sums
}

/// Tells for each of some facets its cosine with the light that leaves at a cosine and an angle
/// around the normal, and the part of all that light that it sends on.
fn each_sent_on(
    [along, across]: [f64; 2],
    [mu, around]: [f64; 2],
    facets: usize,
    mut tell: impl FnMut(f64, f64),
) {
    let length = |v: [f64; 3]| {
        (along * along * v[0] * v[0] + across * across * v[1] * v[1] + v[2] * v[2]).sqrt()
    };
    let (sin_around, cos_around) = libm::sincos(around);
    let sin = (1.0 - mu * mu).sqrt();
    let wo = [sin * cos_around, sin * sin_around, mu];
    let length_o = length(wo);
    let from = [along * wo[0] / length_o, across * wo[1] / length_o, mu / length_o];
    let count = (facets * facets) as f64;
    for (m, weight) in seen_facets([along, across], from, facets) {
        let cos = wo[0] * m[0] + wo[1] * m[1] + wo[2] * m[2];
        let wi = [0, 1, 2].map(|k| 2.0 * cos * m[k] - wo[k]);
        if wi[2] > 0.0 {
            // G2 / G1, heights correlated.
            let hidden = mu * length(wi) + wi[2] * length_o;
            tell(cos.clamp(0.0, 1.0), weight * wi[2] * (mu + length_o) / hidden / count);
        }
    }
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
