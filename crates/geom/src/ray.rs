//! A ray, and how the next one leaves a surface.

use crate::Vec3;

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

/// Moves `position` off along `normal`, to the side of `direction`, by what numbers of the
/// magnitudes `rounded` may have lost.
fn offset(position: Vec3, normal: Vec3, direction: Vec3, rounded: Vec3) -> Vec3 {
    /// Half an ulp for the rounded position, as much again for the rounded
    /// normal and as much for the addition below; doubled for good measure.
    const ROUNDINGS: f32 = 6.0 * f32::EPSILON * 0.5;
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

#[cfg(test)]
mod tests {
    use super::*;

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
