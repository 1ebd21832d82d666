//! What light comes from: lights without a surface, the environment, and surfaces that glow.
//!
//! [`Light`] and [`Environment`] are what authors write; an [`Emitter`] is what is sampled. There
//! is one for each light, for each glowing shape or triangle, and for the environment.

mod disk;
mod distant;
mod emitter;
mod environment;
mod point;
mod sample;
mod selection;
mod sphere;
mod triangle;

pub use disk::DiskEmitter;
pub use distant::DistantEmitter;
pub use emitter::Emitter;
pub use environment::{Environment, EnvironmentEmitter, EnvironmentLight};
pub use point::PointEmitter;
pub use sample::{EmitterSample, Glow};
pub use selection::EmitterSelection;
pub use sphere::SphereEmitter;
pub use triangle::{ParallelogramEmitter, TriangleEmitter};

use crate::color::Rgb;
use crate::problem::{FINITE, NOT_NEGATIVE, Place, SceneProblem};
use rutilant_geom::Vec3;

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
                if unit(direction).is_none() {
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
                towards: -unit(direction).unwrap_or(Vec3::NEG_Y),
                irradiance: irradiance.into(),
            }),
        }
    }
}

/// A direction of any length but 0 at length 1; the squares of its parts may overflow or vanish.
fn unit(direction: Vec3) -> Option<Vec3> {
    (direction / direction.abs().max_element()).try_normalize()
}
