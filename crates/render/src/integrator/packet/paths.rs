//! Paths on their way: their state from one surface to the next.

use crate::color::Spectrum;
use crate::integrator::path::Previous;
use crate::light::ShadingPoint;
use crate::medium::Media;
use crate::prepare::Prepared;
use crate::sampler::Sampler;
use rutilant_geom::RayPacket;
use rutilant_geom::lanes::{LANES, at};

/// Where eight paths start: rays of unit direction, and the numbers that are drawn along them. A
/// ray that is not there starts none.
#[derive(Clone, Copy)]
pub(crate) struct Starts<N> {
    pub(crate) rays: RayPacket,
    pub(crate) samplers: [N; LANES],
    /// Those of which is asked what they meet, where a picture tells that: a bit for each.
    pub(crate) looks: u32,
}

/// Eight paths; those whose ray is not there have ended.
#[derive(Clone, Copy)]
pub(super) struct PathPacket<N> {
    pub(super) rays: RayPacket,
    /// (channel, path).
    pub(super) throughput: [[f32; LANES]; 3],
    /// The density of the direction taken, in 1/sr, or [`UNFINDABLE`](Self::UNFINDABLE).
    pub(super) pdf: [f32; LANES],
    /// For what a light was chosen where the path last was, as in [`ShadingPoint`]: (coordinate,
    /// path). Kept only where the choice depends on it.
    pub(super) lit_position: [[f32; LANES]; 3],
    pub(super) lit_normal: [[f32; LANES]; 3],
    /// Radiance is larger inside a dense medium by this factor; it will be lost on leaving.
    pub(super) density_gain: [f32; LANES],
    /// As in `Caustics::lead`, times what made light paths denser since; 0 where they do not look.
    pub(super) lead: [f32; LANES],
    /// The number of the path's start.
    pub(super) slot: [u32; LANES],
    pub(super) samplers: [N; LANES],
}

impl<N: Sampler> PathPacket<N> {
    /// The density of a direction in which light sampling could not have found what is met.
    pub(super) const UNFINDABLE: f32 = -1.0;

    #[inline(always)]
    fn new(starts: &Starts<N>, number: usize) -> Self {
        let mut slot = [0; LANES];
        for (lane, slot) in slot.iter_mut().enumerate() {
            *slot = (number * LANES + lane) as u32;
        }
        Self {
            rays: starts.rays,
            throughput: [[1.0; LANES]; 3],
            pdf: [Self::UNFINDABLE; LANES],
            lit_position: [[0.0; LANES]; 3],
            lit_normal: [[0.0; LANES]; 3],
            density_gain: [1.0; LANES],
            lead: [0.0; LANES],
            slot,
            samplers: starts.samplers,
        }
    }

    /// The surface that a path last left, if light sampling could have found there what is met next.
    #[inline(always)]
    pub(super) fn previous(&self, lane: usize) -> Option<Previous> {
        let pdf = self.pdf[lane];
        let position = at(&self.rays.origin, lane);
        let (lit, normal) = (at(&self.lit_position, lane), at(&self.lit_normal, lane));
        let point = ShadingPoint { position: lit, normal };
        (pdf != Self::UNFINDABLE).then_some(Previous { position, point, pdf })
    }

    /// Notes for what lights are chosen.
    #[inline(always)]
    pub(super) fn light(&mut self, lane: usize, point: &ShadingPoint) {
        for axis in 0..3 {
            self.lit_position[axis][lane] = point.position[axis];
            self.lit_normal[axis][lane] = point.normal[axis];
        }
    }

    /// What light paths, per unit of their density at a lamp, are denser here.
    #[inline(always)]
    pub(super) fn lead(&self, lane: usize) -> f32 {
        self.lead[lane] / self.density_gain[lane]
    }

    fn take(&mut self, lane: usize, other: &Self, from: usize) {
        for axis in 0..3 {
            self.rays.origin[axis][lane] = other.rays.origin[axis][from];
            self.rays.direction[axis][lane] = other.rays.direction[axis][from];
            self.throughput[axis][lane] = other.throughput[axis][from];
            self.lit_position[axis][lane] = other.lit_position[axis][from];
            self.lit_normal[axis][lane] = other.lit_normal[axis][from];
        }
        self.rays.t_min[lane] = other.rays.t_min[from];
        self.rays.t_max[lane] = other.rays.t_max[from];
        self.rays.leaves[lane] = other.rays.leaves[from];
        self.pdf[lane] = other.pdf[from];
        self.density_gain[lane] = other.density_gain[from];
        self.lead[lane] = other.lead[from];
        self.slot[lane] = other.slot[from];
        self.samplers[lane] = other.samplers[from];
    }
}

/// Many paths, all at the same depth.
pub(super) struct Paths<N> {
    pub(super) packets: Vec<PathPacket<N>>,
    /// What each path is inside of, by the number of its start; empty if there are no borders.
    pub(super) media: Vec<Media>,
}

impl<N: Sampler> Paths<N> {
    pub(super) fn new(starts: &[Starts<N>], scene: &Prepared) -> Self {
        let packets = starts.iter().enumerate().map(|(i, starts)| PathPacket::new(starts, i));
        let bordered = if scene.has_borders() { starts.len() * LANES } else { 0 };
        Self { packets: packets.collect(), media: vec![scene.camera_media(); bordered] }
    }

    /// Puts the last paths in the places of those that have ended, so that packets are full.
    pub(super) fn close_ranks(&mut self) {
        let (mut hole, mut end) = (0, self.packets.len() * LANES);
        loop {
            while hole < end && self.is_there(hole) {
                hole += 1;
            }
            while hole < end && !self.is_there(end - 1) {
                end -= 1;
            }
            if hole >= end {
                break;
            }
            end -= 1;
            let (front, back) = self.packets.split_at_mut(end / LANES);
            let last = &mut back[0];
            match front.get_mut(hole / LANES) {
                Some(packet) => packet.take(hole % LANES, last, end % LANES),
                None => {
                    let other = *last;
                    last.take(hole % LANES, &other, end % LANES);
                }
            }
            last.rays.keep(last.rays.there() & !(1 << (end % LANES)));
        }
        self.packets.truncate(end.div_ceil(LANES));
    }

    fn is_there(&self, path: usize) -> bool {
        self.packets[path / LANES].rays.is_there(path % LANES)
    }
}

/// Adds light to the path of a start.
#[inline(always)]
pub(super) fn add(radiance: &mut [Spectrum], slot: u32, light: Spectrum) {
    if let Some(sum) = radiance.get_mut(slot as usize) {
        *sum += light;
    }
}
