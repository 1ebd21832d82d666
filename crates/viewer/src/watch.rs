//! Tells when a scene's files change on disk.
//!
//! Folders are watched rather than files: editors write a new file and rename
//! it. A change is told once it has been quiet for a moment, so that a file is
//! not read half written.

use notify::event::{MetadataKind, ModifyKind};
use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};
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
    changes: Arc<Mutex<Changes>>,
}

/// What has changed since it was asked last.
#[derive(Default)]
struct Changes {
    files: BTreeSet<PathBuf>,
    last: Option<Instant>,
}

/// What became of the files.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Changed {
    /// Nothing has changed.
    Nothing,
    /// Something has; it will have been quiet after this time, if nothing more happens.
    Soon(Duration),
    /// These have, and it is quiet.
    Files(BTreeSet<PathBuf>),
}

impl Watch {
    /// Of `files`, and of everything in the folder of `beside`; `wake` is called at each change.
    pub(crate) fn begin(
        files: impl IntoIterator<Item = PathBuf>,
        beside: Option<&Path>,
        wake: impl Fn() + Send + 'static,
    ) -> Self {
        let folder_of = |file: &Path| {
            let folder = file.parent()?;
            let here = folder.as_os_str().is_empty();
            (if here { Path::new(".") } else { folder }).canonicalize().ok()
        };
        // By name, so that a file that is missing now is seen when it comes, and behind a link.
        let mut named = BTreeSet::new();
        for file in files {
            named.extend(file.canonicalize().ok());
            let place = folder_of(&file).zip(file.file_name());
            named.extend(place.map(|(folder, name)| folder.join(name)));
        }
        let files = named;
        let all_in = beside.and_then(folder_of);
        let folders: BTreeSet<PathBuf> =
            files.iter().filter_map(|file| folder_of(file)).chain(all_in.clone()).collect();
        let changes = Arc::new(Mutex::new(Changes::default()));
        let theirs = Arc::clone(&changes);
        let heard = move |event: notify::Result<notify::Event>| {
            let Ok(event) = event else { return };
            let watched = |path: &&PathBuf| {
                files.contains(*path) || (all_in.is_some() && path.parent() == all_in.as_deref())
            };
            let touched: Vec<_> = event.paths.iter().filter(watched).collect();
            let metadata = EventKind::Modify(ModifyKind::Metadata(MetadataKind::Any));
            let harmless = matches!(event.kind, EventKind::Access(_)) || event.kind == metadata;
            if touched.is_empty() || harmless {
                return;
            }
            let mut changes = theirs.lock().unwrap_or_else(PoisonError::into_inner);
            changes.files.extend(touched.into_iter().cloned());
            changes.last = Some(Instant::now());
            drop(changes);
            wake();
        };
        let mut watcher = notify::recommended_watcher(heard).ok();
        if let Some(watcher) = &mut watcher {
            for folder in folders {
                // A folder that cannot be watched changes unseen.
                drop(watcher.watch(&folder, RecursiveMode::NonRecursive));
            }
        }
        Self { _watcher: watcher, changes }
    }

    /// These have changed as well.
    pub(crate) fn note(&self, files: Vec<PathBuf>) {
        if !files.is_empty() {
            let mut changes = self.changes.lock().unwrap_or_else(PoisonError::into_inner);
            changes.files.extend(files);
            changes.last = Some(Instant::now());
        }
    }

    /// Takes over what another has seen and not told.
    pub(crate) fn succeed(&self, other: &Self) {
        let lock = |watch: &Self| {
            std::mem::take(&mut *watch.changes.lock().unwrap_or_else(PoisonError::into_inner))
        };
        let Changes { files, last } = lock(other);
        let mut changes = self.changes.lock().unwrap_or_else(PoisonError::into_inner);
        changes.files.extend(files);
        changes.last = changes.last.max(last);
    }

    /// What has changed since files were told last.
    pub(crate) fn changed(&self) -> Changed {
        let mut changes = self.changes.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(last) = changes.last else { return Changed::Nothing };
        match QUIET.checked_sub(last.elapsed()) {
            Some(left) if !left.is_zero() => Changed::Soon(left),
            _ => Changed::Files(std::mem::take(&mut *changes).files),
        }
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
        let watch = Watch::begin([file.clone()], None, || {});
        let here = BTreeSet::from([file.canonicalize().unwrap()]);
        let changed = || {
            (0..300).any(|_| {
                std::thread::sleep(Duration::from_millis(10));
                watch.changed() == Changed::Files(here.clone())
            })
        };
        std::fs::write(&file, "2").unwrap();
        assert!(changed());
        let new = folder.path().join("a.toml~");
        std::fs::write(&new, "3").unwrap();
        std::thread::sleep(3 * QUIET);
        assert_eq!(watch.changed(), Changed::Nothing);
        std::fs::rename(&new, &file).unwrap();
        assert!(changed());
    }

    /// Where a file is missing, whatever comes beside it counts; what was seen is not lost.
    #[test]
    fn what_is_new_in_a_folder_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing.ply");
        let watch = Watch::begin([], Some(&missing), || {});
        std::fs::write(&missing, "1").unwrap();
        std::thread::sleep(3 * QUIET);
        let next = Watch::begin([missing.clone()], None, || {});
        next.succeed(&watch);
        assert_eq!(watch.changed(), Changed::Nothing);
        let expected = BTreeSet::from([missing.canonicalize().unwrap()]);
        assert_eq!(next.changed(), Changed::Files(expected));
    }
}
