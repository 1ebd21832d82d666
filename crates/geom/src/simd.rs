//! How many things the processor does at once.
//!
//! It decides how fast rays are, and never what they find: whatever is done
//! eight at a time only sorts out what is certainly missed.

use fearless_simd::Level;

/// Evaluates an expression with the vector instructions of a level, which the name before the arrow
/// stands for in it, or the other expression where there are none or none are wanted. A copy is
/// compiled for each level, of everything that is inlined into it.
///
/// Like [`fearless_simd::dispatch`], but for the levels of [`Simd`] alone: others gain nothing here
/// and would take long to compile.
#[macro_export]
macro_rules! with_vectors {
    ($level:expr, $simd:ident => $op:expr, else $other:expr) => {{
        use fearless_simd::Simd as _;
        let level = $level;
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            if let Some($simd) = level.as_avx2() {
                $simd.vectorize(
                    #[inline(always)]
                    || $op,
                )
            } else if let Some($simd) = level.as_sse4_2() {
                $simd.vectorize(
                    #[inline(always)]
                    || $op,
                )
            } else {
                $other
            }
        }
        #[cfg(target_arch = "aarch64")]
        {
            if let Some($simd) = level.as_neon() {
                $simd.vectorize(
                    #[inline(always)]
                    || $op,
                )
            } else {
                $other
            }
        }
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64", target_arch = "aarch64")))]
        {
            let _ = level;
            $other
        }
    }};
}

/// The instructions that traversal uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Simd {
    /// The best there are.
    #[default]
    Auto,
    /// One thing at a time, on any processor.
    Scalar,
    /// Four at a time: x86-64 processors since 2008.
    Sse4,
    /// Eight at a time: most x86-64 processors since 2013.
    Avx2,
}

impl Simd {
    /// `None` where the processor has no such instructions.
    pub(crate) fn level(self) -> Option<Level> {
        let best = Level::new();
        match self {
            // Wider vectors gain nothing: a node has eight boxes.
            Self::Auto => Some(avx2(best).unwrap_or(best)),
            Self::Scalar => Some(Level::fallback()),
            Self::Sse4 => sse4(best),
            Self::Avx2 => avx2(best),
        }
    }
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn avx2(best: Level) -> Option<Level> {
    best.as_avx2().map(Level::Avx2)
}

#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
fn sse4(best: Level) -> Option<Level> {
    best.as_sse4_2().map(Level::Sse4_2)
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn avx2(_: Level) -> Option<Level> {
    None
}

#[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
fn sse4(_: Level) -> Option<Level> {
    None
}
