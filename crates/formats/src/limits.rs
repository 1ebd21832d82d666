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
    /// Bytes of the pictures of all textures together.
    pub texture_bytes: u64,
    /// Pixels of the picture that a scene asks for.
    pub picture: u64,
    /// Objects in a scene: each time a shape, or a part of a mesh file, is placed. Each takes some
    /// 350 bytes until it can be rendered.
    pub objects: u64,
    /// Levels of tables and arrays in each other in a scene's text.
    pub nesting: u64,
}

impl Limits {
    /// The name of each limit, as errors and the command line say it.
    pub const NAMES: [&'static str; 8] =
        ["bytes", "vertices", "triangles", "pixels", "textures", "picture", "objects", "nesting"];

    /// The limit of a name; `None` for a name that is not in [`NAMES`](Self::NAMES).
    pub fn by_name(&mut self, name: &str) -> Option<&mut u64> {
        Some(match name {
            "bytes" => &mut self.file_bytes,
            "vertices" => &mut self.vertices,
            "triangles" => &mut self.triangles,
            "pixels" => &mut self.pixels,
            "textures" => &mut self.texture_bytes,
            "picture" => &mut self.picture,
            "objects" => &mut self.objects,
            "nesting" => &mut self.nesting,
            _ => return None,
        })
    }

    /// How to raise the limit on `what`, for the end of a message: nothing where its last word
    /// is not the name of a limit.
    pub(crate) fn hint(what: &str) -> String {
        let name = what.rsplit(' ').next().unwrap_or_default();
        if Self::NAMES.contains(&name) {
            format!("; allow more with --limit {name}=N")
        } else {
            String::new()
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            file_bytes: 8 << 30,
            vertices: 400_000_000,
            triangles: 400_000_000,
            pixels: 1 << 28,
            texture_bytes: 4 << 30,
            picture: 1 << 24,
            objects: 3_000_000,
            nesting: 64,
        }
    }
}
