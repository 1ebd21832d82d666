//! How a surface scatters light at a point.

mod fresnel;

pub use fresnel::Fresnel;
