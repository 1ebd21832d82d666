//! Where a camera stands: what can be wrong with it.

use crate::problem::{FINITE, Place, SceneProblem};
use rutilant_geom::Transform;

/// A camera's transform must be finite and must not flatten space.
pub(super) fn validate(world_from_camera: &Transform) -> Result<(), SceneProblem> {
    let place = Place::Camera;
    let linear = world_from_camera.linear().to_cols_array();
    let numbers = linear.into_iter().chain(world_from_camera.translation().to_array());
    place.check("position", numbers, FINITE)?;
    if world_from_camera.inverse().is_none() {
        return Err(place.problem("position", "the camera's transform flattens space"));
    }
    Ok(())
}
