//! Where the parts of a scene come from that its text does not hold itself.
//!
//! A renderer has no use for it; whoever writes a scene anew has: what stands in a file already is
//! named, or copied with its own bytes, instead of being encoded once more.

use rutilant::scene::{BitmapId, ImageId, MeshId};
use std::path::PathBuf;
use std::sync::Arc;

/// Where pictures and meshes come from. Lists may be shorter than those of the scene: nothing is
/// known of the rest.
#[derive(Clone, Debug, Default)]
pub struct Origins {
    /// Those of the pictures that textures show, by [`BitmapId`].
    pub bitmaps: Vec<PictureOrigin>,
    /// Those of the pictures that skies show, by [`ImageId`].
    pub images: Vec<PictureOrigin>,
    /// Those of the meshes, by [`MeshId`].
    pub meshes: Vec<MeshOrigin>,
}

/// Where a picture comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum PictureOrigin {
    /// A file, symbolic links followed.
    File(PathBuf),
    /// The content of a file that lay within another one.
    Bytes {
        /// What its author calls it.
        title: String,
        /// The content, as it lay there.
        bytes: Arc<Vec<u8>>,
    },
    /// A file of this name that is not there: magenta stands in.
    Missing(String),
}

/// Where a mesh comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum MeshOrigin {
    /// It was made, or is a part of a file that holds more.
    #[default]
    Made,
    /// The scene's own text, number by number.
    Text,
    /// A mesh file that holds this mesh, no other, and no material.
    File {
        /// The file, symbolic links followed.
        path: PathBuf,
        /// The largest angle, in radians, that was smoothed over, where the mesh was given normals.
        crease: Option<f32>,
    },
}

impl Origins {
    pub(crate) fn bitmap(&self, id: BitmapId) -> Option<&PictureOrigin> {
        self.bitmaps.get(id.0 as usize)
    }

    pub(crate) fn image(&self, id: ImageId) -> Option<&PictureOrigin> {
        self.images.get(id.0 as usize)
    }

    pub(crate) fn mesh(&self, id: MeshId) -> &MeshOrigin {
        self.meshes.get(id.0 as usize).unwrap_or(&MeshOrigin::Made)
    }
}
