//! The eye: which ray each point of the film sees along.

mod perspective;

pub use perspective::Perspective;
pub(crate) use perspective::PreparedPerspective;

use crate::problem::SceneProblem;
use rutilant_geom::{Ray, Vec2};

/// A camera as the author describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// A pinhole, or a thin lens.
    Perspective(Perspective),
}

impl From<Perspective> for Camera {
    fn from(camera: Perspective) -> Self {
        Self::Perspective(camera)
    }
}

impl Camera {
    pub(crate) fn validate(&self) -> Result<(), SceneProblem> {
        match self {
            Self::Perspective(c) => c.validate(),
        }
    }

    /// The ray from the middle of the lens through the middle of the picture.
    pub(crate) fn axis(&self) -> Ray {
        match self {
            Self::Perspective(c) => c.axis(),
        }
    }

    /// This camera on a film of `size` pixels.
    pub(crate) fn prepare(&self, size: [u32; 2]) -> PreparedCamera {
        match self {
            Self::Perspective(c) => PreparedCamera::Perspective(c.prepare(size)),
        }
    }
}

/// A camera that knows its film.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PreparedCamera {
    Perspective(PreparedPerspective),
}

impl PreparedCamera {
    /// The ray seen at `film` (in pixels from the upper left corner), through the point of the
    /// lens that `u`, two numbers in [0, 1), stands for. Its direction has unit length.
    pub(crate) fn ray(&self, film: Vec2, u: Vec2) -> Ray {
        match self {
            Self::Perspective(c) => c.ray(film, u),
        }
    }
}
