//! Proofs over all maps from the unit square. A new one joins by a line.

#![expect(clippy::disallowed_methods, reason = "expected values are computed in f64")]

mod common;

use common::{chi_square, family_wise, random};
use rutilant::geom::{Vec2, Vec3};
use rutilant::math::warp;

type Map = fn(Vec2) -> Vec3;
type Density = fn(Vec3) -> f32;

/// Directions follow the stated density.
#[test]
fn directions_follow_the_density() {
    let upper = |d: Vec3, pdf: f32| if d.z >= 0.0 { pdf } else { 0.0 };
    let all: [(&str, Map, Density); 3] = [
        ("cosine hemisphere", warp::cosine_hemisphere, |d| warp::cosine_hemisphere_pdf(d.z)),
        ("uniform sphere", warp::uniform_sphere, |_| warp::UNIFORM_SPHERE_PDF),
        ("uniform hemisphere", warp::uniform_hemisphere, |_| warp::UNIFORM_HEMISPHERE_PDF),
    ];
    for (stream, (name, map, pdf)) in all.into_iter().enumerate() {
        let whole = name == "uniform sphere";
        let density = |d: Vec3| if whole { pdf(d) } else { upper(d, pdf(d)) };
        let p = chi_square(stream as u64, |_, u| Some(map(u)), density);
        assert!(p > family_wise(all.len()), "{name}: p = {p:e}");
    }
}

/// Points of a triangle are spread evenly: the mean of each barycentric weight is 1/3, its second
/// moment 1/6. The old program's means were 1/2, 1/4, 1/4.
#[test]
fn triangles_are_covered_evenly() {
    let n = 400_000_u64;
    let (mut mean, mut square) = ([0.0; 3], [0.0; 3]);
    for i in 0..n {
        let b = warp::uniform_triangle(random(1, i).1);
        assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0);
        for (k, w) in [1.0 - b.x - b.y, b.x, b.y].into_iter().enumerate() {
            mean[k] += f64::from(w) / n as f64;
            square[k] += f64::from(w * w) / n as f64;
        }
    }
    let three_sigma = 3.0 * (1.0 / 18.0 / n as f64).sqrt();
    for k in 0..3 {
        assert!((mean[k] - 1.0 / 3.0).abs() < three_sigma, "{mean:?}");
        assert!((square[k] - 1.0 / 6.0).abs() < three_sigma, "{square:?}");
    }
}

/// Points of a disk are spread evenly: a quarter of them within half the radius, and the mean
/// square of each coordinate is 1/4.
#[test]
fn disks_are_covered_evenly() {
    let n = 400_000_u64;
    let (mut inner, mut square) = (0.0, [0.0; 2]);
    for i in 0..n {
        let p = warp::concentric_disk(random(2, i).1);
        assert!(p.length() <= 1.0 + 1e-6);
        inner += f64::from(u8::from(p.length() < 0.5)) / n as f64;
        square[0] += f64::from(p.x * p.x) / n as f64;
        square[1] += f64::from(p.y * p.y) / n as f64;
    }
    assert!((inner - 0.25).abs() < 3.0 * (0.1875 / n as f64).sqrt(), "{inner}");
    assert!(
        square.iter().all(|s| (s - 0.25).abs() < 3.0 * (0.0625 / n as f64).sqrt()),
        "{square:?}"
    );
}

/// Points of a polygon are spread evenly and stay within it: the means are 0, the mean squares
/// (1 − ⅔ sin²(π/n)) / 4, and each of its triangles gets its share.
#[test]
fn polygons_are_covered_evenly() {
    let n = 400_000_u64;
    for corners in [3_u32, 4, 5, 6, 17] {
        let wedge = 2.0 * std::f64::consts::PI / f64::from(corners);
        let (mut mean, mut square, mut shares) = ([0.0; 2], [0.0; 2], vec![0.0; corners as usize]);
        for i in 0..n {
            let p = warp::concentric_polygon(random(3, i).1, corners);
            let (x, y) = (f64::from(p.x), f64::from(p.y));
            for (k, v) in [x, y].into_iter().enumerate() {
                mean[k] += v / n as f64;
                square[k] += v * v / n as f64;
            }
            // From the corner at the top, counter-clockwise.
            let angle = (-x).atan2(y).rem_euclid(2.0 * std::f64::consts::PI);
            let which = (angle / wedge) as usize;
            shares[which.min(corners as usize - 1)] += 1.0 / n as f64;
            let middle = (which as f64 + 0.5) * wedge;
            let height = y * middle.cos() - x * middle.sin();
            assert!(height <= (0.5 * wedge).cos() + 1e-6, "{p} is outside {corners} corners");
        }
        let expected = 0.25 * (1.0 - 2.0 / 3.0 * (0.5 * wedge).sin().powi(2));
        // A square's spread is at most 1/4, a mean's variance at most that of a coordinate.
        let four_sigma = 4.0 * (0.25 / n as f64).sqrt();
        assert!(mean.iter().all(|m| m.abs() < four_sigma), "{corners}: {mean:?}");
        assert!(square.iter().all(|s| (s - expected).abs() < four_sigma), "{corners}: {square:?}");
        let share = 1.0 / f64::from(corners);
        assert!(shares.iter().all(|s| (s - share).abs() < four_sigma), "{corners}: {shares:?}");
    }
}

/// The corners, edges and centre of the square give points that are numbers.
#[test]
fn edges_of_the_square_are_finite() {
    let below_one = 1.0 - 0.5 * f32::EPSILON;
    for x in [0.0, 0.25, 0.5, below_one] {
        for y in [0.0, 0.5, 0.75, below_one] {
            let u = Vec2::new(x, y);
            assert!(warp::concentric_disk(u).is_finite() && warp::uniform_triangle(u).is_finite());
            assert!(warp::concentric_polygon(u, 5).length() <= 1.0 + 1e-6);
            for d in
                [warp::cosine_hemisphere(u), warp::uniform_sphere(u), warp::uniform_hemisphere(u)]
            {
                assert!((d.length() - 1.0).abs() < 1e-5, "{u}: {d}");
            }
        }
    }
}
