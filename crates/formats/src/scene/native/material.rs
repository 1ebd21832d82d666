//! `[[material]]`: how surfaces look.

use super::draft::Draft;
use super::keys;
use super::light_group;
use super::said::{self, Group, Said, Written, color, degrees, number};
use super::table::{Table, Value};
use super::texture;
use crate::error::SceneError;
use crate::scene::loaded::TextureName;
use crate::shown::shown;
use rutilant::bsdf::{Distribution, Fresnel};
use rutilant::color::Rgb;
use rutilant::material::{
    Absorption, Conductor, Dielectric, Emission, EmittedLight, HemisphereSampling, Material,
    MaterialKind, Matte, Medium, Metal, Mirror, Mix, Principled, PrincipledTextures, Sides,
    ThinDielectric,
};
use rutilant::scene::{MOST_LIGHT, MaterialId, Place, TextureId};
use rutilant::texture::{Channel, ColorInput, Encoding, ScalarInput};
use std::collections::HashMap;

#[derive(Clone, Copy)]
enum Type {
    Black,
    Null,
    Matte,
    Mirror,
    Conductor,
    Dielectric,
    ThinDielectric,
    Principled,
    Mix,
    Emissive,
}

const TYPES: &[(&str, Type)] = &[
    ("matte", Type::Matte),
    ("mirror", Type::Mirror),
    ("conductor", Type::Conductor),
    ("dielectric", Type::Dielectric),
    ("thin-dielectric", Type::ThinDielectric),
    ("principled", Type::Principled),
    ("mix", Type::Mix),
    ("emissive", Type::Emissive),
    ("black", Type::Black),
    ("null", Type::Null),
];

const SAMPLINGS: &[(&str, HemisphereSampling)] =
    &[("cosine", HemisphereSampling::Cosine), ("uniform", HemisphereSampling::Uniform)];

const METALS: &[(&str, Metal)] = &[
    ("gold", Metal::Gold),
    ("copper", Metal::Copper),
    ("silver", Metal::Silver),
    ("aluminium", Metal::Aluminium),
];

const DISTRIBUTIONS: &[(&str, Distribution)] =
    &[("ggx", Distribution::Ggx), ("beckmann", Distribution::Beckmann)];
const FRESNELS: &[(&str, Fresnel)] = &[("exact", Fresnel::Exact), ("schlick", Fresnel::Schlick)];

/// The keys of bumps that are painted, as normals and as heights.
const BUMPS: [&str; 2] = ["normal_map", "bump_map"];
const COAT_BUMPS: [&str; 2] = ["coat_normal_map", "coat_bump_map"];

/// Index of refraction of window glass, near enough.
const GLASS: f32 = 1.5;

/// Reads all materials. A mix may name materials that come after it, so names are read first.
pub(super) fn read_all<'d>(tables: &[Table<'d>], draft: &mut Draft<'d>) -> Result<(), SceneError> {
    for (table, id) in tables.iter().zip(0..) {
        table.must("name", |value| {
            let name = value.text()?;
            match draft.materials.insert(name, MaterialId(id)) {
                None => Ok(()),
                Some(_) => {
                    let what =
                        format!("there is another material \"{}\"; names must differ", shown(name));
                    Err(value.invalid(what))
                }
            }
        })?;
    }
    for table in tables {
        let material = read(table, draft)?.named(table.must("name", Value::text)?);
        let single_sided = table.or("single_sided", Value::flag, false)?;
        let sides = if single_sided { Sides::Front } else { Sides::Both };
        let material = Material { sides, ..material };
        draft.add_material(table, material);
    }
    note_lost_emission(draft);
    Ok(())
}

type Names<'d> = HashMap<&'d str, MaterialId>;

/// The material that a value names.
pub(super) fn named(value: &Value<'_>, names: &Names<'_>) -> Result<MaterialId, SceneError> {
    let name = value.text()?;
    names.get(name).copied().ok_or_else(|| {
        let mut known: Vec<&str> = names.keys().copied().collect();
        known.sort_unstable();
        value.unknown("material", name, known)
    })
}

fn read<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<Material, SceneError> {
    let allow = |table: &Table<'_>, keys| table.only(&[keys::ANY_MATERIAL, keys::SCATTERING, keys]);
    let kind = match table.must("type", |v| v.one_of("material type", TYPES))? {
        Type::Emissive => {
            let table = table.named("an emissive material");
            table.only(&[keys::ANY_MATERIAL, keys::EMISSION])?;
            return emission(&table, &table, draft).map(Material::from);
        }
        Type::Black => {
            allow(&table.named("a black material"), &[])?;
            MaterialKind::Black
        }
        Type::Null => {
            allow(&table.named("a null material"), &[])?;
            MaterialKind::Null
        }
        Type::Matte => {
            allow(&table.named("a matte material"), keys::MATTE)?;
            MaterialKind::Matte(Matte {
                albedo: table.or(
                    "albedo",
                    |value| texture::color_input(value, table, draft),
                    Rgb::grey(0.5).into(),
                )?,
                roughness: roughness(table)?,
                sampling: table.or(
                    "sampling",
                    |v| v.one_of("sampling", SAMPLINGS),
                    HemisphereSampling::Cosine,
                )?,
            })
        }
        Type::Mirror => {
            allow(&table.named("a mirror"), keys::MIRROR)?;
            let reflectance = table.or("reflectance", Value::color, Rgb::WHITE)?;
            MaterialKind::Mirror(Mirror { reflectance })
        }
        Type::Conductor => {
            let table = table.named("a conductor");
            allow(&table, keys::CONDUCTOR)?;
            MaterialKind::Conductor(conductor(&table)?)
        }
        Type::Dielectric => {
            let table = table.named("a dielectric");
            allow(&table, keys::DIELECTRIC)?;
            MaterialKind::Dielectric(dielectric(&table)?)
        }
        Type::ThinDielectric => {
            let table = table.named("a thin dielectric");
            allow(&table, keys::THIN_DIELECTRIC)?;
            MaterialKind::ThinDielectric(ThinDielectric {
                ior: table.or("ior", Value::number, GLASS)?,
                color: table.or("color", Value::color, Rgb::WHITE)?,
            })
        }
        Type::Principled => {
            let table = table.named("a principled material");
            allow(&table, keys::PRINCIPLED)?;
            MaterialKind::Principled(Box::new(principled(&table, draft)?))
        }
        Type::Mix => {
            let table = table.named("a mix");
            allow(&table, keys::MIX)?;
            MaterialKind::Mix(Mix {
                first: table.must("first", |v| named(v, &draft.materials))?,
                second: table.must("second", |v| named(v, &draft.materials))?,
                amount: table.or("amount", Value::number, 0.5)?,
            })
        }
    };
    let owner = table;
    let emission = table.maybe("emission", |value| {
        let table = value.table("emission")?;
        table.only(&[keys::EMISSION])?;
        emission(&table, owner, draft)
    })?;
    let opacity = table.maybe("opacity", |value| texture::opacity(value, table, draft))?;
    let normal_map = texture::bumps(BUMPS, table, draft)?;
    Ok(Material { emission, opacity, normal_map, ..Material::new(kind) })
}

fn emission<'d>(
    table: &Table<'d>,
    owner: &Table<'d>,
    draft: &mut Draft<'d>,
) -> Result<Emission, SceneError> {
    let strength = table.or("strength", Value::number, 1.0)?;
    let light = |key| {
        let Rgb(own) = table.must(key, Value::color)?;
        let whole = own.map(|c| c * strength);
        let sound = |light: [f32; 3]| light.iter().all(|c| (0.0..=MOST_LIGHT).contains(c));
        match table.get("strength") {
            Some(value) if sound(own) && !sound(whole) => Err(value.invalid(format!(
                "strength is {}, but must be 0 or more, and the {key} with it at most {MOST_LIGHT:e}",
                number(strength)
            ))),
            _ => Ok(Rgb(whole)),
        }
    };
    let light = match table.either(["radiance", "power"])? {
        "radiance" => EmittedLight::Radiance(light("radiance")?),
        _ => EmittedLight::Power(light("power")?),
    };
    let texture = texture::texture_of(table, owner, Encoding::Srgb, draft)?;
    Ok(Emission {
        light,
        texture,
        vertex_colors: table.or("vertex_colors", Value::flag, false)?,
        two_sided: table.or("two_sided", Value::flag, false)?,
        group: light_group::of(table)?,
    })
}

fn roughness(table: &Table<'_>) -> Result<f32, SceneError> {
    table.or("roughness", Value::number, 0.0)
}

fn distribution(table: &Table<'_>) -> Result<Distribution, SceneError> {
    table.or("distribution", |v| v.one_of("distribution", DISTRIBUTIONS), Distribution::Ggx)
}

fn conductor(table: &Table<'_>) -> Result<Conductor, SceneError> {
    let roughness = roughness(table)?;
    let distribution = distribution(table)?;
    match table.either(["metal", "eta"])? {
        "metal" => {
            if let Some(k) = table.get("k") {
                return Err(k.invalid("give metal, or eta and k, not both"));
            }
            let metal = table.must("metal", |v| v.one_of("metal", METALS))?;
            Ok(Conductor { distribution, ..metal.conductor(roughness) })
        }
        _ => {
            let (eta, k) = (table.must("eta", Value::color)?, table.must("k", Value::color)?);
            Ok(Conductor { eta, k, roughness, distribution })
        }
    }
}

fn dielectric(table: &Table<'_>) -> Result<Dielectric, SceneError> {
    let medium = |ior, absorption| Medium { ior, absorption };
    Ok(Dielectric {
        interior: medium(table.or("ior", Value::number, GLASS)?, absorption(table)?),
        exterior: medium(
            table.or("exterior_ior", Value::number, Medium::AIR.ior)?,
            Absorption::None,
        ),
        fresnel: table.or("fresnel", |v| v.one_of("fresnel", FRESNELS), Fresnel::Exact)?,
        priority: table.maybe("priority", Value::whole)?,
        roughness: roughness(table)?,
        distribution: distribution(table)?,
        dispersion: table.or("dispersion", Value::number, 0.0)?,
    })
}

fn principled<'d>(table: &Table<'d>, draft: &mut Draft<'d>) -> Result<Principled, SceneError> {
    let usual = Principled::default();
    let mut textures = PrincipledTextures::default();
    let mut part = |key, usual: f32, texture: &mut Option<(TextureId, Channel)>| {
        let input = table.or(
            key,
            |value| texture::scalar_input(value, table, draft),
            ScalarInput::from(usual),
        )?;
        *texture = input.texture;
        Ok::<f32, SceneError>(input.factor)
    };
    let metallic = part("metallic", usual.metallic, &mut textures.metallic)?;
    let roughness = part("roughness", usual.roughness, &mut textures.roughness)?;
    let anisotropy = part("anisotropy", usual.anisotropy, &mut textures.anisotropy)?;
    let specular = part("specular", usual.specular, &mut textures.specular)?;
    let transmission = part("transmission", usual.transmission, &mut textures.transmission)?;
    let diffuse_transmission = part(
        "diffuse_transmission",
        usual.diffuse_transmission,
        &mut textures.diffuse_transmission,
    )?;
    let coat = part("coat", usual.coat, &mut textures.coat)?;
    let coat_roughness =
        part("coat_roughness", usual.coat_roughness, &mut textures.coat_roughness)?;
    let sheen_roughness =
        part("sheen_roughness", usual.sheen_roughness, &mut textures.sheen_roughness)?;
    let iridescence = part("iridescence", usual.iridescence, &mut textures.iridescence)?;
    let iridescence_thickness_nm = part(
        "iridescence_thickness_nm",
        usual.iridescence_thickness_nm,
        &mut textures.iridescence_thickness_nm,
    )?;
    textures.anisotropy_direction =
        table.maybe("anisotropy_direction", |value| texture::directions(value, table, draft))?;
    let coat_normal_map = texture::bumps(COAT_BUMPS, table, draft)?;
    let mut color = |key, usual: Rgb| {
        table.or(key, |value| texture::color_input(value, table, draft), ColorInput::from(usual))
    };
    let base_color = color("base_color", usual.base_color)?;
    (textures.base_color, textures.vertex_colors) = (base_color.texture, base_color.vertex_colors);
    let mut tint = |key, usual, texture: &mut Option<TextureId>| {
        let input = color(key, usual)?;
        *texture = input.texture;
        Ok::<Rgb, SceneError>(input.factor)
    };
    let specular_color =
        tint("specular_color", usual.specular_color, &mut textures.specular_color)?;
    let diffuse_transmission_color = tint(
        "diffuse_transmission_color",
        usual.diffuse_transmission_color,
        &mut textures.diffuse_transmission_color,
    )?;
    let sheen_color = tint("sheen_color", usual.sheen_color, &mut textures.sheen_color)?;
    let number = |key, usual| table.or(key, Value::number, usual);
    let turn = number("anisotropy_rotation_degrees", 0.0)?;
    Ok(Principled {
        base_color: base_color.factor,
        metallic,
        roughness,
        diffuse_roughness: number("diffuse_roughness", usual.diffuse_roughness)?,
        anisotropy,
        anisotropy_rotation: turn.to_radians(),
        specular,
        specular_color,
        ior: number("ior", usual.ior)?,
        dispersion: number("dispersion", usual.dispersion)?,
        transmission,
        thin_walled: table.or("thin_walled", Value::flag, usual.thin_walled)?,
        diffuse_transmission,
        diffuse_transmission_color,
        absorption: absorption(table)?,
        priority: table.maybe("priority", Value::whole)?,
        coat,
        coat_color: table.or("coat_color", Value::color, usual.coat_color)?,
        coat_roughness,
        coat_ior: number("coat_ior", usual.coat_ior)?,
        coat_normal_map,
        sheen_color,
        sheen_roughness,
        iridescence,
        iridescence_ior: number("iridescence_ior", usual.iridescence_ior)?,
        iridescence_thickness_nm,
        iridescence_thickness_minimum_nm: number(
            "iridescence_thickness_minimum_nm",
            usual.iridescence_thickness_minimum_nm,
        )?,
        textures,
    })
}

fn absorption(table: &Table<'_>) -> Result<Absorption, SceneError> {
    let given = table.at_most_one(&["sigma_a", "absorption_color"])?;
    if given == Some("absorption_color") {
        return Ok(Absorption::ColorAtDistance {
            color: table.must("absorption_color", Value::color)?,
            distance: table.or("absorption_distance", Value::number, 1.0)?,
        });
    }
    if let Some(value) = table.get("absorption_distance") {
        return Err(value.invalid("absorption_distance needs an absorption_color"));
    }
    Ok(table.maybe("sigma_a", Value::color)?.map_or(Absorption::None, Absorption::Coefficient))
}

/// A mix scatters as its parts do, but does not glow as they do.
fn note_lost_emission(draft: &mut Draft<'_>) {
    let materials = &draft.scene.materials;
    for (i, material) in materials.iter().enumerate() {
        let MaterialKind::Mix(mix) = &material.kind else { continue };
        let second = (mix.second != mix.first).then_some(mix.second);
        let parts = [mix.first].into_iter().chain(second);
        for part in parts.filter_map(|id| materials.get(id.0 as usize)) {
            if part.emission.is_some() {
                let (mix, part) = (shown(&material.name), shown(&part.name));
                let what = format!(
                    "material \"{mix}\" does not glow as its part \"{part}\" does: give it an \
                     emission of its own"
                );
                draft.notes.push(match draft.places.get(&Place::Material(i)) {
                    Some(table) => table.note(&what),
                    None => what,
                });
            }
        }
    }
}

/// The keys that say all of a material; `None` for a custom one, which no file can say. `names`
/// are those of all materials, `textures` those of all textures. A lamp, which is black and glows,
/// is written "emissive" if `lamp` says so, or else "black" with an emission.
pub(super) fn keys_of(
    material: &Material,
    names: &[String],
    textures: &[TextureName],
    lamp: bool,
) -> Option<Vec<Group>> {
    let name = Group::one(&["name"], said::text(&material.name));
    let kind = |name: &str| Group::one(&["type"], said::text(name));
    let single_sided = (material.sides == Sides::Front).to_string();
    let single_sided = Group::or(&["single_sided"], single_sided, "false");
    if let (MaterialKind::Black, Some(emission), true) = (&material.kind, &material.emission, lamp)
    {
        let mut groups = vec![name, kind("emissive")];
        groups.extend(keys_of_emission(emission, textures));
        groups.push(single_sided);
        return Some(groups);
    }
    let rough = |roughness| Group::or(&["roughness"], number(roughness), "0");
    let distributed = |distribution| {
        let usual = said::name(DISTRIBUTIONS, &Distribution::Ggx);
        Group::or(&["distribution"], said::name(DISTRIBUTIONS, &distribution), &usual)
    };
    let part = |id: MaterialId| said::text(names.get(id.0 as usize).map_or("", String::as_str));
    let ior = |ior| Group::or(&["ior"], number(ior), &number(GLASS));
    let mut groups = match &material.kind {
        MaterialKind::Black => vec![name, kind("black")],
        MaterialKind::Null => vec![name, kind("null")],
        MaterialKind::Matte(m) => {
            let usual = said::name(SAMPLINGS, &HemisphereSampling::Cosine);
            vec![
                name,
                kind("matte"),
                Group::of(&["albedo"], [texture::said_color("albedo", &m.albedo, textures, "0.5")]),
                rough(m.roughness),
                Group::or(&["sampling"], said::name(SAMPLINGS, &m.sampling), &usual),
            ]
        }
        MaterialKind::Mirror(m) => {
            vec![name, kind("mirror"), Group::or(&["reflectance"], color(m.reflectance), "1")]
        }
        MaterialKind::Conductor(m) => {
            let is = |metal: &Metal| {
                *m == Conductor { distribution: m.distribution, ..metal.conductor(m.roughness) }
            };
            let metal = METALS.iter().find(|(_, metal)| is(metal));
            let says = match metal {
                Some((metal, _)) => vec![Said::new("metal", said::text(metal))],
                None => vec![Said::new("eta", color(m.eta)), Said::new("k", color(m.k))],
            };
            let index = Group::of(&["metal", "eta", "k"], says);
            vec![name, kind("conductor"), index, rough(m.roughness), distributed(m.distribution)]
        }
        MaterialKind::Dielectric(m) => {
            let usual = said::name(FRESNELS, &Fresnel::Exact);
            vec![
                name,
                kind("dielectric"),
                ior(m.interior.ior),
                Group::or(&["exterior_ior"], number(m.exterior.ior), &number(Medium::AIR.ior)),
                keys_of_absorption(&m.interior.absorption),
                Group::or(&["fresnel"], said::name(FRESNELS, &m.fresnel), &usual),
                Group::maybe(&["priority"], m.priority.map(|priority| priority.to_string())),
                rough(m.roughness),
                distributed(m.distribution),
                Group::or(&["dispersion"], number(m.dispersion), "0"),
            ]
        }
        MaterialKind::ThinDielectric(m) => vec![
            name,
            kind("thin-dielectric"),
            ior(m.ior),
            Group::or(&["color"], color(m.color), "1"),
        ],
        MaterialKind::Principled(m) => {
            let mut groups = vec![name, kind("principled")];
            groups.extend(keys_of_principled(m, textures));
            groups
        }
        MaterialKind::Mix(m) => vec![
            name,
            kind("mix"),
            Group::one(&["first"], part(m.first)),
            Group::one(&["second"], part(m.second)),
            Group::or(&["amount"], number(m.amount), "0.5"),
        ],
        MaterialKind::Custom(_) => return None,
    };
    let emission = material.emission.as_ref().map(|emission| Said {
        key: "emission",
        value: Written::Table(keys_of_emission(emission, textures).into()),
        usual: false,
    });
    groups.push(Group::of(&["emission"], emission.into_iter().collect::<Vec<_>>()));
    let opacity = material.opacity.as_ref().map(|o| texture::said_opacity(o, textures));
    groups.push(Group::of(&["opacity"], opacity.into_iter().collect::<Vec<_>>()));
    groups.push(texture::said_bumps(&BUMPS, material.normal_map.as_ref(), textures));
    groups.push(single_sided);
    Some(groups)
}

/// Each texture of a material, with what codes mean where the material names a picture instead.
pub(super) fn textures_of(material: &Material) -> Vec<(TextureId, Encoding)> {
    let emission = material.emission.and_then(|emission| emission.texture);
    let mut colors = vec![emission];
    let mut numbers = vec![
        material.opacity.and_then(|opacity| opacity.amount.texture).map(|(id, _)| id),
        material.normal_map.map(|map| map.texture),
    ];
    match &material.kind {
        MaterialKind::Matte(matte) => colors.push(matte.albedo.texture),
        MaterialKind::Principled(principled) => {
            let PrincipledTextures {
                base_color,
                vertex_colors: _,
                metallic,
                roughness,
                anisotropy,
                anisotropy_direction,
                specular,
                specular_color,
                transmission,
                diffuse_transmission,
                diffuse_transmission_color,
                coat,
                coat_roughness,
                sheen_color,
                sheen_roughness,
                iridescence,
                iridescence_thickness_nm,
            } = principled.textures;
            colors.extend([base_color, specular_color, diffuse_transmission_color, sheen_color]);
            let scalars = [
                metallic,
                roughness,
                anisotropy,
                specular,
                transmission,
                diffuse_transmission,
                coat,
                coat_roughness,
                sheen_roughness,
                iridescence,
                iridescence_thickness_nm,
            ];
            numbers.extend(scalars.map(|scalar| scalar.map(|(id, _)| id)));
            numbers.push(anisotropy_direction);
            numbers.push(principled.coat_normal_map.map(|map| map.texture));
        }
        MaterialKind::Black
        | MaterialKind::Null
        | MaterialKind::Mirror(_)
        | MaterialKind::Conductor(_)
        | MaterialKind::Dielectric(_)
        | MaterialKind::ThinDielectric(_)
        | MaterialKind::Mix(_)
        | MaterialKind::Custom(_) => {}
    }
    let colors = colors.into_iter().flatten().map(|id| (id, Encoding::Srgb));
    let numbers = numbers.into_iter().flatten().map(|id| (id, Encoding::Linear));
    colors.chain(numbers).collect()
}

fn keys_of_principled(m: &Principled, names: &[TextureName]) -> Vec<Group> {
    let (usual, of) = (Principled::default(), &m.textures);
    let number = |key: &'static [&'static str; 1], a, b| Group::or(key, number(a), &number(b));
    let part = |key: &'static [&'static str; 1], factor, texture, usual| {
        let input = ScalarInput { factor, texture };
        Group::of(key, [texture::said_scalar(key[0], input, names, usual)])
    };
    let tint = |key: &'static [&'static str; 1], factor, texture, vertex_colors, usual| {
        let input = ColorInput { factor, texture, vertex_colors };
        Group::of(key, [texture::said_color(key[0], &input, names, &color(usual))])
    };
    let scratches = of.anisotropy_direction;
    let scratches = scratches.map(|id| texture::said_directions("anisotropy_direction", id, names));
    vec![
        tint(&["base_color"], m.base_color, of.base_color, of.vertex_colors, usual.base_color),
        part(&["metallic"], m.metallic, of.metallic, usual.metallic),
        part(&["roughness"], m.roughness, of.roughness, usual.roughness),
        number(&["diffuse_roughness"], m.diffuse_roughness, usual.diffuse_roughness),
        part(&["anisotropy"], m.anisotropy, of.anisotropy, usual.anisotropy),
        Group::or(&["anisotropy_rotation_degrees"], degrees(m.anisotropy_rotation), "0"),
        Group::of(&["anisotropy_direction"], scratches.into_iter().collect::<Vec<_>>()),
        part(&["specular"], m.specular, of.specular, usual.specular),
        tint(&["specular_color"], m.specular_color, of.specular_color, false, usual.specular_color),
        number(&["ior"], m.ior, usual.ior),
        number(&["dispersion"], m.dispersion, usual.dispersion),
        part(&["transmission"], m.transmission, of.transmission, usual.transmission),
        Group::or(&["thin_walled"], m.thin_walled.to_string(), "false"),
        part(
            &["diffuse_transmission"],
            m.diffuse_transmission,
            of.diffuse_transmission,
            usual.diffuse_transmission,
        ),
        tint(
            &["diffuse_transmission_color"],
            m.diffuse_transmission_color,
            of.diffuse_transmission_color,
            false,
            usual.diffuse_transmission_color,
        ),
        keys_of_absorption(&m.absorption),
        Group::maybe(&["priority"], m.priority.map(|priority| priority.to_string())),
        part(&["coat"], m.coat, of.coat, usual.coat),
        Group::or(&["coat_color"], color(m.coat_color), &color(usual.coat_color)),
        part(&["coat_roughness"], m.coat_roughness, of.coat_roughness, usual.coat_roughness),
        number(&["coat_ior"], m.coat_ior, usual.coat_ior),
        texture::said_bumps(&COAT_BUMPS, m.coat_normal_map.as_ref(), names),
        tint(&["sheen_color"], m.sheen_color, of.sheen_color, false, usual.sheen_color),
        part(&["sheen_roughness"], m.sheen_roughness, of.sheen_roughness, usual.sheen_roughness),
        part(&["iridescence"], m.iridescence, of.iridescence, usual.iridescence),
        number(&["iridescence_ior"], m.iridescence_ior, usual.iridescence_ior),
        part(
            &["iridescence_thickness_nm"],
            m.iridescence_thickness_nm,
            of.iridescence_thickness_nm,
            usual.iridescence_thickness_nm,
        ),
        number(
            &["iridescence_thickness_minimum_nm"],
            m.iridescence_thickness_minimum_nm,
            usual.iridescence_thickness_minimum_nm,
        ),
    ]
}

fn keys_of_absorption(absorption: &Absorption) -> Group {
    let says = match *absorption {
        Absorption::None => Vec::new(),
        Absorption::Coefficient(sigma) => vec![Said::new("sigma_a", color(sigma))],
        Absorption::ColorAtDistance { color: left, distance } => vec![
            Said::new("absorption_color", color(left)),
            Said::or("absorption_distance", number(distance), "1"),
        ],
    };
    Group::of(&["sigma_a", "absorption_color", "absorption_distance"], says)
}

fn keys_of_emission(emission: &Emission, names: &[TextureName]) -> [Group; 5] {
    let light = match emission.light {
        EmittedLight::Radiance(rgb) => Said::new("radiance", color(rgb)),
        EmittedLight::Power(rgb) => Said::new("power", color(rgb)),
    };
    [
        Group::of(&["radiance", "power", "strength"], [light]),
        texture::said_texture(emission.texture, names),
        Group::or(&["vertex_colors"], emission.vertex_colors.to_string(), "false"),
        Group::or(&["two_sided"], emission.two_sided.to_string(), "false"),
        light_group::key_of(emission.group),
    ]
}
