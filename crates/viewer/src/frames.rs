//! How long frames of the interface take.

use std::time::Duration;

/// Frames are counted by tenths of a millisecond, up to a tenth of a second.
const BINS: usize = 1000;
const BIN: Duration = Duration::from_micros(100);

/// Times of all frames so far, in bounded memory.
#[derive(Clone, Debug)]
pub struct FrameTimes {
    bins: Vec<u64>,
    longest: Duration,
}

impl Default for FrameTimes {
    fn default() -> Self {
        Self { bins: vec![0; BINS + 1], longest: Duration::ZERO }
    }
}

impl FrameTimes {
    pub(crate) fn add(&mut self, time: Duration) {
        let bin = (time.as_micros() / BIN.as_micros()).min(BINS as u128);
        self.bins[bin as usize] += 1;
        self.longest = self.longest.max(time);
    }

    /// How many frames there were.
    pub fn count(&self) -> u64 {
        self.bins.iter().sum()
    }

    /// The longest of them.
    pub fn longest(&self) -> Duration {
        self.longest
    }

    /// So long took at most that part of all frames, to a tenth of a millisecond.
    pub fn quantile(&self, part: f64) -> Duration {
        let enough = (part * self.count() as f64).ceil() as u64;
        let mut sum = 0;
        let bin = self.bins.iter().position(|n| {
            sum += n;
            sum >= enough
        });
        match bin {
            Some(bin) if bin < BINS => (BIN * (bin as u32 + 1)).min(self.longest),
            Some(_) | None => self.longest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a hundred frames of 1 to 100 ms half take at most 50, and 99 at most 99.
    #[test]
    fn quantiles_are_of_all_frames() {
        let mut times = FrameTimes::default();
        (0..100).for_each(|i| times.add(Duration::from_micros(1000 * i + 950)));
        assert_eq!(times.count(), 100);
        assert_eq!(times.quantile(0.5), Duration::from_millis(50));
        assert_eq!(times.quantile(0.99), Duration::from_millis(99));
        assert_eq!(times.longest(), Duration::from_micros(99_950));
        times.add(Duration::from_secs(5));
        assert_eq!(times.quantile(1.0), Duration::from_secs(5));
        assert_eq!(FrameTimes::default().quantile(0.5), Duration::ZERO);
    }
}
