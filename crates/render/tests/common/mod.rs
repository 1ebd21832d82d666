//! What the proofs share: a counter-based random sequence, a chi-square test, a furnace, and a
//! way to render small scenes to their means.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]
#![allow(dead_code, reason = "each test file uses a part of this")]

use rutilant::color::Spectrum;
use rutilant::geom::{Frame, Vec2, Vec3, real};
use rutilant::image::Image;
use rutilant::sampler::{Independent, Sampler, Sequence};
use rutilant::scene::Scene;
use rutilant::settings::{SamplerKind, Settings};
use rutilant::{Prepared, Session};
use std::f64::consts::PI;
use std::sync::Arc;
use std::time::Duration;

/// Number `i` of a fixed random sequence: a number and a pair, all in [0, 1).
pub fn random(stream: u64, i: u64) -> (f32, Vec2) {
    let sampler = Independent::new(&Sequence::new(stream, 1), [0, 0], i);
    (sampler.d1(0), sampler.d2(0))
}

/// Number `i` of a sequence that is spread evenly over a number and a pair, all in [0, 1): each
/// step adds powers of the root of x⁴ = x + 1 (Roberts, "The Unreasonable Effectiveness of
/// Quasirandom Sequences", 2018).
pub fn well_spread(i: u64) -> (f32, Vec2) {
    const ROOT: f64 = 1.220_744_084_605_759_5;
    let step = |power: i32| {
        let x = ((i as f64 + 0.5) * ROOT.powi(-power)).fract();
        (x as f32).min(1.0 - 0.5 * f32::EPSILON)
    };
    (step(3), Vec2::new(step(1), step(2)))
}

/// Directions `wo` over a range of angles with +z, each at a few angles around it.
pub fn directions(degrees: &[f32]) -> Vec<Vec3> {
    let around = [0.3_f32, 2.5];
    let pairs = degrees.iter().flat_map(|&d| around.map(|phi| (d, phi)));
    pairs
        .map(|(d, phi)| {
            let ((st, ct), (sp, cp)) = (real::sin_cos(d.to_radians()), real::sin_cos(phi));
            Vec3::new(st * cp, st * sp, ct)
        })
        .collect()
}

/// The probability of a chi-square value at least this large by chance alone.
///
/// The regularised upper incomplete gamma function by series and continued fraction (Abramowitz
/// and Stegun, 6.5.29 and 6.5.31).
pub fn chi_square_tail(degrees_of_freedom: f64, value: f64) -> f64 {
    let (a, x) = (0.5 * degrees_of_freedom, 0.5 * value);
    if x <= 0.0 {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut sum, mut term, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-15 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return (1.0 - sum * scale).max(0.0);
    }
    let (mut b, mut c, mut d) = (x + 1.0 - a, 1e300, 1.0 / (x + 1.0 - a));
    let mut fraction = d;
    for i in 1..10_000 {
        let n = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (n * d + b);
        c = b + n / c;
        fraction *= d * c;
        if (d * c - 1.0).abs() < 1e-14 {
            break;
        }
    }
    fraction * scale
}

/// Stirling's series after shifting the argument up.
fn ln_gamma(mut x: f64) -> f64 {
    let mut shift = 0.0;
    while x < 10.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let i = 1.0 / (x * x);
    shift + (x - 0.5) * x.ln() - x
        + 0.5 * (2.0 * PI).ln()
        + (1.0 / 12.0 - i * (1.0 / 360.0 - i * (1.0 / 1260.0 - i / 1680.0))) / x
}

/// The level for each of `tests` independent tests at which all of them together raise a false
/// alarm with a probability of 1 % (Šidák 1967).
pub fn family_wise(tests: usize) -> f64 {
    1.0 - 0.99_f64.powf(1.0 / tests as f64)
}

/// Directions that a chi-square test draws.
const SAMPLES: u64 = 200_000;

/// Where a density may be narrow: around `pole`, within about `width` radians. Infinite is even.
#[derive(Clone, Copy, Debug)]
pub struct Focus {
    pub pole: Vec3,
    pub width: f64,
}

/// A sphere, or its part above or below z = 0, cut into cells around a pole. Rows are even in
/// ln (v + s), where v is the part of the sphere nearer to the pole and s about that within the
/// width: however narrow a density is, it fills many cells.
struct Chart {
    axes: [[f64; 3]; 3],
    s: f64,
    /// ln (1 + 1 / s)
    rows: f64,
    /// The sign of z that the chart is for; 0 for both.
    side: f64,
}

impl Chart {
    // Odd numbers, so that cells do not end where the hemispheres do by luck.
    const ROWS: usize = 25;
    const COLUMNS: usize = 48;
    const CELLS: usize = Self::ROWS * Self::COLUMNS;

    fn new(focus: Focus, side: f64) -> Self {
        let frame = Frame::around(focus.pole);
        let axes = [frame.x, frame.y, frame.z].map(|v| v.to_array().map(f64::from));
        // An eighth of the width, so that what is within it has rows as well.
        let s = if focus.width < 1.0 { 0.004 * focus.width * focus.width } else { 1e6 };
        Self { axes, s, rows: (1.0 / s).ln_1p(), side }
    }

    fn cell(&self, d: Vec3) -> usize {
        let d = d.to_array().map(f64::from);
        let [x, y, z] = self.axes.map(|a| a[0] * d[0] + a[1] * d[1] + a[2] * d[2]);
        // Near the pole 1 - z would be all rounding.
        let r2 = x * x + y * y;
        let v = if z > 0.0 { 0.5 * r2 / (1.0 + z) } else { 0.5 - 0.5 * z };
        let row = (v / self.s).ln_1p() / self.rows * Self::ROWS as f64;
        let column = (y.atan2(x) / (2.0 * PI)).rem_euclid(1.0) * Self::COLUMNS as f64;
        (row as usize).min(Self::ROWS - 1) * Self::COLUMNS
            + (column as usize).min(Self::COLUMNS - 1)
    }

    /// The density per unit of (row, column), each from 0 to its number.
    fn density(&self, row: f64, column: f64, pdf: &impl Fn(Vec3) -> f32) -> f64 {
        let v = self.s * (row / Self::ROWS as f64 * self.rows).exp_m1();
        let (r, z) = (2.0 * (v * (1.0 - v)).max(0.0).sqrt(), 1.0 - 2.0 * v);
        let (s, c) = (2.0 * PI * column / Self::COLUMNS as f64).sin_cos();
        let [ax, ay, az] = self.axes;
        let d = [0, 1, 2].map(|i| r * c * ax[i] + r * s * ay[i] + z * az[i]);
        if self.side * d[2] < 0.0 {
            return 0.0;
        }
        let density = pdf(Vec3::from(d.map(|x| x as f32)));
        assert!(density >= 0.0 && density.is_finite(), "a density of {density}");
        let solid_angle = 4.0 * PI * (v + self.s) * self.rows;
        f64::from(density) * solid_angle / Self::CELLS as f64
    }

    /// The density integrated over a square, by nine Gauss points.
    fn gauss(&self, [row, column]: [f64; 2], side: f64, pdf: &impl Fn(Vec3) -> f32) -> f64 {
        const POINTS: [(f64, f64); 3] = [
            (0.112_701_665_379_258_3, 5.0 / 18.0),
            (0.5, 8.0 / 18.0),
            (0.887_298_334_620_741_7, 5.0 / 18.0),
        ];
        let mut sum = 0.0;
        for (x, a) in POINTS {
            for (y, b) in POINTS {
                sum += a * b * self.density(row + side * x, column + side * y, pdf);
            }
        }
        sum * side * side
    }

    /// The same, in quarters and again in quarters until those change nothing that matters.
    fn integrate(
        &self,
        corner: [f64; 2],
        side: f64,
        whole: f64,
        tolerance: f64,
        pdf: &impl Fn(Vec3) -> f32,
    ) -> f64 {
        let half = 0.5 * side;
        let corners = [[0.0, 0.0], [half, 0.0], [0.0, half], [half, half]]
            .map(|[x, y]| [corner[0] + x, corner[1] + y]);
        let parts = corners.map(|corner| self.gauss(corner, half, pdf));
        let sum: f64 = parts.iter().sum();
        // A fiftieth of the noise of what is counted there is nothing to the statistic.
        let noise = (sum / SAMPLES as f64).sqrt();
        if (sum - whole).abs() <= tolerance + 0.02 * noise || side < 1.0 / 300.0 {
            return sum;
        }
        let parts = corners.into_iter().zip(parts);
        parts.map(|(c, part)| self.integrate(c, half, part, 0.25 * tolerance, pdf)).sum()
    }

    /// The part of all samples that a cell should get: cut into `cuts`², each integrated.
    fn expected(&self, cell: usize, cuts: usize, pdf: &impl Fn(Vec3) -> f32) -> f64 {
        let side = 1.0 / cuts as f64;
        let (row, column) = ((cell / Self::COLUMNS) as f64, (cell % Self::COLUMNS) as f64);
        let corners = (0..cuts * cuts)
            .map(|i| [row + (i / cuts) as f64 * side, column + (i % cuts) as f64 * side]);
        corners
            .map(|c| self.integrate(c, side, self.gauss(c, side, pdf), 2e-7 * side * side, pdf))
            .sum()
    }
}

/// Pearson's test that directions drawn by `sample` follow `pdf` (per sr), over the whole sphere.
/// Samples that are `None` are expected as often as the density lacks from 1.
/// Returns the p-value; panics where a direction is drawn at which the density is zero.
pub fn chi_square(
    stream: u64,
    sample: impl Fn(f32, Vec2) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> f64 {
    let even = Focus { pole: Vec3::Z, width: f64::INFINITY };
    chi_square_over(stream, &[Chart::new(even, 0.0)], 4, sample, pdf)
}

/// The same for densities with steps: between the points of a coarse integral a bright pixel of a
/// sky can hide.
pub fn chi_square_of_steps(
    stream: u64,
    sample: impl Fn(f32, Vec2) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> f64 {
    let even = Focus { pole: Vec3::Z, width: f64::INFINITY };
    chi_square_over(stream, &[Chart::new(even, 0.0)], 16, sample, pdf)
}

/// The same with eyes for what is narrow: above and below z = 0, around one pole each.
pub fn chi_square_focused(
    stream: u64,
    [above, below]: [Focus; 2],
    sample: impl Fn(f32, Vec2) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> f64 {
    let charts = [Chart::new(above, 1.0), Chart::new(below, -1.0)];
    chi_square_over(stream, &charts, 1, sample, pdf)
}

fn chi_square_over(
    stream: u64,
    charts: &[Chart],
    cuts: usize,
    sample: impl Fn(f32, Vec2) -> Option<Vec3>,
    pdf: impl Fn(Vec3) -> f32,
) -> f64 {
    // What is drawn.
    let all = charts.len() * Chart::CELLS;
    let mut counts = vec![0.0; all + 1];
    for i in 0..SAMPLES {
        let (choice, u) = random(stream, i);
        let cell = sample(choice, u).map_or(all, |d| {
            let chart = if d.z < 0.0 { charts.len() - 1 } else { 0 };
            chart * Chart::CELLS + charts[chart].cell(d)
        });
        counts[cell] += 1.0;
    }

    // What is expected: the density integrated over each cell, finely where it changes.
    let mut expected: Vec<f64> = (0..all)
        .map(|i| {
            let (chart, cell) = (&charts[i / Chart::CELLS], i % Chart::CELLS);
            let coarse = chart.expected(cell, cuts, &pdf) * SAMPLES as f64;
            // What was missed by all points.
            let missed = coarse < 1.0 && counts[i] > 0.0;
            if missed { chart.expected(cell, 16, &pdf) * SAMPLES as f64 } else { coarse }
        })
        .collect();
    let total: f64 = expected.iter().sum();
    assert!(total < SAMPLES as f64 * 1.005, "the density integrates to {}", total / SAMPLES as f64);
    expected.push((SAMPLES as f64 - total).max(0.0));

    // Cells with few expected samples are pooled: the statistic is normal only from five on.
    let (mut statistic, mut cells) = (0.0, 0.0);
    let (mut pooled_count, mut pooled_expected) = (0.0, 0.0);
    let mut term = |count: f64, expected: f64| {
        statistic += (count - expected) * (count - expected) / expected;
        cells += 1.0;
    };
    for (&count, &expected) in counts.iter().zip(&expected) {
        if expected >= 20.0 {
            term(count, expected);
        } else {
            pooled_count += count;
            pooled_expected += expected;
        }
    }
    if pooled_expected >= 5.0 {
        term(pooled_count, pooled_expected);
    } else {
        // Hardly any are expected; a few may have been rounded over a border of the density.
        assert!(
            pooled_count <= 60.0,
            "{pooled_count} samples where {pooled_expected} are expected"
        );
    }
    if cells > 1.0 { chi_square_tail(cells - 1.0, statistic) } else { 1.0 }
}

/// The mean of `f` over the directions of a sphere, weighted by solid angle: ∫ f dω, by stratified points.
pub fn integrate_sphere(f: impl Fn(Vec3) -> Spectrum) -> [f64; 3] {
    let n = 400;
    let mut sum = [0.0; 3];
    for i in 0..n * n {
        let (x, y) =
            ((f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n));
        let z = 1.0 - 2.0 * y;
        let (s, c) = (2.0 * PI * x).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let value = f(Vec3::new((r * c) as f32, (r * s) as f32, z as f32));
        for (sum, v) in sum.iter_mut().zip(value.channels()) {
            *sum += f64::from(v) * 4.0 * PI / f64::from(n * n);
        }
    }
    sum
}

/// Renders `scene` with some settings.
pub fn render(scene: &Scene, settings: Settings) -> Image {
    render_prepared(Prepared::new(scene).expect("a sound scene"), settings)
}

/// The same of what is prepared.
pub fn render_prepared(scene: impl Into<Arc<Prepared>>, settings: Settings) -> Image {
    let session = Session::start(scene.into(), settings, 2).expect("sound settings");
    while !session.wait(Duration::from_secs(3600)) {}
    assert_eq!(session.progress().dropped.count, 0, "samples were no numbers");
    session.snapshot()
}

/// Mean of a channel over the whole image, and the standard error of that mean.
pub fn mean(image: &Image, channel: &str) -> (f64, f64) {
    let values = image.channel(channel).expect("such a channel");
    let variances = image.channel(&format!("variance.{channel}")).expect("its variance");
    let n = values.len() as f64;
    let sum = |v: &[f32]| v.iter().map(|&x| f64::from(x)).sum::<f64>();
    (sum(values) / n, sum(variances).sqrt() / n)
}

/// A small picture with independent samples, as statistical tests want it.
pub fn small(spp: u64) -> Settings {
    Settings { size: [16, 16], spp, sampler: SamplerKind::Independent, ..Settings::default() }
}

/// Asserts that every channel's mean is `expected`, within `sigmas` standard errors and one part in 10⁴.
#[track_caller]
pub fn assert_mean(image: &Image, expected: f64, sigmas: f64) {
    for channel in ["R", "G", "B"] {
        let (mean, error) = mean(image, channel);
        let tolerance = sigmas * error + 1e-4 * expected;
        assert!(
            (mean - expected).abs() <= tolerance,
            "{channel}: {mean} ± {error}, expected {expected}"
        );
    }
}
