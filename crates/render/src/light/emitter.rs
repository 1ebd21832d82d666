//! Everything that light is sampled from, as one type.

use super::bounds::EmitterBounds;
use super::disk::DiskEmitter;
use super::distant::DistantEmitter;
use super::environment::EnvironmentEmitter;
use super::point::PointEmitter;
use super::sample::{EmitterSample, Glow, LampPoint};
use super::sphere::SphereEmitter;
use super::spot::SpotEmitter;
use super::triangle::{FlatEmitter, ParallelogramEmitter, TriangleEmitter};
use crate::color::Spectrum;
use rutilant_geom::{Vec2, Vec3};

/// Something to sample light from.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// A point.
    Point(PointEmitter),
    /// A point that shines into a cone.
    Spot(SpotEmitter),
    /// A direction.
    Distant(DistantEmitter),
    /// A glowing triangle.
    Triangle(TriangleEmitter),
    /// A glowing parallelogram.
    Parallelogram(ParallelogramEmitter),
    /// A glowing disk or ellipse.
    Disk(DiskEmitter),
    /// A glowing sphere.
    Sphere(SphereEmitter),
    /// The sky.
    Environment(EnvironmentEmitter),
    /// A glowing custom shape: it is met, but never chosen, for nothing is known of its area.
    Custom(Glow),
}

impl Emitter {
    /// Draws a way to this light from `from`, for `u` in [0, 1)². `None` where no light arrives.
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        match self {
            Self::Point(e) => e.sample(from),
            Self::Spot(e) => e.sample(from),
            Self::Distant(e) => Some(e.sample()),
            Self::Triangle(e) => e.flat().sample(from, u),
            Self::Parallelogram(e) => e.flat().sample(from, u),
            Self::Disk(e) => e.sample(from, u),
            Self::Sphere(e) => e.sample(from, u),
            Self::Environment(e) => e.sample(u),
            Self::Custom(_) => None,
        }
    }

    /// The density, in 1/sr, with which [`sample`](Self::sample) draws the direction `wi` from
    /// `from`, which is known to meet the light at `position` with geometric `normal` there.
    /// Both are unused by lights at infinity. Zero for lights that no ray can meet.
    pub fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) | Self::Custom(_) => 0.0,
            Self::Triangle(e) => e.flat().pdf(from, wi, position, normal),
            Self::Parallelogram(e) => e.flat().pdf(from, wi, position, normal),
            Self::Disk(e) => e.pdf(from, wi, position, normal),
            Self::Sphere(e) => e.pdf(from, wi, position, normal),
            Self::Environment(e) => e.pdf(wi),
        }
    }

    /// Draws a point of a lamp of known area, for `u` in [0, 1)²; `None` for all other lights.
    pub(crate) fn point(&self, u: Vec2) -> Option<LampPoint> {
        match self {
            Self::Triangle(e) => Some(e.flat().point(u)),
            Self::Parallelogram(e) => Some(e.flat().point(u)),
            Self::Disk(e) => Some(e.point(u)),
            Self::Sphere(e) => Some(e.point(u)),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Distant(_)
            | Self::Environment(_)
            | Self::Custom(_) => None,
        }
    }

    /// The area of a lamp in m²; 0 where it has none, or none that is known.
    pub(crate) fn area(&self) -> f32 {
        match self {
            Self::Triangle(e) => e.flat().area(),
            Self::Parallelogram(e) => e.flat().area(),
            Self::Disk(e) => e.area(),
            Self::Sphere(e) => e.area(),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Distant(_)
            | Self::Environment(_)
            | Self::Custom(_) => 0.0,
        }
    }

    /// The light of a surface that rays can meet; `None` for lights without a surface.
    pub fn glow(&self) -> Option<&Glow> {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) | Self::Environment(_) => None,
            Self::Triangle(e) => Some(e.glow()),
            Self::Parallelogram(e) => Some(e.glow()),
            Self::Disk(e) => Some(e.glow()),
            Self::Sphere(e) => Some(&e.glow),
            Self::Custom(glow) => Some(glow),
        }
    }

    /// A triangle or a parallelogram.
    #[inline]
    pub(crate) fn flat(&self) -> Option<&FlatEmitter> {
        match self {
            Self::Triangle(e) => Some(e.flat()),
            Self::Parallelogram(e) => Some(e.flat()),
            Self::Point(_)
            | Self::Spot(_)
            | Self::Distant(_)
            | Self::Disk(_)
            | Self::Sphere(_)
            | Self::Environment(_)
            | Self::Custom(_) => None,
        }
    }

    /// Emitted power in W per channel. `scene_radius` bounds what lights at infinity shine on.
    pub fn power(&self, scene_radius: f32) -> Spectrum {
        match self {
            Self::Point(e) => e.power(),
            Self::Spot(e) => e.power(),
            Self::Distant(e) => e.power(scene_radius),
            Self::Triangle(e) => e.flat().power(),
            Self::Parallelogram(e) => e.flat().power(),
            Self::Disk(e) => e.power(),
            Self::Sphere(e) => e.power(),
            Self::Environment(e) => e.power(scene_radius),
            Self::Custom(_) => Spectrum::BLACK,
        }
    }

    /// Where it is and which way it shines; `None` for lights at infinity and custom shapes, and
    /// where it gives no light.
    pub(super) fn bounds(&self) -> Option<EmitterBounds> {
        let bounds = match self {
            Self::Point(e) => e.bounds(),
            Self::Spot(e) => e.bounds(),
            Self::Triangle(e) => e.flat().bounds(),
            Self::Parallelogram(e) => e.flat().bounds(),
            Self::Disk(e) => e.bounds(),
            Self::Sphere(e) => e.bounds(),
            Self::Distant(_) | Self::Environment(_) | Self::Custom(_) => return None,
        };
        bounds.is_sound().then_some(bounds)
    }

    /// True for lights that shine on everything from infinitely far away.
    pub fn is_infinite(&self) -> bool {
        match self {
            Self::Distant(_) | Self::Environment(_) => true,
            Self::Point(_)
            | Self::Spot(_)
            | Self::Triangle(_)
            | Self::Parallelogram(_)
            | Self::Disk(_)
            | Self::Sphere(_)
            | Self::Custom(_) => false,
        }
    }

    /// True for light that comes from everywhere alike.
    pub(crate) fn is_even_sky(&self) -> bool {
        matches!(self, Self::Environment(sky) if sky.is_even())
    }

    /// True for lights that a ray can run into.
    pub(crate) fn can_be_met(&self) -> bool {
        match self {
            Self::Point(_) | Self::Spot(_) | Self::Distant(_) => false,
            Self::Environment(_)
            | Self::Triangle(_)
            | Self::Parallelogram(_)
            | Self::Disk(_)
            | Self::Sphere(_)
            | Self::Custom(_) => true,
        }
    }

    /// True for lights that are met by rays but never chosen.
    pub(crate) fn is_custom(&self) -> bool {
        matches!(self, Self::Custom(_))
    }
}
