//! Two materials in some proportion.

use super::{Material, MaterialKind};
use crate::scene::{MaterialId, Place, SceneProblem, UNIT};

/// `1 - amount` of the first material and `amount` of the second.
///
/// A matte material mixed with a mirror is the 2017 report's "specular
/// component". Emission of the parts is not mixed in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// What there is when `amount` is 0.
    pub first: MaterialId,
    /// What there is when `amount` is 1.
    pub second: MaterialId,
    /// The share of the second, 0 to 1.
    pub amount: f32,
}

impl Mix {
    pub(super) fn validate(&self, place: Place, all: &[Material]) -> Result<(), SceneProblem> {
        place.check("amount", [self.amount], UNIT)?;
        for (key, id) in [("first", self.first), ("second", self.second)] {
            match all.get(id.0 as usize).map(|m| &m.kind) {
                None => {
                    return Err(place.problem(key, format!("there is no material number {}", id.0)));
                }
                Some(MaterialKind::Mix(_)) => {
                    return Err(place.problem(
                        key,
                        format!("{key} is itself a mix; mix plain materials instead"),
                    ));
                }
                Some(MaterialKind::Dielectric(_)) => {
                    return Err(place.problem(
                        key,
                        format!("{key} is a dielectric, which cannot be mixed: what is inside would be in doubt"),
                    ));
                }
                Some(
                    MaterialKind::Black
                    | MaterialKind::Matte(_)
                    | MaterialKind::Mirror(_)
                    | MaterialKind::Conductor(_),
                ) => {}
            }
        }
        Ok(())
    }
}
