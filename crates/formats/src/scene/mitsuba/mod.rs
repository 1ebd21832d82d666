//! Mitsuba's scenes: XML of Mitsuba 3, and the common part of that of 0.6 (docs/mitsuba.md).
//!
//! A text becomes elements with places (`xml`), these become objects with properties (`document`),
//! and they a scene (`scene`, with a file for each class of objects). Of what is not shown a note
//! tells, each kind once.
//!
//! Source: Jakob, Speierer, Roussel, Vicini, *Mitsuba 3 documentation*, 2022; Jakob, *Mitsuba
//! documentation*, version 0.6, 2014.

mod bsdf;
mod document;
mod emitter;
mod parameters;
pub(crate) mod scene;
mod sensor;
pub mod serialized;
mod shape;
mod texture;
mod value;
mod xml;
