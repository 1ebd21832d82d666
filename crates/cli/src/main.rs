//! The command line of Rutilant.
mod compare;
fn main() {}
