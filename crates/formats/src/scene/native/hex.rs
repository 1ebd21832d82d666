//! Colours as the web writes them.

use rutilant::color::Rgb;
use rutilant::display::linear_from_srgb;

/// The scene-linear colour of `#rrggbb`, two hexadecimal digits for each channel of sRGB.
pub(super) fn color(text: &str) -> Option<Rgb> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii())?;
    let channel = |i: usize| {
        let digits = &digits[2 * i..2 * i + 2];
        // `from_str_radix` would take a sign as well.
        let plain = digits.bytes().all(|b| b.is_ascii_hexdigit());
        let code = u8::from_str_radix(digits, 16).ok().filter(|_| plain)?;
        Some(linear_from_srgb(f64::from(code) / 255.0) as f32)
    };
    Some(Rgb::new(channel(0)?, channel(1)?, channel(2)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Only six hexadecimal digits are a colour.
    #[test]
    fn other_texts_are_no_colors() {
        assert_eq!(color("#ffFF00"), Some(Rgb::new(1.0, 1.0, 0.0)));
        for text in ["", "#", "#fff", "#fffffff", "ffffff", "#gg0000", "#+f+f+f", "#é0000", "red"]
        {
            assert_eq!(color(text), None, "{text}");
        }
    }
}
