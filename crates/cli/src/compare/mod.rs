//! `rutilant compare`: how far a picture is from a reference.

mod flip;
mod metrics;
mod pixels;
mod plane;
mod ssim;
#[cfg(test)]
mod testing;

use crate::failure::{Exit, Failure};
use crate::load::Limited;
use crate::options;
use crate::output::{self, Detail};
use crate::say::{print_json, print_line, tell};
use crate::text::several;
use metrics::Errors;
use pixels::Pixels;
use rutilant::display::{Curve, Display, linear_from_srgb};
use rutilant::false_color;
use rutilant::image::Image;
use rutilant_formats::image;
use serde::Serialize;
use std::path::{Path, PathBuf};

pub(crate) const EXAMPLES: &str = "\
Examples:
  rutilant compare out.exr reference.exr
  rutilant compare out.png reference.png --diff diff.png
  rutilant compare out.exr reference.exr --json | jq .relmse

RMSE and relMSE are taken on scene-linear values, PSNR, SSIM and FLIP on what a display shows (sRGB, 8 bits).
HDR-FLIP shows scene-linear files at all exposures where the reference has something to show.
SSIM is 1 for equal pictures. FLIP runs from 0 (no visible difference) to 1, for a viewer 0.7 m from a 0.7 m wide 4K display.";

#[derive(clap::Args)]
pub(crate) struct Args {
    /// The image to judge: .exr, .hdr, .pfm (scene-linear), .png, .jpg
    image: PathBuf,
    /// The image it should be, in any of these formats
    reference: PathBuf,
    /// Write a picture of the FLIP difference: black where there is none, then violet, orange, yellow
    #[arg(long, value_name = "FILE")]
    diff: Option<PathBuf>,
    /// Brightness in stops at which PSNR, SSIM and FLIP see scene-linear files
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, value_parser = options::finite, allow_hyphen_values = true)]
    exposure: f32,
    /// What becomes of values above white there
    #[arg(long, value_name = "NAME", value_enum, default_value_t = options::DisplayCurve::Clip)]
    curve: options::DisplayCurve,
    #[command(flatten)]
    limited: Limited,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

/// All that is said about two pictures.
#[derive(Serialize)]
struct Comparison<'a> {
    image: &'a Path,
    reference: &'a Path,
    size: [u32; 2],
    #[serde(flatten)]
    errors: Errors,
    /// In decibels, of display values with peak 1; null for equal pictures.
    psnr: f64,
    ssim: f64,
    flip: f64,
    /// Only of two scene-linear files.
    hdr_flip: Option<f64>,
    /// Pixels with NaN or infinity: in the image, in the reference. They take no part in any mean.
    not_finite: [usize; 2],
}

pub(crate) fn run(args: &Args) -> Result<Exit, Failure> {
    if let Some(diff) = &args.diff {
        let same = |path: &PathBuf| match (path.canonicalize(), diff.canonicalize()) {
            (Ok(path), Ok(diff)) => path == diff,
            _ => false,
        };
        if same(&args.image) || same(&args.reference) {
            let what = format!("{} is one of the pictures to compare", diff.display());
            return Err(Failure::usage(what));
        }
        image::check_writable(diff)?;
    }
    let limits = args.limited.limits();
    let read = |path: &Path| image::read(path, &limits);
    let (image, reference) = (read(&args.image)?, read(&args.reference)?);
    let size = [image.width(), image.height()];
    if size != [reference.width(), reference.height()] {
        return Err(Failure::usage(format!(
            "{} has {}×{} pixels, but {} has {}×{}: only pictures of one size can be compared",
            args.image.display(),
            size[0],
            size[1],
            args.reference.display(),
            reference.width(),
            reference.height(),
        )));
    }
    let (test, reference) = (pixels(&image, &args.image)?, pixels(&reference, &args.reference)?);
    let not_finite = [metrics::not_finite(&test), metrics::not_finite(&reference)];
    let errors = metrics::errors(&test, &reference).ok_or_else(|| {
        Failure::failed("no pixel is finite in both pictures: there is nothing to compare")
    })?;

    // Eyes see what the display shows; pixels that are no numbers are black in both pictures.
    let counts: Vec<bool> = (test.values.iter().zip(&reference.values))
        .map(|(a, b)| metrics::finite(a) && metrics::finite(b))
        .collect();
    let blackened = |picture: &Pixels| {
        let values = picture.values.iter().zip(&counts);
        let values = values.map(|(rgb, counts)| if *counts { *rgb } else { [0.0; 3] });
        Pixels { width: picture.width, values: values.collect() }
    };
    let (test, reference) = (blackened(&test), blackened(&reference));
    let display = Display { exposure: args.exposure, curve: Curve::from(args.curve) };
    let encoded = |p: &Pixels| p.map(|rgb| display.encode(rgb).map(|b| f32::from(b) / 255.0));
    let (test_shown, reference_shown) = (encoded(&test), encoded(&reference));
    let psnr = metrics::psnr(&test_shown, &reference_shown, &counts);

    let light = |p: &Pixels| p.map(|rgb| rgb.map(|c| linear_from_srgb(f64::from(c)) as f32));
    let map = flip::ldr(&light(&reference_shown), &light(&test_shown), flip::PIXELS_PER_DEGREE);
    let linear = [&args.image, &args.reference].into_iter().all(|path| output::holds_light(path));
    let hdr_map = linear.then(|| flip::hdr(&reference, &test, flip::PIXELS_PER_DEGREE));

    let comparison = Comparison {
        image: &args.image,
        reference: &args.reference,
        size,
        errors,
        psnr,
        ssim: mean(&ssim::map(&test_shown, &reference_shown), &counts),
        flip: mean(&map, &counts),
        hdr_flip: hdr_map.as_ref().map(|map| mean(map, &counts)),
        not_finite,
    };
    if let Some(path) = &args.diff {
        let colors: Vec<_> = (hdr_map.as_ref().unwrap_or(&map).iter())
            .map(|difference| false_color::magma(*difference))
            .collect();
        let diff = Image::from_rgb(size[0], size[1], &colors)
            .ok_or_else(|| Failure::failed("the picture of the difference has no pixels"))?;
        // The colours are made for the display as they are.
        output::write(path, &diff, &Display::default(), Detail::default(), Vec::new())
            .map_err(Failure::failed)?;
        tell(&format!("wrote {}", path.display()));
    }
    if args.json {
        print_json(&comparison)?;
    } else {
        print_line(&describe(&comparison))?;
    }
    Ok(Exit::Done)
}

/// An image's colours.
fn pixels(image: &Image, path: &Path) -> Result<Pixels, Failure> {
    match image.rgb() {
        Some(values) if !values.is_empty() => Ok(Pixels { width: image.width() as usize, values }),
        Some(_) => Err(Failure::usage(format!("{} has no pixels", path.display()))),
        None => Err(Failure::usage(format!("{} has no channels R, G, B (or Y)", path.display()))),
    }
}

/// The mean of the pixels that count.
fn mean(map: &[f32], counts: &[bool]) -> f64 {
    let counted = || map.iter().zip(counts).filter(|(_, counts)| **counts);
    counted().map(|(v, _)| f64::from(*v)).sum::<f64>() / counted().count().max(1) as f64
}

/// The same for people.
fn describe(c: &Comparison<'_>) -> String {
    let e = &c.errors;
    let mut rows = vec![
        format!("RMSE      {:<10.5}", e.rmse),
        format!("relMSE    {:<10.5} ε = {}", e.relmse, metrics::EPSILON),
        format!("          {:<10.5} without the worst 0.1 % of pixels", e.relmse_999),
        format!("bias      {:<+10.5} on a mean of {:.5}", e.bias, e.reference_mean),
        format!("PSNR      {:<10} of display values", format!("{:.2} dB", c.psnr)),
        format!("SSIM      {:<10.5} of display values", c.ssim),
        format!("FLIP      {:<10.5} of display values", c.flip),
    ];
    if let Some(hdr) = c.hdr_flip {
        rows.push(format!("HDR-FLIP  {hdr:<10.5} at the worst of all exposures"));
    }
    let rows = rows.iter().map(|row| row.trim_end().to_owned());
    let mut text = rows.collect::<Vec<_>>().join("\n");
    for (count, name) in c.not_finite.iter().zip([c.image, c.reference]) {
        if *count > 0 {
            text += &format!(
                "\n{}: {} NaN or infinite and left out",
                name.display(),
                several(*count as u64, "pixel is", "pixels are")
            );
        }
    }
    text
}
