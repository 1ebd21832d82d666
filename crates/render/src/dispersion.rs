//! Dispersion: what bends blue light more than red, so that a prism makes a rainbow.
//!
//! White light is a sum of bands of the spectrum, each of which is a colour. Where a path first
//! meets something that bends them differently it takes one of them, by chance and as often as it
//! matters to the eye, and keeps it: from there on it is worth that colour over the chance of it.
//! On average it is worth white, and nothing is approximated but the number of bands. Paths that
//! meet nothing of the kind stay white, at no cost.
//!
//! Bands are the same along a path from the camera and along one from a light, and each is chosen
//! as often by both: their densities compare as those of white paths do.
//!
//! Sources: the index by Cauchy's equation as in glTF's `KHR_materials_dispersion`; the colours of
//! bands by [`color_matching`].

use crate::color::{Spectrum, color_matching};

/// How many bands there are: enough for a rainbow without steps.
pub(crate) const BANDS: usize = 15;

/// Where the first begins, and how wide each is, in nanometres: all of them run from 400 to 700, beyond
/// which the eye sees less than a half per cent of what it does in the middle (ȳ of CIE 1931: 0.0004 at
/// 400 nm and 0.0041 at 700).
const FIRST_NM: f32 = 400.0;
const WIDTH_NM: f32 = 20.0;

/// 1 / (λF⁻² − λC⁻²) in nm², between the Fraunhofer lines F and C at 486.13 and 656.27 nm, as
/// `KHR_materials_dispersion` rounds it.
const BETWEEN_F_AND_C: f32 = 523_655.0;

/// That over λd², for the yellow line d at 587.56 nm, as `KHR_materials_dispersion` rounds it.
const AT_YELLOW: f32 = 1.5168;

/// The index of refraction of a medium for light of a wavelength in nanometres, where `ior` is that
/// for yellow light (587.6 nm) and `dispersion` 20 over the Abbe number; at least 1.
pub(crate) fn index(ior: f32, dispersion: f32, wavelength_nm: f32) -> f32 {
    // Cauchy's equation, n = A + B / λ². The Abbe number V is (n(d) − 1) / (n(F) − n(C)), so B is
    // (n(d) − 1) / V over λF⁻² − λC⁻², and A is what makes it `ior` at the line d.
    let part = BETWEEN_F_AND_C / (wavelength_nm * wavelength_nm) - AT_YELLOW;
    (ior + (ior - 1.0) * (dispersion / 20.0) * part).max(1.0)
}

/// The largest index of refraction of any band.
pub(crate) fn largest_index(ior: f32, dispersion: f32) -> f32 {
    if dispersion == 0.0 { ior } else { index(ior, dispersion, wavelength_nm(0)).max(ior) }
}

/// The most that a medium of this index may disperse for its largest index to be `largest`.
pub(crate) fn most_dispersion(ior: f32, largest: f32) -> f32 {
    let grows = index(2.0, 20.0, wavelength_nm(0)) - 2.0;
    if ior > 1.0 { (20.0 * (largest - ior) / ((ior - 1.0) * grows)).max(0.0) } else { f32::MAX }
}

/// The middle of a band.
fn wavelength_nm(band: usize) -> f32 {
    FIRST_NM + WIDTH_NM * (band as f32 + 0.5)
}

/// The bands of the spectrum.
#[derive(Clone, Debug)]
pub(crate) struct Bands([Band; BANDS]);

/// One of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    /// Its middle.
    pub(crate) wavelength_nm: f32,
    /// How often it is chosen.
    pmf: f32,
    /// Its colour over that. All channels together are 3, so that none exceeds that.
    pub(crate) worth: Spectrum,
}

impl Bands {
    /// No band is worth more than this in any channel.
    pub(crate) const MOST_WORTH: f32 = 3.0;

    pub(crate) fn new() -> Self {
        // The part that each band has in each channel.
        let parts: [Spectrum; BANDS] = std::array::from_fn(|i| seen_as(wavelength_nm(i)));
        let all = parts.iter().fold(Spectrum::BLACK, |sum, part| sum + *part);
        Self(std::array::from_fn(|i| {
            let [r, g, b] = parts[i].channels();
            let [all_r, all_g, all_b] = all.channels();
            let part = Spectrum::from([r / all_r, g / all_g, b / all_b]);
            let pmf = part.channels().iter().sum::<f32>() / 3.0;
            Band { wavelength_nm: wavelength_nm(i), pmf, worth: part / pmf }
        }))
    }

    pub(crate) fn get(&self, number: u8) -> &Band {
        &self.0[(number as usize).min(BANDS - 1)]
    }

    /// The number of the band that `u` in [0, 1) chooses.
    pub(crate) fn choose(&self, mut u: f32) -> u8 {
        for (number, band) in (0..).zip(&self.0) {
            if u < band.pmf {
                return number;
            }
            u -= band.pmf;
        }
        BANDS as u8 - 1
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Band> {
        self.0.iter()
    }
}

/// How pure light of a wavelength looks, in linear sRGB, without what no screen can show.
fn seen_as(wavelength_nm: f32) -> Spectrum {
    let [x, y, z] = color_matching(wavelength_nm);
    // IEC 61966-2-1.
    let rgb = [
        3.2406 * x - 1.5372 * y - 0.4986 * z,
        -0.9689 * x + 1.8758 * y + 0.0415 * z,
        0.0557 * x - 0.2040 * y + 1.0570 * z,
    ];
    Spectrum::from(rgb.map(|c| c.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All bands together are white, each is chosen as often as it says, and they have the colours of
    /// a rainbow in its order.
    #[test]
    fn bands_are_white_together() {
        let bands = Bands::new();
        let white = bands.iter().fold(Spectrum::BLACK, |sum, b| sum + b.worth * b.pmf);
        assert!(white.channels().iter().all(|c| (c - 1.0).abs() < 1e-5), "{white:?}");
        const DRAWN: u32 = 1 << 16;
        let mut counts = [0_u32; BANDS];
        for i in 0..DRAWN {
            counts[bands.choose(i as f32 / DRAWN as f32) as usize] += 1;
        }
        for (band, count) in bands.iter().zip(counts) {
            assert!((band.pmf - count as f32 / DRAWN as f32).abs() < 1e-4, "{band:?} {count}");
            let [r, g, b] = band.worth.channels();
            assert!((r + g + b - 3.0).abs() < 1e-4 && r.max(g).max(b) <= Bands::MOST_WORTH + 1e-4);
            match band.wavelength_nm {
                nm if nm < 480.0 => assert!(b > r && b > g, "{band:?}"),
                nm if nm > 600.0 => assert!(r > 2.6, "{band:?}"),
                nm if (505.0..560.0).contains(&nm) => assert!(g > 1.8, "{band:?}"),
                _ => {}
            }
        }
        assert_eq!(bands.choose(1.0), BANDS as u8 - 1);
    }

    /// Between the lines F and C the index changes by what the Abbe number says, and at the line d it
    /// is what is written: dense flint glass, SF11, of the index 1.7847 and the Abbe number 25.68.
    #[test]
    fn indices_follow_the_abbe_number() {
        let [f, d, c] = [486.13, 587.56, 656.27].map(|nm| index(1.784_7, 20.0 / 25.68, nm));
        assert!((d - 1.784_7).abs() < 1e-4, "{d}");
        assert!(((d - 1.0) / (f - c) - 25.68).abs() < 0.05, "{f} {c}");
        // What its maker's catalogue says at both lines, to what two terms of Cauchy can.
        assert!((f - 1.806_5).abs() < 2e-3 && (c - 1.775_9).abs() < 2e-3, "{f} {c}");
        assert!((largest_index(1.5, most_dispersion(1.5, 2.5)) - 2.5).abs() < 1e-4);
    }
}
