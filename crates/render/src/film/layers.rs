//! What can be kept beside the light of a picture, for denoising and compositing.
//!
//! docs/layers.md tells what each means, in which unit, and who uses it.

/// Something that a picture can tell of what the camera sees, beside its light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Layer {
    /// The part of white light that what is seen sends back: `albedo.R`, `albedo.G`, `albedo.B`.
    Albedo,
    /// The shading normal in the world, on the camera's side: `normal.X`, `normal.Y`, `normal.Z`.
    Normal,
    /// How far away it is in metres: `depth.Z`.
    Depth,
    /// Where it is in the world, in metres: `position.X`, `position.Y`, `position.Z`.
    Position,
    /// Its texture coordinates: `uv.U`, `uv.V`.
    Uv,
    /// The number of the object, from 1 on: `object.id`.
    Object,
    /// The number of the material, from 1 on: `material.id`.
    Material,
    /// The light of the picture in three parts that add up to it: `emission`, seen without a
    /// bounce, `direct`, after one, and `indirect`, after more.
    Light,
    /// The light of the picture by the groups of lights that it started from, which add up to it:
    /// `Combined_key.R`, `Combined_key.G` and `Combined_key.B` of a group "key", and `Combined_rest.R`
    /// and so on of the lights without a group. Nothing where no light has a group.
    Groups,
    /// Mattes of objects, materials and assets by their names: see [`crate::cryptomatte`].
    Cryptomatte,
}

impl Layer {
    /// Every layer with the name that people call it by.
    pub const ALL: [(&'static str, Self); 10] = [
        ("albedo", Self::Albedo),
        ("normal", Self::Normal),
        ("depth", Self::Depth),
        ("position", Self::Position),
        ("uv", Self::Uv),
        ("object", Self::Object),
        ("material", Self::Material),
        ("light", Self::Light),
        ("groups", Self::Groups),
        ("cryptomatte", Self::Cryptomatte),
    ];

    const fn bit(self) -> u16 {
        1 << self as u16
    }
}

/// Which layers a picture has; none at first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Layers(u16);

impl Layers {
    /// Nothing but light.
    pub const NONE: Self = Self(0);

    /// Every one.
    pub fn all() -> Self {
        Layer::ALL.into_iter().map(|(_, layer)| layer).collect()
    }

    /// Whether `layer` is one of them.
    pub const fn has(self, layer: Layer) -> bool {
        self.0 & layer.bit() != 0
    }

    /// The same and `layer`.
    #[must_use]
    pub const fn with(self, layer: Layer) -> Self {
        Self(self.0 | layer.bit())
    }

    /// The same, but not `layer`.
    #[must_use]
    pub const fn without(self, layer: Layer) -> Self {
        Self(self.0 & !layer.bit())
    }

    /// The names of those that are there, in the order of [`Layer::ALL`].
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Layer::ALL.into_iter().filter(move |(_, layer)| self.has(*layer)).map(|(name, _)| name)
    }

    /// Whether any of them tells of the surface that a camera ray meets first.
    pub(crate) fn tell_firsts(self) -> bool {
        self.without(Layer::Light).without(Layer::Groups) != Self::NONE
    }
}

impl FromIterator<Layer> for Layers {
    fn from_iter<T: IntoIterator<Item = Layer>>(layers: T) -> Self {
        layers.into_iter().fold(Self::NONE, Self::with)
    }
}
