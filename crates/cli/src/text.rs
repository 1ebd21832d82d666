//! Numbers for people.

use std::time::Duration;

/// `871,309`.
pub(crate) fn count(n: u64) -> String {
    indicatif::HumanCount(n).to_string()
}

/// `12.3 MB`.
pub(crate) fn bytes(n: u64) -> String {
    format!("{}B", scaled(n as f64))
}

/// `3.41 M`: three digits and a prefix, for rates; the unit follows.
pub(crate) fn scaled(x: f64) -> String {
    let (factor, prefix) = match x.abs() {
        a if a >= 1e9 => (1e-9, "G"),
        a if a >= 1e6 => (1e-6, "M"),
        a if a >= 1e3 => (1e-3, "k"),
        _ => (1.0, ""),
    };
    let x = x * factor;
    let digits = match x.abs() {
        a if a >= 99.95 => 0,
        a if a >= 9.995 => 1,
        _ => 2,
    };
    format!("{x:.digits$} {prefix}")
}

/// `1.2346`: five digits, for lengths.
pub(crate) fn significant(x: f32) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    if !(1e-4..1e6).contains(&x.abs()) {
        return format!("{x:.4e}");
    }
    let digits = (4.0 - x.abs().log10().floor()).max(0.0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// `0.31 s`, `1 min 05 s`, `2 h 05 min`.
pub(crate) fn time(t: Duration) -> String {
    let seconds = t.as_secs_f64();
    let whole = seconds.round() as u64;
    match seconds {
        s if s < 0.0095 => format!("{:.1} ms", s * 1e3),
        s if s < 9.995 => format!("{s:.2} s"),
        s if s < 59.95 => format!("{s:.1} s"),
        s if s < 3599.5 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

/// `1 mesh`, `3 meshes`.
pub(crate) fn several(n: u64, one: &str, many: &str) -> String {
    format!("{} {}", count(n), if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(count(871_309), "871,309");
        assert_eq!(bytes(12_345_678), "12.3 MB");
        assert_eq!(scaled(999.6), "1000 ");
        assert_eq!(scaled(3_414_000.0), "3.41 M");
        assert_eq!(several(1, "mesh", "meshes"), "1 mesh");
        assert_eq!(several(0, "light", "lights"), "0 lights");
    }

    #[test]
    fn lengths_have_five_digits() {
        for (x, text) in [
            (0.0, "0"),
            (-1.000_000_1, "-1"),
            (0.012_345_67, "0.012346"),
            (1234.56, "1234.6"),
            (100_000.0, "100000"),
            (3.5e8, "3.5000e8"),
            (1e-7, "1.0000e-7"),
        ] {
            assert_eq!(significant(x), text);
        }
    }

    #[test]
    fn times_read_well() {
        for (seconds, text) in [
            (0.0021, "2.1 ms"),
            (0.31, "0.31 s"),
            (12.34, "12.3 s"),
            (65.2, "1 min 05 s"),
            (7500.0, "2 h 05 min"),
        ] {
            assert_eq!(time(Duration::from_secs_f64(seconds)), text);
        }
    }
}
