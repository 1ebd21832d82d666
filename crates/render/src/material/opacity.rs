//! Surfaces with holes in them: leaves, fences, curtains.

use crate::problem::{Place, SceneProblem, UNIT};
use crate::texture::ScalarInput;

/// How much of a surface is there. Where it is not, rays of every kind go on as if there were
/// nothing: they see what is behind, and light comes through, unscattered.
///
/// Not for glass, whose surface reflects although one sees through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opacity {
    /// The part of the surface that is there, 0 to 1.
    pub amount: ScalarInput,
    /// Whether the opacity of the mesh's vertices is a factor as well; 1 where it has none.
    pub vertex_colors: bool,
    /// What parts between 0 and 1 mean.
    pub mode: OpacityMode,
}

/// What an opacity between 0 and 1 means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OpacityMode {
    /// So many of the rays meet the surface: a veil.
    Blend,
    /// All of the surface is there where the opacity is at least so much, else nothing.
    Mask {
        /// 0 to 1.
        cutoff: f32,
    },
}

impl Opacity {
    pub(super) fn validate(&self, place: Place, textures: usize) -> Result<(), SceneProblem> {
        self.amount.validate(place, "opacity", UNIT, textures)?;
        match self.mode {
            OpacityMode::Blend => Ok(()),
            OpacityMode::Mask { cutoff } => place.check("cutoff", [cutoff], UNIT),
        }
    }
}
