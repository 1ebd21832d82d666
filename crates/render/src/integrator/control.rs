//! A number beside each path that is zero on average, for the film to cancel noise with.
//!
//! Where a path first looks for light in both ways, let x and y be what the light sample and the
//! scattered ray found, and w the balance heuristic's shares. Then
//!
//! C = w_bsdf(x) − w_light(y)
//!
//! counts what each way leaves to the other, 0 where it brings no light to the camera. Whatever the
//! light and whatever is in its way, its mean is zero: both terms average to ∫ p_light p_bsdf /
//! (p_light + p_bsdf) over the directions from which light arrives.
//!
//! Optimal weights take α_light p_light + α_bsdf p_bsdf, whatever fits best, from the integrand of
//! the balance heuristic's estimate F, and add its known integral α_light + α_bsdf. As the shares
//! add up to one, that is F + δ C with δ = α_light − α_bsdf: one number to learn, which the film
//! does (`film/learned.rs`). Where light is occluded, C leaves out what their estimator includes;
//! its mean is zero either way.
//!
//! Source: Kondapaneni et al., "Optimal Multiple Importance Sampling", SIGGRAPH 2019, for one
//! sample of each technique.

use crate::color::Spectrum;
use crate::follow::Met;

/// What a path tells of the shares that light and BSDF sampling have in the light it finds.
pub(super) trait Control {
    /// What is left at the camera of light that is told of from here on.
    fn carries(&mut self, throughput: Spectrum);

    /// A surface was reached at which light is looked for in both ways.
    fn surface(&mut self);

    /// The light sample there scatters this light on; BSDF sampling has this share in it.
    fn light(&mut self, light: Spectrum, bsdf_share: f32);

    /// The scattered ray found this light; light sampling has this share in it.
    fn scattered(&mut self, light: Spectrum, light_share: f32);

    /// Light of this emitter is found, which is still to be multiplied by what is left of it at the
    /// camera.
    fn found(&mut self, _emitter: usize, _light: Spectrum) {}

    /// The path survived roulette, and stands for this many.
    fn survived(&mut self, stands_for: f32);

    /// The path's segment number `depth`, from 1 on, met a surface.
    fn met(&mut self, _depth: u32, _met: &Met<'_>) {}

    /// The path has brought this radiance when its segment number `depth` has told what shines at
    /// its end.
    fn seen(&mut self, _depth: u32, _radiance: Spectrum) {}
}

/// Nothing is kept.
impl Control for () {
    fn carries(&mut self, _: Spectrum) {}
    fn surface(&mut self) {}
    fn light(&mut self, _: Spectrum, _: f32) {}
    fn scattered(&mut self, _: Spectrum, _: f32) {}
    fn survived(&mut self, _: f32) {}
}

/// The first such surface is kept: later ones share their noise with all that led to them.
pub(super) struct FirstSurface {
    /// C so far.
    pub(super) value: f32,
    /// How many surfaces there were.
    surfaces: u32,
    /// How many paths this one stands for since it left the first.
    stands_for: f32,
    throughput: Spectrum,
}

impl FirstSurface {
    pub(super) fn new() -> Self {
        Self { value: 0.0, surfaces: 0, stands_for: 1.0, throughput: Spectrum::BLACK }
    }

    /// False for light that does not reach the camera, where roulette may end one way and not the
    /// other, and after the first surface.
    fn counts(&self, light: Spectrum) -> bool {
        self.surfaces == 1 && !(self.throughput * light).is_black()
    }
}

impl Control for FirstSurface {
    fn carries(&mut self, throughput: Spectrum) {
        self.throughput = throughput;
    }

    fn surface(&mut self) {
        self.surfaces = self.surfaces.saturating_add(1);
        if self.surfaces == 1 {
            self.stands_for = 1.0;
        }
    }

    fn light(&mut self, light: Spectrum, bsdf_share: f32) {
        if self.counts(light) {
            self.value += bsdf_share;
        }
    }

    fn scattered(&mut self, light: Spectrum, light_share: f32) {
        if self.counts(light) {
            self.value -= self.stands_for * light_share;
        }
    }

    fn survived(&mut self, stands_for: f32) {
        self.stands_for *= stands_for;
    }
}
