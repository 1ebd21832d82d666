//! Damages files of every format and holds the readers to their promises.
//!
//! ```sh
//! cargo run --release -p rutilant-formats --example mutate -- 1000000          # all readers
//! cargo run --release -p rutilant-formats --example mutate -- 1000000 ply png  # some of them
//! ```
//!
//! Each reader runs in a process of its own, so that the system can tell its peak memory. A
//! panic, an unsound value, an error of several lines, more than 5 s for one file, and more than
//! 1 GiB of memory are failures: the file is kept in the folder for temporary files, and named.
//! Peak memory is `VmHWM` of `/proc/self/status`, looked at after every thousand files; where
//! there is no such file, it is not judged. The seed of a mutant is its number, so that every run
//! sees the same ones; `--from N` begins elsewhere.

#[path = "../tests/common/mod.rs"]
mod common;
#[path = "../tests/common/readers.rs"]
mod readers;

use common::{corpus, mutant};
use readers::{READERS, Reader};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(5);
const MOST_MEMORY: u64 = 1 << 30;
/// So many failures are enough.
const MOST_FAILURES: u64 = 20;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let usage = || {
        let names: Vec<_> = READERS.iter().map(|reader| reader.name).collect();
        eprintln!("mutate COUNT [READER]... [--from N]; readers are {}", names.join(", "));
        ExitCode::from(2)
    };
    let (mut numbers, mut names, mut from, mut alone) = (Vec::new(), Vec::new(), 0, false);
    let mut words = words.iter();
    while let Some(word) = words.next() {
        match (word.as_str(), word.parse()) {
            ("--alone", _) => alone = true,
            ("--from", _) => match words.next().and_then(|n| n.parse::<u64>().ok()) {
                Some(n) => from = n,
                None => return usage(),
            },
            (_, Ok(number)) => numbers.push(number),
            (name, Err(_)) => names.push(name),
        }
    }
    let &[count] = &numbers[..] else { return usage() };
    let known = |name: &&str| READERS.iter().find(|reader| reader.name == *name);
    if names.iter().any(|name| known(name).is_none()) {
        return usage();
    }
    let chosen: Vec<&Reader> = match names.is_empty() {
        true => READERS.iter().collect(),
        false => names.iter().filter_map(known).collect(),
    };

    if let (true, [reader]) = (alone, &chosen[..]) {
        return damage(reader, from, count);
    }
    println!("reader      files   seconds   slowest     peak  failures");
    let mut all_well = true;
    for reader in chosen {
        let arguments = [reader.name, &count.to_string(), "--from", &from.to_string(), "--alone"];
        let program = std::env::current_exe().expect("this program");
        let status = Command::new(program).args(arguments).status().expect("started");
        if !status.success() {
            all_well = false;
            println!("{:8} FAILED: {status}", reader.name);
        }
    }
    ExitCode::from(u8::from(!all_well))
}

/// What is being read: the seed, and milliseconds since the start at which it began.
static NOW: (AtomicU64, AtomicU64) = (AtomicU64::new(0), AtomicU64::new(u64::MAX));
/// What the last panic said.
static PANIC: Mutex<String> = Mutex::new(String::new());

fn damage(reader: &'static Reader, from: u64, count: u64) -> ExitCode {
    let start = Instant::now();
    let files = corpus(reader.name);
    let file = move |seed: u64| files[seed as usize % files.len()].1.clone();
    std::panic::set_hook(Box::new(|panic| {
        *PANIC.lock().unwrap_or_else(PoisonError::into_inner) =
            panic.to_string().replace('\n', " ");
    }));
    let keep = {
        let file = file.clone();
        move |seed: u64, why: &str| {
            let path = std::env::temp_dir().join(format!("mutant-{}-{seed}", reader.name));
            let kept = std::fs::write(&path, mutant(&file(seed), reader.words, seed));
            println!("{:8} seed {seed}: {why}; kept in {}: {kept:?}", reader.name, path.display());
        }
    };
    // Somebody has to look at the clock while the reader reads.
    std::thread::spawn({
        let keep = keep.clone();
        move || {
            loop {
                std::thread::sleep(Duration::from_millis(200));
                let began = Duration::from_millis(NOW.1.load(Ordering::Relaxed));
                if start.elapsed() > began.saturating_add(PATIENCE) {
                    keep(NOW.0.load(Ordering::Relaxed), "no end after 5 s");
                    std::process::exit(1);
                }
            }
        }
    });

    let (mut failures, mut slowest, mut peak) = (0, Duration::ZERO, None);
    for seed in from..from + count {
        let bytes = mutant(&file(seed), reader.words, seed);
        let began = start.elapsed();
        NOW.0.store(seed, Ordering::Relaxed);
        NOW.1.store(began.as_millis() as u64, Ordering::Relaxed);
        if catch_unwind(AssertUnwindSafe(|| (reader.check)(&bytes))).is_err() {
            failures += 1;
            keep(seed, &PANIC.lock().unwrap_or_else(PoisonError::into_inner));
        }
        NOW.1.store(u64::MAX, Ordering::Relaxed);
        slowest = slowest.max(start.elapsed() - began);
        if seed % 1000 == 999 || seed + 1 == from + count {
            peak = peak_memory();
            if peak > Some(MOST_MEMORY) {
                failures += 1;
                println!("{:8} more than 1 GiB before seed {seed}", reader.name);
                break;
            }
        }
        if failures >= MOST_FAILURES {
            break;
        }
    }
    let peak = peak.map_or("?".to_owned(), |bytes| format!("{:.0} MB", bytes as f64 / 1e6));
    println!(
        "{:8} {count:8} {:9.1} {:7.1} ms {peak:>8}  {failures}",
        reader.name,
        start.elapsed().as_secs_f64(),
        slowest.as_secs_f64() * 1e3,
    );
    ExitCode::from(u8::from(failures > 0))
}

/// The most memory that this process ever had, in bytes.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?;
    Some(kilobytes * 1024)
}
