//! What light comes from: lights without a surface, the environment, and surfaces that glow.
//!
//! [`Light`] and [`Environment`] are what authors write; an [`Emitter`] is what is sampled. There
//! is one for each light, for each glowing shape or triangle, and for the environment.

mod bounds;
mod disk;
mod distant;
mod emitter;
mod environment;
mod group;
mod point;
mod projection;
mod sample;
mod selection;
mod shading_point;
mod sky_map;
mod sphere;
mod spot;
mod tree;
mod triangle;

pub use disk::DiskEmitter;
pub use distant::DistantEmitter;
pub use emitter::Emitter;
pub use environment::{Environment, EnvironmentEmitter, EnvironmentLight};
pub use group::{GroupNameProblem, LightGroup};
pub use point::PointEmitter;
pub use projection::Projection;
pub(crate) use sample::LampPoint;
pub use sample::{EmitterSample, Glow};
pub use selection::{EmitterSelection, TreeSelection};
pub use shading_point::ShadingPoint;
pub use sphere::SphereEmitter;
pub use spot::SpotEmitter;
pub(crate) use tree::LightTree;
pub(crate) use triangle::FlatEmitter;
pub use triangle::{ParallelogramEmitter, TriangleEmitter};

use crate::color::{Rgb, Spectrum};
use crate::problem::{FINITE, LIGHT, Place, SceneProblem};
use rutilant_geom::Vec3;
use std::f32::consts::PI;

/// A light without a surface. It cannot be seen, only its light can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines from one point, equally in all directions.
    Point {
        /// Where it is.
        position: Vec3,
        /// Intensity in W/sr, per channel.
        intensity: Rgb,
        /// Where its light counts in a picture of light groups.
        group: Option<LightGroup>,
    },
    /// Shines along one direction, from infinitely far away.
    Directional {
        /// Where its light goes; any length but 0.
        direction: Vec3,
        /// Irradiance in W/m² on a surface that faces it, per channel.
        irradiance: Rgb,
        /// Where its light counts in a picture of light groups.
        group: Option<LightGroup>,
    },
    /// Shines from one point into a cone with soft edges.
    Spot {
        /// Where it is.
        position: Vec3,
        /// Where the middle of its beam goes; any length but 0.
        direction: Vec3,
        /// How much light.
        light: SpotLight,
        /// Half angle, in radians, within which it is evenly bright; 0 up to `outer`.
        inner: f32,
        /// Half angle, in radians, beyond which it is dark; above 0, up to π.
        outer: f32,
        /// Where its light counts in a picture of light groups.
        group: Option<LightGroup>,
    },
}

/// How much light a spot gives, per channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpotLight {
    /// Within the inner cone, in W/sr: the cone's width does not change how bright it is.
    Intensity(Rgb),
    /// In all, in W: a narrower cone is brighter.
    Power(Rgb),
}

impl Light {
    /// The group that its light is of.
    pub fn group(&self) -> Option<LightGroup> {
        match self {
            Self::Point { group, .. }
            | Self::Directional { group, .. }
            | Self::Spot { group, .. } => *group,
        }
    }

    /// The same as one of this group.
    #[must_use]
    pub fn in_group(mut self, of: LightGroup) -> Self {
        match &mut self {
            Self::Point { group, .. }
            | Self::Directional { group, .. }
            | Self::Spot { group, .. } => {
                *group = Some(of);
            }
        }
        self
    }

    pub(crate) fn validate(&self, index: usize) -> Result<(), SceneProblem> {
        let place = Place::Light(index);
        match *self {
            Self::Point { position, intensity, group: _ } => {
                place.check("position", position.to_array(), FINITE)?;
                place.check("intensity", intensity.0, LIGHT)
            }
            Self::Directional { direction, irradiance, group: _ } => {
                place.check("direction", direction.to_array(), FINITE)?;
                if unit(direction).is_none() {
                    return Err(place.problem("direction", "direction has no length"));
                }
                place.check("irradiance", irradiance.0, LIGHT)
            }
            Self::Spot { position, direction, light, inner, outer, group: _ } => {
                place.check("position", position.to_array(), FINITE)?;
                place.check("direction", direction.to_array(), FINITE)?;
                if unit(direction).is_none() {
                    return Err(place.problem("direction", "direction has no length"));
                }
                // As the author wrote them: what radians have rounded is rounded back.
                let degrees =
                    [inner, outer].map(|angle| (f64::from(angle).to_degrees() * 1e4).round() / 1e4);
                if !(MIN_CONE..=PI).contains(&outer) {
                    let [_, given] = degrees;
                    return Err(place.problem(
                        "outer_degrees",
                        format!("outer_degrees is {given}, but must lie between 0.01 and 180"),
                    ));
                }
                if !(0.0..=outer).contains(&inner) {
                    let [given, most] = degrees;
                    return Err(place.problem(
                        "inner_degrees",
                        format!("inner_degrees is {given}, but must lie between 0 and outer_degrees, {most}"),
                    ));
                }
                match light {
                    SpotLight::Intensity(rgb) => place.check("intensity", rgb.0, LIGHT),
                    SpotLight::Power(rgb) => place.check("power", rgb.0, LIGHT),
                }
            }
        }
    }

    pub(crate) fn prepare(&self) -> Emitter {
        match *self {
            Self::Point { position, intensity, group: _ } => {
                Emitter::Point(PointEmitter { position, intensity: intensity.into() })
            }
            Self::Directional { direction, irradiance, group: _ } => {
                Emitter::Distant(DistantEmitter {
                    towards: -unit(direction).unwrap_or(Vec3::NEG_Y),
                    irradiance: irradiance.into(),
                })
            }
            Self::Spot { position, direction, light, inner, outer, group: _ } => {
                let cones = [inner, outer];
                let intensity = match light {
                    SpotLight::Intensity(rgb) => Spectrum::from(rgb),
                    SpotLight::Power(rgb) => Spectrum::from(rgb) / SpotEmitter::solid_angle(cones),
                };
                let axis = unit(direction).unwrap_or(Vec3::NEG_Y);
                Emitter::Spot(SpotEmitter::new(position, axis, intensity, cones))
            }
        }
    }
}

/// The narrowest cone of a spot, in radians: 0.01°, a metre wide after 3 km. In a narrower one the
/// angle to its axis would drown in rounding.
pub const MIN_CONE: f32 = 1.7e-4;

/// A direction of any length but 0 at length 1; the squares of its parts may overflow or vanish.
fn unit(direction: Vec3) -> Option<Vec3> {
    (direction / direction.abs().max_element()).try_normalize()
}
