//! Materials as they meet light: from what the author wrote to BSDFs and borders between media.

use crate::bsdf::{
    Bsdf, Fresnel, Lambert, Lobe, OrenNayar, PerfectMirror, RoughConductor, RoughDielectric,
    SmoothConductor, SmoothDielectric, ThinDielectric, UniformLambert,
};
use crate::color::Spectrum;
use crate::material::{CustomMaterial, Dielectric, HemisphereSampling, Material, MaterialKind};
use crate::medium::{Border, PreparedMedium};
use crate::scene::MaterialId;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A material as it meets light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedMaterial {
    pub(crate) bsdf: Bsdf,
    /// Set where light can cross the surface.
    pub(crate) border: Option<Border>,
    /// The number of the custom material that tells the BSDF of each place.
    pub(super) custom: Option<u32>,
    /// True where rays go on as if there were nothing.
    pub(crate) passes: bool,
}

impl From<Bsdf> for PreparedMaterial {
    /// A surface that light does not cross.
    fn from(bsdf: Bsdf) -> Self {
        Self { bsdf, border: None, custom: None, passes: false }
    }
}

impl PreparedMaterial {
    /// The number of its medium among those with a priority.
    pub(super) fn rank(&self) -> Option<u32> {
        self.border.and_then(|b| b.rank)
    }

    /// True where more than the material decides what the surface does to light.
    pub(crate) fn depends_on_place(&self) -> bool {
        self.custom.is_some() || self.passes || self.rank().is_some()
    }

    /// The same as a border between the media that it lies between at some place.
    pub(crate) fn between(&self, here: Border) -> Self {
        let eta = here.interior.ior / here.exterior.ior;
        Self { bsdf: self.bsdf.with_eta(eta), border: Some(here), ..*self }
    }
}

/// True where rays go on as if there were no surface.
pub(super) fn passes(material: &Material) -> bool {
    match material.kind {
        MaterialKind::Null => true,
        MaterialKind::Black
        | MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::Dielectric(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Principled(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => false,
    }
}

/// All materials as they meet light, and the custom ones among them.
pub(super) fn prepare_materials(
    all: &[Material],
) -> (Vec<PreparedMaterial>, Vec<Arc<dyn CustomMaterial>>) {
    // The strongest first; of equally strong ones the first.
    let priority = |m: &Material| match &m.kind {
        MaterialKind::Dielectric(Dielectric { priority, .. }) => *priority,
        MaterialKind::Principled(p) => p.priority,
        MaterialKind::Black
        | MaterialKind::Matte(_)
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Null
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
    };
    let mut ranked: Vec<(u32, usize)> = all
        .iter()
        .enumerate()
        .filter_map(|(i, m)| priority(m).map(|p| (u32::MAX - p, i)))
        .collect();
    ranked.sort_unstable();
    let ranks: BTreeMap<usize, u32> =
        ranked.iter().zip(0..).map(|((_, i), rank)| (*i, rank)).collect();

    let mut customs = Vec::new();
    let prepare = |(i, material): (usize, &Material)| {
        let mut prepared = PreparedMaterial::from(lobe(material).map_or(Bsdf::BLACK, Bsdf::from));
        match &material.kind {
            MaterialKind::Black
            | MaterialKind::Matte(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Conductor(_)
            | MaterialKind::ThinDielectric(_) => {}
            MaterialKind::Null => prepared.passes = true,
            MaterialKind::Principled(p) => {
                prepared.bsdf = p.parameters().into();
                if p.has_inside() {
                    let absorption = p.absorption.coefficient();
                    // What only a matte body sends on is not bent.
                    let ior = if p.transmission > 0.0 { p.ior } else { 1.0 };
                    prepared.border = Some(Border {
                        interior: PreparedMedium { ior, absorption },
                        exterior: PreparedMedium { ior: 1.0, absorption: Spectrum::BLACK },
                        material: i as u32,
                        rank: ranks.get(&i).copied(),
                    });
                }
            }
            MaterialKind::Dielectric(d) => {
                let medium = |m: &crate::material::Medium| PreparedMedium {
                    ior: m.ior,
                    absorption: m.absorption.coefficient(),
                };
                let (interior, exterior) = (medium(&d.interior), medium(&d.exterior));
                let rank = ranks.get(&i).copied();
                prepared.border = Some(Border { interior, exterior, material: i as u32, rank });
            }
            MaterialKind::Mix(mix) => {
                let part =
                    |id: MaterialId, share: f32| lobe(&all[id.0 as usize]).map(|l| (share, l));
                let parts = [part(mix.first, 1.0 - mix.amount), part(mix.second, mix.amount)];
                prepared.bsdf = Bsdf::sum(parts.into_iter().flatten());
            }
            MaterialKind::Custom(custom) => {
                prepared.custom = Some(customs.len() as u32);
                customs.push(Arc::clone(custom));
            }
        }
        prepared
    };
    let materials = all.iter().enumerate().map(prepare).collect();
    (materials, customs)
}

/// The lobe of a material that has just one.
fn lobe(material: &Material) -> Option<Lobe> {
    match &material.kind {
        MaterialKind::Black
        | MaterialKind::Principled(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
        // What passes unscattered crosses a border between equal media.
        MaterialKind::Null => {
            Some(Lobe::Dielectric(SmoothDielectric { eta: 1.0, fresnel: Fresnel::Exact }))
        }
        MaterialKind::Matte(m) if m.roughness == 0.0 => {
            let albedo = m.albedo.into();
            Some(match m.sampling {
                HemisphereSampling::Cosine => Lobe::Lambert(Lambert { albedo }),
                HemisphereSampling::Uniform => Lobe::UniformLambert(UniformLambert { albedo }),
            })
        }
        MaterialKind::Matte(m) => {
            Some(Lobe::OrenNayar(OrenNayar::new(m.albedo.into(), m.roughness)))
        }
        MaterialKind::Mirror(m) => {
            Some(Lobe::Mirror(PerfectMirror { reflectance: m.reflectance.into() }))
        }
        MaterialKind::Conductor(m) => {
            let (eta, k) = (m.eta.into(), m.k.into());
            let rough = RoughConductor::new(eta, k, m.roughness).map(Lobe::RoughConductor);
            Some(rough.unwrap_or(Lobe::Conductor(SmoothConductor { eta, k })))
        }
        MaterialKind::Dielectric(m) => {
            let eta = m.interior.ior / m.exterior.ior;
            let rough = RoughDielectric::new(eta, m.roughness).map(Lobe::RoughDielectric);
            let fresnel = m.fresnel;
            Some(rough.unwrap_or(Lobe::Dielectric(SmoothDielectric { eta, fresnel })))
        }
        MaterialKind::ThinDielectric(m) => {
            Some(Lobe::ThinDielectric(ThinDielectric::new(m.ior, m.color.into())))
        }
    }
}
