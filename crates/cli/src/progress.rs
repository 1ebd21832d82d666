//! What is said while a picture is being rendered: a bar for people, lines of JSON for programs.

use crate::failure::Failure;
use crate::shim::Progress;
use crate::text::{count, scaled, time};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
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
    limit: Option<Duration>,
    /// Paths at the last change, and when that was: rates are taken there, since
    /// numbers only change with the end of a pass.
    last: (u64, Duration),
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
    /// A reporter that counts time from now. `limit` is when the rendering will be stopped.
    pub(crate) fn start(style: Style, limit: Option<Duration>) -> Self {
        let view = match style {
            Style::Bar if std::io::stderr().is_terminal() => View::Bar(bar()),
            Style::Json => View::Json { next: Duration::ZERO },
            Style::Bar | Style::None => View::None,
        };
        Self { view, start: Instant::now(), limit, last: (0, Duration::ZERO) }
    }

    /// Time since the start.
    pub(crate) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }

    /// Shows the state of the rendering. `unbounded` when only time ends it.
    pub(crate) fn update(&mut self, progress: &Progress, unbounded: bool) -> Result<(), Failure> {
        /// Programs get this many updates a second at most.
        const JSON_PERIOD: Duration = Duration::from_millis(250);
        let elapsed = self.elapsed();
        if progress.stats.paths != self.last.0 {
            self.last = (progress.stats.paths, elapsed);
        }
        match &mut self.view {
            View::None => return Ok(()),
            View::Json { next } if elapsed < *next && !progress.finished => return Ok(()),
            View::Json { next } => *next = elapsed + JSON_PERIOD,
            View::Bar(_) => {}
        }
        let update = self.measure(progress, elapsed, unbounded);
        match &self.view {
            View::Bar(bar) => {
                bar.set_position((update.done * BAR_STEPS as f64) as u64);
                bar.set_message(update.line());
            }
            View::Json { .. } => crate::print_json(&update)?,
            View::None => {}
        }
        Ok(())
    }

    fn measure(&self, progress: &Progress, elapsed: Duration, unbounded: bool) -> Update {
        let stats = &progress.stats;
        let counted = self.last.1.as_secs_f64();
        let rate = |n: u64| if counted > 0.0 { n as f64 / counted } else { 0.0 };

        // The samples or the clock: whichever will be done first.
        let seconds = elapsed.as_secs_f64();
        let by_samples = progress.samples as f64 / progress.target.max(1) as f64;
        let by_clock = self.limit.map(|limit| seconds / limit.as_secs_f64());
        let done = by_clock.unwrap_or(0.0).max(by_samples).min(1.0);
        let left_by_samples = (by_samples > 0.0).then(|| (counted / by_samples - seconds).max(0.0));
        let left_by_clock = self.limit.map(|l| l.saturating_sub(elapsed).as_secs_f64());
        let seconds_left = match (left_by_samples, left_by_clock) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };

        Update {
            event: "progress",
            samples: progress.samples,
            target: (!unbounded).then_some(progress.target),
            done: if progress.finished { 1.0 } else { done },
            seconds,
            seconds_left,
            paths: stats.paths,
            paths_per_second: rate(stats.paths),
            rays: stats.rays,
            rays_per_second: rate(stats.rays),
            dropped: stats.dropped,
        }
    }

    /// A line for people that stays above the bar.
    pub(crate) fn say(&self, line: &str) {
        match &self.view {
            View::Bar(bar) => bar.suspend(|| eprintln!("{line}")),
            View::Json { .. } | View::None => eprintln!("{line}"),
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let View::Bar(bar) = &self.view {
            bar.finish_and_clear();
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
        if let Some(left) = self.seconds_left {
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
