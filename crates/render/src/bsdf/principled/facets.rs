//! Facets of metal, gloss and clear borders: what they lose and give back.

use crate::bsdf::energy::Loss;
use crate::bsdf::gloss::{Reflection, Rise, SeenFacets, StretchedFacets};
use crate::bsdf::microfacet::StretchedGgx;
use crate::color::Spectrum;
use rutilant_geom::Vec3;

/// Facets that reflect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facets {
    pub(super) ggx: StretchedGgx,
    pub(super) loss: Loss,
    /// Set where they are steeper one way than the other.
    pub(super) stretched: Option<StretchedFacets>,
    pub(super) seen: SeenFacets,
    pub(super) rise: Rise,
    /// What metal and gloss give back on the side of the light of what facets lose, per part lost.
    pub(super) many_metal: Spectrum,
    pub(super) many_gloss: Spectrum,
}

/// Facets of glass that bend light: see [`RoughDielectric`](crate::bsdf::RoughDielectric).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glass {
    pub(super) above: Side,
    pub(super) below: Side,
    /// The part of what is lost that is given back.
    pub(super) share: f32,
}

/// What is lost and given back, seen from one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Side {
    /// Index of refraction beyond over that on this side.
    pub(super) eta: f32,
    pub(super) loss: Loss,
    /// The part of what crosses that layers above send back, by facets as if these mirrored it.
    pub(super) sent_back: f32,
    /// The part of what is lost that crosses the border when it is given back.
    pub(super) crossing: f32,
}

impl Facets {
    /// What metal loses of light along `w`.
    pub(super) fn lost(&self, w: Vec3) -> f32 {
        self.stretched.map_or_else(|| self.loss.at(w.z.abs()), |s| s.lost(w))
    }

    /// What gloss reflects at one facet of light along `w`, as a mean over what facets send on: as is
    /// `told`, or as it rises from normal incidence to grazing.
    pub(super) fn reflected(&self, told: Option<&Reflection>, ends: [f32; 2], w: Vec3) -> f32 {
        let [normal, grazing] = ends;
        match (told, &self.stretched) {
            (None, _) => normal + (grazing - normal) * self.rise.at(w.z.abs()),
            (Some(told), None) => self.seen.at(w.z.abs(), told),
            (Some(told), Some(stretched)) => stretched.at(w, told),
        }
    }

    /// The same as a mean over the cosine-weighted hemisphere, of all light.
    pub(super) fn mean_reflected(&self, told: Option<&Reflection>, ends: [f32; 2]) -> f32 {
        let [normal, grazing] = ends;
        match (told, &self.stretched) {
            (None, _) => normal * (1.0 - self.loss.mean) + (grazing - normal) * self.rise.mean,
            (Some(told), None) => self.seen.mean(told),
            (Some(told), Some(stretched)) => stretched.mean(told),
        }
    }

    /// What a border that light crosses loses along `w`, seen from `side`: where facets are steeper
    /// one way than the other, in proportion to what metal does.
    pub(super) fn lost_by_glass(&self, side: &Side, w: Vec3) -> f32 {
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
    pub(super) fn new(eta: f32, roughness: f32, share: f32, sent_back: f32, metal: &Loss) -> Self {
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
    pub(super) fn seen_from(&self, outside: bool) -> (&Side, &Side) {
        if outside { (&self.above, &self.below) } else { (&self.below, &self.above) }
    }
}
