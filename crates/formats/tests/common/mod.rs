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

/// `count` damaged copies: flipped bits, other bytes, cuts, repeats, insertions, and numbers that
/// parsers fear, in both notations.
pub(crate) fn mutations(bytes: &[u8], count: usize) -> impl Iterator<Item = Vec<u8>> {
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
    let bytes = bytes.to_vec();
    (0..count as u64).map(move |seed| {
        let mut random = Random(seed);
        let mut mutant = bytes.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(mutant.len());
            let end = (at + 1 + random.below(16)).min(mutant.len());
            let feared = FEARED[random.below(FEARED.len())];
            match random.below(8) {
                _ if mutant.is_empty() => mutant.extend(feared),
                0 | 1 => mutant[at] ^= 1 << random.below(8),
                2 => mutant[at] = random.below(256) as u8,
                3 => mutant.truncate(at),
                4 => drop(mutant.drain(at..end)),
                5 => {
                    let part = mutant[at..end].to_vec();
                    let to = random.below(mutant.len());
                    mutant.splice(to..to, part);
                }
                6 => drop(mutant.splice(at..at, feared.iter().copied())),
                _ => {
                    let end = (at + feared.len()).min(mutant.len());
                    mutant.splice(at..end, feared.iter().copied());
                }
            }
        }
        mutant
    })
}
