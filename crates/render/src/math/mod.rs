//! Small mathematics shared by everything above geometry.

pub mod warp;
