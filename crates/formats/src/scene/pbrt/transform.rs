//! The maps that statements multiply, in double precision.

use crate::scene::affine::Affine;
use rutilant_geom::{DVec3, real};

/// Moves.
pub(super) fn translate(by: DVec3) -> Affine {
    Affine { linear: Affine::IDENTITY.linear, translation: by }
}

/// A factor for each axis.
pub(super) fn scale(by: DVec3) -> Affine {
    let linear = [DVec3::X * by.x, DVec3::Y * by.y, DVec3::Z * by.z];
    Affine { linear, translation: DVec3::ZERO }
}

/// A turn around an axis, in degrees; quarter turns around coordinate axes are exact. `None` where
/// the axis has no length.
pub(super) fn rotate(degrees: f32, axis: DVec3) -> Option<Affine> {
    let axis = axis.try_normalize()?;
    let (s, c) = real::sin_cos_degrees(degrees);
    let (s, c) = (f64::from(s), f64::from(c));
    let column = |e: DVec3| e * c + axis.cross(e) * s + axis * (axis.dot(e) * (1.0 - c));
    let linear = [column(DVec3::X), column(DVec3::Y), column(DVec3::Z)];
    Some(Affine { linear, translation: DVec3::ZERO })
}

/// Camera from world for an eye that looks at a point along its +z, with +y up and +x to the right:
/// left-handed, as everything in pbrt is. `None` where there is no such direction.
pub(super) fn look_at(eye: DVec3, at: DVec3, up: DVec3) -> Option<Affine> {
    let forward = (at - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(forward).try_normalize()?;
    let up = forward.cross(right);
    inverse(&Affine { linear: [right, up, forward], translation: eye })
}

/// The map back; `None` where space is flattened.
pub(super) fn inverse(map: &Affine) -> Option<Affine> {
    let [x, y, z] = map.linear;
    let volume = x.dot(y.cross(z));
    let rows = [y.cross(z) / volume, z.cross(x) / volume, x.cross(y) / volume];
    let linear = [
        DVec3::new(rows[0].x, rows[1].x, rows[2].x),
        DVec3::new(rows[0].y, rows[1].y, rows[2].y),
        DVec3::new(rows[0].z, rows[1].z, rows[2].z),
    ];
    let back = Affine { linear, translation: DVec3::ZERO };
    let inverse = Affine { linear, translation: -back.vector(map.translation) };
    is_finite(&inverse).then_some(inverse)
}

/// Whether left becomes right.
pub(super) fn mirrors(map: &Affine) -> bool {
    let [x, y, z] = map.linear;
    x.dot(y.cross(z)) < 0.0
}

pub(super) fn is_finite(map: &Affine) -> bool {
    map.linear.iter().chain([&map.translation]).all(|v| v.is_finite())
}

/// The factor by which all lengths grow, where it is the same in all directions within 1 in 10⁴.
pub(super) fn uniform_scale(map: &Affine) -> Option<f64> {
    let [x, y, z] = map.linear;
    let s = x.length();
    let off = 1e-4 * s;
    let round = (y.length() - s).abs() <= off
        && (z.length() - s).abs() <= off
        && [x.dot(y), y.dot(z), z.dot(x)].iter().all(|d| d.abs() <= off * s);
    (s > 0.0 && s.is_finite() && round).then_some(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-6
    }

    /// What an eye looks at lies on its +z, what is above it on +y, and what is on the right, as
    /// left-handed coordinates have it, on +x.
    #[test]
    fn eyes_look_along_z() {
        let eye = DVec3::new(1.0, 2.0, 3.0);
        let camera = look_at(eye, eye + DVec3::X, DVec3::Y).expect("a view");
        assert!(near(camera.point(eye + DVec3::X * 5.0), DVec3::Z * 5.0));
        assert!(near(camera.vector(DVec3::Y), DVec3::Y));
        // Left-handed: up × forward is right.
        assert!(near(camera.vector(DVec3::Y.cross(DVec3::X)), DVec3::X));
        assert!(
            look_at(eye, eye, DVec3::Y).is_none()
                && look_at(eye, eye + DVec3::Y, DVec3::Y).is_none()
        );
    }

    /// There and back again is nothing; a turn follows the right hand; flat maps have no way back.
    #[test]
    fn maps_have_inverses() {
        let turn = rotate(30.0, DVec3::new(1.0, 2.0, -0.5)).expect("an axis");
        let map = translate(DVec3::new(1.0, -2.0, 3.0)) * turn * scale(DVec3::new(2.0, -3.0, 0.5));
        let back = inverse(&map).expect("an inverse");
        for point in [DVec3::ZERO, DVec3::X, DVec3::new(0.3, -7.0, 2.0)] {
            assert!(near(back.point(map.point(point)), point));
        }
        assert!(mirrors(&map) && !mirrors(&turn));
        assert!(inverse(&scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
        let quarter = rotate(90.0, DVec3::Z).expect("an axis");
        assert_eq!(quarter.vector(DVec3::X), DVec3::Y);
    }
}
