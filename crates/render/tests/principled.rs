//! Proofs about the layers of principled surfaces, beside those over all BSDFs in `bsdf.rs`.
//!
//! `RUTILANT_SETS=500 cargo test --release -p rutilant --test principled` puts so many random
//! surfaces into the furnace, and draws from a tenth of them to compare with their densities;
//! without it there are 24 and 4.

mod common;

use common::{chi_square, directions, family_wise, random, well_spread};
use rutilant::bsdf::{
    Bsdf, Fresnel, Lambert, Lobe, OrenNayar, PrincipledParameters, RoughConductor, RoughDielectric,
    SmoothDielectric,
};
use rutilant::color::Spectrum;
use rutilant::geom::Vec3;

/// White where anything could be coloured.
fn white() -> PrincipledParameters {
    PrincipledParameters { base_color: Spectrum::WHITE, ..PrincipledParameters::default() }
}

/// What is sent back of an even white sky, per channel, with the standard errors; inside of glass
/// the sky is brighter by the square of the index.
fn furnace(
    bsdf: &Bsdf,
    wo: Vec3,
    n: u64,
    draw: impl Fn(u64) -> (f32, rutilant::geom::Vec2),
) -> ([f64; 3], [f64; 3]) {
    let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
    for i in 0..n {
        let (choice, u) = draw(i);
        let Some(s) = bsdf.sample(wo, choice, u) else { continue };
        for (k, w) in s.weight.channels().into_iter().enumerate() {
            let worth = f64::from(w * s.eta * s.eta);
            sum[k] += worth / n as f64;
            squares[k] += worth * worth / n as f64;
        }
    }
    let error = |k: usize| ((squares[k] - sum[k] * sum[k]).max(0.0) / n as f64).sqrt();
    (sum, std::array::from_fn(error))
}

/// Every slab, alone and over the others, at several roughnesses; nothing absorbs. What is left of
/// white light at least: tables of brushed surfaces and of films are coarse, and tell bounds.
fn white_surfaces() -> Vec<(String, PrincipledParameters, f64)> {
    let mut all = Vec::new();
    for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
        let p = PrincipledParameters { roughness, ..white() };
        let mut add = |name: &str, p: PrincipledParameters| {
            let least = match (p.anisotropy > 0.0, p.iridescence > 0.0) {
                (false, false) => 0.99,
                (false, true) => 0.97,
                (true, _) => 0.955,
            };
            all.push((format!("{name}, roughness {roughness}"), p, least));
        };
        add("plastic", p);
        add("metal", PrincipledParameters { metallic: 1.0, ..p });
        add("half metal", PrincipledParameters { metallic: 0.5, ..p });
        add("no gloss", PrincipledParameters { specular: 0.0, ..p });
        add("gem", PrincipledParameters { eta: 2.4, ..p });
        add("clay", PrincipledParameters { diffuse_roughness: 1.0, ..p });
        add("paper", PrincipledParameters { diffuse_transmission: 0.6, ..p });
        let glass = PrincipledParameters { transmission: 1.0, ..p };
        add("glass", glass);
        add("milky glass", PrincipledParameters { transmission: 0.5, ..p });
        add("bubble", PrincipledParameters { eta: 1.0 / 1.33, ..glass });
        let thin = PrincipledParameters { thin_walled: true, ..glass };
        add("pane", thin);
        add("half a pane", PrincipledParameters { transmission: 0.5, ..thin });
        for anisotropy in [0.3, 0.8] {
            let brushed = |p| PrincipledParameters { anisotropy, ..p };
            let metal = PrincipledParameters { metallic: 1.0, ..p };
            add(&format!("brushed plastic {anisotropy}"), brushed(p));
            add(&format!("brushed metal {anisotropy}"), brushed(metal));
            add(&format!("brushed pane {anisotropy}"), brushed(thin));
        }
        for thickness in [0.0, 110.0, 400.0] {
            let filmed = |p| PrincipledParameters {
                iridescence: 1.0,
                iridescence_thickness_nm: thickness,
                ..p
            };
            add(&format!("plastic, film of {thickness} nm"), filmed(p));
            add(&format!("pane, film of {thickness} nm"), filmed(thin));
            add(&format!("half a film of {thickness} nm"), {
                PrincipledParameters { iridescence: 0.5, ..filmed(p) }
            });
        }
        for sheen_roughness in [0.3, 1.0] {
            let velvet =
                |p| PrincipledParameters { sheen_color: Spectrum::WHITE, sheen_roughness, ..p };
            add(&format!("velvet {sheen_roughness}"), velvet(p));
            let metal = PrincipledParameters { metallic: 1.0, ..p };
            add(&format!("velvet {sheen_roughness} over metal"), velvet(metal));
        }
        for coat_roughness in [0.0, 0.5] {
            let coat = |p| PrincipledParameters { coat: 0.8, coat_roughness, ..p };
            add(&format!("plastic, coated {coat_roughness}"), coat(p));
            let metal = PrincipledParameters { metallic: 1.0, ..p };
            add(&format!("metal, coated {coat_roughness}"), coat(metal));
            add(&format!("glass, coated {coat_roughness}"), coat(glass));
        }
    }
    all
}

/// To within one percent white layers cannot be seen in a furnace, from in front and from behind,
/// up to one degree from the surface: what one layer takes, the next one gets. A film takes from what
/// is below it what it reflects of the channel of which that is most, at each angle another one.
/// Of what is brushed a little more is lost, too. More than there is never comes back.
#[test]
fn white_layers_vanish_in_the_furnace() {
    let (mut darkest, mut brightest) = ((1.0, String::new()), (0.0, String::new()));
    for (name, parameters, least) in white_surfaces() {
        let bsdf = Bsdf::from(parameters);
        let mut wos = directions(&[0.0, 45.0, 70.0, 85.0, 89.0, 110.0, 150.0]);
        if parameters.anisotropy > 0.0 {
            // Along the tangent and across, where they differ most.
            let turned = directions(&[45.0, 70.0, 85.0, 89.0]).into_iter().step_by(2);
            wos.extend(turned.flat_map(|w| {
                let sin = (w.x * w.x + w.y * w.y).sqrt();
                [Vec3::new(sin, 0.0, w.z), Vec3::new(0.0, sin, w.z)]
            }));
        } else {
            wos = wos.into_iter().step_by(2).collect();
        }
        for wo in wos {
            let (mean, error) = furnace(&bsdf, wo, 1 << 12, well_spread);
            let what = format!("{name} at {wo}: {mean:?} ± {error:?}");
            let (mean, error) = (mean[0].max(mean[1]).max(mean[2]), error[0]);
            let (above, below) = (mean - 1.0 - 3.0 * error, mean + error - least);
            if below < darkest.0 {
                darkest = (below, what.clone());
            }
            if above > brightest.0 {
                brightest = (above, what);
            }
        }
    }
    println!("{darkest:?}\n{brightest:?}");
    assert!(darkest.0 > 0.0, "too dark by {}: {}", -darkest.0, darkest.1);
    assert!(brightest.0 < 5e-4, "too bright by {}: {}", brightest.0, brightest.1);
}

/// Rough glass that is brushed gives back less than it loses, and never more.
#[test]
fn brushed_glass_makes_no_light() {
    for roughness in [0.0, 0.2, 0.6] {
        for anisotropy in [0.3, 0.8] {
            let glass =
                PrincipledParameters { roughness, anisotropy, transmission: 1.0, ..white() };
            for wo in directions(&[0.0, 45.0, 70.0, 85.0, 89.0, 110.0, 150.0]) {
                let (mean, error) = furnace(&Bsdf::from(glass), wo, 1 << 13, well_spread);
                assert!(
                    mean[0] < 1.0 + 3.0 * error[0],
                    "{roughness} {anisotropy} at {wo}: {mean:?} ± {error:?}"
                );
            }
        }
    }
}

/// Number `k` of a random sequence of surfaces: every slab is there now and then, alone and with
/// others, smooth, rough, coloured or not.
fn any_surface(k: u64) -> PrincipledParameters {
    let mut stream = 0;
    let mut number = || {
        stream += 1;
        random(1_000 + k, stream).0
    };
    // Often an end of the range, where slabs are absent or alone.
    let mut part = || {
        let (kind, x) = (number(), number());
        match kind {
            kind if kind < 0.3 => 0.0,
            kind if kind < 0.45 => 1.0,
            _ => x,
        }
    };
    let mut color = || Spectrum::from([part(), part(), part()].map(|c| 0.1 + 0.9 * c));
    let (base_color, specular_color, diffuse_transmission_color) = (color(), color(), color());
    let (coat_color, sheen_color) = (color(), color());
    PrincipledParameters {
        base_color,
        specular_color,
        diffuse_transmission_color,
        coat_color,
        metallic: part() * part(),
        roughness: part(),
        diffuse_roughness: part(),
        anisotropy: part(),
        anisotropy_rotation: 6.0 * part(),
        specular: 1.0 - part() * part(),
        eta: 1.0 + 1.5 * part(),
        transmission: part(),
        thin_walled: part() > 0.5,
        diffuse_transmission: part(),
        coat: part(),
        coat_roughness: part(),
        coat_ior: 1.0 + part(),
        coat_normal: Vec3::Z,
        normal: Vec3::Z,
        sheen_color: sheen_color * part().floor(),
        sheen_roughness: part(),
        iridescence: part(),
        iridescence_ior: 1.0 + part(),
        iridescence_thickness_nm: 1000.0 * part(),
    }
}

/// The same without colours, nothing of which is weaker than it can be.
fn whitened(its: PrincipledParameters) -> PrincipledParameters {
    let white = Spectrum::WHITE;
    PrincipledParameters {
        base_color: white,
        specular: 1.0,
        specular_color: white,
        diffuse_transmission_color: white,
        coat_color: white,
        ..its
    }
}

/// How many surfaces are to be looked at, if more than usual.
fn wanted_sets() -> Option<u64> {
    std::env::var("RUTILANT_SETS").ok().map(|n| n.parse().expect("a number"))
}

/// No set of numbers makes light: what is sent back of an even white sky is at most 1, by three
/// standard errors, in every channel; every second set is white where it could be coloured. So many
/// means exceed three standard errors by chance once in a thousand: of those above, a second look
/// with other numbers decides.
#[test]
fn no_surface_makes_light() {
    const ROUNDING: f64 = 1e-6;
    let sets = wanted_sets().unwrap_or(24);
    let (mut looks, mut second_looks, mut wrong) = (0, 0, Vec::new());
    for k in 0..sets {
        let parameters = if k % 2 == 0 { any_surface(k) } else { whitened(any_surface(k)) };
        let bsdf = Bsdf::from(parameters);
        for wo in directions(&[0.0, 50.0, 75.0, 87.0, 105.0, 150.0]) {
            looks += 1;
            let above = |stream: u64, n| {
                let (mean, error) = furnace(&bsdf, wo, n, |i| random(stream, i));
                let over = (0..3).map(|c| (mean[c] - 1.0 - ROUNDING - 3.0 * error[c], mean[c]));
                let worst = over.fold((f64::MIN, 0.0), |a, b| if b.0 > a.0 { b } else { a });
                (worst.0 > 0.0).then_some(worst.1)
            };
            if above(2 * k, 1 << 13).is_some() {
                second_looks += 1;
                let mean = above(2 * k + 1, 1 << 17);
                if let Some(mean) = mean {
                    wrong.push(format!("{mean} at {wo}, set {k}: {parameters:?}"));
                }
            }
        }
    }
    println!("{sets} sets, {looks} looks, {second_looks} of them twice");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Samples of layers follow their density, from all sides; deltas are left out.
#[test]
fn samples_of_layers_follow_the_density() {
    let sets = wanted_sets().map_or(4, |sets| sets / 10);
    let wos = directions(&[50.0, 125.0]);
    let wos: Vec<Vec3> = wos.into_iter().step_by(2).collect();
    let level = family_wise(sets as usize * wos.len());
    for k in 0..sets {
        let mut parameters = any_surface(100 + k);
        // The chart has eyes for highlights that are not too narrow.
        parameters.roughness = parameters.roughness.max(0.35);
        parameters.coat_roughness = parameters.coat_roughness.max(0.35);
        let bsdf = Bsdf::from(parameters);
        for &wo in &wos {
            let sample = |choice, u| {
                let s = bsdf.sample(wo, choice, u)?;
                (!s.delta).then_some(s.wi)
            };
            let p = chi_square(k, sample, |wi| bsdf.pdf(wo, wi));
            assert!(p > level, "{parameters:?} at {wo}: p = {p:e}");
        }
    }
}

/// Value, density and weight say the same, and a way through glass is taken as often back: light
/// paths, which take it the other way, rely on both.
#[test]
fn layers_say_the_same_of_both_ways() {
    for k in 0..300 {
        let mut parameters = any_surface(500 + k);
        // Highlights that are next to nothing wide are lost in rounding.
        parameters.roughness = parameters.roughness.max(0.15);
        if k % 2 == 0 {
            (parameters.roughness, parameters.coat_roughness, parameters.anisotropy) =
                (0.0, 0.0, 0.0);
        }
        let bsdf = Bsdf::from(parameters);
        for wo in directions(&[10.0, 60.0, 85.0, 110.0, 150.0]) {
            for i in 0..60 {
                let (choice, u) = random(k, i);
                let Some(s) = bsdf.sample(wo, choice, u) else { continue };
                assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0, "{parameters:?}: {s:?}");
                if !s.delta {
                    let value = bsdf.eval_cos(wo, s.wi);
                    for (w, f) in s.weight.channels().into_iter().zip(value.channels()) {
                        let off = (w * s.pdf - f).abs();
                        assert!(off <= 2e-3 * f.max(1e-4), "{parameters:?}: {s:?} {f}");
                    }
                    continue;
                }
                let back = (0..256).find_map(|k| {
                    let r = bsdf.sample(s.wi, (k as f32 + 0.5) / 256.0, u)?;
                    (r.delta && r.wi.dot(wo) > 1.0 - 1e-5).then_some(r)
                });
                // What is drawn more rarely than that is not found.
                let Some(back) = back.filter(|_| s.pdf > 0.01) else { continue };
                assert!((back.pdf - s.pdf).abs() < 2e-3, "{parameters:?} {wo}: {s:?} {back:?}");
                // Radiance is corrected for the index.
                let there = s.weight * (s.pdf * s.eta * s.eta);
                let again = back.weight * (back.pdf * back.eta * back.eta);
                for (a, b) in there.channels().into_iter().zip(again.channels()) {
                    assert!((a - b).abs() < 2e-3, "{parameters:?} {wo}: {s:?} {back:?}");
                }
            }
        }
    }
}

fn assert_same(name: &str, layers: &Bsdf, lobe: &Bsdf, tolerance: f32) {
    for wo in directions(&[0.0, 30.0, 60.0, 80.0, 130.0]) {
        for i in 0..100 {
            let (choice, u) = random(9, i);
            let Some(s) = lobe.sample(wo, choice, u) else { continue };
            if s.delta {
                let t = layers.sample(wo, choice, u).expect("a sample");
                assert!(t.wi.dot(s.wi) > 1.0 - 1e-5, "{name} {wo}: {s:?} {t:?}");
                let off = (t.weight + s.weight * -1.0).max_channel().abs();
                assert!(
                    off < tolerance && (t.pdf - s.pdf).abs() < tolerance,
                    "{name}: {s:?} {t:?}"
                );
                continue;
            }
            let (a, b) = (layers.eval_cos(wo, s.wi), lobe.eval_cos(wo, s.wi));
            for (a, b) in a.channels().into_iter().zip(b.channels()) {
                assert!((a - b).abs() <= tolerance * b.max(0.02), "{name} {wo} {}: {a} {b}", s.wi);
            }
        }
    }
}

/// A single slab is the lobe that there was before: matte, clay, glass smooth and rough, and metal.
/// A white metal is one whose index has no real part. A coloured metal rises towards grazing as
/// Schlick says, and the exact equations of its index a little later.
#[test]
fn single_slabs_are_the_lobes_they_are_made_of() {
    let grey = Spectrum::from([0.2, 0.5, 0.8]);
    let matte = PrincipledParameters { base_color: grey, specular: 0.0, roughness: 0.0, ..white() };
    let lambert = Lobe::Lambert(Lambert { albedo: grey });
    assert_same("matte", &matte.into(), &lambert.into(), 1e-4);
    let clay = PrincipledParameters { diffuse_roughness: 0.8, ..matte };
    let lobe = Lobe::OrenNayar(OrenNayar::new(grey, 0.8));
    assert_same("clay", &clay.into(), &lobe.into(), 1e-4);

    let glass = PrincipledParameters { transmission: 1.0, roughness: 0.0, ..white() };
    for eta in [1.5, 2.4, 1.0 / 1.33, 1.0] {
        let lobe = Lobe::Dielectric(SmoothDielectric { eta, fresnel: Fresnel::Exact });
        assert_same("glass", &PrincipledParameters { eta, ..glass }.into(), &lobe.into(), 1e-4);
    }
    for (eta, roughness) in [(1.5, 0.3), (1.33, 0.8), (1.0 / 1.5, 0.5)] {
        let frosted = PrincipledParameters { eta, roughness, ..glass };
        let lobe = Lobe::RoughDielectric(RoughDielectric::new(eta, roughness).unwrap());
        assert_same("frosted glass", &frosted.into(), &lobe.into(), 0.02);
    }

    for roughness in [0.2, 0.6, 1.0] {
        let metal = PrincipledParameters { metallic: 1.0, roughness, ..white() };
        let lobe = RoughConductor::new(Spectrum::BLACK, Spectrum::WHITE, roughness).unwrap();
        assert_same("white metal", &metal.into(), &Lobe::RoughConductor(lobe).into(), 0.02);

        // An index with this reflection at normal incidence (Gulbrandsen 2014).
        let eta = grey.map(|r| (1.0 - r) / (1.0 + r));
        let k = grey.map(|r| 2.0 * r.sqrt() / (1.0 + r));
        let metal = Bsdf::from(PrincipledParameters { base_color: grey, ..metal });
        let lobe =
            Bsdf::from(Lobe::RoughConductor(RoughConductor::new(eta, k, roughness).unwrap()));
        for wo in directions(&[10.0, 40.0]) {
            let [(a, _), (b, _)] = [metal, lobe].map(|m| furnace(&m, wo, 1 << 14, well_spread));
            for (a, b) in a.into_iter().zip(b) {
                assert!((a - b).abs() < 0.06, "metal of roughness {roughness} at {wo}: {a} {b}");
            }
        }
    }
}

/// Turning the tangent turns the highlight, and a quarter turn exchanges the two ways.
#[test]
fn the_tangent_turns_the_highlight() {
    let brushed = |anisotropy_rotation| {
        let metal =
            PrincipledParameters { metallic: 1.0, anisotropy: 0.7, anisotropy_rotation, ..white() };
        Bsdf::from(metal)
    };
    let turned = |w: Vec3, by: f32| {
        let (s, c) = rutilant::geom::real::sin_cos(by);
        Vec3::new(c * w.x - s * w.y, s * w.x + c * w.y, w.z)
    };
    for by in [0.3, 1.570_796_4, 2.5] {
        for wo in directions(&[20.0, 60.0]) {
            for wi in directions(&[10.0, 50.0]) {
                let a = brushed(0.0).eval_cos(wo, wi).max_channel();
                let b = brushed(by).eval_cos(turned(wo, by), turned(wi, by)).max_channel();
                assert!((a - b).abs() < 1e-3 * a.max(1e-3), "{by}: {a} {b}");
            }
        }
    }
    // Along the tangent the highlight is wide, across it is narrow.
    let tilted = |x: f32, y: f32| Vec3::new(x, y, 1.0).normalize();
    let along = brushed(0.0).eval_cos(Vec3::Z, tilted(0.5, 0.0)).max_channel();
    let across = brushed(0.0).eval_cos(Vec3::Z, tilted(0.0, 0.5)).max_channel();
    assert!(along > 5.0 * across, "{along} {across}");
}

/// Numbers from outside their ranges, and no numbers at all, end in numbers or in none, never in a
/// panic: textures are not to be trusted.
#[test]
fn no_numbers_panic() {
    for wrong in [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e30] {
        let color = Spectrum::splat(wrong);
        let usual = white();
        for parameters in [
            PrincipledParameters { base_color: color, ..usual },
            PrincipledParameters { metallic: wrong, ..usual },
            PrincipledParameters { roughness: wrong, ..usual },
            PrincipledParameters { anisotropy: wrong, anisotropy_rotation: wrong, ..usual },
            PrincipledParameters { eta: wrong, transmission: 1.0, ..usual },
            PrincipledParameters { coat: wrong, coat_roughness: wrong, coat_ior: wrong, ..usual },
            PrincipledParameters { sheen_color: color, sheen_roughness: wrong, ..usual },
            PrincipledParameters {
                iridescence: 1.0,
                iridescence_ior: wrong,
                iridescence_thickness_nm: wrong,
                ..usual
            },
        ] {
            let bsdf = Bsdf::from(parameters);
            for wo in directions(&[0.0, 60.0, 130.0]) {
                for i in 0..20 {
                    let (choice, u) = random(1, i);
                    let _ = bsdf.sample(wo, choice, u);
                    let _ = bsdf.eval_cos_pdf(wo, Vec3::Z);
                }
            }
            let _ = bsdf.albedo();
        }
    }
}
