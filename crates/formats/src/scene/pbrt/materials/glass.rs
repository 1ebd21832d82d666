//! Clear borders, and surfaces that are not there.

use crate::scene::pbrt::parameters::Parameters;
use crate::scene::pbrt::scene::Maker;
use crate::shown::shown;
use rutilant::material::{
    Absorption, Dielectric, MAX_IOR, MOST_ROUGH_RATIO, Material, MaterialKind, Medium,
    most_rough_dispersion,
};

impl Maker<'_> {
    pub(super) fn glass(
        &mut self,
        ior: f32,
        dispersion: f32,
        roughness: f32,
        [inside, outside]: [&str; 2],
        parameters: &Parameters,
    ) -> Material {
        let mut medium =
            |ior: f32, name: &str| Medium { ior, absorption: self.absorption(name, parameters) };
        let mut made = Dielectric::new(ior);
        if ior >= 1.0 {
            made.interior = medium(ior.min(MAX_IOR), inside);
            made.exterior = medium(1.0, outside);
        } else {
            made.interior = medium(1.0, inside);
            made.exterior = medium((1.0 / ior).min(MAX_IOR), outside);
        }
        let ratio = made.interior.ior.max(made.exterior.ior);
        if roughness > 0.0 && ratio > MOST_ROUGH_RATIO {
            let what = format!(
                "{} is smooth: rough glass has an index of refraction up to {MOST_ROUGH_RATIO}",
                parameters.of
            );
            self.note(parameters.place, what);
        } else {
            made.roughness = roughness;
        }
        let most = if made.roughness > 0.0 { most_rough_dispersion(ratio) } else { f32::MAX };
        made.dispersion = dispersion.min(most);
        made.into()
    }

    /// A surface that is not there, but may be the border of what absorbs.
    pub(super) fn nothing(&mut self, media: [&str; 2], parameters: &Parameters) -> Material {
        let [inside, outside] = media.map(|name| self.absorption(name, parameters));
        if inside == Absorption::None && outside == Absorption::None {
            return Material::new(MaterialKind::Null);
        }
        Dielectric {
            interior: Medium { ior: 1.0, absorption: inside },
            exterior: Medium { ior: 1.0, absorption: outside },
            ..Dielectric::new(1.0)
        }
        .into()
    }

    pub(super) fn absorption(&mut self, medium: &str, parameters: &Parameters) -> Absorption {
        if medium.is_empty() {
            return Absorption::None;
        }
        match self.media.get(medium) {
            Some(absorption) => *absorption,
            None => {
                let what = format!("there is no medium \"{}\": nothing stands in", shown(medium));
                self.note(parameters.place, what);
                Absorption::None
            }
        }
    }
}
