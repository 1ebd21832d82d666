//! Damage for files, the same on every run.

#![allow(dead_code, reason = "each test file uses its part")]

/// Pseudo-random numbers (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `end`.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    /// A number in [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / (1 << 24) as f32
    }
}

/// Calls `check` with every beginning of `bytes` but the whole.
pub(crate) fn cut_everywhere(bytes: &[u8], mut check: impl FnMut(&[u8])) {
    for end in 0..bytes.len() {
        check(&bytes[..end]);
    }
}

/// Numbers that parsers fear, in both notations, and bytes that move lines and words.
const FEARED: [&[u8]; 22] = [
    b"0",
    b"-1",
    b"-0",
    b"4294967295",
    b"4294967296",
    b"-9223372036854775808",
    b"99999999999999999999",
    b"1e999",
    b"nan",
    b"inf",
    b"/",
    b"//",
    b"\\\n",
    b"\r",
    b"\0",
    b"\xff\xfe",
    b"#",
    b" ",
    &[0; 4],
    &[255; 4],
    &[0, 0, 0, 128],
    &[255, 255, 255, 127],
];

/// A damaged copy of `bytes`, another for every `seed`: flipped bits, other bytes, cuts, repeats,
/// and insertions of what is feared and of the format's own `words`.
pub(crate) fn mutant(bytes: &[u8], words: &[&[u8]], seed: u64) -> Vec<u8> {
    let mut random = Random(seed);
    let mut mutant = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(mutant.len());
        let end = (at + 1 + random.below(40)).min(mutant.len());
        let pick = random.below(FEARED.len() + words.len());
        let word = FEARED.get(pick).unwrap_or_else(|| &words[pick - FEARED.len()]);
        match random.below(9) {
            _ if mutant.is_empty() => mutant.extend(*word),
            0 | 1 => mutant[at] ^= 1 << random.below(8),
            2 => mutant[at] = random.below(256) as u8,
            3 => mutant.truncate(at),
            4 => drop(mutant.drain(at..end)),
            5 => {
                let part = mutant[at..end].to_vec();
                let to = random.below(mutant.len());
                mutant.splice(to..to, part);
            }
            6 => {
                // A line doubled.
                let line = mutant[at..].split_inclusive(|&b| b == b'\n').next().unwrap_or_default();
                let line = line[..line.len().min(200)].to_vec();
                mutant.splice(at..at, line);
            }
            7 => drop(mutant.splice(at..at, word.iter().copied())),
            _ => {
                let end = (at + word.len()).min(mutant.len());
                mutant.splice(at..end, word.iter().copied());
            }
        }
    }
    mutant
}

/// The files that a fuzz target starts from, by their names.
pub(crate) fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/corpus/");
    let entries = std::fs::read_dir(format!("{folder}{target}")).expect("a corpus");
    let mut files: Vec<_> = entries
        .map(|entry| {
            let path = entry.expect("an entry").path();
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            (name, std::fs::read(path).expect("a file"))
        })
        .collect();
    files.sort();
    files
}
