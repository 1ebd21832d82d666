//! A thin lens: where rays start, and the plane on which they meet again.
//!
//! Everything on the plane at the focus distance is sharp; a point off it
//! becomes a picture of the aperture, which may be a disk or a polygon, and may
//! be squeezed as anamorphic lenses squeeze it. The aperture is evenly bright,
//! its edges are straight and sharp.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! section 5.2.3; Shirley and Chiu, "A Low Distortion Map Between Disk and
//! Square", JGT 2(3), 1997.

use crate::math::warp;
use crate::problem::{FINITE, NOT_NEGATIVE, POSITIVE, Place, SceneProblem, UNIT, number};
use rutilant_geom::{Ray, Transform, Vec2, Vec3, real};

/// The widest lens, in focus distances.
const MAX_APERTURE: f32 = 1e6;

/// The lens of a camera, and what it is focused on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Radius of the lens in metres; 0 is a pinhole, which sees everything sharp. The corners of
    /// a polygon lie on this circle.
    pub aperture_radius: f32,
    /// Distance from the eye to the plane that is sharp, in metres along the view direction.
    pub focus_distance: f32,
    /// The place in the picture whose subject shall be sharp, from (0, 0) in its upper left
    /// corner to (1, 1) in the lower right one. Replaces `focus_distance` where there is
    /// something that can be focused on: see [`Prepared::focus_on`](crate::Prepared::focus_on).
    pub focus_on: Option<Vec2>,
    /// Straight edges of the aperture, 3 to [`MAX_BLADES`](Self::MAX_BLADES); 0 is round.
    pub blades: u32,
    /// Turns the polygon, in radians, counter-clockwise in the blur of what lies behind the
    /// focus. At 0 a corner points up there; before the focus the blur is upside down.
    pub blade_rotation: f32,
    /// Height over width of the aperture: 1 is round, 2 half as wide as high, as anamorphic
    /// lenses make it, 0.5 twice as wide as high. The height stays as it is; blades are turned
    /// first, then squeezed.
    pub aperture_ratio: f32,
}

impl Lens {
    /// The most blades; with so many a polygon looks round.
    pub const MAX_BLADES: u32 = 100;

    /// A pinhole, focused (should it be opened) at this many metres.
    pub fn pinhole(focus_distance: f32) -> Self {
        Self {
            aperture_radius: 0.0,
            focus_distance,
            focus_on: None,
            blades: 0,
            blade_rotation: 0.0,
            aperture_ratio: 1.0,
        }
    }

    /// The middle of a pixel as a place in a picture of `size` pixels, for
    /// [`focus_on`](Self::focus_on); `None` outside the picture.
    pub fn place_of_pixel([x, y]: [u32; 2], [width, height]: [u32; 2]) -> Option<Vec2> {
        let part = |at: u32, side: u32| ((f64::from(at) + 0.5) / f64::from(side)) as f32;
        (x < width && y < height).then(|| Vec2::new(part(x, width), part(y, height)))
    }

    pub(super) fn validate(&self) -> Result<(), SceneProblem> {
        let place = Place::Camera;
        place.check("aperture_radius", [self.aperture_radius], NOT_NEGATIVE)?;
        place.check("focus_distance", [self.focus_distance], POSITIVE)?;
        place.check("focus_on", self.focus_on.into_iter().flat_map(|p| p.to_array()), UNIT)?;
        if self.blades != 0 && !(3..=Self::MAX_BLADES).contains(&self.blades) {
            let (blades, most) = (self.blades, Self::MAX_BLADES);
            return Err(place.problem(
                "blades",
                format!("blades is {blades}, but must be 0 for a round lens, or lie between 3 and {most}"),
            ));
        }
        place.check("blade_rotation_degrees", [self.blade_rotation], FINITE)?;
        place.check("aperture_ratio", [self.aperture_ratio], 0.01..=100.0)?;
        // Otherwise the lens would be infinitely far away in terms of the focus.
        let widest = self.aperture_radius / self.aperture_ratio.min(1.0);
        if widest / self.focus_distance > MAX_APERTURE {
            return Err(place.problem(
                "aperture_radius",
                format!(
                    "the lens has a radius of {}, but that must be at most {} times the focus distance of {}",
                    number(self.aperture_radius),
                    number(MAX_APERTURE),
                    number(self.focus_distance)
                ),
            ));
        }
        Ok(())
    }

    pub(super) fn prepare(&self) -> PreparedLens {
        PreparedLens {
            half_size: Vec2::new(self.aperture_radius / self.aperture_ratio, self.aperture_radius),
            corners: self.blades,
            turn: real::sin_cos(self.blade_rotation),
            focus_distance: self.focus_distance,
        }
    }
}

/// A [`Lens`] to send rays through.
#[derive(Clone, Copy, Debug)]
pub(super) struct PreparedLens {
    /// Half the width and the height.
    half_size: Vec2,
    corners: u32,
    /// Sine and cosine of the rotation.
    turn: (f32, f32),
    focus_distance: f32,
}

impl PreparedLens {
    /// The ray through the point of the lens that `u`, in [0, 1)², stands for. `chief` is the one
    /// through the middle, of a length that reaches the plane at distance 1.
    pub(super) fn ray(&self, chief: &Chief, pose: &Transform, u: Vec2) -> Ray {
        let Chief { mut origin, mut direction } = *chief;
        if self.is_open() {
            let [lens, bend] = self.bend(u);
            origin += lens;
            direction += bend;
        }
        Ray::new(pose.point(origin), pose.vector(direction).normalize())
    }

    /// The point of the lens that `u` stands for, and by what the direction of its ray differs from
    /// that through the middle, which comes to the plane at distance 1.
    pub(super) fn bend(&self, u: Vec2) -> [Vec3; 2] {
        let lens = (self.point(u) * self.half_size).extend(0.0);
        [lens, -lens / self.focus_distance]
    }

    /// False for a pinhole.
    pub(super) fn is_open(&self) -> bool {
        self.half_size.y > 0.0
    }

    /// A point of the aperture, before it is squeezed, as if its radius were 1.
    fn point(&self, u: Vec2) -> Vec2 {
        if self.corners == 0 {
            return warp::concentric_disk(u);
        }
        let (p, (s, c)) = (warp::concentric_polygon(u, self.corners), self.turn);
        Vec2::new(c * p.x - s * p.y, s * p.x + c * p.y)
    }
}

/// The ray through the middle of the lens, in the camera's own space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chief {
    pub(super) origin: Vec3,
    /// Its z is −1.
    pub(super) direction: Vec3,
}
