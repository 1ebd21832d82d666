//! pbrt's scenes, of version 4 and what is common of version 3: statements in plain text.
//!
//! Statements change a state and add things to a [`description`](description::Description), in one
//! loop over all files (`parser.rs`). Then [`scene`] makes a scene of it: the world is turned into
//! right-handed coordinates, meshes are read, materials become those that there are here, and light is
//! what pbrt's film would show of it. What is left out is told, each kind of thing once.
//!
//! Source: Pharr, Jakob, Humphreys, *pbrt-v4 input file format*, pbrt.org/fileformat-v4;
//! *pbrt-v3 input file format*, pbrt.org/fileformat-v3; docs/pbrt.md has what is read.

mod camera;
mod description;
mod film;
mod gzip;
mod lexer;
mod lights;
mod materials;
mod parameters;
mod parser;
pub(crate) mod scene;
mod shapes;
mod spectra;
mod state;
mod textures;
