//! Pixel reconstruction filters.

use crate::scene::{Place, SceneProblem};

/// How samples weigh around a pixel's centre. All are separable; radii are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// All samples within `radius` alike.
    Box {
        /// 0.5 covers exactly one pixel.
        radius: f32,
    },
    /// Falls linearly to zero at `radius`.
    Tent {
        /// 1 interpolates linearly between pixels.
        radius: f32,
    },
    /// A Gaussian of standard deviation `sigma`, lowered to reach zero at `radius`.
    Gaussian {
        /// Where it ends.
        radius: f32,
        /// Its width.
        sigma: f32,
    },
    /// Mitchell and Netravali's cubic: sharp, with small negative lobes.
    Mitchell {
        /// Where it ends; 2 is usual.
        radius: f32,
        /// The blurring parameter B; 1/3 is usual.
        b: f32,
        /// The ringing parameter C; 1/3 is usual.
        c: f32,
    },
    /// The four-term Blackman–Harris window: smooth, nearly without ringing.
    BlackmanHarris {
        /// Where it ends; 1.5 is usual.
        radius: f32,
    },
}

impl Default for Filter {
    fn default() -> Self {
        Self::BlackmanHarris { radius: 1.5 }
    }
}

impl Filter {
    /// Half the width of the square that samples come from, in pixels.
    pub fn radius(&self) -> f32 {
        match *self {
            Self::Box { radius }
            | Self::Tent { radius }
            | Self::Gaussian { radius, .. }
            | Self::Mitchell { radius, .. }
            | Self::BlackmanHarris { radius } => radius,
        }
    }

    pub(crate) fn validate(&self) -> Result<(), SceneProblem> {
        let place = Place::Settings;
        place.check("filter_radius", [self.radius()], 0.01..=16.0)?;
        match *self {
            Self::Gaussian { sigma, .. } => place.check("filter_sigma", [sigma], 0.01..=16.0),
            Self::Mitchell { b, c, .. } => place.check("filter_bc", [b, c], -1.0..=2.0),
            Self::Box { .. } | Self::Tent { .. } | Self::BlackmanHarris { .. } => Ok(()),
        }
    }
}
