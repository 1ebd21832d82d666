//! Spectra that scenes tell wavelength by wavelength, as the three numbers that are traced.
//!
//! What surfaces reflect becomes what an eye sees of it in daylight (D65), so that a spectrum which
//! is the same everywhere is a grey; what lamps give becomes the colour of its light. Metals keep the
//! colour that they have at normal incidence. Colours that lie outside of sRGB come to its border.
//!
//! Not for fluorescent lamps on strange pigments: two spectra of one colour are the same here.
//!
//! Sources: Wyman, Sloan and Shirley, "Simple Analytic Approximations to the CIE XYZ Color Matching
//! Functions", JCGT 2(2), 2013, by [`color_matching`]; IEC 61966-2-1; Planck's law; illuminants by
//! CIE 15:2004.

use rutilant::color::{Rgb, Spectrum, color_matching};
use rutilant::material::Metal;
use rutilant_geom::real;
use std::sync::LazyLock;

/// A value at some wavelengths, straight in between, and 0 before the first and behind the last.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sampled {
    /// Wavelengths in nanometres, in ascending order, each with its value. Never empty.
    points: Vec<(f32, f32)>,
}

/// The wavelengths that are looked at, in nanometres: the eye sees next to nothing beyond them.
const VISIBLE_NM: std::ops::RangeInclusive<u16> = 380..=780;

/// Daylight from 380 to 780 nm in steps of 20 (CIE standard illuminant D65).
const D65: [f32; 21] = [
    49.98, 82.75, 93.43, 104.86, 117.81, 115.92, 109.35, 104.79, 104.41, 100.0, 95.79, 90.01,
    87.70, 83.70, 80.21, 78.28, 71.61, 61.60, 75.09, 46.42, 63.38,
];

/// What linear sRGB's channels are sensitive to, at each of the visible wavelengths.
struct Observer {
    /// For light as it is: a flat spectrum of 1 has the luminance 1, and daylight is grey.
    light: Vec<[f64; 3]>,
    /// For surfaces in daylight: each channel adds up to 1.
    surfaces: Vec<[f64; 3]>,
    /// The same without what counts negatively: for numbers that are no colours.
    numbers: Vec<[f64; 3]>,
}

static OBSERVER: LazyLock<Observer> = LazyLock::new(|| {
    let seen: Vec<([f64; 3], f64)> =
        VISIBLE_NM.map(|nm| (sensitivity(f32::from(nm)), daylight(f32::from(nm)))).collect();
    let total = |of: &dyn Fn([f64; 3]) -> f64, lit: bool| -> f64 {
        seen.iter().map(|(s, d)| of(*s) * if lit { *d } else { 1.0 }).sum()
    };
    // The fit's white is not quite that of the observer: daylight is made grey.
    let luminance = |s: [f64; 3]| 0.212_671 * s[0] + 0.715_160 * s[1] + 0.072_169 * s[2];
    let grey: [f64; 3] = std::array::from_fn(|i| total(&luminance, true) / total(&|s| s[i], true));
    let balanced = |s: [f64; 3]| std::array::from_fn::<f64, 3, _>(|i| s[i] * grey[i]);
    let flat = total(&|s| luminance(balanced(s)), false);
    let sums: [f64; 3] = std::array::from_fn(|i| total(&|s| s[i], true));
    let positive: [f64; 3] = std::array::from_fn(|i| total(&|s| s[i].max(0.0), true));
    let each = |make: &dyn Fn([f64; 3], f64, usize) -> f64| {
        seen.iter().map(|&(s, d)| std::array::from_fn(|i| make(s, d, i))).collect()
    };
    Observer {
        light: each(&|s, _, i| balanced(s)[i] / flat),
        surfaces: each(&|s, d, i| s[i] * d / sums[i]),
        numbers: each(&|s, d, i| s[i].max(0.0) * d / positive[i]),
    }
});

/// The channels of linear sRGB for pure light of a wavelength; negative where no screen can show it.
fn sensitivity(nm: f32) -> [f64; 3] {
    srgb_from_xyz(color_matching(nm).map(f64::from))
}

/// Linear sRGB, by IEC 61966-2-1.
fn srgb_from_xyz([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ]
}

/// Linear sRGB of a colour in CIE XYZ; not below 0.
pub(crate) fn rgb_from_xyz(xyz: [f32; 3]) -> Rgb {
    Rgb(srgb_from_xyz(xyz.map(f64::from)).map(|c| c.max(0.0) as f32))
}

fn daylight(nm: f32) -> f64 {
    let x = (nm - 380.0) / 20.0;
    let i = (x as usize).min(D65.len() - 2);
    f64::from(D65[i] + (D65[i + 1] - D65[i]) * (x - i as f32))
}

impl Sampled {
    /// A value at each wavelength in nanometres. `None` where there are none, where one is no finite
    /// number, or where wavelengths do not ascend.
    pub(crate) fn new(points: Vec<(f32, f32)>) -> Option<Self> {
        let finite = points.iter().all(|(nm, value)| nm.is_finite() && value.is_finite());
        let ascending = points.windows(2).all(|pair| pair[0].0 < pair[1].0);
        (!points.is_empty() && finite && ascending).then_some(Self { points })
    }

    /// Pairs of numbers in the text of a file, with comments behind `#`: how pbrt and Mitsuba both
    /// keep measured spectra. What is wrong with it, in words, else.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut numbers = Vec::new();
        for (line, text) in (1_usize..).zip(text.lines()) {
            let text = text.split('#').next().unwrap_or_default();
            let words = text.split(|c: char| c.is_whitespace() || c == ',');
            for word in words.filter(|word| !word.is_empty()) {
                let number = word.parse::<f32>().ok().filter(|number| number.is_finite());
                numbers.push(number.ok_or_else(|| {
                    format!("line {line}: \"{}\" is no number", crate::shown::shown(word))
                })?);
            }
        }
        if numbers.is_empty() || numbers.len() % 2 == 1 {
            let count = numbers.len();
            return Err(format!("{count} numbers are not pairs of wavelengths and values"));
        }
        let points = numbers.chunks_exact(2).map(|pair| (pair[0], pair[1])).collect();
        Self::new(points).ok_or_else(|| "its wavelengths do not ascend".to_owned())
    }

    /// What a body of this temperature in kelvin radiates, in W/(m² sr nm).
    pub(crate) fn black_body(kelvin: f32) -> Self {
        let at = |nm: u16| (f32::from(nm), Self::black_body_at(f32::from(nm), kelvin));
        Self { points: VISIBLE_NM.step_by(5).map(at).collect() }
    }

    /// The same at one wavelength, in nanometres (Planck's law).
    pub(crate) fn black_body_at(nm: f32, kelvin: f32) -> f32 {
        // 2 h c² in W m² and h c / k in m K (CODATA 2018, which are exact).
        const FIRST: f64 = 1.191_042_972e-16;
        const SECOND: f64 = 1.438_776_877e-2;
        let metres = 1e-9 * f64::from(nm);
        let power = f64::from(real::exp((SECOND / (metres * f64::from(kelvin))) as f32));
        let per_metre = FIRST / (metres * metres * metres * metres * metres) / (power - 1.0);
        (1e-9 * per_metre) as f32
    }

    /// The same with its ends held: before the first wavelength as there, behind the last as there.
    #[must_use]
    pub(crate) fn held(mut self) -> Self {
        let (first, last) = (self.points[0], self.points[self.points.len() - 1]);
        if first.0 > FIRST_NM {
            self.points.insert(0, (FIRST_NM, first.1));
        }
        if last.0 < LAST_NM {
            self.points.push((LAST_NM, last.1));
        }
        self
    }

    /// Its value at a wavelength in nanometres.
    pub(crate) fn at(&self, nm: f32) -> f32 {
        let after = self.points.partition_point(|point| point.0 < nm);
        match (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) {
            (_, Some(exact)) if exact.0 == nm => exact.1,
            (Some(a), Some(b)) => a.1 + (b.1 - a.1) * ((nm - a.0) / (b.0 - a.0)),
            (None, _) | (_, None) => 0.0,
        }
    }

    /// As what a surface reflects, or as any number that stands for a colour: seen in daylight. One
    /// that is c everywhere is c in each channel. Not below 0.
    pub(crate) fn reflectance(&self) -> Rgb {
        Rgb(self.seen(&OBSERVER.surfaces).map(|c| c.max(0.0) as f32))
    }

    /// As a number that is no colour, such as an index of refraction: its mean over what each channel
    /// is sensitive to.
    pub(crate) fn mean(&self) -> Rgb {
        Rgb(self.seen(&OBSERVER.numbers).map(|c| c as f32))
    }

    /// As light: one that is 1 everywhere has the luminance 1, and the colour of the equal-energy
    /// illuminant. Not below 0.
    pub(crate) fn light(&self) -> Rgb {
        Rgb(self.seen(&OBSERVER.light).map(|c| c.max(0.0) as f32))
    }

    fn seen(&self, weights: &[[f64; 3]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (nm, weight) in VISIBLE_NM.zip(weights) {
            let value = f64::from(self.at(f32::from(nm)));
            for (sum, weight) in sum.iter_mut().zip(weight) {
                *sum += weight * value;
            }
        }
        sum
    }
}

const FIRST_NM: f32 = *VISIBLE_NM.start() as f32;
const LAST_NM: f32 = *VISIBLE_NM.end() as f32;

/// The same colour with the luminance 1: how pbrt takes light that is told by its spectrum. Black
/// stays black.
pub(crate) fn of_luminance_one(light: Rgb) -> Rgb {
    let luminance = Spectrum::from(light).luminance();
    if luminance > 0.0 { Rgb(light.0.map(|c| c / luminance)) } else { Rgb::BLACK }
}

/// The light of a body of this temperature in kelvin, with the luminance 1; black where it is not
/// above 0.
pub(crate) fn black_body(kelvin: f32) -> Rgb {
    if !(kelvin > 0.0 && kelvin.is_finite()) {
        return Rgb::BLACK;
    }
    // What glows so little that single precision knows nothing of it is as red as anything.
    let light = Sampled::black_body(kelvin.max(300.0)).light();
    of_luminance_one(if light == Rgb::BLACK { Rgb::new(1.0, 0.0, 0.0) } else { light })
}

/// The complex index of a metal, `eta + i k`, whose parts are spectra: the colour at normal incidence
/// in daylight is right, as for [`Metal`].
pub(crate) fn metal_of(eta: &Sampled, k: &Sampled) -> [Rgb; 2] {
    let reflected = |nm: f32| normal_reflectance(eta.at(nm), k.at(nm));
    let points = VISIBLE_NM.map(|nm| (f32::from(nm), reflected(f32::from(nm)))).collect();
    let reflectance = Sampled { points };
    let most = reflectance.points.iter().fold(0.0_f32, |most, point| most.max(point.1));
    let (n, seen) = (eta.mean().0, reflectance.reflectance().0);
    let k = std::array::from_fn(|i| {
        let r = seen[i].min(most).clamp(0.0, MOST_REFLECTED);
        let square = (r * (n[i] + 1.0) * (n[i] + 1.0) - (n[i] - 1.0) * (n[i] - 1.0)) / (1.0 - r);
        square.max(0.0).sqrt()
    });
    [Rgb(n), Rgb(k)]
}

/// What the border to an index of `eta + i k` reflects of light that falls straight onto it.
pub(crate) fn normal_reflectance(eta: f32, k: f32) -> f32 {
    let square = k * k;
    ((eta - 1.0) * (eta - 1.0) + square) / ((eta + 1.0) * (eta + 1.0) + square)
}

/// No metal reflects more, and no index would do it.
pub(crate) const MOST_REFLECTED: f32 = 0.9999;

/// The complex index, `[eta, k]`, of a metal that is called so: its chemical symbol, as pbrt and
/// Mitsuba have it.
pub(crate) fn metal(symbol: &str) -> Option<[Rgb; 2]> {
    let metal = match symbol {
        "Au" => Metal::Gold,
        "Cu" => Metal::Copper,
        "Ag" => Metal::Silver,
        "Al" => Metal::Aluminium,
        // Brass at 650, 550 and 450 nm, after Querry, *Optical Constants*, 1985.
        "CuZn" => return Some([[0.444, 0.527, 1.094], [3.695, 2.765, 1.829]].map(Rgb)),
        // Magnesia by Stephens and Malitson, 1952, and rutile by Devore, 1951, at the same: clear
        // crystals, whose surfaces reflect as these numbers say.
        "MgO" => return Some([[1.734, 1.740, 1.752], [0.0; 3]].map(Rgb)),
        "TiO2" => return Some([[2.574, 2.648, 2.813], [0.0; 3]].map(Rgb)),
        _ => return None,
    };
    let conductor = metal.conductor(0.0);
    Some([conductor.eta, conductor.k])
}

/// The symbols that [`metal`] knows.
pub(crate) const METALS: [&str; 7] = ["Au", "Cu", "Ag", "Al", "CuZn", "MgO", "TiO2"];

/// A clear medium by its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Clear {
    /// Index of refraction for yellow light.
    pub(crate) ior: f32,
    /// The Abbe number, where it is known: 20 over it is what
    /// [`Dielectric::dispersion`](rutilant::material::Dielectric::dispersion) takes.
    pub(crate) abbe: Option<f32>,
}

/// The clear media that have names: those of Mitsuba's documentation, then optical glasses as their
/// makers' catalogues have them.
const CLEAR: &[(&str, f32, Option<f32>)] = &[
    ("vacuum", 1.0, None),
    ("helium", 1.000_036, None),
    ("hydrogen", 1.000_132, None),
    ("air", 1.000_277, None),
    ("carbon dioxide", 1.000_45, None),
    ("water", 1.333, Some(55.7)),
    ("acetone", 1.36, None),
    ("ethanol", 1.361, None),
    ("carbon tetrachloride", 1.461, None),
    ("glycerol", 1.4729, None),
    ("benzene", 1.501, None),
    ("silicone oil", 1.520_45, None),
    ("bromine", 1.661, None),
    ("water ice", 1.31, None),
    ("fused quartz", 1.458, Some(67.8)),
    ("pyrex", 1.47, None),
    ("acrylic glass", 1.49, None),
    ("polypropylene", 1.49, None),
    ("bk7", 1.5168, Some(64.17)),
    ("sodium chloride", 1.544, None),
    ("amber", 1.55, None),
    ("pet", 1.575, None),
    ("diamond", 2.419, Some(55.3)),
    ("baf10", 1.670_03, Some(47.11)),
    ("fk51a", 1.486_56, Some(84.47)),
    ("lasf9", 1.850_25, Some(32.17)),
    ("sf5", 1.672_7, Some(32.21)),
    ("sf10", 1.728_25, Some(28.41)),
    ("sf11", 1.784_72, Some(25.68)),
];

/// The clear medium that is called so, in small letters or not.
pub(crate) fn clear(name: &str) -> Option<Clear> {
    let found = CLEAR.iter().find(|(known, _, _)| known.eq_ignore_ascii_case(name));
    found.map(|&(_, ior, abbe)| Clear { ior, abbe })
}

/// The light of an illuminant of the CIE, with the luminance 1: "A", "D50", "D65", "E", "F1" to "F12",
/// and the Academy's "D60".
pub(crate) fn illuminant(name: &str) -> Option<Rgb> {
    // CIE 15:2004, tables T.3 and T.8.1: chromaticities for the observer of 1931.
    const KNOWN: [(&str, f64, f64); 17] = [
        ("A", 0.447_58, 0.407_45),
        ("D50", 0.345_67, 0.358_51),
        ("D60", 0.321_68, 0.337_67),
        ("D65", 0.312_72, 0.329_03),
        ("E", 1.0 / 3.0, 1.0 / 3.0),
        ("F1", 0.3131, 0.3371),
        ("F2", 0.3721, 0.3751),
        ("F3", 0.4091, 0.3941),
        ("F4", 0.4402, 0.4031),
        ("F5", 0.3138, 0.3452),
        ("F6", 0.3779, 0.3882),
        ("F7", 0.3129, 0.3292),
        ("F8", 0.3458, 0.3586),
        ("F9", 0.3741, 0.3727),
        ("F10", 0.3461, 0.3599),
        ("F11", 0.3805, 0.3769),
        ("F12", 0.4370, 0.4042),
    ];
    if name == "D65" {
        return Some(Rgb::WHITE);
    }
    let &(_, x, y) = KNOWN.iter().find(|(known, _, _)| *known == name)?;
    let rgb = srgb_from_xyz([x / y, 1.0, (1.0 - x - y) / y]);
    Some(of_luminance_one(Rgb(rgb.map(|c| c.max(0.0) as f32))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Rgb, b: Rgb, by: f32) -> bool {
        a.0.iter().zip(b.0).all(|(a, b)| (a - b).abs() <= by)
    }

    fn flat(value: f32) -> Sampled {
        Sampled::new(vec![(300.0, value), (900.0, value)]).expect("a spectrum")
    }

    /// Grey is grey, as a surface, as a number, and daylight as light. A channel that is not
    /// normalised shows.
    #[test]
    fn grey_is_grey() {
        for value in [0.0, 0.18, 1.0, 3.5] {
            assert!(near(flat(value).reflectance(), Rgb::grey(value), 1e-6 * value));
            assert!(near(flat(value).mean(), Rgb::grey(value), 1e-6 * value));
        }
        let points = (0..21).map(|i| (380.0 + 20.0 * i as f32, D65[i as usize])).collect();
        let daylight = Sampled::new(points).expect("a spectrum");
        assert!(near(of_luminance_one(daylight.light()), Rgb::WHITE, 1e-5));
        let luminance = Spectrum::from(flat(1.0).light()).luminance();
        assert!((luminance - 1.0).abs() < 1e-5, "{luminance}");
    }

    /// Bodies that glow have the colours of Planck's locus, by the tables of CIE illuminant A
    /// (2856 K) and by what is known of white: between 6000 and 7000 K light is about as blue as red.
    #[test]
    fn glowing_bodies_have_their_colours() {
        let a = illuminant("A").expect("known");
        assert!(near(black_body(2856.0), a, 0.05), "{:?} {a:?}", black_body(2856.0));
        let [r, g, b] = black_body(6600.0).0;
        assert!((r - 1.0).abs() < 0.06 && (g - 1.0).abs() < 0.06 && (b - 1.0).abs() < 0.06);
        for kelvin in [-1.0, 0.0, f32::NAN, f32::INFINITY] {
            assert_eq!(black_body(kelvin), Rgb::BLACK);
        }
        for kelvin in [1e-30, 1.0, 500.0, 1e6, 1e30] {
            let luminance = Spectrum::from(black_body(kelvin)).luminance();
            assert!((luminance - 1.0).abs() < 1e-4, "{kelvin}: {luminance}");
        }
        // Wien's law: at 5000 K the most is radiated at 2.898e-3 / 5000 m.
        let body = Sampled::black_body(5000.0);
        let most = body.points.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("points").0;
        assert!((most - 579.6).abs() <= 5.0, "{most}");
        // And that much, 4.096e-6 T⁵ W/(m² sr m): per nanometre 12.8 kW/(m² sr).
        let peak = body.at(most);
        assert!((peak / (4.0957e-6 * 5000_f32.powi(5) * 1e-9) - 1.0).abs() < 2e-3, "{peak}");
    }

    /// A metal of one index at every wavelength keeps it; straight lines are straight.
    #[test]
    fn even_metals_keep_their_index() {
        let [eta, k] = metal_of(&flat(0.4), &flat(3.0));
        assert!(near(eta, Rgb::grey(0.4), 1e-5) && near(k, Rgb::grey(3.0), 1e-3), "{eta:?} {k:?}");
        let slope = Sampled::new(vec![(400.0, 1.0), (500.0, 2.0)]).expect("a spectrum");
        assert_eq!([slope.at(399.0), slope.at(450.0), slope.at(501.0)], [0.0, 1.5, 0.0]);
        let held = slope.held();
        assert_eq!([held.at(390.0), held.at(500.0), held.at(700.0)], [1.0, 2.0, 2.0]);
    }

    /// Files are pairs; what is wrong is told.
    #[test]
    fn files_are_pairs() {
        let read = Sampled::parse("# measured\n400 0.5\n\n700\t1e0 # end\n").expect("a spectrum");
        assert_eq!(read.points, [(400.0, 0.5), (700.0, 1.0)]);
        for (text, what) in [
            ("", "0 numbers are not pairs of wavelengths and values"),
            ("400 1 500", "3 numbers are not pairs of wavelengths and values"),
            ("400 1\n500 x", "line 2: \"x\" is no number"),
            ("500 1 400 1", "its wavelengths do not ascend"),
            ("500 1 600 inf", "line 1: \"inf\" is no number"),
        ] {
            assert_eq!(Sampled::parse(text).expect_err(what), what);
        }
    }

    /// Known names are found, others are not.
    #[test]
    fn names_are_known() {
        assert!(METALS.into_iter().all(|symbol| metal(symbol).is_some()));
        assert!(
            metal("Xx").is_none() && clear("unobtainium").is_none() && illuminant("Z").is_none()
        );
        assert_eq!(clear("BK7").map(|glass| glass.ior), Some(1.5168));
        // Illuminant A is about 2.8 times as red as daylight.
        let [r, g, b] = illuminant("A").expect("known").0;
        assert!(r > 1.7 && g < 1.0 && b < 0.35, "{r} {g} {b}");
    }
}
