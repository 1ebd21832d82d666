//! The Z-order curve.

/// Where (`x`, `y`) stands on a curve that goes through each aligned square of 2ᵏ × 2ᵏ places
/// before it leaves it.
///
/// Source: Morton, "A Computer Oriented Geodetic Data Base", IBM, 1966.
pub(crate) fn morton(x: u32, y: u32) -> u64 {
    let spread = |v: u32| {
        let mut v = u64::from(v);
        for (shift, mask) in [
            (16, 0x0000_ffff_0000_ffff_u64),
            (8, 0x00ff_00ff_00ff_00ff),
            (4, 0x0f0f_0f0f_0f0f_0f0f),
            (2, 0x3333_3333_3333_3333),
            (1, 0x5555_5555_5555_5555),
        ] {
            v = (v | v << shift) & mask;
        }
        v
    };
    spread(x) | spread(y) << 1
}
