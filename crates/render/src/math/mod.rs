//! Small mathematics shared by everything above geometry.

pub mod cube;
pub mod distribution;
pub mod lat_long;
mod morton;
pub mod octahedral;
mod spherical;
pub mod warp;

pub(crate) use morton::{from_morton, morton};
pub(crate) use spherical::SphericalTriangle;
