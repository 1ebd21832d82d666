//! A ray, and how the next one leaves a surface.

use crate::Vec3;
use crate::each;
use crate::lanes::{Xyz, Xyz8};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8, i32x8};

/// The points `origin + t * direction` with `t_min < t < t_max`.
///
/// `direction` need not be a unit vector; `t` counts in its lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where `t` is zero.
    pub origin: Vec3,
    /// Where the ray goes; not zero, finite.
    pub direction: Vec3,
    /// Hits at `t_min` and before do not count. At least zero.
    pub t_min: f32,
    /// Hits at `t_max` and beyond do not count. May be infinite.
    pub t_max: f32,
}

impl Ray {
    /// The whole half-line from `origin` on.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY }
    }

    /// The open segment between two points: `t` runs from 0 to 1.
    pub fn between(from: Vec3, to: Vec3) -> Self {
        Self { origin: from, direction: to - from, t_min: 0.0, t_max: 1.0 }
    }

    /// The point at `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// The origin of a ray that leaves the surface point `position` towards `direction`.
///
/// A hit position is the exact point, each coordinate rounded once, so it lies
/// at most `error = 2^-24 (|x nx| + |y ny| + |z nz|)` off the surface. The
/// origin moves off along the geometric `normal` by a few times that much, to
/// the side that `direction` points to, and every coordinate that moves is
/// rounded away from the surface. It therefore stands strictly on that side of
/// the surface, at any scale and any distance from the scene's origin.
///
/// Where the surface runs through the scene's origin there is nothing to move
/// by: the bound is zero, or less than what double precision rounds away. There
/// the surfaces help: none is met by a ray that starts on it to within that
/// rounding.
///
/// Two things no offset can do. A direction so near to the surface that the
/// rounded normal does not tell its sides apart (a cosine below 2^-23) may cross
/// it after all, far away. And inside a sphere smaller than the spacing of
/// single-precision numbers at its place there is no room for an origin.
///
/// Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
/// section 6.8.6, with the error bound of a position that is rounded once.
pub fn offset_origin(position: Vec3, normal: Vec3, direction: Vec3) -> Vec3 {
    offset(position, normal, direction, position.abs())
}

/// The end of a ray from `from` that stops just short of the surface point `position`, whose
/// geometric normal is `normal`: [`Ray::between`] the two does not meet the surface there.
///
/// Beside the rounding of `position` this makes up for that of the ray's direction, which is the
/// rounded difference of two points and grows with their distance.
pub fn offset_end(position: Vec3, normal: Vec3, from: Vec3) -> Vec3 {
    let way = position - from;
    offset(position, normal, -way, position.abs() + way.abs())
}

/// Half an ulp for the rounded position, as much again for the rounded
/// normal and as much for the addition below; doubled for good measure.
const ROUNDINGS: f32 = 6.0 * f32::EPSILON * 0.5;

/// Moves `position` off along `normal`, to the side of `direction`, by what numbers of the
/// magnitudes `rounded` may have lost.
fn offset(position: Vec3, normal: Vec3, direction: Vec3, rounded: Vec3) -> Vec3 {
    let distance = ROUNDINGS * rounded.dot(normal.abs());
    let offset = normal * if normal.dot(direction) < 0.0 { -distance } else { distance };
    let step = |p: f32, o: f32| {
        let moved = p + o;
        if o > 0.0 {
            moved.next_up()
        } else if o < 0.0 {
            moved.next_down()
        } else {
            moved
        }
    };
    Vec3::new(step(position.x, offset.x), step(position.y, offset.y), step(position.z, offset.z))
}

/// [`offset_origin`] in each lane.
#[inline(always)]
pub fn offset_origins<S: Simd>(position: Xyz8<S>, normal: Xyz8<S>, direction: Xyz8<S>) -> Xyz8<S> {
    offset_each(position, normal, direction, each!(position, p => p.abs()))
}

/// [`offset_end`] in each lane.
#[inline(always)]
pub fn offset_ends<S: Simd>(position: Xyz8<S>, normal: Xyz8<S>, from: Xyz8<S>) -> Xyz8<S> {
    let way = position - from;
    let rounded = each!(position, p => p.abs()) + each!(way, w => w.abs());
    offset_each(position, normal, way.negated(), rounded)
}

#[inline(always)]
fn offset_each<S: Simd>(
    position: Xyz8<S>,
    normal: Xyz8<S>,
    direction: Xyz8<S>,
    rounded: Xyz8<S>,
) -> Xyz8<S> {
    let simd = position.x.token();
    let distance = rounded.dot(each!(normal, n => n.abs())) * ROUNDINGS;
    let behind = normal.dot(direction).simd_lt(f32x8::splat(simd, 0.0));
    let offset = normal.scaled(behind.select(-distance, distance));
    Xyz {
        x: step(position.x, offset.x),
        y: step(position.y, offset.y),
        z: step(position.z, offset.z),
    }
}

/// `p + o`, and on to the next number in the direction of `o`.
#[inline(always)]
fn step<S: Simd>(p: f32x8<S>, o: f32x8<S>) -> f32x8<S> {
    let simd = p.token();
    let moved = p + o;
    let (zero, still) = (f32x8::splat(simd, 0.0), i32x8::splat(simd, 0));
    let (up, down) = (i32x8::splat(simd, 1), i32x8::splat(simd, -1));
    // Away from zero or towards it: the bits count magnitudes.
    let outwards = o.simd_gt(zero).select(up, o.simd_lt(zero).select(down, still));
    let outwards = moved.simd_lt(zero).select(still - outwards, outwards);
    let bits: i32x8<S> = moved.bitcast();
    let next: f32x8<S> = (bits + outwards).bitcast();
    let tiny = f32x8::splat(simd, f32::from_bits(1)).copysign(o);
    let from_zero = moved.simd_eq(zero) & o.simd_ne(zero);
    from_zero.select(tiny, next)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eight at once are the same bits as one by one, zeros and all.
    #[test]
    fn lanes_are_moved_as_one_is() {
        let level = fearless_simd::Level::new();
        let number = |i: u32| {
            let x = i.wrapping_mul(0x9e37_79b9);
            let x = (x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d) >> 8;
            let v = x as f32 / (1 << 23) as f32 - 1.0;
            if x.is_multiple_of(7) { 0.0 } else { v }
        };
        for i in 0..20_000 {
            let vector = |k: u32| -> [[f32; 8]; 3] {
                std::array::from_fn(|axis| {
                    std::array::from_fn(|lane| {
                        number(i * 72 + k * 24 + axis as u32 * 8 + lane as u32)
                    })
                })
            };
            let v = [vector(0), vector(1), vector(2)];
            let (origins, ends) = fearless_simd::dispatch!(level, simd => {
                let [p, n, d] = v.map(|v| Xyz8::load(simd, &v));
                (offset_origins(p, n, d).store(), offset_ends(p, n, d).store())
            });
            for lane in 0..8 {
                let at = |v: &[[f32; 8]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
                let [p, n, d] = [at(&v[0]), at(&v[1]), at(&v[2])];
                assert_eq!(offset_origin(p, n, d), at(&origins), "{p} {n} {d}");
                assert_eq!(offset_end(p, n, d), at(&ends), "{p} {n} {d}");
            }
        }
    }

    /// The origin must stand on the side it leaves to, however far from the
    /// scene's origin: a fixed offset of 2.4e-6 vanished beyond 32 units.
    #[test]
    fn origins_leave_the_surface_at_any_scale() {
        for exponent in -20_i32..=20 {
            let position =
                Vec3::new(0.7, 1.3, -2.1) * f32::from_bits(((127 + exponent) as u32) << 23);
            let normal = Vec3::new(0.36, 0.48, 0.8);
            for direction in [normal, -normal] {
                let origin = offset_origin(position, normal, direction);
                let height = (origin.as_dvec3() - position.as_dvec3()).dot(direction.as_dvec3());
                let rounding =
                    0.5 * f64::from(f32::EPSILON) * f64::from(position.abs().max_element());
                assert!(height > 2.0 * rounding, "scale 2^{exponent}: {height:e}");
            }
        }
    }
}
