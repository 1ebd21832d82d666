//! Proves the renderer against itself and against closed forms.
//!
//! [`scenes`] is a list of small scenes that between them use everything.
//! [`agreement`] decides, by statistics and not by a tolerance, whether two
//! estimates of the same picture agree.

pub mod agreement;
pub mod scenes;
