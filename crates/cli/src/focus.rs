//! What the camera is focused on: said where it was asked for.

use crate::failure::Failure;
use crate::text::{several, significant};
use rutilant::Prepared;
use rutilant::camera::Lens;
use rutilant::scene::Scene;
use serde::Serialize;

/// Something sharp.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Focus {
    /// Of the sharp plane, in metres along the view.
    distance: f32,
    /// Metres from the lens to the point, by way of all mirrors and glass.
    path_length: f32,
    point: [f32; 3],
    /// Mirrors and borders of glass on the way.
    bounces: u32,
}

/// Asks the scene's camera to focus on a pixel of a picture of `size` pixels.
pub(crate) fn ask(scene: &mut Scene, [x, y]: [u32; 2], size: [u32; 2]) -> Result<(), Failure> {
    let Some(lens) = scene.camera.lens_mut() else {
        return Err(Failure::usage(
            "--focus-on needs a lens, and an equirectangular camera has none",
        ));
    };
    let Some(place) = Lens::place_of_pixel([x, y], size) else {
        let [width, height] = size;
        return Err(Failure::usage(format!(
            "--focus-on {x},{y} lies outside the picture of {width}x{height} pixels; they count from 0,0"
        )));
    };
    lens.focus_on = Some(place);
    Ok(())
}

/// What the scene's camera is focused on, if it was asked to focus on a pixel; and what to say
/// where that comes to nothing.
pub(crate) fn find(
    scene: &Scene,
    prepared: &Prepared,
    size: [u32; 2],
) -> (Option<Focus>, Option<String>) {
    let Some(lens) = scene.camera.lens() else { return (None, None) };
    let Some(place) = lens.focus_on else { return (None, None) };
    match prepared.focus_on(size, place) {
        None => {
            let kept = significant(lens.focus_distance);
            let what = "nothing in the pixel to focus on can be made sharp";
            (None, Some(format!("{what}; the focus stays at {kept} m")))
        }
        Some(found) => {
            let focus = Focus {
                distance: found.distance,
                path_length: found.path_length,
                point: found.point.to_array(),
                bounces: found.bounces,
            };
            let without_lens = (lens.aperture_radius == 0.0).then(|| {
                "focusing changes nothing: a pinhole sees everything sharp; give the camera an \
                 aperture_radius or an f_number"
                    .to_owned()
            });
            (Some(focus), without_lens)
        }
    }
}

impl Focus {
    /// For people.
    pub(crate) fn describe(&self) -> String {
        let distance = significant(self.distance);
        let point = self.point.map(significant).join(", ");
        let way = match self.bounces {
            0 => String::new(),
            n => format!(
                ", {} m of way over {}",
                significant(self.path_length),
                several(u64::from(n), "mirror or border of glass", "mirrors and borders of glass"),
            ),
        };
        format!("{distance} m along the view, on ({point}){way}")
    }
}
