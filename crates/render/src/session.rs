//! A rendering that runs: start it, look at it, end it, go on.
//!
//! The one render loop there is; command line, window and scripts all hold a
//! [`Session`]. It works in passes that bring every pixel to the same number
//! of samples. Where a session was interrupted or continued leaves no trace
//! in the picture.

use crate::cpu::{Counters, Rendering};
use crate::film::{Dropped, Film, Splats};
use crate::image::Image;
use crate::prepare::{Casting, Prepared};
use crate::scene::{Place, SceneProblem};
use crate::settings::Settings;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// A rendering in the background. Dropping it stops it.
#[derive(Debug)]
pub struct Session {
    shared: Arc<Shared>,
    worker: Option<JoinHandle<()>>,
}

/// How far a rendering has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Samples that every pixel has.
    pub samples: u64,
    /// Samples that every pixel is to have.
    pub target: u64,
    /// Samples that every pixel will have after the pass in flight, the soonest end.
    pub pass: u64,
    /// True when nothing is being rendered any more: the target is reached, or it was stopped.
    pub finished: bool,
    /// Camera paths traced, one for each sample of each pixel.
    pub paths: u64,
    /// Rays traced.
    pub rays: u64,
    /// Samples that were no numbers.
    pub dropped: Dropped,
    /// True when it ended because something panicked: a custom shape or material. The picture so
    /// far is whole.
    pub panicked: bool,
}

#[derive(Debug)]
struct Shared {
    scene: Arc<Prepared>,
    settings: Settings,
    threads: usize,
    film: Film,
    counters: Counters,
    /// Leaves the pass in flight undone.
    stop: AtomicBool,
    state: Mutex<State>,
    /// Told whenever `state` changes.
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    target: u64,
    /// Samples that the pass in flight brings every pixel to.
    pass: u64,
    /// Set when no further pass shall begin.
    ending: bool,
    running: bool,
    panicked: bool,
}

impl Session {
    /// Starts rendering `scene` with this many threads (at least one).
    ///
    /// # Errors
    /// What [`Settings::validate`] finds, and more pixels than there is room for with the scene's light
    /// groups.
    pub fn start(
        scene: Arc<Prepared>,
        settings: Settings,
        threads: usize,
    ) -> Result<Self, SceneProblem> {
        settings.validate()?;
        let scene = Arc::new(Arc::unwrap_or_clone(scene).on_film(settings.size));
        let window = settings.window();
        let casting = scene.casting().filter(|_| settings.traces_light());
        let planned = settings.planned_spp.unwrap_or(settings.spp);
        let layers = settings.kept_layers();
        let groups = &scene.groups().names()[..scene.told_groups(layers)];
        check_room(&settings, groups.len())?;
        let splats =
            |c: &Casting| Splats::new(window, settings.size, c.brightest, planned, groups.len());
        let splats = casting.map(splats);
        let shared = Arc::new(Shared {
            film: Film::new(window, settings.learns(), splats, layers, groups),
            state: Mutex::new(State {
                target: settings.spp,
                pass: 0,
                ending: false,
                running: false,
                panicked: false,
            }),
            threads: threads.max(1),
            counters: Counters::default(),
            stop: AtomicBool::new(false),
            changed: Condvar::new(),
            scene,
            settings,
        });
        let mut session = Self { shared, worker: None };
        session.resume();
        Ok(session)
    }

    /// How far it has come.
    pub fn progress(&self) -> Progress {
        let (target, pass, finished, panicked) = {
            let state = self.shared.state();
            (state.target, state.pass, !state.running, state.panicked)
        };
        let (paths, rays) = self.shared.counters.so_far();
        Progress {
            samples: self.shared.film.samples(),
            target,
            pass,
            finished,
            paths,
            rays,
            dropped: self.shared.film.dropped(),
            panicked,
        }
    }

    /// The picture so far: channels `R`, `G`, `B`, the variance of each pixel's mean as
    /// `variance.R`, `variance.G`, `variance.B`, the number of samples in it as `samples.Y`, and those
    /// of the [`Layer`](crate::settings::Layer)s that were asked for.
    pub fn snapshot(&self) -> Image {
        self.shared.film.image(self.shared.scene.ids())
    }

    /// Waits until nothing is being rendered any more, but not longer than `timeout`. Returns
    /// whether it is finished.
    pub fn wait(&self, timeout: Duration) -> bool {
        let state = self.shared.state();
        let (state, _) = self
            .shared
            .changed
            .wait_timeout_while(state, timeout, |state| state.running)
            .unwrap_or_else(PoisonError::into_inner);
        !state.running
    }

    /// Ends the rendering after the pass in flight, so that all pixels have equally many samples.
    pub fn finish_pass(&self) {
        self.shared.state().ending = true;
    }

    /// Ends the rendering as soon as each thread has finished a few samples of its tile. Pixels may have different
    /// numbers of samples; [`extend`](Self::extend) evens them out.
    pub fn cancel(&self) {
        self.shared.state().ending = true;
        self.shared.stop.store(true, Ordering::Relaxed);
    }

    /// Goes on to `spp` samples per pixel, or to what was asked for before if that is more.
    pub fn extend(&mut self, spp: u64) {
        let running = {
            let mut state = self.shared.state();
            state.target = state.target.max(spp);
            // A thread that was told to end will end, and a new one begins after it.
            state.running && !state.ending
        };
        if !running {
            self.resume();
        }
    }

    /// Starts the background thread anew.
    fn resume(&mut self) {
        self.join();
        self.shared.stop.store(false, Ordering::Relaxed);
        {
            let mut state = self.shared.state();
            (state.ending, state.running, state.panicked) = (false, true, false);
        }
        let shared = Arc::clone(&self.shared);
        self.worker = Some(std::thread::spawn(move || {
            let _running = Running(&shared);
            let Shared { scene, settings, film, threads, stop, counters, .. } = &*shared;
            Rendering { scene, settings, film, threads: *threads, stop, counters }
                .run(|| shared.next_pass());
        }));
    }

    fn join(&mut self) {
        if let Some(worker) = self.worker.take() {
            // A panic in there has been printed, and is told by `progress`.
            drop(worker.join());
        }
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.cancel();
        self.join();
    }
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of samples that the next pass brings every pixel to, if there is one. When
    /// there is none the session no longer counts as running, in the same breath: a target that
    /// is raised later finds it ended.
    fn next_pass(&self) -> Option<u64> {
        /// In a pass each thread traces about this many rays: enough to outweigh its start, and few
        /// enough to be over soon when it is to be the last.
        const RAYS_EACH: u64 = 1 << 21;
        /// A pass is at most so many times as long as all before it.
        const LEAP: u64 = 8;
        let window = self.settings.window();
        let pixels = u64::from(window.width) * u64::from(window.height);
        let done = self.film.samples();
        // As the passes before went, so will the next; of the first nothing is known.
        let (paths, rays) = self.counters.so_far();
        let rays_per_sample = rays as f64 / paths.max(1) as f64 * pixels as f64;
        let affordable = RAYS_EACH as f64 * self.threads as f64 / rays_per_sample.max(1.0);
        // A few paths tell little of how long all will be.
        let samples = (affordable as u64).min(LEAP * done).max(1);
        let mut state = self.state();
        if state.ending || done >= state.target {
            state.running = false;
            self.changed.notify_all();
            return None;
        }
        state.pass = state.target.min(done + samples);
        Some(state.pass)
    }
}

/// The most sums of light groups that are kept at once, one for each group of each pixel: they take
/// 13 GB, and twice as much where light paths find caustics.
const MOST_GROUP_SUMS: u64 = 1 << 29;

/// Whether there is room for so many groups of lights in each pixel.
fn check_room(settings: &Settings, groups: usize) -> Result<(), SceneProblem> {
    let window = settings.window();
    let pixels = u64::from(window.width) * u64::from(window.height);
    let most = MOST_GROUP_SUMS / (groups as u64).max(1);
    if pixels <= most {
        return Ok(());
    }
    Err(Place::Settings.problem(
        "layers",
        format!(
            "{pixels} pixels are too many to render at once with {groups} light groups; at most {most} \
             are, use crops"
        ),
    ))
}

/// Marks the session as ended when its thread ends, however that happens.
struct Running<'a>(&'a Shared);

impl Drop for Running<'_> {
    fn drop(&mut self) {
        let mut state = self.0.state();
        (state.running, state.panicked) = (false, std::thread::panicking());
        drop(state);
        self.0.changed.notify_all();
    }
}
