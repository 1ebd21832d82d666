//! Where samples become pixels.

mod filter;

pub use filter::Filter;
