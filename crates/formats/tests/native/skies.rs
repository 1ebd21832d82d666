//! Skies that whoever reads a scene asks for, instead of its own.

use crate::HEAD;
use rutilant::color::Rgb;
use rutilant::light::{Environment, Projection};
use rutilant::scene::ImageId;
use rutilant_formats::{LoadedScene, ReadOptions, SceneError, SkyChoice, read_scene};
use std::path::Path;

/// A picture of the same light everywhere.
fn picture(file: &Path, size: [usize; 2]) {
    let [width, height] = size;
    let mut bytes = format!("Pf\n{width} {height}\n-1\n").into_bytes();
    bytes.extend((0..width * height).flat_map(|_| 2.0_f32.to_le_bytes()));
    std::fs::write(file, bytes).expect("a file");
}

fn under(folder: &Path, sky: &SkyChoice) -> Result<LoadedScene, SceneError> {
    let file = folder.join("scene.toml");
    let text = format!("{HEAD}[environment]\nimage = \"own.pfm\"\nrotation_degrees = 30\n");
    std::fs::write(&file, text).expect("a file");
    picture(&folder.join("own.pfm"), [4, 2]);
    read_scene(&file, &ReadOptions { sky, ..ReadOptions::default() })
}

/// Each choice takes the place of the scene's own sky, without its turn; a picture is counted
/// after those that the scene has, and its proportions tell how directions lie on it.
#[test]
fn another_sky_takes_the_place_of_the_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let sky = |choice: SkyChoice| under(at, &choice).map(|loaded| loaded.scene.environment);
    let own = Environment { rotation: 30.0_f32.to_radians(), ..Environment::image(ImageId(0)) };
    assert_eq!(sky(SkyChoice::Own).expect("a scene"), Some(own));
    assert_eq!(sky(SkyChoice::None).expect("a scene"), None);
    let blue = Rgb([0.1, 0.2, 0.7]);
    assert_eq!(sky(SkyChoice::Even(blue)).expect("a scene"), Some(Environment::constant(blue)));

    for (size, projection) in [
        ([8, 4], Projection::Equirectangular),
        ([5, 5], Projection::Octahedral),
        ([8, 6], Projection::Cube),
        ([6, 8], Projection::Cube),
        ([7, 3], Projection::Equirectangular),
    ] {
        picture(&at.join("other.pfm"), size);
        let loaded = under(at, &SkyChoice::Picture(at.join("other.pfm"))).expect("a scene");
        assert_eq!(loaded.scene.environment, Some(Environment::map(ImageId(1), projection)));
        assert_eq!(loaded.image_names, ["own.pfm", "other.pfm"]);
        let [width, height] = size.map(|side| side as u32);
        let image = &loaded.scene.images[1];
        assert_eq!((image.width(), image.height()), (width, height));
        let files: Vec<_> = loaded.files.iter().filter_map(|file| file.file_name()).collect();
        assert_eq!(files, ["own.pfm", "other.pfm"]);
    }
}

/// What is wrong with a sky is said of the sky.
#[test]
fn bad_skies_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let missing = at.join("missing.exr");
    let error = under(at, &SkyChoice::Picture(missing.clone())).expect_err("no file").to_string();
    assert!(error.starts_with(&format!("{}: ", missing.display())), "{error}");
    let error = under(at, &SkyChoice::Even(Rgb([1.0, -1.0, 0.0]))).expect_err("negative");
    let said =
        format!("{}: the sky that is asked for: color is -1", at.join("scene.toml").display());
    assert!(error.to_string().starts_with(&said), "{error}");
    assert!(under(at, &SkyChoice::Even(Rgb::grey(f32::NAN))).is_err());
}
