//! Proves the renderer against itself, against closed forms and against others.
//!
//! [`scenes`] is a list of small scenes that between them use everything, and
//! [`matrix`] renders each in every way there is. [`agreement`] decides, by
//! statistics and not by a tolerance, whether two estimates of the same picture
//! agree. [`references`] are scenes of other people with pictures that other
//! renderers made of them. The program of this crate writes all of it into a report.

pub mod agreement;
pub mod matrix;
pub mod references;
pub mod report;
pub mod scenes;
