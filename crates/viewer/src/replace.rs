//! Files that appear as a whole or not at all.

use std::io::Write;
use std::path::Path;

/// Writes a file in place of what is there, behind a link as well, as a whole or not at all.
pub(crate) fn replace(file: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let file = &*file.canonicalize().unwrap_or_else(|_| file.to_owned());
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut new = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // As for any new file: the user's mask says what others may do.
        use std::os::unix::fs::PermissionsExt;
        new.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut new = new.tempfile_in(folder)?;
    new.write_all(bytes)?;
    if let Ok(metadata) = std::fs::metadata(file) {
        new.as_file().set_permissions(metadata.permissions())?;
    }
    new.persist(file).map(|_| ()).map_err(|error| error.error)
}
