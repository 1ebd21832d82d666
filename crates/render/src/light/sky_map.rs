//! The radiance of a sky from a picture, and directions drawn in proportion to it.
//!
//! Between pixel centres the radiance is interpolated bilinearly, over all edges of the picture's
//! charts (`projection.rs`) and over the poles: each chart is kept with a border of what lies
//! beyond it. Directions are drawn in proportion to the interpolated luminance times solid angle,
//! pixel by pixel, so that no place that shines is ever left out.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., section 12.5.

use super::projection::{Charts, Projection};
use crate::color::Spectrum;
use crate::image::Image;
use crate::math::distribution::Distribution2d;
use rutilant_geom::{Vec2, Vec3};

/// A sky from a picture.
#[derive(Clone, Debug)]
pub(super) struct SkyMap {
    charts: Charts,
    /// (chart, height + 2, width + 2) radiances: each chart with a border.
    texels: Vec<Spectrum>,
    /// Over the charts, one below the other; `None` for a black map.
    distribution: Option<Distribution2d>,
    /// Radiance integrated over all directions.
    integral: Spectrum,
}

impl SkyMap {
    /// `None` for a picture without colours or of a size that the projection does not have. The
    /// number tells how many of its pixels were negative or no numbers; these give no light.
    pub(super) fn new(image: &Image, projection: Projection, scale: f32) -> Option<(Self, usize)> {
        let charts = projection.charts([image.width(), image.height()]).ok()?;
        let (width, height) = (charts.width, charts.height);
        let rgb = image.rgb()?;
        let sound = |rgb: &[f32; 3]| rgb.iter().all(|c| (0.0..=f32::MAX).contains(c));
        let light = |pixel: usize| {
            let mend = |c| if (0.0..=f32::MAX).contains(&c) { c } else { 0.0 };
            Spectrum::from(rgb[pixel].map(mend)) * scale
        };

        // The charts with their borders. What a cross leaves free is never looked at.
        let mut mended = 0;
        let mut texels = Vec::with_capacity(charts.count() * (width + 2) * (height + 2));
        for chart in 0..charts.count() {
            for row in -1..=height as isize {
                for column in -1..=width as isize {
                    let inside = (0..width).contains(&(column as usize))
                        && (0..height).contains(&(row as usize));
                    texels.push(if inside {
                        let pixel = charts.pixel(chart, column as usize, row as usize);
                        mended += usize::from(!sound(&rgb[pixel]));
                        light(pixel)
                    } else {
                        let pixels = charts.pixels_at(chart, column, row);
                        let share = 1.0 / pixels.len() as f32;
                        let sum = |sum, pixel: &usize| sum + light(*pixel) * share;
                        pixels.iter().fold(Spectrum::BLACK, sum)
                    });
                }
            }
        }
        let mut map = Self { charts, texels, distribution: None, integral: Spectrum::BLACK };

        // What is drawn from: the interpolated radiance integrated over each texel.
        let mut integral = [0.0; 3];
        let mut weights = vec![0.0; charts.count() * width * height];
        for row in 0..height {
            let solid_angles = charts.solid_angles(row);
            for chart in 0..charts.count() {
                let first = (chart * height + row) * width;
                let weights = &mut weights[first..first + width];
                for (column, (weight, solid_angle)) in
                    weights.iter_mut().zip(&solid_angles).enumerate()
                {
                    let mean = map.texel_mean(chart, column, row);
                    for (sum, c) in integral.iter_mut().zip(mean.channels()) {
                        *sum += f64::from(c) * solid_angle;
                    }
                    // Any channel counts: a lamp of pure blue has next to no luminance.
                    *weight = (f64::from(mean.luminance()) + 1e-3 * f64::from(mean.max_channel()))
                        * solid_angle;
                }
            }
        }
        map.integral = Spectrum::from(integral.map(|c| c as f32));
        map.distribution = Distribution2d::new(width, &weights);
        Some((map, mended))
    }

    /// Radiance seen in a unit direction.
    pub(super) fn radiance(&self, d: Vec3) -> Spectrum {
        let (chart, uv) = self.charts.find(d);
        self.interpolated(chart, uv)
    }

    /// A direction for `u` in [0, 1)², the radiance there, and the density in 1/sr with which it
    /// is drawn.
    pub(super) fn sample(&self, u: Vec2) -> Option<(Vec3, Spectrum, f32)> {
        let ([column, row], within, density) = self.distribution.as_ref()?.sample(u)?;
        let (width, height) = (self.charts.width, self.charts.height);
        let (chart, row) = (row / height, row % height);
        let texel = Vec2::new(column as f32, row as f32);
        let uv = (texel + within) / Vec2::new(width as f32, height as f32);
        let d = self.charts.direction(chart, uv);
        Some((d, self.interpolated(chart, uv), self.per_solid_angle(density, d)))
    }

    /// The density of [`sample`](Self::sample) at a unit direction, in 1/sr.
    pub(super) fn pdf(&self, d: Vec3) -> f32 {
        let Some(distribution) = &self.distribution else { return 0.0 };
        let (chart, uv) = self.charts.find(d);
        let texel = |part: f32, count: usize| ((part * count as f32) as usize).min(count - 1);
        let (width, height) = (self.charts.width, self.charts.height);
        let cell = [texel(uv.x, width), chart * height + texel(uv.y, height)];
        self.per_solid_angle(distribution.density(cell), d)
    }

    /// Radiance integrated over all directions.
    pub(super) fn integral(&self) -> Spectrum {
        self.integral
    }

    /// A density over all charts as one around a direction.
    fn per_solid_angle(&self, density: f32, d: Vec3) -> f32 {
        density / self.charts.count() as f32 * self.charts.uv_per_solid_angle(d)
    }

    /// The place among the texels of a column and row, both counted from the border.
    fn place(&self, chart: usize, column: usize, row: usize) -> usize {
        let (width, height) = (self.charts.width + 2, self.charts.height + 2);
        (chart * height + row) * width + column
    }

    /// The bilinear interpolant averaged over a texel: weights 1/8, 6/8, 1/8 along each axis.
    fn texel_mean(&self, chart: usize, column: usize, row: usize) -> Spectrum {
        let across = |row| {
            let first = self.place(chart, column, row);
            (self.texels[first] + self.texels[first + 2]) * 0.125 + self.texels[first + 1] * 0.75
        };
        (across(row) + across(row + 2)) * 0.125 + across(row + 1) * 0.75
    }

    /// Interpolated between the four nearest texel centres; both coordinates in [0, 1).
    fn interpolated(&self, chart: usize, uv: Vec2) -> Spectrum {
        let at = uv * Vec2::new(self.charts.width as f32, self.charts.height as f32) - 0.5;
        let corner = at.floor();
        let part = at - corner;
        // From -1, where the border is.
        let (column, row) = ((corner.x + 1.0) as usize, (corner.y + 1.0) as usize);
        let across = |row| {
            let first = self.place(chart, column, row);
            self.texels[first] * (1.0 - part.x) + self.texels[first + 1] * part.x
        };
        across(row) * (1.0 - part.y) + across(row + 1) * part.y
    }
}
