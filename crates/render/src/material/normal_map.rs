//! Bumps that are painted: a picture of normals, or of heights.

use crate::id::TextureId;
use crate::problem::{FINITE, Place, SceneProblem};

/// Turns the normal that a surface is shaded by; the surface itself stays as it is. The texture's
/// encoding should be linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// The picture.
    pub texture: TextureId,
    /// A factor on the slopes.
    pub scale: f32,
    /// What the picture shows.
    pub shows: Bumps,
}

/// What a picture of bumps shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bumps {
    /// Red, green and blue, from 0..1 to −1..1, are the normal along u, along v and out of the
    /// surface: what is even is (½, ½, 1). Tangents are those of the mesh where it has some, else
    /// each triangle's own.
    #[default]
    Normals,
    /// Red is how far out of the surface it goes, in metres of the world (Blinn, *Simulation of
    /// Wrinkled Surfaces*, SIGGRAPH 1978).
    Heights,
}

impl NormalMap {
    /// Problems are told at the keys of the map and of its scale.
    pub(super) fn validate(
        &self,
        place: Place,
        [map, scale]: [&'static str; 2],
        textures: usize,
    ) -> Result<(), SceneProblem> {
        place.check(scale, [self.scale], FINITE)?;
        if self.texture.0 as usize >= textures {
            let what = format!("there is no texture number {}", self.texture.0);
            return Err(place.problem(map, what));
        }
        Ok(())
    }
}
