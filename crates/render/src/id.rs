//! Numbers that stand for parts of a scene, one type for each kind of part.

/// A place in [`Scene::materials`](crate::scene::Scene::materials).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// A place in [`Scene::meshes`](crate::scene::Scene::meshes).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MeshId(pub u32);

/// A place in [`Scene::bitmaps`](crate::scene::Scene::bitmaps).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BitmapId(pub u32);

/// A place in [`Scene::textures`](crate::scene::Scene::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextureId(pub u32);

/// A place in [`Scene::images`](crate::scene::Scene::images).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ImageId(pub u32);
