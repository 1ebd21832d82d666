//! Values of options: what is written on the command line, and what it means.

use crate::failure::Failure;
use clap::ValueEnum;
use rutilant::color::Rgb;
use rutilant::display::Curve;
use rutilant::geom::{BuildOptions, Quality, Simd};
use rutilant::scene::MOST_LIGHT;
use rutilant::settings::{Crop, IntegratorKind, Layer, Layers, SamplerKind};
use rutilant_formats::{CameraChoice, Limits, SkyChoice};
use std::time::Duration;

/// `800x600`.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or("write it as 800x600")?;
    let side = |text: &str| match text.trim().parse::<u32>() {
        Ok(side) if side > 0 => Ok(side),
        _ => Err(format!("\"{text}\" is not a number of pixels; write it as 800x600")),
    };
    Ok([side(width)?, side(height)?])
}

/// `x,y,w,h`.
pub(crate) fn crop(text: &str) -> Result<Crop, String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, width, height]) => Ok(Crop { x, y, width, height }),
        _ => Err("write it as x,y,width,height in whole pixels, like 100,50,320,200".to_owned()),
    }
}

/// `x,y`.
pub(crate) fn pixel(text: &str) -> Result<[u32; 2], String> {
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y]) => Ok([x, y]),
        _ => Err("write it as x,y in whole pixels, like 400,300".to_owned()),
    }
}

/// `60s`, `5m`, `1h30m`, `1.5h`, or a plain number of seconds.
pub(crate) fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || format!("\"{text}\" is not a time; write it as 60s, 5m or 1h30m");
    let (mut seconds, mut rest) = (0.0_f64, text.trim());
    if rest.is_empty() {
        return Err(wrong());
    }
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let number: f64 = rest[..digits].parse().map_err(|_| wrong())?;
        let letters = &rest[digits..];
        let end = letters.find(|c: char| !c.is_alphabetic()).unwrap_or(letters.len());
        let unit = match &letters[..end] {
            "ms" => 0.001,
            "" | "s" => 1.0,
            "m" | "min" => 60.0,
            "h" => 3600.0,
            "d" => 86_400.0,
            _ => return Err(wrong()),
        };
        seconds += number * unit;
        rest = &letters[end..];
    }
    match Duration::try_from_secs_f64(seconds) {
        Ok(time) if !time.is_zero() => Ok(time),
        _ => Err(wrong()),
    }
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("write a number, like 1.5 or -2".to_owned()),
    }
}

/// How many of something: one at least.
pub(crate) fn count<N: std::str::FromStr + Default + PartialEq>(text: &str) -> Result<N, String> {
    match text.parse::<N>() {
        Ok(n) if n != N::default() => Ok(n),
        _ => Err("write a whole number, 1 or more".to_owned()),
    }
}

/// A number that stands for a picture.
pub(crate) fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| "write a whole number, 0 or more".to_owned())
}

/// `pixels=500M`: the name of a limit, and a number in which k, M and G stand for thousands,
/// millions and milliards.
pub(crate) fn limit(text: &str) -> Result<(&'static str, u64), String> {
    let names = Limits::NAMES;
    let (name, most) = text.split_once('=').ok_or("write it as NAME=N, like pixels=500M")?;
    let Some(name) = names.into_iter().find(|known| *known == name.trim()) else {
        return Err(format!("there are {}", names.join(", ")));
    };
    let most = most.trim();
    let digits = most.trim_end_matches(['k', 'M', 'G']);
    let factor = match &most[digits.len()..] {
        "" => Some(1),
        "k" => Some(1_000),
        "M" => Some(1_000_000),
        "G" => Some(1_000_000_000),
        _ => None,
    };
    let number = digits.parse::<u64>().ok().zip(factor).and_then(|(n, f)| n.checked_mul(f));
    let number = number.filter(|_| digits.starts_with(|c: char| c.is_ascii_digit()));
    let number = number.ok_or("write a whole number, like 2000000, 500k, 2M or 8G")?;
    Ok((name, number))
}

/// `all`, `none`, or names of layers.
pub(crate) fn layers(text: &str) -> Result<Layers, String> {
    match text {
        "all" => return Ok(Layers::all()),
        "none" => return Ok(Layers::NONE),
        _ => {}
    }
    let layer = |name: &str| {
        let known = Layer::ALL.into_iter().find(|(known, _)| *known == name.trim());
        known.map(|(_, layer)| layer).ok_or_else(|| {
            let names = Layer::ALL.map(|(name, _)| name).join(", ");
            format!("there are {names}; or write all or none")
        })
    };
    text.split(',').map(layer).collect()
}

/// `spp=64`: the name of a parameter of a scene, and what it stands for.
pub(crate) fn parameter(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, value)) if !name.trim().is_empty() => {
            Ok((name.trim().to_owned(), value.to_owned()))
        }
        Some(_) | None => Err("write it as NAME=VALUE, like spp=64".to_owned()),
    }
}

/// The name of a camera, its number, or `auto`.
pub(crate) fn camera(text: &str) -> Result<CameraChoice, String> {
    match text {
        "" => Err("write a name, a number or auto".to_owned()),
        "auto" => Ok(CameraChoice::Auto),
        name => Ok(CameraChoice::Named(name.to_owned())),
    }
}

/// `none`, one number or three for a radiance, or the path of a picture.
pub(crate) fn sky(text: &str) -> Result<SkyChoice, String> {
    const WHAT: &str = "write none, a radiance as one number or three, like 0.8,0.9,1, or the path \
                        of a picture";
    match text {
        "none" => return Ok(SkyChoice::None),
        "" => return Err(WHAT.to_owned()),
        _ => {}
    }
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    let radiance = match numbers.as_deref() {
        Ok(&[grey]) => Rgb::grey(grey),
        Ok(&[r, g, b]) => Rgb([r, g, b]),
        Ok(_) => return Err(WHAT.to_owned()),
        // Another option, or a colour in another language.
        Err(_) if text.starts_with(['-', '#']) => return Err(WHAT.to_owned()),
        Err(_) => return Ok(SkyChoice::Picture(text.into())),
    };
    if radiance.0.iter().any(|c| !(0.0..=MOST_LIGHT).contains(c)) {
        return Err(format!("a radiance must lie between 0 and {MOST_LIGHT:e}"));
    }
    Ok(SkyChoice::Even(radiance))
}

/// How many threads.
pub(crate) fn threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count @ 1..=1024) => Ok(count),
        _ => Err("write a number from 1 to 1024".to_owned()),
    }
}

/// As many threads as the machine runs at once.
pub(crate) fn all_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get).min(1024)
}

/// What is computed for each camera ray; the names are those of the scene format.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Integrator {
    /// All light, over any number of bounces
    Path,
    /// The same, but lights are only found by chance: slow, for comparison
    Naive,
    /// Emission and direct light only
    Direct,
    /// Ambient occlusion: how much of the sky each point sees
    Ao,
    /// Shading normals, from −1..1 mapped to 0..1
    Normals,
    /// The part of white light that surfaces send back
    Albedo,
    /// Distance from the camera in metres
    Depth,
}

impl From<Integrator> for IntegratorKind {
    fn from(name: Integrator) -> Self {
        match name {
            Integrator::Path => Self::Path,
            Integrator::Naive => Self::Naive,
            Integrator::Direct => Self::Direct,
            Integrator::Ao => Self::AmbientOcclusion,
            Integrator::Normals => Self::Normals,
            Integrator::Albedo => Self::Albedo,
            Integrator::Depth => Self::Depth,
        }
    }
}

impl From<IntegratorKind> for Integrator {
    fn from(kind: IntegratorKind) -> Self {
        match kind {
            IntegratorKind::Path => Self::Path,
            IntegratorKind::Naive => Self::Naive,
            IntegratorKind::Direct => Self::Direct,
            IntegratorKind::AmbientOcclusion => Self::Ao,
            IntegratorKind::Normals => Self::Normals,
            IntegratorKind::Albedo => Self::Albedo,
            IntegratorKind::Depth => Self::Depth,
        }
    }
}

impl Integrator {
    /// True when the length of paths changes the picture.
    pub(crate) fn heeds_max_depth(self) -> bool {
        match self {
            Self::Path | Self::Naive => true,
            Self::Direct | Self::Ao | Self::Normals | Self::Albedo | Self::Depth => false,
        }
    }
}

/// Where random numbers come from.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Sampler {
    /// Owen-scrambled Sobol points: less noise from the same number of samples
    Sobol,
    /// Every number drawn on its own
    Independent,
}

impl From<Sampler> for SamplerKind {
    fn from(name: Sampler) -> Self {
        match name {
            Sampler::Sobol => Self::Sobol,
            Sampler::Independent => Self::Independent,
        }
    }
}

impl From<SamplerKind> for Sampler {
    fn from(kind: SamplerKind) -> Self {
        match kind {
            SamplerKind::Sobol => Self::Sobol,
            SamplerKind::Independent => Self::Independent,
        }
    }
}

/// A choice as it is written on the command line.
pub(crate) fn name(choice: &impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Bits of a number in a file.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Bits {
    /// 8 in .png, 16 in .exr: the smallest files
    #[value(name = "8")]
    Eight,
    /// 16 in .png, 16 in .exr
    #[value(name = "16")]
    Sixteen,
    /// 16 in .png, 32 in .exr: nothing is lost
    #[value(name = "32")]
    ThirtyTwo,
}

/// Which channels are kept in .exr files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Channels {
    #[default]
    /// R, G, B, the variance of each pixel's mean, how many samples it has, and the layers
    All,
    /// R, G, B: half the size
    Color,
}

/// What becomes of values above white.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum DisplayCurve {
    /// They are white; everything below stays exact: for comparing
    Clip,
    /// A soft shoulder, as film has it: contrast, quickly
    Filmic,
    /// Luminance is compressed, colours stay: for some highlights
    Reinhard,
    /// The reference look of film production: strong contrast, rather dark
    Aces,
    /// Sixteen stops; bright colours bleach to white: for lamps, fire, sun
    Agx,
}

impl From<DisplayCurve> for Curve {
    fn from(name: DisplayCurve) -> Self {
        match name {
            DisplayCurve::Clip => Self::Clip,
            DisplayCurve::Filmic => Self::Filmic,
            DisplayCurve::Reinhard => Self::Reinhard,
            DisplayCurve::Aces => Self::Aces,
            DisplayCurve::Agx => Self::Agx,
        }
    }
}

/// How much time the tree that rays go through is worth.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum Build {
    /// Soonest there, for slower rays
    Fast,
    /// For most pictures
    Default,
    /// Several times as long, for a few percent faster rays
    High,
}

impl From<Build> for BuildOptions {
    fn from(build: Build) -> Self {
        Self::from(match build {
            Build::Fast => Quality::Fast,
            Build::Default => Quality::Default,
            Build::High => Quality::High,
        })
    }
}

/// The processor's instructions that rays are traced with.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(crate) enum SimdLevel {
    /// The best there are
    Auto,
    /// One box at a time
    Scalar,
    /// Four at a time
    Sse4,
    /// Eight at a time
    Avx2,
}

impl From<SimdLevel> for Simd {
    fn from(level: SimdLevel) -> Self {
        match level {
            SimdLevel::Auto => Self::Auto,
            SimdLevel::Scalar => Self::Scalar,
            SimdLevel::Sse4 => Self::Sse4,
            SimdLevel::Avx2 => Self::Avx2,
        }
    }
}

impl SimdLevel {
    /// What is said where the processor has no such instructions.
    pub(crate) fn missing(self) -> Failure {
        Failure::usage(format!("this processor has no instructions \"{}\"", name(&self)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_counts_of_pixels() {
        assert_eq!(size("800x600"), Ok([800, 600]));
        assert_eq!(size("16×9"), Ok([16, 9]));
        for wrong in ["", "800", "800x", "x600", "0x600", "-1x5", "8e2x5", "800x600x3"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn crops_are_four_numbers() {
        assert_eq!(crop("1, 2,3,4"), Ok(Crop { x: 1, y: 2, width: 3, height: 4 }));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "-1,2,3,4", "a,b,c,d"] {
            assert!(crop(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn layers_are_names() {
        assert_eq!(layers("all"), Ok(Layers::all()));
        assert_eq!(layers("none"), Ok(Layers::NONE));
        let two = Layers::NONE.with(Layer::Albedo).with(Layer::Normal);
        assert_eq!(layers("albedo, normal"), Ok(two));
        for wrong in ["", "albedo,", "Albedo", "albedo;normal", "all,albedo"] {
            assert!(layers(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn limits_are_names_and_counts() {
        assert_eq!(limit("pixels=500M"), Ok(("pixels", 500_000_000)));
        assert_eq!(limit("bytes = 8G"), Ok(("bytes", 8_000_000_000)));
        assert_eq!(limit("nesting=0"), Ok(("nesting", 0)));
        for name in Limits::NAMES {
            assert_eq!(limit(&format!("{name}=7k")), Ok((name, 7000)));
            assert!(Limits::default().by_name(name).is_some(), "{name}");
        }
        for wrong in [
            "",
            "pixels",
            "=5",
            "pixles=5",
            "pixels=",
            "pixels=k",
            "pixels=-1",
            "pixels=+1",
            "pixels=1.5M",
            "pixels=5Mk",
            "pixels=5T",
            "pixels=99999999999G",
        ] {
            assert!(limit(wrong).is_err(), "{wrong}");
        }
    }

    /// A radiance that is none is refused here, where the option can be blamed for it.
    #[test]
    fn skies_are_light_or_pictures() {
        assert_eq!(sky("none"), Ok(SkyChoice::None));
        assert_eq!(sky("0.5"), Ok(SkyChoice::Even(Rgb::grey(0.5))));
        assert_eq!(sky("0, 1e18,2"), Ok(SkyChoice::Even(Rgb::new(0.0, 1e18, 2.0))));
        assert_eq!(sky("nan.hdr"), Ok(SkyChoice::Picture("nan.hdr".into())));
        for wrong in ["nan", "inf", "-1", "1,2", "1,nan,1", "1,1,-inf", "2e18"] {
            assert!(sky(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn parameters_are_names_and_values() {
        let pair = |name: &str, value: &str| Ok((name.to_owned(), value.to_owned()));
        assert_eq!(parameter("spp=64"), pair("spp", "64"));
        assert_eq!(parameter("file=a=b.png"), pair("file", "a=b.png"));
        assert_eq!(parameter("x="), pair("x", ""));
        for wrong in ["", "spp", "=64", " =1"] {
            assert!(parameter(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn pixels_are_two_numbers() {
        assert_eq!(pixel("400, 0"), Ok([400, 0]));
        for wrong in ["", "1", "1,2,3", "-1,2", "1.5,2", "a,b", "1x2"] {
            assert!(pixel(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn times_add_up() {
        for (text, seconds) in [
            ("60s", 60.0),
            ("90", 90.0),
            ("5m", 300.0),
            ("1h30m", 5400.0),
            ("1.5h", 5400.0),
            ("2min", 120.0),
            ("250ms", 0.25),
        ] {
            assert_eq!(duration(text).map(|d| d.as_secs_f64()), Ok(seconds), "{text}");
        }
        for wrong in [
            "",
            "s",
            "-5s",
            "0",
            "5 parsecs",
            "1e400",
            "..",
            "inf",
            "5m-3s",
            "9999999999999999999999s",
        ] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }
}
