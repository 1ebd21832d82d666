//! What is said while a picture is being rendered: a bar for people, lines of JSON for programs.

use crate::failure::Failure;
use crate::say::{print_json, tell};
use crate::text::{count, scaled, time};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use rutilant::Progress;
use serde::Serialize;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Style {
    /// A bar on standard error, if that is a terminal
    Bar,
    /// One JSON object per line on standard output, and the result as the last of them
    Json,
    /// Nothing
    None,
}

/// Tells how a rendering goes on.
pub(crate) struct Reporter {
    view: View,
    start: Instant,
    goal: Goal,
}

/// When a rendering will be done: by samples or by the clock, whichever comes first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// Pixels that are rendered.
    pub pixels: u64,
    /// Samples for each of them; `None` when time alone decides.
    pub spp: Option<u64>,
    /// Time from the start.
    pub time: Option<Duration>,
}

enum View {
    Bar(ProgressBar),
    Json { next: Duration },
    None,
}

/// One update.
#[derive(Serialize)]
struct Update {
    event: &'static str,
    /// Samples done in every pixel.
    samples: u64,
    /// Samples that are wanted; absent when time decides.
    target: Option<u64>,
    /// 0 to 1.
    done: f64,
    seconds: f64,
    seconds_left: Option<f64>,
    paths: u64,
    paths_per_second: f64,
    rays: u64,
    rays_per_second: f64,
    dropped: u64,
}

impl Reporter {
    /// A reporter that counts time from now.
    pub(crate) fn start(style: Style, goal: Goal) -> Self {
        let view = match style {
            Style::Bar if std::io::stderr().is_terminal() => View::Bar(bar()),
            Style::Json => View::Json { next: Duration::ZERO },
            Style::Bar | Style::None => View::None,
        };
        Self { view, start: Instant::now(), goal }
    }

    /// Time since the start.
    pub(crate) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Shows the state of the rendering.
    pub(crate) fn update(&mut self, progress: &Progress) -> Result<(), Failure> {
        /// Programs get this many updates a second at most.
        const JSON_PERIOD: Duration = Duration::from_millis(250);
        let elapsed = self.elapsed();
        let update = self.goal.measure(progress, elapsed);
        match &mut self.view {
            View::Bar(bar) => {
                bar.set_position((update.done * BAR_STEPS as f64) as u64);
                bar.set_message(update.line());
            }
            View::Json { next } if elapsed >= *next || progress.finished => {
                *next = elapsed + JSON_PERIOD;
                print_json(&update)?;
            }
            View::Json { .. } | View::None => {}
        }
        Ok(())
    }

    /// A line for people that stays above the bar.
    pub(crate) fn say(&self, line: &str) {
        match &self.view {
            View::Bar(bar) => bar.suspend(|| tell(line)),
            View::Json { .. } | View::None => tell(line),
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
        }
    }
}

impl Goal {
    fn measure(&self, progress: &Progress, elapsed: Duration) -> Update {
        let seconds = elapsed.as_secs_f64();
        let rate = |n: u64| if seconds > 0.0 { n as f64 / seconds } else { 0.0 };
        let by_samples = self.spp.map(|spp| {
            let all = spp as f64 * self.pixels as f64;
            (progress.paths as f64 / all, (all - progress.paths as f64) / rate(progress.paths))
        });
        let by_clock = self.time.map(|limit| {
            let limit = limit.as_secs_f64();
            (seconds / limit, limit - seconds)
        });
        let (done, left) = match (by_samples, by_clock) {
            (Some(a), Some(b)) => (a.0.max(b.0), a.1.min(b.1)),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => (0.0, f64::INFINITY),
        };
        Update {
            event: "progress",
            samples: progress.samples,
            target: self.spp,
            done: if progress.finished { 1.0 } else { done.min(1.0) },
            seconds,
            seconds_left: left.is_finite().then_some(left.max(0.0)),
            paths: progress.paths,
            paths_per_second: rate(progress.paths),
            rays: progress.rays,
            rays_per_second: rate(progress.rays),
            dropped: progress.dropped.count,
        }
    }
}

impl Update {
    /// `48/64 spp  3.41 Msamples/s  12.1 Mrays/s  0.8 s left`.
    fn line(&self) -> String {
        let of = self.target.map(|target| format!("/{}", count(target))).unwrap_or_default();
        let mut line = format!(
            "{}{of} spp  {}samples/s  {}rays/s",
            count(self.samples),
            scaled(self.paths_per_second),
            scaled(self.rays_per_second)
        );
        if let Some(left) = self.seconds_left.filter(|left| *left > 0.0) {
            line += &format!("  {} left", time(Duration::from_secs_f64(left.min(1e9))));
        }
        if self.dropped > 0 {
            line += &format!("  {} dropped", count(self.dropped));
        }
        line
    }
}

/// How finely the bar moves.
const BAR_STEPS: u64 = 1000;

fn bar() -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:28.yellow} {percent:>3}%  {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar())
        .progress_chars("━╸─");
    let bar = ProgressBar::new(BAR_STEPS).with_style(style);
    bar.set_message("first samples …");
    bar
}

/// A turning sign with a word, while there is nothing to count. Gone when dropped.
pub(crate) struct Spinner(Option<ProgressBar>);

impl Spinner {
    /// Starts turning, if `style` is a bar and there is a terminal.
    pub(crate) fn start(style: Style, word: &str) -> Self {
        let shown = style == Style::Bar && std::io::stderr().is_terminal();
        Self(shown.then(|| {
            let spinner = ProgressBar::new_spinner().with_message(word.to_owned());
            spinner.enable_steady_tick(Duration::from_millis(100));
            spinner
        }))
    }
}

impl Drop for Spinner {
    fn drop(&mut self) {
        if let Some(spinner) = &self.0 {
            spinner.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rutilant::film::Dropped;

    fn progress(paths: u64) -> Progress {
        let dropped = Dropped { count: 0, first: None };
        Progress {
            samples: paths / 100,
            target: 64,
            pass: paths / 100 + 1,
            finished: false,
            paths,
            rays: 0,
            dropped,
            panicked: false,
        }
    }

    /// A quarter of the samples after 2 s leaves 6 s; a clock that strikes earlier wins.
    #[test]
    fn the_nearer_end_counts() {
        let two = Duration::from_secs(2);
        let samples = Goal { pixels: 100, spp: Some(64), time: None };
        let update = samples.measure(&progress(1600), two);
        assert_eq!((update.done, update.seconds_left), (0.25, Some(6.0)));

        let both = Goal { time: Some(Duration::from_secs(4)), ..samples };
        let update = both.measure(&progress(1600), two);
        assert_eq!((update.done, update.seconds_left), (0.5, Some(2.0)));

        let clock = Goal { spp: None, ..both };
        let update = clock.measure(&progress(0), Duration::from_secs(5));
        assert_eq!((update.done, update.seconds_left, update.target), (1.0, Some(0.0), None));
    }

    /// Before the first sample nobody knows.
    #[test]
    fn at_the_start_no_time_is_promised() {
        let goal = Goal { pixels: 100, spp: Some(64), time: None };
        assert_eq!(goal.measure(&progress(0), Duration::ZERO).seconds_left, None);
    }
}
