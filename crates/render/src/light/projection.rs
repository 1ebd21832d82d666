//! How the directions of a sky lie on a picture.
//!
//! A picture holds one chart or several: rectangles of pixels that between them show every
//! direction once. Beyond each edge of a chart another one goes on, or the same one elsewhere.

use crate::math::{cube, lat_long, octahedral};
use rutilant_geom::{DVec3, Vec2, Vec3, real};
use std::f32::consts::PI;

/// How the directions of a sky lie on a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Projection {
    /// A latitude-longitude map of any size: its upper edge is +y, its middle −z, +x lies to the
    /// right of that.
    #[default]
    Equirectangular,
    /// An equal-area octahedral map, which is square: its middle is +y, the middles of its right
    /// and lower edges are +x and +z, its corners are −y. These are the maps of pbrt-v4, whose z is
    /// up here and whose y is z: pbrt is left-handed, and so nothing is mirrored.
    Octahedral,
    /// Six square faces of a cube, oriented as OpenGL's: upright or lying crosses, or strips in the
    /// order +x, −x, +y, −y, +z, −z.
    Cube,
}

/// Where the charts stand in a picture.
#[derive(Clone, Copy, Debug)]
struct Layout {
    /// Columns and rows of places for a chart.
    places: [u32; 2],
    /// The column and row of each chart.
    charts: &'static [[usize; 2]],
    /// The chart that stands on its head.
    turned: Option<usize>,
}

/// A single chart fills the picture.
const WHOLE: Layout = Layout { places: [1, 1], charts: &[[0, 0]], turned: None };

/// The faces of a cube. In crosses +z is in the middle of the band around the horizon, and edges
/// that touch go on; that is why the foot of the upright one is turned.
const CUBES: [Layout; 4] = [
    Layout {
        places: [4, 3],
        charts: &[[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]],
        turned: None,
    },
    Layout {
        places: [3, 4],
        charts: &[[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]],
        turned: Some(5),
    },
    Layout {
        places: [6, 1],
        charts: &[[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [5, 0]],
        turned: None,
    },
    Layout {
        places: [1, 6],
        charts: &[[0, 0], [0, 1], [0, 2], [0, 3], [0, 4], [0, 5]],
        turned: None,
    },
];

impl Projection {
    /// The projection that a picture of `size` pixels most likely has, by its proportions alone:
    /// squares are octahedral, crosses and strips of squares are cubes, all else is
    /// equirectangular.
    pub fn likely(size: [u32; 2]) -> Self {
        let [width, height] = size;
        if width == height && width > 0 {
            Self::Octahedral
        } else if Self::Cube.charts(size).is_ok() {
            Self::Cube
        } else {
            Self::Equirectangular
        }
    }

    /// The charts of a picture of `size` pixels, not 0.
    ///
    /// # Errors
    /// Says which sizes there are, where this one is none of them.
    pub(super) fn charts(self, size: [u32; 2]) -> Result<Charts, String> {
        let [width, height] = size;
        let of = |layout: &Layout| {
            let [columns, rows] = layout.places;
            [width / columns, height / rows]
        };
        let layout = match self {
            Self::Equirectangular => &WHOLE,
            Self::Octahedral if width == height => &WHOLE,
            Self::Octahedral => {
                return Err(format!(
                    "an octahedral map is a square, but the image has {width}x{height} pixels"
                ));
            }
            Self::Cube => {
                let fits = |layout: &&Layout| {
                    let ([columns, rows], [w, h]) = (layout.places, of(layout));
                    w == h && w > 0 && [columns * w, rows * h] == size
                };
                CUBES.iter().find(fits).ok_or_else(|| {
                    format!(
                        "the faces of a cube are 4x3 or 3x4 squares (a cross) or 6x1 or 1x6 (a \
                         strip), but the image has {width}x{height} pixels"
                    )
                })?
            }
        };
        let [chart_width, chart_height] = of(layout).map(|side| side as usize);
        Ok(Charts {
            projection: self,
            layout: *layout,
            width: chart_width,
            height: chart_height,
            picture_width: width as usize,
        })
    }
}

/// The charts of a picture, all of one size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Charts {
    projection: Projection,
    layout: Layout,
    /// Pixels of a chart from left to right.
    pub(super) width: usize,
    /// And from top to bottom.
    pub(super) height: usize,
    picture_width: usize,
}

impl Charts {
    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.layout.charts.len()
    }

    /// The number of a chart's pixel in the picture.
    pub(super) fn pixel(&self, chart: usize, column: usize, row: usize) -> usize {
        let (place, turned) = (self.layout.charts[chart], self.layout.turned == Some(chart));
        let (column, row) =
            if turned { (self.width - 1 - column, self.height - 1 - row) } else { (column, row) };
        (place[1] * self.height + row) * self.picture_width + place[0] * self.width + column
    }

    /// The pixels whose mean stands at a column and row of a chart, of which there are one more to
    /// each side than the chart has: where two edges meet, three faces of a cube do.
    pub(super) fn pixels_at(&self, chart: usize, column: isize, row: isize) -> Vec<usize> {
        let (width, height) = (self.width as isize, self.height as isize);
        let pixel = |(chart, column, row): (usize, isize, isize)| {
            self.pixel(chart, column as usize, row as usize)
        };
        match self.projection {
            Projection::Equirectangular => {
                // Columns go round, rows go over the pole to the other side.
                let (column, row) = match row {
                    r if r < 0 => (column + width / 2, -1 - r),
                    r if r >= height => (column + width / 2, 2 * height - 1 - r),
                    r => (column, r),
                };
                vec![pixel((chart, column.rem_euclid(width), row))]
            }
            Projection::Octahedral => {
                // Each edge is folded onto itself.
                let (column, row) = match row {
                    r if r < 0 || r >= height => (width - 1 - column, r.clamp(0, height - 1)),
                    r => (column, r),
                };
                let (column, row) = match column {
                    c if c < 0 || c >= width => (c.clamp(0, width - 1), height - 1 - row),
                    c => (c, row),
                };
                vec![pixel((chart, column, row))]
            }
            Projection::Cube => {
                let (inner_column, inner_row) =
                    (column.clamp(0, width - 1), row.clamp(0, height - 1));
                let around = |column, row| pixel(self.over_the_edge(chart, column, row));
                if inner_column != column && inner_row != row {
                    vec![
                        around(inner_column, inner_row),
                        around(column, inner_row),
                        around(inner_column, row),
                    ]
                } else {
                    vec![around(column, row)]
                }
            }
        }
    }

    /// The face, column and row of a pixel that may lie one step beyond one edge of a cube's face.
    fn over_the_edge(&self, face: usize, column: isize, row: isize) -> (usize, isize, isize) {
        let n = self.width as isize;
        // Twice the distance from the middle of a face whose edges are n away from it: whole
        // numbers far below 2²⁴, with which single precision is exact.
        let from_middle = |i: isize| (2 * i + 1 - n) as f32;
        let (side, edge) = (n as f32, Vec2::splat(n as f32));
        let on_plane = Vec2::new(from_middle(column), from_middle(row));
        let within = on_plane.clamp(-edge, edge);
        let beyond = on_plane - within;
        if beyond == Vec2::ZERO {
            return (face, column, row);
        }
        // What reaches beyond the edge is folded down.
        let [middle, right, down] = cube::FACES[face];
        let outward = (right * beyond.x + down * beyond.y).normalize();
        let p = middle * (side - beyond.abs().max_element()) + right * within.x + down * within.y;
        let face = cube::face_of(outward);
        let [_, right, down] = cube::FACES[face];
        let place = |along: f32| (along as isize + n - 1) / 2;
        (face, place(p.dot(right)), place(p.dot(down)))
    }

    /// The solid angles of the pixels in a row of any chart, in sr.
    pub(super) fn solid_angles(&self, row: usize) -> Vec<f64> {
        let (width, height) = (self.width as f64, self.height as f64);
        match self.projection {
            Projection::Equirectangular => {
                let edge = |r: usize| f64::from(real::cos(PI * r as f32 / self.height as f32));
                let band = (edge(row) - edge(row + 1)).abs() * 2.0 * f64::from(PI);
                vec![band / width; self.width]
            }
            Projection::Octahedral => {
                vec![1.0 / (f64::from(octahedral::UV_PER_SOLID_ANGLE) * width * height); self.width]
            }
            Projection::Cube => {
                let edge = |i: usize| 2.0 * i as f64 / width - 1.0;
                let rows = [edge(row), edge(row + 1)];
                (0..self.width).map(|c| on_a_face([edge(c), edge(c + 1)], rows)).collect()
            }
        }
    }

    /// The chart that shows a unit direction, and where: both coordinates in [0, 1).
    pub(super) fn find(&self, d: Vec3) -> (usize, Vec2) {
        match self.projection {
            Projection::Equirectangular => (0, lat_long::uv_from_direction(d)),
            Projection::Octahedral => (0, octahedral::uv_from_direction(y_for_z(d))),
            Projection::Cube => cube::uv_from_direction(d),
        }
    }

    /// The unit direction that a point of a chart shows.
    pub(super) fn direction(&self, chart: usize, uv: Vec2) -> Vec3 {
        match self.projection {
            Projection::Equirectangular => lat_long::direction_from_uv(uv),
            Projection::Octahedral => y_for_z(octahedral::direction_from_uv(uv)),
            Projection::Cube => cube::direction_from_uv(chart, uv),
        }
    }

    /// How much of its chart a unit of solid angle covers around a unit direction.
    pub(super) fn uv_per_solid_angle(&self, d: Vec3) -> f32 {
        match self.projection {
            Projection::Equirectangular => lat_long::uv_per_solid_angle(d),
            Projection::Octahedral => octahedral::UV_PER_SOLID_ANGLE,
            Projection::Cube => cube::uv_per_solid_angle(d),
        }
    }
}

/// From a world with z up to one with y up, of the other hand; and back.
fn y_for_z(d: Vec3) -> Vec3 {
    Vec3::new(d.x, d.z, d.y)
}

/// The solid angle, in sr, of a rectangle on the plane z = 1, seen from the origin.
///
/// Source: Van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983. The triple
/// product of two triangles that are halves of the rectangle is its area.
fn on_a_face(x: [f64; 2], y: [f64; 2]) -> f64 {
    let area = (x[1] - x[0]) * (y[1] - y[0]);
    let corner = |i: usize, j: usize| DVec3::new(x[i], y[j], 1.0);
    let triangle = |[a, b, c]: [DVec3; 3]| {
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * f64::from(real::atan2(area as f32, below as f32))
    };
    triangle([corner(0, 0), corner(1, 0), corner(1, 1)])
        + triangle([corner(0, 0), corner(1, 1), corner(0, 1)])
}
