//! Files that appear as a whole or not at all.

use crate::file;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Puts `bytes` where `path` is, as a whole or not at all: they are written under another name in the
/// same folder, brought to the disk, and renamed. A symbolic link stays one.
///
/// # Errors
/// A folder that is not there or takes no files, a file that is read-only or not a regular one, a
/// symbolic link to nothing.
pub fn replace_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let target = target(path)?;
    let mut new = temporary(&target)?;
    // Not through the name's own `Write`, whose errors speak of the temporary name.
    new.as_file_mut().write_all(bytes)?;
    new.as_file().sync_all()?;
    if let Ok(old) = fs::metadata(&target) {
        new.as_file().set_permissions(old.permissions())?;
    }
    new.persist(&target).map_err(|e| e.error)?;
    // The new name is safe once its folder is on the disk. Not every system can do that.
    if let Ok(folder) = File::open(file::folder(&target)) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// The file that `path` means: symbolic links are followed, so that they stay what they are.
pub(crate) fn target(path: &Path) -> io::Result<PathBuf> {
    let target = match path.canonicalize() {
        Ok(there) => there,
        // It would not stay a link, and where it leads nobody has looked.
        Err(e) if e.kind() == io::ErrorKind::NotFound && path.is_symlink() => {
            let what = "this is a symbolic link to a file that is not there";
            return Err(io::Error::new(io::ErrorKind::NotFound, what));
        }
        // What hinders it beyond that, the folder will show.
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Ok(path.to_owned());
        }
        Err(e) => return Err(e),
    };
    let metadata = fs::metadata(&target)?;
    if let Some(what) = file::not_regular(&metadata) {
        return Err(io::Error::other(format!("this is {what}, not a file")));
    }
    if metadata.permissions().readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    Ok(target)
}

/// A new file next to `target`, which is gone again if it is dropped.
pub(crate) fn temporary(target: &Path) -> io::Result<tempfile::NamedTempFile> {
    let folder = file::folder(target);
    if !folder.is_dir() {
        let what = if folder.exists() {
            format!("{} is a file, not a folder", folder.display())
        } else {
            format!("there is no folder {}", folder.display())
        };
        return Err(io::Error::new(io::ErrorKind::NotFound, what));
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rutilant-").suffix(".tmp");
    #[cfg(unix)]
    {
        // As for any new file: what the user's umask leaves of this.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|error| {
        // The temporary name that follows says nothing to anybody.
        let text = error.to_string();
        let cause = text.split_once(" at path ").map_or(&*text, |(cause, _)| cause);
        io::Error::new(error.kind(), cause)
    })
}
