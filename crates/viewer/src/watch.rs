//! Tells when a scene's files change on disk.
//!
//! Folders are watched rather than files: editors write a new file and rename
//! it. A change is told once it has been quiet for a moment, so that a file is
//! not read half written.

use notify::{RecommendedWatcher, RecursiveMode, Watcher};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// So long nothing must have changed.
const QUIET: Duration = Duration::from_millis(120);

/// Watches some files. Where the system cannot watch, nothing is told.
pub(crate) struct Watch {
    /// Ends with this.
    _watcher: Option<RecommendedWatcher>,
    last: Arc<Mutex<Option<Instant>>>,
}

impl Watch {
    /// Of `files`; `wake` is called after each change, when it has been quiet for a moment.
    pub(crate) fn begin(
        files: impl IntoIterator<Item = PathBuf>,
        wake: impl Fn(Duration) + Send + 'static,
    ) -> Self {
        let files = files.into_iter().filter_map(|file| file.canonicalize().ok());
        let files: BTreeSet<PathBuf> = files.collect();
        let folders: BTreeSet<PathBuf> =
            files.iter().filter_map(|file| file.parent().map(Path::to_owned)).collect();
        let last = Arc::new(Mutex::new(None));
        let theirs = Arc::clone(&last);
        let heard = move |event: notify::Result<notify::Event>| {
            let Ok(event) = event else { return };
            let changes = !matches!(event.kind, notify::EventKind::Access(_));
            if changes && event.paths.iter().any(|path| files.contains(path)) {
                *theirs.lock().unwrap_or_else(PoisonError::into_inner) = Some(Instant::now());
                wake(QUIET);
            }
        };
        let mut watcher = notify::recommended_watcher(heard).ok();
        if let Some(watcher) = &mut watcher {
            for folder in folders {
                // A folder that cannot be watched changes unseen.
                drop(watcher.watch(&folder, RecursiveMode::NonRecursive));
            }
        }
        Self { _watcher: watcher, last }
    }

    /// Whether something has changed since this was asked last, and it has been quiet since.
    pub(crate) fn has_changed(&self) -> bool {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.take_if(|since| since.elapsed() >= QUIET).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written in place or replaced by a rename, a change is told once; that of a file beside it
    /// is not.
    #[test]
    fn changes_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.toml");
        std::fs::write(&file, "1").unwrap();
        let watch = Watch::begin([file.clone()], |_| {});
        let changed = || {
            (0..300).any(|_| {
                std::thread::sleep(Duration::from_millis(10));
                watch.has_changed()
            })
        };
        std::fs::write(&file, "2").unwrap();
        assert!(changed());
        let new = folder.path().join("a.toml~");
        std::fs::write(&new, "3").unwrap();
        std::thread::sleep(3 * QUIET);
        assert!(!watch.has_changed());
        std::fs::rename(&new, &file).unwrap();
        assert!(changed());
    }
}
