//! What every integrator does.

use super::caustics::Caustics;
use super::first::{First, NOTHING, View};
use super::packet::Starts;
use crate::color::Spectrum;
use crate::film::Layer;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::Ray;
use rutilant_geom::lanes::LANES;
use std::ops::Range;

/// What came of many starts, eight for each packet, in their order.
#[derive(Default)]
pub(crate) struct Found {
    pub(crate) radiance: Vec<Spectrum>,
    /// See [`Integrator::controlled`].
    pub(crate) controls: Vec<f32>,
    /// Of the radiance what was seen without a bounce; empty where it is not asked for.
    pub(crate) emission: Vec<Spectrum>,
    /// That with what came after one bounce.
    pub(crate) direct: Vec<Spectrum>,
    /// Of the radiance what started from the lights of each group.
    pub(crate) groups: GroupLight,
    /// The number of the object that each camera ray met first, or [`NOTHING`]; empty where it is not
    /// asked for.
    pub(crate) objects: Vec<u32>,
    /// More of what some of them met, by the number of the start, which rises.
    pub(crate) firsts: Vec<(u32, First)>,
}

/// Light by the groups of lights that it started from.
#[derive(Default)]
pub(crate) struct GroupLight {
    /// How many groups there are: none where they are not asked for.
    each: usize,
    /// (start, group).
    light: Vec<Spectrum>,
}

impl GroupLight {
    fn clear(&mut self, starts: usize, each: usize) {
        self.each = each;
        self.light.clear();
        self.light.resize(starts * each, Spectrum::BLACK);
    }

    /// Whether groups are asked for.
    #[inline(always)]
    pub(crate) fn are_told(&self) -> bool {
        self.each > 0
    }

    /// What these starts brought: (start, group).
    pub(crate) fn of(&self, starts: Range<usize>) -> &[Spectrum] {
        &self.light[starts.start * self.each..starts.end * self.each]
    }

    /// The groups of a start.
    pub(crate) fn of_mut(&mut self, start: usize) -> &mut [Spectrum] {
        &mut self.light[start * self.each..(start + 1) * self.each]
    }

    /// Adds light of a group to that of a start.
    #[inline(always)]
    pub(super) fn add(&mut self, start: u32, group: usize, light: Spectrum) {
        if let Some(sum) = self.light.get_mut(start as usize * self.each + group) {
            *sum += light;
        }
    }
}

impl Found {
    /// Room for so many starts, all black.
    fn clear(&mut self, count: usize, view: Option<&View>) {
        let asked = |asked: fn(&View) -> bool| if view.is_some_and(asked) { count } else { 0 };
        let of_light = asked(|view| view.layers.has(Layer::Light));
        for (light, count) in [
            (&mut self.radiance, count),
            (&mut self.emission, of_light),
            (&mut self.direct, of_light),
        ] {
            light.clear();
            light.resize(count, Spectrum::BLACK);
        }
        self.groups.clear(count, view.map_or(0, |view| view.groups));
        self.controls.clear();
        self.controls.resize(count, 0.0);
        self.objects.clear();
        self.objects.resize(asked(|view| view.layers.tell_firsts()), NOTHING);
        self.firsts.clear();
    }

    /// Leaves out the parts of the radiance of a start.
    pub(crate) fn drop_parts(&mut self, start: usize) {
        for part in [&mut self.emission, &mut self.direct] {
            if let Some(part) = part.get_mut(start) {
                *part = Spectrum::BLACK;
            }
        }
        self.groups.of_mut(start).fill(Spectrum::BLACK);
    }
}

/// What came of one start, with what is asked about it.
pub(crate) struct Watched {
    pub(crate) radiance: Spectrum,
    pub(crate) control: f32,
    /// What was seen without a bounce, and that with what came after one.
    pub(crate) parts: [Spectrum; 2],
    /// The number of the object that was met first, and more of it where that is asked for.
    pub(crate) first: Option<(u32, Option<First>)>,
}

/// Gives the radiance that one ray brings, estimated once.
pub(crate) trait Integrator: Sync {
    /// The radiance arriving along `ray` (of unit direction), in W/(m² sr), or what else the
    /// integrator shows. Counts the rays it traces.
    fn radiance<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> Spectrum;

    /// What [`controlled`](Self::controlled) gives for each start, or [`watched`](Self::watched)
    /// where there is a `view`.
    fn estimates<S: Sampler>(
        &self,
        scene: &Prepared,
        starts: &[Starts<S>],
        view: Option<&View>,
        found: &mut Found,
        rays: &mut u64,
    ) {
        found.clear(starts.len() * LANES, view);
        if self.trace_together(scene, starts, view, found, rays) {
            return;
        }
        for (i, Starts { rays: first, samplers, looks }) in starts.iter().enumerate() {
            for (lane, sampler) in samplers.iter().enumerate().filter(|(l, _)| first.is_there(*l)) {
                let (slot, ray) = (i * LANES + lane, first.ray(lane));
                let Some(view) = view else {
                    (found.radiance[slot], found.controls[slot]) =
                        self.controlled(scene, ray, sampler, rays);
                    continue;
                };
                let view = (view, looks >> lane & 1 == 1);
                let groups = found.groups.of_mut(slot);
                let watched = self.watched(scene, ray, sampler, view, groups, rays);
                (found.radiance[slot], found.controls[slot]) = (watched.radiance, watched.control);
                if !found.emission.is_empty() {
                    [found.emission[slot], found.direct[slot]] = watched.parts;
                }
                if let Some((object, first)) = watched.first {
                    found.objects[slot] = object;
                    found.firsts.extend(first.map(|first| (slot as u32, first)));
                }
            }
        }
    }

    /// Finds what is asked of all starts at once, if the integrator can do that in this scene, with
    /// the bits that each would bring alone; false if it cannot.
    fn trace_together<S: Sampler>(
        &self,
        _: &Prepared,
        _: &[Starts<S>],
        _: Option<&View>,
        _: &mut Found,
        _: &mut u64,
    ) -> bool {
        false
    }

    /// The same radiance, and a number whose mean is zero and whose noise the radiance may share,
    /// which the film then takes out. 0 for integrators that know of none.
    fn controlled<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        rays: &mut u64,
    ) -> (Spectrum, f32) {
        (self.radiance(scene, ray, sampler, rays), 0.0)
    }

    /// The same with what is asked besides, and whether what is met is to be looked at. Adds to
    /// `groups` what started from the lights of each. Integrators that know no parts of light tell
    /// none.
    fn watched<S: Sampler>(
        &self,
        scene: &Prepared,
        ray: Ray,
        sampler: &S,
        (view, look): (&View, bool),
        _groups: &mut [Spectrum],
        rays: &mut u64,
    ) -> Watched {
        let first = view.along(scene, ray, look, rays);
        let (radiance, control) = self.controlled(scene, ray, sampler, rays);
        Watched { radiance, control, parts: [Spectrum::BLACK; 2], first }
    }

    /// How light paths share the work, if they do.
    fn caustics(&self) -> Option<&Caustics<'_>> {
        None
    }
}
