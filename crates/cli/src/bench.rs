//! `rutilant bench`: how fast is it, in numbers that can be compared.

use crate::failure::{Exit, Failure};
use crate::load::{self, timed};
use crate::options;
use crate::say::{print_json, print_line};
use crate::text::{bytes, count, time};
use rutilant_geom::lanes::LANES;
use rutilant_geom::{HitPacket, Ray, RayPacket, Surfaces, Vec3};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[derive(clap::Subcommand)]
pub(crate) enum Mode {
    /// Million rays per second over saved triangles and rays, closest and any hit
    #[command(after_help = FILES)]
    Rays(RaysArgs),
}

const FILES: &str = "\
All files hold 32-bit little-endian floating-point numbers and nothing else.
TRIS: 9 for each triangle, three corners.
RAYS: 8 for each ray: origin, t_min, direction, t_max.
Speeds are medians over the repetitions. Hits and the sum of distances show whether two tracers agree.";

#[derive(clap::Args)]
pub(crate) struct RaysArgs {
    /// Triangles
    #[arg(value_name = "TRIS")]
    triangles: PathBuf,
    /// Sets of rays
    #[arg(value_name = "RAYS", required = true)]
    rays: Vec<PathBuf>,
    /// Threads that build and trace
    #[arg(long, value_name = "N", value_parser = options::threads, default_value_t = 1)]
    threads: usize,
    /// Instructions that rays are traced with
    #[arg(long, value_name = "NAME", value_enum, default_value_t = options::SimdLevel::Auto)]
    simd: options::SimdLevel,
    /// How much time the tree is worth
    #[arg(long, value_name = "NAME", value_enum, default_value_t = options::Build::Default)]
    build: options::Build,
    /// How often each set is traced
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repetitions: u32,
    /// Print one line of JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Report {
    triangles: usize,
    threads: usize,
    repetitions: u32,
    build_seconds: f64,
    nodes: u64,
    sah_cost: f64,
    bytes: u64,
    sets: Vec<Set>,
}

/// What one set of rays found, and how fast.
#[derive(Serialize)]
struct Set {
    file: PathBuf,
    rays: usize,
    closest_mrays_per_second: f64,
    any_mrays_per_second: f64,
    /// The same with each ray traced alone.
    closest_alone_mrays_per_second: f64,
    any_alone_mrays_per_second: f64,
    /// Rays that hit something.
    hits: u64,
    /// Of the closest hits.
    sum_of_t: f64,
    /// Rays that the any-hit query says are blocked; equal to `hits`.
    blocked: u64,
}

pub(crate) fn run(mode: &Mode) -> Result<Exit, Failure> {
    match mode {
        Mode::Rays(args) => rays(args),
    }
}

fn rays(args: &RaysArgs) -> Result<Exit, Failure> {
    load::use_threads(args.threads)?;
    let corners = read_numbers::<9>(&args.triangles, "triangles of nine numbers")?;
    let sets = args.rays.iter().map(|path| read_rays(path)).collect::<Result<Vec<_>, _>>()?;

    let triangles = corners.len();
    let positions: Vec<Vec3> = corners
        .iter()
        .flat_map(|c| [0, 3, 6].map(|i| Vec3::new(c[i], c[i + 1], c[i + 2])))
        .collect();
    let last = u32::try_from(positions.len()).map_err(|_| Failure::usage("too many triangles"))?;
    let indices: Vec<[u32; 3]> = (0..last).step_by(3).map(|i| [i, i + 1, i + 2]).collect();
    let (surfaces, building) =
        timed(|| Surfaces::new(positions, indices, Vec::new(), Vec::new(), &args.build.into()));
    let surfaces = surfaces.with_simd(args.simd.into()).ok_or_else(|| args.simd.missing())?;

    let built = surfaces.report();
    let mut report = Report {
        triangles,
        threads: args.threads,
        repetitions: args.repetitions,
        build_seconds: building.as_secs_f64(),
        nodes: built.nodes as u64,
        sah_cost: built.sah_cost,
        bytes: built.bytes as u64,
        sets: Vec::new(),
    };
    if !args.json {
        print_line(&format!(
            "{} triangles: built in {} by {} thread{}, {} nodes, SAH cost {:.2}, {}",
            count(triangles as u64),
            time(building),
            args.threads,
            if args.threads == 1 { "" } else { "s" },
            count(report.nodes),
            report.sah_cost,
            bytes(report.bytes),
        ))?;
        print_line(&format!(
            "{:<28}{:>10}{:>16}{:>8}{:>14}{:>8}{:>10}{:>14}{:>10}",
            "set",
            "rays",
            "closest Mray/s",
            "alone",
            "any Mray/s",
            "alone",
            "hits",
            "sum of t",
            "blocked"
        ))?;
    }
    for (file, rays) in args.rays.iter().zip(&sets) {
        let set = measure(args, &surfaces, file, rays);
        if !args.json {
            print_line(&format!(
                "{:<28}{:>10}{:>16.2}{:>8.2}{:>14.2}{:>8.2}{:>10}{:>14.1}{:>10}",
                file.file_name().unwrap_or_default().to_string_lossy(),
                set.rays,
                set.closest_mrays_per_second,
                set.closest_alone_mrays_per_second,
                set.any_mrays_per_second,
                set.any_alone_mrays_per_second,
                set.hits,
                set.sum_of_t,
                set.blocked,
            ))?;
        }
        report.sets.push(set);
    }
    if args.json {
        print_json(&report)?;
    }
    Ok(Exit::Done)
}

/// Traces a set again and again, closest and any hit, eight rays at once and each alone in turn, so
/// that a disturbance meets all.
fn measure(args: &RaysArgs, surfaces: &Surfaces, file: &Path, rays: &[Ray]) -> Set {
    let mut times = [const { Vec::new() }; 4];
    let (mut found, mut blocked) = (Found::default(), Found::default());
    for _ in 0..args.repetitions {
        let runs = [
            trace(args.threads, rays, |rays, found| {
                let hits = surfaces.closest_packet(&RayPacket::new(rays));
                for lane in 0..rays.len() {
                    if hits.primitive[lane] != HitPacket::NOTHING {
                        found.add(hits.t[lane]);
                    }
                }
            }),
            trace(args.threads, rays, |rays, found| {
                found.hits +=
                    u64::from(surfaces.occluded_packet(&RayPacket::new(rays)).count_ones());
            }),
            trace(args.threads, rays, |rays, found| {
                for hit in rays.iter().filter_map(|ray| surfaces.closest(ray)) {
                    found.add(hit.t);
                }
            }),
            trace(args.threads, rays, |rays, found| {
                found.hits += rays.iter().filter(|ray| surfaces.occluded(ray)).count() as u64;
            }),
        ];
        (found, blocked) = (runs[0].0, runs[1].0);
        for (times, (_, time)) in times.iter_mut().zip(runs) {
            times.push(time);
        }
    }
    let rate = |times| rays.len() as f64 / median(times).as_secs_f64().max(1e-9) * 1e-6;
    let [closest, any, closest_alone, any_alone] = times.map(rate);
    Set {
        file: file.to_owned(),
        rays: rays.len(),
        closest_mrays_per_second: closest,
        any_mrays_per_second: any,
        closest_alone_mrays_per_second: closest_alone,
        any_alone_mrays_per_second: any_alone,
        hits: found.hits,
        sum_of_t: found.sum_of_t,
        blocked: blocked.hits,
    }
}

#[derive(Clone, Copy, Default)]
struct Found {
    hits: u64,
    sum_of_t: f64,
}

impl Found {
    fn add(&mut self, t: f32) {
        self.hits += 1;
        self.sum_of_t += f64::from(t);
    }
}

/// Traces every ray once, by up to eight, shared out over `threads` in equal runs; the time is that
/// of the slowest.
fn trace(
    threads: usize,
    rays: &[Ray],
    query: impl Fn(&[Ray], &mut Found) + Sync,
) -> (Found, Duration) {
    let run = |rays: &[Ray]| {
        rays.chunks(LANES).fold(Found::default(), |mut found, rays| {
            query(rays, &mut found);
            found
        })
    };
    let start = Instant::now();
    let parts: Vec<Found> = if threads == 1 {
        vec![run(rays)]
    } else {
        let chunk = rays.len().div_ceil(threads).max(1);
        std::thread::scope(|scope| {
            let workers: Vec<_> =
                rays.chunks(chunk).map(|part| scope.spawn(move || run(part))).collect();
            workers.into_iter().filter_map(|worker| worker.join().ok()).collect()
        })
    };
    let time = start.elapsed();
    let sum = parts.into_iter().fold(Found::default(), |a, b| Found {
        hits: a.hits + b.hits,
        sum_of_t: a.sum_of_t + b.sum_of_t,
    });
    (sum, time)
}

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times.get(times.len() / 2).copied().unwrap_or_default()
}

/// Rays whose numbers can be traced.
fn read_rays(path: &Path) -> Result<Vec<Ray>, Failure> {
    let rays = read_numbers::<8>(path, "rays of eight numbers")?;
    let ray = |(i, r): (usize, [f32; 8])| {
        let ray = Ray {
            origin: Vec3::new(r[0], r[1], r[2]),
            direction: Vec3::new(r[4], r[5], r[6]),
            t_min: r[3],
            t_max: r[7],
        };
        match fault(&ray) {
            None => Ok(ray),
            Some(what) => Err(Failure::usage(format!("{}: ray {i}: {what}", path.display()))),
        }
    };
    rays.into_iter().enumerate().map(ray).collect()
}

/// Why a ray cannot be traced.
fn fault(ray: &Ray) -> Option<String> {
    let Ray { origin, direction, t_min, t_max } = *ray;
    if !origin.is_finite() {
        Some(format!("origin is {origin}, but must be finite"))
    } else if !direction.is_finite() {
        Some(format!("direction is {direction}, but must be finite"))
    } else if direction == Vec3::ZERO {
        Some("direction is 0, but must point somewhere".to_owned())
    } else if t_min.is_nan() || t_min < 0.0 {
        Some(format!("t_min is {t_min}, but must be 0 or more"))
    } else if t_max.is_nan() {
        Some("t_max is NaN, but must be a number".to_owned())
    } else {
        None
    }
}

/// A file of 32-bit numbers in groups of `N`.
fn read_numbers<const N: usize>(path: &Path, what: &str) -> Result<Vec<[f32; N]>, Failure> {
    let refused =
        |what: &dyn std::fmt::Display| Failure::usage(format!("{}: {what}", path.display()));
    // A pipe may never end.
    if !std::fs::metadata(path).map_err(|error| refused(&error))?.is_file() {
        return Err(refused(&"not a regular file"));
    }
    let bytes = std::fs::read(path).map_err(|error| refused(&error))?;
    let (numbers, rest) = bytes.as_chunks::<4>();
    let numbers: Vec<f32> = numbers.iter().map(|b| f32::from_le_bytes(*b)).collect();
    match numbers.as_chunks::<N>() {
        (groups, []) if rest.is_empty() => Ok(groups.to_vec()),
        _ => Err(refused(&format!(
            "{} bytes do not make whole {what} of four bytes each",
            bytes.len()
        ))),
    }
}
