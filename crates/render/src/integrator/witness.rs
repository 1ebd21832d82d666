//! What a path tells beside its light, while it is traced alone: what it met first, which part of the
//! light came after how many bounces, and which from which lights.

use super::control::Control;
use super::estimate::Watched;
use super::first::{First, View};
use crate::color::Spectrum;
use crate::follow::Met;
use crate::prepare::Prepared;

/// Notes what is asked of one path.
pub(super) struct Witness<'a> {
    scene: &'a Prepared,
    view: &'a View,
    look: bool,
    first: Option<(u32, Option<First>)>,
    /// As those of [`Watched`].
    parts: [Spectrum; 2],
    /// The depths that the path has reached.
    depth: u32,
    /// What started from the lights of each group; empty where that is not asked for.
    groups: &'a mut [Spectrum],
    /// What is left at the camera of light that is found.
    throughput: Spectrum,
}

impl<'a> Witness<'a> {
    /// Adds to `groups` what is found.
    pub(super) fn new(
        scene: &'a Prepared,
        view: &'a View,
        look: bool,
        groups: &'a mut [Spectrum],
    ) -> Self {
        let (first, parts, depth, throughput) = (None, [Spectrum::BLACK; 2], 0, Spectrum::WHITE);
        Self { scene, view, look, first, parts, depth, groups, throughput }
    }

    /// All of it, when the path has ended and brought this `radiance`.
    pub(super) fn told(mut self, radiance: Spectrum, control: f32) -> Watched {
        for part in self.parts.iter_mut().skip(self.depth as usize) {
            *part = radiance;
        }
        Watched { radiance, control, parts: self.parts, first: self.first }
    }
}

impl Control for Witness<'_> {
    fn carries(&mut self, throughput: Spectrum) {
        self.throughput = throughput;
    }

    fn surface(&mut self) {}
    fn light(&mut self, _: Spectrum, _: f32) {}
    fn scattered(&mut self, _: Spectrum, _: f32) {}
    fn survived(&mut self, _: f32) {}

    fn found(&mut self, emitter: usize, light: Spectrum) {
        if !self.groups.is_empty()
            && let Some(sum) = self.groups.get_mut(self.scene.groups().of(emitter))
        {
            *sum += self.throughput * light;
        }
    }

    fn met(&mut self, depth: u32, met: &Met<'_>) {
        if depth == 1 && self.view.layers.tell_firsts() {
            self.first = Some(self.view.told(self.scene, met, self.look));
        }
    }

    fn seen(&mut self, depth: u32, radiance: Spectrum) {
        if let Some(part) = self.parts.get_mut(depth as usize - 1) {
            (*part, self.depth) = (radiance, depth);
        }
    }
}

/// Both are told everything.
impl<A: Control, B: Control> Control for (A, B) {
    fn carries(&mut self, throughput: Spectrum) {
        self.0.carries(throughput);
        self.1.carries(throughput);
    }

    fn surface(&mut self) {
        self.0.surface();
        self.1.surface();
    }

    fn light(&mut self, light: Spectrum, bsdf_share: f32) {
        self.0.light(light, bsdf_share);
        self.1.light(light, bsdf_share);
    }

    fn scattered(&mut self, light: Spectrum, light_share: f32) {
        self.0.scattered(light, light_share);
        self.1.scattered(light, light_share);
    }

    fn found(&mut self, emitter: usize, light: Spectrum) {
        self.0.found(emitter, light);
        self.1.found(emitter, light);
    }

    fn survived(&mut self, stands_for: f32) {
        self.0.survived(stands_for);
        self.1.survived(stands_for);
    }

    fn met(&mut self, depth: u32, met: &Met<'_>) {
        self.0.met(depth, met);
        self.1.met(depth, met);
    }

    fn seen(&mut self, depth: u32, radiance: Spectrum) {
        self.0.seen(depth, radiance);
        self.1.seen(depth, radiance);
    }
}
