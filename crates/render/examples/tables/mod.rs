//! What the programs that bake tables have in common.

use std::process::ExitCode;

/// Where step `i` of `n` lies between 0 and 1.
pub fn part(i: usize, n: usize) -> f64 {
    i as f64 / (n - 1) as f64
}

/// Writes a table, and says what went wrong if it cannot.
pub fn write(path: &str, bytes: &[u8]) -> ExitCode {
    match std::fs::write(path, bytes) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}

/// What there is `of` each entry of a table of `sizes`, row-major, told by its place in parts of
/// each axis.
pub fn grid<const N: usize, T>(sizes: [usize; N], of: impl Fn([f64; N]) -> T) -> Vec<T> {
    let count = sizes.iter().product();
    let at = |number: usize| {
        let mut rest = number;
        let mut at = [0.0; N];
        for (at, &size) in at.iter_mut().zip(&sizes).rev() {
            *at = part(rest % size, size);
            rest /= size;
        }
        at
    };
    (0..count).map(|number| of(at(number))).collect()
}

/// A table between whose entries straight lines are nowhere below the `truth` (`up` 1) or nowhere
/// above it (`up` -1): entries move by as much as the truth bends away half-way to their
/// neighbours, and then by what is still missing amidst them.
pub fn bounding<const N: usize>(
    sizes: [usize; N],
    up: f64,
    truth: impl Fn([f64; N]) -> f64,
) -> Vec<f64> {
    let exact = grid(sizes, &truth);
    let mut most = vec![0.0_f64; exact.len()];
    for axis in 0..N {
        let stride: usize = sizes[axis + 1..].iter().product();
        // Of places on the far side, which have no next one, less than nothing.
        let half_way = grid(sizes, |mut at| {
            at[axis] += 0.5 / (sizes[axis] - 1) as f64;
            if at[axis] < 1.0 { truth(at) } else { up * f64::NEG_INFINITY }
        });
        for (number, half_way) in half_way.into_iter().enumerate() {
            if let Some(&next) = exact.get(number + stride) {
                let beyond = up * (half_way - 0.5 * (exact[number] + next));
                most[number] = most[number].max(beyond);
                most[number + stride] = most[number + stride].max(beyond);
            }
        }
    }
    let moved: Vec<f64> = exact.iter().zip(most).map(|(exact, most)| exact + up * most).collect();

    // The corners of the cell that starts at an entry.
    let corners = |number: usize| {
        (0..1_usize << N).map(move |corner| {
            let (mut place, mut stride) = (number, 1);
            for axis in (0..N).rev() {
                place += stride * (corner >> axis & 1);
                stride *= sizes[axis];
            }
            place
        })
    };
    let amidst = grid(sizes, |mut at| {
        for (at, size) in at.iter_mut().zip(sizes) {
            *at += 0.5 / (size - 1) as f64;
        }
        at.iter().all(|&at| at < 1.0).then(|| truth(at))
    });
    let mut most = vec![0.0_f64; moved.len()];
    for (number, truth) in amidst.into_iter().enumerate() {
        let Some(truth) = truth else { continue };
        let told = corners(number).map(|corner| moved[corner]).sum::<f64>() / f64::from(1 << N);
        for corner in corners(number) {
            most[corner] = most[corner].max(up * (truth - told));
        }
    }
    moved.iter().zip(most).map(|(moved, most)| moved + up * most).collect()
}
