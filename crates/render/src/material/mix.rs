//! Two materials in some proportion.

use crate::id::MaterialId;

/// `1 - amount` of the first material and `amount` of the second.
///
/// A matte material mixed with a mirror is the 2017 report's "specular
/// component". Emission of the parts is not mixed in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// What there is when `amount` is 0.
    pub first: MaterialId,
    /// What there is when `amount` is 1.
    pub second: MaterialId,
    /// The share of the second, 0 to 1.
    pub amount: f32,
}
