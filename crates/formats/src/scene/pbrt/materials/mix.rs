//! Mixtures of two materials.

use super::metal::Metal;
use super::which::Which;
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::pbrt::parameters::{Before, Parameters, Values};
use crate::scene::pbrt::scene::Maker;
use crate::scene::pbrt::textures::{self, Change};
use rutilant::color::Rgb;
use rutilant::material::{Material, MaterialKind, Mix, Principled, PrincipledTextures};

/// Parts of mixtures, each time that they are looked at.
const MOST_PARTS: usize = 100_000;

impl Maker<'_> {
    pub(super) fn mix(&mut self, parameters: &Parameters) -> Result<Material, SceneError> {
        let place = parameters.place;
        let old = parameters.get("namedmaterial1").is_some();
        let names: Vec<String> = if old {
            let of = |name: &str| parameters.text(name, self.texts);
            let (first, second) = (of("namedmaterial1")?, of("namedmaterial2")?);
            [first, second].into_iter().flatten().map(str::to_owned).collect()
        } else {
            match parameters.get("materials").map(|parameter| &parameter.values) {
                Some(Values::Texts(names)) => names.clone(),
                Some(_) | None => Vec::new(),
            }
        };
        let [first, second] = &names[..] else {
            let what = format!("{} must name two materials", parameters.of);
            return Err(self.texts.invalid(place, what));
        };
        let mut amount = self.number(parameters, "amount", 0.5)?;
        if old {
            // There it was the share of the first.
            amount = amount.changed(Change::Invert);
        }
        if self.making.len() as u64 > self.options.limits.nesting {
            let (asked, allowed) = (self.making.len() as u64, self.options.limits.nesting);
            let kind = SceneErrorKind::Limit { what: "levels of nesting", asked, allowed };
            return Err(self.texts.error(place, kind));
        }
        let Before { materials: before, .. } = parameters.before;
        let mut part = |name: &str| {
            if matches!(name, "interface" | "none") && self.names.material(name, before).is_none() {
                return Ok(Material::new(MaterialKind::Null));
            }
            let number = self.named_material(name, before, place)?;
            self.mixed_parts += 1;
            if self.mixed_parts > MOST_PARTS {
                let what = "mixtures of mixtures have too many parts";
                return Err(self.texts.invalid(place, what));
            }
            self.look(Which::Named(number), ["", ""])
        };
        let (first, second) = (part(first)?, part(second)?);

        // What is mixed with nothing has holes.
        let null = |material: &Material| {
            matches!(material.kind, MaterialKind::Null) && material.opacity.is_none()
        };
        if null(&second) {
            let mut material = first;
            self.open(&mut material, &amount.changed(Change::Invert));
            return Ok(material);
        }
        if null(&first) {
            let mut material = second;
            self.open(&mut material, &amount);
            return Ok(material);
        }
        if amount.varies.is_some() {
            let what = format!("the amount of {} cannot vary: its mean stands in", parameters.of);
            self.note(place, what);
        }
        let [r, g, b] = textures::mean(&amount).0;
        let amount = ((r + g + b) / 3.0).clamp(0.0, 1.0);
        if amount == 0.0 {
            return Ok(first);
        }
        if amount == 1.0 {
            return Ok(second);
        }
        let plain = |material: &Material| {
            let mixes = matches!(
                material.kind,
                MaterialKind::Black
                    | MaterialKind::Matte(_)
                    | MaterialKind::Mirror(_)
                    | MaterialKind::Conductor(_)
                    | MaterialKind::ThinDielectric(_)
            );
            mixes && material.opacity.is_none() && material.normal_map.is_none()
        };
        if plain(&first) && plain(&second) {
            let (first, second) = (self.scene.add_material(first), self.scene.add_material(second));
            return Ok(Mix { first, second, amount }.into());
        }
        if let (Some(a), Some(b)) = (layers(&first.kind), layers(&second.kind))
            && let Some(layers) = between(&a, &b, amount)
        {
            let heavier = if amount > 0.5 { second } else { first };
            let kind = MaterialKind::Principled(Box::new(layers));
            return Ok(Material { kind, ..heavier });
        }
        let what = format!(
            "{} mixes what cannot be mixed here: what there is more of stands in for it",
            parameters.of
        );
        self.note(place, what);
        Ok(if amount > 0.5 { second } else { first })
    }
}

/// The same as layers, where that can be said.
fn layers(kind: &MaterialKind) -> Option<Principled> {
    match kind {
        MaterialKind::Principled(layers) => Some(**layers),
        MaterialKind::Matte(matte) => Some(Principled {
            base_color: matte.albedo.factor,
            diffuse_roughness: matte.roughness,
            specular: 0.0,
            textures: PrincipledTextures {
                base_color: matte.albedo.texture,
                vertex_colors: matte.albedo.vertex_colors,
                ..Default::default()
            },
            ..Principled::default()
        }),
        MaterialKind::Black => {
            Some(Principled { base_color: Rgb::BLACK, specular: 0.0, ..Principled::default() })
        }
        MaterialKind::Mirror(mirror) => Some(Principled {
            base_color: mirror.reflectance,
            metallic: 1.0,
            roughness: 0.0,
            ..Principled::default()
        }),
        MaterialKind::Conductor(conductor) => {
            let metal = Metal { eta: conductor.eta, k: conductor.k };
            Some(Principled {
                base_color: metal.normal_reflectance(1.0),
                metallic: 1.0,
                roughness: conductor.roughness,
                ..Principled::default()
            })
        }
        MaterialKind::Null
        | MaterialKind::Dielectric(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => None,
    }
}

/// Layers whose numbers lie between those of two others; `None` where textures are in the way.
fn between(a: &Principled, b: &Principled, amount: f32) -> Option<Principled> {
    if a.textures != b.textures || a.thin_walled != b.thin_walled {
        return None;
    }
    let lerp = |a: f32, b: f32| a + (b - a) * amount;
    let colors = |a: Rgb, b: Rgb| Rgb(std::array::from_fn(|i| lerp(a.0[i], b.0[i])));
    Some(Principled {
        base_color: colors(a.base_color, b.base_color),
        metallic: lerp(a.metallic, b.metallic),
        roughness: lerp(a.roughness, b.roughness),
        diffuse_roughness: lerp(a.diffuse_roughness, b.diffuse_roughness),
        specular: lerp(a.specular, b.specular),
        specular_color: colors(a.specular_color, b.specular_color),
        ior: lerp(a.ior, b.ior),
        transmission: lerp(a.transmission, b.transmission),
        diffuse_transmission: lerp(a.diffuse_transmission, b.diffuse_transmission),
        coat: lerp(a.coat, b.coat),
        coat_roughness: if a.coat > 0.0 { a.coat_roughness } else { b.coat_roughness },
        coat_ior: if a.coat > 0.0 { a.coat_ior } else { b.coat_ior },
        ..*a
    })
}
