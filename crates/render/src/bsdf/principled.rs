//! Layers over a base: most surfaces that people make and paint, told by a few plain numbers.
//!
//! From the top: fibres that stand up (sheen), a clear coat, and a base that is metal, or a
//! dielectric over a matte body, or a dielectric that light goes through. Each layer leaves to
//! those below what it does not send back itself, by tables of what layers reflect in all, so
//! that no light is made and, where nothing is coloured, none is lost.
//!
//! What is smooth is smooth: coats, metals and glass without roughness scatter into single
//! directions, and chance chooses them alike on the way to the light and back.
//!
//! Below a coat or sheen a rough base is not reciprocal: how much comes through is told by the
//! side of `wo` alone, since only that keeps the balance for every base. Matte below gloss is.
//!
//! Not for layers that have a thickness, nor for light that enters and leaves at different places.
//!
//! Source: OpenPBR Surface specification 1.1, 2024; glTF 2.0, appendix B, and its extensions
//! `KHR_materials_*`; Kulla and Conty, "Revisiting Physically Based Shading at Imageworks",
//! SIGGRAPH course, 2017, for matte below gloss; `microfacet.rs`, `gloss.rs` and `energy.rs`.

use super::energy::Loss;
use super::fresnel::Fresnel;
use super::gloss::{self, COSINES, Reflection, Rise, SeenFacets, StretchedFacets};
use super::microfacet::{Ggx, StretchedGgx};
use super::oren_nayar::OrenNayar;
use super::rough_dielectric::RoughDielectric;
use super::sample::BsdfSample;
use super::sheen::Sheen;
use super::thin_film::ThinFilm;
use crate::color::Spectrum;
use crate::math::warp;
use rutilant_geom::{Frame, Vec2, Vec3, real};
use std::f32::consts::FRAC_1_PI;

/// What a principled surface is at a point: plain numbers, which textures may drive. All but
/// indices, angles and thicknesses lie between 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledParameters {
    /// What metal reflects at normal incidence, what a matte body sends back, and what is left of
    /// light each time that it crosses a clear border.
    pub base_color: Spectrum,
    /// The share of metal.
    pub metallic: f32,
    /// How rough metal and gloss are; α is the square.
    pub roughness: f32,
    /// How rough the matte body is: see [`OrenNayar`].
    pub diffuse_roughness: f32,
    /// How much steeper facets are along the tangent: α grows from there to 1 by the square.
    pub anisotropy: f32,
    /// Where the tangent lies, in radians counter-clockwise from the x axis of the shading frame,
    /// which must follow the u direction of the surface.
    pub anisotropy_rotation: f32,
    /// How much of the dielectric's reflection there is.
    pub specular: f32,
    /// A factor on what the dielectric reflects at normal incidence.
    pub specular_color: Spectrum,
    /// Index of refraction of the dielectric, over that in front of it.
    pub eta: f32,
    /// The part of what enters the dielectric that goes through instead of into a matte body.
    pub transmission: f32,
    /// Whether there is nothing behind the surface: light goes through without being bent, and
    /// the back is like the front.
    pub thin_walled: bool,
    /// The part of the matte body that sends light on to the other side.
    pub diffuse_transmission: f32,
    /// The colour of that light.
    pub diffuse_transmission_color: Spectrum,
    /// How much of the surface is coated.
    pub coat: f32,
    /// What is left of light that goes straight through the coat, to the base and back.
    pub coat_color: Spectrum,
    /// How rough the coat is; α is the square.
    pub coat_roughness: f32,
    /// Index of refraction of the coat, at least 1.
    pub coat_ior: f32,
    /// The coat's own unit normal in the shading frame, on the front. What it mirrors below the
    /// surface is lost, so it should lean towards `wo` where it would do that.
    pub coat_normal: Vec3,
    /// The same of all other layers.
    pub normal: Vec3,
    /// What the fibres reflect; none if black.
    pub sheen_color: Spectrum,
    /// How much the fibres lean.
    pub sheen_roughness: f32,
    /// How much of metal and gloss is under a thin film.
    pub iridescence: f32,
    /// Index of refraction of the film, at least 1.
    pub iridescence_ior: f32,
    /// How thick the film is, in nanometres.
    pub iridescence_thickness_nm: f32,
}

impl Default for PrincipledParameters {
    /// Satin plastic: light grey, of index 1.5.
    fn default() -> Self {
        Self {
            base_color: Spectrum::splat(0.8),
            metallic: 0.0,
            roughness: 0.3,
            diffuse_roughness: 0.0,
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            specular: 1.0,
            specular_color: Spectrum::WHITE,
            eta: 1.5,
            transmission: 0.0,
            thin_walled: false,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: Spectrum::WHITE,
            coat: 0.0,
            coat_color: Spectrum::WHITE,
            coat_roughness: 0.0,
            coat_ior: 1.5,
            coat_normal: Vec3::Z,
            normal: Vec3::Z,
            sheen_color: Spectrum::BLACK,
            sheen_roughness: 0.5,
            iridescence: 0.0,
            iridescence_ior: 1.3,
            iridescence_thickness_nm: 400.0,
        }
    }
}

/// A surface of layers, ready to scatter. Where light goes through and there is something behind,
/// that is where z is negative; else both sides are alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    its: PrincipledParameters,
    /// The shares of metal, of dielectric over a matte body, and of clear dielectric.
    metal: f32,
    opaque: f32,
    clear: f32,
    /// Facets of metal and gloss; `None` where they are smooth.
    facets: Option<Facets>,
    /// Facets of the border that light crosses; `None` where it is smooth, thin or not there.
    border: Option<Glass>,
    film: Option<ThinFilm>,
    /// What gloss reflects at normal incidence and at grazing, of any channel the most.
    most: [f32; 2],
    /// The same at more cosines, where these two do not tell enough: below films, and where facets
    /// are steeper one way than the other.
    told: Option<Reflection>,
    /// What gloss leaves to a matte body, as a mean over the cosine-weighted hemisphere.
    mean_left: f32,
    matte: OrenNayar,
    /// What a matte body sends on to the other side.
    matte_through: Spectrum,
    coat: Option<Coat>,
    sheen: Option<Sheen>,
    /// The frame of all layers but the coat, where that is not the shading frame.
    frame: Option<Frame>,
    /// Cosine and sine of the tangent's angle; `None` where there is none to be seen.
    tangent: Option<Vec2>,
}

/// Facets that reflect.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Facets {
    ggx: StretchedGgx,
    loss: Loss,
    /// Set where they are steeper one way than the other.
    stretched: Option<StretchedFacets>,
    seen: SeenFacets,
    rise: Rise,
    /// What metal and gloss give back on the side of the light of what facets lose, per part lost.
    many_metal: Spectrum,
    many_gloss: Spectrum,
}

/// Facets of glass that bend light: see [`RoughDielectric`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Glass {
    above: Side,
    below: Side,
    /// The part of what is lost that is given back.
    share: f32,
}

/// What is lost and given back, seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Side {
    /// Index of refraction beyond over that on this side.
    eta: f32,
    loss: Loss,
    /// The part of what crosses that layers above send back, by facets as if these mirrored it.
    sent_back: f32,
    /// The part of what is lost that crosses the border when it is given back.
    crossing: f32,
}

/// A clear layer that reflects.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Coat {
    /// How much of it there is.
    weight: f32,
    ior: f32,
    color: Spectrum,
    /// `None` where it is smooth.
    rough: Option<RoughCoat>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct RoughCoat {
    ggx: Ggx,
    loss: Loss,
    rise: Rise,
}

/// What a direction `wo` decides.
struct View {
    /// In front of all layers.
    outside: bool,
    /// The surface is seen, but all layers below the coat turn away.
    turns_away: bool,
    /// The part of light that sheen leaves to what is below it, and sheen and coat together.
    below_sheen: f32,
    below_coat: f32,
    /// What the coat's colour leaves on the way out.
    tint: Spectrum,
    /// What metal and gloss lose between facets.
    lost: f32,
    /// What gloss leaves to a matte body.
    left: f32,
    /// How often each way of scattering is drawn; all add up to 1.
    ways: Ways<f32>,
    leaning: Leaning,
}

/// How layers lean to one another, in the frame of all but the coat.
#[derive(Clone, Copy)]
struct Leaning {
    /// The frame of the coat, where that is one of its own.
    coat: Option<Frame>,
    /// The normal of the surface on the side of `wo`, where layers have others.
    up: Option<Vec3>,
    /// In front of all layers.
    outside: bool,
}

impl Leaning {
    /// Whether light between these directions goes through the surface.
    fn crosses(&self, wo: Vec3, wi: Vec3) -> bool {
        self.up.map_or(wo.z * wi.z, |up| up.dot(wi)) < 0.0
    }

    /// The mirror image of a direction in the surface, where layers lean: what they send below it
    /// meets other bumps, and comes back up.
    fn folded(&self, w: Vec3) -> Option<Vec3> {
        self.up.map(|up| w - 2.0 * up.dot(w) * up)
    }

    /// A direction into which layers reflect what leaves along `wo`, if need be folded up.
    fn above(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        self.folded(wi).filter(|_| self.crosses(wo, wi)).unwrap_or(wi)
    }
}

/// The ways of scattering, and something about each.
#[derive(Clone, Copy, Debug, Default)]
struct Ways<T> {
    /// Into the mirrored direction.
    mirror: T,
    /// Straight through, or bent as by smooth glass.
    window: T,
    /// Into the direction that a smooth coat with a normal of its own mirrors.
    coat_mirror: T,
    coat: T,
    sheen: T,
    /// By one facet of metal, gloss or the clear border, to either side.
    facet: T,
    /// By several facets of metal or gloss.
    many: T,
    /// By several facets of the border, to either side.
    many_glass: T,
    /// By several facets, through something thin.
    many_thin: T,
    matte: T,
    matte_through: T,
}

impl Ways<f32> {
    fn sum(&self) -> f32 {
        self.deltas() + self.spread_sum()
    }

    fn deltas(&self) -> f32 {
        self.mirror + self.window + self.coat_mirror
    }

    fn spread_sum(&self) -> f32 {
        self.coat
            + self.sheen
            + self.facet
            + self.many
            + self.many_glass
            + self.many_thin
            + self.matte
            + self.matte_through
    }

    fn scaled(&self, by: f32) -> Self {
        Self {
            mirror: self.mirror * by,
            window: self.window * by,
            coat_mirror: self.coat_mirror * by,
            coat: self.coat * by,
            sheen: self.sheen * by,
            facet: self.facet * by,
            many: self.many * by,
            many_glass: self.many_glass * by,
            many_thin: self.many_thin * by,
            matte: self.matte * by,
            matte_through: self.matte_through * by,
        }
    }
}

/// One of the ways of scattering.
#[derive(Clone, Copy)]
enum Way {
    Mirror,
    Window,
    CoatMirror,
    Coat,
    Sheen,
    Facet,
    Many,
    ManyGlass,
    ManyThin,
    Matte,
    MatteThrough,
}

/// What the clear border does to light at one of its facets.
struct Crossing {
    /// What it reflects.
    reflected: Spectrum,
    /// The part that crosses, before it is coloured.
    passed: f32,
    /// The cosine beyond.
    cos_beyond: f32,
    /// The cosine in front of the border.
    cos_outside: f32,
}

impl Principled {
    /// The layers that the numbers say. Numbers outside their ranges give numbers, or no numbers,
    /// but no panic.
    pub fn new(its: PrincipledParameters) -> Self {
        let metal = its.metallic;
        let clear = (1.0 - metal) * its.transmission;
        let opaque = (1.0 - metal) * (1.0 - its.transmission);
        // Facets are steeper along the tangent.
        let alpha = its.roughness * its.roughness;
        let along = alpha + (1.0 - alpha) * its.anisotropy * its.anisotropy;
        let is_rough = along >= Ggx::LEAST_ALPHA;
        let across = alpha.max(Ggx::LEAST_ALPHA);
        let is_stretched = is_rough && along > across * 1.001;
        let steepness = (0.5 * (along * along + across * across)).sqrt().sqrt();

        let mut layers = Self {
            its,
            metal,
            opaque,
            clear,
            facets: None,
            border: None,
            film: ThinFilm::new(its.iridescence, its.iridescence_ior, its.iridescence_thickness_nm),
            most: [0.0; 2],
            told: None,
            mean_left: 1.0,
            matte: OrenNayar::new(
                its.base_color * (1.0 - its.diffuse_transmission),
                its.diffuse_roughness,
            ),
            matte_through: its.diffuse_transmission_color * its.diffuse_transmission,
            coat: Coat::new(&its),
            sheen: Sheen::new(its.sheen_color, its.sheen_roughness),
            frame: (its.normal != Vec3::Z).then(|| Frame::around(its.normal)),
            tangent: is_stretched.then(|| {
                let (s, c) = real::sin_cos(its.anisotropy_rotation);
                Vec2::new(c, s)
            }),
        };
        // Where the indices are the same there is no gloss.
        let grazing = if its.eta == 1.0 { 0.0 } else { its.specular };
        layers.most = [layers.normal_gloss().max_channel(), grazing];
        let mean_rise = Rise::new(its.eta, 0.0).mean;
        let [normal, grazing] = layers.most;
        let gloss = (!is_rough || is_stretched || layers.film.is_some())
            .then(|| Reflection::cosines().map(|cos| layers.gloss(cos)));
        let told = gloss.map(|gloss| Reflection::new(gloss.map(Spectrum::max_channel)));
        if !is_rough {
            layers.mean_left = 1.0 - told.map_or(0.0, |told| told.mean());
            return layers;
        }

        // What facets lose, and how much of it metal and gloss give back.
        let loss = Loss::metal(steepness).roughly_averaged();
        let stretched = is_stretched
            .then(|| StretchedFacets::new(across.sqrt(), its.anisotropy, [along, across]));
        layers.told = told.map(|told| {
            told.raised(if is_stretched { StretchedFacets::STEP } else { SeenFacets::STEP })
        });
        let mean_lost = stretched.map_or(loss.mean, |s| s.mean_lost);
        let series = |f: f32| f * f * (1.0 - mean_lost) / (1.0 - f * mean_lost);
        let [mean_metal, mean_gloss] = layers.mean_reflectances(gloss, mean_rise);
        let rise = Rise::new(its.eta, steepness);
        let (many_metal, many_gloss) = (mean_metal.map(series), mean_gloss.map(series));
        layers.facets = Some(Facets {
            ggx: StretchedGgx { along, across: if is_stretched { across } else { along } },
            loss: loss.with_mean(mean_lost),
            stretched,
            seen: SeenFacets::new(steepness),
            rise,
            many_metal,
            many_gloss,
        });
        let once = match (&layers.told, &stretched) {
            (None, _) => normal * (1.0 - mean_lost) + (grazing - normal) * rise.mean,
            (Some(told), None) => SeenFacets::new(steepness).mean(told),
            (Some(told), Some(stretched)) => stretched.mean(told),
        };
        layers.mean_left = 1.0 - (once + mean_lost * many_gloss.max_channel());

        // The border that light crosses.
        let ratio = its.eta.max(1.0 / its.eta);
        if clear > 0.0 && !its.thin_walled && ratio >= RoughDielectric::LEAST_RATIO {
            layers.border = Some(Glass::new(
                its.eta,
                steepness,
                layers.share_given_back(),
                layers.mean_sent_back(),
                &loss.with_mean(mean_lost),
            ));
        }
        layers
    }

    /// How much of what the facets of a clear border lose may be given back, so that no light is
    /// made: what plain glass loses is known. Where less is reflected or less crosses, by some
    /// factor, at least that part of it is lost; under a film nothing is sure. What is lost where
    /// facets are steeper one way than the other was compared with what is known, over all angles:
    /// this part of it is always lost.
    fn share_given_back(&self) -> f32 {
        const STRETCHED: f32 = 1.0 / 1.5;
        let [r, g, b] = self.its.specular_color.channels();
        let reflects = self.its.specular * r.min(g).min(b);
        let plain = gloss::normal_reflectance(self.its.eta);
        let crosses = (1.0 - self.normal_gloss().max_channel()) / (1.0 - plain);
        let bare = self.film.map_or(1.0, |film| 1.0 - film.strength);
        reflects.min(crosses).clamp(0.0, 1.0)
            * bare
            * if self.tangent.is_some() { STRETCHED } else { 1.0 }
    }

    /// What coat and sheen send back of diffuse light that comes through the border from inside.
    fn mean_sent_back(&self) -> f32 {
        const STEPS: u32 = 6;
        let cosines = (0..STEPS).map(|n| ((n as f32 + 0.5) / STEPS as f32).sqrt());
        cosines.map(|mu| 1.0 - self.let_through(mu)).sum::<f32>() / STEPS as f32
    }

    /// The part of light that coat and sheen let through, under the cosine `mu` outside.
    fn let_through(&self, mu: f32) -> f32 {
        let sheen = self.sheen.map_or(0.0, |s| s.taken(mu));
        let coat = self.coat.map_or(0.0, |c| c.weight * c.reflected(mu));
        (1.0 - sheen) * (1.0 - coat)
    }

    /// The same over another index of refraction, where there is something behind it.
    pub(super) fn with_eta(&self, eta: f32) -> Self {
        Self::new(PrincipledParameters { eta, ..self.its })
    }

    /// True where what is behind the surface is another medium.
    fn has_inside(&self) -> bool {
        let crossed = self.clear > 0.0 || self.opaque > 0.0 && !self.matte_through.is_black();
        crossed && !self.its.thin_walled
    }

    /// True where light crosses the surface without being spread.
    fn is_clear(&self) -> bool {
        let rough =
            if self.its.thin_walled { self.facets.is_some() } else { self.border.is_some() };
        self.clear > 0.0 && !rough
    }

    /// True where gloss reflects anything.
    fn is_glossy(&self) -> bool {
        self.most[1] > 0.0 || self.film.is_some()
    }

    /// True when some of it is scattered into single directions.
    pub(super) fn has_delta(&self) -> bool {
        let mirror = self.metal > 0.0 || self.opaque > 0.0 && self.is_glossy();
        self.facets.is_none() && mirror
            || self.is_clear()
            || self.coat.is_some_and(|c| c.rough.is_none())
    }

    /// True when some of it is not.
    pub(super) fn has_spread(&self) -> bool {
        let matte = !self.matte.albedo().is_black() || !self.matte_through.is_black();
        self.sheen.is_some()
            || self.coat.is_some_and(|c| c.rough.is_some())
            || self.opaque > 0.0 && matte
            || self.facets.is_some()
                && (self.metal > 0.0
                    || self.opaque > 0.0 && self.is_glossy()
                    || self.clear > 0.0 && !self.is_clear())
    }

    /// True for what scatters light through the surface, and not into single directions.
    pub(super) fn is_translucent(&self) -> bool {
        self.opaque > 0.0 && !self.matte_through.is_black() || self.clear > 0.0 && !self.is_clear()
    }

    /// How often light is scattered into a single direction, seen from straight above.
    pub(super) fn delta_pmf(&self) -> f32 {
        self.view(Vec3::Z, self.leaning(Vec3::Z)).ways.deltas()
    }

    /// About what part of white light is sent on.
    pub(super) fn albedo(&self) -> Spectrum {
        let view = self.view(Vec3::Z, self.leaning(Vec3::Z));
        let matte = (self.matte.albedo() + self.matte_through) * (view.left * self.opaque);
        let Crossing { reflected, passed, .. } = self.crossing(1.0, true);
        let clear = (reflected + self.its.base_color * passed) * self.clear;
        let gloss = self.gloss(1.0) * self.opaque;
        let base = matte + clear + gloss + self.metal(1.0) * self.metal;
        let coat = self.coat.map_or(0.0, |c| c.weight * c.reflected(1.0)) * view.below_sheen;
        let sheen = self.sheen.map_or(Spectrum::BLACK, |s| s.albedo(1.0));
        base * view.tint * view.tint * view.below_coat + Spectrum::splat(coat) + sheen
    }

    /// BSDF value times cosine, `f(wo, wi) |cos θi|`, and the density with which
    /// [`sample`](Self::sample) draws `wi`, both in 1/sr. Without what goes into single directions.
    #[inline(never)]
    pub fn eval_cos_pdf(&self, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let (local, wi) = (self.turned(wo, wo), self.turned(wi, wo));
        if local.z == 0.0 || wi.z == 0.0 {
            return (Spectrum::BLACK, 0.0);
        }
        self.seen(&self.view(local, self.leaning(wo)), local, wi)
    }

    /// Draws the direction the light came from. `choice` and `u` hold numbers in [0, 1). `None`
    /// where nothing is scattered.
    #[inline(never)]
    pub fn sample(&self, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let local = self.turned(wo, wo);
        if local.z == 0.0 {
            return None;
        }
        let view = self.view(local, self.leaning(wo));
        let (way, choice) = view.ways.choose(choice)?;
        let single = match way {
            Way::Mirror => self.mirrored(&view, local)?,
            Way::Window => self.passed(&view, local)?,
            Way::CoatMirror => self.mirrored_by_coat(&view, local)?,
            Way::Coat
            | Way::Sheen
            | Way::Facet
            | Way::Many
            | Way::ManyGlass
            | Way::ManyThin
            | Way::Matte
            | Way::MatteThrough => {
                let (wi, eta) = self.draw(&view, local, way, choice, u)?;
                // As others will see it, rounded.
                let wi = self.turned_back(wi, wo).try_normalize()?;
                let (value, pdf) = self.seen(&view, local, self.turned(wi, wo));
                return (pdf > 0.0).then(|| BsdfSample {
                    wi,
                    weight: value / pdf,
                    pdf,
                    delta: false,
                    eta,
                });
            }
        };
        Some(BsdfSample { wi: self.turned_back(single.wi, wo), ..single })
    }

    /// Draws a direction of one of the ways that spread light, with the index of refraction beyond
    /// over that before the surface if it crosses that.
    fn draw(&self, view: &View, wo: Vec3, way: Way, choice: f32, u: Vec2) -> Option<(Vec3, f32)> {
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let facing = |w: Vec3| if wo.z < 0.0 { Vec3::new(w.x, w.y, -w.z) } else { w };
        let mut eta = 1.0;
        let above = match way {
            Way::Mirror | Way::Window | Way::CoatMirror => None,
            Way::Coat => {
                let frame = &view.leaning.coat;
                let seen_from = frame.map_or(wo, |frame| frame.to_local(wo));
                let facet = self.coat?.rough?.ggx.sample_seen(seen_from, u);
                let mirrored = 2.0 * seen_from.dot(facet) * facet - seen_from;
                let mirrored = Some(mirrored).filter(|w| w.z > 0.0)?;
                let mirrored = frame.map_or(mirrored, |frame| frame.to_world(mirrored));
                return Some((view.leaning.above(wo, mirrored), 1.0));
            }
            Way::Sheen => Some(warp::uniform_hemisphere(u)),
            Way::Facet => {
                let facet = self.facets?.ggx.sample_seen(up, u);
                let cos = up.dot(facet).clamp(0.0, 1.0);
                let mirrored = 2.0 * cos * facet - up;
                let crossing = self.crossing(cos, view.outside);
                if choice < self.reflects(cos, &crossing) {
                    Some(mirrored).filter(|w| w.z > 0.0)
                } else if self.its.thin_walled {
                    Some(-mirrored).filter(|w| w.z < 0.0).map(|w| Vec3::new(-w.x, -w.y, w.z))
                } else {
                    eta = self.index_beyond(view.outside);
                    let bent = (cos / eta - crossing.cos_beyond) * facet - up / eta;
                    Some(bent).filter(|w| w.z < 0.0)
                }
            }
            Way::Many => Some(self.facets?.loss.sample(u)),
            Way::ManyThin => Some(-self.facets?.loss.sample(u)),
            Way::ManyGlass => {
                let (side, beyond) = self.border.as_ref()?.seen_from(view.outside);
                if choice < side.crossing {
                    eta = self.index_beyond(view.outside);
                    Some(-beyond.loss.sample(u))
                } else {
                    Some(side.loss.sample(u))
                }
            }
            Way::Matte => {
                let matte = if self.its.diffuse_roughness == 0.0 {
                    Some(warp::cosine_hemisphere(u))
                } else {
                    self.matte.sample(up, choice, u).map(|s| s.wi)
                };
                matte.filter(|w| w.z > 0.0)
            }
            Way::MatteThrough => {
                eta = self.matte_index_beyond(view.outside);
                Some(-warp::cosine_hemisphere(u)).filter(|w| w.z < 0.0)
            }
        };
        let wi = facing(above?);
        if wo.z * wi.z < 0.0 {
            return view.leaning.crosses(wo, wi).then_some((wi, eta));
        }
        Some((view.leaning.above(wo, wi), eta))
    }

    /// The mirrored direction, by base and coat together.
    fn mirrored(&self, view: &View, wo: Vec3) -> Option<BsdfSample> {
        let o = wo.z.abs();
        let mut value = Spectrum::BLACK;
        if self.facets.is_none() {
            value += self.metal(o) * self.metal + self.gloss(o) * self.opaque;
        }
        if self.is_clear() {
            value += self.crossing(o, view.outside).reflected * self.clear;
        }
        value *= view.tint * view.tint * view.below_coat;
        if let (Some(coat), None) = (self.smooth_coat(view), &view.leaning.coat) {
            value += Spectrum::splat(coat.weight * coat.reflected(o) * view.below_sheen);
        }
        let pdf = view.ways.mirror;
        let wi = Vec3::new(-wo.x, -wo.y, wo.z);
        let sample = BsdfSample { wi, weight: value / pdf, pdf, delta: true, eta: 1.0 };
        (!view.leaning.crosses(wo, wi)).then_some(sample)
    }

    /// The direction that a smooth coat with a normal of its own mirrors.
    fn mirrored_by_coat(&self, view: &View, wo: Vec3) -> Option<BsdfSample> {
        let (coat, normal) = (self.smooth_coat(view)?, view.leaning.coat?.z);
        let value = coat.weight * coat.reflected(cos_of_coat(&view.leaning, wo));
        let pdf = view.ways.coat_mirror;
        let weight = Spectrum::splat(value * view.below_sheen) / pdf;
        let wi = (2.0 * wo.dot(normal) * normal - wo).try_normalize()?;
        let sample = BsdfSample { wi, weight, pdf, delta: true, eta: 1.0 };
        (!view.leaning.crosses(wo, wi)).then_some(sample)
    }

    /// The way through a clear border that is smooth or thin.
    fn passed(&self, view: &View, wo: Vec3) -> Option<BsdfSample> {
        let crossing = self.crossing(wo.z.abs(), view.outside);
        let eta = self.index_beyond(view.outside);
        let wi = if eta == 1.0 {
            -wo
        } else {
            let down = -crossing.cos_beyond.copysign(wo.z);
            Vec3::new(-wo.x / eta, -wo.y / eta, down).normalize()
        };
        let tint = self.coat.map_or(Spectrum::WHITE, |c| c.leg(crossing.cos_outside));
        let value = self.its.base_color * tint * (self.clear * crossing.passed * view.below_coat);
        let pdf = view.ways.window;
        let weight = value / (pdf * eta * eta);
        let sample = BsdfSample { wi, weight, pdf, delta: true, eta };
        (wi.z != 0.0 && view.leaning.crosses(wo, wi)).then_some(sample)
    }

    /// What is sent from `wi` to `wo`, with the density of drawing it.
    fn seen(&self, view: &View, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        if view.leaning.crosses(wo, wi) {
            let is_through = wo.z * wi.z < 0.0 && !view.turns_away;
            return if is_through {
                self.seen_through(view, wo, wi)
            } else {
                (Spectrum::BLACK, 0.0)
            };
        }
        let (value, pdf) = self.reflected(view, wo, wi);
        let Some(folded) = view.leaning.folded(wi) else { return (value, pdf) };
        let (more, more_pdf) = self.reflected(view, wo, folded);
        (value + more, pdf + more_pdf)
    }

    /// What layers send from `wi` to `wo` on one side of theirs, with the density of drawing it.
    fn reflected(&self, view: &View, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let (o, i) = (wo.z.abs(), wi.z.abs());
        let ways = &view.ways;
        if view.turns_away || wo.z * wi.z < 0.0 {
            let (reflected, pdf) = self.by_coat(view, wo, wi);
            return (Spectrum::splat(reflected), pdf);
        }

        // The base: metal and gloss by one facet and by several.
        let (mut base, mut pdf) = (Spectrum::BLACK, 0.0);
        let half = wo + wi;
        let length = half.length();
        let facet = half * (half.z.signum() / length);
        let cos = (0.5 * length).min(1.0);
        if let (Some(facets), true) = (&self.facets, length > 0.0) {
            let (length_o, length_i) =
                (facets.ggx.squeezed_length(wo), facets.ggx.squeezed_length(wi));
            // Height-correlated G2 / (4 o i) (Heitz 2014, equation 99).
            let hidden = o * length_i + i * length_o;
            if hidden > 0.0 && ways.facet > 0.0 {
                let density = facets.ggx.density(facet) * 0.5;
                let crossing = self.crossing(cos, view.outside);
                base += self.rough_color(cos, &crossing) * (density * i / hidden);
                pdf += ways.facet * self.reflects(cos, &crossing) * density / (o + length_o);
            }
            let many = self.many();
            base += many * (view.lost * facets.lost(wi) * i * FRAC_1_PI / facets.loss.mean);
            pdf += ways.many * facets.loss.pdf(i);
        }
        if let (Some(glass), Some(facets)) = (&self.border, &self.facets) {
            let (side, _) = glass.seen_from(view.outside);
            let returning = 1.0 - side.crossing;
            let lost = facets.lost_by_glass(side, wo) * facets.lost_by_glass(side, wi);
            let lobe = glass.share * lost * i * (FRAC_1_PI / side.loss.mean);
            base += Spectrum::splat(self.clear * returning * lobe);
            pdf += ways.many_glass * returning * side.loss.pdf(i);
        }

        // The matte body below gloss.
        if ways.matte > 0.0 {
            // What gloss takes of light along `wi` is taken from what is sent evenly: only of that is
            // it known how much there is of it in all.
            let through = self.opaque * view.left;
            let entering = self.left(wi) / self.mean_left;
            if self.its.diffuse_roughness == 0.0 {
                base += self.matte.albedo() * (through * entering * i * FRAC_1_PI);
                pdf += ways.matte * warp::cosine_hemisphere_pdf(i);
            } else {
                let even = self.matte.even_part() * (i * (entering - 1.0));
                base += (self.matte.eval_cos(wo, wi) + even).map(|c| c.max(0.0)) * through;
                pdf += ways.matte * self.matte.pdf(wo, wi);
            }
        }
        let tint_in = match &self.coat {
            Some(coat) if view.outside => coat.leg(cos_of_coat(&view.leaning, wi)),
            _ => Spectrum::WHITE,
        };
        let mut value = base * view.tint * tint_in * view.below_coat;

        // Coat and sheen above it.
        if ways.coat > 0.0 {
            let (reflected, density) = self.by_coat(view, wo, wi);
            value += Spectrum::splat(reflected);
            pdf += density;
        }
        if let (Some(sheen), true) = (&self.sheen, ways.sheen > 0.0) {
            value += sheen.eval_cos(wo, wi);
            pdf += ways.sheen * warp::UNIFORM_HEMISPHERE_PDF;
        }
        (value, pdf)
    }

    /// What a facet of a rough coat sends from `wi` to `wo`, with the density of drawing it.
    fn by_coat(&self, view: &View, wo: Vec3, wi: Vec3) -> (f32, f32) {
        let (wo, wi) = match &view.leaning.coat {
            None => (wo, wi),
            Some(frame) => (frame.to_local(wo), frame.to_local(wi)),
        };
        let half = wo + wi;
        let length = half.length();
        let (Some(coat), true) = (&self.coat, length > 0.0 && wo.z * wi.z > 0.0) else {
            return (0.0, 0.0);
        };
        let Some(rough) = &coat.rough else { return (0.0, 0.0) };
        let (o, i) = (wo.z.abs(), wi.z.abs());
        let facet = half * (half.z.signum() / length);
        let (length_o, length_i) = (rough.ggx.squeezed_length(wo), rough.ggx.squeezed_length(wi));
        let density = rough.ggx.density(facet) * 0.5;
        let (reflected, _) = Fresnel::Exact.dielectric((0.5 * length).min(1.0), coat.ior);
        let once = density * i / (o * length_i + i * length_o);
        let value = coat.weight * reflected * once * view.below_sheen;
        (value, view.ways.coat * density / (o + length_o))
    }

    /// The same through the surface.
    fn seen_through(&self, view: &View, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let (o, i) = (wo.z.abs(), wi.z.abs());
        let ways = &view.ways;
        let eta = self.index_beyond(view.outside);
        let (mut value, mut pdf) = (Spectrum::BLACK, 0.0);

        // Through a rough border: by one facet and by several.
        if let (Some(glass), Some(facets), true) = (&self.border, &self.facets, ways.facet > 0.0) {
            let (side, beyond) = glass.seen_from(view.outside);
            let lost = facets.lost_by_glass(side, wo) * facets.lost_by_glass(beyond, wi);
            let lobe = glass.share * lost * i * (FRAC_1_PI / beyond.loss.mean);
            let many = self.clear * side.crossing * lobe / (eta * eta);
            pdf += ways.many_glass * side.crossing * beyond.loss.pdf(i);
            value += self.its.base_color * many;
            let half = wo + wi * eta;
            let length2 = half.length_squared();
            let facet = half * (half.z.signum() / length2.sqrt());
            let (cos_o, cos_i) = (wo.dot(facet) * wo.z.signum(), wi.dot(facet) * wi.z.signum());
            if length2 > 0.0 && cos_o > 0.0 && cos_i > 0.0 {
                // Walter 2007, equations 17 and 21, with separate masking.
                let crossing = self.crossing(cos_o.min(1.0), view.outside);
                let (length_o, length_i) =
                    (facets.ggx.squeezed_length(wo), facets.ggx.squeezed_length(wi));
                let once =
                    facets.ggx.density(facet) * cos_o * cos_i / length2 * 2.0 / (o + length_o);
                let passed = self.clear * crossing.passed * once * 2.0 * i / (i + length_i);
                value += self.its.base_color * passed;
                pdf += ways.facet
                    * (1.0 - self.reflects(cos_o.min(1.0), &crossing))
                    * once
                    * eta
                    * eta;
            }
        }

        // Through something thin: as reflected, on the other side.
        if let (Some(facets), true) = (&self.facets, self.its.thin_walled && self.clear > 0.0) {
            let back = Vec3::new(wi.x, wi.y, -wi.z);
            let half = wo + back;
            let length = half.length();
            let (length_o, length_i) =
                (facets.ggx.squeezed_length(wo), facets.ggx.squeezed_length(wi));
            if length > 0.0 && ways.facet > 0.0 {
                let density = facets.ggx.density(half * (half.z.signum() / length)) * 0.5;
                let cos = (0.5 * length).min(1.0);
                let crossing = self.crossing(cos, view.outside);
                let once = density * i / (o * length_i + i * length_o);
                value += self.its.base_color * (self.clear * crossing.passed * once);
                pdf +=
                    ways.facet * (1.0 - self.reflects(cos, &crossing)) * density / (o + length_o);
            }
            let lobe = view.lost * facets.lost(wi) * i * FRAC_1_PI / facets.loss.mean;
            value += self.its.base_color * (self.clear * self.many_thin() * lobe);
            pdf += ways.many_thin * facets.loss.pdf(i);
        }

        // Through a matte body.
        if ways.matte_through > 0.0 {
            let through = self.opaque * view.left * self.left(wi) / self.mean_left;
            let eta = self.matte_index_beyond(view.outside);
            value += self.matte_through * (through * i * FRAC_1_PI / (eta * eta));
            pdf += ways.matte_through * warp::cosine_hemisphere_pdf(i);
        }
        let tint = match &self.coat {
            Some(coat) if !view.outside => coat.leg(i),
            _ => view.tint,
        };
        (value * tint * view.below_coat, pdf)
    }

    /// What `wo` decides, in the frame of the layers.
    fn view(&self, wo: Vec3, leaning: Leaning) -> View {
        let o = wo.z.abs();
        let outside = leaning.outside;
        let turns_away = outside != (wo.z > 0.0);
        // The layers are in front, and on both sides of what has no inside.
        let below_sheen = match &self.sheen {
            Some(sheen) if outside => 1.0 - sheen.taken(o),
            _ => 1.0,
        };
        let (coat, tint) = match &self.coat {
            Some(coat) if outside => {
                let cos = cos_of_coat(&leaning, wo);
                (coat.weight * coat.reflected(cos), coat.leg(cos))
            }
            _ => (0.0, Spectrum::WHITE),
        };
        let below_coat = below_sheen * (1.0 - coat);
        let lost = self.facets.as_ref().map_or(0.0, |f| f.lost(wo));
        let left = self.left_of(lost, wo);

        // What each sends on, of white light.
        let its = &self.its;
        let color = its.base_color.max_channel();
        let reflected =
            self.metal * self.metal(o).max_channel() + self.opaque * self.gloss(o).max_channel();
        let crossing = self.crossing(o, outside);
        let mut ways = Ways {
            sheen: 1.0 - below_sheen,
            matte: below_coat * self.opaque * left * self.matte.albedo().max_channel(),
            matte_through: below_coat * self.opaque * left * self.matte_through.max_channel(),
            ..Ways::default()
        };
        match self.coat {
            Some(Coat { rough: Some(_), .. }) => ways.coat = below_sheen * coat,
            Some(Coat { rough: None, .. }) if leaning.coat.is_some() => {
                ways.coat_mirror = below_sheen * coat;
            }
            Some(Coat { rough: None, .. }) => ways.mirror += below_sheen * coat,
            None => {}
        }
        if self.is_clear() {
            ways.mirror += below_coat * self.clear * crossing.reflected.max_channel();
            ways.window = below_coat * self.clear * crossing.passed * color;
        }
        if let Some(facets) = &self.facets {
            ways.facet = below_coat * (1.0 - lost) * reflected;
            ways.many = below_coat * lost * self.many().max_channel();
            if let Some(glass) = &self.border {
                let (side, _) = glass.seen_from(outside);
                let lost = facets.lost_by_glass(side, wo);
                ways.facet += below_coat * self.clear * (1.0 - lost);
                ways.many_glass = below_coat * self.clear * glass.share * lost;
            } else if self.clear > 0.0 && its.thin_walled {
                let once = crossing.reflected.max_channel() + crossing.passed * color;
                ways.facet += below_coat * self.clear * (1.0 - lost) * once;
                ways.many_thin = below_coat * self.clear * lost * self.many_thin() * color;
            }
        } else {
            ways.mirror += below_coat * reflected;
        }
        if turns_away {
            ways = Ways { coat: ways.coat, coat_mirror: ways.coat_mirror, ..Ways::default() };
        }
        let sum = ways.sum();
        ways = if sum > 0.0 { ways.scaled(1.0 / sum) } else { Ways::default() };

        // Glass is crossed as often from inside as from outside: light paths rely on it.
        if !outside && ways.window > 0.0 {
            let other = Vec3::new(0.0, 0.0, crossing.cos_outside);
            let sin = (1.0 - other.z * other.z).max(0.0).sqrt();
            let across = Vec2::new(wo.x, wo.y).normalize_or(Vec2::X) * sin;
            let other = Vec3::new(across.x, across.y, other.z);
            let window = self.view(other, Leaning { outside: true, ..leaning }).ways.window;
            let rest = ways.mirror + ways.spread_sum();
            let scale = if rest > 0.0 { (1.0 - window) / rest } else { 0.0 };
            ways = Ways { window, ..ways.scaled(scale) };
        }
        View { outside, turns_away, below_sheen, below_coat, tint, lost, left, ways, leaning }
    }

    /// What metal reflects at a facet: Schlick's approximation, and grazing light whole.
    fn metal(&self, cos: f32) -> Spectrum {
        let m = 1.0 - cos;
        let rise = (m * m) * (m * m) * m;
        let bare = self.its.base_color.map(|c| c + (1.0 - c) * rise);
        self.filmed(bare, self.its.base_color, cos)
    }

    /// What gloss reflects at a facet, seen from the thinner side.
    fn gloss(&self, cos: f32) -> Spectrum {
        let eta = self.its.eta.max(1.0 / self.its.eta);
        self.gloss_of(Fresnel::Exact.dielectric(cos, eta).0, cos)
    }

    /// The same where Fresnel's equations say how much.
    fn gloss_of(&self, reflected: f32, cos: f32) -> Spectrum {
        let normal = self.normal_gloss();
        let grazing = self.its.specular;
        let rise = Rise::of_smooth(reflected, self.its.eta);
        self.filmed(normal.map(|f| f + (grazing - f) * rise), normal, cos)
    }

    /// What gloss reflects at normal incidence: `KHR_materials_specular`.
    fn normal_gloss(&self) -> Spectrum {
        let bare = gloss::normal_reflectance(self.its.eta);
        self.its.specular_color.map(|c| (bare * c).min(1.0) * self.its.specular)
    }

    /// The same under the thin film, if there is one.
    fn filmed(&self, bare: Spectrum, normal: Spectrum, cos: f32) -> Spectrum {
        match &self.film {
            None => bare,
            Some(film) => {
                bare * (1.0 - film.strength) + film.reflectance(cos, normal) * film.strength
            }
        }
    }

    /// What metal and gloss reflect as means over the cosine-weighted hemisphere; `gloss` is what the
    /// second reflects at some cosines, if that is known.
    fn mean_reflectances(
        &self,
        gloss: Option<[Spectrum; COSINES]>,
        mean_rise: f32,
    ) -> [Spectrum; 2] {
        let mean = |reflected: [Spectrum; COSINES]| {
            let channel = |k: usize| Reflection::new(reflected.map(|r| r.channels()[k])).mean();
            Spectrum::from(std::array::from_fn(channel))
        };
        let metal = match &self.film {
            // The mean of (1 - cos)⁵ is 1/21.
            None => self.its.base_color.map(|c| c + (1.0 - c) / 21.0),
            Some(_) => mean(Reflection::cosines().map(|cos| self.metal(cos))),
        };
        let grazing = self.its.specular;
        let plain = || self.normal_gloss().map(|f| f + (grazing - f) * mean_rise);
        [metal, gloss.map_or_else(plain, mean)]
    }

    /// What gloss leaves to a matte body of light along `w`.
    fn left(&self, w: Vec3) -> f32 {
        self.left_of(self.facets.as_ref().map_or(0.0, |f| f.lost(w)), w)
    }

    fn left_of(&self, lost: f32, w: Vec3) -> f32 {
        let [normal, grazing] = self.most;
        let reflected = match &self.facets {
            None => self.gloss(w.z.abs()).max_channel(),
            Some(facets) => {
                let once = match &self.told {
                    None => normal + (grazing - normal) * facets.rise.at(w.z.abs()),
                    Some(told) => facets.reflected(told, w),
                };
                (1.0 - lost) * once + lost * facets.many_gloss.max_channel()
            }
        };
        (1.0 - reflected).max(0.0)
    }

    /// What metal and gloss give back of what facets lose, per part lost.
    fn many(&self) -> Spectrum {
        let Some(facets) = &self.facets else { return Spectrum::BLACK };
        let gloss = self.opaque + if self.its.thin_walled { self.clear } else { 0.0 };
        facets.many_metal * self.metal + facets.many_gloss * gloss
    }

    /// The part of what facets of something thin lose that goes through.
    fn many_thin(&self) -> f32 {
        self.facets.as_ref().map_or(0.0, |f| 1.0 - f.many_gloss.max_channel())
    }

    /// What the clear border does to light under the cosine `cos` on the side of `wo`.
    fn crossing(&self, cos: f32, outside: bool) -> Crossing {
        let nothing =
            Crossing { reflected: Spectrum::BLACK, passed: 0.0, cos_beyond: 0.0, cos_outside: cos };
        if self.clear == 0.0 {
            return nothing;
        }
        if self.its.thin_walled {
            let reflected = self.gloss(cos);
            let passed = (1.0 - reflected.max_channel()).max(0.0);
            return Crossing { reflected, passed, cos_beyond: cos, ..nothing };
        }
        let eta = if outside { self.its.eta } else { 1.0 / self.its.eta };
        let (reflected, cos_beyond) = Fresnel::Exact.dielectric(cos, eta);
        if cos_beyond == 0.0 {
            return Crossing { reflected: Spectrum::WHITE, ..nothing };
        }
        let cos_outside = if outside { cos } else { cos_beyond };
        let reflected = self.gloss_of(reflected, cos_outside);
        let passed = (1.0 - reflected.max_channel()).max(0.0);
        if outside {
            return Crossing { reflected, passed, cos_beyond, cos_outside };
        }
        // From inside, coat and sheen stand behind the border and send their part back.
        let through = self.let_through(cos_outside);
        let returned = Spectrum::splat(passed * (1.0 - through));
        Crossing {
            reflected: reflected + returned,
            passed: passed * through,
            cos_beyond,
            cos_outside,
        }
    }

    /// The colour that rough facets reflect.
    fn rough_color(&self, cos: f32, crossing: &Crossing) -> Spectrum {
        let base = self.metal(cos) * self.metal + self.gloss(cos) * self.opaque;
        if self.clear > 0.0 && !self.is_clear() {
            base + crossing.reflected * self.clear
        } else {
            base
        }
    }

    /// How often a rough facet reflects, of all light that it sends on.
    fn reflects(&self, cos: f32, crossing: &Crossing) -> f32 {
        if self.clear == 0.0 || self.is_clear() {
            return 1.0;
        }
        let reflected = self.rough_color(cos, crossing).max_channel();
        let passed = self.clear * crossing.passed * self.its.base_color.max_channel();
        if passed > 0.0 { reflected / (reflected + passed) } else { 1.0 }
    }

    /// The index of refraction beyond the surface over that before it.
    fn index_beyond(&self, outside: bool) -> f32 {
        match (self.its.thin_walled, outside) {
            (true, _) => 1.0,
            (false, true) => self.its.eta,
            (false, false) => 1.0 / self.its.eta,
        }
    }

    /// The same for light that a matte body sends on. Where it alone does so, there is no border to
    /// bend light, and no index behind it.
    fn matte_index_beyond(&self, outside: bool) -> f32 {
        if self.clear > 0.0 { self.index_beyond(outside) } else { 1.0 }
    }

    /// How layers lean to one another; `wo` says in the shading frame from where the surface is seen.
    fn leaning(&self, wo: Vec3) -> Leaning {
        let side = if wo.z < 0.0 { -1.0 } else { 1.0 };
        let normal = self.its.coat_normal;
        let coat_leans = self.coat.is_some() && (normal != Vec3::Z || self.frame.is_some());
        let leans = coat_leans || self.frame.is_some();
        Leaning {
            coat: coat_leans.then(|| Frame::around(self.turned(side * normal, wo))),
            up: leans.then(|| self.turned(side * Vec3::Z, wo)),
            outside: wo.z > 0.0 || !self.has_inside(),
        }
    }

    fn smooth_coat(&self, view: &View) -> Option<&Coat> {
        self.coat.as_ref().filter(|c| c.rough.is_none() && view.outside)
    }

    /// A direction in the frame of the layers, whose x axis is the tangent, on their side if the
    /// surface has no inside; `wo` says in the shading frame from where it is seen.
    fn turned(&self, w: Vec3, wo: Vec3) -> Vec3 {
        let w = self.frame.map_or(w, |frame| frame.to_local(w));
        let w = if wo.z < 0.0 && !self.has_inside() { Vec3::new(w.x, w.y, -w.z) } else { w };
        self.tangent.map_or(w, |t| Vec3::new(t.x * w.x + t.y * w.y, t.x * w.y - t.y * w.x, w.z))
    }

    /// The way back.
    fn turned_back(&self, w: Vec3, wo: Vec3) -> Vec3 {
        let w = self
            .tangent
            .map_or(w, |t| Vec3::new(t.x * w.x - t.y * w.y, t.x * w.y + t.y * w.x, w.z));
        let w = if wo.z < 0.0 && !self.has_inside() { Vec3::new(w.x, w.y, -w.z) } else { w };
        self.frame.map_or(w, |frame| frame.to_world(w))
    }
}

/// The cosine under which the coat sees `w`.
fn cos_of_coat(leaning: &Leaning, w: Vec3) -> f32 {
    leaning.coat.map_or(w.z.abs(), |frame| frame.z.dot(w).abs().min(1.0))
}

impl Ways<f32> {
    /// Draws one of them; what is left of the choice is as good as new.
    fn choose(&self, choice: f32) -> Option<(Way, f32)> {
        let all = [
            (Way::Mirror, self.mirror),
            (Way::Window, self.window),
            (Way::CoatMirror, self.coat_mirror),
            (Way::Coat, self.coat),
            (Way::Sheen, self.sheen),
            (Way::Facet, self.facet),
            (Way::Many, self.many),
            (Way::ManyGlass, self.many_glass),
            (Way::ManyThin, self.many_thin),
            (Way::Matte, self.matte),
            (Way::MatteThrough, self.matte_through),
        ];
        let (mut left, mut chosen) = (choice, None);
        for (way, pmf) in all {
            if pmf > 0.0 {
                chosen = Some((way, (left / pmf).min(1.0 - 0.5 * f32::EPSILON)));
                if left < pmf {
                    break;
                }
                left -= pmf;
            }
        }
        chosen
    }
}

impl Facets {
    /// What metal loses of light along `w`.
    fn lost(&self, w: Vec3) -> f32 {
        self.stretched.map_or_else(|| self.loss.at(w.z.abs()), |s| s.lost(w))
    }

    /// The mean of what is `told` over what they send on of light along `w`.
    fn reflected(&self, told: &Reflection, w: Vec3) -> f32 {
        match &self.stretched {
            None => self.seen.at(w.z.abs(), told),
            Some(stretched) => stretched.at(w, told),
        }
    }

    /// What a border that light crosses loses along `w`, seen from `side`: where facets are steeper
    /// one way than the other, in proportion to what metal does.
    fn lost_by_glass(&self, side: &Side, w: Vec3) -> f32 {
        let mu = w.z.abs();
        let lost = match &self.stretched {
            None => side.loss.at(mu),
            Some(stretched) => {
                let roughness = stretched.equal_alpha(w).sqrt();
                let usual = Loss::metal(roughness).at(mu);
                let lost = Loss::glass(roughness, side.eta).at(mu);
                if usual > 0.0 { (lost / usual).min(1.0) * stretched.lost(w) } else { lost }
            }
        };
        if side.sent_back == 0.0 { lost } else { lost + (self.lost(w) - lost) * side.sent_back }
    }
}

impl Glass {
    /// As [`RoughDielectric::new`], but only a `share` of what is lost is given back, and the part
    /// `sent_back` of what comes from below is not let through by layers above, but mirrored: of
    /// that as much is lost as facets of `metal` lose.
    fn new(eta: f32, roughness: f32, share: f32, sent_back: f32, metal: &Loss) -> Self {
        let loss = |eta: f32| Loss::glass(roughness, eta).roughly_averaged();
        let (above, below) = (loss(eta), loss(1.0 / eta));
        let below = below.with_mean(below.mean + (metal.mean - below.mean) * sent_back);
        // From the denser side so much less crosses.
        let denser = if eta < 1.0 { eta * eta } else { 1.0 };
        let through = Rise::mean_transmittance(eta) * denser / above.mean.max(below.mean);
        Self {
            above: Side { eta, loss: above, sent_back: 0.0, crossing: through * below.mean },
            below: Side {
                eta: 1.0 / eta,
                loss: below,
                sent_back,
                crossing: through * above.mean / (eta * eta),
            },
            share,
        }
    }

    /// The side that is seen, and the other one.
    fn seen_from(&self, outside: bool) -> (&Side, &Side) {
        if outside { (&self.above, &self.below) } else { (&self.below, &self.above) }
    }
}

impl Coat {
    fn new(its: &PrincipledParameters) -> Option<Self> {
        let alpha = its.coat_roughness * its.coat_roughness;
        let rough = (alpha >= Ggx::LEAST_ALPHA).then(|| RoughCoat {
            ggx: Ggx { alpha },
            loss: Loss::metal(its.coat_roughness),
            rise: Rise::new(its.coat_ior, its.coat_roughness),
        });
        let weight = its.coat;
        let color = its.coat_color.map(|c| 1.0 + (c - 1.0) * weight);
        (weight > 0.0).then_some(Self { weight, ior: its.coat_ior, color, rough })
    }

    /// The part that it reflects in all under the cosine `mu`.
    fn reflected(&self, mu: f32) -> f32 {
        match &self.rough {
            None => Fresnel::Exact.dielectric(mu, self.ior).0,
            Some(rough) => {
                let normal = gloss::normal_reflectance(self.ior);
                (1.0 - rough.loss.at(mu)) * (normal + (1.0 - normal) * rough.rise.at(mu))
            }
        }
    }

    /// What is left of light on its way through, under the cosine `mu` outside: slanted ways are
    /// longer.
    fn leg(&self, mu: f32) -> Spectrum {
        if self.color == Spectrum::WHITE {
            return Spectrum::WHITE;
        }
        let (_, cos) = Fresnel::Exact.dielectric(mu, self.ior);
        self.color.map(|c| if c > 0.0 { real::exp(real::ln(c) * 0.5 / cos) } else { 0.0 })
    }
}
