//! What metal, gloss and the clear border reflect and let through.

use super::Principled;
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::gloss::{self, COSINES, Reflection, Rise};
use crate::color::Spectrum;
use rutilant_geom::Vec3;

/// What the clear border does to light at one of its facets.
pub(super) struct Crossing {
    /// What it reflects.
    pub(super) reflected: Spectrum,
    /// The part that crosses, before it is coloured.
    pub(super) passed: f32,
    /// The cosine beyond.
    pub(super) cos_beyond: f32,
    /// The cosine in front of the border.
    pub(super) cos_outside: f32,
}

impl Principled {
    /// What metal reflects at a facet: Schlick's approximation, and grazing light whole.
    pub(super) fn metal(&self, cos: f32) -> Spectrum {
        let m = 1.0 - cos;
        let rise = (m * m) * (m * m) * m;
        let bare = self.its.base_color.map(|c| c + (1.0 - c) * rise);
        self.filmed(bare, self.its.base_color, cos)
    }

    /// What gloss reflects at a facet, seen from the thinner side.
    pub(super) fn gloss(&self, cos: f32) -> Spectrum {
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
    pub(super) fn normal_gloss(&self) -> Spectrum {
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
    pub(super) fn mean_reflectances(&self, gloss: Option<[Spectrum; COSINES]>) -> [Spectrum; 2] {
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
        let plain = || {
            let rise = Rise::new(self.its.eta, 0.0).mean;
            self.normal_gloss().map(|f| f + (grazing - f) * rise)
        };
        [metal, gloss.map_or_else(plain, mean)]
    }

    /// What gloss leaves to a matte body of light along `w`.
    pub(super) fn left(&self, w: Vec3) -> f32 {
        self.left_of(self.facets.as_ref().map_or(0.0, |f| f.lost(w)), w)
    }

    pub(super) fn left_of(&self, lost: f32, w: Vec3) -> f32 {
        let reflected = match &self.facets {
            None => self.gloss(w.z.abs()).max_channel(),
            Some(facets) => {
                let once = facets.reflected(self.told.as_ref(), self.most, w);
                (1.0 - lost) * once + lost * facets.many_gloss.max_channel()
            }
        };
        (1.0 - reflected).max(0.0)
    }

    /// What metal and gloss give back of what facets lose, per part lost.
    pub(super) fn many(&self) -> Spectrum {
        let Some(facets) = &self.facets else { return Spectrum::BLACK };
        let gloss = self.opaque + if self.its.thin_walled { self.clear } else { 0.0 };
        facets.many_metal * self.metal + facets.many_gloss * gloss
    }

    /// The part of what facets of something thin lose that goes through.
    pub(super) fn many_thin(&self) -> f32 {
        self.facets.as_ref().map_or(0.0, |f| 1.0 - f.many_gloss.max_channel())
    }

    /// What the clear border does to light under the cosine `cos` on the side of `wo`.
    pub(super) fn crossing(&self, cos: f32, outside: bool) -> Crossing {
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
    pub(super) fn rough_color(&self, cos: f32, crossing: &Crossing) -> Spectrum {
        let base = self.metal(cos) * self.metal + self.gloss(cos) * self.opaque;
        if self.clear > 0.0 && !self.is_clear() {
            base + crossing.reflected * self.clear
        } else {
            base
        }
    }

    /// How often a rough facet reflects, of all light that it sends on.
    pub(super) fn reflects(&self, cos: f32, crossing: &Crossing) -> f32 {
        if self.clear == 0.0 || self.is_clear() {
            return 1.0;
        }
        let reflected = self.rough_color(cos, crossing).max_channel();
        let passed = self.clear * crossing.passed * self.its.base_color.max_channel();
        if passed > 0.0 { reflected / (reflected + passed) } else { 1.0 }
    }
}
