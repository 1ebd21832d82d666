//! Large meshes written on the fly, and what reading them costs.

#![allow(dead_code, reason = "test and example each use their part")]

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// What a reader may cost at most. The figures behind them stand in docs/scene-format.md.
pub(crate) struct Budget {
    /// The extension of the file.
    pub(crate) format: &'static str,
    /// Peak memory for each triangle, the file's own bytes included.
    pub(crate) bytes: f64,
    /// Seconds for a million triangles, on one core of a machine of 2020 that is busy with other
    /// things as well.
    pub(crate) seconds: f64,
}

/// All-in, while reading; afterwards 18 bytes for a triangle are left.
pub(crate) const BUDGETS: [Budget; 2] = [
    Budget { format: "ply", bytes: 64.0, seconds: 0.5 },
    Budget { format: "obj", bytes: 128.0, seconds: 2.0 },
];

/// Writes a hilly square of `2 * side * side` triangles to `path`, whose extension says how.
pub(crate) fn write_hills(path: &Path, side: u32) -> io::Result<u64> {
    let mut file = BufWriter::new(File::create(path)?);
    let triangles = 2 * u64::from(side) * u64::from(side);
    let vertices = (side + 1) * (side + 1);
    let is_ply = path.extension().is_some_and(|extension| extension == "ply");
    if is_ply {
        write!(
            file,
            "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\n\
             property float y\nproperty float z\nelement face {triangles}\n\
             property list uchar int vertex_indices\nend_header\n"
        )?;
    }
    for z in 0..=side {
        for x in 0..=side {
            // Any height will do; this one has few equal neighbours.
            let height = (x.wrapping_mul(x) ^ z.wrapping_mul(7 * z + x)) % 997;
            let point = [x as f32 * 0.01, height as f32 * 0.001, z as f32 * 0.01];
            if is_ply {
                point.iter().try_for_each(|c| file.write_all(&c.to_le_bytes()))?;
            } else {
                writeln!(file, "v {} {} {}", point[0], point[1], point[2])?;
            }
        }
    }
    for z in 0..side {
        for x in 0..side {
            let a = z * (side + 1) + x;
            let (b, c, d) = (a + 1, a + side + 1, a + side + 2);
            for [p, q, r] in [[a, c, b], [b, c, d]] {
                if is_ply {
                    file.write_all(&[3])?;
                    [p, q, r].iter().try_for_each(|v| file.write_all(&v.to_le_bytes()))?;
                } else {
                    writeln!(file, "f {} {} {}", p + 1, q + 1, r + 1)?;
                }
            }
        }
    }
    file.flush()?;
    Ok(triangles)
}

/// Bytes after a name in `/proc/self/status`: `VmHWM` for the most memory that this process had,
/// `VmRSS` for what it has. `None` where there is no such file.
pub(crate) fn memory(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    let kilobytes = line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?;
    Some(kilobytes * 1024)
}

/// Lets `VmHWM` begin anew. Whether that is possible here.
pub(crate) fn forget_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}
