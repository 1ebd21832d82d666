//! Which statement a material comes from.

use crate::error::{SceneError, SceneErrorKind};
use crate::scene::nearest::nearest;
use crate::scene::pbrt::lexer::Place;
use crate::scene::pbrt::scene::Maker;
use crate::scene::pbrt::state::Chosen;
use crate::shown::shown;

/// Which statement a material comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(in super::super) enum Which {
    Default,
    Own(usize),
    Named(usize),
}

impl Maker<'_> {
    /// The material that a shape names.
    pub(in super::super) fn which(&self, chosen: &Chosen) -> Result<Which, SceneError> {
        match chosen {
            Chosen::Default => Ok(Which::Default),
            Chosen::Own(number) => Ok(Which::Own(*number)),
            Chosen::Named { name, place, before } => {
                self.named_material(name, *before, *place).map(Which::Named)
            }
        }
    }

    pub(super) fn named_material(
        &self,
        name: &str,
        before: usize,
        place: Place,
    ) -> Result<usize, SceneError> {
        self.names.material(name, before).ok_or_else(|| {
            let known = self.description.named_materials.iter().map(|named| &*named.name);
            let kind = SceneErrorKind::Unknown {
                what: "material",
                name: shown(name),
                closest: nearest(name, known).map(shown),
            };
            self.texts.error(place, kind)
        })
    }
}
