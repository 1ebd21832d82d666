//! Proofs about the layers of principled surfaces, beside those over all BSDFs in `bsdf.rs`.
//!
//! `RUTILANT_SETS=500 cargo test --release -p rutilant --test principled` puts so many random
//! surfaces into the furnace; without it there are 24.

mod common;

use common::{chi_square, directions, family_wise, random, well_spread};
use rutilant::bsdf::{
    Bsdf, Fresnel, Lambert, Lobe, OrenNayar, PrincipledParameters, RoughConductor,
    RoughDielectric, SmoothDielectric,
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

/// Every slab, alone and over the others, at several roughnesses; nothing absorbs.
fn white_surfaces() -> Vec<(String, PrincipledParameters)> {
    let mut all = Vec::new();
    for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
        let p = PrincipledParameters { roughness, ..white() };
        let mut add = |name: &str, p: PrincipledParameters| {
            all.push((format!("{name}, roughness {roughness}"), p));
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
            let stretched = |p| PrincipledParameters { anisotropy, ..p };
            add(&format!("brushed plastic {anisotropy}"), stretched(p));
            add(
                &format!("brushed metal {anisotropy}"),
                stretched(PrincipledParameters { metallic: 1.0, ..p }),
            );
            add(&format!("brushed pane {anisotropy}"), stretched(thin));
            add(&format!("brushed glass {anisotropy}"), stretched(glass));
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
/// up to a tenth of a degree from the surface: what one layer takes, the next one gets.
#[test]
fn white_layers_vanish_in_the_furnace() {
    let mut worst = (0.0, String::new());
    for (name, parameters) in white_surfaces() {
        let bsdf = Bsdf::from(parameters);
        for wo in directions(&[0.0, 45.0, 70.0, 85.0, 89.0, 110.0, 150.0]).into_iter().step_by(2) {
            let (mean, error) = furnace(&bsdf, wo, 1 << 13, well_spread);
            let off = (mean[0] - 1.0).abs() - error[0];
            if off > 0.006 {
                println!("{:+.4} ± {:.4} {name} at {wo}", mean[0] - 1.0, error[0]);
            }
            if off > worst.0 {
                worst = (off, format!("{name} at {wo}: {mean:?} ± {error:?}"));
            }
        }
    }
    println!("off by {} at worst: {}", worst.0, worst.1);
    assert!(worst.0 < 0.01, "off by {}: {}", worst.0, worst.1);
}
