//! Wavefront MTL: the materials of OBJ files, as near as the materials here come to them.
//!
//! MTL describes the shading of 1990: a diffuse and a specular colour and a
//! number for the formula that joins them. What light does is taken from it:
//!
//! | in the file, the first line that fits        | here                        |
//! |----------------------------------------------|-----------------------------|
//! | `d` below 1, `Tr` above 0, or `illum` 4, 6, 7, 9 | dielectric of index `Ni` (1.5 where absent or up to 1), coloured `Tf` after 1 m, rough by `Pr`; principled if `Pc`, `Ps` or `aniso` is not 0 |
//! | `Pr`, or one of `Pm`, `Pc`, `Ps`, `aniso` that is not 0 | principled: base `Kd`, metal `Pm`, rough by `Pr` (0.5 where absent), index `Ni`, coat `Pc` rough by `Pcr`, sheen `Ps`, `aniso` turned by `anisor` |
//! | `illum` 5                                    | a mirror of `Ks` over matte `Kd` |
//! | `illum` 3 or 8                               | the same, rough by `Ns` if that is given |
//! | `Ks` and `Ns`, but for `illum` 0 and 1       | a gloss of `Ks`, rough by `Ns`, over matte `Kd` |
//! | everything else                              | matte of albedo `Kd` (0.8 where absent) |
//! | besides, `map_Kd`                            | a picture by which `Kd` is multiplied; white where that is black |
//! | besides, `Ke` not black                      | also gives that radiance, on its front |
//! | besides, `map_Ke`                            | a picture by which `Ke` is multiplied; white where that is black or absent |
//! | besides, `map_Pr`, `map_Pm`                  | pictures by which `Pr` and `Pm` are multiplied; 1 where those are absent or 0 |
//! | besides, `map_Ks`                            | a picture by which the gloss of `Ks` is multiplied, which then is that of a principled material; white where `Ks` is black or absent |
//! | besides, `map_d`                             | how much of the surface is there, times `d`, which then is none of glass |
//! | besides, `map_Tr`                            | how much of it is not there |
//! | besides, `norm`                              | a normal map |
//! | besides, `bump`, `map_bump`                  | heights in metres of the world, times `-bm` (1 where absent), or normals, if the picture looks like one of them; none beside `norm` |
//!
//! "Over" is a mix in which the gloss has the share of the brightest channel of
//! its colour. Where `Kd` and the gloss would send back more than they get, both
//! are dimmed. With `Ni` above 1 and `Kd` not dark, the gloss of `Ks` and `Ns`
//! is that of a varnish: `Ks` times what such an index reflects, as
//! exporters that write `Ks 0.5` for everything mean it. Where there is no `Ni`
//! at all, its highlight is as bright as the formula of 1990 makes it, against
//! white matter under the same lamp: `Ks` times 8 / (Ns + 2), but no less than a
//! varnish has. (Straight on GGX sends back R / (4 π α²), Phong's `Ks` / π.)
//!
//! `Ns` is the width of a highlight, never the share of a mirror: the α of a
//! rough surface is √(2 / (Ns + 2)), and `roughness` the square root of that.
//! `illum 4` alone is not believed where `Kd` is not dark, `d` is 1 and `Ni` is
//! absent or up to 1: a widespread exporter writes so for every matte surface.
//! Of the picture of a number red counts, and of `map_d` and `map_Tr` alpha where it is that of
//! `map_Kd`. Other textures are left out, with a note.
//!
//! Source: Wavefront, *Advanced Visualizer Manual*, MTL material format, 1995;
//! `Pr`, `Pm` and so on: Exocortex, *Extending Wavefront MTL to Support PBR*.
//! α from Ns: Walter, Marschner, Li, Torrance, *Microfacet Models for
//! Refraction through Rough Surfaces*, 2007, section 5.2.
//! A metal's index from its colour: Gulbrandsen, *Artist Friendly Metallic
//! Fresnel*, 2014, with white edges.

use super::text::{Cursor, Places, place, word_at};
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::file;
use crate::limits::Limits;
use crate::shown::{decode, quoted};
use rutilant::color::Rgb;
use rutilant::material::{
    Absorption, Bumps, Conductor, Dielectric, Emission, MAX_IOR, MAX_SPECULAR_COLOR,
    MOST_ROUGH_RATIO, Material, MaterialKind, Matte, Mirror, Mix, NormalMap, Opacity, OpacityMode,
    Principled, PrincipledTextures,
};
use rutilant::scene::{BitmapId, MOST_LIGHT, MaterialId, TextureId};
use rutilant::texture::{
    Channel, ColorInput, Encoding, ImageTexture, ScalarInput, UvMapping, Wrap,
};
use rutilant_geom::Vec2;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::Path;

/// What an MTL file holds.
#[derive(Clone, Debug, Default)]
pub struct Library {
    /// Its materials, each name once. The parts of a mix follow it directly, without a name; the
    /// mix counts them in this list.
    pub materials: Vec<Material>,
    /// The textures that they use, which count their bitmaps in `pictures`.
    pub textures: Vec<ImageTexture>,
    /// The pictures that these show.
    pub pictures: Vec<Picture>,
    /// What was left out or changed: one line each.
    pub notes: Vec<String>,
}

/// A picture that an MTL file names.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Its name as it is written, counted from the folder of the file.
    pub name: String,
    /// Where that stands.
    pub at: Source,
}

/// The materials in the MTL file at `path`, and notes on what was left out.
///
/// # Errors
/// A file that cannot be read, breaks the format or exceeds the `limits`.
pub fn read(path: &Path, limits: &Limits) -> Result<Library, SceneError> {
    read_bytes(&file::scene_bytes(path, limits)?, path)
}

/// As [`read`], for the content of a file; `path` is only for messages.
///
/// # Errors
/// As [`read`].
pub fn read_bytes(bytes: &[u8], path: &Path) -> Result<Library, SceneError> {
    let mut parser = Parser {
        bytes,
        path,
        cursor: Cursor::new(bytes),
        left_out: BTreeMap::new(),
        textures: BTreeSet::new(),
        first_texture: None,
        library: Library::default(),
        names: HashSet::new(),
        repeated: None,
        known_pictures: HashMap::new(),
        known_textures: HashMap::new(),
        places: Places::default(),
    };
    parser.lines()?;
    Ok(parser.library)
}

/// The statements of one material.
#[derive(Default)]
struct Written {
    name: String,
    at: usize,
    kd: Option<[f32; 3]>,
    ks: Option<[f32; 3]>,
    ke: Option<[f32; 3]>,
    tf: Option<[f32; 3]>,
    ni: Option<f32>,
    d: Option<f32>,
    tr: Option<f32>,
    illum: Option<f32>,
    ns: Option<f32>,
    pr: Option<f32>,
    pm: Option<f32>,
    map_kd: Option<TextureId>,
    map_ke: Option<TextureId>,
    map_pr: Option<TextureId>,
    map_pm: Option<TextureId>,
    map_ks: Option<TextureId>,
    map_d: Option<TextureId>,
    map_tr: Option<TextureId>,
    norm: Option<TextureId>,
    /// Heights, and the factor on them.
    bump: Option<(TextureId, f32)>,
    ps: f32,
    pc: f32,
    pcr: f32,
    aniso: f32,
    anisor: f32,
}

impl Written {
    /// True where there are layers that only a principled material has.
    fn is_layered(&self) -> bool {
        self.ps != 0.0 || self.pc != 0.0 || self.aniso != 0.0
    }
}

struct Parser<'a> {
    bytes: &'a [u8],
    path: &'a Path,
    cursor: Cursor<'a>,
    /// Statements that nobody reads: how often, and where first.
    left_out: BTreeMap<&'a [u8], (u64, usize)>,
    /// Textures: their statements, how many there are, and where and which the first is.
    textures: BTreeSet<&'a [u8]>,
    first_texture: Option<(u64, usize, String)>,
    library: Library,
    names: HashSet<String>,
    /// Materials that come again: how many, and where and which the first is.
    repeated: Option<(u64, usize, String)>,
    /// Pictures by their names.
    known_pictures: HashMap<String, BitmapId>,
    known_textures: HashMap<TextureKey, TextureId>,
    /// Where pictures stand.
    places: Places,
}

/// All that tells one texture of an MTL file from another: its picture, the bits of its scale and
/// offset, and the rest.
type TextureKey = (BitmapId, [u32; 4], Wrap, Encoding);

/// A colour is dark when no channel is brighter than this. Exporters write small numbers where
/// they mean none.
const DARK: f32 = 0.05;

/// The albedo of a matte material that states none: what modelling programs show then.
const DEFAULT_ALBEDO: [f32; 3] = [0.8; 3];

/// The index of refraction of glass, where the file has none that refracts.
const DEFAULT_IOR: f32 = 1.5;

/// More distinct statements than this are counted together: a file of garbage has a note, not a book.
const MOST_LEFT_OUT: usize = 16;

/// Nobody reads more notes on one file, and each costs a walk to its line.
const MOST_NOTES: usize = 64;

impl<'a> Parser<'a> {
    fn lines(&mut self) -> Result<(), SceneError> {
        let mut current: Option<Written> = None;
        while let Some((at, keyword)) = self.cursor.statement() {
            if keyword == b"newmtl" {
                let name = self.cursor.name();
                if name.is_empty() {
                    return Err(self.invalid(at, "newmtl needs a name".to_owned()));
                }
                if let Some(done) = current.replace(Written { name, at, ..Written::default() }) {
                    self.finish(done);
                }
            } else if let Some(material) = &mut current {
                self.statement(keyword, at, material)?;
            } else {
                let what = format!("{} stands before the first newmtl", quoted(keyword));
                return Err(self.invalid(at, what));
            }
            self.cursor.skip_line();
        }
        if let Some(done) = current {
            self.finish(done);
        }

        if let Some((count, first, name)) = self.repeated.take() {
            let what = format!("materials that come again, left out: {count} (first {name})");
            self.note(first, &what);
        }
        if let Some((count, first, name)) = self.first_texture.take() {
            let kinds: Vec<_> = self.textures.iter().map(|keyword| decode(keyword)).collect();
            let kinds = kinds.join(", ");
            let what =
                format!("textures of other kinds are not read: {count} ({kinds}; first {name})");
            self.note(first, &what);
        }
        for (keyword, (count, first)) in std::mem::take(&mut self.left_out) {
            let times = if count == 1 { String::new() } else { format!(", {count} times") };
            let keyword = if keyword.is_empty() { "…".to_owned() } else { quoted(keyword) };
            self.note(first, &format!("{keyword} is not read{times}"));
        }
        Ok(())
    }

    fn statement(
        &mut self,
        keyword: &'a [u8],
        at: usize,
        material: &mut Written,
    ) -> Result<(), SceneError> {
        match keyword {
            b"Kd" => material.kd = self.color(keyword)?.or(material.kd),
            b"Ks" => material.ks = self.color(keyword)?.or(material.ks),
            b"Ke" => material.ke = self.color(keyword)?.or(material.ke),
            b"Tf" => material.tf = self.color(keyword)?.or(material.tf),
            b"Ni" => material.ni = Some(self.number(keyword)?),
            b"Tr" => material.tr = Some(self.number(keyword)?),
            b"illum" => material.illum = Some(self.number(keyword)?),
            b"d" => {
                let mut option = self.cursor;
                option.skip_blanks();
                if option.word() == b"-halo" {
                    self.cursor = option;
                    self.leave_out(b"d -halo", at);
                }
                material.d = Some(self.number(keyword)?);
            }
            b"Ns" => material.ns = Some(self.number(keyword)?),
            b"Pr" => material.pr = Some(self.number(keyword)?),
            b"Pm" => material.pm = Some(self.number(keyword)?),
            b"Ps" => material.ps = self.number(keyword)?,
            b"Pc" => material.pc = self.number(keyword)?,
            b"Pcr" => material.pcr = self.number(keyword)?,
            b"aniso" => material.aniso = self.number(keyword)?,
            b"anisor" => material.anisor = self.number(keyword)?,
            // Ambient light is what a path tracer computes; sharpness is of reflection maps; the
            // others say how those above are, and `map_aat` how textures are smoothed.
            b"Ka" | b"sharpness" | b"map_aat" => {}
            b"map_Kd" => material.map_kd = self.picture(at, Encoding::Srgb).or(material.map_kd),
            b"map_Ke" => material.map_ke = self.picture(at, Encoding::Srgb).or(material.map_ke),
            b"map_Pr" => material.map_pr = self.picture(at, Encoding::Linear).or(material.map_pr),
            b"map_Pm" => material.map_pm = self.picture(at, Encoding::Linear).or(material.map_pm),
            b"map_Ks" => material.map_ks = self.picture(at, Encoding::Srgb).or(material.map_ks),
            b"map_Tr" => material.map_tr = self.picture(at, Encoding::Linear).or(material.map_tr),
            b"bump" | b"map_bump" | b"map_Bump" => {
                material.bump = self.scaled_picture(at, Encoding::Linear).or(material.bump);
            }
            b"map_d" => material.map_d = self.picture(at, Encoding::Linear).or(material.map_d),
            b"norm" => material.norm = self.picture(at, Encoding::Linear).or(material.norm),
            _ if is_texture(keyword) => self.texture(keyword, at),
            _ => self.leave_out(keyword, at),
        }
        Ok(())
    }

    /// The options before the name of a texture: where on it coordinates point, what lies beyond its
    /// edges, and the factor on its heights. Nothing in them is an error.
    fn options(&mut self) -> (UvMapping, Wrap, f32) {
        let (mut mapping, mut wrap, mut height) = (UvMapping::default(), Wrap::Repeat, 1.0);
        loop {
            let mut option = self.cursor;
            option.skip_blanks();
            let keyword = option.word();
            let Some(values) = texture_option(keyword) else {
                return (mapping, wrap, height);
            };
            self.cursor = option;
            let usual = if [&b"-s"[..], b"-bm"].contains(&keyword) { 1.0 } else { 0.0 };
            let mut numbers = [usual; 3];
            for (i, number) in numbers.iter_mut().enumerate().take(values as usize) {
                let mut value = self.cursor;
                value.skip_blanks();
                match value.number() {
                    Some(given) if given.is_finite() => *number = given,
                    Some(_) => {}
                    // Of three numbers, those behind the first may be absent.
                    None if i > 0 => break,
                    None => {
                        let word = value.word();
                        if keyword == b"-clamp" && word == b"on" {
                            wrap = Wrap::Clamp;
                        }
                    }
                }
                self.cursor = value;
            }
            let [u, v, _] = numbers;
            match keyword {
                b"-s" => mapping.scale = Vec2::new(u, v),
                b"-o" => mapping.offset = Vec2::new(u, v),
                b"-bm" => height = u,
                _ => {}
            }
        }
    }

    /// Options and the name of a picture, as a texture; `None` without a name.
    fn picture(&mut self, at: usize, encoding: Encoding) -> Option<TextureId> {
        self.scaled_picture(at, encoding).map(|(texture, _)| texture)
    }

    /// The same with the factor on its heights.
    fn scaled_picture(&mut self, at: usize, encoding: Encoding) -> Option<(TextureId, f32)> {
        let (mapping, wrap, height) = self.options();
        let name = self.cursor.name();
        // Some exporters write the statement where there is no texture.
        if name.is_empty() {
            return None;
        }
        let Library { textures, pictures, .. } = &mut self.library;
        let bitmap = match self.known_pictures.get(&name) {
            Some(id) => *id,
            None => {
                let id = BitmapId(pictures.len() as u32);
                self.known_pictures.insert(name.clone(), id);
                pictures.push(Picture { name, at: self.places.place(self.path, self.bytes, at) });
                id
            }
        };
        let UvMapping { scale, offset, .. } = mapping;
        let bits = [scale.x, scale.y, offset.x, offset.y].map(f32::to_bits);
        let id = *self.known_textures.entry((bitmap, bits, wrap, encoding)).or_insert_with(|| {
            let wrap = [wrap; 2];
            textures.push(ImageTexture { mapping, wrap, encoding, ..ImageTexture::new(bitmap) });
            TextureId(textures.len() as u32 - 1)
        });
        Some((id, height))
    }

    /// Options and the name of a texture that nobody uses.
    fn texture(&mut self, keyword: &'a [u8], at: usize) {
        self.options();
        let name = self.cursor.name();
        // Some exporters write the statement where there is no texture.
        if !name.is_empty() {
            if self.textures.len() < MOST_LEFT_OUT {
                self.textures.insert(keyword);
            }
            let first = || (0, at, quoted(name.as_bytes()));
            self.first_texture.get_or_insert_with(first).0 += 1;
        }
    }

    fn leave_out(&mut self, keyword: &'a [u8], at: usize) {
        let full = self.left_out.len() >= MOST_LEFT_OUT && !self.left_out.contains_key(keyword);
        let (count, _) = self.left_out.entry(if full { b"" } else { keyword }).or_insert((0, at));
        *count += 1;
    }

    /// Three numbers, or one for all three; `None` for a colour given in a way that is not read.
    fn color(&mut self, keyword: &'a [u8]) -> Result<Option<[f32; 3]>, SceneError> {
        self.cursor.skip_blanks();
        let at = self.cursor.at;
        let mut option = self.cursor;
        match option.word() {
            b"spectral" | b"xyz" => {
                let what = format!("{} by spectrum or xyz is not read", decode(keyword));
                self.note(at, &what);
                return Ok(None);
            }
            _ => {}
        }
        let r = self.number(keyword)?;
        let g = if self.cursor.line_is_done() { r } else { self.number(keyword)? };
        let b = if self.cursor.line_is_done() { r } else { self.number(keyword)? };
        Ok(Some([r, g, b]))
    }

    fn number(&mut self, keyword: &[u8]) -> Result<f32, SceneError> {
        if self.cursor.line_is_done() {
            let what = format!("{} needs a number", decode(keyword));
            return Err(self.invalid(self.cursor.at, what));
        }
        let at = self.cursor.at;
        match self.cursor.number() {
            Some(number) if number.is_finite() => Ok(number),
            Some(number) => {
                let keyword = decode(keyword);
                let what = format!("{keyword} is {number}, but must be finite");
                Err(self.invalid(at, what))
            }
            None => {
                let word = word_at(self.bytes, at);
                Err(self.invalid(at, format!("{word} is not a number")))
            }
        }
    }

    /// Makes a material of its statements.
    fn finish(&mut self, written: Written) {
        let at = written.at;
        let shown = quoted(written.name.as_bytes());
        if !self.names.insert(written.name.clone()) {
            self.repeated.get_or_insert((0, at, shown)).0 += 1;
            return;
        }

        // How much light goes through: two words for one thing, and files where they disagree.
        let mut dissolve = written.d.or(written.tr.map(|tr| 1.0 - tr)).unwrap_or(1.0);
        if let (Some(d), Some(tr)) = (written.d, written.tr)
            && (d + tr - 1.0).abs() > 0.01
        {
            dissolve = d;
            self.note(at, &format!("material {shown}: d {d} and Tr {tr} disagree; d counts"));
        }
        let illum = written.illum.unwrap_or(2.0);
        let dark_kd = written.kd.is_none_or(|kd| brightest(Rgb(kd)) <= DARK);
        let refracts = written.ni.is_some_and(|ni| ni > 1.0);

        let has_holes = written.map_d.is_some() || written.map_tr.is_some();
        let clear = dissolve < 1.0 && !has_holes
            || [6.0, 7.0, 9.0].contains(&illum)
            || (illum == 4.0 && (refracts || dark_kd));
        if illum == 4.0 && !clear {
            self.note(at, &format!("material {shown}: illum 4 without d or Ni is taken as matte"));
        }
        let kind = if clear {
            self.without_map_ks(&written, &shown);
            let glass = self.dielectric(&written, &shown);
            Surface::Plain(if written.is_layered() {
                let layers = self.layers(&written, &shown);
                MaterialKind::Principled(Box::new(Principled {
                    base_color: Rgb::WHITE,
                    metallic: 0.0,
                    // What is too dense to be rough is smooth.
                    anisotropy: if glass.interior.ior > MOST_ROUGH_RATIO {
                        0.0
                    } else {
                        layers.anisotropy
                    },
                    roughness: glass.roughness,
                    ior: glass.interior.ior,
                    transmission: 1.0,
                    absorption: glass.interior.absorption,
                    ..layers
                }))
            } else {
                MaterialKind::Dielectric(glass)
            })
        } else {
            self.opaque(&written, dark_kd, &shown)
        };
        let ke = written.ke.filter(|ke| written.map_ke.is_none() || *ke != [0.0; 3]);
        let ke = ke.or(written.map_ke.map(|_| [1.0; 3]));
        let emission = ke.and_then(|ke| {
            let radiance = self.clamped("Ke", ke, 0.0, MOST_LIGHT, at, &shown);
            let texture = written.map_ke;
            let glow = || Emission { texture, ..Emission::radiance(radiance) };
            (radiance != Rgb::BLACK).then(glow)
        });
        if written.norm.is_some() && written.bump.is_some() {
            self.note(at, &format!("material {shown}: bump is left out beside norm"));
        }
        let normals = |texture| NormalMap { texture, scale: 1.0, shows: Bumps::Normals };
        let heights = |(texture, scale)| NormalMap { texture, scale, shows: Bumps::Heights };
        let normal_map = written.norm.map(normals).or(written.bump.map(heights));
        let bitmap = |id: TextureId| self.library.textures[id.0 as usize].bitmap;
        let in_color = |id: TextureId| written.map_kd.is_some_and(|kd| bitmap(kd) == bitmap(id));
        let holes = written.map_d.map(|texture| {
            let channel = if in_color(texture) { Channel::Alpha } else { Channel::Red };
            (texture, channel, dissolve.clamp(0.0, 1.0))
        });
        // What is there, d, is not meant to be nothing where a picture says what is not there.
        let holes = holes.or(written.map_tr.map(|texture| {
            let alpha = in_color(texture);
            let channel = if alpha { Channel::InverseAlpha } else { Channel::InverseRed };
            let there = written.d.unwrap_or(1.0).clamp(0.0, 1.0);
            (texture, channel, if there > 0.0 { there } else { 1.0 })
        }));
        let opacity = holes.map(|(texture, channel, factor)| Opacity {
            amount: ScalarInput { factor, texture: Some((texture, channel)) },
            vertex_colors: false,
            mode: OpacityMode::Blend,
        });
        let materials = &mut self.library.materials;
        let (kind, parts) = match kind {
            Surface::Plain(kind) => (kind, None),
            Surface::Over { below, gloss, share } => {
                let next = materials.len() as u32 + 1;
                let [first, second] = [MaterialId(next), MaterialId(next + 1)];
                let mix = Mix { first, second, amount: share };
                (MaterialKind::Mix(mix), Some([below, gloss]))
            }
        };
        let material = Material::new(kind).named(written.name);
        materials.push(Material { emission, opacity, normal_map, ..material });
        materials.extend(parts.into_iter().flatten().map(Material::new));
    }

    /// What light does not go through.
    fn opaque(&mut self, written: &Written, dark_kd: bool, shown: &str) -> Surface {
        let at = written.at;
        let usual = if written.map_kd.is_some() { [1.0; 3] } else { DEFAULT_ALBEDO };
        let mut kd = written.kd.unwrap_or(usual);
        if written.map_kd.is_some() && kd == [0.0; 3] {
            self.note(at, &format!("material {shown}: Kd 0 0 0 is taken as 1 1 1 for its map_Kd"));
            kd = usual;
        }
        let albedo = self.clamped("Kd", kd, 0.0, 1.0, at, shown);
        let albedo = ColorInput { texture: written.map_kd, ..albedo.into() };
        let below = || MaterialKind::Matte(Matte::new(albedo));

        // The physically based additions say it in their own words.
        let painted = written.map_pr.is_some() || written.map_pm.is_some();
        let said = written.pr.is_some() || written.pm.is_some_and(|pm| pm != 0.0);
        if said || painted || written.is_layered() {
            self.without_map_ks(written, shown);
            let base_color = albedo.factor;
            let mut layers = Principled { base_color, ..self.layers(written, shown) };
            layers.textures.base_color = written.map_kd;
            return Surface::Plain(MaterialKind::Principled(Box::new(layers)));
        }
        let fresnel = |ni: f32| ((ni - 1.0) / (ni + 1.0)) * ((ni - 1.0) / (ni + 1.0));
        let refracting =
            written.ni.filter(|ni| *ni > 1.0).map(|ni| self.index(ni, written.at, shown));
        let ks = match (written.ks, written.map_ks) {
            (None | Some([0.0, 0.0, 0.0]), Some(_)) => [1.0; 3],
            (Some(ks), _) => ks,
            (None, None) => return Surface::Plain(below()),
        };
        let ks = self.clamped("Ks", ks, 0.0, 1.0, at, shown);
        let ns = written.ns.map(|ns| ns.max(0.0));
        // The root of α, and the part of Ks that is reflected straight on.
        let roughness = |ns: f32| (2.0 / (ns + 2.0)).sqrt().sqrt();
        let part = |ns: f32| match refracting {
            _ if dark_kd && written.map_kd.is_none() => 1.0,
            Some(ni) => fresnel(ni),
            None if written.ni.is_some() => 1.0,
            None => (8.0 / (ns + 2.0)).clamp(fresnel(DEFAULT_IOR), 1.0),
        };
        let (width, part) = match (written.illum.unwrap_or(2.0), ns) {
            (5.0, _) => (0.0, 1.0),
            (3.0 | 8.0, ns) => (ns.map_or(0.0, roughness), 1.0),
            (0.0 | 1.0, _) | (_, None) => return Surface::Plain(below()),
            (_, Some(ns)) => (roughness(ns), part(ns)),
        };
        let reflected = Rgb(ks.0.map(|c| c * part));
        let Some(map) = written.map_ks else { return over(albedo, reflected, width) };
        // Only layers take a picture of their gloss: that of a dielectric, brightened to what is said.
        let ior = refracting.unwrap_or(DEFAULT_IOR);
        let mut layers = Principled {
            base_color: albedo.factor,
            roughness: width,
            ior,
            specular_color: Rgb(reflected.0.map(|c| (c / fresnel(ior)).min(MAX_SPECULAR_COLOR))),
            ..Principled::default()
        };
        layers.textures.base_color = written.map_kd;
        layers.textures.specular_color = Some(map);
        Surface::Plain(MaterialKind::Principled(Box::new(layers)))
    }

    /// The layers that the physically based additions say, over a base that is still to be told.
    fn layers(&mut self, written: &Written, shown: &str) -> Principled {
        let ior = written.ni.filter(|ni| *ni > 1.0).map(|ni| self.index(ni, written.at, shown));
        let mut unit = |keyword, number| self.in_unit(keyword, number, written.at, shown);
        let coat = unit("Pc", written.pc);
        // What a picture multiplies is not meant to be 0.
        let painted = |number: Option<f32>, map: Option<TextureId>, usual| match map {
            Some(_) => number.filter(|n| *n != 0.0).unwrap_or(1.0),
            None => number.unwrap_or(usual),
        };
        let red = |map: Option<TextureId>| map.map(|id| (id, Channel::Red));
        Principled {
            metallic: unit("Pm", painted(written.pm, written.map_pm, 0.0)),
            roughness: unit("Pr", painted(written.pr, written.map_pr, DEFAULT_ROUGHNESS)),
            textures: PrincipledTextures {
                metallic: red(written.map_pm),
                roughness: red(written.map_pr),
                ..PrincipledTextures::default()
            },
            ior: ior.unwrap_or(DEFAULT_IOR),
            coat,
            coat_roughness: if coat > 0.0 { unit("Pcr", written.pcr) } else { 0.0 },
            sheen_color: Rgb::grey(unit("Ps", written.ps)),
            anisotropy: unit("aniso", written.aniso),
            // In turns.
            anisotropy_rotation: (360.0 * written.anisor.rem_euclid(1.0)).to_radians(),
            ..Principled::default()
        }
    }

    fn without_map_ks(&mut self, written: &Written, shown: &str) {
        if written.map_ks.is_some() {
            let what = format!(
                "material {shown}: map_Ks is left out on glass and beside Pr, Pm, Pc, Ps, aniso"
            );
            self.note(written.at, &what);
        }
    }

    /// An index above 1, brought into the range with a note if that changes it.
    fn index(&mut self, ni: f32, at: usize, shown: &str) -> f32 {
        if ni > MAX_IOR {
            self.note(at, &format!("material {shown}: Ni {ni} is taken as {MAX_IOR}"));
        }
        ni.min(MAX_IOR)
    }

    fn dielectric(&mut self, written: &Written, shown: &str) -> Dielectric {
        let ior = match written.ni {
            Some(ni) if ni > 1.0 => self.index(ni, written.at, shown),
            Some(ni) => {
                let what = format!("material {shown}: Ni {ni} is taken as {DEFAULT_IOR}");
                self.note(written.at, &what);
                DEFAULT_IOR
            }
            None => DEFAULT_IOR,
        };
        let mut dielectric = Dielectric::new(ior);
        if let Some(pr) = written.pr {
            dielectric.roughness = self.in_unit("Pr", pr, written.at, shown);
        }
        if dielectric.roughness > 0.0 && ior > MOST_ROUGH_RATIO {
            let what = format!(
                "material {shown}: Pr is taken as 0, for glass with Ni above {MOST_ROUGH_RATIO} \
                 must be smooth"
            );
            self.note(written.at, &what);
            dielectric.roughness = 0.0;
        }
        if let Some(tf) = written.tf {
            let color = self.clamped("Tf", tf, f32::MIN_POSITIVE, 1.0, written.at, shown);
            if color != Rgb::WHITE {
                dielectric.interior.absorption =
                    Absorption::ColorAtDistance { color, distance: 1.0 };
            }
        }
        dielectric
    }

    /// A number brought into 0 to 1, with a note if that changes it.
    fn in_unit(&mut self, keyword: &str, number: f32, at: usize, shown: &str) -> f32 {
        let clamped = number.clamp(0.0, 1.0);
        if clamped != number {
            let what = format!("material {shown}: {keyword} {number} is taken as {clamped}");
            self.note(at, &what);
        }
        clamped
    }

    /// A colour with every channel in a range, and a note if that changes it.
    fn clamped(
        &mut self,
        keyword: &str,
        color: [f32; 3],
        least: f32,
        most: f32,
        at: usize,
        shown: &str,
    ) -> Rgb {
        let clamped = color.map(|c| c.clamp(least, most));
        if clamped != color {
            let [r, g, b] = color;
            // With an exponent where there would be nothing but zeros.
            let plain = |v: f32| v == 0.0 || (1e-5..1e7).contains(&v);
            let [least, most] =
                [least, most].map(|v| if plain(v) { v.to_string() } else { format!("{v:e}") });
            let what = format!(
                "material {shown}: {keyword} {r} {g} {b} is brought into the range {least} to {most}"
            );
            self.note(at, &what);
        }
        Rgb(clamped)
    }

    fn note(&mut self, at: usize, what: &str) {
        if self.library.notes.len() == MOST_NOTES {
            self.library.notes.push(format!("{}: … and more", self.path.display()));
        }
        if self.library.notes.len() > MOST_NOTES {
            return;
        }
        let source = place(self.path, self.bytes, at);
        let line = Source { column: 0, ..source };
        self.library.notes.push(format!("{line}: {what}"));
    }

    fn invalid(&self, at: usize, what: String) -> SceneError {
        SceneError { at: place(self.path, self.bytes, at), kind: SceneErrorKind::Invalid(what) }
    }
}

/// How a material scatters.
enum Surface {
    Plain(MaterialKind),
    /// A mix of two.
    Over {
        below: MaterialKind,
        gloss: MaterialKind,
        /// That of the gloss.
        share: f32,
    },
}

/// A gloss over a matte surface. Together they send back what they get at most, in all channels:
/// where they would send back more, both are dimmed.
fn over(albedo: ColorInput, reflectance: Rgb, roughness: f32) -> Surface {
    let (most_below, most_gloss) = (brightest(albedo.factor), brightest(reflectance));
    if most_gloss == 0.0 {
        return Surface::Plain(MaterialKind::Matte(Matte::new(albedo)));
    }
    if most_below == 0.0 {
        return Surface::Plain(gloss(reflectance, roughness));
    }
    let share = most_gloss / (most_below + most_gloss).max(1.0);
    // What each has of its share: no channel of either is above 1.
    let dimmed = |color: Rgb, by: f32| Rgb(color.0.map(|c| (c / by).min(1.0)));
    let factor = dimmed(albedo.factor, (most_below + most_gloss).max(1.0) * (1.0 - share));
    let below = ColorInput { factor, ..albedo };
    Surface::Over {
        below: MaterialKind::Matte(Matte::new(below)),
        gloss: gloss(dimmed(reflectance, most_gloss), roughness),
        share,
    }
}

/// What reflects a colour at normal incidence, sharply or not.
fn gloss(reflectance: Rgb, roughness: f32) -> MaterialKind {
    if roughness == 0.0 {
        return MaterialKind::Mirror(Mirror { reflectance });
    }
    // Gulbrandsen 2014, with an edge tint of 1: n and k of which normal incidence gives r.
    let eta = Rgb(reflectance.0.map(|r| (1.0 - r) / (1.0 + r)));
    let k = Rgb(reflectance.0.map(|r| 2.0 * r.sqrt() / (1.0 + r)));
    MaterialKind::Conductor(Conductor::new(eta, k, roughness))
}

/// The brightest channel.
fn brightest(color: Rgb) -> f32 {
    color.0.into_iter().fold(0.0, f32::max)
}

/// The roughness of a principled material that states none.
const DEFAULT_ROUGHNESS: f32 = 0.5;

/// Whether a statement names a texture.
fn is_texture(keyword: &[u8]) -> bool {
    let has_prefix = keyword.get(..4).is_some_and(|head| head.eq_ignore_ascii_case(b"map_"));
    has_prefix || [&b"bump"[..], b"disp", b"decal", b"refl", b"norm"].contains(&keyword)
}

/// How many values an option of a texture has at most; `None` for what is no option.
fn texture_option(word: &[u8]) -> Option<u32> {
    Some(match word {
        b"-blendu" | b"-blendv" | b"-boost" | b"-cc" | b"-clamp" | b"-texres" | b"-imfchan"
        | b"-type" | b"-bm" => 1,
        b"-mm" => 2,
        b"-o" | b"-s" | b"-t" => 3,
        _ => return None,
    })
}
