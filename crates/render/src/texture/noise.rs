//! Clouds, marble, dirt: a random pattern with the same share of every scale.
//!
//! Source: Perlin, *Improving Noise*, SIGGRAPH 2002, in two dimensions, with whole numbers mixed
//! in the place of a table; summed over octaves as fractional Brownian motion (Musgrave, in Ebert
//! et al., *Texturing and Modeling*, 3rd ed., chapter 16). Octaves whose waves are shorter than what
//! a pixel sees fade out (Norton, Rockwood, Skolmoski, *Clamping*, SIGGRAPH 1982).

use super::mapping::UvMapping;
use crate::color::Rgb;
use crate::problem::{LIGHT, Place, SceneProblem, UNIT};
use crate::sampler::{GOLDEN, mix};
use rutilant_geom::Vec2;

/// A random pattern between two colours, smooth, without a direction and without an end. The largest
/// of its waves are about two units of the mapped texture coordinates long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// The colour of the valleys.
    pub first: Rgb,
    /// The colour of the hills.
    pub second: Rgb,
    /// How many scales are added, 1 to 16, each with waves half as long as the one before.
    pub octaves: u32,
    /// How strong each octave is against the one before, 0 to 1.
    pub gain: f32,
    /// From the surface's texture coordinates to those of the pattern.
    pub mapping: UvMapping,
}

impl Noise {
    pub(super) fn validate(&self, place: Place) -> Result<(), SceneProblem> {
        place.check("first", self.first.0, LIGHT)?;
        place.check("second", self.second.0, LIGHT)?;
        place.check("octaves", [self.octaves as f32], 1.0..=16.0)?;
        place.check("gain", [self.gain], UNIT)?;
        self.mapping.validate(place)
    }

    /// The part of the second colour at a place of the pattern, where a pixel sees so much of it.
    pub(crate) fn amount(&self, uv: Vec2, width: f32) -> f32 {
        let (mut sum, mut all, mut strength, mut scale) = (0.0, 0.0, 1.0, 1.0_f32);
        for octave in 0..self.octaves {
            // A wave is two units long: there are two pixels to it where a pixel sees one.
            let seen = (2.0 - 2.0 * width * scale).clamp(0.0, 1.0);
            let at = uv * scale;
            if seen > 0.0 && at.is_finite() {
                sum += strength * seen * gradient_noise(at, octave);
            }
            all += strength;
            (strength, scale) = (strength * self.gain, 2.0 * scale);
        }
        0.5 + 0.5 * sum / all
    }
}

/// Noise of one scale, −1 to 1: 0 at whole numbers, where it has one of eight gradients.
fn gradient_noise(at: Vec2, octave: u32) -> f32 {
    let cell = at.floor();
    let within = at - cell;
    let corner = |x: u32, y: u32| {
        let number = |c: f32, step: u32| (c as i32).cast_unsigned().wrapping_add(step);
        let place = u64::from(number(cell.x, x)) << 32 | u64::from(number(cell.y, y));
        let bits = mix(place ^ u64::from(octave).wrapping_mul(GOLDEN));
        let offset = within - Vec2::new(x as f32, y as f32);
        GRADIENTS[(bits >> 61) as usize].dot(offset)
    };
    // No jump of the second derivative at the edges of a cell.
    let weight = within * within * within * (within * (within * 6.0 - 15.0) + 10.0);
    let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
    let below = mix(corner(0, 0), corner(1, 0), weight.x);
    let above = mix(corner(0, 1), corner(1, 1), weight.x);
    // In the middle of a cell, all of whose gradients point there, it is √½.
    (mix(below, above, weight.y) * std::f32::consts::SQRT_2).clamp(-1.0, 1.0)
}

/// Eight directions of length 1.
const GRADIENTS: [Vec2; 8] = {
    const H: f32 = std::f32::consts::FRAC_1_SQRT_2;
    [
        Vec2::X,
        Vec2::new(H, H),
        Vec2::Y,
        Vec2::new(-H, H),
        Vec2::NEG_X,
        Vec2::new(-H, -H),
        Vec2::NEG_Y,
        Vec2::new(H, -H),
    ]
};

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(octaves: u32) -> Noise {
        let mapping = UvMapping::default();
        Noise { first: Rgb::BLACK, second: Rgb::WHITE, octaves, gain: 0.5, mapping }
    }

    /// At whole numbers a single octave is grey, and beside them it follows one of eight
    /// gradients, each as often as the others.
    #[test]
    fn gradients_are_even() {
        const STEP: f32 = 1.0 / 1024.0;
        let mut counts = [0_u32; 8];
        for i in 0..80 {
            for j in -50..50 {
                let at = Vec2::new(i as f32, j as f32);
                let n = |offset: Vec2| noise(1).amount(at + offset, 0.0) - 0.5;
                assert_eq!(n(Vec2::ZERO), 0.0);
                // Half of 1 − −1, times √2.
                let slope = Vec2::new(n(Vec2::X * STEP), n(Vec2::Y * STEP))
                    / (0.5 * STEP)
                    / std::f32::consts::SQRT_2;
                let nearest = (0..8)
                    .max_by(|&a, &b| GRADIENTS[a].dot(slope).total_cmp(&GRADIENTS[b].dot(slope)));
                let nearest = nearest.expect("eight");
                assert!((GRADIENTS[nearest] - slope).length() < 0.02, "{slope}");
                counts[nearest] += 1;
            }
        }
        // Chi-square of 7 degrees of freedom: 35 or more comes once in 10⁵ trials.
        let expected = 8000.0 / 8.0;
        let off = |n: &u32| (f64::from(*n) - expected) * (f64::from(*n) - expected) / expected;
        let chi_square: f64 = counts.iter().map(off).sum();
        assert!(chi_square < 35.0, "{counts:?}");
    }

    /// It is grey in the mean, stays between its colours, has no jumps, and fades to grey where a
    /// pixel sees much of it.
    #[test]
    fn it_is_smooth_and_grey() {
        let noise = noise(8);
        let mut sum = 0.0;
        let mut variance = 0.0;
        const COUNT: u32 = 40_000;
        for i in 0..COUNT {
            // Points of a Kronecker sequence, over 200 units.
            let at = (i as f32 * Vec2::new(0.754_877_7, 0.569_840_3)).fract_gl() * 200.0 - 100.0;
            let here = noise.amount(at, 0.0);
            assert!((0.0..=1.0).contains(&here));
            sum += f64::from(here);
            variance += (f64::from(here) - 0.5) * (f64::from(here) - 0.5);
            // Each octave is as steep as the others: 8 of them, of half the sum of strengths.
            let beside = noise.amount(at + Vec2::splat(1e-4), 0.0);
            assert!((beside - here).abs() < 2e-3, "{at}");
            assert_eq!(noise.amount(at, 1.0), 0.5);
            let blurred = noise.amount(at, 0.25);
            assert!((blurred - here).abs() < 0.25, "{at}");
        }
        let count = f64::from(COUNT);
        let error = (variance / count / 10_000.0).sqrt();
        // One cell of 40,000 is about one independent value; four points lie in each.
        assert!((sum / count - 0.5).abs() < 5.0 * error, "{} {error}", sum / count);
        assert!(variance / count > 0.004, "{}", variance / count);
    }

    /// Far away there is still a number.
    #[test]
    fn far_places_are_numbers() {
        for far in [1e9, -1e12, 3e38, f32::MAX] {
            for at in [Vec2::new(far, 0.3), Vec2::splat(far)] {
                assert!((0.0..=1.0).contains(&noise(16).amount(at, 0.0)), "{at}");
            }
        }
    }
}
