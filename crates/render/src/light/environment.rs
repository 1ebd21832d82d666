//! Light from infinitely far away, in all directions: a sky.
//!
//! A map is a latitude-longitude picture (`math/lat_long.rs`). Between pixel
//! centres its radiance is interpolated bilinearly, over the seam and over the poles. Directions are
//! drawn in proportion to the interpolated luminance times solid angle, pixel
//! by pixel, so that no place that shines is ever left out.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! section 12.5.

use super::sample::EmitterSample;
use crate::color::{Rgb, Spectrum};
use crate::id::ImageId;
use crate::image::Image;
use crate::math::distribution::Distribution2d;
use crate::math::lat_long::{direction_from_uv, uv_from_direction, uv_per_solid_angle};
use crate::math::warp;
use crate::problem::{FINITE, NOT_NEGATIVE, Place, SceneProblem};
use rutilant_geom::{Vec2, Vec3, real};
use std::f32::consts::PI;

/// A sky as the author describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Its radiance.
    pub light: EnvironmentLight,
    /// A factor on the radiance, 0 or more.
    pub scale: f32,
    /// Turns the sky around +y, in radians, counter-clockwise seen from above.
    pub rotation: f32,
}

/// The radiance of a sky in W/(m² sr).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EnvironmentLight {
    /// The same in every direction.
    Constant(Rgb),
    /// A latitude-longitude map: its upper edge is +y, its middle −z, +x lies to the right of that.
    Image(ImageId),
}

impl Environment {
    /// The same radiance in every direction.
    pub fn constant(radiance: Rgb) -> Self {
        Self { light: EnvironmentLight::Constant(radiance), scale: 1.0, rotation: 0.0 }
    }

    /// A latitude-longitude map as it is.
    pub fn image(id: ImageId) -> Self {
        Self { light: EnvironmentLight::Image(id), scale: 1.0, rotation: 0.0 }
    }

    pub(crate) fn validate(&self, images: &[Image]) -> Result<(), SceneProblem> {
        let place = Place::Environment;
        place.check("scale", [self.scale], NOT_NEGATIVE)?;
        place.check("rotation_degrees", [self.rotation], FINITE)?;
        match self.light {
            EnvironmentLight::Constant(rgb) => place.check("color", rgb.0, NOT_NEGATIVE),
            EnvironmentLight::Image(id) => match images.get(id.0 as usize) {
                None => Err(place.problem("image", format!("there is no image number {}", id.0))),
                Some(image) if image.width() == 0 || image.height() == 0 => {
                    Err(place.problem("image", "the image has no pixels"))
                }
                Some(image) if image.rgb().is_none() => {
                    Err(place.problem("image", "the image has no channels R, G, B (or Y)"))
                }
                Some(_) => Ok(()),
            },
        }
    }
}

/// A sky to sample.
#[derive(Clone, Debug)]
pub struct EnvironmentEmitter {
    sky: Sky,
    /// Sine and cosine of the rotation around +y.
    turn: (f32, f32),
}

#[derive(Clone, Debug)]
enum Sky {
    Constant(Spectrum),
    Map(SkyMap),
}

impl EnvironmentEmitter {
    /// From a valid environment and the scene's images. The number tells how many of the map's
    /// pixels were negative or no numbers; these give no light.
    pub(crate) fn new(environment: &Environment, images: &[Image]) -> (Self, usize) {
        let (sky, mended) = match environment.light {
            EnvironmentLight::Constant(rgb) => {
                (Sky::Constant(Spectrum::from(rgb) * environment.scale), 0)
            }
            EnvironmentLight::Image(id) => SkyMap::new(&images[id.0 as usize], environment.scale)
                .map_or((Sky::Constant(Spectrum::BLACK), 0), |(map, mended)| {
                    (Sky::Map(map), mended)
                }),
        };
        (Self { sky, turn: real::sin_cos(environment.rotation) }, mended)
    }

    /// Radiance seen in the unit direction `wi`, in W/(m² sr).
    pub fn radiance(&self, wi: Vec3) -> Spectrum {
        match &self.sky {
            Sky::Constant(radiance) => *radiance,
            Sky::Map(map) => map.radiance(uv_from_direction(self.to_map(wi))),
        }
    }

    /// Draws a direction that light comes from.
    pub fn sample(&self, u: Vec2) -> Option<EmitterSample> {
        let (wi, radiance, pdf) = match &self.sky {
            Sky::Constant(radiance) => {
                (warp::uniform_sphere(u), *radiance, warp::UNIFORM_SPHERE_PDF)
            }
            Sky::Map(map) => {
                let (uv, pdf_uv) = map.distribution.as_ref()?.sample(u)?;
                let direction = direction_from_uv(uv);
                (self.to_world(direction), map.radiance(uv), pdf_uv * uv_per_solid_angle(direction))
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
                let direction = self.to_map(wi);
                let pdf_uv =
                    map.distribution.as_ref().map_or(0.0, |d| d.pdf(uv_from_direction(direction)));
                let pdf = pdf_uv * uv_per_solid_angle(direction);
                if pdf.is_finite() { pdf } else { 0.0 }
            }
        }
    }

    pub(super) fn power(&self, scene_radius: f32) -> Spectrum {
        let over_the_sphere = match &self.sky {
            Sky::Constant(radiance) => *radiance * (4.0 * PI),
            Sky::Map(map) => map.integral,
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

/// A latitude-longitude map.
#[derive(Clone, Debug)]
struct SkyMap {
    width: usize,
    height: usize,
    /// (height, width) radiances, row 0 around +y.
    texels: Vec<Spectrum>,
    /// Over the unit square of the map; `None` for a black map.
    distribution: Option<Distribution2d>,
    /// Radiance integrated over all directions.
    integral: Spectrum,
}

impl SkyMap {
    fn new(image: &Image, scale: f32) -> Option<(Self, usize)> {
        let (width, height) = (image.width() as usize, image.height() as usize);
        let mut mended = 0;
        let texels: Vec<Spectrum> = image
            .rgb()?
            .into_iter()
            .map(|rgb| {
                let sound = rgb.iter().all(|c| (0.0..=f32::MAX).contains(c));
                mended += usize::from(!sound);
                Spectrum::from(rgb.map(|c| if (0.0..=f32::MAX).contains(&c) { c } else { 0.0 }))
                    * scale
            })
            .collect();
        let mut map = Self { width, height, texels, distribution: None, integral: Spectrum::BLACK };

        // What is drawn from: the interpolated radiance integrated over each texel.
        let mut integral = [0.0; 3];
        let mut weights = Vec::with_capacity(width * height);
        for row in 0..height {
            let edge = |r: usize| f64::from(real::cos(PI * r as f32 / height as f32));
            let solid_angle =
                (edge(row) - edge(row + 1)).abs() * 2.0 * f64::from(PI) / width as f64;
            for column in 0..width {
                let mean = map.texel_mean(column as isize, row as isize);
                for (sum, c) in integral.iter_mut().zip(mean.channels()) {
                    *sum += f64::from(c) * solid_angle;
                }
                // Any channel counts: a lamp of pure blue has next to no luminance.
                weights.push(
                    (f64::from(mean.luminance()) + 1e-3 * f64::from(mean.max_channel()))
                        * solid_angle,
                );
            }
        }
        map.integral = Spectrum::from(integral.map(|c| c as f32));
        map.distribution = Distribution2d::new(width, &weights);
        Some((map, mended))
    }

    /// A texel by column and row; columns go round, rows go over the pole to the other side.
    fn texel(&self, column: isize, row: isize) -> Spectrum {
        let (width, height) = (self.width as isize, self.height as isize);
        let (column, row) = match row {
            r if r < 0 => (column + width / 2, -1 - r),
            r if r >= height => (column + width / 2, 2 * height - 1 - r),
            r => (column, r),
        };
        self.texels[(row * width + column.rem_euclid(width)) as usize]
    }

    /// The bilinear interpolant averaged over a texel: weights 1/8, 6/8, 1/8 along each axis.
    fn texel_mean(&self, column: isize, row: isize) -> Spectrum {
        let across = |row| {
            (self.texel(column - 1, row) + self.texel(column + 1, row)) * 0.125
                + self.texel(column, row) * 0.75
        };
        (across(row - 1) + across(row + 1)) * 0.125 + across(row) * 0.75
    }

    /// Interpolated between the four nearest texel centres.
    fn radiance(&self, uv: Vec2) -> Spectrum {
        let at = uv * Vec2::new(self.width as f32, self.height as f32) - 0.5;
        let corner = at.floor();
        let part = at - corner;
        let (column, row) = (corner.x as isize, corner.y as isize);
        let across =
            |row| self.texel(column, row) * (1.0 - part.x) + self.texel(column + 1, row) * part.x;
        across(row) * (1.0 - part.y) + across(row + 1) * part.y
    }
}
