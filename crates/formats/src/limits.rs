//! How much a file may ask for.

/// The most that reading may take, so that a small hostile file cannot ask for a large machine.
///
/// Allocation is bounded by the bytes present in any case; these limits end
/// what is legal but larger than the caller cares for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of any one file.
    pub file_bytes: u64,
    /// Vertices of all meshes together.
    pub vertices: u64,
    /// Triangles of all meshes together.
    pub triangles: u64,
    /// Pixels of any one image.
    pub pixels: u64,
    /// Objects in a scene: each time a shape, or a part of a mesh file, is placed.
    pub objects: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 8 << 30,
            vertices: 400_000_000,
            triangles: 400_000_000,
            pixels: 1 << 28,
            objects: 10_000_000,
        }
    }
}
