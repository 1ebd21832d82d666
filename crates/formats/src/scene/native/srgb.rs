//! Colours as the web writes them.

use rutilant::color::Rgb;

/// The scene-linear colour of `#rrggbb`, two hexadecimal digits for each channel of sRGB.
pub(super) fn from_hex(text: &str) -> Option<Rgb> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii())?;
    let channel = |i: usize| {
        let digits = &digits[2 * i..2 * i + 2];
        // `from_str_radix` would take a sign as well.
        let plain = digits.bytes().all(|b| b.is_ascii_hexdigit());
        u8::from_str_radix(digits, 16).ok().filter(|_| plain).map(to_linear)
    };
    Some(Rgb::new(channel(0)?, channel(1)?, channel(2)?))
}

/// The light behind a byte of sRGB. Source: IEC 61966-2-1.
///
/// The power 2.4 is taken by products and a fifth root, which have the same bits on every
/// machine, unlike the standard library's `powf`.
fn to_linear(byte: u8) -> f32 {
    let encoded = f64::from(byte) / 255.0;
    if encoded <= 0.04045 {
        (encoded / 12.92) as f32
    } else {
        let base = (encoded + 0.055) / 1.055;
        let square = base * base;
        (square * fifth_root(square)) as f32
    }
}

/// Newton's method from above; `a` from 0.008 to 1 needs fewer than these steps.
fn fifth_root(a: f64) -> f64 {
    (0..16).fold(1.0, |y: f64, _| (4.0 * y + a / (y * y * y * y)) / 5.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The standard's own formula, to the last bit of single precision but one.
    #[test]
    fn bytes_decode_as_the_standard_says() {
        for byte in 0..=255_u8 {
            let c = f64::from(byte) / 255.0;
            let exact = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
            assert!((f64::from(to_linear(byte)) - exact).abs() <= 6e-8 * exact, "{byte}");
        }
        assert_eq!((to_linear(0), to_linear(255)), (0.0, 1.0));
    }

    /// Only six hexadecimal digits are a colour.
    #[test]
    fn other_texts_are_no_colors() {
        assert_eq!(from_hex("#ffFF00"), Some(Rgb::new(1.0, 1.0, 0.0)));
        for text in ["", "#", "#fff", "#fffffff", "ffffff", "#gg0000", "#+f+f+f", "#é0000", "red"]
        {
            assert_eq!(from_hex(text), None, "{text}");
        }
    }
}
