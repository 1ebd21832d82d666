//! A scene file changed on disk while it was being edited: what counts?
//!
//! What the file changed counts. What it left as it was stays as the window has
//! it, so that one can look around while one writes. Materials are told apart
//! by their names.

use rutilant::display::Display;
use rutilant::material::Material;
use rutilant::settings::Settings;
use rutilant_formats::Look;
use rutilant_formats::camera::AuthoredCamera;

/// The look `mine`, which began as `before`, on top of the file's new look `theirs`; `cameras` are those
/// that the file had and has.
pub(crate) fn merged(
    before: &Look,
    mine: &Look,
    theirs: &Look,
    cameras: [&[AuthoredCamera]; 2],
) -> Look {
    fn pick<T: PartialEq + Clone>(before: &T, mine: &T, theirs: &T) -> T {
        if before == theirs { mine.clone() } else { theirs.clone() }
    }
    let all = &theirs.materials;
    let materials = all.iter().enumerate().map(|(index, theirs)| {
        // Names may repeat, and parts of mixes have none: the first goes with the first.
        let before_it = |m: &&Material| m.name == theirs.name;
        let number = all[..index].iter().filter(before_it).count();
        let named = |all: &[Material]| all.iter().filter(before_it).nth(number).cloned();
        match (named(&before.materials), named(&mine.materials)) {
            // A mix names others by number, which may have moved.
            (Some(before), Some(mine)) if before == *theirs && !is_mix(&mine) => mine,
            _ => theirs.clone(),
        }
    });
    // Images are numbered anew as well; a sky of the window's own is none of the file's.
    // One looks through the camera that one has chosen as long as there is one of its name.
    let pose = |camera: &AuthoredCamera| (camera.position, camera.look_at, camera.up);
    let m = &mine.camera;
    let [b, t] = cameras.map(|all| all.iter().find(|camera| camera.name == m.name));
    let camera = match (b, t) {
        (Some(b), Some(t)) => {
            let (position, look_at, up) = pick(&pose(b), &pose(m), &pose(t));
            let kind = pick(&b.kind, &m.kind, &t.kind);
            AuthoredCamera { name: m.name.clone(), position, look_at, up, kind }
        }
        _ => theirs.camera.clone(),
    };
    Look {
        camera,
        environment: pick(&before.environment, &mine.environment, &theirs.environment),
        materials: materials.collect(),
        lights: pick(&before.lights, &mine.lights, &theirs.lights),
        settings: changed_over(&before.settings, &theirs.settings, &mine.settings),
        display: Display {
            exposure: pick(
                &before.display.exposure,
                &mine.display.exposure,
                &theirs.display.exposure,
            ),
            curve: pick(&before.display.curve, &mine.display.curve, &theirs.display.curve),
        },
    }
}

/// Each setting as in `changed` where that differs from `base`, and else as in `other`.
pub(crate) fn changed_over(base: &Settings, changed: &Settings, other: &Settings) -> Settings {
    macro_rules! each {
        ($($field:ident),*) => {
            Settings {
                $($field: if changed.$field == base.$field {
                    other.$field.clone()
                } else {
                    changed.$field.clone()
                }),*
            }
        };
    }
    each!(
        size,
        crop,
        spp,
        planned_spp,
        max_depth,
        integrator,
        sampler,
        seed,
        filter,
        strategy,
        heuristic,
        roulette,
        light_selection,
        caustics,
        layers
    )
}

fn is_mix(material: &Material) -> bool {
    matches!(material.kind, rutilant::material::MaterialKind::Mix(_))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rutilant::color::Rgb;
    use rutilant::material::Matte;
    use rutilant_formats::camera::AuthoredCamera;
    use rutilant_geom::Vec3;

    fn look(albedo: f32, spp: u64, x: f32) -> Look {
        let material = |name: &str| Material::from(Matte::new(Rgb::grey(albedo))).named(name);
        Look {
            camera: AuthoredCamera::perspective(Vec3::X * x, Vec3::Z, 40.0),
            environment: None,
            materials: vec![material("a"), material("b")],
            lights: Vec::new(),
            settings: rutilant::settings::Settings { spp, ..Default::default() },
            display: Default::default(),
        }
    }

    /// Where the file has but the camera that is looked through.
    fn with_own_cameras(before: &Look, mine: &Look, theirs: &Look) -> Look {
        let cameras = [before, theirs].map(|look| std::slice::from_ref(&look.camera));
        merged(before, mine, theirs, cameras)
    }

    /// A camera that was chosen stays so, takes what the file changed of it, and nothing of others.
    #[test]
    fn cameras_are_told_by_their_names() {
        let camera = |name: &str, x: f32, fov: f32| AuthoredCamera {
            name: name.into(),
            ..AuthoredCamera::perspective(Vec3::X * x, Vec3::Z, fov)
        };
        let before = look(0.5, 16, 1.0);
        let mine = Look { camera: camera("b", 7.0, 40.0), ..before.clone() };
        let old = [camera("a", 1.0, 40.0), camera("b", 2.0, 40.0)];
        let new = [camera("a", 5.0, 30.0), camera("b", 2.0, 20.0)];
        let all = merged(&before, &mine, &before, [&old, &new]);
        assert_eq!(all.camera, camera("b", 7.0, 20.0));
        let theirs = Look { camera: new[0].clone(), ..before.clone() };
        assert_eq!(merged(&before, &mine, &theirs, [&old, &new[..1]]).camera, new[0]);
    }

    /// Each part comes from the side that changed it, and from the file where both did.
    #[test]
    fn the_file_counts_where_it_changed() {
        let before = look(0.5, 16, 1.0);
        let mut mine = look(0.5, 16, 2.0);
        mine.materials[0] = look(0.7, 0, 0.0).materials[0].clone();
        let mut theirs = look(0.5, 99, 1.0);
        theirs.materials[1] = look(0.9, 0, 0.0).materials[1].clone();
        let all = with_own_cameras(&before, &mine, &theirs);
        assert_eq!(all.camera, mine.camera);
        assert_eq!(all.settings, theirs.settings);
        mine.settings.size = [5, 4];
        let both = with_own_cameras(&before, &mine, &theirs).settings;
        assert_eq!((both.size, both.spp), ([5, 4], 99));
        assert_eq!(all.materials[0], mine.materials[0]);
        assert_eq!(all.materials[1], theirs.materials[1]);

        // The angle of view from the file, the place from the window.
        theirs.camera.kind = AuthoredCamera::perspective(Vec3::X, Vec3::Z, 20.0).kind;
        theirs.display.exposure = 2.0;
        mine.display.curve = rutilant::display::Curve::Agx;
        let all = with_own_cameras(&before, &mine, &theirs);
        assert_eq!(
            (all.camera.position, all.camera.kind),
            (mine.camera.position, theirs.camera.kind)
        );
        assert_eq!((all.display.exposure, all.display.curve), (2.0, mine.display.curve));
        theirs.camera.position.x = 7.0;
        let all = with_own_cameras(&before, &mine, &theirs);
        assert_eq!(all.camera.position, theirs.camera.position);
        theirs.materials.remove(0);
        assert_eq!(with_own_cameras(&before, &mine, &theirs).materials, theirs.materials);
        assert_eq!(with_own_cameras(&before, &mine, &before), mine);
    }

    /// Materials without a name, as parts of mixes are, are told apart by their order.
    #[test]
    fn equal_names_keep_their_order() {
        let nameless = |albedo: f32| Material::from(Matte::new(Rgb::grey(albedo)));
        let mut before = look(0.5, 16, 1.0);
        before.materials = vec![nameless(0.1), nameless(0.2)];
        let mut mine = before.clone();
        mine.materials[1] = nameless(0.7);
        let theirs = before.clone();
        assert_eq!(with_own_cameras(&before, &mine, &theirs).materials, mine.materials);
    }
}
