//! The command line as its users meet it: the built program, its files, its exit status.

use rutilant::display::Display;
use rutilant::image::Image;
use rutilant_formats::Limits;
use rutilant_formats::image::Pixels;
use serde_json::Value;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A room with everything that could depend on the order of work: glass, a lamp, a sky.
const ROOM: &str = r#"
version = 1

[render]
size = [101, 97]
spp = 4

[camera]
position = [0, 1, 4]
look_at = [0, 0.6, 0]
fov_degrees = 40

[environment]
color = [0.2, 0.3, 0.5]

[[material]]
name = "floor"
type = "matte"
albedo = [0.6, 0.5, 0.4]

[[material]]
name = "glass"
type = "dielectric"
ior = 1.5

[[material]]
name = "lamp"
type = "emissive"
radiance = [9, 8, 6]

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

[[shape]]
type = "rectangle"
size = [1, 1]
rotate_degrees = [90, 0, 0]
translate = [0, 2, 0]
material = "lamp"
"#;

/// A folder with the room in it, where the program runs.
struct Desk {
    folder: TempDir,
}

impl Desk {
    fn new() -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("room.toml"), ROOM).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rutilant"));
        command.current_dir(self.folder.path()).args(arguments.split_whitespace());
        command
    }

    fn run(&self, arguments: &str) -> Ran {
        Ran::from(self.command(arguments).output().unwrap())
    }

    /// Runs what must succeed and says one line of JSON.
    fn json(&self, arguments: &str) -> Value {
        let ran = self.run(arguments);
        assert_eq!(ran.status, 0, "{arguments}: {}", ran.error);
        assert_eq!(ran.out.lines().count(), 1, "{arguments}: {}", ran.out);
        serde_json::from_str(&ran.out).unwrap()
    }

    fn image(&self, name: &str) -> Image {
        rutilant_formats::image::read(&self.path(name), &Limits::default()).unwrap()
    }

    fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

/// What a run left behind.
#[derive(Debug)]
struct Ran {
    status: i32,
    out: String,
    error: String,
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        Self {
            // A process that a signal ended has no status: −1.
            status: output.status.code().unwrap_or(-1),
            out: String::from_utf8(output.stdout).unwrap(),
            error: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

// ---- usage ----

#[test]
fn help_shows_the_way() {
    let desk = Desk::new();
    for arguments in ["--help", "-h", "render --help", "compare --help", "bench rays --help"] {
        let ran = desk.run(arguments);
        assert_eq!((ran.status, ran.error.as_str()), (0, ""), "{arguments}");
        assert!(ran.out.contains("Usage:"), "{arguments}");
    }
    let help = desk.run("--help").out;
    for word in ["--spp", "--time", "--crop", "check", "compare", "Examples:", "Exit status"] {
        assert!(help.contains(word), "{word}");
    }
    let help = desk.run("compare --help").out;
    for format in [".exr", ".hdr", ".pfm", ".png", ".jpg"] {
        assert!(help.contains(format), "{format}");
    }
    assert!(desk.run("--version").out.starts_with("rutilant "));
}

/// Nothing is done with a command line that cannot be meant, and the answer says what could be.
#[test]
fn bad_usage_is_refused_with_a_hint() {
    let desk = Desk::new();
    for (arguments, hint) in [
        ("room.toml --ssp 4", "--spp"),
        ("room.toml --spp 0", "1 or more"),
        ("room.toml --spp -3", "1 or more"),
        ("room.toml --size 80", "800x600"),
        ("room.toml --size 0x5", "800x600"),
        ("room.toml --crop 1,2,3", "x,y,width,height"),
        ("room.toml --crop 100,0,2,1", "crop"),
        ("room.toml --size 70000x1", "65536"),
        ("room.toml --time soon", "1h30m"),
        ("room.toml --threads 0", "1024"),
        ("room.toml --integrator magic", "path"),
        ("room.toml --exposure nan", "number"),
        ("room.toml other.toml", "\"other.toml\" is one too many"),
        ("--spp 4 check room.toml", "a command comes first"),
        ("room.toml check", "a command comes first"),
        ("room.toml --seed -1", "whole number, 0 or more"),
        ("room.toml --seed 1.5", "whole number, 0 or more"),
        ("room.toml --bits 12", "8, 16, 32"),
        ("room.toml --limit", "NAME=N"),
        ("room.toml --limit pixels", "pixels=500M"),
        (
            "room.toml --limit pixles=4",
            "bytes, vertices, triangles, pixels, textures, picture, objects, nesting",
        ),
        ("room.toml --limit pixels=many", "2000000, 500k, 2M or 8G"),
        ("check", "SCENE"),
        ("compare a.png", "REFERENCE"),
        ("bench", "rays"),
    ] {
        let ran = desk.run(arguments);
        assert_eq!(ran.status, 2, "{arguments}: {ran:?}");
        assert!(ran.error.contains(hint), "{arguments}: {}", ran.error);
        assert_eq!(ran.error.lines().count(), 1, "{arguments}: {}", ran.error);
        assert_eq!(ran.out, "", "{arguments}");
    }
    assert_eq!(desk.files(), ["room.toml"]);
    for (arguments, said) in [
        (
            "room.toml --ssp 4",
            "unexpected argument '--ssp' found; tip: a similar argument exists: '--spp'",
        ),
        ("room.toml --spp 0", "invalid value '0' for '--spp <N>': write a whole number, 1 or more"),
        ("compare a.png", "the following required arguments were not provided: <REFERENCE>"),
    ] {
        let error = format!("rutilant: {said}; see --help\n");
        assert_eq!(desk.run(arguments).error, error, "{arguments}");
    }
}

/// A slip in a command is answered by the command, not by talk about a scene of that name.
#[test]
fn a_mistyped_command_is_recognised() {
    let desk = Desk::new();
    for arguments in ["rendr", "rendr room.toml", "rendr room.toml --spp 1", "rendr --help"] {
        let ran = desk.run(arguments);
        let error = "error: no command \"rendr\"; did you mean \"render\"?\n";
        assert_eq!((ran.status, ran.error.as_str()), (2, error), "{arguments}");
    }
    for arguments in ["paint", "paint room.toml"] {
        let ran = desk.run(arguments);
        assert_eq!(ran.status, 2, "{arguments}: {ran:?}");
        assert!(ran.error.starts_with("error: no command \"paint\"; "), "{}", ran.error);
        for name in ["render", "check", "info", "compare", "bench", ".toml"] {
            assert!(ran.error.contains(name), "{name}: {}", ran.error);
        }
        assert_eq!(ran.error.lines().count(), 1, "{}", ran.error);
    }
    assert_eq!(desk.files(), ["room.toml"]);
    // What is there, or ends like a scene, is a scene.
    fs::write(desk.path("rendr"), ROOM).unwrap();
    for scene in ["rendr", "rendr.toml", "kitchen.scene"] {
        let ran = desk.run(scene);
        assert_eq!(ran.status, 2, "{scene}");
        assert!(!ran.error.contains("command"), "{scene}: {}", ran.error);
    }
}

// ---- errors ----

#[test]
fn a_missing_scene_is_one_clear_line() {
    let desk = Desk::new();
    let ran = desk.run("kitchen.toml -o a.png");
    assert_eq!(ran.status, 2, "{ran:?}");
    assert!(ran.error.contains("kitchen.toml"), "{}", ran.error);
    assert_eq!(ran.error.lines().count(), 1, "{}", ran.error);
    assert_eq!(desk.files(), ["room.toml"]);
}

/// Hours of work must not end with "no such folder": outputs are tried before anything is read.
#[test]
fn an_output_that_cannot_be_written_is_found_first() {
    let desk = Desk::new();
    for output in ["nowhere/a.png", "a.xyz", "a", ".", "room.toml"] {
        let ran = desk.run(&format!("room.toml -o good.png -o {output}"));
        assert_eq!(ran.status, 2, "{output}: {ran:?}");
        assert_eq!(ran.error.lines().count(), 1, "{output}: {}", ran.error);
        assert!(ran.error.starts_with("error: "), "{output}: {}", ran.error);
        assert_eq!(desk.files(), ["room.toml"], "{output}");
    }
    assert_eq!(fs::read_to_string(desk.path("room.toml")).unwrap(), ROOM);
    // Even a scene that does not exist is not looked for.
    let ran = desk.run("kitchen.toml -o nowhere/a.png");
    assert!(ran.error.contains("nowhere"), "{}", ran.error);
}

/// A bad scene names the place, as compilers do, and an older picture stays as it was.
#[test]
fn a_bad_scene_names_its_place_and_leaves_files_alone() {
    let desk = Desk::new();
    fs::write(desk.path("bad.toml"), ROOM.replace("albedo = [0.6", "albedo = [1.6")).unwrap();
    fs::write(desk.path("bad.png"), "an older picture").unwrap();
    for arguments in ["bad.toml", "check bad.toml", "info bad.toml"] {
        let ran = desk.run(arguments);
        assert_eq!(ran.status, 2, "{arguments}: {ran:?}");
        assert!(ran.error.starts_with("bad.toml:19:"), "{arguments}: {}", ran.error);
        assert!(ran.error.contains("albedo"), "{arguments}: {}", ran.error);
    }
    assert_eq!(fs::read_to_string(desk.path("bad.png")).unwrap(), "an older picture");
    assert_eq!(desk.files(), ["bad.png", "bad.toml", "room.toml"]);
}

/// Every command that reads can be told how much; what is said about too much leads out of it.
#[test]
fn limits_are_set_on_the_command_line() {
    let desk = Desk::new();
    for (command, limit) in [
        ("room.toml --spp 1", "objects=2"),
        ("check room.toml", "bytes=99"),
        ("info room.toml", "nesting=1"),
    ] {
        let ran = desk.run(&format!("{command} --limit {limit}"));
        assert_eq!(ran.status, 2, "{command}: {ran:?}");
        let (name, _) = limit.split_once('=').unwrap();
        let hint = format!("allow more with --limit {name}=N\n");
        assert!(ran.error.ends_with(&hint), "{command}: {}", ran.error);
        let ran = desk.run(&format!("{command} --limit {limit} --limit {name}=2k"));
        assert_eq!(ran.status, 0, "{command}: {ran:?}");
    }
    write_picture(&desk.path("a.pfm"), [20, 20], |_, _| [0.5; 3]);
    let ran = desk.run("compare a.pfm a.pfm --limit pixels=399");
    let said = "error: a.pfm: 20x20 are 400 pixels, but at most 399 are allowed; \
                allow more with --limit pixels=N\n";
    assert_eq!((ran.status, ran.error.as_str()), (2, said));
    assert_eq!(desk.run("compare a.pfm a.pfm --limit pixels=400").status, 0);
}

/// `rutilant … | head` closes the pipe while there is more to say: no reason to panic.
#[test]
fn nobody_has_to_listen() {
    let desk = Desk::new();
    for arguments in ["info room.toml", "check nowhere.toml", "room.toml --spp 1 --progress json"] {
        let mut child =
            desk.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop((child.stdout.take(), child.stderr.take()));
        let status = child.wait().unwrap().code();
        let expected = if arguments.contains("nowhere") { 2 } else { 0 };
        assert_eq!(status, Some(expected), "{arguments}");
    }
}

// ---- check and info ----

#[test]
fn check_tells_good_from_bad() {
    let desk = Desk::new();
    fs::write(desk.path("bad.toml"), ROOM.replace("albedo", "albdo")).unwrap();
    let ran = desk.run("check room.toml");
    assert_eq!(ran.status, 0, "{ran:?}");
    assert!(ran.out.contains("3 objects"), "{}", ran.out);

    // Every scene is checked, in order; one bad scene makes the whole bad.
    let ran = desk.run("check bad.toml room.toml --json");
    assert_eq!(ran.status, 2);
    let verdicts: Vec<Value> =
        ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((&verdicts[0]["ok"], &verdicts[1]["ok"]), (&false.into(), &true.into()));
    let error = verdicts[0]["error"].as_str().unwrap();
    assert!(error.starts_with("bad.toml:19:1: ") && error.contains("\"albedo\""), "{error}");

    // Notes say by themselves which file they are about.
    fs::write(desk.path("bare.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let ran = desk.run("check bare.obj");
    let notes: Vec<_> = ran.error.lines().collect();
    assert!(!notes.is_empty() && notes.iter().all(|n| n.matches("bare.obj: ").count() == 1));
}

/// What only shows when a scene is prepared is told as well, with the line it is about: here
/// glass that is wound inside out.
#[test]
fn check_looks_as_closely_as_rendering() {
    let desk = Desk::new();
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
    fs::write(desk.path("inside-out.obj"), tetrahedron).unwrap();
    let mesh = "\n[[shape]]\ntype = \"mesh\"\nfile = \"inside-out.obj\"\nmaterial = \"glass\"\n";
    fs::write(desk.path("glass.toml"), format!("{ROOM}{mesh}")).unwrap();
    let ran = desk.run("check room.toml glass.toml");
    assert_eq!(ran.status, 0, "{ran:?}");
    let place = format!("glass.toml:{}: ", ROOM.lines().count() + 2);
    let turned = |text: &str| text.contains(&place) && text.contains("inside out");
    assert_eq!(ran.error.lines().filter(|line| turned(line)).count(), 1, "{}", ran.error);
    let verdict = desk.json("check glass.toml --json");
    let notes = verdict["notes"].as_array().unwrap();
    assert!(notes.iter().any(|note| turned(note.as_str().unwrap())), "{verdict}");
}

#[test]
fn info_counts_what_is_there() {
    let desk = Desk::new();
    let info = desk.json("info room.toml --json");
    assert_eq!(info["objects"], 3);
    assert_eq!(info["triangles"], 4);
    assert_eq!(info["materials"]["dielectric"], 1);
    assert_eq!(info["lights"]["glowing rectangle"], 1);
    assert_eq!(info["lights"]["even sky"], 1);
    assert!(number(&info["bvh"]["nodes"]) >= 1.0);
    assert!(number(&info["bvh"]["bytes"]) > 0.0);
    for (corner, expected) in [(0, [-3.0, 0.0, -3.0]), (1, [3.0, 2.0, 3.0])] {
        for (i, expected) in expected.into_iter().enumerate() {
            let got = number(&info["bounds"][corner][i]);
            assert!((got - expected).abs() < 1e-4, "{info}");
        }
    }
    let text = desk.run("info room.toml").out;
    assert!(text.contains("SAH cost") && text.contains("4 triangles"), "{text}");
}

// ---- render ----

/// The picture is a function of the scene alone: the old program lost rows with 7 threads and
/// shifted bands with 16.
#[test]
fn any_threads_instructions_and_trees_give_the_same_pixels() {
    let desk = Desk::new();
    let hash = |arguments: &str| {
        desk.json(&format!("room.toml -o a.exr --quiet --json {arguments}"))["hash"].clone()
    };
    let expected = hash("--threads 1");
    for threads in [2, 3, 5, 7, 16, 61] {
        assert_eq!(hash(&format!("--threads {threads}")), expected, "{threads} threads");
    }
    for simd in ["scalar", "auto"] {
        assert_eq!(hash(&format!("--simd {simd}")), expected, "{simd}");
    }
    for build in ["fast", "default", "high"] {
        assert_eq!(hash(&format!("--build {build}")), expected, "{build}");
    }
    assert_ne!(hash("--seed 1"), expected);
    assert_ne!(hash("--sampler independent"), expected);
}

/// Windows of a picture, put together, are the picture.
#[test]
fn crops_put_together_are_the_whole() {
    let desk = Desk::new();
    desk.json("room.toml -o whole.exr --json");
    let whole = desk.image("whole.exr");
    let rgb = whole.rgb().unwrap();
    // Cuts at odd places, one column wide and one row high among them.
    let (xs, ys) = ([0, 1, 37, 64, 101], [0, 31, 32, 97]);
    let mut pixels = 0;
    for x in xs.windows(2) {
        for y in ys.windows(2) {
            let (w, h) = (x[1] - x[0], y[1] - y[0]);
            desk.json(&format!("room.toml -o part.exr --json --crop {},{},{w},{h}", x[0], y[0]));
            let part = desk.image("part.exr");
            assert_eq!((part.width() as usize, part.height() as usize), (w, h));
            for (i, pixel) in part.rgb().unwrap().iter().enumerate() {
                let at = (y[0] + i / w) * 101 + x[0] + i % w;
                assert_eq!(*pixel, rgb[at], "pixel {at}");
                pixels += 1;
            }
        }
    }
    assert_eq!(pixels, 101 * 97);
}

/// Without `-o` the picture is called like the scene and lies in the current folder; the hash of
/// the pixels is the only thing on standard output.
#[test]
fn the_picture_is_called_like_the_scene() {
    let desk = Desk::new();
    fs::create_dir(desk.path("scenes")).unwrap();
    fs::rename(desk.path("room.toml"), desk.path("scenes/room.v2.toml")).unwrap();
    let ran = desk.run("scenes/room.v2.toml --spp 1");
    assert_eq!(ran.status, 0, "{ran:?}");
    assert_eq!(desk.files(), ["room.v2.png", "scenes"]);
    let hash = ran.out.strip_prefix("hash ").unwrap().trim_end();
    assert_eq!(hash.len(), 16);
    assert!(hash.chars().all(|c| c.is_ascii_hexdigit()), "{hash}");
    assert!(ran.error.contains("wrote room.v2.png"), "{}", ran.error);

    let quiet = desk.run("scenes/room.v2.toml --spp 1 --quiet");
    assert_eq!((quiet.out, quiet.error), (ran.out, String::new()));
}

/// Without anything: the built-in scene, small here, and what to try next.
#[test]
fn the_built_in_scene_needs_no_file() {
    let desk = Desk::new();
    let ran = desk.run("--size 40x30 --spp 1");
    assert_eq!(ran.status, 0, "{ran:?}");
    assert!(desk.files().contains(&"glass-cube.png".to_owned()));
    assert!(ran.error.contains("rutilant --help"), "{}", ran.error);
    assert_eq!(desk.image("glass-cube.png").width(), 40);
}

/// Files for eyes obey the display; files for light do not.
#[test]
fn exposure_changes_what_is_shown_and_not_what_is_stored() {
    let desk = Desk::new();
    let hash = |arguments: &str| desk.json(arguments)["hash"].clone();
    let plain = hash("room.toml -o a.exr -o a.png --json");
    let brighter = hash("room.toml -o b.exr -o b.png --exposure 2 --curve filmic --json");
    assert_eq!(plain, brighter);
    assert_eq!(fs::read(desk.path("a.exr")).unwrap(), fs::read(desk.path("b.exr")).unwrap());
    assert_ne!(fs::read(desk.path("a.png")).unwrap(), fs::read(desk.path("b.png")).unwrap());
}

/// Grey 0.18 is 118 on a screen, and 0.18 in a file that holds light, under every curve and
/// exposure. The old program had a gamma of 2 and a hidden factor of 1.5.
#[test]
fn middle_grey_is_118_for_eyes_and_itself_in_files_of_light() {
    let desk = Desk::new();
    let scene = "version = 1\nrender.size = [4, 4]\nrender.spp = 4\nenvironment.color = 0.18
        camera.position = [0, 0, 1]\ncamera.look_at = [0, 0, 0]";
    fs::write(desk.path("grey.toml"), scene).unwrap();
    for (options, byte) in [("", 118), ("--curve agx", 118), ("--curve aces --exposure 1", 141)] {
        desk.json(&format!("grey.toml -o grey.exr -o grey.png --json {options}"));
        let (light, shown) = (desk.image("grey.exr"), desk.image("grey.png"));
        assert_eq!(light.channel("G").unwrap(), [0.18; 16], "{options}");
        let code = |linear: f32| (255.0 * rutilant::display::srgb_from_linear(linear)).round();
        let bytes: Vec<f32> = shown.channel("G").unwrap().iter().map(|&c| code(c)).collect();
        assert_eq!(bytes, [byte as f32; 16], "{options}");
    }
}

/// `--camera` sees the scene by another of its cameras, in all modes.
#[test]
fn cameras_are_chosen_by_name() {
    let desk = Desk::new();
    let (head, tail) = ROOM.split_once("[camera]\n").expect("a camera");
    let camera = |name: &str, at: &str| {
        format!("[[camera]]\nname = \"{name}\"\nposition = {at}\nlook_at = [0, 0, 0]\n")
    };
    let two = [camera("front", "[0, 1, 5]"), camera("top", "[0, 6, 1]")].concat();
    let rest = &tail[tail.find("\n[").expect("another table")..];
    fs::write(desk.path("two.toml"), format!("{head}{two}{rest}")).unwrap();
    let hash =
        |options: &str| desk.json(&format!("two.toml {options} --json -o a.hdr"))["hash"].clone();
    assert_eq!(hash(""), hash("--camera front"));
    assert_ne!(hash(""), hash("--camera top"));
    let names =
        |options: &str| desk.json(&format!("info two.toml --json {options}"))["cameras"].clone();
    assert_eq!(names(""), serde_json::json!(["front", "top"]));
    assert_eq!(names("--camera top"), serde_json::json!(["top", "front"]));
    assert!(desk.run("info two.toml").out.contains("cameras    front, top\n"));
    for mode in ["render", "check", "info"] {
        let ran = desk.run(&format!("{mode} two.toml --camera tp"));
        assert_eq!(ran.status, 2);
        assert!(
            ran.error.contains("two.toml: no camera \"tp\"; did you mean \"top\"?"),
            "{}",
            ran.error
        );
    }
}

/// `-D` gives a Mitsuba scene its parameters, in all modes; a furnace of radiance 2 around a ball that
/// sends back half of what it gets shows the ball as 1, and the sky as 2.
#[test]
fn parameters_are_given() {
    let desk = Desk::new();
    let scene = "<scene version=\"3.0.0\"><default name=\"light\" value=\"1\"/><sensor \
        type=\"orthographic\"><transform name=\"to_world\"><lookat origin=\"0 0 5\" target=\"0 0 0\" \
        up=\"0 1 0\"/></transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"$size\"/>\
        <integer name=\"height\" value=\"5\"/><rfilter type=\"box\"/></film></sensor><emitter \
        type=\"constant\"><rgb name=\"radiance\" value=\"$light\"/></emitter><shape \
        type=\"sphere\"><float name=\"radius\" value=\"0.6\"/></shape></scene>";
    fs::write(desk.path("ball.xml"), scene).unwrap();
    desk.json("ball.xml -D size=5 --define light=2 -o a.exr --json --spp 256");
    let red = desk.image("a.exr").channel("R").unwrap().to_vec();
    assert!((red[12] - 1.0).abs() < 0.05 && red[0] == 2.0, "{red:?}");
    for mode in ["render", "check", "info"] {
        let said = |options: &str| {
            let ran = desk.run(&format!("{mode} ball.xml {options}"));
            assert_eq!(ran.status, 2);
            ran.error
        };
        let error = said("");
        assert!(error.contains("ball.xml:1:"), "{error}");
        assert!(error.contains("no parameter \"size\": it has no <default>"), "{error}");
        let error = said("-D size=3 -D lihgt=2");
        assert!(error.contains("no parameter \"lihgt\"; did you mean \"light\"?"), "{error}");
        assert!(said("-D size").contains("write it as NAME=VALUE, like spp=64"));
    }
}

/// Any scene stands under the sky that is asked for: under an even one every pixel that sees only
/// sky has its radiance; what is neither a radiance nor a picture is refused by name.
#[test]
fn another_sky_is_asked_for() {
    let desk = Desk::new();
    let scene = "version = 1\nrender.size = [2, 2]\nrender.spp = 1\nenvironment.color = 7
        camera.position = [0, 0, 1]\ncamera.look_at = [0, 0, 0]";
    fs::write(desk.path("sky.toml"), scene).unwrap();
    let red = |options: &str| {
        desk.json(&format!("sky.toml -o a.exr --json {options}"));
        desk.image("a.exr").channel("R").unwrap().to_vec()
    };
    assert_eq!(red(""), [7.0; 4]);
    assert_eq!(red("--environment 0.25,1,3"), [0.25; 4]);
    assert_eq!(red("--environment none"), [0.0; 4]);
    fs::copy(desk.path("a.exr"), desk.path("dark.exr")).unwrap();
    assert_eq!(red("--environment dark.exr"), [0.0; 4]);
    for (asked, said) in [
        ("1,2", "write none, a radiance as one number or three, like 0.8,0.9,1, or the path"),
        ("-1", "a radiance must lie between 0 and 1e18"),
        ("--quiet", "write none, a radiance as one number or three"),
        ("-o", "write none, a radiance as one number or three"),
        ("#ffffff", "write none, a radiance as one number or three"),
        ("-1,0,0", "a radiance must lie between 0 and 1e18"),
        ("gone.hdr", "gone.hdr: "),
        ("sky.toml", "sky.toml: "),
        ("nan", "'nan' for '--environment"),
        ("1,inf,1", "a radiance must lie between 0 and 1e18"),
        ("1 --at-time nan", "'nan' for '--at-time"),
        ("1 --at-time -inf", "'-inf' for '--at-time"),
        ("1 --variant red", "sky.toml: no variant \"red\": only glTF files have variants"),
    ] {
        let ran = desk.run(&format!("sky.toml --environment {asked}"));
        assert_eq!(ran.status, 2, "{}", ran.error);
        assert!(ran.error.contains(said), "{}", ran.error);
    }
}

/// Focusing says what became sharp, changes the picture only where there is a lens, and is kept
/// with the picture.
#[test]
fn focusing_on_a_pixel_is_told() {
    let desk = Desk::new();
    let lens = ROOM.replace("fov_degrees = 40", "fov_degrees = 40\naperture_radius = 0.1");
    fs::write(desk.path("lens.toml"), &lens).unwrap();
    // Through the glass ball to the floor behind it.
    let said = desk.json("lens.toml --focus-on 50,46 --json -o a.hdr");
    let focus = &said["focus"];
    assert!(number(&focus["distance"]) > 1.0 && number(&focus["path_length"]) > 3.0, "{said}");
    assert_eq!(focus["bounces"], 2, "{said}");
    assert_eq!(said["notes"].as_array().map(Vec::len), Some(0), "{said}");
    assert_ne!(said["hash"], desk.json("lens.toml --json -o b.hdr")["hash"]);
    let header = String::from_utf8_lossy(&fs::read(desk.path("a.hdr")).unwrap()).into_owned();
    assert!(header.contains("focus_on: 50,46"), "the picture says how to make it again");

    // The scene says the same; `info` measures without rendering.
    let scene = lens.replace("fov_degrees", "focus_on = [50, 46]\nfov_degrees");
    fs::write(desk.path("scene.toml"), scene).unwrap();
    assert_eq!(desk.json("scene.toml --json -o b.hdr")["hash"], said["hash"]);
    assert_eq!(desk.json("info scene.toml --json")["focus"], *focus);
    assert_eq!(desk.json("info lens.toml --json --focus-on 50,46")["focus"], *focus);
    let people = desk.run("info scene.toml");
    assert!(people.out.contains("m along the view"), "{}", people.out);

    // What comes to nothing is said: no lens, nothing there.
    let pinhole = desk.run("room.toml --focus-on 50,46 -o c.hdr");
    assert!(pinhole.error.contains("a pinhole sees everything sharp"), "{}", pinhole.error);
    let sky = desk.run("lens.toml --focus-on 0,0 -o c.hdr");
    assert!(sky.error.contains("the focus stays at 4.0"), "{}", sky.error);
    for wrong in ["101,5", "5", "-1,2"] {
        let ran = desk.run(&format!("lens.toml --focus-on {wrong}"));
        assert_eq!(ran.status, 2, "{wrong}: {}", ran.error);
    }
    let around = ROOM.replace("fov_degrees = 40", "type = \"equirectangular\"");
    fs::write(desk.path("around.toml"), around).unwrap();
    let ran = desk.run("around.toml --focus-on 5,5");
    assert!(ran.status == 2 && ran.error.contains("has none"), "{}", ran.error);
}

/// Sixteen bits a number keep three digits.
#[test]
fn half_numbers_take_half_the_room() {
    let desk = Desk::new();
    desk.json("room.toml --json -q --channels color -o float.exr");
    desk.json("room.toml --json -q --channels color --bits 16 -o half.exr");
    let bytes = |name| fs::metadata(desk.path(name)).unwrap().len();
    assert!(4 * bytes("half.exr") < 3 * bytes("float.exr"), "less is stored");
    let (float, half) = (desk.image("float.exr"), desk.image("half.exr"));
    for (a, b) in float.channel("G").unwrap().iter().zip(half.channel("G").unwrap()) {
        assert!((a - b).abs() <= a.abs() / 1024.0 + 1e-7, "{a} {b}");
    }
}

/// One number says how finely files are stored, and each format takes the nearest it has.
#[test]
fn bits_are_those_of_the_format() {
    let desk = Desk::new();
    // What the header of a PNG says, and the type of R in an EXR: 1 is half, 2 is float.
    let png = |name: &str| fs::read(desk.path(name)).unwrap()[24];
    let exr = |name: &str| {
        let bytes = fs::read(desk.path(name)).unwrap();
        let channel = b"\0R\0";
        let at = bytes.windows(3).position(|w| w == channel).unwrap();
        bytes[at + 3]
    };
    for (bits, expected) in
        [("", (8, 2)), ("--bits 8", (8, 1)), ("--bits 16", (16, 1)), ("--bits 32", (16, 2))]
    {
        let outputs = "-o a.png -o a.exr -o a.jpg -o a.hdr";
        desk.json(&format!("room.toml --spp 1 --json {outputs} {bits}"));
        assert_eq!((png("a.png"), exr("a.exr")), expected, "{bits}");
    }
    // Sixteen bits show the same picture, more finely.
    desk.json("room.toml --spp 1 --json -o fine.png --bits 16");
    desk.json("room.toml --spp 1 --json -o plain.png");
    let [fine, plain] = ["fine.png", "plain.png"].map(|name| desk.image(name).rgb().unwrap());
    let code = |c: f32| rutilant::display::srgb_from_linear(c) * 255.0;
    for (a, b) in fine.iter().flatten().zip(plain.iter().flatten()) {
        assert!((code(*a) - code(*b)).abs() <= 0.501, "{a} {b}");
    }
    assert!(fine.iter().flatten().any(|c| (code(*c) - code(*c).round()).abs() > 0.1));
}

/// EXR files tell how sure each pixel is: the variance of its mean, and its number of samples.
#[test]
fn exr_files_tell_variance_and_samples() {
    let desk = Desk::new();
    let names = |name: &str| -> Vec<String> {
        desk.image(name).channels().iter().map(|c| c.name.clone()).collect()
    };
    desk.json("room.toml --json -o all.exr");
    desk.json("room.toml --json -o color.exr --channels color");
    let all = ["R", "G", "B", "samples.Y", "variance.R", "variance.G", "variance.B"];
    assert_eq!(names("all.exr"), all);
    assert_eq!(names("color.exr"), all[..3]);
    let image = desk.image("all.exr");
    assert!(image.channel("samples.Y").unwrap().iter().all(|&n| n == 4.0), "4 spp");
    assert_eq!(image.rgb(), desk.image("color.exr").rgb());
}

/// A picture says how it was made, in the words of the command line: those words make it again.
#[test]
fn a_picture_says_how_to_make_it_again() {
    let desk = Desk::new();
    let said = "--spp 2 --seed 7 --size 40x30 --crop 4,3,20,10 --integrator naive \
                --sampler independent --max-depth 3";
    desk.json(&format!("room.toml --json -o a.hdr {said}"));
    let bytes = fs::read(desk.path("a.hdr")).unwrap();
    let header = String::from_utf8_lossy(&bytes);
    let kept: Vec<_> = header
        .lines()
        .take_while(|line| !line.is_empty())
        .filter_map(|line| line.strip_prefix("# ")?.split_once(": "))
        .map(|(name, value)| format!("--{} {value}", name.replace('_', "-")))
        .collect();
    for option in ["--spp 2", "--seed 7", "--size 40x30", "--crop 4,3,20,10"] {
        assert!(kept.iter().any(|k| k == option), "{option}: {kept:?}");
    }
    desk.json(&format!("room.toml --json -o b.hdr {}", kept.join(" ")));
    assert_eq!(bytes, fs::read(desk.path("b.hdr")).unwrap());
}

/// An option without effect is not passed over in silence.
#[test]
fn a_max_depth_without_effect_is_told() {
    let desk = Desk::new();
    for (integrator, heeds) in [
        ("path", true),
        ("naive", true),
        ("direct", false),
        ("ao", false),
        ("normals", false),
        ("albedo", false),
        ("depth", false),
    ] {
        let ran = desk.run(&format!("room.toml --spp 1 --integrator {integrator} --max-depth 2"));
        assert_eq!(ran.status, 0, "{integrator}: {ran:?}");
        assert_eq!(ran.error.contains("--max-depth"), !heeds, "{integrator}: {}", ran.error);
    }
    let ran = desk.run("room.toml --spp 1 --integrator direct");
    assert!(!ran.error.contains("--max-depth"), "{}", ran.error);
}

/// Layers that no file can hold are told as such.
#[test]
fn layers_without_a_file_are_told() {
    let desk = Desk::new();
    for (arguments, told) in
        [("-o a.png", true), ("-o b.exr --channels color", true), ("-o c.png -o d.exr", false)]
    {
        let ran = desk.run(&format!("room.toml --spp 1 --layers albedo {arguments}"));
        assert_eq!(ran.status, 0, "{arguments}: {ran:?}");
        assert_eq!(ran.error.contains("--layers"), told, "{arguments}: {}", ran.error);
    }
}

/// Programs get lines of JSON, the result last, and nothing else.
#[test]
fn progress_for_programs_is_lines_of_json() {
    let desk = Desk::new();
    let ran = desk.run("room.toml --spp 8 --progress json");
    assert_eq!(ran.status, 0, "{ran:?}");
    let lines: Vec<Value> =
        ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let (last, updates) = lines.split_last().unwrap();
    assert!(!updates.is_empty() && updates.iter().all(|u| u["event"] == "progress"));
    let final_update = updates.last().unwrap();
    assert_eq!((&final_update["samples"], &final_update["done"]), (&8.into(), &1.0.into()));
    assert_eq!((&last["event"], &last["spp"]), (&"done".into(), &8.into()));
    assert_eq!(last["paths"], 8 * 101 * 97);
    assert!(number(&last["rays"]) >= number(&last["paths"]));
}

/// Time alone ends a rendering that has no other end, and not much later than asked.
#[test]
fn a_time_limit_is_kept() {
    let desk = Desk::new();
    let result = desk.json("room.toml --time 1s --json");
    let seconds = number(&result["seconds"]["render"]);
    assert!((0.5..2.0).contains(&seconds), "{seconds}");
    assert!(number(&result["spp"]) >= 1.0);
    assert_eq!(result["interrupted"], false);
    // Samples that are reached first end it first.
    assert_eq!(desk.json("room.toml --time 1h --spp 2 --json")["spp"], 2);
}

/// Long paths in a small picture must not make a pass so long that time is forgotten: this room
/// keeps every path for 3000 segments.
#[test]
fn a_time_limit_is_kept_by_slow_small_pictures() {
    let desk = Desk::new();
    let white_room = r#"
        version = 1
        [render]
        size = [32, 32]
        max_depth = 3000
        roulette = "off"
        [camera]
        position = [0, 0, 0]
        look_at = [0, 0, -1]
        [[material]]
        name = "white"
        type = "matte"
        albedo = 1
        [[shape]]
        type = "box"
        size = [4, 4, 4]
        material = "white"
    "#;
    fs::write(desk.path("white.toml"), white_room).unwrap();
    let done = desk.json("white.toml --time 1s --json -o a.png");
    // A pass is half a million rays or one sample per pixel, which is three million here.
    assert!(number(&done["seconds"]["render"]) < 20.0, "{done}");
    assert!(number(&done["spp"]) >= 1.0);
}

/// A picture in place of a scene is told so, whatever the output would be called.
#[test]
fn a_picture_is_no_scene() {
    let desk = Desk::new();
    fs::write(desk.path("a.png"), b"\x89PNG").unwrap();
    let ran = desk.run("a.png");
    assert_eq!(ran.status, 2);
    assert!(ran.error.contains("no scene format .png; there are .toml"), "{}", ran.error);
    assert_eq!(desk.files(), ["a.png", "room.toml"]);
}

/// A camera that is chosen to see everything fits the picture that is asked for: in a narrow one
/// it stands farther away.
#[test]
fn a_chosen_camera_fits_the_size_on_the_command_line() {
    let desk = Desk::new();
    fs::write(desk.path("bar.obj"), "v -1 0 0\nv 1 0 0\nv 1 .1 0\nv -1 .1 0\nf 1 2 3 4\n").unwrap();
    for size in ["160x400", "400x160", "100x100"] {
        let ran = desk.run(&format!("bar.obj --size {size} --integrator depth --spp 4 -o a.pfm"));
        assert_eq!(ran.status, 0, "{}", ran.error);
        let image = desk.image("a.pfm");
        let (width, height) = (image.width() as usize, image.height() as usize);
        let seen = image.channel("R").unwrap();
        let on_border = |i: usize| {
            let (x, y) = (i % width, i / width);
            x == 0 || y == 0 || x + 1 == width || y + 1 == height
        };
        assert!(seen.iter().any(|&d| d > 0.0), "{size}");
        assert!((0..seen.len()).all(|i| seen[i] == 0.0 || !on_border(i)), "{size}");
    }
}

/// Starts a rendering without an end and waits until it is under way.
#[cfg(unix)]
fn start_endless(desk: &Desk, arguments: &str) -> std::process::Child {
    use std::io::{BufRead, BufReader};
    let mut child = desk
        .command(&format!("room.toml --time 1h --progress json {arguments}"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Read to the first update that counts something; later ones stay in the pipe, unread.
    let mut out = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while !line.contains("\"paths\":") || line.contains("\"paths\":0,") {
        line.clear();
        assert!(out.read_line(&mut line).unwrap() > 0, "the program ended");
    }
    std::thread::spawn(move || out.lines().count());
    child
}

#[cfg(unix)]
fn signal(child: &std::process::Child, name: &str) {
    let status = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

/// The first Ctrl-C, or the system's wish to end, writes what there is.
#[cfg(unix)]
#[test]
fn an_interrupt_writes_the_image() {
    for name in ["-INT", "-TERM"] {
        let desk = Desk::new();
        let mut child = start_endless(&desk, "-o a.exr -o a.png");
        signal(&child, name);
        assert_eq!(child.wait().unwrap().code(), Some(130), "{name}");
        assert_eq!(desk.files(), ["a.exr", "a.png", "room.toml"], "{name}");
        let image = desk.image("a.exr");
        assert_eq!((image.width(), image.height()), (101, 97));
        assert!(image.rgb().unwrap().iter().flatten().all(|c| c.is_finite()));
    }
}

/// Programs like `timeout` signal a process and its group in one breath: that is one wish to end,
/// not two, and the picture is written.
#[cfg(unix)]
#[test]
fn an_echo_of_an_interrupt_is_no_second_one() {
    for _ in 0..5 {
        let desk = Desk::new();
        let mut child = start_endless(&desk, "-o a.png");
        // One call, so that the two come as close together as they can.
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id, &id]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(desk.files(), ["a.png", "room.toml"]);
    }
}

/// The second Ctrl-C ends the program at once, and no half of a file is left.
#[cfg(unix)]
#[test]
fn a_second_interrupt_stops_at_once() {
    let desk = Desk::new();
    // One pass of this takes far longer than the test waits.
    let mut child = start_endless(&desk, "--threads 1 --size 3000x3000 -o a.png");
    signal(&child, "-INT");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(child.try_wait().unwrap(), None, "the first interrupt waits for the pass");
    let asked = Instant::now();
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(asked.elapsed() < Duration::from_secs(2), "{:?}", asked.elapsed());
    assert_eq!(desk.files(), ["room.toml"]);
}

/// A place that vanishes while the picture is being made costs that file and no other, and is
/// not called a success.
#[cfg(unix)]
#[test]
fn an_output_that_fails_late_leaves_the_others() {
    let desk = Desk::new();
    fs::create_dir(desk.path("gone")).unwrap();
    let mut child = start_endless(&desk, "-o gone/a.exr -o b.exr");
    fs::remove_dir(desk.path("gone")).unwrap();
    signal(&child, "-INT");
    assert_eq!(child.wait().unwrap().code(), Some(1));
    assert_eq!(desk.files(), ["b.exr", "room.toml"]);
    let mut error = String::new();
    child.stderr.take().unwrap().read_to_string(&mut error).unwrap();
    assert!(error.lines().last().unwrap().starts_with("error: gone/a.exr: "), "{error}");
}

// ---- compare ----

/// Writes a picture by formula.
fn write_picture(path: &Path, size: [u32; 2], f: impl Fn(u32, u32) -> [f32; 3]) {
    let [width, height] = size;
    let pixels: Vec<_> = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
    let pixels: Vec<_> = pixels.into_iter().map(|(x, y)| f(x, y)).collect();
    let image = Image::from_rgb(width, height, &pixels).unwrap();
    let rgb8 = pixels.iter().flat_map(|c| Display::default().encode(*c)).collect::<Vec<_>>();
    let pixels = if path.extension().is_some_and(|e| e == "png") {
        Pixels::Display { width, height, rgb8: &rgb8 }
    } else {
        Pixels::Light(&image)
    };
    rutilant_formats::image::write(path, pixels, &Default::default()).unwrap();
}

#[test]
fn compare_measures_known_differences() {
    let desk = Desk::new();
    let size = [64, 48];
    let ramp = |x: u32, y: u32| [x as f32 / 64.0, y as f32 / 48.0, 0.5];
    write_picture(&desk.path("a.exr"), size, ramp);
    write_picture(&desk.path("b.exr"), size, |x, y| ramp(x, y).map(|c| c + 0.25));
    write_picture(&desk.path("a.png"), size, ramp);

    let same = desk.json("compare a.exr a.exr --json");
    for key in ["rmse", "relmse", "relmse_999", "flip", "hdr_flip"] {
        assert_eq!(number(&same[key]), 0.0, "{key}");
    }
    assert_eq!(same["psnr"], Value::Null);
    assert!((number(&same["ssim"]) - 1.0).abs() < 1e-6, "{same}");

    let off = desk.json("compare b.exr a.exr --json --diff diff.png");
    assert!((number(&off["rmse"]) - 0.25).abs() < 1e-3, "{off}");
    assert!((number(&off["bias"]) - 0.25).abs() < 1e-3, "{off}");
    assert!(number(&off["flip"]) > 0.05 && number(&off["hdr_flip"]) > 0.05, "{off}");
    assert_eq!((desk.image("diff.png").width(), desk.image("diff.png").height()), (64, 48));

    // A picture for eyes has no exposures to try.
    let shown = desk.json("compare a.png a.exr --json");
    assert_eq!(shown["hdr_flip"], Value::Null);
    assert!(number(&shown["flip"]) < 1e-3, "{shown}");
    let text = desk.run("compare b.exr a.exr").out;
    for word in ["RMSE", "relMSE", "worst 0.1 %", "PSNR", "SSIM", "FLIP", "HDR-FLIP"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn compare_counts_what_is_no_number() {
    let desk = Desk::new();
    write_picture(&desk.path("a.exr"), [20, 20], |_, _| [0.5; 3]);
    write_picture(&desk.path("nan.exr"), [20, 20], |x, _| [if x == 3 { f32::NAN } else { 0.5 }; 3]);
    let result = desk.json("compare nan.exr a.exr --json");
    assert_eq!(result["not_finite"], serde_json::json!([20, 0]));
    assert_eq!(number(&result["rmse"]), 0.0);
    assert_eq!(number(&result["flip"]), 0.0);
    let nothing = desk.run("compare a.exr room.toml");
    assert_eq!(nothing.status, 2, "{nothing:?}");
}

/// Pixels next to nothing around a lamp: this once asked for four billion exposures.
#[test]
fn compare_survives_a_median_next_to_nothing() {
    let desk = Desk::new();
    let dark = |x: u32, y: u32| [if (x, y) == (5, 5) { 1.0 } else { 1e-41 }; 3];
    write_picture(&desk.path("a.pfm"), [16, 12], dark);
    let same = desk.json("compare a.pfm a.pfm --json");
    for key in ["rmse", "relmse", "flip", "hdr_flip"] {
        assert_eq!(number(&same[key]), 0.0, "{key}");
    }
}

#[test]
fn compare_refuses_other_sizes() {
    let desk = Desk::new();
    write_picture(&desk.path("a.exr"), [20, 20], |_, _| [0.5; 3]);
    write_picture(&desk.path("b.exr"), [20, 21], |_, _| [0.5; 3]);
    let ran = desk.run("compare a.exr b.exr");
    assert_eq!(ran.status, 2, "{ran:?}");
    assert!(ran.error.contains("20×20") && ran.error.contains("20×21"), "{}", ran.error);
}

// ---- bench ----

/// Four rays over a unit triangle: two hits at t = 1 and 3, one beyond its range, one beside.
#[test]
fn bench_finds_the_right_hits() {
    let desk = Desk::new();
    let write = |name: &str, numbers: &[f32]| {
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        fs::write(desk.path(name), bytes).unwrap();
    };
    write("one.tris", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let ray = |x: f32, z: f32, t_max: f32| [x, 0.25, z, 0.0, 0.0, 0.0, -1.0, t_max];
    let rays =
        [ray(0.25, 1.0, 1e30), ray(0.25, 3.0, 1e30), ray(0.25, 3.0, 2.0), ray(2.0, 1.0, 1e30)];
    write("four.rays", rays.as_flattened());
    for threads in [1, 3] {
        let report = desk.json(&format!(
            "bench rays one.tris four.rays four.rays --repetitions 2 --threads {threads} --json"
        ));
        assert_eq!(report["triangles"], 1);
        for set in report["sets"].as_array().unwrap() {
            assert_eq!((&set["hits"], &set["blocked"]), (&2.into(), &2.into()), "{set}");
            assert!((number(&set["sum_of_t"]) - 4.0).abs() < 1e-5, "{set}");
        }
    }
    let text = desk.run("bench rays one.tris four.rays").out;
    assert!(text.contains("four.rays") && text.contains("Mray/s"), "{text}");

    write("short.rays", &[1.0; 9]);
    write("nan.rays", &[f32::NAN; 8]);
    for (numbers, what) in [
        ([0.0, f32::INFINITY, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0], "ray 0: origin is"),
        ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f32::NAN, 1.0], "ray 0: direction is"),
        ([0.0; 8], "ray 0: direction is 0"),
        ([0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 1.0], "ray 0: t_min is -1, but must be 0 or more"),
        ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, f32::NAN], "ray 0: t_max is NaN"),
    ] {
        write("bad.rays", &numbers);
        let ran = desk.run("bench rays one.tris bad.rays");
        assert_eq!(ran.status, 2, "{what}");
        assert!(ran.error.contains(what), "{what}: {}", ran.error);
    }
    for bad in ["short.rays", "nan.rays", "none.rays", "."] {
        let ran = desk.run(&format!("bench rays one.tris {bad}"));
        assert_eq!(ran.status, 2, "{bad}");
        assert!(ran.error.contains(bad), "{bad}: {}", ran.error);
    }
}

/// What a rendering or a comparison reads is never written over.
#[test]
fn inputs_are_not_written_over() {
    let desk = Desk::new();
    write_picture(&desk.path("sky.hdr"), [8, 4], |_, _| [0.5; 3]);
    write_picture(&desk.path("a.exr"), [8, 4], |_, _| [0.5; 3]);
    fs::write(
        desk.path("sky.toml"),
        "version = 1\n[camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\n\
         [environment]\nimage = \"sky.hdr\"\n",
    )
    .unwrap();
    for (arguments, what) in [
        ("sky.toml -o sky.hdr", "sky.hdr is a file that the scene reads"),
        ("compare a.exr sky.hdr --diff a.exr", "a.exr is one of the pictures to compare"),
        ("compare a.exr sky.hdr --diff sky.hdr", "sky.hdr is one of the pictures to compare"),
    ] {
        let before =
            [fs::read(desk.path("sky.hdr")).unwrap(), fs::read(desk.path("a.exr")).unwrap()];
        let ran = desk.run(arguments);
        assert_eq!(ran.status, 2, "{arguments}: {}", ran.error);
        assert!(ran.error.contains(what), "{arguments}: {}", ran.error);
        let after =
            [fs::read(desk.path("sky.hdr")).unwrap(), fs::read(desk.path("a.exr")).unwrap()];
        assert!(before == after, "{arguments}");
    }
}

/// What a format has no room for is told before rendering, and a scene's own size is limited.
#[test]
fn pictures_too_large_are_refused_at_once() {
    let desk = Desk::new();
    let ran = desk.run("room.toml --size 65536x1 --spp 1000000 -o a.png -o a.jpg");
    assert_eq!(ran.status, 2, "{}", ran.error);
    assert!(ran.error.contains("65536x1 is too large for a JPEG"), "{}", ran.error);
    assert!(!desk.path("a.png").exists());

    let room = fs::read_to_string(desk.path("room.toml")).unwrap();
    let large = room.replace("size = [101, 97]", "size = [11585, 11585]");
    fs::write(desk.path("large.toml"), large).unwrap();
    let ran = desk.run("check large.toml");
    assert_eq!(ran.status, 2, "{}", ran.error);
    assert!(ran.error.contains("large.toml:5:8: "), "{}", ran.error);
    assert!(ran.error.contains("--limit picture=N"), "{}", ran.error);
    let ran = desk.run("large.toml --size 4x4 --spp 1 -o a.png --quiet");
    assert_eq!(ran.status, 0, "{}", ran.error);
}

/// The room written anew shows the same picture, beside the old one and elsewhere; nothing that is there
/// is written over unasked, and never the scene itself.
#[test]
fn scenes_are_converted() {
    let desk = Desk::new();
    let hash = |scene: &str| {
        let line = format!("{scene} -o a.exr --size 16x16 --spp 2 --quiet --json");
        desk.json(&line)["hash"].clone()
    };
    let ran = desk.run("convert room.toml new.toml");
    assert_eq!((ran.status, ran.out.as_str()), (0, ""), "{}", ran.error);
    assert_eq!(ran.error, "wrote new.toml\n");
    assert_eq!(hash("new.toml"), hash("room.toml"));

    for (line, status, said) in [
        ("convert room.toml new.toml", 2, "new.toml: there is such a file already; --force writes"),
        ("convert room.toml room.toml --force", 2, "room.toml: this is the scene itself"),
        ("convert room.toml ./room.toml", 2, "./room.toml: this is the scene itself"),
        ("convert room.toml new.txt", 2, "new.txt: scenes are written as .toml"),
        ("convert room.toml nowhere/a.toml", 1, "nowhere/a.toml: its folder: "),
        ("convert nothing.toml a.toml", 2, "nothing.toml: "),
        ("convert room.toml a.toml --camera nobody", 2, "room.toml: no camera \"nobody\""),
        ("convert room.toml new.toml --force", 0, "wrote new.toml"),
    ] {
        let ran = desk.run(line);
        assert_eq!(ran.status, status, "{line}: {}", ran.error);
        assert!(
            ran.error.contains(said) && ran.error.lines().count() == 1,
            "{line}: {}",
            ran.error
        );
    }
    assert_eq!(fs::read_to_string(desk.path("room.toml")).unwrap(), ROOM);

    // A mesh that is written out somewhere else takes its file along.
    let cube = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\n";
    fs::write(desk.path("two.obj"), cube).unwrap();
    fs::create_dir(desk.path("sent")).unwrap();
    let ran = desk.run("convert two.obj sent/two.toml");
    assert_eq!(ran.status, 0, "{}", ran.error);
    let wrote: Vec<&str> = ran.error.lines().filter(|line| line.starts_with("wrote ")).collect();
    assert_eq!(wrote.len(), 3, "{}", ran.error);
    assert_eq!(wrote[2], "wrote sent/two.toml");
    let ran = desk.run("convert two.obj here.toml");
    assert!(ran.error.contains("\nwrote here_assets/"), "{}", ran.error);
    assert_eq!(hash("sent/two.toml"), hash("two.obj"));
    for word in ["--force", "--copy", "Examples:", "Exit status"] {
        assert!(desk.run("convert --help").out.contains(word), "{word}");
    }
}
