//! Triangle meshes.

use crate::problem::{Place, SceneProblem};
use rutilant_geom::{Vec2, Vec3};

/// Triangles that share vertices.
///
/// A triangle's front is where its vertices run counter-clockwise. Vertices
/// and triangles may be NaN, infinite or degenerate: such triangles are left
/// out and counted when the scene is prepared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// What the author calls it; may be empty.
    pub name: String,
    /// Vertex positions, in metres.
    pub positions: Vec<Vec3>,
    /// One normal per vertex for smooth shading, any length; empty for flat triangles.
    pub normals: Vec<Vec3>,
    /// One texture coordinate per vertex; empty where there are none.
    pub uvs: Vec<Vec2>,
    /// Further sets of texture coordinates, each with one per vertex; textures that ask for set 1
    /// get the first of these.
    pub more_uvs: Vec<Vec<Vec2>>,
    /// Where u grows at each vertex, in (x, y, z), of any length, and in w whether v grows along the
    /// normal times that (1) or against it (−1); empty where there are none. Normal maps need them.
    pub tangents: Vec<[f32; 4]>,
    /// One colour and opacity per vertex, linear; empty where there are none. Materials use them
    /// where they say so.
    pub colors: Vec<[f32; 4]>,
    /// Three vertex numbers each.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub(crate) fn validate(&self, index: usize) -> Result<(), SceneProblem> {
        let place = Place::Mesh(index);
        let count = self.positions.len();
        let lengths = [
            ("normals", self.normals.len()),
            ("uvs", self.uvs.len()),
            ("colors", self.colors.len()),
            ("tangents", self.tangents.len()),
        ];
        let more = self.more_uvs.iter().map(|uvs| ("uvs", uvs.len()));
        for (key, length) in lengths.into_iter().chain(more) {
            if length != 0 && length != count {
                return Err(place.problem(
                    key,
                    format!("{length} {key} for {count} positions; give one each, or none"),
                ));
            }
        }
        match self.triangles.iter().flatten().find(|&&v| v as usize >= count) {
            Some(v) => Err(place.problem(
                "triangles",
                format!(
                    "a triangle names vertex {v}, but there are only {count} (numbered from 0)"
                ),
            )),
            None => Ok(()),
        }
    }
}
