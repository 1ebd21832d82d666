//! What light comes from: lights without a surface, the environment, and surfaces that glow.
//!
//! [`Light`] and [`Environment`] are what authors write; an [`Emitter`] is what is sampled. There
//! is one for each light, for each glowing shape or triangle, and for the environment.

mod disk;
mod distant;
mod emitter;
mod environment;
mod point;
mod selection;
mod sphere;
mod triangle;

pub use disk::DiskEmitter;
pub use distant::DistantEmitter;
pub use emitter::{EmitterSample, Glow};
pub use environment::{Environment, EnvironmentEmitter, EnvironmentLight};
pub use point::PointEmitter;
pub use selection::EmitterSelection;
pub use sphere::SphereEmitter;
pub use triangle::{ParallelogramEmitter, TriangleEmitter};

use crate::color::{Rgb, Spectrum};
use crate::scene::{FINITE, NOT_NEGATIVE, Place, SceneProblem};
use rutilant_geom::{Vec2, Vec3};

/// A light without a surface. It cannot be seen, only its light can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines from one point, equally in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Intensity in W/sr, per channel.
        intensity: Rgb,
    },
    /// Shines along one direction, from infinitely far away.
    Directional {
        /// Where its light goes; any length but 0.
        direction: Vec3,
        /// Irradiance in W/m² on a surface that faces it, per channel.
        irradiance: Rgb,
    },
}

impl Light {
    pub(crate) fn validate(&self, index: usize) -> Result<(), SceneProblem> {
        let place = Place::Light(index);
        match *self {
            Self::Point { position, intensity } => {
                place.check("position", position.to_array(), FINITE)?;
                place.check("intensity", intensity.0, NOT_NEGATIVE)
            }
            Self::Directional { direction, irradiance } => {
                place.check("direction", direction.to_array(), FINITE)?;
                if direction.try_normalize().is_none() {
                    return Err(place.problem("direction", "direction has no length"));
                }
                place.check("irradiance", irradiance.0, NOT_NEGATIVE)
            }
        }
    }

    pub(crate) fn prepare(&self) -> Emitter {
        match *self {
            Self::Point { position, intensity } => {
                Emitter::Point(PointEmitter { position, intensity: intensity.into() })
            }
            Self::Directional { direction, irradiance } => Emitter::Distant(DistantEmitter {
                towards: -direction.normalize_or(Vec3::NEG_Y),
                irradiance: irradiance.into(),
            }),
        }
    }
}

/// Something to sample light from.
#[derive(Clone, Debug)]
pub enum Emitter {
    /// A point.
    Point(PointEmitter),
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
}

impl Emitter {
    /// Draws a way to this light from `from`, for `u` in [0, 1)². `None` where no light arrives.
    pub fn sample(&self, from: Vec3, u: Vec2) -> Option<EmitterSample> {
        match self {
            Self::Point(e) => e.sample(from),
            Self::Distant(e) => Some(e.sample()),
            Self::Triangle(e) => e.sample(from, u),
            Self::Parallelogram(e) => e.sample(from, u),
            Self::Disk(e) => e.sample(from, u),
            Self::Sphere(e) => e.sample(from, u),
            Self::Environment(e) => e.sample(u),
        }
    }

    /// The density, in 1/sr, with which [`sample`](Self::sample) draws the direction `wi` from
    /// `from`, which is known to meet the light at `position` with geometric `normal` there.
    /// Both are unused by lights at infinity. Zero for lights that no ray can meet.
    pub fn pdf(&self, from: Vec3, wi: Vec3, position: Vec3, normal: Vec3) -> f32 {
        match self {
            Self::Point(_) | Self::Distant(_) => 0.0,
            Self::Triangle(e) => e.pdf(from, wi, position, normal),
            Self::Parallelogram(e) => e.pdf(from, wi, position, normal),
            Self::Disk(e) => e.pdf(from, wi, position, normal),
            Self::Sphere(e) => e.pdf(from, wi, position, normal),
            Self::Environment(e) => e.pdf(wi),
        }
    }

    /// The light of a surface that rays can meet; `None` for lights without a surface.
    pub fn glow(&self) -> Option<&Glow> {
        match self {
            Self::Point(_) | Self::Distant(_) | Self::Environment(_) => None,
            Self::Triangle(e) => Some(e.glow()),
            Self::Parallelogram(e) => Some(e.glow()),
            Self::Disk(e) => Some(e.glow()),
            Self::Sphere(e) => Some(&e.glow),
        }
    }

    /// Emitted power in W per channel. `scene_radius` bounds what lights at infinity shine on.
    pub fn power(&self, scene_radius: f32) -> Spectrum {
        match self {
            Self::Point(e) => e.power(),
            Self::Distant(e) => e.power(scene_radius),
            Self::Triangle(e) => e.power(),
            Self::Parallelogram(e) => e.power(),
            Self::Disk(e) => e.power(),
            Self::Sphere(e) => e.power(),
            Self::Environment(e) => e.power(scene_radius),
        }
    }

    /// True for lights that shine on everything from infinitely far away.
    pub fn is_infinite(&self) -> bool {
        match self {
            Self::Distant(_) | Self::Environment(_) => true,
            Self::Point(_)
            | Self::Triangle(_)
            | Self::Parallelogram(_)
            | Self::Disk(_)
            | Self::Sphere(_) => false,
        }
    }
}
