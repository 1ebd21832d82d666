//! Scenes of other people, held against pictures that another renderer made of them.
//!
//! The scenes are transcribed by hand into our own format and ship with this
//! crate; the pictures do not. They are looked for in the folder that the
//! environment variable `RUTILANT_DATA` names.
//!
//! Scenes and pictures: Benedikt Bitterli, "Rendering resources", 2016,
//! <https://benedikt-bitterli.me/resources>, CC0; rendered by Tungsten.

use crate::matrix::render;
use rutilant::Prepared;
use rutilant::image::Image;
use rutilant_formats::{Limits, LoadedScene, ReadOptions, image, parse_native, read_scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene, and the picture that it should give.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// What it is called.
    pub name: &'static str,
    /// The scene in our own format.
    pub scene: &'static str,
    /// The picture, from the data folder.
    pub picture: &'static str,
    /// Samples per pixel that bring our own noise below what is tolerated.
    pub spp: u64,
    /// What is not compared, in pixels: first column and row, width and height.
    pub without: Option<[u32; 4]>,
    /// Whether the two should be the same, but for what the remark says.
    pub same: bool,
    /// What remains different, and why.
    pub remark: &'static str,
}

/// Of veach-mis: it alone is a fifth of the picture's light, on a handful of pixels, so that a mean
/// tells how these were sampled and nothing else.
const SMALLEST_LAMP: Option<[u32; 4]> = Some([440, 120, 40, 40]);

/// All of them.
pub const ALL: &[Reference] = &[
    Reference {
        name: "bitterli-cornell-box",
        scene: include_str!("../scenes/bitterli-cornell-box.toml"),
        picture: "mitsuba/bitterli-cornell-box/TungstenRender.exr",
        spp: 128,
        without: None,
        same: true,
        remark: "The edges of the lamp are a little softer in the reference: its pixel filter is wider than the tent that the scene asks for.",
    },
    Reference {
        name: "bitterli-veach-mis",
        scene: include_str!("../scenes/bitterli-veach-mis.toml"),
        picture: "mitsuba/bitterli-veach-mis/TungstenRender.exr",
        spp: 128,
        without: SMALLEST_LAMP,
        same: true,
        remark: "The reference shows direct light alone. The smallest lamp, which is as bright as its pixels are few, is left out.",
    },
];

/// A scene of pbrt or Mitsuba, read from the data folder as it is, and the picture that it should give.
#[derive(Clone, Copy, Debug)]
pub struct Foreign {
    /// The scene, from the data folder.
    pub scene: &'static str,
    /// The picture, from the data folder.
    pub picture: &'static str,
    /// The longest path in segments, where the picture has others than the scene asks for.
    pub max_depth: Option<u32>,
    /// What is not compared, in pixels: first column and row, width and height.
    pub without: Option<[u32; 4]>,
    /// Why, and what else is known of the difference.
    pub remark: &'static str,
}

/// All of them. That of veach-mis in pbrt is none: its file says copper that reflects all that copper does,
/// not 0.3 of it, and pbrt's facets are those of GGX, not Beckmann's; its picture is 58, 42 and
/// 37 % brighter in direct light, and 62, 46 and 40 % with the four segments that it asks for.
pub const FOREIGN: &[Foreign] = &[
    Foreign {
        scene: "pbrt/bitterli-cornell-box/scene-v4.pbrt",
        picture: "mitsuba/bitterli-cornell-box/TungstenRender.exr",
        max_depth: None,
        without: None,
        remark: "",
    },
    Foreign {
        scene: "mitsuba/bitterli-cornell-box/scene.xml",
        picture: "mitsuba/bitterli-cornell-box/TungstenRender.exr",
        max_depth: None,
        without: None,
        remark: "",
    },
    Foreign {
        scene: "mitsuba/bitterli-veach-mis/scene.xml",
        picture: "mitsuba/bitterli-veach-mis/TungstenRender.exr",
        max_depth: Some(2),
        without: SMALLEST_LAMP,
        remark: "The reference shows direct light alone. With the three segments that the scene asks for, ours is 1.5 % brighter, and up to a third on walls and floor.",
    },
    Foreign {
        scene: "pbrt/bitterli-coffee/scene-v4.pbrt",
        picture: "pbrt/bitterli-coffee/TungstenRender.exr",
        max_depth: None,
        without: Some([200, 600, 360, 200]),
        remark: "The jug's metal band and the neck of its lid lie a hundredth of a millimetre off the glass. Rays of the reference's renderer start farther than that from what they leave, so that they get into those bodies and end there. Ours and Mitsuba's agree, to 0.2 % in red, where both bodies are moved half a millimetre off the glass, and there and here ours is 14 % brighter in the jug than the reference, with light that goes along the glass; with something black before both bodies it is 2 % darker.",
    },
];

impl Foreign {
    /// Renders the scene with `spp` samples per pixel and compares it with the picture in `data`, by
    /// the means of squares of `block` pixels a side. `None` where either is absent.
    ///
    /// # Errors
    /// What is wrong with the scene or the picture.
    pub fn measure(
        &self,
        data: &Path,
        spp: u64,
        block: u32,
        threads: usize,
    ) -> Result<Option<Measured>, String> {
        let [scene, picture] = [self.scene, self.picture].map(|name| data.join(name));
        if !scene.exists() || !picture.exists() {
            return Ok(None);
        }
        let mut loaded = read_scene(&scene, &ReadOptions::default()).map_err(|e| e.to_string())?;
        loaded.settings.max_depth = self.max_depth.or(loaded.settings.max_depth);
        let [ours, reference] = both(loaded, &picture, spp, threads, self.without)?;
        Ok(Some(measured(&ours, &reference, block)))
    }
}

/// Our picture of a scene, and that of a file, which must have the same size; both without a window.
fn both(
    loaded: LoadedScene,
    picture: &Path,
    spp: u64,
    threads: usize,
    without: Option<[u32; 4]>,
) -> Result<[Image; 2], String> {
    let reference = image::read(picture, &Limits::default()).map_err(|e| e.to_string())?;
    let LoadedScene { scene, mut settings, .. } = loaded;
    settings.spp = spp;
    let scene = Arc::new(Prepared::new(&scene).map_err(|e| e.to_string())?);
    let ours = render(&scene, settings, threads).map_err(|e| e.to_string())?;
    if [ours.width(), ours.height()] != [reference.width(), reference.height()] {
        return Err(format!("{}: scene and picture have different sizes", picture.display()));
    }
    Ok([ours, reference].map(|image| match without {
        None => image,
        Some(window) => blackened(&image, window),
    }))
}

/// A picture that is black in a window.
fn blackened(image: &Image, [x, y, width, height]: [u32; 4]) -> Image {
    let columns = image.width();
    let within = |i: usize| {
        let (column, row) = (i as u32 % columns, i as u32 / columns);
        (x..x + width).contains(&column) && (y..y + height).contains(&row)
    };
    let pixels = image.rgb().expect("pictures have colour").into_iter().enumerate();
    let pixels: Vec<_> = pixels.map(|(i, p)| if within(i) { [0.0; 3] } else { p }).collect();
    Image::from_rgb(columns, image.height(), &pixels).expect("as many pixels")
}

/// How far a picture of ours is from the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Mean of our picture over that of the reference, per channel.
    pub mean_ratio: [f64; 3],
    /// Mean of (ours − reference)² / (reference² + 0.01), of squares of `block` pixels a side.
    pub relative_mse: f64,
}

impl Measured {
    /// The mean of each channel within 0.5 %, and a relMSE of at most 0.002.
    pub fn agrees(&self) -> bool {
        self.mean_ratio.iter().all(|ratio| (ratio - 1.0).abs() <= 0.005)
            && self.relative_mse <= 0.002
    }
}

/// The folder of other people's scenes and pictures, if there is one.
pub fn data() -> Option<PathBuf> {
    std::env::var_os("RUTILANT_DATA").map(PathBuf::from)
}

impl Reference {
    /// Renders the scene with `spp` samples per pixel and compares it with the picture in `data`,
    /// by the means of squares of `block` pixels a side. `None` where the picture is absent.
    ///
    /// # Errors
    /// What is wrong with the scene or the picture.
    pub fn measure(
        &self,
        data: &Path,
        spp: u64,
        block: u32,
        threads: usize,
    ) -> Result<Option<Measured>, String> {
        let path = data.join(self.picture);
        if !path.exists() {
            return Ok(None);
        }
        let name = format!("{}.toml", self.name);
        let loaded = parse_native(self.scene, name.as_ref(), &ReadOptions::default());
        let loaded = loaded.map_err(|e| e.to_string())?;
        let [ours, reference] = both(loaded, &path, spp, threads, self.without)?;
        Ok(Some(measured(&ours, &reference, block)))
    }
}

fn measured(ours: &Image, reference: &Image, block: u32) -> Measured {
    let (a, b) = (squares(ours, block), squares(reference, block));
    let mean = |squares: &[[f64; 3]], c: usize| squares.iter().map(|s| s[c]).sum::<f64>();
    let both = || a.iter().flatten().zip(b.iter().flatten());
    let sum: f64 = both().map(|(a, b)| (a - b) * (a - b) / (b * b + 0.01)).sum();
    Measured {
        mean_ratio: std::array::from_fn(|c| mean(&a, c) / mean(&b, c)),
        relative_mse: sum / both().count() as f64,
    }
}

/// The mean colours of squares of `side` pixels; what is left over at the right and below is not used.
fn squares(image: &Image, side: u32) -> Vec<[f64; 3]> {
    let pixels = image.rgb().expect("pictures have colour");
    let (columns, rows) = (image.width() / side, image.height() / side);
    let mean = |column: u32, row: u32| {
        let places = (0..side * side).map(|i| (column * side + i % side, row * side + i / side));
        let sum = places.fold([0.0; 3], |sum: [f64; 3], (x, y)| {
            let pixel = pixels[(y * image.width() + x) as usize];
            std::array::from_fn(|c| sum[c] + f64::from(pixel[c]))
        });
        sum.map(|s| s / f64::from(side * side))
    };
    (0..rows).flat_map(|row| (0..columns).map(move |column| mean(column, row))).collect()
}
