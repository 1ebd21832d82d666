//! Places that take no picture: found before anything is rendered, or the older file survives.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

const SCENE: &str = r#"
version = 1
[render]
size = [300, 200]
spp = 1
sampler = "independent"
[camera]
position = [0, 0, 3]
look_at = [0, 0, 0]
[environment]
color = 1
[[material]]
name = "lamp"
type = "matte"
[[shape]]
type = "sphere"
radius = 1
material = "lamp"
"#;

/// A folder with `scene.toml`.
fn desk() -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scene.toml"), SCENE).unwrap();
    folder
}

fn rutilant(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rutilant"));
    command.current_dir(folder).args(arguments).output().unwrap()
}

/// Exit status and the lines on standard error.
fn said(output: &Output) -> (Option<i32>, Vec<String>) {
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    (output.status.code(), text.lines().map(str::to_owned).collect())
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// All of this is found before the scene is even looked for: it does not exist.
#[test]
fn hopeless_outputs_are_found_before_anything_is_read() {
    let desk = desk();
    let folder = desk.path();
    fs::create_dir(folder.join("folder.png")).unwrap();
    fs::write(folder.join("file"), "mine").unwrap();
    for (output, expected) in [
        ("a.gif", "a.gif: no image format .gif; there are .exr, .hdr, .pfm, .png, .jpg"),
        ("a", "a: no extension, so no image format; there are .exr, .hdr, .pfm, .png, .jpg"),
        ("folder.png", "folder.png: cannot write: this is a folder, not a file"),
        ("no/a.png", "no/a.png: cannot write: there is no folder no"),
        ("no/such/a.png", "no/such/a.png: cannot write: there is no folder no/such"),
        ("file/a.png", "file/a.png: cannot write: file is a file, not a folder"),
        ("file/deep/a.png", "file/deep/a.png: cannot write: there is no folder file/deep"),
    ] {
        let ran = rutilant(folder, &["nowhere.toml", "-o", "good.png", "-o", output]);
        assert_eq!(said(&ran), (Some(2), vec![format!("error: {expected}")]));
    }
    assert_eq!(fs::read_to_string(folder.join("file")).unwrap(), "mine");
    assert_eq!(names(folder), ["file", "folder.png", "scene.toml"]);
}

/// A link to a device that never takes a byte, or to a pipe that nobody reads.
#[cfg(unix)]
#[test]
fn devices_and_pipes_are_no_pictures() {
    use std::os::unix::fs::symlink;
    let desk = desk();
    let folder = desk.path();
    symlink("/dev/full", folder.join("full.png")).unwrap();
    let pipe = folder.join("pipe.png");
    assert!(Command::new("mkfifo").arg(&pipe).status().is_ok_and(|status| status.success()));
    for output in ["full.png", "pipe.png"] {
        let ran = rutilant(folder, &["nowhere.toml", "-o", output]);
        let expected =
            format!("error: {output}: cannot write: this is a pipe or a device, not a file");
        assert_eq!(said(&ran), (Some(2), vec![expected]));
    }
}

/// Runs a script in a world of its own, where file systems can be mounted; `None` where the
/// system does not allow that.
#[cfg(target_os = "linux")]
fn with_mounts(folder: &Path, script: &str) -> Option<Output> {
    let run = |script: &str| {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--mount", "sh", "-ec", script]);
        command.env("RUTILANT", env!("CARGO_BIN_EXE_rutilant")).current_dir(folder).output()
    };
    match run("mkdir -p trial && mount -t tmpfs trial trial && umount trial && rmdir trial") {
        Ok(trial) if trial.status.success() => Some(run(script).unwrap()),
        Ok(_) | Err(_) => {
            eprintln!("skipped: nothing can be mounted here");
            let _ = fs::remove_dir(folder.join("trial"));
            None
        }
    }
}

/// A disk that fills up while the picture is written costs that picture, not the older one of
/// its name, and is not called a success. Another disk gets its copy all the same.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_keeps_the_older_picture() {
    let desk = desk();
    fs::create_dir(desk.path().join("full")).unwrap();
    let script = "mount -t tmpfs -o size=8k full full
        echo older > full/a.exr
        set +e
        $RUTILANT scene.toml -q -o full/a.exr -o b.exr
        echo status $?
        cat full/a.exr
        ls -A full";
    let Some(ran) = with_mounts(desk.path(), script) else { return };
    let out = String::from_utf8(ran.stdout.clone()).unwrap();
    assert_eq!(out, "status 1\nolder\na.exr\n", "{ran:?}");
    let (_, error) = said(&ran);
    let expected = "error: full/a.exr: cannot write: No space left on device (os error 28)";
    assert_eq!(error, ["wrote b.exr", expected]);
    assert_eq!(names(desk.path()), ["b.exr", "full", "scene.toml"]);
}

/// A folder that takes no files is found before anything is read, for root as well.
#[cfg(target_os = "linux")]
#[test]
fn a_read_only_folder_is_found_before_anything_is_read() {
    let desk = desk();
    fs::create_dir(desk.path().join("closed")).unwrap();
    fs::write(desk.path().join("closed/old.png"), "older").unwrap();
    let script = "mount --bind closed closed
        mount -o remount,ro,bind closed
        set +e
        for name in new old; do
            $RUTILANT nowhere.toml -o closed/$name.png
            echo status $?
        done";
    let Some(ran) = with_mounts(desk.path(), script) else { return };
    assert_eq!(String::from_utf8(ran.stdout.clone()).unwrap(), "status 2\nstatus 2\n", "{ran:?}");
    let (_, error) = said(&ran);
    assert_eq!(error.len(), 2, "{error:?}");
    for (line, name) in error.iter().zip(["new", "old"]) {
        let what = "cannot write: Read-only file system (os error 30)";
        assert_eq!(*line, format!("error: closed/{name}.png: {what}"));
    }
    assert_eq!(fs::read_to_string(desk.path().join("closed/old.png")).unwrap(), "older");
}
