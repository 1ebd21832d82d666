//! What is in a folder, to choose from below the path that one types.
//!
//! Folders are read on a thread of their own: those on a network may take their time.

use eframe::egui::{Context, ScrollArea, Ui};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};

/// One thing in a folder.
struct Entry {
    name: String,
    is_folder: bool,
}

/// A folder's contents.
#[derive(Default)]
pub(super) struct Listing {
    /// The folder, as it begins the path that is typed: empty, or with a separator at its end.
    folder: String,
    entries: Vec<Entry>,
    /// Where the contents will come from, while they are being read.
    reading: Option<Receiver<Vec<Entry>>>,
    known: bool,
}

/// More than anybody looks through; one types a letter or two.
const MOST: usize = 200;

impl Listing {
    /// Shows what in the folder of `path` begins as it ends, and changes it to what is clicked on.
    /// Only files with one of the `extensions` are shown, all where there are none. Returns true
    /// where a file was chosen by a double click.
    pub(super) fn show(&mut self, ui: &mut Ui, path: &mut String, extensions: &[&str]) -> bool {
        let (folder, begun) = split(path);
        self.follow(folder, ui.ctx());
        let begun = begun.to_lowercase();
        let wanted = |entry: &&Entry| {
            let extension = Path::new(&entry.name).extension().unwrap_or_default();
            let extension = extension.to_string_lossy().to_lowercase();
            let fits = extensions.is_empty() || extensions.contains(&&*extension);
            let hidden = entry.name.starts_with('.') && !begun.starts_with('.');
            (entry.is_folder || fits) && !hidden && entry.name.to_lowercase().starts_with(&begun)
        };
        let (mut next, mut chosen) = (None, false);
        // As high for few as for many: what is below stays where it is.
        ScrollArea::vertical().max_height(180.0).auto_shrink(false).show(ui, |ui| {
            if let Some(above) = above(folder)
                && begun.is_empty()
                && ui.selectable_label(false, "../").clicked()
            {
                next = Some(above);
            }
            for entry in self.entries.iter().filter(wanted).take(MOST) {
                let slash = if entry.is_folder { "/" } else { "" };
                let shown = format!("{}{slash}", entry.name);
                let response = ui.selectable_label(*path == format!("{folder}{shown}"), &shown);
                if response.clicked() {
                    next = Some(format!("{folder}{shown}"));
                    chosen = response.double_clicked() && !entry.is_folder;
                }
            }
        });
        if let Some(next) = next {
            *path = next;
        }
        chosen
    }

    /// Reads the folder, if it is another one, and takes what has been read.
    fn follow(&mut self, folder: &str, context: &Context) {
        if !self.known || self.folder != folder {
            let (sender, receiver) = channel();
            let (path, wake) = (folder.to_owned(), context.clone());
            std::thread::spawn(move || {
                // Nobody waits for it any more if another folder was typed meanwhile.
                drop(sender.send(entries(&path)));
                wake.request_repaint();
            });
            *self = Self {
                folder: folder.to_owned(),
                entries: Vec::new(),
                reading: Some(receiver),
                known: true,
            };
        }
        if let Some(entries) = self.reading.as_ref().and_then(|reading| reading.try_recv().ok()) {
            (self.entries, self.reading) = (entries, None);
        }
    }
}

/// The folder that a path begins with, and the rest.
fn split(path: &str) -> (&str, &str) {
    let end = path.rfind(std::path::is_separator).map_or(0, |last| last + 1);
    path.split_at(end)
}

/// The folder around a folder; `None` for the last one.
fn above(folder: &str) -> Option<String> {
    let here = if folder.is_empty() { Path::new(".") } else { Path::new(folder) };
    let above = std::path::absolute(here).ok()?;
    let above = above.parent()?.display().to_string();
    let slash = if above.ends_with(std::path::is_separator) { "" } else { "/" };
    Some(format!("{above}{slash}"))
}

/// What is in a folder, folders first; nothing where it cannot be read.
fn entries(folder: &str) -> Vec<Entry> {
    let folder = if folder.is_empty() { Path::new(".") } else { Path::new(folder) };
    let Ok(all) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut entries: Vec<Entry> = all
        .flatten()
        .filter_map(|entry| {
            // A name that is no text cannot be typed either.
            let name = entry.file_name().into_string().ok()?;
            Some(Entry { name, is_folder: entry.path().is_dir() })
        })
        .collect();
    entries.sort_by_cached_key(|entry| (!entry.is_folder, entry.name.to_lowercase()));
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_split_where_their_names_begin() {
        for (path, folder, name) in [
            ("", "", ""),
            ("a", "", "a"),
            ("a/", "a/", ""),
            ("/a", "/", "a"),
            ("a/b/c", "a/b/", "c"),
        ] {
            assert_eq!(split(path), (folder, name));
        }
        assert_eq!(above("/a/b/").as_deref(), Some("/a/"));
        assert_eq!(above("/a/").as_deref(), Some("/"));
        assert_eq!(above("/"), None);
    }

    #[test]
    fn folders_come_first() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.toml", "A.ply"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("z")).unwrap();
        let path = format!("{}/", folder.path().display());
        let names: Vec<String> = entries(&path).into_iter().map(|entry| entry.name).collect();
        assert_eq!(names, ["z", "A.ply", "b.toml"]);
        assert_eq!(entries("/no/such/folder/").len(), 0);
    }
}
