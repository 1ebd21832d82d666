//! Materials that scatter otherwise in different places.

use super::prepared::Prepared;
use super::texture::{PreparedTextures, SoughtColor, TexturePlace};
use crate::bsdf::{Bsdf, Lambert, Lobe, OrenNayar, UniformLambert};
use crate::color::Spectrum;
use crate::interaction::SurfaceInteraction;
use crate::material::{CustomMaterial, HemisphereSampling, Matte, Principled, SurfacePoint};
use crate::texture::{ColorInput, ScalarInput};
use rutilant_geom::{Frame, Hit, Vec2, real};
use std::sync::Arc;

/// How a material scatters, told for each place.
#[derive(Clone, Debug)]
pub(super) enum Varying {
    /// As others say.
    Custom(Arc<dyn CustomMaterial>),
    /// By weighted lobes.
    Lobes([Option<(f32, VaryingLobe)>; Bsdf::MAX_LOBES]),
    /// By layers.
    Principled(Box<Principled>),
}

/// One way of scattering.
#[derive(Clone, Copy, Debug)]
pub(super) enum VaryingLobe {
    /// The same everywhere.
    Fixed(Lobe),
    /// Diffuse.
    Matte(Matte),
}

impl VaryingLobe {
    /// Whether it is another in different places.
    pub(super) fn varies(&self) -> bool {
        match self {
            Self::Fixed(_) => false,
            Self::Matte(matte) => matte.albedo.varies(),
        }
    }

    /// As it is in the mean.
    pub(super) fn mean(&self, textures: &PreparedTextures) -> Lobe {
        match self {
            Self::Fixed(lobe) => *lobe,
            Self::Matte(matte) => matte_lobe(matte, textures.mean_reflectance(&matte.albedo)),
        }
    }

    fn at(&self, textures: &PreparedTextures, place: &TexturePlace<'_>) -> Lobe {
        match self {
            Self::Fixed(lobe) => *lobe,
            Self::Matte(matte) => matte_lobe(matte, textures.reflectance(&matte.albedo, place)),
        }
    }
}

/// A matte surface whose albedo is known.
fn matte_lobe(matte: &Matte, albedo: Spectrum) -> Lobe {
    match matte.sampling {
        _ if matte.roughness > 0.0 => Lobe::OrenNayar(OrenNayar::new(albedo, matte.roughness)),
        HemisphereSampling::Cosine => Lobe::Lambert(Lambert { albedo }),
        HemisphereSampling::Uniform => Lobe::UniformLambert(UniformLambert { albedo }),
    }
}

impl Prepared {
    /// How the varying material of this number scatters where it was hit. `own_coat` says whether
    /// its coat has another normal than what is below it.
    pub(super) fn varied_bsdf(
        &self,
        number: u32,
        hit: &Hit,
        at: &SurfaceInteraction,
        own_coat: bool,
    ) -> Bsdf {
        match &self.varying[number as usize] {
            Varying::Custom(custom) => {
                let uv = self.uv(hit);
                custom.bsdf(&SurfacePoint { position: hit.position, normal: hit.normal, uv })
            }
            Varying::Principled(principled) => {
                let place = TexturePlace::new(self, self.object(hit), hit);
                let color = |factor, texture, vertex_colors| {
                    let input = ColorInput { factor, texture, vertex_colors };
                    self.textures.color(&input, &place)
                };
                let scalar = |factor, texture| {
                    self.textures.scalar(&ScalarInput { factor, texture }, &place)
                };
                let mut parameters = principled.varied(color, scalar);
                let mut frame = at.shading;
                if own_coat {
                    let normal_map = self.materials[at.material as usize].normal_map;
                    parameters.normal = self.layer_normal(normal_map, hit, at);
                    parameters.coat_normal = self.layer_normal(principled.coat_normal_map, hit, at);
                    let own = Frame::around(parameters.normal);
                    frame = Frame {
                        x: frame.to_world(own.x),
                        y: frame.to_world(own.y),
                        z: frame.to_world(own.z),
                    };
                }
                if principled.is_anisotropic() {
                    let turned = self.tangent_angle(principled, hit, &frame, &place);
                    parameters.anisotropy_rotation = turned;
                }
                parameters.into()
            }
            Varying::Lobes(lobes) => {
                let place = TexturePlace::new(self, self.object(hit), hit);
                let lobes = lobes.iter().flatten();
                Bsdf::sum(lobes.map(|(weight, lobe)| (*weight, lobe.at(&self.textures, &place))))
            }
        }
    }

    /// Where the tangent of facets lies, in radians from the x axis of the `shading` frame towards
    /// its y axis: `KHR_materials_anisotropy`.
    fn tangent_angle(
        &self,
        principled: &Principled,
        hit: &Hit,
        shading: &Frame,
        place: &TexturePlace<'_>,
    ) -> f32 {
        let direction = principled.textures.anisotropy_direction.map_or(Vec2::X, |texture| {
            let [x, y, ..] = self.textures.rgba(texture, place);
            Vec2::new(2.0 * x - 1.0, 2.0 * y - 1.0).normalize_or(Vec2::X)
        });
        let (s, c) = real::sin_cos(principled.anisotropy_rotation);
        let turned =
            Vec2::new(c * direction.x - s * direction.y, s * direction.x + c * direction.y);
        let local = match self.directions(hit, self.object(hit), shading.z) {
            Some((u, v)) => shading.to_local(u * turned.x + v * turned.y).truncate(),
            None => turned,
        };
        real::atan2(local.y, local.x)
    }

    /// The albedo of the varying material of this number, if it does nothing but scatter as Lambert's
    /// law says.
    #[inline]
    pub(super) fn varied_lambert(&self, number: u32) -> Option<&ColorInput> {
        let Varying::Lobes([Some((1.0, VaryingLobe::Matte(matte))), None]) =
            &self.varying[number as usize]
        else {
            return None;
        };
        let cosine = matte.sampling == HemisphereSampling::Cosine;
        (matte.roughness == 0.0 && cosine).then_some(&matte.albedo)
    }

    /// What a colour is made of where a surface was hit.
    #[inline]
    pub(crate) fn seek_color(&self, input: &ColorInput, hit: &Hit) -> SoughtColor<'_> {
        self.textures.seek(input, &TexturePlace::new(self, self.object(hit), hit))
    }
}
