//! Small mathematics shared by everything above geometry.

pub mod distribution;
pub mod lat_long;
pub mod warp;
