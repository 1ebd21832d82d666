//! Damaged files of every format: a sound value or an error of one line, and soon.
//!
//! The same corpora feed the fuzz targets in `fuzz/`, and the same damage, at length,
//! `cargo run --release -p rutilant-formats --example mutate -- 1000000`.

mod common;
#[path = "common/readers.rs"]
mod readers;

use common::{corpus, cut_everywhere, mutant};
use readers::{READERS, Reader};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

/// No file of a few kilobytes is worth more time.
const PATIENCE: Duration = Duration::from_secs(5);

/// Holds a reader to its promises, and says which bytes broke them; whether it read anything.
fn check(reader: &Reader, bytes: &[u8], origin: impl FnOnce() -> String) -> bool {
    let start = Instant::now();
    let read = catch_unwind(AssertUnwindSafe(|| (reader.check)(bytes)));
    let in_time = start.elapsed() < PATIENCE;
    match read {
        Ok(read) if in_time => read,
        Ok(_) => panic!("{}: {} took {:?}", reader.name, origin(), start.elapsed()),
        Err(_) => panic!("{}: {} broke a promise", reader.name, origin()),
    }
}

/// The corpus of a reader as it is, cut off everywhere, and damaged `count` times.
fn hold(name: &str, count: u64) {
    let reader = READERS.iter().find(|reader| reader.name == name).expect(name);
    let files = corpus(name);
    assert!(!files.is_empty());
    for (file, bytes) in &files {
        // What once went wrong is kept under such a name; all else is a good beginning.
        let read = check(reader, bytes, || file.clone());
        assert!(read || file.starts_with("bad-"), "{name}/{file} is refused");
        if name != "scene_render" {
            cut_everywhere(bytes, |cut| {
                check(reader, cut, || format!("{file} cut at {}", cut.len()));
            });
        }
    }
    for seed in 0..count {
        let (file, bytes) = &files[seed as usize % files.len()];
        check(reader, &mutant(bytes, reader.words, seed), || format!("{file}, seed {seed}"));
    }
}

macro_rules! damage {
    ($($name:ident: $count:literal),*) => {
        $(#[test]
        fn $name() {
            hold(stringify!($name), $count);
        })*

        /// A reader that nobody damages here would be one too many.
        #[test]
        fn every_reader_is_held() {
            let held = [$(stringify!($name)),*];
            assert!(READERS.iter().all(|reader| held.contains(&reader.name)));
        }
    };
}

damage! {
    native: 10000, obj: 10000, mtl: 10000, ply: 10000, gltf: 10000, pbrt: 4000, mitsuba: 5000, serialized: 10000, stl: 10000, exr: 10000, hdr: 10000, pfm: 10000,
    png: 10000, jpeg: 10000, tga: 10000, scene_render: 1000
}
