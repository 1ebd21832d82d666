//! A bounding volume hierarchy: a tree of boxes around primitives.
//!
//! The tree knows only boxes and numbers. Who owns the primitives gives their
//! boxes to [`Bvh::build`], makes an eight-wide tree of the binary one, and
//! meets the primitives itself when a ray comes to a leaf. What a ray finds
//! never depends on the shape of the tree: boxes are only left out where no hit
//! can be.

mod binary;
mod build;
mod built;
mod node;
mod optimize;
mod traverse;
mod wide;

pub use binary::{Bvh, MAX_DEPTH};
pub use build::{BuildOptions, Quality};
pub use built::{BuildReport, LeftOut};
pub use node::{Content, Node, Siblings};
pub(crate) use traverse::{
    BoxRay, BoxRays, Met, Order, RoomyBoxRay, SLACK, Visit, limit_of, traverse, traverse_in_turn,
    traverse_packet, way,
};
pub(crate) use wide::{Inside, PACK, WIDTH, WideNode, report, widened};
