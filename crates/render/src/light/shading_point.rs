//! A point that lights shine on, as choosing between them sees it.

use rutilant_geom::Vec3;

/// A point that lights shine on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadingPoint {
    /// Where.
    pub position: Vec3,
    /// The unit normal on the side from which light counts; zero where it counts from everywhere.
    pub normal: Vec3,
}

impl ShadingPoint {
    /// A point on which light counts from everywhere.
    pub fn open(position: Vec3) -> Self {
        Self { position, normal: Vec3::ZERO }
    }
}
