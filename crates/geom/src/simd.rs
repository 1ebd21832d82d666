//! How many things the processor does at once.
//!
//! It decides how fast rays are, and never what they find: whatever is done
//! eight at a time only sorts out what is certainly missed.

use fearless_simd::Level;

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
            Self::Auto => Some(if std::env::var_os("A512").is_some() { best } else { avx2(best).unwrap_or(best) }),
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
