//! Small mathematics shared by everything above geometry.

pub mod distribution;
pub mod warp;
