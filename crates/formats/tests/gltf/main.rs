//! What glTF documents mean, and what is said of those that mean nothing.

mod builder;
mod errors;
mod meaning;
mod poses;
mod real;
mod scenes;
