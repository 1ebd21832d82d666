//! Proofs over all BSDFs. A new one joins by a line in `all`.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{
    Focus, chi_square, chi_square_focused, directions, family_wise, integrate_sphere, random,
    well_spread,
};
use rutilant::bsdf::{
    Bsdf, Distribution, Fresnel, Ggx, Lambert, Lobe, OrenNayar, PerfectMirror,
    PrincipledParameters, RoughConductor, RoughDielectric, SmoothConductor, SmoothDielectric,
    ThinDielectric, UniformLambert,
};
use rutilant::color::Spectrum;
use rutilant::geom::{Vec2, Vec3};

/// What a BSDF promises.
struct Entry {
    name: String,
    bsdf: Bsdf,
    /// Sends back all light, per channel, at every angle.
    white: bool,
    /// Made of several layers.
    layers: bool,
}

fn all() -> Vec<Entry> {
    let lambert = |albedo: f32| Lobe::Lambert(Lambert { albedo: Spectrum::splat(albedo) });
    let even =
        |albedo: f32| Lobe::UniformLambert(UniformLambert { albedo: Spectrum::splat(albedo) });
    let mirror = |r: f32| Lobe::Mirror(PerfectMirror { reflectance: Spectrum::splat(r) });
    let glass = |eta, fresnel| Lobe::Dielectric(SmoothDielectric { eta, fresnel });
    let gold =
        SmoothConductor { eta: [0.143, 0.375, 1.442].into(), k: [3.983, 2.386, 1.603].into() };
    let clay = |albedo: f32, r| Lobe::OrenNayar(OrenNayar::new(Spectrum::splat(albedo), r));
    let rough_gold = Lobe::RoughConductor(RoughConductor::new(gold.eta, gold.k, 0.4).unwrap());
    let frosted = |eta, r| Lobe::RoughDielectric(RoughDielectric::new(eta, r).unwrap());
    let beckmann = Distribution::Beckmann;
    let beckmann_gold =
        Lobe::RoughConductor(RoughConductor::with(beckmann, gold.eta, gold.k, 0.4).unwrap());
    let ground = |eta, r| Lobe::RoughDielectric(RoughDielectric::with(beckmann, eta, r).unwrap());
    let pane = |ior, color: [f32; 3]| Lobe::ThinDielectric(ThinDielectric::new(ior, color.into()));
    let entry =
        |name: &'static str, bsdf, white| Entry { name: name.into(), bsdf, white, layers: false };
    // Layers, white as far as nothing is said.
    let white =
        PrincipledParameters { base_color: Spectrum::WHITE, ..PrincipledParameters::default() };
    let clear = PrincipledParameters { transmission: 1.0, roughness: 0.0, ..white };
    let metal = PrincipledParameters { metallic: 1.0, roughness: 0.4, ..white };
    let coated = PrincipledParameters { coat: 1.0, ..white };
    let layered = |name: &'static str, p: PrincipledParameters, white| Entry {
        layers: true,
        ..entry(name, p.into(), white)
    };
    vec![
        entry("white lambert", lambert(1.0).into(), true),
        entry("grey lambert", lambert(0.3).into(), false),
        entry("white lambert, evenly", even(1.0).into(), true),
        entry("grey lambert, evenly", even(0.3).into(), false),
        entry("white clay", clay(1.0, 0.8).into(), true),
        entry("grey clay", clay(0.3, 1.0).into(), false),
        entry("mirror", mirror(1.0).into(), true),
        entry("gold", Lobe::Conductor(gold).into(), false),
        entry("rough gold", rough_gold.into(), false),
        entry("glass", glass(1.5, Fresnel::Exact).into(), true),
        entry("glass by Schlick", glass(1.5, Fresnel::Schlick).into(), true),
        entry("bubble", glass(1.0 / 1.33, Fresnel::Exact).into(), true),
        entry("nothing", glass(1.0, Fresnel::Exact).into(), true),
        entry("frosted glass", frosted(1.5, 0.5).into(), true),
        entry("gold by Beckmann", beckmann_gold.into(), false),
        entry("glass by Beckmann", ground(1.5, 0.6).into(), false),
        entry("bubble by Beckmann", ground(1.0 / 1.33, 0.5).into(), false),
        entry("rough bubble", frosted(1.0 / 1.33, 0.6).into(), true),
        entry("window", pane(1.5, [1.0; 3]).into(), true),
        entry("film of nothing", pane(1.0, [1.0; 3]).into(), true),
        entry("green pane", pane(1.5, [0.2, 0.9, 0.0]).into(), false),
        entry("half mirror", Bsdf::sum([(0.5, lambert(1.0)), (0.5, mirror(1.0))]), true),
        entry("dim half mirror", Bsdf::sum([(0.8, lambert(0.2)), (0.2, mirror(0.9))]), false),
        entry("two greys", Bsdf::sum([(0.3, lambert(0.9)), (0.7, lambert(0.1))]), false),
        entry("gold leaf on clay", Bsdf::sum([(0.4, rough_gold), (0.6, clay(0.5, 0.5))]), false),
        entry("torn gauze", Bsdf::sum([(0.4, pane(1.0, [1.0; 3])), (0.6, lambert(1.0))]), true),
        entry("black", Bsdf::BLACK, false),
        layered("plastic", white, true),
        layered("polished plastic", PrincipledParameters { roughness: 0.0, ..white }, true),
        layered("paper", PrincipledParameters { diffuse_transmission: 0.7, ..white }, true),
        layered(
            "brushed metal",
            PrincipledParameters { anisotropy: 0.5, anisotropy_rotation: 0.7, ..metal },
            true,
        ),
        layered("frosted", PrincipledParameters { roughness: 0.5, ..clear }, true),
        layered(
            "thin frosted pane",
            PrincipledParameters { thin_walled: true, roughness: 0.5, ..clear },
            true,
        ),
        layered("milky", PrincipledParameters { transmission: 0.5, roughness: 0.0, ..white }, true),
        layered(
            "layers: worn varnish",
            PrincipledParameters { coat_roughness: 0.4, ..coated },
            true,
        ),
        layered("layers: coated glass", PrincipledParameters { coat: 0.7, ..clear }, true),
        layered(
            "layers: waves of varnish",
            PrincipledParameters { coat_normal: Vec3::new(0.28, 0.0, 0.96), ..coated },
            false,
        ),
        layered(
            "layers: worn waves",
            PrincipledParameters {
                coat_normal: Vec3::new(0.0, -0.28, 0.96),
                coat_roughness: 0.4,
                ..coated
            },
            false,
        ),
        layered(
            "layers: bumps under worn varnish",
            PrincipledParameters {
                normal: Vec3::new(0.48, 0.36, 0.8),
                coat_normal: Vec3::new(0.0, -0.28, 0.96),
                coat_roughness: 0.4,
                roughness: 0.5,
                ..coated
            },
            false,
        ),
        layered(
            "layers: waves of frosted glass under varnish",
            PrincipledParameters {
                normal: Vec3::new(0.28, 0.0, 0.96),
                transmission: 1.0,
                roughness: 0.5,
                ..coated
            },
            false,
        ),
        layered(
            "layers: velvet",
            PrincipledParameters {
                base_color: [0.1, 0.1, 0.3].into(),
                diffuse_roughness: 0.7,
                sheen_color: [0.5, 0.6, 0.9].into(),
                ..white
            },
            false,
        ),
    ]
}

/// A rough one, and what it is made of.
struct Rough {
    entry: Entry,
    /// α of its facets; `None` where it has none.
    alpha: Option<f32>,
    /// Index below over that above; 1 where nothing is refracted.
    eta: f32,
}

/// From what single precision just resolves to what is as rough as can be.
const ROUGHNESSES: [f32; 9] = [0.020_001, 0.03, 0.07, 0.15, 0.3, 0.45, 0.6, 0.8, 1.0];

/// From hardly there to diamond, and their reciprocals.
const INDICES: [f32; 7] = [1.041, 1.06, 1.15, 1.33, 1.5, 1.8, 2.5];

fn etas() -> impl Iterator<Item = f32> {
    INDICES.into_iter().flat_map(|n| [n, 1.0 / n])
}

/// A grid over roughness and index. All are white, metals included.
fn rough_ones() -> Vec<Rough> {
    let mut all = Vec::new();
    for roughness in ROUGHNESSES {
        let mut add = |name: String, lobe: Lobe, alpha, eta| {
            let entry = Entry { name, bsdf: lobe.into(), white: true, layers: false };
            all.push(Rough { entry, alpha, eta });
        };
        let alpha = Some(roughness * roughness);
        let clay = OrenNayar::new(Spectrum::WHITE, roughness);
        add(format!("clay {roughness}"), Lobe::OrenNayar(clay), None, 1.0);
        // An index without real part reflects everything.
        let metal = RoughConductor::new(Spectrum::BLACK, Spectrum::WHITE, roughness).unwrap();
        add(format!("metal {roughness}"), Lobe::RoughConductor(metal), alpha, 1.0);
        for eta in etas() {
            let glass = RoughDielectric::new(eta, roughness).unwrap();
            add(format!("glass {roughness} of {eta}"), Lobe::RoughDielectric(glass), alpha, eta);
        }
    }
    all
}

/// Facets that lose light, over a part of the same grid.
fn beckmann_ones() -> Vec<Rough> {
    let mut all = Vec::new();
    for (i, roughness) in ROUGHNESSES.into_iter().enumerate() {
        let alpha = Some(roughness * roughness);
        let mut add = |name: String, lobe: Lobe, eta| {
            let name = format!("{name} {roughness} by Beckmann");
            let entry = Entry { name, bsdf: lobe.into(), white: false, layers: false };
            all.push(Rough { entry, alpha, eta });
        };
        let (distribution, white) = (Distribution::Beckmann, Spectrum::WHITE);
        let metal = RoughConductor::with(distribution, Spectrum::BLACK, white, roughness);
        add("metal".to_owned(), Lobe::RoughConductor(metal.unwrap()), 1.0);
        let eta = INDICES[i % INDICES.len()];
        let eta = if i % 2 == 0 { eta } else { 1.0 / eta };
        let glass = RoughDielectric::with(distribution, eta, roughness).unwrap();
        add(format!("glass of {eta}"), Lobe::RoughDielectric(glass), eta);
    }
    all
}

/// All of them.
fn everything() -> impl Iterator<Item = Rough> {
    let simple = all().into_iter().map(|entry| Rough { entry, alpha: None, eta: 1.0 });
    simple.chain(rough_ones()).chain(beckmann_ones())
}

/// Directions over both sides, up to a tenth of a degree from the surface.
fn steep_and_grazing() -> Vec<Vec3> {
    let degrees = [0.0_f32, 20.0, 45.0, 60.0, 75.0, 85.0, 89.0, 89.9];
    let both = degrees.iter().flat_map(|&d| [d, 180.0 - d]).collect::<Vec<_>>();
    directions(&both).into_iter().step_by(2).collect()
}

fn all_sides() -> Vec<Vec3> {
    directions(&[0.0, 20.0, 50.0, 75.0, 88.0, 92.0, 130.0, 180.0])
}

/// Samples follow the stated density; those of delta lobes are left to the other tests.
#[test]
fn samples_follow_the_density() {
    // Layers have a test of their own, in `principled.rs`.
    let rough = |e: &&Entry| !e.bsdf.is_delta() && !e.layers;
    let wos = directions(&[0.0, 50.0, 88.0, 130.0]);
    let entries = all();
    let level = family_wise(entries.iter().filter(rough).count() * wos.len());
    for (stream, entry) in entries.iter().filter(rough).enumerate() {
        for &wo in &wos {
            let sample = |choice, u| {
                let s = entry.bsdf.sample(wo, choice, u)?;
                (!s.delta).then_some(s.wi)
            };
            let p = chi_square(stream as u64, sample, |wi| entry.bsdf.pdf(wo, wi));
            assert!(p > level, "{} at {wo}: p = {p:e}", entry.name);
        }
    }
}

/// The same over the grid of roughness, index and angle, with eyes for the narrowest highlight.
#[test]
fn rough_samples_follow_the_density() {
    let wos = directions(&[0.0, 50.0, 84.0, 125.0]);
    let wos: Vec<Vec3> = wos.into_iter().step_by(2).collect();
    // Every other roughness and index, and all of clay and metal.
    let grid: Vec<Rough> = rough_ones()
        .into_iter()
        .enumerate()
        .filter(|(i, rough)| rough.eta == 1.0 || i % 3 == 0)
        .map(|(_, rough)| rough)
        .chain(beckmann_ones())
        .collect();
    let tests = grid.len() * wos.len();
    assert!(tests >= 200, "{tests} are too few");
    let level = family_wise(tests);
    for (stream, Rough { entry, alpha, eta }) in grid.iter().enumerate() {
        for (k, &wo) in wos.iter().enumerate() {
            let sample = |choice, u| entry.bsdf.sample(wo, choice, u).map(|s| s.wi);
            let pdf = |wi| entry.bsdf.pdf(wo, wi);
            let stream = (stream * wos.len() + k) as u64;
            let p = match alpha {
                None => chi_square(stream, sample, pdf),
                Some(alpha) => {
                    let focus = highlights(wo, f64::from(*alpha), *eta);
                    chi_square_focused(stream, focus, sample, pdf)
                }
            };
            assert!(p > level, "{} at {wo}: p = {p:e}", entry.name);
        }
    }
}

/// Where smooth glass would send light from `wo`, above and below, and how wide facets make that.
fn highlights(wo: Vec3, alpha: f64, eta: f32) -> [Focus; 2] {
    let eta = if wo.z > 0.0 { eta } else { 1.0 / eta };
    let mirrored = Focus { pole: Vec3::new(-wo.x, -wo.y, wo.z), width: 2.0 * alpha };
    let sin2 = (wo.x * wo.x + wo.y * wo.y) / (eta * eta);
    let down = (1.0 - sin2).max(0.0).sqrt().copysign(-wo.z);
    let pole = Vec3::new(-wo.x / eta, -wo.y / eta, down).normalize();
    let bend = f64::from((1.0 - 1.0 / eta).abs());
    let refracted = Focus { pole, width: if eta == 1.0 { 2.0 } else { alpha * bend } };
    if wo.z > 0.0 { [mirrored, refracted] } else { [refracted, mirrored] }
}

/// In a furnace of radiance 1 a surface that absorbs nothing cannot be seen: what it sends back
/// averages to 1. A missing π, a missing cosine or a lost half shows here.
#[test]
fn white_surfaces_vanish_in_the_furnace() {
    for entry in all() {
        for wo in all_sides() {
            let n = 40_000;
            let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
            for i in 0..n {
                let (choice, u) = random(7, i);
                let Some(s) = entry.bsdf.sample(wo, choice, u) else { continue };
                // Radiance grows by the square of the index inside; the furnace's does, too.
                for (k, w) in s.weight.channels().into_iter().enumerate() {
                    let worth = f64::from(w * (s.eta * s.eta));
                    sum[k] += worth / n as f64;
                    squares[k] += worth * worth / n as f64;
                }
            }
            for (mean, square) in sum.into_iter().zip(squares) {
                // Chance alone exceeds five standard errors once in two million.
                let off = 1e-3 + 5.0 * ((square - mean * mean).max(0.0) / n as f64).sqrt();
                assert!(mean < 1.0 + off, "{} at {wo} sends back {mean}", entry.name);
                assert!(
                    !entry.white || mean > 1.0 - off,
                    "{} at {wo} sends back {mean}",
                    entry.name
                );
            }
        }
    }
}

/// What comes back, in red, of light of 1 from everywhere, by so many samples.
fn sent_on(bsdf: &Bsdf, wo: Vec3, samples: u64) -> f64 {
    let worth = (0..samples).filter_map(|i| {
        let (choice, u) = well_spread(i);
        let s = bsdf.sample(wo, choice, u)?;
        Some(f64::from(s.weight.channels()[0] * (s.eta * s.eta)))
    });
    worth.sum::<f64>() / samples as f64
}

/// The same over the grid, to within half a percent: what facets lose is given back, at every
/// roughness, index and angle, from outside and from inside.
#[test]
fn rough_white_surfaces_vanish_in_the_furnace() {
    let mut worst = (0.0, String::new());
    for Rough { entry, .. } in rough_ones() {
        for wo in steep_and_grazing() {
            let off = (sent_on(&entry.bsdf, wo, 1 << 15) - 1.0).abs();
            if off > 0.003 {
                println!("{off} {} at {wo}", entry.name);
            }
            if off > worst.0 {
                worst = (off, format!("{} at {wo}", entry.name));
            }
        }
    }
    println!("off by {} at worst: {}", worst.0, worst.1);
    assert!(worst.0 < 0.005, "off by {}: {}", worst.0, worst.1);
}

/// Facets of Beckmann send on no more than there is, and hardly less where they are hardly rough.
#[test]
fn beckmanns_facets_make_no_light() {
    for Rough { entry, alpha, .. } in beckmann_ones() {
        for wo in steep_and_grazing() {
            let sent = sent_on(&entry.bsdf, wo, 1 << 13);
            assert!(sent < 1.005, "{} at {wo} sends back {sent}", entry.name);
            let steep = wo.z.abs() > 0.9 && alpha.is_some_and(|alpha| alpha < 0.01);
            assert!(!steep || sent > 0.99, "{} at {wo} sends back {sent}", entry.name);
        }
    }
}

/// Value, density and weight of a sample say the same.
#[test]
fn weights_are_value_over_density() {
    for entry in everything().map(|rough| rough.entry) {
        for wo in all_sides() {
            for i in 0..200 {
                let (choice, u) = random(3, i);
                let Some(s) = entry.bsdf.sample(wo, choice, u) else { continue };
                assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0, "{}: {s:?}", entry.name);
                if s.delta {
                    continue;
                }
                // The mix's own delta lobe can draw no direction of the others.
                let value = entry.bsdf.eval_cos(wo, s.wi);
                for (w, f) in s.weight.channels().into_iter().zip(value.channels()) {
                    assert!((w * s.pdf - f).abs() <= 1e-5 * f.max(1e-6), "{}: {s:?}", entry.name);
                }
            }
        }
    }
}

/// Light takes the same way back (Helmholtz), radiance corrected for the index.
#[test]
fn scattering_is_reciprocal() {
    let index = |eta: f32, w: Vec3| if w.z > 0.0 { 1.0 } else { eta };
    let even = |e: Entry| {
        let eta = match e.name.as_str() {
            name if name.contains("bubble") => 1.0 / 1.33,
            "paper" => 1.0,
            name if name.starts_with("thin") => 1.0,
            _ => 1.5,
        };
        Rough { entry: e, alpha: None, eta }
    };
    for Rough { entry, eta, .. } in
        all().into_iter().map(even).chain(rough_ones()).chain(beckmann_ones())
    {
        for wo in all_sides() {
            for i in 0..100 {
                let (choice, u) = random(5, i);
                let anywhere = rutilant::math::warp::uniform_sphere(u);
                // Where anything is to be seen, and anywhere.
                let scattered = entry.bsdf.sample(wo, choice, u).map(|s| s.wi);
                for wi in [Some(anywhere), scattered].into_iter().flatten() {
                    let (cos_o, cos_i) = (wo.z.abs(), wi.z.abs());
                    // Below coats and sheen nothing rough is: see `Principled`.
                    if cos_o.min(cos_i) < 1e-5 || entry.name.starts_with("layers") {
                        continue;
                    }
                    let (n_o, n_i) = (index(eta, wo), index(eta, wi));
                    let there = entry.bsdf.eval_cos(wo, wi) / (cos_i * n_o * n_o);
                    let back = entry.bsdf.eval_cos(wi, wo) / (cos_o * n_i * n_i);
                    for (a, b) in there.channels().into_iter().zip(back.channels()) {
                        assert!(
                            (a - b).abs() <= 1e-4 * a.max(1.0),
                            "{} {wo} {wi}: {a} {b}",
                            entry.name
                        );
                    }
                }
                // A delta's way back leads to where it came from, with the same probability.
                let Some(s) = entry.bsdf.sample(wo, choice, u).filter(|s| s.delta) else {
                    continue;
                };
                let reversed = (0..64).find_map(|k| {
                    let r = entry.bsdf.sample(s.wi, (k as f32 + 0.5) / 64.0, u)?;
                    (r.delta && r.wi.dot(wo) > 1.0 - 1e-5).then_some(r)
                });
                // No light path goes by a coat with a normal of its own: what is below it is seen
                // under another angle on the way back, and what was folded up is not unfolded.
                let waves = entry.name.contains("waves");
                let Some(r) = reversed else {
                    assert!(waves, "{}: no way back from {s:?}", entry.name);
                    continue;
                };
                let as_often = (r.pdf - s.pdf).abs() < 1e-3 || waves;
                assert!(
                    as_often && (r.eta * s.eta - 1.0).abs() < 1e-5,
                    "{}: {s:?} {r:?}",
                    entry.name
                );
            }
        }
    }
}

/// The density of non-delta lobes integrates to the chance of drawing one of them.
#[test]
fn densities_integrate_to_their_chance() {
    for entry in all() {
        let wo = directions(&[40.0])[0];
        let n = 10_000;
        let drawn = (0..n)
            .filter(|&i| {
                let (choice, u) = random(11, i);
                entry.bsdf.sample(wo, choice, u).is_some_and(|s| !s.delta)
            })
            .count() as f64
            / n as f64;
        let [integral, ..] = integrate_sphere(|wi| Spectrum::splat(entry.bsdf.pdf(wo, wi)));
        assert!((integral - drawn).abs() < 0.02, "{}: {integral} {drawn}", entry.name);
    }
}

/// At every edge of their domain samples are finite or absent: the ends of [0, 1), directions in
/// the surface, and along the normal a cosine that was rounded up from 1. The old program drew a
/// cosine of 0 and divided by it.
#[test]
fn edges_give_numbers_or_nothing() {
    let below_one = 1.0 - 0.5 * f32::EPSILON;
    let us = [0.0, f32::MIN_POSITIVE, 0.5, below_one];
    let mut wos =
        vec![Vec3::X, Vec3::Z, Vec3::NEG_Z, Vec3::new(1.0, 0.0, 1e-30), Vec3::new(1.0, 0.0, -1e-7)];
    wos.push(Vec3::new(0.8, -0.6, f32::MIN_POSITIVE));
    let rounded_up = Vec3::new(5e-5, -3e-5, 1.0 + f32::EPSILON);
    wos.extend([rounded_up, -rounded_up]);
    for entry in everything().map(|rough| rough.entry) {
        for &wo in &wos {
            for wi in [rounded_up, -rounded_up] {
                let (value, pdf) = entry.bsdf.eval_cos_pdf(wo, wi);
                assert!(value.is_finite() && pdf.is_finite(), "{} {wo} {wi}", entry.name);
            }
            for choice in us {
                for x in us {
                    for y in us {
                        let Some(s) = entry.bsdf.sample(wo, choice, Vec2::new(x, y)) else {
                            continue;
                        };
                        let sound = s.wi.is_finite()
                            && s.weight.is_finite()
                            && s.pdf > 0.0
                            && s.pdf.is_finite();
                        let (value, pdf) =
                            (entry.bsdf.eval_cos(wo, s.wi), entry.bsdf.pdf(wo, s.wi));
                        let sound = sound && value.is_finite() && pdf.is_finite();
                        assert!(
                            sound && s.weight.channels().iter().all(|&w| w >= 0.0),
                            "{} {wo} {s:?}",
                            entry.name
                        );
                    }
                }
            }
        }
    }
}

/// Below the critical angle nothing leaves glass: at 45° and 1.5 every sample is reflected.
#[test]
fn total_reflection_is_total() {
    let glass =
        Bsdf::from(Lobe::Dielectric(SmoothDielectric { eta: 1.5, fresnel: Fresnel::Exact }));
    let wo = -directions(&[45.0])[0];
    for i in 0..1000 {
        let s = glass.sample(wo, i as f32 / 1000.0, Vec2::splat(0.5)).unwrap();
        assert!(s.wi.z < 0.0 && s.weight == Spectrum::WHITE && s.pdf == 1.0);
    }
}

/// A border between equal media changes nothing, not even the last bit.
#[test]
fn equal_indices_are_invisible() {
    let nothing =
        Bsdf::from(Lobe::Dielectric(SmoothDielectric { eta: 1.0, fresnel: Fresnel::Exact }));
    for wo in all_sides() {
        let s = nothing.sample(wo, 0.0, Vec2::ZERO).unwrap();
        assert_eq!((s.wi, s.weight, s.pdf), (-wo, Spectrum::WHITE, 1.0));
    }
}

/// Hardly rough glass reflects what the Fresnel equations say of smooth glass, from both sides,
/// and sends the rest where Snell's law says.
#[test]
fn hardly_rough_glass_is_like_smooth_glass() {
    for eta in etas() {
        let roughness = 0.020_001;
        let rough =
            Bsdf::from(Lobe::RoughDielectric(RoughDielectric::new(eta, roughness).unwrap()));
        let smooth =
            Bsdf::from(Lobe::Dielectric(SmoothDielectric { eta, fresnel: Fresnel::Exact }));
        for wo in directions(&[0.0, 30.0, 60.0, 80.0, 120.0, 150.0, 180.0]) {
            let relative = if wo.z > 0.0 { eta } else { 1.0 / eta };
            let (expected, _) = Fresnel::Exact.dielectric(wo.z.abs(), relative);
            let ways = [0.0, 1.0 - 0.5 * f32::EPSILON]
                .map(|choice| smooth.sample(wo, choice, Vec2::ZERO).unwrap());
            let n = 20_000;
            let (mut reflected, mut near) = (0.0, 0.0);
            for i in 0..n {
                let (choice, u) = well_spread(i);
                let Some(s) = rough.sample(wo, choice, u) else { continue };
                let weight = s.weight.channels()[0] * s.eta * s.eta;
                if !s.is_transmission(wo) {
                    reflected += weight;
                }
                if ways.iter().any(|way| way.wi.dot(s.wi) > 0.999) {
                    near += weight;
                }
            }
            let (reflected, near) = (reflected / n as f32, near / n as f32);
            // Near the critical angle facets see both sides of it.
            let critical = (1.0 - wo.z * wo.z).sqrt() / relative;
            let tolerance = if (critical - 1.0).abs() < 0.01 { 0.2 } else { 2e-3 };
            assert!(
                (reflected - expected).abs() < tolerance,
                "{eta} {wo}: {reflected}, not {expected}"
            );
            assert!(near > 0.99, "{eta} {wo}: only {near} go where they should");
        }
    }
}

/// What cannot be told from smooth is smooth, exactly: no roughness, too little of it, or a border
/// between equal media.
#[test]
fn what_cannot_be_resolved_is_left_to_smooth_lobes() {
    let least = Ggx::LEAST_ALPHA.sqrt();
    let (eta, k) = (Spectrum::WHITE, Spectrum::WHITE);
    assert!(RoughConductor::new(eta, k, 0.0).is_none());
    assert!(RoughConductor::new(eta, k, 0.99 * least).is_none());
    assert!(RoughConductor::new(eta, k, 1.01 * least).is_some());
    assert!(RoughDielectric::new(1.5, 0.99 * least).is_none());
    assert!(RoughConductor::with(Distribution::Beckmann, eta, k, 0.99 * least).is_none());
    for nearly_equal in [1.0, 1.02, 1.0 / 1.02] {
        assert!(RoughDielectric::new(nearly_equal, 1.0).is_none());
    }
}

/// A matte surface without roughness is Lambert's, and no sample of a rough one weighs much more
/// than its albedo.
#[test]
fn rough_matte_samples_are_of_even_weight() {
    let flat = OrenNayar::new(Spectrum::splat(0.7), 0.0);
    let lambert = Lambert { albedo: Spectrum::splat(0.7) };
    for roughness in [0.3, 0.6, 1.0] {
        let clay = OrenNayar::new(Spectrum::WHITE, roughness);
        for wo in directions(&[0.0, 40.0, 70.0, 85.0, 89.9]) {
            let (mut sum, mut squares, n) = (0.0, 0.0, 20_000);
            for i in 0..n {
                let (choice, u) = well_spread(i);
                let s = clay.sample(wo, choice, u).unwrap();
                let (a, b) = (flat.eval_cos(wo, s.wi), lambert.eval_cos(wo, s.wi));
                assert!((a - b).max_channel().abs() < 1e-6);
                let weight = f64::from(s.weight.channels()[0]);
                assert!(weight < 2.0, "{roughness} {wo}: {weight}");
                sum += weight;
                squares += weight * weight;
            }
            let mean = sum / n as f64;
            let variance = squares / n as f64 - mean * mean;
            println!("{roughness} {:.1}°: variance {variance:.4}", wo.z);
            assert!(variance < 0.12, "{roughness} {wo}: {variance}");
        }
    }
}

/// A clear pane reflects 2 R / (1 + R), as Stokes found; a grey one the series that is summed here
/// term by term.
#[test]
fn panes_sum_what_goes_to_and_fro() {
    for (ior, color) in [(1.5, 1.0), (1.5, 0.5), (2.4, 0.9), (1.2, 0.0)] {
        let pane = ThinDielectric::new(ior, Spectrum::splat(color));
        for wo in directions(&[0.0, 30.0, 60.0, 85.0, 120.0]) {
            let (r, cos_t) = Fresnel::Exact.dielectric(wo.z.abs(), ior);
            let (r, left) = (f64::from(r), f64::from(color).powf(f64::from(1.0 / cos_t)));
            // Into the pane, and then from face to face, each time leaving a part behind it.
            let (mut reflected, mut passed, mut inside) = (r, 0.0, (1.0 - r) * left);
            for bounce in 0..200 {
                let out = inside * (1.0 - r);
                if bounce % 2 == 0 {
                    passed += out;
                } else {
                    reflected += out;
                }
                inside *= r * left;
            }
            for choice in [0.0, 0.999_999] {
                let Some(s) = pane.sample(wo, choice) else { continue };
                let got = f64::from(s.weight.channels()[0] * s.pdf);
                let expected = if s.is_transmission(wo) { passed } else { reflected };
                assert!((got - expected).abs() < 1e-5, "{ior} {color} {wo}: {got} {expected}");
                assert!(!s.is_transmission(wo) || s.wi == -wo, "light passes straight on");
            }
            if color == 1.0 {
                assert!((reflected - 2.0 * r / (1.0 + r)).abs() < 1e-9);
            }
        }
    }
}

/// What a surface sends back by its value alone, integrated over directions: 1 for white clay, and
/// for white metal and glass to the precision of their table. It does not ask how samples are drawn.
#[test]
fn values_integrate_to_white() {
    let mut surfaces: Vec<(String, Bsdf, f64)> = Vec::new();
    for roughness in [0.2, 0.5, 0.8, 1.0] {
        let clay = Lobe::OrenNayar(OrenNayar::new(Spectrum::WHITE, roughness));
        surfaces.push((format!("clay {roughness}"), clay.into(), 2e-4));
    }
    for roughness in [0.6, 0.8, 1.0] {
        let metal = RoughConductor::new(Spectrum::BLACK, Spectrum::WHITE, roughness).unwrap();
        surfaces.push((format!("metal {roughness}"), Lobe::RoughConductor(metal).into(), 5e-3));
    }
    for (name, bsdf, tolerance) in surfaces {
        for wo in directions(&[0.0, 20.0, 50.0, 75.0, 88.0, 130.0]) {
            let [sum, ..] = integrate_sphere(|wi| bsdf.eval_cos(wo, wi));
            assert!((sum - 1.0).abs() < tolerance, "{name} at {wo}: {sum}");
        }
    }
}
