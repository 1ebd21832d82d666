//! The decisions along a path, each with random numbers of its own.

/// Where within the pixel's filter.
pub(crate) const FILM: u32 = 0;
/// Where on the lens.
pub(crate) const LENS: u32 = 1;

/// The decisions at the end of a path's `depth`-th segment, from 1.
#[derive(Clone, Copy)]
pub(crate) struct Bounce(u32);

impl Bounce {
    pub(crate) fn at(depth: u32) -> Self {
        Self(5_u32.wrapping_mul(depth.wrapping_sub(1)).wrapping_add(2))
    }

    /// Which of the BSDF's ways to scatter.
    pub(crate) fn lobe(self) -> u32 {
        self.0
    }

    /// The scattered direction.
    pub(crate) fn direction(self) -> u32 {
        self.0.wrapping_add(1)
    }

    /// Which light.
    pub(crate) fn light(self) -> u32 {
        self.0.wrapping_add(2)
    }

    /// Where on that light.
    pub(crate) fn light_point(self) -> u32 {
        self.0.wrapping_add(3)
    }

    /// Whether the path goes on.
    pub(crate) fn roulette(self) -> u32 {
        self.0.wrapping_add(4)
    }
}
