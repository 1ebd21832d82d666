//! Cameras, and how pbrt's left-handed worlds come into right-handed ones.
//!
//! pbrt's eye looks along +z with +x to the right, which is a mirror image of ours. A world that is
//! seen by such an eye is mirrored as a whole; one whose camera mirrors it already, as exporters of
//! right-handed programs write them, stays as it is.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed., sections 3.3 and 5.2.

use super::description::{Description, Eye};
use super::film::Film;
use super::lexer::{Place, Texts};
use super::parameters::Parameters;
use crate::camera::{
    AngleOfView, Aperture, AuthoredCamera, AuthoredLens, CameraKind, FocusOn, SENSOR_HEIGHT_MM,
};
use crate::error::{SceneError, SceneErrorKind};
use crate::scene::affine::{Affine, single};
use crate::scene::nearest::nearest;
use crate::scene::notes::Notes;
use crate::shown::shown;
use rutilant::settings::Crop;
use rutilant_geom::{DVec3, real};

const KINDS: [&str; 4] = ["perspective", "orthographic", "spherical", "environment"];

/// Our eye from pbrt's: x to the right, y up, and −z ahead.
pub(super) fn ours_from_theirs(description: &Description) -> Affine {
    let linear = match description.camera.as_ref().map(|eye| &*eye.kind) {
        // The picture of one that sees all around has −x in its middle, and −z to the right of that.
        Some("spherical" | "environment") => [DVec3::Z, DVec3::Y, DVec3::NEG_X],
        Some(_) | None => [DVec3::X, DVec3::Y, DVec3::NEG_Z],
    };
    Affine { linear, translation: DVec3::ZERO }
}

/// The camera of a scene, and the film behind it, whose size and crop follow from what is seen.
pub(super) fn read(
    description: &Description,
    film: &mut Film,
    world: &Affine,
    texts: &Texts,
    notes: &mut Notes,
) -> Result<AuthoredCamera, SceneError> {
    let none = Eye {
        kind: "perspective".to_owned(),
        parameters: Parameters::none("Camera", Place { text: 0, at: 0, line: 1 }),
        map: Affine::IDENTITY,
    };
    let Eye { kind, parameters, map } = description.camera.as_ref().unwrap_or(&none);
    let place = parameters.place;

    // Where it stands.
    let stretched =
        || texts.unsupported(place, "a camera that is stretched or flattened is not made");
    let back = map.inverse().ok_or_else(stretched)?;
    let scale = back.uniform_scale().ok_or_else(stretched)?;
    let turned = ours_from_theirs(description).inverse().unwrap_or(Affine::IDENTITY);
    let pose = *world * back * turned;
    let [_, up, behind] = pose.linear;
    let position = single(pose.translation);
    let direction = single(-behind / scale);
    // Far enough for the direction to be told by the difference of two points.
    let look_at = position + direction * position.abs().max_element().max(1.0);
    if !look_at.is_finite() {
        return Err(stretched());
    }

    // What it sees: the borders of a plane at distance 1.
    let [width, height] = film.size.map(|side| side as f32);
    let aspect = parameters.number_or("frameaspectratio", width / height, texts)?;
    if aspect.is_nan() || aspect <= 0.0 {
        return Err(texts.invalid(
            parameters.place_of("frameaspectratio"),
            format!("frameaspectratio is {aspect}, but must be more than 0"),
        ));
    }
    let usual = match aspect > 1.0 {
        true => [-aspect, aspect, -1.0, 1.0],
        false => [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect],
    };
    let window = parameters.some::<4>("screenwindow", texts)?.unwrap_or(usual);
    let window = Window::of(window, film.size).ok_or_else(|| {
        texts.invalid(
            parameters.place_of("screenwindow"),
            "\"screenwindow\" must be left, right, bottom and top, and hold something",
        )
    })?;

    let lens = |maker: &mut Notes| -> Result<AuthoredLens, SceneError> {
        let radius = parameters.number_or("lensradius", 0.0, texts)?;
        let distance = parameters.number_or("focaldistance", 1e6, texts)?;
        let mut lens = AuthoredLens::PINHOLE;
        if radius > 0.0 {
            if distance.is_nan() || distance <= 0.0 {
                let what = format!("focaldistance is {distance}, but must be more than 0");
                return Err(texts.invalid(parameters.place_of("focaldistance"), what));
            }
            lens.aperture = Aperture::Radius(radius * scale as f32);
            lens.focus = FocusOn::Distance(distance * scale as f32);
        } else if radius < 0.0 {
            maker.say(texts, place, "a lens with a radius below 0 is a pinhole");
        }
        Ok(lens)
    };
    let kind = match &**kind {
        "perspective" => {
            let fov = parameters.number_or("fov", 90.0, texts)?;
            // Older still.
            let fov = match parameters.number("halffov", texts)? {
                Some(half) => 2.0 * half,
                None => fov,
            };
            if !(fov > 0.0 && fov < 180.0) {
                let what = format!("fov is {fov}, but must be more than 0 and less than 180");
                let name = if parameters.get("halffov").is_some() { "halffov" } else { "fov" };
                return Err(texts.invalid(parameters.place_of(name), what));
            }
            let half = real::tan(0.5 * fov.to_radians()) * window.half_height;
            let degrees = (2.0 * real::atan(half)).to_degrees();
            // One that nothing has been done to keeps its digits.
            let degrees = if window.half_height == 1.0 { fov } else { degrees };
            CameraKind::Perspective {
                view: AngleOfView::FovDegrees(degrees),
                sensor_height_mm: SENSOR_HEIGHT_MM,
                lens: lens(notes)?,
            }
        }
        "orthographic" => CameraKind::Orthographic {
            height: 2.0 * window.half_height * scale as f32,
            lens: lens(notes)?,
        },
        "spherical" | "environment" => {
            if kind == "spherical"
                && parameters.text("mapping", texts)?.unwrap_or("equalarea") != "equirectangular"
            {
                let what = "the picture of a camera that sees all around is a latitude-longitude \
                            map, not one of equal area";
                notes.say(texts, place, what);
            }
            CameraKind::Equirectangular
        }
        "realistic" => {
            let what = "Camera \"realistic\" is not made: give a \"perspective\" one with lensradius \
                        and focaldistance";
            return Err(texts.unsupported(place, what));
        }
        other => {
            let kind = SceneErrorKind::Unknown {
                what: "type of cameras",
                name: shown(other),
                closest: nearest(other, KINDS).map(str::to_owned),
            };
            return Err(texts.error(place, kind));
        }
    };
    if !matches!(kind, CameraKind::Equirectangular) {
        if window.stretch > 1.001 {
            let what = "pixels are squares: the window that the camera sees through is stretched \
                        otherwise";
            notes.say(texts, place, what);
        }
        window.expose(film);
    }
    parameters.tell_unused(texts, notes);
    Ok(AuthoredCamera { name: String::new(), position, look_at, up: single(up / scale), kind })
}

/// The window that an eye sees through, on a plane at distance 1.
struct Window {
    /// Half of the height of a window around the view's middle that holds all of it.
    half_height: f32,
    /// The picture of that one, and which part of it is seen.
    size: [u32; 2],
    offset: [u32; 2],
    /// How much longer one side of a pixel is than the other.
    stretch: f32,
}

impl Window {
    fn of([left, right, bottom, top]: [f32; 4], size: [u32; 2]) -> Option<Self> {
        let (wide, high) = (right - left, top - bottom);
        if !(wide > 0.0 && high > 0.0 && wide.is_finite() && high.is_finite()) {
            return None;
        }
        let pixel = [wide / size[0] as f32, high / size[1] as f32];
        let stretch = (pixel[0] / pixel[1]).max(pixel[1] / pixel[0]);
        // Pixels from the middle of the view to each border; the border must lie on one of them.
        let around = |low: f32, high: f32, pixel: f32, side: u32| {
            let before = (2.0 * -low / pixel).round() as i64;
            let behind = 2 * i64::from(side) - before;
            let whole = before.max(behind).clamp(1, 1 << 20);
            let offset = ((whole - before) / 2).max(0);
            if (low + high).abs() <= 1e-4 * (high - low) {
                (side, 0)
            } else {
                (whole as u32, offset as u32)
            }
        };
        let (width, x) = around(left, right, pixel[0], size[0]);
        // From the top on.
        let (height, y) = around(-top, -bottom, pixel[1], size[1]);
        let half_height =
            if y == 0 && height == size[1] { 0.5 * high } else { 0.5 * height as f32 * pixel[1] };
        Some(Self { half_height, size: [width, height], offset: [x, y], stretch })
    }

    /// Lets the film see what the window shows.
    fn expose(&self, film: &mut Film) {
        if self.size == film.size {
            return;
        }
        let [width, height] = film.size;
        let crop = film.crop.unwrap_or(Crop { x: 0, y: 0, width, height });
        let [x, y] = self.offset;
        film.crop = Some(Crop { x: crop.x + x, y: crop.y + y, ..crop });
        film.size = self.size;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A window to one side of the middle is a part of one that is twice as large around it; one
    /// around the middle is itself.
    #[test]
    fn windows_beside_the_middle_are_crops() {
        let mut film = Film { size: [100, 50], crop: None, exposure: 1.0 };
        let window = Window::of([-2.0, 2.0, -1.0, 1.0], film.size).expect("a window");
        window.expose(&mut film);
        assert_eq!((film.size, film.crop, window.half_height), ([100, 50], None, 1.0));
        let window = Window::of([0.0, 2.0, -1.0, 0.0], film.size).expect("a window");
        window.expose(&mut film);
        assert_eq!(film.size, [200, 100]);
        assert_eq!(film.crop, Some(Crop { x: 100, y: 50, width: 100, height: 50 }));
        assert_eq!(window.half_height, 1.0);
        assert!(Window::of([1.0, 1.0, 0.0, 1.0], [2, 2]).is_none());
    }
}
