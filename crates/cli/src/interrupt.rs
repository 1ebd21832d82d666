//! Ctrl-C, and the system's requests to end.
//!
//! The first request lets a rendering finish its pass and write what there is;
//! the second ends the process. Before the rendering there is nothing to write,
//! so the first ends it at once.

use crate::failure::{Exit, Failure};
use crate::say::tell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError, TryLockError};
use std::time::{Duration, Instant};

/// The first request, and what the next one would disturb.
#[derive(Debug, Default)]
pub(crate) struct Interrupt {
    /// When the first request came.
    first: OnceLock<Instant>,
    /// There is an image worth writing.
    rendering: AtomicBool,
    /// Held while a file is being written, and while the process ends.
    writing: Mutex<()>,
}

impl Interrupt {
    /// Listens from now on.
    pub(crate) fn install() -> Result<Arc<Self>, Failure> {
        let interrupt = Arc::new(Self::default());
        let listener = Arc::clone(&interrupt);
        ctrlc::set_handler(move || listener.request())
            .map_err(|error| Failure::failed(format!("cannot listen for Ctrl-C: {error}")))?;
        Ok(interrupt)
    }

    /// True once someone has asked to stop.
    pub(crate) fn requested(&self) -> bool {
        self.first.get().is_some()
    }

    /// From now on there is an image worth writing.
    pub(crate) fn rendering_starts(&self) {
        self.rendering.store(true, Ordering::SeqCst);
    }

    /// Runs `write`, which a request does not cut in two. It does not begin once the process ends.
    pub(crate) fn while_writing<T>(&self, write: impl FnOnce() -> T) -> T {
        let _writing = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
        write()
    }

    /// Runs in a thread of its own for every request.
    fn request(&self) {
        /// A file that takes longer than this is given up: stopping comes first.
        const PATIENCE: Duration = Duration::from_secs(2);
        /// A request so soon after the first is the same one: some programs signal a process
        /// and then the group that it belongs to, `timeout` among them.
        const ECHO: Duration = Duration::from_millis(200);
        let asked = Instant::now();
        let first = *self.first.get_or_init(|| asked);
        if self.rendering.load(Ordering::SeqCst) && asked.duration_since(first) < ECHO {
            return;
        }
        let _nothing_is_written_any_more = loop {
            match self.writing.try_lock() {
                Ok(held) => break Some(held),
                Err(TryLockError::Poisoned(held)) => break Some(held.into_inner()),
                Err(TryLockError::WouldBlock) if asked.elapsed() >= PATIENCE => break None,
                Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_millis(5)),
            }
        };
        tell("");
        tell("interrupted");
        std::process::exit(Exit::Interrupted as i32);
    }
}
