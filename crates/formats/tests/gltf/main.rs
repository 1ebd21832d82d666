//! What glTF documents mean, and what is said of those that mean nothing.

mod builder;
mod real;
