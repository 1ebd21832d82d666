//! Wavefront MTL: the materials of OBJ files, as near as the materials here come to them.
//!
//! MTL describes the shading of 1990: a diffuse and a specular colour and a
//! number for the formula that joins them. What light does is taken from it:
//!
//! | in the file                                    | here                        |
//! |------------------------------------------------|-----------------------------|
//! | `Ke` not black                                 | also gives that radiance, on its front |
//! | `d` below 1, or `illum` 4, 6, 7, 9             | dielectric of index `Ni` (1.5 where absent or up to 1), coloured `Tf` after 1 m |
//! | `illum` 5, or 3 with bright `Ks` and dark `Kd` | mirror of reflectance `Ks`  |
//! | everything else                                | matte of albedo `Kd` (0.8 where absent) |
//!
//! `illum 4` alone is not believed where `Kd` is not dark, `d` is 1 and `Ni` is
//! absent or up to 1: a widespread exporter writes so for every matte surface.
//! `Ns` is the width of a highlight, never the share of a mirror. Textures and
//! the physically based additions are left out, with a note.
//!
//! Source: Wavefront, *Advanced Visualizer Manual*, MTL material format, 1995.

use super::text::{Cursor, place, word_at};
use crate::error::{SceneError, SceneErrorKind, Source};
use crate::file;
use crate::limits::Limits;
use crate::shown::{decode, quoted};
use rutilant::color::Rgb;
use rutilant::material::{Absorption, Dielectric, Emission, Material, Matte, Mirror};
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

/// What an MTL file holds.
#[derive(Clone, Debug, Default)]
pub struct Library {
    /// Its materials, each name once.
    pub materials: Vec<Material>,
    /// What was left out or changed: one line each.
    pub notes: Vec<String>,
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
        library: Library::default(),
        names: HashSet::new(),
        repeated: None,
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
}

struct Parser<'a> {
    bytes: &'a [u8],
    path: &'a Path,
    cursor: Cursor<'a>,
    /// Statements that nobody reads: how often, and where first.
    left_out: BTreeMap<&'a [u8], (u64, usize)>,
    library: Library,
    names: HashSet<String>,
    /// Materials that come again: how many, and where and which the first is.
    repeated: Option<(u64, usize, String)>,
}

/// A colour is dark when no channel is brighter than this. Exporters write small numbers where
/// they mean none.
const DARK: f32 = 0.05;

/// A colour is bright when a channel is at least this.
const BRIGHT: f32 = 0.5;

/// The albedo of a matte material that states none: what modelling programs show then.
const DEFAULT_ALBEDO: [f32; 3] = [0.8; 3];

/// The index of refraction of glass, where the file has none that refracts.
const DEFAULT_IOR: f32 = 1.5;

/// The largest index of refraction that a material takes.
const LARGEST_IOR: f32 = 10.0;

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
            // Ambient light is what a path tracer computes; highlights need a rough surface,
            // which none of these materials has; sharpness is of reflection maps.
            b"Ka" | b"Ns" | b"sharpness" => {}
            _ => self.leave_out(keyword, at),
        }
        Ok(())
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
        let brightest = |color: Option<[f32; 3]>| match color {
            Some([r, g, b]) => r.max(g).max(b),
            None => 0.0,
        };
        let dark_kd = brightest(written.kd) <= DARK;
        let refracts = written.ni.is_some_and(|ni| ni > 1.0);

        let clear = dissolve < 1.0
            || [6.0, 7.0, 9.0].contains(&illum)
            || (illum == 4.0 && (refracts || dark_kd));
        if illum == 4.0 && !clear {
            self.note(at, &format!("material {shown}: illum 4 without d or Ni is taken as matte"));
        }
        let mirrors = brightest(written.ks) > 0.0
            && (illum == 5.0 || (illum == 3.0 && brightest(written.ks) >= BRIGHT && dark_kd));

        let material: Material = if clear {
            self.dielectric(&written, &shown).into()
        } else if mirrors {
            let ks = written.ks.unwrap_or_default();
            Mirror { reflectance: self.clamped("Ks", ks, 0.0, 1.0, at, &shown) }.into()
        } else {
            let kd = written.kd.unwrap_or(DEFAULT_ALBEDO);
            Matte::new(self.clamped("Kd", kd, 0.0, 1.0, at, &shown)).into()
        };
        let mut material = material.named(written.name);
        if let Some(ke) = written.ke {
            let radiance = self.clamped("Ke", ke, 0.0, f32::MAX, at, &shown);
            if radiance != Rgb::BLACK {
                material = material.emitting(Emission::radiance(radiance));
            }
        }
        self.library.materials.push(material);
    }

    fn dielectric(&mut self, written: &Written, shown: &str) -> Dielectric {
        let ior = match written.ni {
            Some(ni) if ni > LARGEST_IOR => {
                let what = format!("material {shown}: Ni {ni} is taken as {LARGEST_IOR}");
                self.note(written.at, &what);
                LARGEST_IOR
            }
            Some(ni) if ni > 1.0 => ni,
            Some(ni) => {
                let what = format!("material {shown}: Ni {ni} is taken as {DEFAULT_IOR}");
                self.note(written.at, &what);
                DEFAULT_IOR
            }
            None => DEFAULT_IOR,
        };
        let mut dielectric = Dielectric::new(ior);
        if let Some(tf) = written.tf {
            let color = self.clamped("Tf", tf, f32::MIN_POSITIVE, 1.0, written.at, shown);
            if color != Rgb::WHITE {
                dielectric.interior.absorption =
                    Absorption::ColorAtDistance { color, distance: 1.0 };
            }
        }
        dielectric
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
            let range =
                if most == f32::MAX { "0 or more".to_owned() } else { format!("0 to {most}") };
            let what = format!(
                "material {shown}: {keyword} {r} {g} {b} is brought into the range {range}"
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
