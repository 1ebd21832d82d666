//! Proofs over all BSDFs. A new one joins by a line in `all`.

mod common;

use common::{chi_square, directions, family_wise, integrate_sphere, random};
use rutilant::bsdf::{
    Bsdf, Fresnel, Lambert, Lobe, PerfectMirror, SmoothConductor, SmoothDielectric,
};
use rutilant::color::Spectrum;
use rutilant::geom::{Vec2, Vec3};

/// What a BSDF promises.
struct Entry {
    name: &'static str,
    bsdf: Bsdf,
    /// Sends back all light, per channel, at every angle.
    white: bool,
}

fn all() -> Vec<Entry> {
    let lambert = |albedo: f32| Lobe::Lambert(Lambert { albedo: Spectrum::splat(albedo) });
    let mirror = |r: f32| Lobe::Mirror(PerfectMirror { reflectance: Spectrum::splat(r) });
    let glass = |eta, fresnel| Lobe::Dielectric(SmoothDielectric { eta, fresnel });
    let gold =
        SmoothConductor { eta: [0.143, 0.375, 1.442].into(), k: [3.983, 2.386, 1.603].into() };
    let entry = |name, bsdf, white| Entry { name, bsdf, white };
    vec![
        entry("white lambert", lambert(1.0).into(), true),
        entry("grey lambert", lambert(0.3).into(), false),
        entry("mirror", mirror(1.0).into(), true),
        entry("gold", Lobe::Conductor(gold).into(), false),
        entry("glass", glass(1.5, Fresnel::Exact).into(), true),
        entry("glass by Schlick", glass(1.5, Fresnel::Schlick).into(), true),
        entry("bubble", glass(1.0 / 1.33, Fresnel::Exact).into(), true),
        entry("nothing", glass(1.0, Fresnel::Exact).into(), true),
        entry("half mirror", Bsdf::sum([(0.5, lambert(1.0)), (0.5, mirror(1.0))]), true),
        entry("dim half mirror", Bsdf::sum([(0.8, lambert(0.2)), (0.2, mirror(0.9))]), false),
        entry("two greys", Bsdf::sum([(0.3, lambert(0.9)), (0.7, lambert(0.1))]), false),
        entry("black", Bsdf::BLACK, false),
    ]
}

fn all_sides() -> Vec<Vec3> {
    directions(&[0.0, 20.0, 50.0, 75.0, 88.0, 92.0, 130.0, 180.0])
}

/// Samples follow the stated density; those of delta lobes are left to the other tests.
#[test]
fn samples_follow_the_density() {
    let rough = |e: &&Entry| !e.bsdf.is_delta();
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

/// In a furnace of radiance 1 a surface that absorbs nothing cannot be seen: what it sends back
/// averages to 1. A missing π, a missing cosine or a lost half shows here.
#[test]
fn white_surfaces_vanish_in_the_furnace() {
    for entry in all() {
        for wo in all_sides() {
            let n = 40_000;
            // Radiance grows by the square of the index inside; the furnace's does, too.
            let worth = (0..n).filter_map(|i| {
                let (choice, u) = random(7, i);
                entry.bsdf.sample(wo, choice, u).map(|s| s.weight * (s.eta * s.eta))
            });
            let sum = worth.fold(Spectrum::BLACK, |sum, w| sum + w * (1.0 / n as f32));
            for channel in sum.channels() {
                assert!(channel < 1.001, "{} at {wo} sends back {channel}", entry.name);
                assert!(
                    !entry.white || channel > 0.999,
                    "{} at {wo} sends back {channel}",
                    entry.name
                );
            }
        }
    }
}

/// Value, density and weight of a sample say the same.
#[test]
fn weights_are_value_over_density() {
    for entry in all() {
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
    for entry in all() {
        for wo in all_sides() {
            for i in 0..100 {
                let (choice, u) = random(5, i);
                let wi = rutilant::math::warp::uniform_sphere(u);
                let there = entry.bsdf.eval_cos(wo, wi) / wi.z.abs().max(1e-6);
                let back = entry.bsdf.eval_cos(wi, wo) / wo.z.abs().max(1e-6);
                for (a, b) in there.channels().into_iter().zip(back.channels()) {
                    assert!((a - b).abs() < 1e-4 || wo.z.abs() < 1e-5, "{}: {a} {b}", entry.name);
                }
                // A delta's way back leads to where it came from, with the same probability.
                let Some(s) = entry.bsdf.sample(wo, choice, u).filter(|s| s.delta) else {
                    continue;
                };
                let reversed = (0..64).find_map(|k| {
                    let r = entry.bsdf.sample(s.wi, (k as f32 + 0.5) / 64.0, u)?;
                    (r.delta && r.wi.dot(wo) > 1.0 - 1e-5).then_some(r)
                });
                let Some(r) = reversed else { panic!("{}: no way back from {s:?}", entry.name) };
                assert!(
                    (r.pdf - s.pdf).abs() < 1e-3 && (r.eta * s.eta - 1.0).abs() < 1e-5,
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
/// the surface. The old program drew a cosine of 0 and divided by it.
#[test]
fn edges_give_numbers_or_nothing() {
    let below_one = 1.0 - 0.5 * f32::EPSILON;
    let us = [0.0, f32::MIN_POSITIVE, 0.5, below_one];
    let mut wos =
        vec![Vec3::X, Vec3::Z, Vec3::NEG_Z, Vec3::new(1.0, 0.0, 1e-30), Vec3::new(1.0, 0.0, -1e-7)];
    wos.push(Vec3::new(0.8, -0.6, f32::MIN_POSITIVE));
    for entry in all() {
        for &wo in &wos {
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
