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

mod coat;
mod facets;
mod leaning;
mod parameters;
mod reflectance;
mod value;
mod ways;

pub use parameters::PrincipledParameters;

use super::energy::Loss;
use super::gloss::{self, COSINES, Reflection, Rise, SeenFacets, StretchedFacets};
use super::microfacet::{Ggx, StretchedGgx};
use super::oren_nayar::OrenNayar;
use super::rough_dielectric::RoughDielectric;
use super::sample::BsdfSample;
use super::sheen::Sheen;
use super::thin_film::ThinFilm;
use crate::color::Spectrum;
use crate::math::warp;
use coat::Coat;
use facets::{Facets, Glass};
use leaning::Leaning;
use reflectance::Crossing;
use rutilant_geom::{Frame, Vec2, Vec3, real};
use ways::{Way, Ways};

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

/// What a direction `wo` decides.
struct View {
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
    ways: Ways,
    leaning: Leaning,
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
        let gloss = || Reflection::cosines().map(|cos| layers.gloss(cos));
        let most = |gloss: [Spectrum; COSINES]| Reflection::new(gloss.map(Spectrum::max_channel));
        if !is_rough {
            layers.mean_left = 1.0 - most(gloss()).mean();
            return layers;
        }

        // What facets lose, and how much of it metal and gloss give back.
        let loss = Loss::metal(steepness).roughly_averaged();
        let stretched = is_stretched
            .then(|| StretchedFacets::new(across.sqrt(), its.anisotropy, [along, across]));
        let gloss = (is_stretched || layers.film.is_some()).then(gloss);
        let step = if is_stretched { StretchedFacets::STEP } else { SeenFacets::STEP };
        layers.told = gloss.map(|gloss| most(gloss).raised(step));
        let mean_lost = stretched.map_or(loss.mean, |s| s.mean_lost);
        let series = |f: f32| f * f * (1.0 - mean_lost) / (1.0 - f * mean_lost);
        let [mean_metal, mean_gloss] = layers.mean_reflectances(gloss);
        let (many_metal, many_gloss) = (mean_metal.map(series), mean_gloss.map(series));
        let facets = Facets {
            ggx: StretchedGgx { along, across: if is_stretched { across } else { along } },
            loss: loss.with_mean(mean_lost),
            stretched,
            seen: SeenFacets::new(steepness),
            rise: Rise::new(its.eta, steepness),
            many_metal,
            many_gloss,
        };
        let once = facets.mean_reflected(layers.told.as_ref(), layers.most);
        layers.facets = Some(facets);
        layers.mean_left = 1.0 - (once + mean_lost * many_gloss.max_channel());

        // The border that light crosses.
        let ratio = its.eta.max(1.0 / its.eta);
        if clear > 0.0 && !its.thin_walled && ratio >= RoughDielectric::LEAST_RATIO {
            layers.border = Some(Glass::new(
                its.eta,
                steepness,
                layers.share_given_back(),
                layers.mean_sent_back(),
                &facets.loss,
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
        // Crossing gives nothing where there is nothing clear; below films the others take long.
        let Crossing { reflected, passed, .. } = self.crossing(1.0, true);
        let clear = (reflected + self.its.base_color * passed) * self.clear;
        let part = |share: f32, of: &dyn Fn() -> Spectrum| match share {
            0.0 => Spectrum::BLACK,
            _ => of() * share,
        };
        let gloss = part(self.opaque, &|| self.gloss(1.0));
        let base = matte + clear + gloss + part(self.metal, &|| self.metal(1.0));
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
                return Some((view.leaning.onto_side(wo, mirrored, false), 1.0));
            }
            Way::Sheen => Some(warp::uniform_hemisphere(u)),
            Way::Facet => {
                let facet = self.facets?.ggx.sample_seen(up, u);
                let cos = up.dot(facet).clamp(0.0, 1.0);
                let mirrored = 2.0 * cos * facet - up;
                let crossing = self.crossing(cos, view.leaning.outside);
                if choice < self.reflects(cos, &crossing) {
                    Some(mirrored).filter(|w| w.z > 0.0)
                } else if self.its.thin_walled {
                    Some(-mirrored).filter(|w| w.z < 0.0).map(|w| Vec3::new(-w.x, -w.y, w.z))
                } else {
                    eta = self.index_beyond(view.leaning.outside);
                    let bent = (cos / eta - crossing.cos_beyond) * facet - up / eta;
                    Some(bent).filter(|w| w.z < 0.0)
                }
            }
            Way::Many => Some(self.facets?.loss.sample(u)),
            Way::ManyThin => Some(-self.facets?.loss.sample(u)),
            Way::ManyGlass => {
                let (side, beyond) = self.border.as_ref()?.seen_from(view.leaning.outside);
                if choice < side.crossing {
                    eta = self.index_beyond(view.leaning.outside);
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
                eta = self.matte_index_beyond(view.leaning.outside);
                Some(-warp::cosine_hemisphere(u)).filter(|w| w.z < 0.0)
            }
        };
        let wi = facing(above?);
        let through = wo.z * wi.z < 0.0;
        Some((view.leaning.onto_side(wo, wi, through), eta))
    }

    /// What `wo` decides, in the frame of the layers.
    fn view(&self, wo: Vec3, leaning: Leaning) -> View {
        let o = wo.z.abs();
        let outside = leaning.outside;
        // The layers are in front, and on both sides of what has no inside.
        let below_sheen = match &self.sheen {
            Some(sheen) if outside => 1.0 - sheen.taken(o),
            _ => 1.0,
        };
        let (coat, tint) = match &self.coat {
            Some(coat) if outside => {
                let cos = leaning.cos_of_coat(wo);
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
        let mut ways = Ways::default();
        ways[Way::Sheen] = 1.0 - below_sheen;
        let below_gloss = below_coat * self.opaque * left;
        ways[Way::Matte] = below_gloss * self.matte.albedo().max_channel();
        ways[Way::MatteThrough] = below_gloss * self.matte_through.max_channel();
        match self.coat {
            Some(Coat { rough: Some(_), .. }) => ways[Way::Coat] = below_sheen * coat,
            Some(Coat { rough: None, .. }) if leaning.coat.is_some() => {
                ways[Way::CoatMirror] = below_sheen * coat;
            }
            Some(Coat { rough: None, .. }) => ways[Way::Mirror] += below_sheen * coat,
            None => {}
        }
        if self.is_clear() {
            ways[Way::Mirror] += below_coat * self.clear * crossing.reflected.max_channel();
            ways[Way::Window] = below_coat * self.clear * crossing.passed * color;
        }
        if let Some(facets) = &self.facets {
            ways[Way::Facet] = below_coat * (1.0 - lost) * reflected;
            ways[Way::Many] = below_coat * lost * self.many().max_channel();
            if let Some(glass) = &self.border {
                let (side, _) = glass.seen_from(outside);
                let lost = facets.lost_by_glass(side, wo);
                ways[Way::Facet] += below_coat * self.clear * (1.0 - lost);
                ways[Way::ManyGlass] = below_coat * self.clear * glass.share * lost;
            } else if self.clear > 0.0 && its.thin_walled {
                let once = crossing.reflected.max_channel() + crossing.passed * color;
                ways[Way::Facet] += below_coat * self.clear * (1.0 - lost) * once;
                ways[Way::ManyThin] = below_coat * self.clear * lost * self.many_thin() * color;
            }
        } else {
            ways[Way::Mirror] += below_coat * reflected;
        }
        if leaning.turns_away(wo) {
            ways = ways.only(&[Way::Coat, Way::CoatMirror]);
        }
        let sum = ways.sum();
        ways = if sum > 0.0 { ways.scaled(1.0 / sum) } else { Ways::default() };

        // Glass is crossed as often from inside as from outside: light paths rely on it.
        if !outside && ways[Way::Window] > 0.0 {
            let other = Vec3::new(0.0, 0.0, crossing.cos_outside);
            let sin = (1.0 - other.z * other.z).max(0.0).sqrt();
            let across = Vec2::new(wo.x, wo.y).normalize_or(Vec2::X) * sin;
            let other = Vec3::new(across.x, across.y, other.z);
            let window = self.view(other, Leaning { outside: true, ..leaning }).ways[Way::Window];
            let rest = ways.sum() - ways[Way::Window];
            let scale = if rest > 0.0 { (1.0 - window) / rest } else { 0.0 };
            ways = ways.scaled(scale);
            ways[Way::Window] = window;
        }
        View { below_sheen, below_coat, tint, lost, left, ways, leaning }
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
        self.coat.as_ref().filter(|c| c.rough.is_none() && view.leaning.outside)
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
