//! What is computed along each camera ray.

mod caustics;
mod control;
mod debug;
pub(crate) mod dimension;
mod direct;
mod emission;
mod estimate;
mod first;
mod naive;
mod optimal;
mod packet;
mod path;
mod witness;

pub(crate) use caustics::Caustics;
pub(crate) use debug::{Albedo, AmbientOcclusion, Depth, Normals};
pub(crate) use direct::Direct;
pub(crate) use estimate::{Found, Integrator};
pub(crate) use first::{First, NOTHING, View};
pub(crate) use naive::Naive;
pub(crate) use optimal::Optimal;
pub(crate) use packet::Starts;
pub(crate) use path::Path;
