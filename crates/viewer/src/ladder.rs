//! At which resolution the first picture after a change is rendered.
//!
//! A sample for every pixel of a large picture takes longer than one likes to
//! wait. So the first picture has fewer pixels: as many as are done within a
//! twentieth of a second, or in less where an edit of the scene took some of
//! it, as far as one can tell from what came before. Each rung has twice the
//! width and height of the one below, up to the picture itself, which then
//! gathers samples.

use std::time::Duration;

/// So long the first picture may take.
const FIRST: Duration = Duration::from_millis(50);

/// So long it may take together with what is done to the scene before it.
const WITH_EDIT: Duration = Duration::from_millis(80);

/// But this much it gets in any case: few pixels are as good as none.
const LEAST: Duration = Duration::from_millis(10);

/// The lowest rung: a sixteenth of the width and height.
const LOWEST: u32 = 16;

/// Where to begin while nothing is known of the speed.
const UNKNOWN: u32 = 8;

/// How fast samples come, learned on the way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ladder {
    /// Samples per second.
    rate: Option<f64>,
}

impl Ladder {
    /// So many samples were taken in such a time.
    pub(crate) fn learn(&mut self, samples: u64, took: Duration) {
        let rate = samples as f64 / took.as_secs_f64().max(1e-4);
        // What is in view changes by the moment: the last rung counts as much as all before.
        self.rate = Some(self.rate.map_or(rate, |old| (old * rate).sqrt()));
    }

    /// What the sides of a picture of `size` pixels are divided by in its first rendering, when
    /// `gone` of the time is over.
    pub(crate) fn first(&self, size: [u32; 2], gone: Duration) -> u32 {
        let Some(rate) = self.rate else { return UNKNOWN };
        let left = WITH_EDIT.saturating_sub(gone).clamp(LEAST, FIRST);
        let affordable = rate * left.as_secs_f64();
        let pixels = |divisor: u32| {
            let [w, h] = reduced(size, divisor);
            f64::from(w) * f64::from(h)
        };
        let mut divisor = 1;
        while divisor < LOWEST && pixels(divisor) > affordable {
            divisor *= 2;
        }
        divisor
    }
}

/// The size of a picture whose sides are divided.
pub(crate) fn reduced(size: [u32; 2], divisor: u32) -> [u32; 2] {
    size.map(|side| side.div_ceil(divisor).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slow scene begins coarser than a fast one; a small picture is rendered as it is; nothing
    /// begins below the lowest rung.
    #[test]
    fn the_first_rung_is_affordable() {
        let mut ladder = Ladder::default();
        assert_eq!(ladder.first([1280, 720], Duration::ZERO), UNKNOWN);
        let second = Duration::from_secs(1);
        for (rate, expected) in
            [(100_000_000, 1), (8_000_000, 2), (1_500_000, 4), (400_000, 8), (100, LOWEST)]
        {
            ladder = Ladder::default();
            ladder.learn(rate, second);
            assert_eq!(ladder.first([1280, 720], Duration::ZERO), expected, "{rate}");
        }
        // An edit that took all of the time leaves a fifth of it.
        ladder = Ladder::default();
        ladder.learn(8_000_000, second);
        assert_eq!(ladder.first([1280, 720], Duration::from_millis(500)), 4);
        assert_eq!(ladder.first([1, 1], Duration::ZERO), 1);
        assert_eq!(reduced([1, 7], 16), [1, 1]);
        assert_eq!(reduced([100, 101], 4), [25, 26]);
    }

    /// It follows a change of speed within a few rungs, and one outlier does not throw it far.
    #[test]
    fn it_learns() {
        let mut ladder = Ladder::default();
        ladder.learn(8_000_000, Duration::from_secs(1));
        for _ in 0..6 {
            ladder.learn(100_000, Duration::from_secs(1));
        }
        assert!(ladder.first([1280, 720], Duration::ZERO) >= 8);
        ladder.learn(10, Duration::ZERO);
        assert!(ladder.first([1280, 720], Duration::ZERO) <= LOWEST);
    }
}
