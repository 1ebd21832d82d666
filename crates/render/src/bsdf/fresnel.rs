//! How much light a smooth border reflects.

/// Which formula gives the reflected part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fresnel {
    /// The Fresnel equations for unpolarised light.
    Exact,
    /// Schlick's approximation, on the transmitted side's cosine inside the denser medium.
    Schlick,
}
