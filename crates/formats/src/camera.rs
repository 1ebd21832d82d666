//! The camera in its author's words.
//!
//! A [`Camera`] holds what rays need: a transform, an angle, a radius. An
//! [`AuthoredCamera`] holds what was said: where the eye is and what it looks
//! at, a focal length or an angle, an f-number or a radius. The one is made of
//! the other by [`AuthoredCamera::camera`] alone, for files and for whoever
//! edits a camera; so one that is written by [`AuthoredCamera::to_toml`] and
//! read again is the same camera, to the last bit.

use crate::scene::native::camera as native;
use rutilant::camera::{Camera, Equirectangular, Lens, Orthographic, Perspective};
use rutilant::scene::{Place, SceneProblem};
use rutilant_geom::{Transform, Vec3, real};

/// The vertical angle of view where none is given, in degrees.
pub(crate) const FOV_DEGREES: f32 = 45.0;

/// The height of the film where none is given, in millimetres: that of small-format film and of
/// "full frame" digital cameras, which photographers mean when they name a focal length.
pub(crate) const SENSOR_HEIGHT_MM: f32 = 24.0;

/// A camera as the native scene format says it (docs/scene-format.md): lengths in metres unless
/// they are named otherwise, angles in degrees.
#[derive(Clone, Debug, PartialEq)]
pub struct AuthoredCamera {
    /// What it is called; may be empty.
    pub name: String,
    /// Where the eye is.
    pub position: Vec3,
    /// What stands in the middle of the picture.
    pub look_at: Vec3,
    /// What is up in the picture; of any length but 0.
    pub up: Vec3,
    /// How it sees.
    pub kind: CameraKind,
}

/// How a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CameraKind {
    /// What is far is small, as for the eye.
    Perspective {
        /// How much is seen.
        view: AngleOfView,
        /// The height of the film behind a focal length or an f-number; without either it has no
        /// meaning.
        sensor_height_mm: f32,
        /// The lens.
        lens: AuthoredLens,
    },
    /// What is far is as large as what is near.
    Orthographic {
        /// From the picture's bottom to its top, in metres.
        height: f32,
        /// The lens.
        lens: AuthoredLens,
    },
    /// Everything around, as on a map.
    Equirectangular,
}

/// How much a perspective camera sees from the picture's top to its bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AngleOfView {
    /// The angle itself.
    FovDegrees(f32),
    /// The focal length that sees it on the film that there is.
    FocalLengthMm(f32),
}

/// A lens in its author's words.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AuthoredLens {
    /// How wide it is.
    pub aperture: Aperture,
    /// What is sharp.
    pub focus: FocusOn,
    /// Straight edges of the aperture; 0 is round.
    pub blades: u32,
    /// Turns the polygon; without blades it has no meaning.
    pub blade_rotation_degrees: f32,
    /// Height over width of the aperture.
    pub aperture_ratio: f32,
}

/// How wide a lens is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aperture {
    /// Its radius in metres; 0 is a pinhole.
    Radius(f32),
    /// Its f-number; for perspective cameras only.
    FNumber(f32),
}

/// What a camera is focused on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FocusOn {
    /// What it looks at.
    LookAt,
    /// This far away, along the view.
    Distance(f32),
    /// The plane through this point.
    Point(Vec3),
    /// Whatever is seen in this pixel.
    Pixel([u32; 2]),
}

impl AuthoredLens {
    /// A pinhole that is focused, should it be opened, on what the camera looks at.
    pub const PINHOLE: Self = Self {
        aperture: Aperture::Radius(0.0),
        focus: FocusOn::LookAt,
        blades: 0,
        blade_rotation_degrees: 0.0,
        aperture_ratio: 1.0,
    };
}

impl Default for AuthoredLens {
    fn default() -> Self {
        Self::PINHOLE
    }
}

impl CameraKind {
    /// A pinhole that sees so many degrees from top to bottom.
    pub fn perspective(fov_degrees: f32) -> Self {
        Self::Perspective {
            view: AngleOfView::FovDegrees(fov_degrees),
            sensor_height_mm: SENSOR_HEIGHT_MM,
            lens: AuthoredLens::PINHOLE,
        }
    }

    /// The lens, where there can be one.
    pub fn lens(&self) -> Option<&AuthoredLens> {
        match self {
            Self::Perspective { lens, .. } | Self::Orthographic { lens, .. } => Some(lens),
            Self::Equirectangular => None,
        }
    }

    /// The lens, to be changed.
    pub fn lens_mut(&mut self) -> Option<&mut AuthoredLens> {
        match self {
            Self::Perspective { lens, .. } | Self::Orthographic { lens, .. } => Some(lens),
            Self::Equirectangular => None,
        }
    }
}

impl AuthoredCamera {
    /// A pinhole without a name, upright, that sees `fov_degrees` from top to bottom.
    pub fn perspective(position: Vec3, look_at: Vec3, fov_degrees: f32) -> Self {
        let kind = CameraKind::perspective(fov_degrees);
        Self { name: String::new(), position, look_at, up: Vec3::Y, kind }
    }

    /// The camera of a picture of `size` pixels.
    ///
    /// # Errors
    /// A direction that is none, a focus that lies behind the camera or outside the picture, an
    /// f-number that no lens has. Whether all numbers keep to their ranges is asked by
    /// [`Scene::validate`](rutilant::scene::Scene::validate).
    pub fn camera(&self, size: [u32; 2]) -> Result<Camera, SceneProblem> {
        let pose = self.pose()?;
        Ok(match self.kind {
            CameraKind::Perspective { view, sensor_height_mm, lens } => {
                let fov_y = match view {
                    AngleOfView::FovDegrees(degrees) => degrees.to_radians(),
                    AngleOfView::FocalLengthMm(length) => {
                        2.0 * real::atan2(0.5 * sensor_height_mm, length)
                    }
                };
                let aperture_radius = match lens.aperture {
                    Aperture::Radius(radius) => radius,
                    Aperture::FNumber(f_number) => {
                        let film = 1e-3 * sensor_height_mm;
                        let focal_length = 0.5 * film / real::tan(0.5 * fov_y);
                        let radius = 0.5 * focal_length / f_number;
                        // An angle of view that is none has the first word.
                        if !radius.is_finite() && focal_length.is_finite() {
                            let what = format!("f_number is {f_number:e}, too little for any lens");
                            return Err(problem("f_number", what));
                        }
                        radius
                    }
                };
                let lens = self.lens(&lens, aperture_radius, &pose, size)?;
                Perspective { world_from_camera: pose, fov_y, lens }.into()
            }
            CameraKind::Orthographic { height, lens } => {
                let aperture_radius = match lens.aperture {
                    Aperture::Radius(radius) => radius,
                    Aperture::FNumber(_) => {
                        let what = "an orthographic camera has no f_number: give aperture_radius";
                        return Err(problem("f_number", what));
                    }
                };
                let lens = self.lens(&lens, aperture_radius, &pose, size)?;
                Orthographic { world_from_camera: pose, height, lens }.into()
            }
            CameraKind::Equirectangular => Equirectangular { world_from_camera: pose }.into(),
        })
    }

    /// Where it stands and looks.
    fn pose(&self) -> Result<Transform, SceneProblem> {
        let up = sizable(self.up)
            .ok_or_else(|| problem("up", "it points nowhere: all three numbers are 0"))?;
        Transform::look_at(self.position, self.look_at, up).ok_or_else(|| {
            let what = "the camera has no direction: position and look_at are the same point, or \
                        too far apart";
            problem("look_at", what)
        })
    }

    fn lens(
        &self,
        lens: &AuthoredLens,
        aperture_radius: f32,
        pose: &Transform,
        size: [u32; 2],
    ) -> Result<Lens, SceneProblem> {
        // How far away a point is, along the view.
        let along_view = |point: Vec3| {
            let offset = point - pose.translation();
            offset.dot(pose.vector(Vec3::NEG_Z))
        };
        let focus_distance = match lens.focus {
            FocusOn::Distance(distance) => distance,
            FocusOn::LookAt | FocusOn::Pixel(_) => along_view(self.look_at),
            FocusOn::Point(point) => {
                let distance = along_view(point);
                if distance.is_nan() || distance <= 0.0 {
                    let what = "focus_at lies behind the camera, or beside it";
                    return Err(problem("focus_at", what));
                }
                distance
            }
        };
        let focus_on = match lens.focus {
            FocusOn::Pixel(at) => Some(Lens::place_of_pixel(at, size).ok_or_else(|| {
                let ([x, y], [width, height]) = (at, size);
                let what = format!(
                    "focus_on is {x},{y}, but the picture has {width}x{height} pixels, from 0,0 on"
                );
                problem("focus_on", what)
            })?),
            FocusOn::LookAt | FocusOn::Distance(_) | FocusOn::Point(_) => None,
        };
        let turn = if lens.blades == 0 { 0.0 } else { lens.blade_rotation_degrees };
        Ok(Lens {
            aperture_radius,
            focus_distance,
            focus_on,
            blades: lens.blades,
            blade_rotation: turn.to_radians(),
            aperture_ratio: lens.aperture_ratio,
        })
    }

    /// The same camera with the usual value wherever a number has no meaning: a film without a
    /// focal length or an f-number, a turn without blades. No file can say those.
    #[must_use]
    pub fn meant(mut self) -> Self {
        if let CameraKind::Perspective { view: AngleOfView::FovDegrees(_), sensor_height_mm, lens } =
            &mut self.kind
            && matches!(lens.aperture, Aperture::Radius(_))
        {
            *sensor_height_mm = SENSOR_HEIGHT_MM;
        }
        if let Some(lens) = self.kind.lens_mut()
            && lens.blades == 0
        {
            lens.blade_rotation_degrees = 0.0;
        }
        self
    }

    /// A complete `[camera]` table of the native scene format. What is as usual is left out;
    /// numbers have the fewest digits that read back to the same bits.
    pub fn to_toml(&self) -> String {
        native::table("[camera]", self)
    }
}

/// A direction whose length is a number; `None` for one of no length. One whose squares are no
/// numbers any more is brought to length 1.
pub(crate) fn sizable(direction: Vec3) -> Option<Vec3> {
    if direction.try_normalize().is_some() {
        return Some(direction);
    }
    (direction / direction.abs().max_element()).try_normalize()
}

fn problem(key: &'static str, what: impl Into<String>) -> SceneProblem {
    SceneProblem { place: Place::Camera, key, what: what.into() }
}
