//! Pixel reconstruction filters, drawn from rather than multiplied with.
//!
//! A sample is placed around its pixel's centre in proportion to the filter's
//! value and counts for that pixel alone. Where the filter is negative the
//! sample counts negatively. No pixel ever touches another's sum.
//!
//! Source: Ernst, Stamminger, Greiner, "Filter Importance Sampling", IRT 2006;
//! Mitchell and Netravali, "Reconstruction Filters in Computer Graphics",
//! SIGGRAPH 1988; Harris, "On the Use of Windows for Harmonic Analysis",
//! Proc. IEEE 66(1), 1978.

use crate::math::distribution::choose;
use crate::problem::{Place, SceneProblem};
use fearless_simd::{Simd, f32x8};
use rutilant_geom::lanes::LANES;
use rutilant_geom::{Vec2, real};

/// How samples weigh around a pixel's centre. All are separable; radii are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// All samples within `radius` alike.
    Box {
        /// 0.5 covers exactly one pixel.
        radius: f32,
    },
    /// Falls linearly to zero at `radius`.
    Tent {
        /// 1 interpolates linearly between pixels.
        radius: f32,
    },
    /// A Gaussian of standard deviation `sigma`, lowered to reach zero at `radius`.
    Gaussian {
        /// Where it ends.
        radius: f32,
        /// Its width.
        sigma: f32,
    },
    /// Mitchell and Netravali's cubic: sharp, with small negative lobes.
    Mitchell {
        /// Where it ends; 2 is usual.
        radius: f32,
        /// The blurring parameter B; 1/3 is usual.
        b: f32,
        /// The ringing parameter C; 1/3 is usual.
        c: f32,
    },
    /// The four-term Blackman–Harris window: smooth, without ringing.
    BlackmanHarris {
        /// Where it ends; 1.5 is usual.
        radius: f32,
    },
}

impl Default for Filter {
    fn default() -> Self {
        Self::BlackmanHarris { radius: 1.5 }
    }
}

impl Filter {
    /// Half the width of the square that samples come from, in pixels.
    pub fn radius(&self) -> f32 {
        match *self {
            Self::Box { radius }
            | Self::Tent { radius }
            | Self::Gaussian { radius, .. }
            | Self::Mitchell { radius, .. }
            | Self::BlackmanHarris { radius } => radius,
        }
    }

    /// Its value along one axis, `x` pixels from the centre, not normalised. Zero from the radius on.
    pub fn eval(&self, x: f32) -> f32 {
        let radius = self.radius();
        if x.abs() >= radius {
            return 0.0;
        }
        match *self {
            Self::Box { .. } => 1.0,
            Self::Tent { .. } => 1.0 - x.abs() / radius,
            Self::Gaussian { sigma, .. } => {
                let bell = |x: f32| real::exp(-0.5 * (x / sigma) * (x / sigma));
                // Where it is nearly flat the difference would cancel: e^d - 1 by its series.
                let d = 0.5 * (radius - x) * (radius + x) / (sigma * sigma);
                if d < 1e-2 {
                    bell(radius) * d * (1.0 + d * (0.5 + d / 6.0))
                } else {
                    bell(x) - bell(radius)
                }
            }
            Self::Mitchell { b, c, .. } => mitchell(2.0 * x.abs() / radius, b, c),
            Self::BlackmanHarris { .. } => {
                let turn = std::f32::consts::PI * (1.0 + x / radius);
                0.35875 - 0.48829 * real::cos(turn) + 0.14128 * real::cos(2.0 * turn)
                    - 0.01168 * real::cos(3.0 * turn)
            }
        }
    }

    pub(crate) fn validate(&self) -> Result<(), SceneProblem> {
        let place = Place::Settings;
        place.check("filter_radius", [self.radius()], 0.01..=16.0)?;
        match *self {
            Self::Gaussian { sigma, .. } => place.check("filter_sigma", [sigma], 0.01..=16.0),
            Self::Mitchell { b, c, .. } => place.check("filter_bc", [b, c], 0.0..=1.0),
            Self::Box { .. } | Self::Tent { .. } | Self::BlackmanHarris { .. } => Ok(()),
        }
    }
}

/// The cubic over 0..2 (equation 8 of the paper, without its factor).
fn mitchell(x: f32, b: f32, c: f32) -> f32 {
    let (x2, x3) = (x * x, x * x * x);
    if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x3
            + (6.0 * b + 30.0 * c) * x2
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c)
    }
}

/// Draws offsets from a pixel's centre in proportion to a filter's absolute value.
#[derive(Clone, Debug)]
pub(crate) struct FilterSampler {
    radius: f32,
    /// Cumulative share of the absolute value at the borders of equal intervals; first 0, last 1.
    cumulative: Vec<f32>,
    /// How many borders lie at or before the start of each of equal parts of [0, 1): from there on it
    /// is not far to any number in that part.
    before: Vec<u16>,
    /// +1 or −1 for each interval.
    signs: Vec<f32>,
    /// What a positive sample counts: ∫|f| / ∫f along one axis.
    gain: f32,
}

impl FilterSampler {
    /// Intervals along an axis. The drawn density is a step function with this many steps; its
    /// spread differs from the filter's by less than 1e-5 pixels² at a radius of 2.
    const INTERVALS: usize = 512;

    pub(crate) fn new(filter: &Filter) -> Self {
        let radius = filter.radius();
        let count = match filter {
            Filter::Box { .. } => 1,
            Filter::Tent { .. }
            | Filter::Gaussian { .. }
            | Filter::Mitchell { .. }
            | Filter::BlackmanHarris { .. } => Self::INTERVALS,
        };
        let step = 2.0 * f64::from(radius) / count as f64;
        let value = |i: usize| {
            f64::from(filter.eval((-f64::from(radius) + (i as f64 + 0.5) * step) as f32))
        };
        let (total, total_abs) =
            (0..count).fold((0.0, 0.0), |(s, a), i| (s + value(i), a + value(i).abs()));
        let mut sum = 0.0;
        let mut cumulative = vec![0.0];
        cumulative.extend((0..count).map(|i| {
            sum += value(i).abs();
            (sum / total_abs) as f32
        }));
        let signs = (0..count).map(|i| value(i).signum() as f32).collect();
        let parts = (0..count).map(|part| part as f32 / count as f32);
        let before = parts.map(|from| cumulative.partition_point(|&c| c <= from) as u16).collect();
        Self { radius, cumulative, before, signs, gain: (total_abs / total) as f32 }
    }

    /// [`sample`](Self::sample) for eight samples.
    #[inline(always)]
    pub(crate) fn sample_all<S: Simd>(&self, u: [f32x8<S>; 2]) -> ([f32x8<S>; 2], [f32; LANES]) {
        if let ([sign], &[from, to]) = (&*self.signs, &*self.cumulative) {
            let weight = sign * self.gain;
            let [x, y] = u;
            let across =
                [(x - from) / (to - from) * 2.0 - 1.0, (y - from) / (to - from) * 2.0 - 1.0];
            return ([across[0] * self.radius, across[1] * self.radius], [weight * weight; LANES]);
        }
        let (mut offset, mut weight) = (u, [0.0; LANES]);
        for lane in 0..LANES {
            let (o, w) = self.sample(Vec2::new(u[0][lane], u[1][lane]));
            (offset[0][lane], offset[1][lane], weight[lane]) = (o.x, o.y, w);
        }
        (offset, weight)
    }

    /// An offset in pixels, and what a sample there counts (1 on average).
    pub(crate) fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let ((x, wx), (y, wy)) = (self.sample_axis(u.x), self.sample_axis(u.y));
        (Vec2::new(x, y), wx * wy)
    }

    /// About what part of the film the filters of all pixels cover: 1 but for filters that are
    /// narrower than a pixel.
    pub(crate) fn coverage(&self) -> f32 {
        let count = self.signs.len() as f32;
        let shares = self.cumulative.windows(2).map(|ends| ends[1] - ends[0]);
        // As wide as a box that is as uneven: one over the integral of the squared density.
        let width = 2.0 * self.radius / (count * shares.map(|share| share * share).sum::<f32>());
        width.min(1.0) * width.min(1.0)
    }

    /// Chooses, by `u` in [0, 1)², one of the pixels whose filters see a point of the film: its
    /// column and row, which may lie outside the picture, and what a sample of that point counts
    /// for it, so that all pixels together get what their filters say. `None` between filters
    /// that do not cover the film. Of a `map` of all directions, of so many pixels, filters look
    /// over the edges: into the column on the other side, and over the poles.
    pub(crate) fn pixel_of(
        &self,
        film: Vec2,
        map: Option<[u32; 2]>,
        u: Vec2,
    ) -> Option<([i64; 2], f32)> {
        let (mut y, wy) = self.pixel_along(film.y, u.y)?;
        let Some([width, height]) = map.map(|size| size.map(i64::from)) else {
            let (x, wx) = self.pixel_along(film.x, u.x)?;
            return Some(([x, y], wx * wy));
        };
        // Beyond a pole lies the meridian on the other side, on the way back.
        y = y.rem_euclid(2 * height);
        let beyond = y >= height;
        let across = if beyond { 0.5 * width as f32 } else { 0.0 };
        let (x, wx) = self.pixel_along(film.x + across, u.x)?;
        let row = if beyond { 2 * height - 1 - y } else { y };
        Some(([x.rem_euclid(width), row], wx * wy))
    }

    fn pixel_along(&self, at: f32, u: f32) -> Option<(i64, f32)> {
        let (first, last) = ((at - self.radius - 0.5).ceil(), (at + self.radius - 0.5).floor());
        let values = || {
            let count = (last - first).clamp(-1.0, 32.0) as i32 + 1;
            (0..count).map(|i| (first + i as f32, self.value(at - (first + i as f32 + 0.5))))
        };
        let total: f32 = values().map(|(_, value)| value.abs()).sum();
        let choices = values().map(|(pixel, value)| ((pixel, value), value.abs()));
        let (pixel, value) = choose(choices, u * total)?;
        Some((pixel as i64, total.copysign(value)))
    }

    /// The filter along one axis as it is drawn from, `x` pixels from the centre, with an integral
    /// of 1.
    fn value(&self, x: f32) -> f32 {
        let count = self.signs.len();
        let place = (x / self.radius + 1.0) * (0.5 * count as f32);
        if !(place >= 0.0 && place < count as f32) {
            return 0.0;
        }
        let i = place as usize;
        let density = (self.cumulative[i + 1] - self.cumulative[i]) * count as f32;
        self.signs[i] * self.gain * density / (2.0 * self.radius)
    }

    fn sample_axis(&self, u: f32) -> (f32, f32) {
        let count = self.signs.len();
        let before = usize::from(self.before[(u * count as f32) as usize]);
        let more = self.cumulative[before..].iter().take_while(|&&c| c <= u).count();
        let i = ((before + more).max(1) - 1).min(count - 1);
        let (from, to) = (self.cumulative[i], self.cumulative[i + 1]);
        let within = if to > from { (u - from) / (to - from) } else { 0.5 };
        let x = (2.0 * (i as f32 + within) / count as f32 - 1.0) * self.radius;
        (x, self.signs[i] * self.gain)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lat_long;

    const ALL: [Filter; 7] = [
        Filter::Box { radius: 0.5 },
        Filter::Tent { radius: 1.0 },
        Filter::Gaussian { radius: 1.5, sigma: 0.5 },
        Filter::Gaussian { radius: 0.01, sigma: 16.0 },
        Filter::Gaussian { radius: 16.0, sigma: 0.01 },
        Filter::Mitchell { radius: 2.0, b: 1.0 / 3.0, c: 1.0 / 3.0 },
        Filter::BlackmanHarris { radius: 1.5 },
    ];

    /// An edge through the pixel is as bright as the filter's integral up to the edge, also for
    /// filters with negative lobes; and the weights average 1.
    #[test]
    fn the_drawn_edge_is_the_filters_integral() {
        for filter in ALL {
            let sampler = FilterSampler::new(&filter);
            let (n, radius) = (1 << 16, filter.radius());
            let integral = |to: f32| {
                let steps = 20_000;
                (0..steps)
                    .map(|i| -radius + (to + radius) * (i as f32 + 0.5) / steps as f32)
                    .map(|x| f64::from(filter.eval(x)) * f64::from(to + radius) / f64::from(steps))
                    .sum::<f64>()
            };
            for edge in [-1.2_f32, -0.4, 0.0, 0.1, 0.7, 2.0].map(|e| e.clamp(-radius, radius)) {
                let drawn: f64 = (0..n)
                    .map(|i| sampler.sample_axis((i as f32 + 0.5) / n as f32))
                    .map(|(x, w)| if x < edge { f64::from(w) } else { 0.0 })
                    .sum::<f64>()
                    / f64::from(n);
                let expected = integral(edge) / integral(radius);
                assert!(
                    (drawn - expected).abs() < 2e-3,
                    "{filter:?} at {edge}: {drawn} {expected}"
                );
            }
        }
    }

    /// The ends of [0, 1) stay within the radius.
    #[test]
    fn offsets_stay_within_the_radius() {
        for filter in ALL {
            let sampler = FilterSampler::new(&filter);
            for u in [0.0, 0.25, 0.5, 1.0 - 0.5 * f32::EPSILON] {
                let (x, w) = sampler.sample_axis(u);
                assert!(x.abs() <= filter.radius() && w.is_finite(), "{filter:?} {u}: {x} {w}");
            }
        }
    }

    /// A point of the film counts for each pixel what that pixel's filter says of it, as often as it
    /// is chosen times what it counts then. Between filters that leave gaps it counts for none.
    #[test]
    fn points_count_what_filters_say() {
        for filter in ALL.into_iter().filter(|f| f.eval(0.6 * f.radius()) != 0.0) {
            let (sampler, radius) = (FilterSampler::new(&filter), filter.radius());
            let steps = 4000;
            let step = 2.0 * f64::from(radius) / f64::from(steps);
            let value =
                |i: i32| f64::from(filter.eval(((f64::from(i) + 0.5) * step) as f32 - radius));
            let integral = (0..steps).map(value).sum::<f64>() * step;
            for at in [3.0, 3.2, 3.5, 3.91, -0.3_f32] {
                let mut counts = std::collections::BTreeMap::new();
                let n = 1 << 16;
                for u in (0..n).map(|i| (i as f32 + 0.5) / n as f32) {
                    if let Some((pixel, weight)) = sampler.pixel_along(at, u) {
                        *counts.entry(pixel).or_insert(0.0) += f64::from(weight) / f64::from(n);
                    }
                }
                for pixel in -20..24_i64 {
                    let x = at - (pixel as f32 + 0.5);
                    // Where a box ends, either side will do.
                    if matches!(filter, Filter::Box { .. }) && x.abs() == radius {
                        continue;
                    }
                    let expected = f64::from(filter.eval(x)) / integral;
                    let counted = counts.get(&pixel).copied().unwrap_or(0.0);
                    let most = f64::from(filter.eval(0.0)) / integral;
                    let error = (counted - expected).abs() / most;
                    assert!(error < 0.01, "{filter:?} at {at}, {pixel}: {counted} for {expected}");
                }
            }
        }
    }

    /// On a map of all directions filters see over the edges: a point counts for a pixel what its
    /// filter says of all places at which the map, were it to go on, shows the same direction.
    #[test]
    fn edges_of_maps_join() {
        let filter = Filter::Mitchell { radius: 2.5, b: 0.3, c: 0.3 };
        let sampler = FilterSampler::new(&filter);
        for size @ [width, height] in [[6_u32, 3_u32], [7, 4], [2, 1]] {
            let [w, h] = size.map(|side| side as f32);
            for at in
                [Vec2::new(0.2, 0.3), Vec2::new(w - 0.1, 0.6 * h), Vec2::new(0.6 * w, h - 0.9)]
            {
                let direction = |film: Vec2| lat_long::direction_from_uv(film / Vec2::new(w, h));
                let turns =
                    || (-4..=4).flat_map(|i| (-4..=4).map(move |j| Vec2::new(i as f32, j as f32)));
                let places: Vec<Vec2> = turns()
                    .flat_map(|turn| {
                        let over = Vec2::new(at.x + 0.5 * w, -at.y);
                        [at, over].map(|place| place + turn * Vec2::new(w, 2.0 * h))
                    })
                    .collect();
                assert!(places.iter().all(|p| direction(*p).distance(direction(at)) < 1e-4));
                let mut counts = std::collections::BTreeMap::new();
                let n = 1 << 9;
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                    let u = Vec2::new(i as f32 + 0.5, j as f32 + 0.5) / n as f32;
                    if let Some((pixel, weight)) = sampler.pixel_of(at, Some(size), u) {
                        *counts.entry(pixel).or_insert(0.0) += f64::from(weight) / f64::from(n * n);
                    }
                }
                for pixel @ [x, y] in (0..width).flat_map(|x| (0..height).map(move |y| [x, y])) {
                    let middle = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                    let value =
                        |p: &Vec2| sampler.value(p.x - middle.x) * sampler.value(p.y - middle.y);
                    let expected: f32 = places.iter().map(value).sum();
                    let counted = counts.remove(&pixel.map(i64::from)).unwrap_or(0.0);
                    let error = counted - f64::from(expected);
                    assert!(
                        error.abs() < 0.01,
                        "{size:?} {at} {pixel:?}: {counted} for {expected}"
                    );
                }
                assert!(counts.is_empty(), "{counts:?}");
            }
        }
    }
}
