//! Where one stands and where one looks, and every way to move.
//!
//! A pose is what a scene file says of a camera: a position, a point that is
//! looked at, and which way is up. All moves keep it usable: finite, with a
//! direction, and not upside down. They are computed in double precision and
//! rounded once, so that a move and its opposite end where they began, to
//! within a rounding.

use rutilant_geom::{Aabb, DVec3, Vec3};

/// Where a camera stands and what it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Where it stands.
    pub position: Vec3,
    /// What it looks at; what it is turned around by [`orbit`](Self::orbit).
    pub look_at: Vec3,
    /// Which way is up; any length but 0.
    pub up: Vec3,
}

/// A direction along which one can look at a scene as on a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// From the front, along −z.
    Front,
    /// From the back, along +z.
    Back,
    /// From the left, along +x.
    Left,
    /// From the right, along −x.
    Right,
    /// From above, along −y, with −z up.
    Top,
    /// From below, along +y, with +z up.
    Bottom,
}

impl Axis {
    /// All of them, with what people call them.
    pub const ALL: [(Self, &str); 6] = [
        (Self::Front, "Front"),
        (Self::Back, "Back"),
        (Self::Left, "Left"),
        (Self::Right, "Right"),
        (Self::Top, "Top"),
        (Self::Bottom, "Bottom"),
    ];

    /// Towards the eye, and up.
    fn directions(self) -> [DVec3; 2] {
        match self {
            Self::Front => [DVec3::Z, DVec3::Y],
            Self::Back => [DVec3::NEG_Z, DVec3::Y],
            Self::Left => [DVec3::NEG_X, DVec3::Y],
            Self::Right => [DVec3::X, DVec3::Y],
            Self::Top => [DVec3::Y, DVec3::NEG_Z],
            Self::Bottom => [DVec3::NEG_Y, DVec3::Z],
        }
    }
}

/// So near to straight up or down one can look, in radians: beyond it, left and right would swap.
const STEEPEST: f64 = 89.5_f64.to_radians();

/// The farthest that anything may be, in metres. Beyond it, squares of distances are no single
/// precision numbers any more.
const FARTHEST: f64 = 1e15;

/// The least distance to what is looked at, as a part of the largest coordinate: less could not be
/// told from none.
const NEAREST: f64 = 1e-4;

/// Right, up and forward, of unit length.
struct Axes {
    right: DVec3,
    up: DVec3,
    forward: DVec3,
}

impl Pose {
    /// Moves along the view: to the right, up (as [`up`](Self::up) says) and forward, in metres.
    pub fn fly(&mut self, [right, up, forward]: [f64; 3]) {
        let axes = self.axes();
        let step = axes.right * right + self.upward() * up + axes.forward * forward;
        self.shift(step);
    }

    /// Moves across the view: to the right and up, as on the picture, in metres.
    pub fn pan(&mut self, right: f64, up: f64) {
        let axes = self.axes();
        self.shift(axes.right * right + axes.up * up);
    }

    /// Looks around: to the left and up, in radians.
    pub fn turn(&mut self, left: f64, up: f64) {
        let offset = self.turned(left, up);
        self.set(self.position.as_dvec3(), self.position.as_dvec3() + offset);
    }

    /// Goes around what is looked at: `left` and `up` turn the view as in [`turn`](Self::turn),
    /// and the eye moves so that the same point stays in the middle.
    pub fn orbit(&mut self, left: f64, up: f64) {
        let offset = self.turned(left, up);
        self.set(self.look_at.as_dvec3() - offset, self.look_at.as_dvec3());
    }

    /// Brings the eye to `factor` times its distance from what is looked at.
    pub fn dolly(&mut self, factor: f64) {
        if !(factor.is_finite() && factor > 0.0) {
            return;
        }
        let target = self.look_at.as_dvec3();
        let distance = (self.distance() * factor).clamp(self.nearest(), FARTHEST);
        self.set(target - self.axes().forward * distance, target);
    }

    /// Sees all of `bounds` from the side on which it is now, with a picture that shows
    /// `half_angle` radians from its middle to its nearest edge. Nothing happens, and it is false,
    /// where there is nothing to see.
    pub fn fit(&mut self, bounds: &Aabb, half_angle: f64) -> bool {
        let towards_eye = -self.axes().forward;
        self.place(bounds, half_angle, towards_eye)
    }

    /// As [`fit`](Self::fit), along an axis.
    pub fn look_along(&mut self, axis: Axis, bounds: &Aabb, half_angle: f64) -> bool {
        let [towards_eye, up] = axis.directions();
        self.up = up.as_vec3();
        self.place(bounds, half_angle, towards_eye)
    }

    /// How far away what is looked at is.
    pub fn distance(&self) -> f64 {
        self.position.as_dvec3().distance(self.look_at.as_dvec3())
    }

    fn place(&mut self, bounds: &Aabb, half_angle: f64, towards_eye: DVec3) -> bool {
        /// Air around it.
        const MARGIN: f64 = 1.05;
        if bounds.is_empty() || !(bounds.min.is_finite() && bounds.max.is_finite()) {
            return false;
        }
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let (center, radius) = (0.5 * (min + max), 0.5 * min.distance(max));
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let sine = half_angle.clamp(1e-3, 1.5).sin();
        self.set(center + towards_eye * (MARGIN * radius / sine), center);
        true
    }

    /// The way to what is looked at, after turning it to the left and up.
    fn turned(&self, left: f64, up: f64) -> DVec3 {
        let (axes, upward) = (self.axes(), self.upward());
        let elevation = axes.forward.dot(upward).clamp(-1.0, 1.0).asin();
        // Looking steeper than one may, one may stay there.
        let steepest = STEEPEST.max(elevation.abs());
        let elevation = (elevation + finite(up)).clamp(-steepest, steepest);
        let ahead = upward.cross(axes.right);
        let (sin, cos) = finite(left).sin_cos();
        let level = ahead * cos - axes.right * sin;
        (level * elevation.cos() + upward * elevation.sin()) * self.distance()
    }

    fn shift(&mut self, step: DVec3) {
        if step.is_finite() {
            self.set(self.position.as_dvec3() + step, self.look_at.as_dvec3() + step);
        }
    }

    /// Takes up another place, unless there one could not see: too far away for single precision,
    /// or where both points round to the same.
    fn set(&mut self, position: DVec3, look_at: DVec3) {
        let next = Self { position: position.as_vec3(), look_at: look_at.as_vec3(), ..*self };
        let far = position.abs().max(look_at.abs()).max_element();
        if far <= FARTHEST && next.distance() >= 0.5 * next.nearest() {
            *self = next;
        }
    }

    fn nearest(&self) -> f64 {
        let largest = self.look_at.abs().max_element();
        f64::from(largest).max(1e-6) * NEAREST
    }

    /// Up, of unit length.
    fn upward(&self) -> DVec3 {
        self.up.as_dvec3().try_normalize().unwrap_or(DVec3::Y)
    }

    fn axes(&self) -> Axes {
        let upward = self.upward();
        let way = self.look_at.as_dvec3() - self.position.as_dvec3();
        let forward = way.try_normalize().unwrap_or(DVec3::NEG_Z);
        let right = forward.cross(upward).try_normalize();
        let right = right.unwrap_or_else(|| upward.any_orthonormal_vector());
        Axes { right, up: right.cross(forward), forward }
    }
}

fn finite(angle: f64) -> f64 {
    if angle.is_finite() { angle } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rutilant_geom::Transform;

    const START: Pose =
        Pose { position: Vec3::new(0.0, 1.0, 4.0), look_at: Vec3::new(0.0, 1.0, 0.0), up: Vec3::Y };

    fn close(a: Vec3, b: [f32; 3]) {
        assert!(a.distance(b.into()) < 1e-5, "{a} is not {b:?}");
    }

    /// Right is right, up is up and forward is forward. The old program's "up" looked down, and its
    /// steps shrank when it looked up.
    #[test]
    fn every_way_goes_where_it_says() {
        let mut pose = START;
        pose.fly([1.0, 2.0, 3.0]);
        close(pose.position, [1.0, 3.0, 1.0]);
        close(pose.look_at, [1.0, 3.0, -3.0]);

        let mut pose = START;
        pose.turn(0.0, 0.3);
        assert!(pose.look_at.y > 1.0 && pose.position == START.position);
        assert!((pose.distance() - 4.0).abs() < 1e-6);
        // Steps are as long as before when one looks up.
        let before = pose;
        pose.fly([2.0, 0.0, 0.0]);
        close(pose.position - before.position, [2.0, 0.0, 0.0]);

        let mut pose = START;
        pose.turn(std::f64::consts::FRAC_PI_2, 0.0);
        close(pose.look_at, [-4.0, 1.0, 4.0]);

        let mut pose = START;
        pose.orbit(std::f64::consts::FRAC_PI_2, 0.0);
        close(pose.position, [4.0, 1.0, 0.0]);
        assert_eq!(pose.look_at, START.look_at);

        let mut pose = START;
        pose.dolly(0.5);
        close(pose.position, [0.0, 1.0, 2.0]);
        pose.pan(1.0, -1.0);
        close(pose.position, [1.0, 0.0, 2.0]);
        close(pose.look_at, [1.0, 0.0, 0.0]);
    }

    /// What fits is seen as a whole: all corners of the box lie within the angle.
    #[test]
    fn what_fits_is_seen_as_a_whole() {
        let bounds = Aabb { min: Vec3::new(-1.0, 2.0, -3.0), max: Vec3::new(5.0, 3.0, 4.0) };
        for half_angle in [0.1, 0.4, 1.0] {
            let mut poses = vec![START];
            poses[0].fit(&bounds, half_angle);
            for (axis, _) in Axis::ALL {
                let mut pose = START;
                pose.look_along(axis, &bounds, half_angle);
                poses.push(pose);
            }
            for pose in poses {
                close(pose.look_at, [2.0, 2.5, 0.5]);
                let forward = (pose.look_at - pose.position).normalize();
                for corner in 0..8_u32 {
                    let pick =
                        |bit: u32| if corner >> bit & 1 == 0 { bounds.min } else { bounds.max };
                    let corner = Vec3::new(pick(0).x, pick(1).y, pick(2).z);
                    let angle = (corner - pose.position).normalize().dot(forward).acos();
                    assert!(f64::from(angle) <= half_angle, "{pose:?} {angle} {half_angle}");
                }
            }
        }
        let mut pose = START;
        assert!(!pose.fit(&Aabb::EMPTY, 0.5));
        assert_eq!(pose, START);
    }

    /// From above one can still turn and orbit, and come back.
    #[test]
    fn one_can_leave_the_poles() {
        for axis in [Axis::Top, Axis::Bottom] {
            let mut pose = START;
            pose.look_along(axis, &Aabb { min: Vec3::NEG_ONE, max: Vec3::ONE }, 0.4);
            let before = pose;
            pose.orbit(0.3, 0.2);
            assert!(pose.position.distance(before.position) > 0.1, "{axis:?}");
        }
        // With y up, straight down: the next move brings the horizon back.
        let mut pose = Pose { position: Vec3::Y * 5.0, look_at: Vec3::ZERO, up: Vec3::Y };
        pose.orbit(0.0, 0.5);
        assert!(pose.position.y < 5.0 && pose.position.y > 3.0, "{pose:?}");
    }

    /// Whatever is done, in whatever order, by whatever amounts: a camera can stand there.
    #[test]
    fn no_move_leads_nowhere() {
        let mut state = 1_u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let unit = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            match state >> 59 {
                0 => f64::NAN,
                1 => f64::INFINITY,
                2 => 0.0,
                3..6 => unit * 1e30,
                6..9 => unit * 1e6,
                _ => unit * 4.0,
            }
        };
        let bounds = Aabb { min: Vec3::splat(-2.0), max: Vec3::splat(3.0) };
        let mut pose = START;
        for step in 0..100_000 {
            let (a, b, c) = (number(), number(), number());
            match step % 8 {
                0 => pose.fly([a, b, c]),
                1 => pose.pan(a, b),
                2 => pose.turn(a, b),
                3 => pose.orbit(a, b),
                4 => pose.dolly(a),
                5 if step % 64 == 5 => _ = pose.fit(&bounds, a),
                6 if step % 64 == 6 => _ = pose.look_along(Axis::ALL[step % 6].0, &bounds, b),
                _ => pose.fly([c, a, b]),
            }
            let camera = Transform::look_at(pose.position, pose.look_at, pose.up);
            assert!(camera.is_some_and(|c| c.inverse().is_some()), "{step}: {pose:?}");
        }
    }
}
