//! Light from infinitely far away, in all directions: a sky.
//!
//! It is even, or comes from a picture (`sky_map.rs`).

use super::group::LightGroup;
use super::projection::Projection;
use super::sample::EmitterSample;
use super::sky_map::SkyMap;
use crate::color::{Rgb, Spectrum};
use crate::id::ImageId;
use crate::image::Image;
use crate::math::warp;
use crate::problem::{FINITE, LIGHT, NOT_NEGATIVE, Place, SceneProblem, number};
use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::PI;
use std::sync::Arc;

/// A sky as the author describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Its radiance.
    pub light: EnvironmentLight,
    /// A factor on the radiance, 0 or more.
    pub scale: f32,
    /// Turns the sky around +y, in radians, counter-clockwise seen from above.
    pub rotation: f32,
    /// Where its light counts in a picture of light groups.
    pub group: Option<LightGroup>,
}

/// The radiance of a sky in W/(m² sr).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvironmentLight {
    /// The same in every direction.
    Constant(Rgb),
    /// A map of it.
    Image {
        /// The picture.
        image: ImageId,
        /// How directions lie on it.
        projection: Projection,
    },
}

impl Environment {
    /// The same radiance in every direction.
    pub fn constant(radiance: Rgb) -> Self {
        let light = EnvironmentLight::Constant(radiance);
        Self { light, scale: 1.0, rotation: 0.0, group: None }
    }

    /// A latitude-longitude map as it is.
    pub fn image(image: ImageId) -> Self {
        Self::map(image, Projection::Equirectangular)
    }

    /// A map as it is.
    pub fn map(image: ImageId, projection: Projection) -> Self {
        let light = EnvironmentLight::Image { image, projection };
        Self { light, scale: 1.0, rotation: 0.0, group: None }
    }

    /// The same as one of this group.
    #[must_use]
    pub fn in_group(self, group: LightGroup) -> Self {
        Self { group: Some(group), ..self }
    }

    pub(crate) fn validate(&self, images: &[Arc<Image>]) -> Result<(), SceneProblem> {
        let place = Place::Environment;
        place.check("scale", [self.scale], NOT_NEGATIVE)?;
        place.check("rotation_degrees", [self.rotation], FINITE)?;
        match self.light {
            EnvironmentLight::Constant(rgb) => {
                place.check("color", rgb.0, LIGHT)?;
                self.check_scaled("color", rgb.0)
            }
            EnvironmentLight::Image { image: ImageId(id), projection } => {
                let problem = |what| Err(place.problem("image", what));
                let Some(image) = images.get(id as usize) else {
                    return problem(format!("there is no image number {id}"));
                };
                let size = [image.width(), image.height()];
                if size.contains(&0) {
                    return problem("the image has no pixels".to_owned());
                }
                if image.rgb().is_none() {
                    return problem("the image has no channels R, G, B (or Y)".to_owned());
                }
                projection.charts(size).map(|_| ()).or_else(problem)?;
                let brightest = brightest_pixel(image);
                if self.scale == 1.0 && !LIGHT.contains(&brightest) {
                    let [brightest, most] = [brightest, *LIGHT.end()].map(number);
                    return problem(format!(
                        "the image's brightest pixel is {brightest}, but must be at most {most}; \
                         a scale would make it less"
                    ));
                }
                self.check_scaled("the image's brightest pixel", [brightest])
            }
        }
    }

    /// The radiances of `what` must not grow beyond all numbers when they are scaled.
    fn check_scaled(
        &self,
        what: &str,
        radiances: impl IntoIterator<Item = f32>,
    ) -> Result<(), SceneProblem> {
        let brightest = radiances.into_iter().fold(0.0, f32::max);
        if LIGHT.contains(&(brightest * self.scale)) {
            return Ok(());
        }
        let [scale, most, brightest] = [self.scale, *LIGHT.end(), brightest].map(number);
        let what =
            format!("scale is {scale}, but times {what}, {brightest}, must be at most {most}");
        Err(Place::Environment.problem("scale", what))
    }
}

/// The largest channel of any pixel; those that are no numbers give no light.
fn brightest_pixel(image: &Image) -> f32 {
    let channels = image.rgb().into_iter().flatten().flatten();
    channels.filter(|c| c.is_finite()).fold(0.0, f32::max)
}

/// A sky to sample.
#[derive(Clone, Debug)]
pub struct EnvironmentEmitter {
    sky: Sky,
    /// Sine and cosine of the rotation around +y.
    turn: (f32, f32),
    /// The largest radiance of any channel.
    brightest: f32,
}

#[derive(Clone, Debug)]
enum Sky {
    Constant(Spectrum),
    Map(SkyMap),
}

impl EnvironmentEmitter {
    /// From a valid environment and the scene's images. The number tells how many of the map's
    /// pixels were negative or no numbers; these give no light.
    pub(crate) fn new(environment: &Environment, images: &[Arc<Image>]) -> (Self, usize) {
        let (sky, mended) = match environment.light {
            EnvironmentLight::Constant(rgb) => {
                (Sky::Constant(Spectrum::from(rgb) * environment.scale), 0)
            }
            EnvironmentLight::Image { image, projection } => {
                let image = &images[image.0 as usize];
                SkyMap::new(image, projection, environment.scale)
                    .map_or((Sky::Constant(Spectrum::BLACK), 0), |(map, mended)| {
                        (Sky::Map(map), mended)
                    })
            }
        };
        let brightest = match environment.light {
            EnvironmentLight::Constant(rgb) => Spectrum::from(rgb).max_channel(),
            EnvironmentLight::Image { image, .. } => brightest_pixel(&images[image.0 as usize]),
        };
        let brightest = brightest * environment.scale;
        (Self { sky, turn: real::sin_cos(environment.rotation), brightest }, mended)
    }

    /// The largest radiance of any channel.
    pub(crate) fn brightest(&self) -> f32 {
        self.brightest
    }

    /// Whether it is the same everywhere.
    pub(super) fn is_even(&self) -> bool {
        matches!(self.sky, Sky::Constant(_))
    }

    /// Radiance seen in the unit direction `wi`, in W/(m² sr).
    pub fn radiance(&self, wi: Vec3) -> Spectrum {
        match &self.sky {
            Sky::Constant(radiance) => *radiance,
            Sky::Map(map) => map.radiance(self.to_map(wi)),
        }
    }

    /// Draws a direction that light comes from.
    pub fn sample(&self, u: Vec2) -> Option<EmitterSample> {
        let (wi, radiance, pdf) = match &self.sky {
            Sky::Constant(radiance) => {
                (warp::uniform_sphere(u), *radiance, warp::UNIFORM_SPHERE_PDF)
            }
            Sky::Map(map) => {
                let (direction, radiance, pdf) = map.sample(u)?;
                (self.to_world(direction), radiance, pdf)
            }
        };
        (!radiance.is_black() && pdf.is_finite() && pdf > 0.0).then_some(EmitterSample {
            wi,
            radiance,
            pdf,
            delta: false,
            end: None,
        })
    }

    /// The density with which [`sample`](Self::sample) draws the unit direction `wi`, in 1/sr.
    pub fn pdf(&self, wi: Vec3) -> f32 {
        match &self.sky {
            Sky::Constant(_) => warp::UNIFORM_SPHERE_PDF,
            Sky::Map(map) => {
                let pdf = map.pdf(self.to_map(wi));
                if pdf.is_finite() { pdf } else { 0.0 }
            }
        }
    }

    pub(super) fn power(&self, scene_radius: f32) -> Spectrum {
        let over_the_sphere = match &self.sky {
            Sky::Constant(radiance) => *radiance * (4.0 * PI),
            Sky::Map(map) => map.integral(),
        };
        over_the_sphere * (PI * scene_radius * scene_radius)
    }

    /// World directions to the map's.
    fn to_map(&self, d: Vec3) -> Vec3 {
        let (s, c) = self.turn;
        Vec3::new(c * d.x - s * d.z, d.y, s * d.x + c * d.z)
    }

    /// The map's directions to the world's.
    fn to_world(&self, d: Vec3) -> Vec3 {
        let (s, c) = self.turn;
        Vec3::new(c * d.x + s * d.z, d.y, -s * d.x + c * d.z)
    }
}
