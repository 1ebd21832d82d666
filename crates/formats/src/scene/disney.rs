//! What materials of Disney's in other renderers have in common here.

use rutilant::color::Rgb;
use rutilant::material::Principled;

/// Clear bodies take the root of their colour: Disney's materials tint light by the colour once on its
/// way through, half of it at each border, where a [`Principled`] one tints it at each.
///
/// What is matte or metal as well, or whose colour varies, keeps its colour; what to say of it then.
///
/// Source: Burley, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering", in
/// *Physically Based Shading in Theory and Practice*, SIGGRAPH course, 2015.
pub(crate) fn tint_once(layers: &mut Principled) -> Option<&'static str> {
    let is_tinted = layers.base_color != Rgb::WHITE || layers.textures.base_color.is_some();
    if !layers.has_inside() || layers.transmission == 0.0 || !is_tinted {
        return None;
    }
    let of = &layers.textures;
    let is_clear = layers.transmission == 1.0 && of.transmission.is_none();
    let is_metal = layers.metallic > 0.0;
    if is_clear && !is_metal && of.base_color.is_none() && !of.vertex_colors {
        layers.base_color = Rgb(layers.base_color.0.map(f32::sqrt));
        return None;
    }
    Some("what is clear in part, or in a colour that varies, is tinted at both of its borders")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Through two borders goes what the colour says; what is matte as well keeps its colour, and
    /// thin walls have one border.
    #[test]
    fn two_borders_are_one_tint() {
        let base_color = Rgb::new(0.25, 0.81, 1.0);
        let glass = Principled { base_color, transmission: 1.0, ..Principled::default() };
        let mut clear = glass;
        assert_eq!(tint_once(&mut clear), None);
        assert_eq!(clear.base_color, Rgb::new(0.5, 0.9, 1.0));
        let mut half = Principled { transmission: 0.5, ..glass };
        assert!(tint_once(&mut half).is_some() && half.base_color == base_color);
        let mut thin = Principled { thin_walled: true, ..glass };
        assert!(tint_once(&mut thin).is_none() && thin.base_color == base_color);
    }
}
