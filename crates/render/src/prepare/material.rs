//! Materials as they meet light: from what the author wrote to BSDFs and borders between media.

use super::texture::PreparedTextures;
use super::varying::{Varying, VaryingLobe};
use crate::bsdf::{
    Bsdf, Fresnel, Lobe, PerfectMirror, RoughConductor, RoughDielectric, SmoothConductor,
    SmoothDielectric, ThinDielectric,
};
use crate::color::Spectrum;
use crate::dispersion::{BANDS, Bands};
use crate::material::{Dielectric, Material, MaterialKind, NormalMap, Opacity};
use crate::medium::{Border, PreparedMedium};
use crate::scene::MaterialId;
use crate::texture::ColorInput;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A material as it meets light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedMaterial {
    /// How it scatters; in the mean, where it varies.
    pub(crate) bsdf: Bsdf,
    /// Its albedo, where it is the same everywhere.
    pub(super) albedo: Option<Spectrum>,
    /// Set where light can cross the surface.
    pub(crate) border: Option<Border>,
    /// The number of its BSDFs for each band of the spectrum, where it bends them differently, and
    /// they are known beforehand.
    pub(super) dispersed: Option<u32>,
    /// The number of what tells the BSDF of each place, where that is not the same everywhere.
    pub(super) varying: Option<u32>,
    /// The number of what tells how much of it is there, where that is not all.
    pub(super) opacity: Option<u32>,
    /// What turns its normals.
    pub(super) normal_map: Option<NormalMap>,
    /// What its light varies by.
    pub(super) glow: Option<ColorInput>,
    /// True where a coat has another normal than what is below it.
    pub(super) own_coat: bool,
    /// True where rays go on as if there were nothing.
    pub(crate) passes: bool,
    /// True where rays that come from behind do so.
    pub(crate) one_sided: bool,
}

impl From<Bsdf> for PreparedMaterial {
    /// A surface that light does not cross.
    fn from(bsdf: Bsdf) -> Self {
        Self {
            bsdf,
            albedo: None,
            border: None,
            dispersed: None,
            varying: None,
            opacity: None,
            normal_map: None,
            glow: None,
            own_coat: false,
            passes: false,
            one_sided: false,
        }
    }
}

impl PreparedMaterial {
    /// About what part of white light is sent on.
    pub(crate) fn albedo(&self) -> Spectrum {
        self.albedo.unwrap_or_else(|| self.bsdf.albedo())
    }

    /// The number of its medium among those with a priority.
    pub(super) fn rank(&self) -> Option<u32> {
        self.border.and_then(|b| b.rank)
    }

    /// True where a picture tells its normals, pictures or vertices its light, or a coat has normals of its own.
    pub(super) fn is_painted(&self) -> bool {
        self.normal_map.is_some() || self.glow.is_some() || self.own_coat
    }

    /// True where light paths go on in single directions. What has only a front they pass, and a coat
    /// with normals of its own would send them elsewhere than paths from the camera.
    pub(super) fn casts(&self) -> bool {
        self.bsdf.has_delta() && !self.one_sided && !self.own_coat
    }

    /// True where it scatters otherwise in different places.
    pub(crate) fn varies(&self) -> bool {
        self.varying.is_some()
    }

    /// True where more than the material decides what the surface does to light.
    pub(crate) fn depends_on_place(&self) -> bool {
        self.varying.is_some() || self.passes || self.rank().is_some()
    }

    /// True where a path does not go from one surface to the next by the material alone.
    pub(super) fn bends_the_way(&self) -> bool {
        self.passes || self.rank().is_some()
    }

    /// The same as a border between the media that it lies between at some place.
    pub(crate) fn between(&self, here: Border) -> Self {
        let eta = here.interior.ior / here.exterior.ior;
        let bsdf = self.bsdf.with_eta(eta);
        Self { bsdf, albedo: None, border: Some(here), dispersed: None, ..*self }
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

/// All materials as they meet light, what tells more of those that vary, and how much is there of
/// those that are not everywhere.
pub(super) fn prepare_materials(
    all: &[Material],
    textures: &PreparedTextures,
) -> (Vec<PreparedMaterial>, Vec<Varying>, Vec<Opacity>) {
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

    let (mut varying, mut opacities) = (Vec::new(), Vec::new());
    let prepare = |(i, material): (usize, &Material)| {
        let lobes = match &material.kind {
            MaterialKind::Mix(mix) => {
                let part =
                    |id: MaterialId, share: f32| lobe(&all[id.0 as usize]).map(|l| (share, l));
                [part(mix.first, 1.0 - mix.amount), part(mix.second, mix.amount)]
            }
            MaterialKind::Black
            | MaterialKind::Matte(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Conductor(_)
            | MaterialKind::ThinDielectric(_)
            | MaterialKind::Null
            | MaterialKind::Dielectric(_)
            | MaterialKind::Principled(_)
            | MaterialKind::Custom(_) => [lobe(material).map(|lobe| (1.0, lobe)), None],
        };
        let mean = lobes.iter().flatten().map(|(weight, lobe)| (*weight, lobe.mean(textures)));
        let mut prepared = PreparedMaterial {
            normal_map: material.normal_map,
            glow: material.emission.and_then(|emission| emission.variation()),
            opacity: material.opacity.map(|opacity| push(&mut opacities, opacity)),
            one_sided: material.is_one_sided(all),
            ..PreparedMaterial::from(Bsdf::sum(mean))
        };
        let mut vary = |what| Some(push(&mut varying, what));
        if lobes.iter().flatten().any(|(_, lobe)| lobe.varies()) {
            prepared.varying = vary(Varying::Lobes(lobes));
        }
        match &material.kind {
            MaterialKind::Black
            | MaterialKind::Matte(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Conductor(_)
            | MaterialKind::ThinDielectric(_)
            | MaterialKind::Mix(_) => {}
            MaterialKind::Null => prepared.passes = true,
            MaterialKind::Principled(p) => {
                prepared.bsdf = textures.mean_principled(p).into();
                prepared.own_coat = p.has_own_coat_normal(material.normal_map.is_some());
                if p.textures.vary() || p.is_anisotropic() || prepared.own_coat {
                    prepared.varying = vary(Varying::Principled(p.clone()));
                }
                if p.has_inside() {
                    let absorption = p.absorption.coefficient();
                    // What only a matte body sends on is not bent.
                    let bent = p.transmission > 0.0;
                    let (ior, dispersion) = if bent { (p.ior, p.dispersion) } else { (1.0, 0.0) };
                    prepared.border = Some(Border {
                        interior: PreparedMedium { ior, dispersion, absorption },
                        exterior: PreparedMedium {
                            ior: 1.0,
                            dispersion: 0.0,
                            absorption: Spectrum::BLACK,
                        },
                        material: i as u32,
                        rank: ranks.get(&i).copied(),
                    });
                }
            }
            MaterialKind::Dielectric(d) => {
                let medium = |m: &crate::material::Medium, dispersion| PreparedMedium {
                    ior: m.ior,
                    dispersion,
                    absorption: m.absorption.coefficient(),
                };
                let interior = medium(&d.interior, d.dispersion);
                let exterior = medium(&d.exterior, 0.0);
                let rank = ranks.get(&i).copied();
                prepared.border = Some(Border { interior, exterior, material: i as u32, rank });
            }
            MaterialKind::Custom(custom) => {
                prepared.varying = vary(Varying::Custom(Arc::clone(custom)));
            }
        }
        prepared.albedo = prepared.varying.is_none().then(|| prepared.bsdf.albedo());
        prepared
    };
    let materials = all.iter().enumerate().map(prepare).collect();
    (materials, varying, opacities)
}

/// The bands of the spectrum, where a material bends them differently, and the BSDFs for each of
/// the materials that are the same everywhere, whose numbers they are given.
pub(super) fn disperse(materials: &mut [PreparedMaterial]) -> Option<(Bands, Vec<[Bsdf; BANDS]>)> {
    let disperses = |m: &PreparedMaterial| m.border.is_some_and(|border| border.disperses());
    if !materials.iter().any(disperses) {
        return None;
    }
    let (bands, mut dispersed) = (Bands::new(), Vec::new());
    for material in materials {
        // Of media with a priority only the place knows what is on both sides.
        let known = material.varying.is_none() && material.rank().is_none();
        if let Some(border) = material.border.filter(|border| border.disperses() && known) {
            let mut all = [material.bsdf; BANDS];
            for (bsdf, band) in all.iter_mut().zip(bands.iter()) {
                *bsdf = material.bsdf.with_eta(border.eta_at(band.wavelength_nm));
            }
            material.dispersed = Some(push(&mut dispersed, all));
        }
    }
    Some((bands, dispersed))
}

/// Adds an item, and gives its number.
fn push<T>(items: &mut Vec<T>, item: T) -> u32 {
    items.push(item);
    (items.len() - 1) as u32
}

/// The lobe of a material that has just one.
fn lobe(material: &Material) -> Option<VaryingLobe> {
    let lobe = match &material.kind {
        MaterialKind::Matte(matte) => return Some(VaryingLobe::Matte(*matte)),
        MaterialKind::Black
        | MaterialKind::Principled(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
        // What passes unscattered crosses a border between equal media.
        MaterialKind::Null => {
            Some(Lobe::Dielectric(SmoothDielectric { eta: 1.0, fresnel: Fresnel::Exact }))
        }
        MaterialKind::Mirror(m) => {
            Some(Lobe::Mirror(PerfectMirror { reflectance: m.reflectance.into() }))
        }
        MaterialKind::Conductor(m) => {
            let (eta, k) = (m.eta.into(), m.k.into());
            let rough = RoughConductor::with(m.distribution, eta, k, m.roughness);
            let smooth = Lobe::Conductor(SmoothConductor { eta, k });
            Some(rough.map_or(smooth, Lobe::RoughConductor))
        }
        MaterialKind::Dielectric(m) => {
            let eta = m.interior.ior / m.exterior.ior;
            let rough = RoughDielectric::with(m.distribution, eta, m.roughness);
            let smooth = Lobe::Dielectric(SmoothDielectric { eta, fresnel: m.fresnel });
            Some(rough.map_or(smooth, Lobe::RoughDielectric))
        }
        MaterialKind::ThinDielectric(m) => {
            Some(Lobe::ThinDielectric(ThinDielectric::new(m.ior, m.color.into())))
        }
    };
    lobe.map(VaryingLobe::Fixed)
}
