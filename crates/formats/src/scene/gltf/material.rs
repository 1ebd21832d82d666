//! Materials: the metallic-roughness model and the ratified extensions to it.
//!
//! Everything is kept in the words of the specifications: factors, and textures
//! that multiply them. Which channels of a texture count, and whether they are
//! stored as sRGB, is said with each. Factors outside their ranges are moved to
//! the end of the range, with a note.
//!
//! Sources: Khronos Group, *glTF 2.0 Specification*, 2021, section 3.9, and the
//! extensions `KHR_materials_…` named below.

use super::entry::{Entry, Result};
use super::texture::{TextureRef, texture_ref};
use rutilant::material::{MAX_DISPERSION, MAX_FILM_NM, MAX_IOR, MAX_SPECULAR_COLOR};
use rutilant::scene::MOST_LIGHT;

/// How alpha counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Not at all.
    #[default]
    Opaque,
    /// What is less than the cutoff is not there, all else is.
    Mask {
        /// At least 0; above 1 nothing is there.
        cutoff: f32,
    },
    /// The part of the surface that is there.
    Blend,
}

/// A material. Without any key it is white, rough metal.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// What the author calls it; may be empty.
    pub name: String,
    /// Base colour, scene-linear, and alpha; each in [0, 1].
    pub base_color: [f32; 4],
    /// Times the base colour: RGB as sRGB, A linear.
    pub base_color_texture: Option<TextureRef>,
    /// From 0, not a metal, to 1.
    pub metallic: f32,
    /// Perceptual roughness in [0, 1]; α of GGX is its square.
    pub roughness: f32,
    /// Times roughness (G) and metallic (B), linear.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normals, linear: RGB in [0, 1] stand for [-1, 1].
    pub normal_texture: Option<TextureRef>,
    /// Times x and y of those normals, before they are normalised.
    pub normal_scale: f32,
    /// Ambient occlusion (R, linear). Path tracing finds it by itself.
    pub occlusion_texture: Option<TextureRef>,
    /// How much of the occlusion counts, in [0, 1].
    pub occlusion_strength: f32,
    /// Emitted radiance, scene-linear, at least 0: to be multiplied by `emissive_strength`.
    pub emissive: [f32; 3],
    /// Times the emitted radiance, as sRGB.
    pub emissive_texture: Option<TextureRef>,
    /// `KHR_materials_emissive_strength`: at least 0; 1 if not given.
    pub emissive_strength: f32,
    /// How alpha counts.
    pub alpha: Alpha,
    /// Whether it is seen from behind as well, with the normal turned.
    pub double_sided: bool,
    /// `KHR_materials_unlit`: shown in its base colour, whatever the light.
    pub unlit: bool,
    /// `KHR_materials_ior`: the index of refraction, at least 1, or 0 for mirrors whose
    /// reflection at normal incidence is the specular colour alone; 1.5 if not given.
    pub ior: f32,
    /// `KHR_materials_specular`.
    pub specular: Specular,
    /// `KHR_materials_transmission`; `None` where light does not pass.
    pub transmission: Option<Transmission>,
    /// `KHR_materials_volume`; `None` where walls are infinitely thin.
    pub volume: Option<Volume>,
    /// `KHR_materials_dispersion`: 20 divided by the Abbe number, at least 0.
    pub dispersion: f32,
    /// `KHR_materials_clearcoat`.
    pub clearcoat: Option<Clearcoat>,
    /// `KHR_materials_sheen`.
    pub sheen: Option<Sheen>,
    /// `KHR_materials_anisotropy`.
    pub anisotropy: Option<Anisotropy>,
    /// `KHR_materials_iridescence`.
    pub iridescence: Option<Iridescence>,
    /// `KHR_materials_diffuse_transmission`, a release candidate when this was written.
    pub diffuse_transmission: Option<DiffuseTransmission>,
    /// `KHR_materials_pbrSpecularGlossiness`, archived: see [`SpecularGlossiness`].
    pub specular_glossiness: Option<SpecularGlossiness>,
}

/// What is reflected by the surface of what is no metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specular {
    /// Times all of it, in [0, 1].
    pub strength: f32,
    /// Times the strength (A, linear).
    pub strength_texture: Option<TextureRef>,
    /// Times the reflection at normal incidence; may exceed 1, the product not.
    pub color: [f32; 3],
    /// Times the colour, as sRGB.
    pub color_texture: Option<TextureRef>,
}

/// Light that passes the surface, instead of being scattered back below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// The part of it, in [0, 1].
    pub factor: f32,
    /// Times the factor (R, linear).
    pub texture: Option<TextureRef>,
}

/// What is inside of a closed surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Thickness below the surface in the mesh's own units, for renderers that do not trace
    /// rays: here it says only whether there is an inside (above 0) or a thin wall (0).
    pub thickness: f32,
    /// Times the thickness (G, linear).
    pub thickness_texture: Option<TextureRef>,
    /// Metres of the world after which white light has the attenuation colour; infinite where
    /// nothing is absorbed.
    pub attenuation_distance: f32,
    /// What is left of white light after that distance, in [0, 1].
    pub attenuation_color: [f32; 3],
}

/// A clear layer above everything else, of index 1.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearcoat {
    /// How much of it there is, in [0, 1].
    pub factor: f32,
    /// Times the factor (R, linear).
    pub texture: Option<TextureRef>,
    /// Perceptual roughness, in [0, 1].
    pub roughness: f32,
    /// Times the roughness (G, linear).
    pub roughness_texture: Option<TextureRef>,
    /// Its own normals; where there are none, it is as smooth as the mesh.
    pub normal_texture: Option<TextureRef>,
    /// Times x and y of those normals.
    pub normal_scale: f32,
}

/// Fibres above everything but a clear coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheen {
    /// Reflection at grazing angles, in [0, 1].
    pub color: [f32; 3],
    /// Times the colour, as sRGB.
    pub color_texture: Option<TextureRef>,
    /// Perceptual roughness, in [0, 1].
    pub roughness: f32,
    /// Times the roughness (A, linear).
    pub roughness_texture: Option<TextureRef>,
}

/// Scratches in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anisotropy {
    /// From 0, none, to 1: α along the direction is mixed from α towards 1 by its square.
    pub strength: f32,
    /// Radians from the tangent, counter-clockwise, of the direction with the larger α.
    pub rotation: f32,
    /// Direction (RG, in [-1, 1] around 0.5) to be turned by `rotation`, and a factor to the
    /// strength (B); linear.
    pub texture: Option<TextureRef>,
}

/// A film that is as thin as a wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iridescence {
    /// How much of it there is, in [0, 1].
    pub factor: f32,
    /// Times the factor (R, linear).
    pub texture: Option<TextureRef>,
    /// Index of refraction of the film, at least 1.
    pub ior: f32,
    /// Thickness in nanometres where the texture is 0; without a texture not used.
    pub thickness_minimum_nm: f32,
    /// Thickness in nanometres where the texture is 1, or everywhere without one.
    pub thickness_maximum_nm: f32,
    /// Mixes minimum and maximum (G, linear).
    pub thickness_texture: Option<TextureRef>,
}

/// Light that is scattered through a thin surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// The part of scattered light that passes, in [0, 1].
    pub factor: f32,
    /// Times the factor (A, linear).
    pub texture: Option<TextureRef>,
    /// The colour of what passes, in [0, 1].
    pub color: [f32; 3],
    /// Times the colour, as sRGB.
    pub color_texture: Option<TextureRef>,
}

/// The older model of a diffuse and a specular colour.
///
/// The core factors of its [`Material`] have been set to mean the same: the
/// base colour is the diffuse one, nothing is metal, `ior` is 0 and
/// `specular.color` the specular colour, the roughness is what glossiness lacks
/// to 1 (as the appendix of `KHR_materials_specular` has it). Base colour and
/// specular colour have their textures there too. Only gloss from a texture
/// cannot be told so: where there is a texture here, roughness is
/// `1 - glossiness * A`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecularGlossiness {
    /// In [0, 1]: what is not rough.
    pub glossiness: f32,
    /// Times the specular colour (RGB as sRGB) and glossiness (A, linear).
    pub texture: Option<TextureRef>,
}

const UNIT: [f32; 2] = [0.0, 1.0];
const POSITIVE: [f32; 2] = [0.0, f32::MAX];
const LIGHT: [f32; 2] = [0.0, MOST_LIGHT];
const FILM: [f32; 2] = [0.0, MAX_FILM_NM];

/// A material of a document with so many textures.
pub(super) fn material(entry: &Entry<'_, '_>, textures: usize) -> Result<Material> {
    let texture = |entry: &Entry<'_, '_>, key| texture_ref(entry, key, textures);
    let scale = |entry: &Entry<'_, '_>, key, scale, range| match entry.get(key)? {
        Some(texture) => texture.factor(scale, 1.0, range),
        None => Ok(1.0),
    };
    let any = [f32::MIN, f32::MAX];
    let mut material = Material {
        name: entry.name()?,
        base_color: [1.0; 4],
        base_color_texture: None,
        metallic: 1.0,
        roughness: 1.0,
        metallic_roughness_texture: None,
        normal_texture: texture(entry, "normalTexture")?,
        normal_scale: scale(entry, "normalTexture", "scale", any)?,
        occlusion_texture: texture(entry, "occlusionTexture")?,
        occlusion_strength: scale(entry, "occlusionTexture", "strength", UNIT)?,
        // More than 1 is against the letter, but was written before strengths existed.
        emissive: entry.factors("emissiveFactor", [0.0; 3], LIGHT)?,
        emissive_texture: texture(entry, "emissiveTexture")?,
        emissive_strength: 1.0,
        alpha: alpha(entry)?,
        double_sided: entry.flag("doubleSided", false)?,
        unlit: entry.extension("KHR_materials_unlit")?.is_some(),
        ior: 1.5,
        specular: Specular {
            strength: 1.0,
            strength_texture: None,
            color: [1.0; 3],
            color_texture: None,
        },
        transmission: None,
        volume: None,
        dispersion: 0.0,
        clearcoat: None,
        sheen: None,
        anisotropy: None,
        iridescence: None,
        diffuse_transmission: None,
        specular_glossiness: None,
    };
    if let Some(core) = entry.get("pbrMetallicRoughness")? {
        material.base_color = core.factors("baseColorFactor", [1.0; 4], UNIT)?;
        material.base_color_texture = texture(&core, "baseColorTexture")?;
        material.metallic = core.factor("metallicFactor", 1.0, UNIT)?;
        material.roughness = core.factor("roughnessFactor", 1.0, UNIT)?;
        material.metallic_roughness_texture = texture(&core, "metallicRoughnessTexture")?;
    }
    if let Some(more) = entry.extension("KHR_materials_emissive_strength")? {
        material.emissive_strength = more.factor("emissiveStrength", 1.0, LIGHT)?;
    }
    if let Some(more) = entry.extension("KHR_materials_ior")? {
        let ior = more.number_or("ior", 1.5)?;
        material.ior = if ior == 0.0 { 0.0 } else { more.factor("ior", 1.5, [1.0, MAX_IOR])? };
    }
    if let Some(more) = entry.extension("KHR_materials_specular")? {
        material.specular = Specular {
            strength: more.factor("specularFactor", 1.0, UNIT)?,
            strength_texture: texture(&more, "specularTexture")?,
            color: more.factors("specularColorFactor", [1.0; 3], [0.0, MAX_SPECULAR_COLOR])?,
            color_texture: texture(&more, "specularColorTexture")?,
        };
    }
    if let Some(more) = entry.extension("KHR_materials_transmission")? {
        material.transmission = Some(Transmission {
            factor: more.factor("transmissionFactor", 0.0, UNIT)?,
            texture: texture(&more, "transmissionTexture")?,
        });
    }
    if let Some(more) = entry.extension("KHR_materials_volume")? {
        let distance = more.get("attenuationDistance")?;
        let distance = distance.map(|distance| distance.number().map(|d| (d, distance)));
        let attenuation_distance = match distance.transpose()? {
            None => f32::INFINITY,
            Some((distance, _)) if distance > 0.0 => distance,
            Some((distance, entry)) => {
                return Err(entry.wrong(format_args!("is {distance}, but must be more than 0")));
            }
        };
        material.volume = Some(Volume {
            thickness: more.factor("thicknessFactor", 0.0, POSITIVE)?,
            thickness_texture: texture(&more, "thicknessTexture")?,
            attenuation_distance,
            attenuation_color: more.factors("attenuationColor", [1.0; 3], UNIT)?,
        });
    }
    if let Some(more) = entry.extension("KHR_materials_dispersion")? {
        material.dispersion = more.factor("dispersion", 0.0, [0.0, MAX_DISPERSION])?;
    }
    if let Some(more) = entry.extension("KHR_materials_clearcoat")? {
        material.clearcoat = Some(Clearcoat {
            factor: more.factor("clearcoatFactor", 0.0, UNIT)?,
            texture: texture(&more, "clearcoatTexture")?,
            roughness: more.factor("clearcoatRoughnessFactor", 0.0, UNIT)?,
            roughness_texture: texture(&more, "clearcoatRoughnessTexture")?,
            normal_texture: texture(&more, "clearcoatNormalTexture")?,
            normal_scale: scale(&more, "clearcoatNormalTexture", "scale", any)?,
        });
    }
    if let Some(more) = entry.extension("KHR_materials_sheen")? {
        material.sheen = Some(Sheen {
            color: more.factors("sheenColorFactor", [0.0; 3], UNIT)?,
            color_texture: texture(&more, "sheenColorTexture")?,
            roughness: more.factor("sheenRoughnessFactor", 0.0, UNIT)?,
            roughness_texture: texture(&more, "sheenRoughnessTexture")?,
        });
    }
    if let Some(more) = entry.extension("KHR_materials_anisotropy")? {
        material.anisotropy = Some(Anisotropy {
            strength: more.factor("anisotropyStrength", 0.0, UNIT)?,
            rotation: more.number_or("anisotropyRotation", 0.0)?,
            texture: texture(&more, "anisotropyTexture")?,
        });
    }
    if let Some(more) = entry.extension("KHR_materials_iridescence")? {
        material.iridescence = Some(Iridescence {
            factor: more.factor("iridescenceFactor", 0.0, UNIT)?,
            texture: texture(&more, "iridescenceTexture")?,
            ior: more.factor("iridescenceIor", 1.3, [1.0, MAX_IOR])?,
            thickness_minimum_nm: more.factor("iridescenceThicknessMinimum", 100.0, FILM)?,
            thickness_maximum_nm: more.factor("iridescenceThicknessMaximum", 400.0, FILM)?,
            thickness_texture: texture(&more, "iridescenceThicknessTexture")?,
        });
    }
    if let Some(more) = entry.extension("KHR_materials_diffuse_transmission")? {
        material.diffuse_transmission = Some(DiffuseTransmission {
            factor: more.factor("diffuseTransmissionFactor", 0.0, UNIT)?,
            texture: texture(&more, "diffuseTransmissionTexture")?,
            color: more.factors("diffuseTransmissionColorFactor", [1.0; 3], UNIT)?,
            color_texture: texture(&more, "diffuseTransmissionColorTexture")?,
        });
    }
    if let Some(more) = entry.extension("KHR_materials_pbrSpecularGlossiness")? {
        let glossiness = more.factor("glossinessFactor", 1.0, UNIT)?;
        let gloss = texture(&more, "specularGlossinessTexture")?;
        material.base_color = more.factors("diffuseFactor", [1.0; 4], UNIT)?;
        material.base_color_texture = texture(&more, "diffuseTexture")?;
        material.metallic = 0.0;
        material.roughness = 1.0 - glossiness;
        material.metallic_roughness_texture = None;
        material.ior = 0.0;
        material.specular = Specular {
            strength: 1.0,
            strength_texture: None,
            color: more.factors("specularFactor", [1.0; 3], UNIT)?,
            color_texture: gloss,
        };
        material.specular_glossiness = Some(SpecularGlossiness { glossiness, texture: gloss });
    }
    Ok(material)
}

fn alpha(entry: &Entry<'_, '_>) -> Result<Alpha> {
    let cutoff = entry.factor("alphaCutoff", 0.5, POSITIVE)?;
    let Some(mode) = entry.get("alphaMode")? else { return Ok(Alpha::Opaque) };
    match mode.text()? {
        "OPAQUE" => Ok(Alpha::Opaque),
        "MASK" => Ok(Alpha::Mask { cutoff }),
        "BLEND" => Ok(Alpha::Blend),
        other => {
            let other = crate::shown::shown(other);
            Err(mode.wrong(format_args!("is \"{other}\", but must be OPAQUE, MASK or BLEND")))
        }
    }
}
