//! The rendering behind the window: a thread that holds a session and always
//! works on the newest wish.
//!
//! The window says what it wants to see ([`Wish`]) and takes what has become of
//! it ([`Shown`]); neither waits for the other. Whatever changes the picture
//! starts a new session with a film of its own, so no sample of before can get
//! into it. The first picture after a change has few pixels (`ladder.rs`) and
//! is finished even if the next wish is already there: while something is
//! dragged, pictures keep coming.

use crate::ladder::{Ladder, reduced};
use crate::picture::{Developed, View, develop, filled};
use rutilant::cryptomatte;
use rutilant::display::Display;
use rutilant::focus::Focus;
use rutilant::image::Image;
use rutilant::scene::{Scene, SceneProblem};
use rutilant::settings::{IntegratorKind, Layer, Layers, Settings};
use rutilant::{Prepared, Progress, Session};
use rutilant_formats::Look;
use rutilant_formats::camera::AuthoredCamera;
use rutilant_geom::Vec2;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// More samples than anybody waits for.
const ENDLESS: u64 = 1 << 32;

/// How often the session is looked at.
const PERIOD: Duration = Duration::from_millis(4);

/// A scene that rays can go through.
pub(crate) struct Stage {
    pub(crate) scene: Scene,
    pub(crate) prepared: Arc<Prepared>,
    /// What `prepared` was made for.
    pub(crate) look: Arc<Look>,
}

/// What the window wants to see.
#[derive(Clone)]
pub(crate) struct Wish {
    pub(crate) look: Arc<Look>,
    pub(crate) view: View,
    pub(crate) paused: bool,
    /// Go on beyond the samples that the scene asks for.
    pub(crate) endless: bool,
    /// A picture to compare with.
    pub(crate) beside: Option<Arc<Image>>,
}

impl Wish {
    /// Whether it asks for exactly what another asks for.
    pub(crate) fn is_same_as(&self, other: &Self) -> bool {
        let same_beside = match (&self.beside, &other.beside) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        };
        let how = |wish: &Self| (wish.view, wish.paused, wish.endless);
        Arc::ptr_eq(&self.look, &other.look) && how(self) == how(other) && same_beside
    }
}

/// A picture that is to be rendered as the command line would, in place of what the window shows.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    pub(crate) settings: Settings,
    /// How it is shown to eyes, where the file is for these.
    pub(crate) display: Display,
    /// Where it is to be written.
    pub(crate) file: PathBuf,
    /// What the file's header has to say of its mattes, once it has begun.
    pub(crate) mattes: Vec<(String, String)>,
}

/// How far a [`Job`] has come.
#[derive(Clone, Debug)]
pub(crate) enum JobState {
    /// It has not begun.
    Waiting,
    Running {
        progress: Progress,
    },
    /// The picture, to be written by whoever asked for it.
    Done {
        image: Arc<Image>,
        job: Job,
        took: Duration,
    },
    Failed {
        what: String,
    },
}

/// What has become of a wish.
#[derive(Clone)]
pub(crate) struct Shown {
    /// Counts pictures.
    pub(crate) number: u64,
    /// What it shows.
    pub(crate) look: Arc<Look>,
    /// How it was rendered.
    pub(crate) settings: Arc<Settings>,
    /// Whether the rendering was over, and nothing is missing.
    #[cfg_attr(not(test), expect(dead_code, reason = "tests wait for it"))]
    pub(crate) finished: bool,
    pub(crate) picture: Arc<Developed>,
    /// The picture beside it.
    pub(crate) beside: Option<Arc<Developed>>,
}

/// How the rendering is going.
#[derive(Clone, Debug, Default)]
pub(crate) struct Status {
    pub(crate) progress: Option<Progress>,
    /// What the sides of the picture are divided by: 1 for the full picture.
    pub(crate) divisor: u32,
    /// Time spent on it, without pauses.
    pub(crate) spent: Duration,
    /// Why the newest wish cannot be shown.
    pub(crate) problem: Option<SceneProblem>,
    /// What a person should know.
    pub(crate) notes: Vec<String>,
}

/// What the two threads tell each other.
struct Shared {
    inbox: Mutex<Inbox>,
    /// Told when something comes into the inbox.
    told: Condvar,
    shown: Mutex<Option<Shown>>,
    status: Mutex<Status>,
    job: Mutex<Option<JobState>>,
    /// What is seen at the place that was asked for.
    focus: Mutex<Option<Option<Focus>>>,
    /// Wakes the window.
    wake: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct Inbox {
    stage: Option<Box<Stage>>,
    wish: Option<Wish>,
    images: Vec<Arc<Image>>,
    job: Option<Job>,
    stop_job: bool,
    /// A place of the picture to focus on.
    focus: Option<Vec2>,
    quit: bool,
}

/// Leaves the processor to the interface where both want it. On Linux this counts for the thread
/// that calls and for those that it starts; elsewhere it would count for the whole program.
fn step_back() {
    #[cfg(target_os = "linux")]
    // Whoever may not be nicer renders as before.
    let _ = rustix::process::nice(NICER);
}

/// By how much rendering steps back: at each core the interface gets some four times its share.
#[cfg(target_os = "linux")]
const NICER: i32 = 6;

/// The window's end of it. Dropping it ends the rendering.
pub(crate) struct Live {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Live {
    /// Starts the thread; sessions have `threads` threads of their own. `wake` is called whenever
    /// there is something new to be shown.
    pub(crate) fn start(threads: usize, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let shared = Arc::new(Shared {
            inbox: Mutex::default(),
            told: Condvar::new(),
            shown: Mutex::default(),
            status: Mutex::default(),
            job: Mutex::default(),
            focus: Mutex::default(),
            wake: Box::new(wake),
        });
        let theirs = Arc::clone(&shared);
        let thread = std::thread::spawn(move || {
            step_back();
            Worker::new(theirs, threads).run();
        });
        Self { shared, thread: Some(thread) }
    }

    /// Another scene. What was asked for before is forgotten.
    pub(crate) fn stage(&self, stage: Stage, wish: Wish) {
        self.tell(|inbox| {
            inbox.images.clear();
            inbox.focus = None;
            if inbox.job.take().is_some() {
                let what = "another scene was opened before it began".to_owned();
                *locked(&self.shared.job) = Some(JobState::Failed { what });
            }
            inbox.stage = Some(Box::new(stage));
            inbox.wish = Some(wish);
        });
    }

    /// The newest wish; those that were not heard yet are forgotten.
    pub(crate) fn wish(&self, wish: Wish) {
        self.tell(|inbox| inbox.wish = Some(wish));
    }

    /// Another image behind those that the scene has.
    pub(crate) fn add_image(&self, image: Arc<Image>) {
        self.tell(|inbox| inbox.images.push(image));
    }

    /// Renders a picture for a file; false, and nothing, where another is on its way.
    pub(crate) fn begin_job(&self, job: Job) -> bool {
        {
            let mut state = locked(&self.shared.job);
            if state.is_some() {
                return false;
            }
            *state = Some(JobState::Waiting);
        }
        self.tell(|inbox| (inbox.job, inbox.stop_job) = (Some(job), false));
        true
    }

    /// Gives up the picture for a file.
    pub(crate) fn stop_job(&self) {
        self.tell(|inbox| (inbox.job, inbox.stop_job) = (None, true));
    }

    /// Looks for what is seen at a place of the picture, from (0, 0) to (1, 1).
    pub(crate) fn find_focus(&self, place: Vec2) {
        self.tell(|inbox| inbox.focus = Some(place));
    }

    /// What was found there, told once; `Some(None)` where there is nothing to focus on.
    pub(crate) fn focus(&self) -> Option<Option<Focus>> {
        locked(&self.shared.focus).take()
    }

    /// The newest picture.
    pub(crate) fn shown(&self) -> Option<Shown> {
        locked(&self.shared.shown).clone()
    }

    /// Whether the thread has ended on its own: it never should.
    pub(crate) fn is_broken(&self) -> bool {
        self.thread.as_ref().is_some_and(JoinHandle::is_finished)
    }

    pub(crate) fn status(&self) -> Status {
        locked(&self.shared.status).clone()
    }

    /// How far the picture for a file has come. What is done is told once.
    pub(crate) fn job(&self) -> Option<JobState> {
        let mut job = locked(&self.shared.job);
        match &*job {
            Some(JobState::Waiting | JobState::Running { .. }) => job.clone(),
            Some(JobState::Done { .. } | JobState::Failed { .. }) | None => job.take(),
        }
    }

    fn tell(&self, what: impl FnOnce(&mut Inbox)) {
        what(&mut locked(&self.shared.inbox));
        self.shared.told.notify_one();
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.tell(|inbox| inbox.quit = true);
        if let Some(thread) = self.thread.take() {
            // A panic in there has been printed.
            drop(thread.join());
        }
    }
}

/// A session, and what it is for.
struct Running {
    session: Session,
    look: Arc<Look>,
    settings: Arc<Settings>,
    /// What it renders instead of what the scene asks for.
    integrator: Option<IntegratorKind>,
    divisor: u32,
    /// The first after a change, to be finished in any case.
    first: bool,
    /// Since when it runs; `None` while it is paused.
    since: Option<Instant>,
    /// Time spent before that.
    spent: Duration,
    /// The paths in the picture that was shown last, and whether the rendering was over: what light
    /// paths bring comes after the last path from the camera.
    shown: Option<(u64, bool)>,
}

impl Running {
    fn spent(&self) -> Duration {
        self.spent + self.since.map_or(Duration::ZERO, |since| since.elapsed())
    }

    fn pause(&mut self) {
        self.rest();
        self.session.cancel();
    }

    /// Stops the clock: it has ended by itself.
    fn rest(&mut self) {
        self.spent = self.spent();
        self.since = None;
    }

    fn is_full(&self) -> bool {
        self.divisor == 1
    }
}

/// A whole picture with fewer pixels.
struct Coarse {
    look: Arc<Look>,
    integrator: Option<IntegratorKind>,
    image: Arc<Image>,
}

impl Coarse {
    /// Whether it shows what this rendering will show.
    fn stands_in_for(&self, running: &Running) -> bool {
        self.integrator == running.integrator && renders_same(&self.look, &running.look)
    }
}

struct Worker {
    shared: Arc<Shared>,
    threads: usize,
    /// The scene as it was read; its look is that of the newest wish.
    scene: Option<Scene>,
    /// The scene as the newest good wish wants it, and that wish's look.
    prepared: Option<(Arc<Prepared>, Arc<Look>)>,
    wish: Option<Wish>,
    running: Option<Running>,
    /// The full picture, while something else of the same look is shown.
    parked: Option<Running>,
    ladder: Ladder,
    /// The last whole picture below the full one, for the gaps of finer ones.
    coarse: Option<Coarse>,
    beside: Option<(Arc<Image>, View, Arc<Developed>)>,
    /// When the newest wish was heard.
    heard: Instant,
    /// When the next picture may be shown.
    due: Instant,
    number: u64,
    job: Option<(Job, Session, Instant)>,
}

impl Worker {
    fn new(shared: Arc<Shared>, threads: usize) -> Self {
        Self {
            shared,
            threads,
            scene: None,
            prepared: None,
            wish: None,
            running: None,
            parked: None,
            ladder: Ladder::default(),
            coarse: None,
            beside: None,
            heard: Instant::now(),
            due: Instant::now(),
            number: 0,
            job: None,
        }
    }

    fn run(mut self) {
        loop {
            let idle = self.is_idle();
            let Some(inbox) = self.hear(idle) else { return };
            self.take(inbox);
            self.go_on_with_job();
            self.go_on();
        }
    }

    /// Whether nothing will happen until the window wants something.
    fn is_idle(&self) -> bool {
        let done = |r: &Running| {
            let progress = r.session.progress();
            r.is_full() && progress.finished && r.shown == Some((progress.paths, true))
        };
        self.job.is_none() && self.running.as_ref().is_none_or(done)
    }

    /// What the window has said meanwhile; waits for it a moment, or for as long as it takes. `None` to end.
    fn hear(&self, idle: bool) -> Option<Inbox> {
        let inbox = locked(&self.shared.inbox);
        let silent = |inbox: &mut Inbox| {
            let Inbox { stage, wish, images, job, stop_job, focus, quit } = inbox;
            stage.is_none()
                && wish.is_none()
                && images.is_empty()
                && job.is_none()
                && focus.is_none()
                && !*stop_job
                && !*quit
        };
        let mut inbox = if idle {
            self.shared.told.wait_while(inbox, silent).unwrap_or_else(PoisonError::into_inner)
        } else {
            let waited = self.shared.told.wait_timeout_while(inbox, PERIOD, silent);
            waited.unwrap_or_else(PoisonError::into_inner).0
        };
        (!inbox.quit).then(|| std::mem::take(&mut *inbox))
    }

    fn take(&mut self, inbox: Inbox) {
        let Inbox { stage, wish, images, job, stop_job, focus, quit: _ } = inbox;
        if let Some(stage) = stage {
            let Stage { scene, prepared, look } = *stage;
            // A picture for a file goes on: it has the scene that it was asked for.
            (self.running, self.parked, self.coarse) = (None, None, None);
            self.scene = Some(scene);
            self.prepared = Some((prepared, look));
            // Another scene is as fast as nobody knows.
            self.ladder = Ladder::default();
        }
        if let Some(scene) = &mut self.scene {
            scene.images.extend(images);
        }
        if stop_job {
            self.job = None;
            *locked(&self.shared.job) = None;
            self.steer();
            (self.shared.wake)();
        }
        if let Some(wish) = wish {
            self.wish = Some(wish);
            self.follow_wish();
        }
        if let Some(job) = job {
            self.begin_job(job);
        }
        if let (Some(place), Some((prepared, look))) = (focus, &self.prepared) {
            *locked(&self.shared.focus) = Some(prepared.focus_on(look.settings.size, place));
            (self.shared.wake)();
        }
    }

    /// Brings what is rendered in line with the wish.
    fn follow_wish(&mut self) {
        let Some(wish) = self.wish.clone() else { return };
        self.heard = Instant::now();
        if self.prepared.as_ref().is_some_and(|(_, before)| !same_light(before, &wish.look)) {
            // An edit takes longer than all else before the next picture: all cores for it.
            self.finish_first();
            if let Some(running) = &mut self.running {
                running.pause();
            }
        }
        match self.prepare(&wish.look) {
            Ok(()) => self.set_status(|status| status.problem = None),
            Err(problem) => self.set_status(|status| status.problem = Some(problem)),
        }
        let Some((_, look)) = self.prepared.clone() else { return };
        let integrator = wish.view.channel.integrator();
        let fits = |r: &Running| renders_same(&r.look, &look) && r.integrator == integrator;

        // What was rendered of another look is of no use any more.
        self.parked.take_if(|r| !renders_same(&r.look, &look));
        if !self.running.as_ref().is_some_and(fits) {
            self.finish_first();
            if let Some(mut before) = self.running.take()
                && before.is_full()
                && before.integrator.is_none()
                && renders_same(&before.look, &look)
            {
                before.pause();
                self.parked = Some(before);
            }
            self.running = match self.parked.take_if(|r| fits(r)) {
                Some(mut parked) => {
                    parked.shown = None;
                    Some(parked)
                }
                None => self.start(&look, integrator),
            };
            self.due = Instant::now();
        }
        self.steer();
        self.due = Instant::now();
        if let Some(running) = &mut self.running {
            // Exposure, marks, the picture beside it: shown at once.
            running.look = look;
            running.shown = None;
        }
    }

    /// Pauses, goes on, or changes how far it goes.
    fn steer(&mut self) {
        let holds = self.holds();
        let (Some(running), Some(wish)) = (&mut self.running, &self.wish) else { return };
        let progress = running.session.progress();
        let target = match running.divisor {
            1 => target(&running.look.settings, running.integrator, wish.endless),
            _ => 1,
        };
        // What has no sample yet gets one in any case: a change is seen even in a pause.
        if holds && progress.samples > 0 {
            if running.since.is_some() {
                running.pause();
            }
        } else if progress.samples < target {
            if running.since.is_none() || progress.finished || progress.target < target {
                running.since.get_or_insert_with(Instant::now);
                running.session.extend(target);
            }
        } else if progress.target > target && !progress.finished {
            running.session.finish_pass();
        }
    }

    /// Whether nothing is to be rendered for the window beyond a first look.
    fn holds(&self) -> bool {
        self.job.is_some() || self.wish.as_ref().is_some_and(|wish| wish.paused)
    }

    /// Makes the scene traceable with another look.
    fn prepare(&mut self, look: &Arc<Look>) -> Result<(), SceneProblem> {
        let Some((prepared, before)) = &mut self.prepared else { return Ok(()) };
        if Arc::ptr_eq(before, look) {
            return Ok(());
        }
        let settings = window_settings(&look.settings, None);
        settings.validate()?;
        let camera = look.camera.camera(look.settings.size)?;
        let Some(scene) = &mut self.scene else { return Ok(()) };
        let next = if same_light(before, look) {
            prepared.seen_by(&camera)?
        } else {
            scene.camera = camera;
            scene.environment = look.environment;
            scene.materials.clone_from(&look.materials);
            scene.lights.clone_from(&look.lights);
            prepared.edited(scene)?
        };
        let missed = next.notes_for(&settings);
        let notes = next.report().notes.iter().chain(&missed).map(ToString::to_string).collect();
        (*prepared, *before) = (Arc::new(next), Arc::clone(look));
        self.set_status(|status| status.notes = notes);
        Ok(())
    }

    /// Starts at the lowest rung that is needed.
    fn start(&mut self, look: &Arc<Look>, integrator: Option<IntegratorKind>) -> Option<Running> {
        let divisor = self.ladder.first(look.settings.size, self.heard.elapsed());
        self.start_rung(look, integrator, divisor, true)
    }

    fn start_rung(
        &self,
        look: &Arc<Look>,
        integrator: Option<IntegratorKind>,
        divisor: u32,
        first: bool,
    ) -> Option<Running> {
        let (prepared, _) = self.prepared.as_ref()?;
        let full = window_settings(&look.settings, integrator);
        let settings = match divisor {
            1 => full,
            _ => {
                let size = reduced(full.size, divisor);
                Settings { size, spp: 1, planned_spp: Some(1), ..full }
            }
        };
        // The settings have been found to be good.
        let session = Session::start(Arc::clone(prepared), settings.clone(), self.threads).ok()?;
        let settings = Arc::new(settings);
        let since = Some(Instant::now());
        let look = Arc::clone(look);
        let spent = Duration::ZERO;
        Some(Running {
            session,
            look,
            settings,
            integrator,
            divisor,
            first,
            since,
            spent,
            shown: None,
        })
    }

    /// Waits for the first picture after a change, but not for ever.
    fn finish_first(&mut self) {
        const PATIENCE: Duration = Duration::from_millis(150);
        let Some(running) = &self.running else { return };
        if !running.first || running.shown.is_some() {
            return;
        }
        let left = PATIENCE.saturating_sub(running.spent());
        running.session.wait(left);
        if running.session.progress().samples > 0 {
            self.show();
        }
    }

    /// Looks how far the rendering is, shows it where that is worth it, climbs the ladder.
    fn go_on(&mut self) {
        /// So long one looks at the picture of before rather than at one with gaps.
        const GAPS: Duration = Duration::from_millis(150);
        let Some(running) = &mut self.running else { return };
        let progress = running.session.progress();
        let spent = running.spent();
        let news = running.shown != Some((progress.paths, progress.finished));
        if running.is_full() {
            // In the middle of a pass some pixels have a sample more than others: each shows the mean
            // of its own.
            let stand_in = self.coarse.as_ref().is_some_and(|c| c.stands_in_for(running));
            let whole = progress.samples > 0 || stand_in || spent > GAPS;
            if progress.finished && running.since.is_some() {
                running.rest();
            }
            if news && (whole && Instant::now() >= self.due || progress.finished) {
                self.show();
            }
            // It has its first sample in a pause, or has ended while more was asked for.
            if !progress.panicked {
                self.steer();
            }
        } else if progress.finished && (progress.samples > 0 || progress.panicked) {
            self.ladder.learn(progress.paths, spent);
            if news {
                self.show();
            }
            self.climb();
        }
        self.set_status(|_| {});
    }

    /// On to twice the width and height.
    fn climb(&mut self) {
        let Some(running) = self.running.take() else { return };
        let divisor = running.divisor / 2;
        self.running = self.start_rung(&running.look, running.integrator, divisor.max(1), false);
        self.steer();
    }

    /// Shows what there is of the picture.
    fn show(&mut self) {
        let (Some(running), Some(wish)) = (&mut self.running, &self.wish) else { return };
        let begin = Instant::now();
        let Progress { samples, paths, finished, .. } = running.session.progress();
        let mut image = running.session.snapshot();
        if samples == 0
            && let Some(coarse) = self.coarse.as_ref().filter(|c| c.stands_in_for(running))
        {
            image = filled(image, &coarse.image);
        }
        let image = Arc::new(image);
        if !running.is_full() {
            let (look, integrator) = (Arc::clone(&running.look), running.integrator);
            self.coarse = Some(Coarse { look, integrator, image: Arc::clone(&image) });
        }
        running.shown = Some((paths, finished));
        let picture = Arc::new(develop(image, &wish.view));
        let (look, settings) = (Arc::clone(&running.look), Arc::clone(&running.settings));
        let beside = self.develop_beside();
        self.number += 1;
        let shown = Shown { number: self.number, look, settings, finished, picture, beside };
        *locked(&self.shared.shown) = Some(shown);
        // At most thirty pictures a second, and no more than a sixteenth of the time for them.
        let took = begin.elapsed();
        self.due = Instant::now() + (15 * took).max(Duration::from_millis(33));
        (self.shared.wake)();
    }

    fn develop_beside(&mut self) -> Option<Arc<Developed>> {
        let wish = self.wish.as_ref()?;
        let Some(image) = &wish.beside else {
            self.beside = None;
            return None;
        };
        let known =
            self.beside.as_ref().filter(|(i, view, _)| Arc::ptr_eq(i, image) && *view == wish.view);
        if let Some((_, _, developed)) = known {
            return Some(Arc::clone(developed));
        }
        let developed = Arc::new(develop(Arc::clone(image), &wish.view));
        self.beside = Some((Arc::clone(image), wish.view, Arc::clone(&developed)));
        Some(developed)
    }

    fn begin_job(&mut self, mut job: Job) {
        let (Some((prepared, look)), Some(scene)) = (&self.prepared, &self.scene) else { return };
        if job.settings.layers.has(Layer::Cryptomatte) {
            job.mattes = cryptomatte::metadata(scene);
        }
        let problem = locked(&self.shared.status).problem.clone();
        let camera = problem.map_or_else(|| look.camera.camera(job.settings.size), Err);
        let started = camera.and_then(|camera| {
            let prepared = Arc::new(prepared.seen_by(&camera)?);
            Session::start(prepared, job.settings.clone(), self.threads)
        });
        match started {
            Ok(session) => {
                *locked(&self.shared.job) =
                    Some(JobState::Running { progress: session.progress() });
                self.job = Some((job, session, Instant::now()));
                self.steer();
            }
            Err(problem) => {
                *locked(&self.shared.job) = Some(JobState::Failed { what: problem.what });
            }
        }
        (self.shared.wake)();
    }

    fn go_on_with_job(&mut self) {
        let Some((job, session, since)) = &self.job else { return };
        let progress = session.progress();
        if !progress.finished {
            *locked(&self.shared.job) = Some(JobState::Running { progress });
            return;
        }
        let state = if progress.samples < job.settings.spp {
            JobState::Failed { what: "the rendering broke off".to_owned() }
        } else {
            let (image, job) = (Arc::new(session.snapshot()), job.clone());
            JobState::Done { image, job, took: since.elapsed() }
        };
        *locked(&self.shared.job) = Some(state);
        self.job = None;
        self.steer();
        (self.shared.wake)();
    }

    fn set_status(&self, change: impl FnOnce(&mut Status)) {
        let mut status = locked(&self.shared.status);
        change(&mut status);
        if let Some(running) = &self.running {
            status.progress = Some(running.session.progress());
            status.divisor = running.divisor;
            status.spent = running.spent();
        } else {
            status.progress = None;
        }
    }
}

/// How the window renders: all of the picture, in the order of samples that the scene's number of
/// them is best for, however far it goes.
pub(crate) fn window_settings(settings: &Settings, integrator: Option<IntegratorKind>) -> Settings {
    // Layers are for files.
    let (planned_spp, layers) = (Some(settings.spp), Layers::NONE);
    let mut settings = Settings { crop: None, planned_spp, layers, ..settings.clone() };
    if let Some(integrator) = integrator {
        settings.integrator = integrator;
        settings.spp = settings.spp.min(DEBUG_SPP);
    }
    settings
}

/// Samples of pictures that have hardly any noise.
const DEBUG_SPP: u64 = 16;

/// After how many samples a picture is done.
pub(crate) fn target(
    settings: &Settings,
    integrator: Option<IntegratorKind>,
    endless: bool,
) -> u64 {
    match (integrator, endless) {
        (Some(_), _) => settings.spp.min(DEBUG_SPP),
        (None, true) => ENDLESS,
        (None, false) => settings.spp,
    }
}

/// Whether the light of two looks goes the same ways: they differ at most in the camera, and in how
/// the picture is rendered and shown.
fn same_light(a: &Look, b: &Look) -> bool {
    a.environment == b.environment && a.materials == b.materials && a.lights == b.lights
}

/// Whether two looks differ at most in how the picture is shown.
fn renders_same(a: &Look, b: &Look) -> bool {
    let Look { camera, settings, .. } = a;
    let named = |c: &AuthoredCamera| AuthoredCamera { name: String::new(), ..c.clone() };
    named(camera) == named(&b.camera) && *settings == b.settings && same_light(a, b)
}

/// Locks. What is locked here is whole between statements.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Channel;
    use rutilant_formats::{ReadOptions, parse_native};
    use rutilant_geom::Vec3;
    use std::path::Path;

    const SCENE: &str = r#"
version = 1
[render]
size = [64, 48]
spp = 12
[camera]
position = [0, 1, 4]
look_at = [0, 0.5, 0]
[environment]
color = [0.6, 0.7, 0.9]
[[material]]
name = "floor"
type = "matte"
albedo = 0.6
[[material]]
name = "glass"
type = "dielectric"
[[shape]]
type = "rectangle"
size = [6, 6]
rotate_degrees = [-90, 0, 0]
material = "floor"
[[shape]]
type = "sphere"
radius = 0.5
center = [0, 0.5, 0]
material = "glass"
"#;

    fn stage() -> Stage {
        let loaded = parse_native(SCENE, Path::new("a.toml"), &ReadOptions::default()).unwrap();
        let look = Arc::new(loaded.look());
        let prepared = Arc::new(Prepared::new(&loaded.scene).unwrap());
        Stage { scene: loaded.scene, prepared, look }
    }

    fn wish(look: &Arc<Look>) -> Wish {
        let view = View::default();
        Wish { look: Arc::clone(look), view, paused: false, endless: false, beside: None }
    }

    /// What the command line would render.
    fn headless(look: &Look) -> u64 {
        let mut scene = stage().scene;
        scene.camera = look.camera.camera(look.settings.size).unwrap();
        scene.materials.clone_from(&look.materials);
        scene.environment = look.environment;
        let prepared = Arc::new(Prepared::new(&scene).unwrap());
        let session = Session::start(prepared, look.settings.clone(), 1).unwrap();
        while !session.wait(Duration::from_secs(1)) {}
        session.snapshot().hash()
    }

    /// Waits until the picture of this look has all its samples.
    fn finished(live: &Live, look: &Arc<Look>) -> Shown {
        for _ in 0..4000 {
            std::thread::sleep(Duration::from_millis(5));
            if let Some(shown) = live.shown()
                && Arc::ptr_eq(&shown.look, look)
                && let Some(counts) = shown.picture.image.channel("samples.Y")
                && shown.picture.size == look.settings.size
                && counts.iter().all(|&n| n as u64 >= look.settings.spp)
            {
                return shown;
            }
        }
        panic!("no picture: {:?}", live.status());
    }

    /// Begins a job.
    fn begin(live: &Live, settings: Settings) {
        let (file, display) = ("a.exr".into(), Display::default());
        assert!(live.begin_job(Job { settings, file, display, mattes: Vec::new() }));
    }

    /// Waits for the picture of a job.
    fn rendered(live: &Live) -> (Arc<Image>, Job) {
        loop {
            match live.job() {
                Some(JobState::Done { image, job, .. }) => return (image, job),
                Some(JobState::Waiting | JobState::Running { .. }) => {
                    std::thread::sleep(Duration::from_millis(1));
                }
                ended => panic!("{ended:?}"),
            }
        }
    }

    /// Waits for a whole picture of this look, however noisy.
    fn sampled(live: &Live, look: &Arc<Look>) {
        for _ in 0..4000 {
            std::thread::sleep(Duration::from_millis(5));
            if let Some(shown) = live.shown()
                && Arc::ptr_eq(&shown.look, look)
                && let Some(counts) = shown.picture.image.channel("samples.Y")
                && shown.picture.size == look.settings.size
                && counts.iter().all(|&n| n > 0.0)
            {
                return;
            }
        }
        panic!("no picture: {:?}", live.status());
    }

    /// After any changes, in quick succession, the picture is that of a fresh rendering: not one
    /// sample of before is in it.
    #[test]
    fn no_stale_sample() {
        let live = Live::start(2, || {});
        let stage = stage();
        let mut look = Arc::clone(&stage.look);
        live.stage(stage, wish(&look));
        assert_eq!(finished(&live, &look).picture.image.hash(), headless(&look));
        for round in 0..6_u8 {
            for change in 0..5_u8 {
                let next = Arc::make_mut(&mut look);
                next.camera.position += Vec3::new(0.05, 0.02 * f32::from(change), -0.03);
                if change == 3 {
                    let glass = next.materials[1].clone();
                    next.materials[1] = next.materials[0].clone();
                    next.materials[0] = glass;
                }
                live.wish(wish(&look));
                std::thread::sleep(Duration::from_millis(u64::from(round)));
            }
            assert_eq!(finished(&live, &look).picture.image.hash(), headless(&look), "{round}");
        }
    }

    /// A pause, a look at normals and another exposure lose nothing and change nothing.
    #[test]
    fn detours_leave_no_trace() {
        let live = Live::start(2, || {});
        let stage = stage();
        let mut look = Arc::clone(&stage.look);
        live.stage(stage, wish(&look));
        std::thread::sleep(Duration::from_millis(30));
        live.wish(Wish { paused: true, ..wish(&look) });
        std::thread::sleep(Duration::from_millis(30));
        let view = View { channel: Channel::Normal, ..View::default() };
        live.wish(Wish { view, ..wish(&look) });
        std::thread::sleep(Duration::from_millis(100));
        Arc::make_mut(&mut look).display.exposure = 1.0;
        live.wish(wish(&look));
        assert_eq!(finished(&live, &look).picture.image.hash(), headless(&look));
    }

    /// What cannot be rendered is told, and the last good picture stays; the next good wish is
    /// followed.
    #[test]
    fn a_bad_wish_keeps_the_last_good_picture() {
        let live = Live::start(1, || {});
        let stage = stage();
        let good = Arc::clone(&stage.look);
        live.stage(stage, wish(&good));
        finished(&live, &good);
        let mut bad = Look::clone(&good);
        bad.camera.look_at = bad.camera.position;
        live.wish(wish(&Arc::new(bad)));
        for _ in 0..1000 {
            std::thread::sleep(Duration::from_millis(2));
            if live.status().problem.is_some() {
                break;
            }
        }
        assert!(live.status().problem.is_some());
        assert!(Arc::ptr_eq(&live.shown().unwrap().look, &good));
        let mut next = Look::clone(&good);
        next.settings.size = [33, 21];
        let next = Arc::new(next);
        live.wish(wish(&next));
        assert_eq!(finished(&live, &next).picture.image.hash(), headless(&next));
        assert!(live.status().problem.is_none());
    }

    /// A job gives the bits of the command line, and the window's picture goes on after it.
    #[test]
    fn a_job_is_the_command_lines() {
        let live = Live::start(2, || {});
        let stage = stage();
        let look = Arc::clone(&stage.look);
        live.stage(stage, wish(&look));
        let settings = Settings { size: [40, 30], spp: 7, ..look.settings.clone() };
        begin(&live, settings.clone());
        let (image, _) = rendered(&live);
        let asked = Look { settings, ..Look::clone(&look) };
        assert_eq!(image.hash(), headless(&asked));
        assert_eq!(finished(&live, &look).picture.image.hash(), headless(&look));
    }

    /// The layers that a scene asks for are in the pictures of jobs, with the names that mattes go
    /// by, and not in the window's.
    #[test]
    fn layers_are_for_files() {
        let live = Live::start(2, || {});
        let mut stage = stage();
        let look = Arc::make_mut(&mut stage.look);
        look.settings.layers = Layers::NONE.with(Layer::Albedo).with(Layer::Cryptomatte);
        let look = Arc::clone(&stage.look);
        live.stage(stage, wish(&look));
        begin(&live, Settings { spp: 2, ..look.settings.clone() });
        let (image, job) = rendered(&live);
        let layers = ["albedo.R", "CryptoMaterial00.R"];
        assert!(layers.iter().all(|name| image.channel(name).is_some()));
        assert!(job.mattes.iter().any(|(_, text)| text.contains("\"floor\"")));
        let shown = finished(&live, &look).picture;
        assert!(layers.iter().all(|name| shown.image.channel(name).is_none()));
    }

    /// While a job runs, changes are seen, with a sample at least; once it is stopped, the picture
    /// goes on.
    #[test]
    fn a_job_can_be_stopped() {
        let live = Live::start(2, || {});
        let stage = stage();
        let mut look = Arc::clone(&stage.look);
        live.stage(stage, wish(&look));
        let settings = Settings { spp: 1 << 30, ..look.settings.clone() };
        begin(&live, settings);
        Arc::make_mut(&mut look).camera.position.x = 0.5;
        live.wish(wish(&look));
        sampled(&live, &look);
        assert!(matches!(live.job(), Some(JobState::Running { .. })));
        live.stop_job();
        assert_eq!(finished(&live, &look).picture.image.hash(), headless(&look));
        assert!(live.job().is_none());
    }

    /// Another scene, or the same read anew, does not end a job.
    #[test]
    fn a_job_outlives_its_scene() {
        let live = Live::start(2, || {});
        let first = stage();
        let look = Arc::clone(&first.look);
        live.stage(first, wish(&look));
        let settings = Settings { spp: 400, ..look.settings.clone() };
        begin(&live, settings.clone());
        while !matches!(live.job(), Some(JobState::Running { .. })) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let mut second = stage();
        let mut other = Look::clone(&look);
        other.camera.position.x = 0.5;
        second.look = Arc::new(other);
        let other = Arc::clone(&second.look);
        second.scene.camera = other.camera.camera(other.settings.size).unwrap();
        second.prepared = Arc::new(Prepared::new(&second.scene).unwrap());
        live.stage(second, wish(&other));
        assert_eq!(rendered(&live).0.hash(), headless(&Look { settings, ..Look::clone(&look) }));
        assert_eq!(finished(&live, &other).picture.image.hash(), headless(&other));
    }

    /// In a pause, what is moved or looked at otherwise is seen whole, however small the picture.
    #[test]
    fn a_pause_shows_what_changes() {
        let live = Live::start(2, || {});
        let stage = stage();
        let mut look = Arc::clone(&stage.look);
        live.stage(stage, wish(&look));
        finished(&live, &look);
        for channel in [Channel::Radiance, Channel::Normal, Channel::Radiance] {
            Arc::make_mut(&mut look).camera.position.x += 0.1;
            let view = View { channel, ..View::default() };
            live.wish(Wish { paused: true, view, ..wish(&look) });
            sampled(&live, &look);
        }
        live.wish(wish(&look));
        assert_eq!(finished(&live, &look).picture.image.hash(), headless(&look));
    }

    /// Beyond the scene's samples, and back.
    #[test]
    fn endless_goes_on() {
        let live = Live::start(2, || {});
        let stage = stage();
        let look = Arc::clone(&stage.look);
        live.stage(stage, wish(&look));
        finished(&live, &look);
        live.wish(Wish { endless: true, ..wish(&look) });
        for _ in 0..4000 {
            std::thread::sleep(Duration::from_millis(2));
            if live.status().progress.is_some_and(|p| p.samples > 40) {
                break;
            }
        }
        live.wish(wish(&look));
        let stopped = |live: &Live| live.status().progress.is_some_and(|p| p.finished);
        for _ in 0..4000 {
            std::thread::sleep(Duration::from_millis(2));
            if stopped(&live) {
                break;
            }
        }
        assert!(stopped(&live) && live.status().progress.unwrap().samples > 40);
    }
}
