//! The Z-order curve.

/// Where (`x`, `y`) stands on a curve that goes through each aligned square of 2ᵏ × 2ᵏ places
/// before it leaves it.
///
/// Source: Morton, "A Computer Oriented Geodetic Data Base", IBM, 1966.
pub(crate) fn morton(x: u32, y: u32) -> u64 {
    let spread = |v: u64, steps: &[(u32, u64)]| {
        steps.iter().fold(v, |v, (shift, mask)| (v | v << shift) & mask)
    };
    if (x | y) >> 16 == 0 {
        // Both at once.
        let both = spread(u64::from(y) << 32 | u64::from(x), &STEPS[1..]);
        both & 0xffff_ffff | both >> 31
    } else {
        spread(x.into(), &STEPS) | spread(y.into(), &STEPS) << 1
    }
}

/// Each half of a number, of half a number, and so on is moved away from the other.
const STEPS: [(u32, u64); 5] = [
    (16, 0x0000_ffff_0000_ffff),
    (8, 0x00ff_00ff_00ff_00ff),
    (4, 0x0f0f_0f0f_0f0f_0f0f),
    (2, 0x3333_3333_3333_3333),
    (1, 0x5555_5555_5555_5555),
];

/// The place, at most 2¹⁶ from each axis, that is number `i` on the curve.
pub(crate) fn from_morton(i: u32) -> [u32; 2] {
    let gathered = |v: u32| {
        let v = v & 0x5555_5555;
        let v = (v | v >> 1) & 0x3333_3333;
        let v = (v | v >> 2) & 0x0f0f_0f0f;
        let v = (v | v >> 4) & 0x00ff_00ff;
        (v | v >> 8) & 0x0000_ffff
    };
    [gathered(i), gathered(i >> 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bits of both coordinates in turn, small and large.
    #[test]
    fn bits_in_turn() {
        for (x, y) in [(0, 0), (1, 0), (0, 1), (0xffff, 0xabcd), (0x1_2345, 7), (u32::MAX, 1 << 31)]
        {
            let bit =
                |i: u32| u64::from(x >> i & 1) << (2 * i) | u64::from(y >> i & 1) << (2 * i + 1);
            assert_eq!(morton(x, y), (0..32).map(bit).sum::<u64>(), "{x} {y}");
            if (x | y) >> 16 == 0 {
                assert_eq!(from_morton(morton(x, y) as u32), [x, y]);
            }
        }
    }
}
