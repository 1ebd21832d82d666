//! What layers send from one direction to another, and how often that is drawn.

use super::Principled;
use super::View;
use super::ways::Way;
use crate::bsdf::fresnel::Fresnel;
use crate::bsdf::sample::BsdfSample;
use crate::color::Spectrum;
use crate::math::warp;
use rutilant_geom::Vec3;
use std::f32::consts::FRAC_1_PI;

impl Principled {
    /// The mirrored direction, by base and coat together.
    pub(super) fn mirrored(&self, view: &View, wo: Vec3) -> Option<BsdfSample> {
        let o = wo.z.abs();
        let mut value = Spectrum::BLACK;
        if self.facets.is_none() {
            value += self.metal(o) * self.metal + self.gloss(o) * self.opaque;
        }
        if self.is_clear() {
            value += self.crossing(o, view.leaning.outside).reflected * self.clear;
        }
        value *= view.tint * view.tint * view.below_coat;
        if let (Some(coat), None) = (self.smooth_coat(view), &view.leaning.coat) {
            value += Spectrum::splat(coat.weight * coat.reflected(o) * view.below_sheen);
        }
        let pdf = view.ways[Way::Mirror];
        let wi = view.leaning.onto_side(wo, Vec3::new(-wo.x, -wo.y, wo.z), false);
        Some(BsdfSample { wi, weight: value / pdf, pdf, delta: true, eta: 1.0 })
    }

    /// The direction that a smooth coat with a normal of its own mirrors.
    pub(super) fn mirrored_by_coat(&self, view: &View, wo: Vec3) -> Option<BsdfSample> {
        let (coat, normal) = (self.smooth_coat(view)?, view.leaning.coat?.z);
        let value = coat.weight * coat.reflected(view.leaning.cos_of_coat(wo));
        let pdf = view.ways[Way::CoatMirror];
        let weight = Spectrum::splat(value * view.below_sheen) / pdf;
        let wi = (2.0 * wo.dot(normal) * normal - wo).try_normalize()?;
        let wi = view.leaning.onto_side(wo, wi, false);
        Some(BsdfSample { wi, weight, pdf, delta: true, eta: 1.0 })
    }

    /// The way through a clear border that is smooth or thin.
    pub(super) fn passed(&self, view: &View, wo: Vec3) -> Option<BsdfSample> {
        let crossing = self.crossing(wo.z.abs(), view.leaning.outside);
        let eta = self.index_beyond(view.leaning.outside);
        let wi = if eta == 1.0 {
            -wo
        } else {
            let down = -crossing.cos_beyond.copysign(wo.z);
            Vec3::new(-wo.x / eta, -wo.y / eta, down).normalize()
        };
        let tint = self.coat.map_or(Spectrum::WHITE, |c| c.leg(crossing.cos_outside));
        let value = self.its.base_color * tint * (self.clear * crossing.passed * view.below_coat);
        let pdf = view.ways[Way::Window];
        let weight = value / (pdf * eta * eta);
        let lies = wi.z == 0.0;
        let wi = view.leaning.onto_side(wo, wi, true);
        (!lies).then_some(BsdfSample { wi, weight, pdf, delta: true, eta })
    }

    /// What is sent from `wi` to `wo`, with the density of drawing it.
    pub(super) fn seen(&self, view: &View, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let through = view.leaning.crosses(wo, wi);
        let seen = |wi: Vec3| {
            if through { self.seen_through(view, wo, wi) } else { self.reflected(view, wo, wi) }
        };
        let (value, pdf) = seen(wi);
        let Some(folded) = view.leaning.folded(wi) else { return (value, pdf) };
        let (more, more_pdf) = seen(folded);
        (value + more, pdf + more_pdf)
    }

    /// What layers send from `wi` to `wo` on one side of theirs, with the density of drawing it.
    fn reflected(&self, view: &View, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let (o, i) = (wo.z.abs(), wi.z.abs());
        let ways = &view.ways;
        if view.leaning.turns_away(wo) || wo.z * wi.z < 0.0 {
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
            if hidden > 0.0 && ways[Way::Facet] > 0.0 {
                let density = facets.ggx.density(facet) * 0.5;
                let crossing = self.crossing(cos, view.leaning.outside);
                base += self.rough_color(cos, &crossing) * (density * i / hidden);
                pdf += ways[Way::Facet] * self.reflects(cos, &crossing) * density / (o + length_o);
            }
            let many = self.many();
            base += many * (view.lost * facets.lost(wi) * i * FRAC_1_PI / facets.loss.mean);
            pdf += ways[Way::Many] * facets.loss.pdf(i);
        }
        if let (Some(glass), Some(facets)) = (&self.border, &self.facets) {
            let (side, _) = glass.seen_from(view.leaning.outside);
            let returning = 1.0 - side.crossing;
            let lost = facets.lost_by_glass(side, wo) * facets.lost_by_glass(side, wi);
            let lobe = glass.share * lost * i * (FRAC_1_PI / side.loss.mean);
            base += Spectrum::splat(self.clear * returning * lobe);
            pdf += ways[Way::ManyGlass] * returning * side.loss.pdf(i);
        }

        // The matte body below gloss.
        if ways[Way::Matte] > 0.0 {
            // What gloss takes of light along `wi` is taken from what is sent evenly: only of that is
            // it known how much there is of it in all.
            let through = self.opaque * view.left;
            let entering = self.left(wi) / self.mean_left;
            if self.its.diffuse_roughness == 0.0 {
                base += self.matte.albedo() * (through * entering * i * FRAC_1_PI);
                pdf += ways[Way::Matte] * warp::cosine_hemisphere_pdf(i);
            } else {
                let even = self.matte.even_part() * (i * (entering - 1.0));
                base += (self.matte.eval_cos(wo, wi) + even).map(|c| c.max(0.0)) * through;
                pdf += ways[Way::Matte] * self.matte.pdf(wo, wi);
            }
        }
        let tint_in = match &self.coat {
            Some(coat) if view.leaning.outside => coat.leg(view.leaning.cos_of_coat(wi)),
            _ => Spectrum::WHITE,
        };
        let mut value = base * view.tint * tint_in * view.below_coat;

        // Coat and sheen above it.
        if ways[Way::Coat] > 0.0 {
            let (reflected, density) = self.by_coat(view, wo, wi);
            value += Spectrum::splat(reflected);
            pdf += density;
        }
        if let (Some(sheen), true) = (&self.sheen, ways[Way::Sheen] > 0.0) {
            value += sheen.eval_cos(wo, wi);
            pdf += ways[Way::Sheen] * warp::UNIFORM_HEMISPHERE_PDF;
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
        (value, view.ways[Way::Coat] * density / (o + length_o))
    }

    /// The same through the surface.
    fn seen_through(&self, view: &View, wo: Vec3, wi: Vec3) -> (Spectrum, f32) {
        let (mut value, mut pdf) = (Spectrum::BLACK, 0.0);
        if view.leaning.turns_away(wo) || wo.z * wi.z >= 0.0 {
            return (value, pdf);
        }
        let (o, i) = (wo.z.abs(), wi.z.abs());
        let ways = &view.ways;
        let eta = self.index_beyond(view.leaning.outside);

        // Through a rough border: by one facet and by several.
        if let (Some(glass), Some(facets), true) =
            (&self.border, &self.facets, ways[Way::Facet] > 0.0)
        {
            let (side, beyond) = glass.seen_from(view.leaning.outside);
            let lost = facets.lost_by_glass(side, wo) * facets.lost_by_glass(beyond, wi);
            let lobe = glass.share * lost * i * (FRAC_1_PI / beyond.loss.mean);
            let many = self.clear * side.crossing * lobe / (eta * eta);
            pdf += ways[Way::ManyGlass] * side.crossing * beyond.loss.pdf(i);
            value += self.its.base_color * many;
            let half = wo + wi * eta;
            let length2 = half.length_squared();
            let facet = half * (half.z.signum() / length2.sqrt());
            let (cos_o, cos_i) = (wo.dot(facet) * wo.z.signum(), wi.dot(facet) * wi.z.signum());
            if length2 > 0.0 && cos_o > 0.0 && cos_i > 0.0 {
                // Walter 2007, equations 17 and 21, with separate masking.
                let crossing = self.crossing(cos_o.min(1.0), view.leaning.outside);
                let (length_o, length_i) =
                    (facets.ggx.squeezed_length(wo), facets.ggx.squeezed_length(wi));
                let once =
                    facets.ggx.density(facet) * cos_o * cos_i / length2 * 2.0 / (o + length_o);
                let passed = self.clear * crossing.passed * once * 2.0 * i / (i + length_i);
                value += self.its.base_color * passed;
                pdf += ways[Way::Facet]
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
            if length > 0.0 && ways[Way::Facet] > 0.0 {
                let density = facets.ggx.density(half * (half.z.signum() / length)) * 0.5;
                let cos = (0.5 * length).min(1.0);
                let crossing = self.crossing(cos, view.leaning.outside);
                let once = density * i / (o * length_i + i * length_o);
                value += self.its.base_color * (self.clear * crossing.passed * once);
                pdf += ways[Way::Facet] * (1.0 - self.reflects(cos, &crossing)) * density
                    / (o + length_o);
            }
            let lobe = view.lost * facets.lost(wi) * i * FRAC_1_PI / facets.loss.mean;
            value += self.its.base_color * (self.clear * self.many_thin() * lobe);
            pdf += ways[Way::ManyThin] * facets.loss.pdf(i);
        }

        // Through a matte body.
        if ways[Way::MatteThrough] > 0.0 {
            let through = self.opaque * view.left * self.left(wi) / self.mean_left;
            let eta = self.matte_index_beyond(view.leaning.outside);
            value += self.matte_through * (through * i * FRAC_1_PI / (eta * eta));
            pdf += ways[Way::MatteThrough] * warp::cosine_hemisphere_pdf(i);
        }
        let tint = match &self.coat {
            Some(coat) if !view.leaning.outside => coat.leg(i),
            _ => view.tint,
        };
        (value * tint * view.below_coat, pdf)
    }
}
