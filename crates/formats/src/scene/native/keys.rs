//! Every key of the format, by the table it belongs to.
//!
//! docs/scene-format.md explains each; a test below sees to that.

pub(super) const ROOT: &[&str] =
    &["version", "render", "camera", "environment", "texture", "material", "shape", "light"];

pub(super) const RENDER: &[&str] = &[
    "size",
    "crop",
    "spp",
    "max_depth",
    "integrator",
    "sampler",
    "seed",
    "filter",
    "filter_radius",
    "filter_sigma",
    "filter_bc",
    "strategy",
    "heuristic",
    "roulette",
    "light_selection",
    "caustics",
    "layers",
    "exposure",
    "curve",
];

pub(super) const ANY_CAMERA: &[&str] = &["name", "type", "position", "look_at", "up"];
pub(super) const LENS: &[&str] = &[
    "aperture_radius",
    "focus_distance",
    "focus_at",
    "focus_on",
    "blades",
    "blade_rotation_degrees",
    "aperture_ratio",
];
pub(super) const PERSPECTIVE: &[&str] =
    &["fov_degrees", "focal_length_mm", "sensor_height_mm", "f_number"];
pub(super) const ORTHOGRAPHIC: &[&str] = &["height"];

pub(super) const ENVIRONMENT: &[&str] =
    &["image", "projection", "color", "scale", "rotation_degrees", "group"];

pub(super) const ANY_TEXTURE: &[&str] =
    &["name", "type", "uv_scale", "uv_rotation_degrees", "uv_offset", "uv_set"];
pub(super) const IMAGE_TEXTURE: &[&str] = &["image", "encoding", "wrap", "interpolation"];
pub(super) const PATTERN: &[&str] = &["first", "second"];
pub(super) const BRICKS: &[&str] = &["joint", "shift"];
pub(super) const NOISE: &[&str] = &["octaves", "gain"];
pub(super) const COLOR_INPUT: &[&str] = &["texture", "image", "factor", "vertex_colors"];

pub(super) const SCALAR_INPUT: &[&str] = &["texture", "image", "channel", "factor"];
pub(super) const DIRECTIONS: &[&str] = &["texture", "image"];
pub(super) const NORMAL_MAP: &[&str] = &["texture", "image", "scale"];
pub(super) const OPACITY: &[&str] =
    &["texture", "image", "channel", "factor", "vertex_colors", "cutoff"];

pub(super) const ANY_MATERIAL: &[&str] = &["name", "type", "single_sided"];
pub(super) const EMISSION: &[&str] =
    &["radiance", "power", "strength", "two_sided", "texture", "image", "vertex_colors", "group"];
pub(super) const SCATTERING: &[&str] = &["emission", "opacity", "normal_map", "bump_map"];
pub(super) const MATTE: &[&str] = &["albedo", "roughness", "sampling"];
pub(super) const MIRROR: &[&str] = &["reflectance"];
pub(super) const CONDUCTOR: &[&str] = &["metal", "eta", "k", "roughness", "distribution"];
pub(super) const DIELECTRIC: &[&str] = &[
    "ior",
    "exterior_ior",
    "dispersion",
    "roughness",
    "distribution",
    "sigma_a",
    "absorption_color",
    "absorption_distance",
    "fresnel",
    "priority",
];
pub(super) const THIN_DIELECTRIC: &[&str] = &["ior", "color"];
pub(super) const PRINCIPLED: &[&str] = &[
    "base_color",
    "metallic",
    "roughness",
    "diffuse_roughness",
    "anisotropy",
    "anisotropy_rotation_degrees",
    "anisotropy_direction",
    "specular",
    "specular_color",
    "ior",
    "dispersion",
    "transmission",
    "thin_walled",
    "diffuse_transmission",
    "diffuse_transmission_color",
    "sigma_a",
    "absorption_color",
    "absorption_distance",
    "priority",
    "coat",
    "coat_color",
    "coat_roughness",
    "coat_ior",
    "coat_normal_map",
    "coat_bump_map",
    "sheen_color",
    "sheen_roughness",
    "iridescence",
    "iridescence_ior",
    "iridescence_thickness_nm",
    "iridescence_thickness_minimum_nm",
];
pub(super) const MIX: &[&str] = &["first", "second", "amount"];

pub(super) const ANY_SHAPE: &[&str] = &[
    "name",
    "type",
    "material",
    "group",
    "translate",
    "rotate_degrees",
    "rotate",
    "scale",
    "matrix",
    "instances",
];
pub(super) const INSTANCE: &[&str] = &["translate", "rotate_degrees", "rotate", "scale", "matrix"];
pub(super) const CENTERED: &[&str] = &["center"];
pub(super) const ROUND: &[&str] = &["radius"];
pub(super) const SIZED: &[&str] = &["size"];
pub(super) const MESH: &[&str] =
    &["file", "positions", "triangles", "normals", "uvs", "smooth_degrees", "fit"];
pub(super) const FIT: &[&str] = &["up", "size", "axis", "on_floor", "center"];
pub(super) const ROTATE: &[&str] = &["axis", "degrees"];

pub(super) const ANY_LIGHT: &[&str] = &["type", "group"];
pub(super) const POINT: &[&str] = &["position", "intensity"];
pub(super) const SPOT: &[&str] =
    &["position", "direction", "look_at", "intensity", "power", "outer_degrees", "inner_degrees"];
pub(super) const DIRECTIONAL: &[&str] = &["direction", "irradiance"];

/// Which table has which keys.
const PLACES: &[(&str, &[&str])] = &[
    ("the scene itself, above all tables", ROOT),
    ("[render]", RENDER),
    ("[camera]", ANY_CAMERA),
    ("a perspective or orthographic [camera]", LENS),
    ("a perspective [camera]", PERSPECTIVE),
    ("an orthographic [camera]", ORTHOGRAPHIC),
    ("[environment]", ENVIRONMENT),
    ("[[texture]]", ANY_TEXTURE),
    ("an image texture", IMAGE_TEXTURE),
    ("a checker, bricks or noise", PATTERN),
    ("bricks", BRICKS),
    ("noise", NOISE),
    ("a textured color", COLOR_INPUT),
    ("a textured number", SCALAR_INPUT),
    ("a picture of directions", DIRECTIONS),
    ("a normal or bump map", NORMAL_MAP),
    ("opacity", OPACITY),
    ("[[material]]", ANY_MATERIAL),
    ("an emissive material or emission", EMISSION),
    ("a material that scatters", SCATTERING),
    ("a matte material", MATTE),
    ("a mirror", MIRROR),
    ("a conductor", CONDUCTOR),
    ("a dielectric", DIELECTRIC),
    ("a thin dielectric", THIN_DIELECTRIC),
    ("a principled material", PRINCIPLED),
    ("a mix", MIX),
    ("[[shape]]", ANY_SHAPE),
    ("an instance", INSTANCE),
    ("a sphere or disk", ROUND),
    ("a rectangle or box", SIZED),
    ("a sphere, rectangle, disk or box", CENTERED),
    ("a mesh", MESH),
    ("fit", FIT),
    ("rotate", ROTATE),
    ("[[light]]", ANY_LIGHT),
    ("a point light", POINT),
    ("a spot", SPOT),
    ("a directional light", DIRECTIONAL),
];

/// The tables that have the key `name`, for people, if there are any.
pub(super) fn where_it_belongs(name: &str) -> Option<String> {
    let places = PLACES.iter().filter(|(_, keys)| keys.contains(&name)).map(|(place, _)| *place);
    let places: Vec<_> = places.collect();
    (!places.is_empty()).then(|| places.join(" or "))
}

/// What to write where a key is missing that has only one good value.
pub(super) fn hint(key: &str) -> &'static str {
    match key {
        "version" => ": begin it with \"version = 1\"",
        _ => "",
    }
}

/// Whether any table has the key `name`.
pub(super) fn is_known(name: &str) -> bool {
    PLACES.iter().any(|(_, keys)| keys.contains(&name))
}

/// Properties that an author may give by other keys: a problem with the one is shown at the
/// first of the others. What comes from a file is shown at the file's name.
pub(super) const STANDS_FOR: &[(&str, &[&str])] = &[
    ("scale", &["uv_scale"]),
    ("normal_map", &["bump_map"]),
    ("normal_scale", &["normal_map", "bump_map"]),
    ("coat_normal_map", &["coat_bump_map"]),
    ("coat_normal_scale", &["coat_normal_map", "coat_bump_map"]),
    (
        "transform",
        &["matrix", "scale", "rotate", "rotate_degrees", "translate", "center", "fit", "instances"],
    ),
    ("fov_degrees", &["focal_length_mm"]),
    ("rotation_degrees", &["uv_rotation_degrees"]),
    ("offset", &["uv_offset"]),
    ("direction", &["look_at"]),
    ("aperture_radius", &["f_number"]),
    ("focus_distance", &["focus_at", "look_at"]),
    ("*", &["file"]),
];

/// What other programs call the names of this format.
pub(super) const SYNONYMS: &[(&str, &str)] = &[
    ("diffuse", "matte"),
    ("lambert", "matte"),
    ("lambertian", "matte"),
    ("glass", "dielectric"),
    ("water", "dielectric"),
    ("metal", "conductor"),
    ("openpbr", "principled"),
    ("disney", "principled"),
    ("plastic", "principled"),
    ("blend", "mix"),
    ("light", "emissive"),
    ("area", "emissive"),
    ("emitter", "emissive"),
    ("specular", "mirror"),
    ("cube", "box"),
    ("quad", "rectangle"),
    ("plane", "rectangle"),
    ("obj", "mesh"),
    ("ply", "mesh"),
    ("trianglemesh", "mesh"),
    ("circle", "disk"),
    ("sun", "directional"),
    ("distant", "directional"),
    ("brick", "bricks"),
    ("tiles", "bricks"),
    ("fbm", "noise"),
    ("perlin", "noise"),
    ("clouds", "noise"),
    ("checkerboard", "checker"),
    ("bitmap", "image"),
    ("imagemap", "image"),
    ("latlong", "equirectangular"),
    ("lat-long", "equirectangular"),
    ("equal-area", "octahedral"),
    ("cubemap", "cube"),
    ("cross", "cube"),
    ("triangle", "tent"),
    ("random", "independent"),
    ("pathtracer", "path"),
    ("none", "off"),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the documentation tells the keys of places in a line: how it begins.
    const LINES: &[(&str, &[&str])] = &[
        ("a textured number", &["A number or texture is "]),
        ("a picture of directions", &["| `anisotropy_direction` |"]),
        ("a normal or bump map", &["| `normal_map` |"]),
        ("an instance", &["In each entry of `instances`"]),
    ];

    /// Where it tells those of all others in tables: how the lines before these begin.
    const SECTIONS: &[(&str, &[&str])] = &[
        ("the scene itself, above all tables", &["## Top level"]),
        ("[render]", &["## `[render]`"]),
        ("[camera]", &["## `[camera]`"]),
        ("a perspective or orthographic [camera]", &["The lens of perspective and orthographic"]),
        ("a perspective [camera]", &["\"perspective\": "]),
        ("an orthographic [camera]", &["\"orthographic\": "]),
        ("[environment]", &["## `[environment]`"]),
        ("[[texture]]", &["## `[[texture]]`"]),
        ("an image texture", &["\"image\": "]),
        ("a checker, bricks or noise", &["\"checker\": ", "\"bricks\": ", "\"noise\": "]),
        ("bricks", &["\"bricks\": "]),
        ("noise", &["\"noise\": "]),
        ("a textured color", &["A colour or texture is "]),
        ("opacity", &["It is a number, the part of the rays that meet the surface"]),
        ("[[material]]", &["## `[[material]]`"]),
        ("an emissive material or emission", &["\"emissive\": "]),
        ("a material that scatters", &["## `[[material]]`"]),
        ("a matte material", &["\"matte\": "]),
        ("a mirror", &["\"mirror\": "]),
        ("a conductor", &["\"conductor\": "]),
        ("a dielectric", &["\"dielectric\": "]),
        ("a thin dielectric", &["\"thin-dielectric\": "]),
        ("a principled material", &["\"principled\": "]),
        ("a mix", &["\"mix\": "]),
        ("[[shape]]", &["## `[[shape]]`"]),
        ("a sphere or disk", &["\"sphere\" (normals outwards)"]),
        ("a rectangle or box", &["\"rectangle\" (in the x-y plane"]),
        ("a sphere, rectangle, disk or box", &["All but the mesh stand around the origin"]),
        ("a mesh", &["\"mesh\": "]),
        ("fit", &["In `fit`:"]),
        ("rotate", &["In `rotate`:"]),
        ("[[light]]", &["## `[[light]]`"]),
        ("a point light", &["\"point\": "]),
        ("a spot", &["\"spot\": "]),
        ("a directional light", &["\"directional\": "]),
    ];

    /// The line that begins so, and the rows of the first table after it in its section.
    fn section<'d>(docs: &'d str, begins: &str) -> (&'d str, Vec<&'d str>) {
        let mut lines = docs.lines().skip_while(|line| !line.starts_with(begins));
        let first = lines.next().unwrap_or_else(|| panic!("no line begins with {begins}"));
        let another = |line: &&str| line.starts_with("## ") || line.starts_with('"');
        let lines = lines.take_while(|line| !another(line)).skip_while(|l| !l.starts_with('|'));
        (first, lines.take_while(|line| line.starts_with('|')).collect())
    }

    /// Documentation that forgets a key is wrong, even if another table has one of that name.
    #[test]
    fn every_key_is_documented() {
        let docs = include_str!("../../../../../docs/scene-format.md");
        for (place, keys) in PLACES {
            let of = |list: &'static [(&str, &'static [&'static str])]| {
                let found = list.iter().find(|(of, _)| of == place);
                found.map_or(&[][..], |(_, sections)| sections)
            };
            assert!(!of(LINES).is_empty() || !of(SECTIONS).is_empty(), "{place}");
            for key in *keys {
                let said = |text: &str| text.contains(&format!("`{key}`"));
                for begins in of(LINES) {
                    let (line, _) = section(docs, begins);
                    assert!(
                        said(line) || line.contains(&format!("{key} = ")),
                        "`{key}` of {place}"
                    );
                }
                for begins in of(SECTIONS) {
                    // Of a row only its first cell names a key.
                    let (_, rows) = section(docs, begins);
                    let told = rows.iter().any(|row| row.split('|').nth(1).is_some_and(said));
                    assert!(told, "`{key}` of {place}, after \"{begins}\"");
                }
            }
        }
    }
}
