//! How surfaces scatter: Mitsuba's BSDFs as materials.
//!
//! Most have a material of their own. What has none becomes layers or a mixture where these say the
//! same, and else the nearest there is, with a note. Microfacets of layers follow GGX here whatever
//! is asked for, with the α that is asked for: α is the square of a roughness.

use super::document::{Class, View};
use super::scene::Maker;
use super::texture::{Paint, Use};
use super::value::Value;
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::disney::tint_once;
use crate::scene::nearest::nearest;
use crate::scene::spectrum::{self, MOST_REFLECTED, normal_reflectance};
use crate::shown::shown;
use rutilant::bsdf::{Distribution, Fresnel};
use rutilant::color::Rgb;
use rutilant::material::{
    Absorption, Bumps, Conductor, Dielectric, MAX_IOR, MOST_ROUGH_RATIO, Material, MaterialKind,
    Matte, Medium, Mirror, Mix, NormalMap, Opacity, OpacityMode, Principled, PrincipledTextures,
    ThinDielectric,
};
use rutilant::texture::{Encoding, ScalarInput, Texture};
use rutilant_geom::{Vec3, real};

/// How a surface looks, without its light.
#[derive(Clone, Debug)]
pub(super) struct Look {
    pub(super) kind: MaterialKind,
    pub(super) opacity: Option<Opacity>,
    pub(super) normal_map: Option<NormalMap>,
    pub(super) name: String,
    /// Whether it looks the same from behind.
    pub(super) two_sided: bool,
    /// Whether some of it varies with texture coordinates.
    pub(super) textured: bool,
}

impl Look {
    fn new(kind: MaterialKind) -> Self {
        let (opacity, normal_map, name) = (None, None, String::new());
        Self { kind, opacity, normal_map, name, two_sided: false, textured: false }
    }

    fn painted(kind: MaterialKind, textured: bool) -> Self {
        Self { textured, ..Self::new(kind) }
    }

    /// What Mitsuba gives shapes that name no BSDF.
    pub(super) fn grey() -> Self {
        let grey = Matte::new(Rgb::grey(0.5));
        Self { name: "default".to_owned(), ..Self::new(MaterialKind::Matte(grey)) }
    }

    /// What Mitsuba gives lamps that name no BSDF.
    pub(super) fn black() -> Self {
        Self { name: "lamp".to_owned(), ..Self::new(MaterialKind::Black) }
    }

    /// As a material that gives no light.
    pub(super) fn material(self) -> Material {
        let Self { kind, opacity, normal_map, name, .. } = self;
        Material { opacity, normal_map, ..Material::new(kind).named(name) }
    }
}

/// BSDFs refer to BSDFs; no sensible one does so more deeply.
const DEEPEST: u32 = 16;

/// All that are read.
const KNOWN: &[&str] = &[
    "diffuse",
    "roughdiffuse",
    "conductor",
    "roughconductor",
    "dielectric",
    "roughdielectric",
    "thindielectric",
    "plastic",
    "roughplastic",
    "principled",
    "principledthin",
    "twosided",
    "mask",
    "bumpmap",
    "normalmap",
    "blendbsdf",
    "null",
];

/// Indices of refraction by Mitsuba's own table where it differs from makers' catalogues.
const MITSUBA_BK7: f32 = 1.5046;
const MITSUBA_AIR: f32 = 1.000_277;

impl Maker<'_, '_> {
    /// How the surface of a BSDF looks.
    pub(super) fn look(&mut self, bsdf: View<'_, '_>, depth: u32) -> Result<Look, SceneError> {
        if depth > DEEPEST {
            let what = "BSDFs refer to each other over and over";
            return Err(bsdf.document.invalid(bsdf.place(), what));
        }
        let look = match bsdf.plugin() {
            "diffuse" => {
                let albedo = self.paint(bsdf, "reflectance", Use::Surface)?;
                let albedo = albedo.unwrap_or(Paint::even(Rgb::grey(0.5)));
                Look::painted(MaterialKind::Matte(Matte::new(albedo.input())), albedo.varies())
            }
            "roughdiffuse" => {
                let albedo = self.paint(bsdf, "reflectance", Use::Surface)?;
                let albedo = albedo.unwrap_or(Paint::even(Rgb::grey(0.5)));
                let roughness = self.even_number(bsdf, "alpha", 0.2)?.clamp(0.0, 1.0);
                bsdf.pass_over(&["use_fast_approx"]);
                let matte = Matte { roughness, ..Matte::new(albedo.input()) };
                Look::painted(MaterialKind::Matte(matte), albedo.varies())
            }
            "conductor" => self.conductor(bsdf, Rough::NOT)?,
            "roughconductor" => {
                let rough = self.rough(bsdf)?;
                self.conductor(bsdf, rough)?
            }
            "dielectric" => self.dielectric(bsdf, 0.0, Distribution::Ggx)?,
            "roughdielectric" => {
                let Rough { alphas: [u, v], distribution } = self.rough(bsdf)?;
                if u != v {
                    let what = "rough glass is as rough one way as the other here: the mean of its \
                                alphas stands in";
                    bsdf.note(what, what);
                }
                self.dielectric(bsdf, (0.5 * (u + v)).sqrt(), distribution)?
            }
            "thindielectric" => {
                let ior = self.relative_ior(bsdf, MITSUBA_BK7)?;
                let color = self.even_color(bsdf, "specular_transmittance", Use::Surface)?;
                self.untinted(bsdf, "specular_reflectance")?;
                let pane = ThinDielectric { ior, color: color.unwrap_or(Rgb::WHITE) };
                Look::new(MaterialKind::ThinDielectric(pane))
            }
            "plastic" => self.plastic(bsdf, None)?,
            "roughplastic" => {
                let Rough { alphas: [u, v], distribution } = self.rough(bsdf)?;
                note_on_layers(bsdf, distribution);
                let is_ggx = distribution == Distribution::Ggx;
                self.plastic(bsdf, Some(Facets { alpha: 0.5 * (u + v), is_ggx }))?
            }
            "principled" | "principledthin" => self.principled(bsdf)?,
            "twosided" => {
                let mut inner = bsdf.parts(Class::Bsdf);
                let first = self.inner(bsdf, inner.next(), depth)?;
                if inner.next().is_some() {
                    let what = "the second BSDF of a \"twosided\" one is left out: both sides look \
                                as the front";
                    bsdf.note(what, what);
                }
                Look { two_sided: true, ..first }
            }
            "mask" => self.mask(bsdf, depth)?,
            "bumpmap" | "normalmap" => self.bumps(bsdf, depth)?,
            "blendbsdf" => self.blend(bsdf, depth)?,
            "null" => Look::new(MaterialKind::Null),
            _ => return Err(bsdf.unknown(KNOWN)),
        };
        let name = if bsdf.id().is_empty() { look.name } else { bsdf.id().to_owned() };
        Ok(Look { name, ..look })
    }

    fn inner(
        &mut self,
        of: View<'_, '_>,
        inner: Option<View<'_, '_>>,
        depth: u32,
    ) -> Result<Look, SceneError> {
        match inner {
            Some(inner) => self.look(inner, depth + 1),
            None => {
                let what = format!("bsdf \"{}\" needs another one within it", shown(of.plugin()));
                Err(of.document.invalid(of.place(), what))
            }
        }
    }

    /// The facets that are asked for.
    fn rough(&mut self, bsdf: View<'_, '_>) -> Result<Rough, SceneError> {
        let (beckmann, ggx) = (Distribution::Beckmann, Distribution::Ggx);
        let distribution = bsdf.choice(
            "distribution",
            &[("beckmann", Some(beckmann)), ("ggx", Some(ggx)), ("phong", None), ("as", None)],
        )?;
        if distribution.is_none() {
            let what = "microfacets that follow Phong are taken as Beckmann's of the same alpha";
            bsdf.note(what, what);
        }
        let distribution = distribution.unwrap_or(beckmann);
        bsdf.pass_over(&["sample_visible", "sample_all"]);
        let both = self.even_number(bsdf, "alpha", 0.1)?;
        let u = self.even_number(bsdf, "alpha_u", both)?;
        let v = self.even_number(bsdf, "alpha_v", both)?;
        if [u, v].iter().any(|alpha| !(0.0..=1.0).contains(alpha)) {
            let what = format!("an alpha of {} is taken as one within 0 and 1", u.max(v));
            bsdf.note(&what, &what);
        }
        Ok(Rough { alphas: [u, v].map(|alpha| alpha.clamp(0.0, 1.0)), distribution })
    }

    /// Real and imaginary part of a metal's index; `None` for what reflects everything.
    fn metal(&mut self, bsdf: View<'_, '_>) -> Result<Option<[Rgb; 2]>, SceneError> {
        let named = bsdf.text("material")?;
        if let Some(name) = named.filter(|name| *name != "none") {
            let known = spectrum::metal(name).or_else(|| spectrum::metal(name.get(..2)?));
            if known.is_some() {
                return Ok(known);
            }
            let place = bsdf.property("material").map_or(bsdf.place(), |written| written.place);
            let known = spectrum::METALS.join(", ");
            let what = format!(
                "the metal \"{}\" is not known here; there are {known}, or give its eta and k",
                shown(name)
            );
            return Err(bsdf.document.unsupported(place, what));
        }
        if let (Some(eta), Some(k)) = (self.samples(bsdf, "eta")?, self.samples(bsdf, "k")?) {
            return Ok(Some(spectrum::metal_of(&eta.held(), &k.held())));
        }
        let eta = self.even_color(bsdf, "eta", Use::Number)?;
        let k = self.even_color(bsdf, "k", Use::Number)?;
        if eta.is_none() && k.is_none() {
            return Ok(None);
        }
        let over = self.ior(bsdf, "ext_eta", 1.0)?;
        let part =
            |of: Option<Rgb>, default| Rgb(of.unwrap_or(Rgb::grey(default)).0.map(|c| c / over));
        Ok(Some([part(eta, 0.0), part(k, 1.0)]))
    }

    fn conductor(
        &mut self,
        bsdf: View<'_, '_>,
        Rough { alphas: [u, v], distribution }: Rough,
    ) -> Result<Look, SceneError> {
        let index = self.metal(bsdf)?;
        let tint = self.paint(bsdf, "specular_reflectance", Use::Surface)?;
        let tint = tint.unwrap_or(Paint::even(Rgb::WHITE));
        let roughness = u.min(v).sqrt();
        let normal =
            |[eta, k]: [Rgb; 2]| Rgb([0, 1, 2].map(|i| normal_reflectance(eta.0[i], k.0[i])));

        // What varies, or is rougher one way than the other, is a layer of metal.
        if tint.varies() || u != v {
            let what = "metal that varies, or is brushed, has the colour of its reflection at normal \
                        incidence, from where on Schlick's approximation says it";
            bsdf.note(what, what);
            note_on_layers(bsdf, distribution);
            let white = Rgb::WHITE;
            let color = index.map_or(white, normal);
            let color = Rgb([0, 1, 2].map(|i| (color.0[i] * tint.factor.0[i]).clamp(0.0, 1.0)));
            let mut layers = Principled {
                base_color: color,
                metallic: 1.0,
                roughness,
                thin_walled: true,
                textures: PrincipledTextures {
                    base_color: tint.texture,
                    vertex_colors: tint.vertex_colors,
                    ..PrincipledTextures::default()
                },
                ..Principled::default()
            };
            brush(&mut layers, [u, v]);
            return Ok(Look::painted(MaterialKind::Principled(Box::new(layers)), true));
        }

        let tint = tint.factor;
        let Some([eta, k]) = index else {
            if roughness == 0.0 {
                let color = Rgb(tint.0.map(|c| c.clamp(0.0, 1.0)));
                return Ok(Look::new(MaterialKind::Mirror(Mirror { reflectance: color })));
            }
            // Without a real part everything is reflected.
            let (eta, k) = (Rgb::BLACK, Rgb::WHITE);
            let all = Conductor { eta, k, roughness, distribution };
            return Ok(Look::new(self.dimmed(all, tint, bsdf)));
        };
        Ok(Look::new(self.dimmed(Conductor { eta, k, roughness, distribution }, tint, bsdf)))
    }

    /// A metal of which a part is black. Where the part is another for each channel, the index is
    /// changed until reflection at normal incidence is right.
    fn dimmed(&mut self, metal: Conductor, tint: Rgb, bsdf: View<'_, '_>) -> MaterialKind {
        let [r, g, b] = tint.0.map(|c| c.clamp(0.0, 1.0));
        let most = r.max(g).max(b);
        if most == 0.0 {
            return MaterialKind::Black;
        }
        let mut metal = metal;
        if [r, g, b] != [most; 3] {
            let what = "a coloured specular_reflectance of metal is right at normal incidence; at \
                        grazing angles it is whiter than it says";
            bsdf.note(what, what);
            for (i, part) in [r, g, b].into_iter().enumerate() {
                let (eta, k) = (&mut metal.eta.0[i], &mut metal.k.0[i]);
                let wanted = normal_reflectance(*eta, *k) * part / most;
                (*eta, *k) = index_of(*eta, wanted);
            }
        }
        if most == 1.0 {
            return MaterialKind::Conductor(metal);
        }
        let first = self.add_part(MaterialKind::Conductor(metal));
        let second = self.add_part(MaterialKind::Black);
        MaterialKind::Mix(Mix { first, second, amount: 1.0 - most })
    }

    /// An index of refraction, by its number or by the name of a medium.
    fn ior(&mut self, bsdf: View<'_, '_>, name: &str, default: f32) -> Result<f32, SceneError> {
        let Some(written) = bsdf.property(name) else { return Ok(default) };
        let Value::Text(medium) = written.value else { return bsdf.number(name, default) };
        match (&**medium, spectrum::clear(medium)) {
            ("bk7", _) => Ok(MITSUBA_BK7),
            (_, Some(clear)) => Ok(clear.ior),
            (_, None) => {
                let media =
                    ["vacuum", "air", "water", "bk7", "diamond", "acrylic glass", "polypropylene"];
                let closest = nearest(medium, media).map(str::to_owned);
                let kind = SceneErrorKind::Unknown { what: "medium", name: shown(medium), closest };
                Err(bsdf.document.error(written.place, kind))
            }
        }
    }

    /// The index inside over that outside, at least 1.
    fn relative_ior(&mut self, bsdf: View<'_, '_>, default: f32) -> Result<f32, SceneError> {
        let inside = self.ior(bsdf, "int_ior", default)?;
        let outside = self.ior(bsdf, "ext_ior", MITSUBA_AIR)?;
        let ratio = inside / outside;
        if (1.0..=MAX_IOR).contains(&ratio) {
            return Ok(ratio);
        }
        let what = format!(
            "an index that is {ratio} times that outside is taken as one between 1 and {MAX_IOR}"
        );
        bsdf.note(&what, &what);
        Ok(if ratio.is_finite() { ratio.clamp(1.0, MAX_IOR) } else { 1.0 })
    }

    /// Factors on what glass reflects or lets through, which no glass has.
    fn untinted(&mut self, bsdf: View<'_, '_>, name: &str) -> Result<(), SceneError> {
        let Some(paint) = self.paint(bsdf, name, Use::Surface)? else { return Ok(()) };
        if paint != Paint::even(Rgb::WHITE) {
            let what = format!("{name} of \"{}\" is taken as 1", shown(bsdf.plugin()));
            bsdf.note(&what, &what);
        }
        Ok(())
    }

    fn dielectric(
        &mut self,
        bsdf: View<'_, '_>,
        roughness: f32,
        distribution: Distribution,
    ) -> Result<Look, SceneError> {
        let inside = self.ior(bsdf, "int_ior", MITSUBA_BK7)?;
        let outside = self.ior(bsdf, "ext_ior", MITSUBA_AIR)?;
        self.untinted(bsdf, "specular_reflectance")?;
        self.untinted(bsdf, "specular_transmittance")?;
        let medium = |ior| Medium { ior, absorption: Absorption::None };
        let ratio = (inside / outside).max(outside / inside);
        let mut roughness = roughness;
        if roughness > 0.0 && ratio > MOST_ROUGH_RATIO {
            let what = format!(
                "indices that differ by a factor of {ratio} can only be smooth: up to \
                 {MOST_ROUGH_RATIO} glass may be rough"
            );
            bsdf.note(&what, &what);
            roughness = 0.0;
        }
        Ok(Look::new(MaterialKind::Dielectric(Dielectric {
            interior: medium(inside),
            exterior: medium(outside),
            fresnel: Fresnel::Exact,
            priority: None,
            roughness,
            distribution,
            dispersion: 0.0,
        })))
    }

    /// Matte under a border of glass. With ρ below, F the mean that the border sends back from inside
    /// and T the mean that it lets in, what comes out is ρ T² / (η² (1 − F)), or (1 − ρ F) below where
    /// the series inside is summed up (`nonlinear`). Principled layers say T times their base colour,
    /// with a T in which facets lose nothing: for a smooth border 1 − F is T / η², and the base colour
    /// is ρ. Mitsuba's rough borders lose light; so much darker is the base colour here.
    fn plastic(&mut self, bsdf: View<'_, '_>, facets: Option<Facets>) -> Result<Look, SceneError> {
        let ior = self.relative_ior(bsdf, 1.49)?;
        let base = self.paint(bsdf, "diffuse_reflectance", Use::Surface)?;
        let mut base = base.unwrap_or(Paint::even(Rgb::grey(0.5)));
        self.untinted(bsdf, "specular_reflectance")?;
        let smooth = Facets { alpha: 0.0, is_ggx: true };
        let [all_through, _] = smooth.through(ior);
        let [through, out] = facets.unwrap_or(smooth).through(ior);
        let inside = 1.0 - out;
        let series = match bsdf.boolean("nonlinear", false)? {
            true if base.varies() => {
                let what = "a nonlinear plastic whose colour varies is taken as a linear one";
                bsdf.note(what, what);
                [out; 3]
            }
            true => base.factor.0.map(|c| 1.0 - c * inside),
            false => [out; 3],
        };
        let factor = through * through / (ior * ior * all_through);
        let color = |i: usize| base.factor.0[i] * (factor / series[i]).min(1.0);
        base.factor = Rgb([color(0), color(1), color(2)]);
        let layers = Principled {
            base_color: base.factor,
            metallic: 0.0,
            roughness: facets.map_or(0.0, |facets| facets.alpha.sqrt()),
            ior,
            thin_walled: true,
            textures: textures_of(base),
            ..Principled::default()
        };
        Ok(Look::painted(MaterialKind::Principled(Box::new(layers)), base.varies()))
    }

    fn principled(&mut self, bsdf: View<'_, '_>) -> Result<Look, SceneError> {
        let thin = bsdf.plugin() == "principledthin";
        let what = "Disney's principled BSDFs are shown by layers that are much like them, not the \
                    same: matte does not shine at grazing angles, and sheen is that of fibres";
        bsdf.note(what, what);
        let base = self.paint(bsdf, "base_color", Use::Surface)?;
        let base = base.unwrap_or(Paint::even(Rgb::grey(0.5)));
        let mut number = |name: &str, default: f32| self.scalar(bsdf, name, default);
        let roughness = number("roughness", 0.5)?;
        let metallic = number("metallic", 0.0)?;
        let transmission = number("spec_trans", 0.0)?;
        let coat = number("clearcoat", 0.0)?;
        let through = number("diff_trans", 0.0)?;
        let mut even = |name: &str, default: f32| self.even_number(bsdf, name, default);
        let anisotropic = even("anisotropic", 0.0)?;
        let spec_tint = even("spec_tint", 0.0)?;
        let sheen = even("sheen", 0.0)?;
        let sheen_tint = even("sheen_tint", 0.0)?;
        let coat_gloss = even("clearcoat_gloss", 0.0)?;
        let flatness = even("flatness", 0.0)?;
        let specular = bsdf.optional_number("specular")?;
        let eta = bsdf.optional_number("eta")?;
        bsdf.pass_over(&[
            "diffuse_reflectance_sampling_rate",
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
            "spec_reflect_sampling_rate",
            "spec_trans_sampling_rate",
            "diff_trans_sampling_rate",
        ]);
        if flatness != 0.0 {
            let what = "flatness of \"principled\" is left out";
            bsdf.note(what, what);
        }
        // Reflection at normal incidence is 0.08 times `specular`.
        let of_specular = |s: f32| 2.0 / (1.0 - (0.08 * s.clamp(0.0, 1.0)).sqrt()) - 1.0;
        let ior = match (eta, specular) {
            (Some(eta), _) => eta,
            (None, Some(specular)) => of_specular(specular),
            (None, None) if thin => 1.5,
            (None, None) => of_specular(0.5),
        };
        let tint = {
            let most = base.factor.0.iter().fold(0.0_f32, |most, c| most.max(*c));
            let hue = |c: f32| if most > 0.0 { c / most } else { 1.0 };
            base.factor.0.map(hue)
        };
        let towards = |amount: f32| Rgb(tint.map(|c| 1.0 + (c - 1.0) * amount.clamp(0.0, 1.0)));
        let part = |x: f32| x.clamp(0.0, 1.0);
        let gloss = part(coat_gloss);
        let coat_alpha = 0.1 + (0.001 - 0.1) * gloss;
        let mut layers = Principled {
            base_color: base.factor,
            metallic: part(metallic.factor),
            roughness: part(roughness.factor),
            specular_color: towards(spec_tint),
            ior: ior.clamp(1.0, MAX_IOR),
            transmission: part(transmission.factor),
            thin_walled: thin,
            // Disney's goes up to 2, where all of the matte body is behind.
            diffuse_transmission: part(0.5 * through.factor),
            diffuse_transmission_color: base.factor,
            coat: 0.25 * part(coat.factor),
            coat_roughness: coat_alpha.sqrt(),
            sheen_color: Rgb(towards(sheen_tint).0.map(|c| c * part(sheen))),
            textures: PrincipledTextures {
                metallic: metallic.texture,
                roughness: roughness.texture,
                transmission: transmission.texture,
                coat: coat.texture,
                diffuse_transmission: through.texture,
                ..textures_of(base)
            },
            ..Principled::default()
        };
        // The aspect of Burley 2012, section 5.4.
        let aspect = (1.0 - 0.9 * part(anisotropic)).sqrt();
        let alpha = layers.roughness * layers.roughness;
        if aspect < 1.0 {
            brush(&mut layers, [(alpha / aspect).min(1.0), alpha * aspect]);
        }
        if layers.has_inside() && layers.roughness > 0.0 {
            layers.ior = layers.ior.min(MOST_ROUGH_RATIO);
        }
        if let Some(what) = tint_once(&mut layers) {
            bsdf.note(what, what);
        }
        let textured = layers.textures.vary() || aspect < 1.0;
        Ok(Look::painted(MaterialKind::Principled(Box::new(layers)), textured))
    }

    fn mask(&mut self, bsdf: View<'_, '_>, depth: u32) -> Result<Look, SceneError> {
        let inner = bsdf.parts(Class::Bsdf).next();
        let inner = self.inner(bsdf, inner, depth)?;
        let amount = self.scalar(bsdf, "opacity", 0.5)?;
        if inner.opacity.is_some() {
            let what = "a mask within a mask is left out";
            bsdf.note(what, what);
        }
        let amount = ScalarInput { factor: amount.factor.clamp(0.0, 1.0), ..amount };
        let opacity = Some(Opacity { amount, vertex_colors: false, mode: OpacityMode::Blend });
        let textured = inner.textured || amount.texture.is_some();
        Ok(Look { opacity, textured, ..inner })
    }

    fn bumps(&mut self, bsdf: View<'_, '_>, depth: u32) -> Result<Look, SceneError> {
        let inner = bsdf.parts(Class::Bsdf).next();
        let inner = self.inner(bsdf, inner, depth)?;
        let map = bsdf.parts(Class::Texture).next();
        let Some(map) = map.filter(|map| map.plugin() == "bitmap") else {
            let what = format!(
                "bsdf \"{}\" needs a bitmap: nothing else shows bumps here",
                shown(bsdf.plugin())
            );
            return Err(bsdf.document.unsupported(bsdf.place(), what));
        };
        let texture = self.picture(map)?;
        let (shows, scale) = match bsdf.plugin() {
            "bumpmap" => (Bumps::Heights, bsdf.number("scale", 1.0)?),
            _ => (Bumps::Normals, 1.0),
        };
        bsdf.pass_over(&["flip_invalid_normals", "use_shadowing_function"]);
        if shows == Bumps::Normals {
            // Normals are numbers, whatever the file of the scene says of their encoding.
            if let Some(Texture::Image(image)) = self.scene.textures.get_mut(texture.0 as usize)
                && image.encoding == Encoding::Srgb
            {
                image.encoding = Encoding::Linear;
                let what =
                    "a picture of normals holds numbers, not colours: it is taken as \"raw\"";
                map.note(what, what);
            }
        }
        if inner.normal_map.is_some() {
            let what = "bumps on bumps are left out: the outer ones are shown";
            bsdf.note(what, what);
        }
        Ok(Look { normal_map: Some(NormalMap { texture, scale, shows }), textured: true, ..inner })
    }

    fn blend(&mut self, bsdf: View<'_, '_>, depth: u32) -> Result<Look, SceneError> {
        let mut inner = bsdf.parts(Class::Bsdf);
        let (first, second) = (inner.next(), inner.next());
        let first = self.inner(bsdf, first, depth)?;
        let second = self.inner(bsdf, second, depth)?;
        let amount = self.even_number(bsdf, "weight", 0.5)?.clamp(0.0, 1.0);
        let mixes = |look: &Look| match &look.kind {
            MaterialKind::Black
            | MaterialKind::Null
            | MaterialKind::Matte(_)
            | MaterialKind::Mirror(_)
            | MaterialKind::Conductor(_)
            | MaterialKind::ThinDielectric(_) => look.opacity.is_none(),
            MaterialKind::Dielectric(_)
            | MaterialKind::Principled(_)
            | MaterialKind::Mix(_)
            | MaterialKind::Custom(_) => false,
        };
        if !(mixes(&first) && mixes(&second)) {
            let what =
                "a blend of layers, glass or blends is not mixed: the larger part stands for all";
            bsdf.note(what, what);
            return Ok(if amount < 0.5 { first } else { second });
        }
        let textured = first.textured || second.textured;
        let two_sided = first.two_sided && second.two_sided;
        let normal_map = first.normal_map.or(second.normal_map);
        let (first, second) = (self.add_part(first.kind), self.add_part(second.kind));
        let mix = MaterialKind::Mix(Mix { first, second, amount });
        Ok(Look { two_sided, normal_map, ..Look::painted(mix, textured) })
    }

    fn add_part(&mut self, kind: MaterialKind) -> rutilant::scene::MaterialId {
        self.scene.add_material(Material::new(kind))
    }
}

fn textures_of(base: Paint) -> PrincipledTextures {
    PrincipledTextures {
        base_color: base.texture,
        vertex_colors: base.vertex_colors,
        ..PrincipledTextures::default()
    }
}

/// Makes facets steeper along u than along v, or the other way round. The larger α is
/// α + (1 − α) a² for the smaller α and anisotropy a.
fn brush(layers: &mut Principled, [u, v]: [f32; 2]) {
    let (least, most) = (u.min(v), u.max(v));
    layers.roughness = least.sqrt();
    if most > least {
        layers.anisotropy = ((most - least) / (1.0 - least)).sqrt();
        layers.anisotropy_rotation = if u >= v { 0.0 } else { 90.0_f32.to_radians() };
    }
}

/// An index that reflects so much at normal incidence: with this real part, if there is one.
fn index_of(eta: f32, reflectance: f32) -> (f32, f32) {
    let r = reflectance.clamp(0.0, MOST_REFLECTED);
    let k2 = (r * (eta + 1.0) * (eta + 1.0) - (eta - 1.0) * (eta - 1.0)) / (1.0 - r);
    if k2 >= 0.0 {
        return (eta, k2.sqrt());
    }
    // Too much is reflected by the real part alone: one that is nearer to 1.
    let root = r.sqrt();
    let above = (1.0 + root) / (1.0 - root);
    (if eta > 1.0 { above } else { 1.0 / above }, 0.0)
}

/// The facets of rough metal or glass.
#[derive(Clone, Copy, Debug)]
struct Rough {
    /// α along u and v, 0 to 1.
    alphas: [f32; 2],
    distribution: Distribution,
}

impl Rough {
    const NOT: Self = Self { alphas: [0.0; 2], distribution: Distribution::Ggx };
}

/// Tells that what becomes layers has facets of GGX.
fn note_on_layers(bsdf: View<'_, '_>, distribution: Distribution) {
    if distribution == Distribution::Beckmann {
        let what = "plastic, and metal that varies or is brushed, has facets of GGX in place of \
                    Beckmann's, with wider tails";
        bsdf.note(what, what);
    }
}

/// The facets of a rough border; smooth where α is 0.
#[derive(Clone, Copy, Debug)]
struct Facets {
    alpha: f32,
    /// Else Beckmann's.
    is_ggx: bool,
}

impl Facets {
    /// What a border of an index above 1 lets through, as a mean over cosine-weighted directions: from
    /// outside, and from inside. Light that facets throw into each other is lost, as in Mitsuba.
    fn through(self, eta: f32) -> [f32; 2] {
        let outside = 1.0 - self.mean_reflected(eta);
        // By reciprocity (Egan and Hilgeman, *Optical Properties of Inhomogeneous Materials*, 1979);
        // but what is lost is lost on both sides.
        let inside = match self.alpha {
            0.0 => outside / (eta * eta),
            _ => 1.0 - self.mean_reflected(1.0 / eta),
        };
        [outside, inside]
    }

    /// What the border reflects once, as a mean over cosine-weighted directions; `eta` is the index on
    /// the other side over that on this one.
    fn mean_reflected(self, eta: f32) -> f32 {
        const STEPS: u32 = 64;
        let each = (0..STEPS).map(|i| {
            // Even steps of sin²θ are those of the cosine-weighted hemisphere.
            let sin2 = (i as f32 + 0.5) / STEPS as f32;
            self.reflected(sin2.sqrt(), (1.0 - sin2).sqrt(), eta)
        });
        each.sum::<f32>() / STEPS as f32
    }

    /// The mean of F G₁(wi) G₁(wo) (wi·m) / (cos θi cos θm) over facets m that are drawn by their area
    /// seen from above (Walter et al., "Microfacet Models for Refraction through Rough Surfaces", EGSR
    /// 2007, equations 41 and 20).
    fn reflected(self, sin: f32, cos: f32, eta: f32) -> f32 {
        if self.alpha == 0.0 {
            return fresnel(cos, eta);
        }
        const RINGS: u32 = 32;
        const SPOKES: u32 = 16;
        let mut sum = 0.0;
        for ring in 0..RINGS {
            let u = (ring as f32 + 0.5) / RINGS as f32;
            let tan2 = self.alpha
                * self.alpha
                * if self.is_ggx { u / (1.0 - u) } else { -real::ln(1.0 - u) };
            let cos_m = 1.0 / (1.0 + tan2).sqrt();
            let sin_m = (1.0 - cos_m * cos_m).max(0.0).sqrt();
            for spoke in 0..SPOKES {
                // Left and right are alike.
                let (s, c) = real::sin_cos_degrees(180.0 * (spoke as f32 + 0.5) / SPOKES as f32);
                let m = Vec3::new(sin_m * c, sin_m * s, cos_m);
                let wi = Vec3::new(sin, 0.0, cos);
                let facing = wi.dot(m);
                let wo = 2.0 * facing * m - wi;
                if facing > 0.0 && wo.z > 0.0 {
                    let seen = self.seen(cos) * self.seen(wo.z);
                    sum += fresnel(facing, eta) * seen * facing / (cos * cos_m);
                }
            }
        }
        sum / (RINGS * SPOKES) as f32
    }

    /// How much of the facets is seen at this cosine (Walter et al. 2007, equations 34 and 27).
    fn seen(self, cos: f32) -> f32 {
        let tan2 = (1.0 - cos * cos).max(0.0) / (cos * cos);
        if self.is_ggx {
            return 2.0 / (1.0 + (1.0 + self.alpha * self.alpha * tan2).sqrt());
        }
        let a = 1.0 / (self.alpha * tan2.sqrt());
        if a >= 1.6 { 1.0 } else { (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a) }
    }
}

/// What a smooth border reflects of unpolarised light.
fn fresnel(cos: f32, eta: f32) -> f32 {
    Fresnel::Exact.dielectric(cos, eta).0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A changed index reflects what it is to reflect, above and below what its real part alone does.
    #[test]
    fn indices_reflect_what_they_should() {
        for eta in [0.2_f32, 1.0, 1.5, 4.0] {
            for wanted in [0.0, 0.01, 0.3, 0.9] {
                let (n, k) = index_of(eta, wanted);
                assert!(
                    (normal_reflectance(n, k) - wanted).abs() < 1e-5,
                    "{eta} {wanted}: {n} {k}"
                );
            }
        }
    }

    /// Mean reflectances of a smooth border of index 1.5: 9.18 % from outside, 59.6 % from inside
    /// (d'Eon and Irving, "A Quantized-Diffusion Model for Rendering Translucent Materials", 2011); and
    /// nearly smooth facets reflect as none do.
    #[test]
    fn mean_reflectance_inside() {
        let smooth = Facets { alpha: 0.0, is_ggx: true };
        let [through, out] = smooth.through(1.5);
        assert!((1.0 - through - 0.0918).abs() < 1e-3, "{through}");
        assert!((1.0 - out - 0.5964).abs() < 1e-3, "{out}");
        for is_ggx in [false, true] {
            let nearly = Facets { alpha: 1e-3, is_ggx }.through(1.5);
            assert!((nearly[0] - through).abs() < 2e-3, "{nearly:?}");
            assert!((nearly[1] - out).abs() < 2e-2, "{nearly:?}");
            // Rough facets lose some of what they reflect.
            let rough = Facets { alpha: 0.5, is_ggx }.through(1.5);
            assert!(rough[0] > through && rough[1] > out + 0.05, "{rough:?}");
        }
    }

    /// Layers have the alphas that were asked for.
    #[test]
    fn brushed_alphas() {
        for [u, v] in [[0.1, 0.4], [0.4, 0.1], [0.2, 0.2], [0.0, 1.0]] {
            let mut layers = Principled::default();
            brush(&mut layers, [u, v]);
            let alpha = layers.roughness * layers.roughness;
            let along = alpha + (1.0 - alpha) * layers.anisotropy * layers.anisotropy;
            assert!((alpha - u.min(v)).abs() < 1e-6 && (along - u.max(v)).abs() < 1e-6);
            assert_eq!(layers.anisotropy_rotation > 0.0, u < v);
        }
    }
}
