//! What somebody may have meant.

/// Longer names get no suggestion: the search takes time in proportion to their product.
const LONGEST: usize = 64;

/// The candidate nearest to `name`, if it is so near that a slip of the fingers explains it:
/// at most one letter in three inserted, left out, exchanged or swapped with its neighbour.
/// The first of several equally near ones.
pub(super) fn nearest<'c>(
    name: &str,
    candidates: impl IntoIterator<Item = &'c str>,
) -> Option<&'c str> {
    if name.len() > LONGEST {
        return None;
    }
    let name: Vec<char> = name.to_lowercase().chars().collect();
    let most = (name.len() / 3).max(1).min(name.len().saturating_sub(1));
    candidates
        .into_iter()
        .filter(|candidate| candidate.len() <= LONGEST)
        .map(|candidate| {
            (distance(&name, &candidate.to_lowercase().chars().collect::<Vec<_>>()), candidate)
        })
        .filter(|(d, _)| *d <= most)
        .min_by_key(|(d, _)| *d)
        .map(|(_, candidate)| candidate)
}

/// How many slips lead from `a` to `b`: the optimal string alignment distance.
fn distance(a: &[char], b: &[char]) -> usize {
    let first: Vec<usize> = (0..=b.len()).collect();
    // Three rows of the table: for one letter of `a` less, for this one, and for two less.
    let (mut previous, mut before) = (first.clone(), first);
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let exchange = previous[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = exchange.min(previous[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut previous, row);
    }
    previous[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slips(a: &str, b: &str) -> usize {
        distance(&a.chars().collect::<Vec<_>>(), &b.chars().collect::<Vec<_>>())
    }

    /// Each kind of slip counts once, and the order of the words does not matter.
    #[test]
    fn distances_count_slips() {
        for (a, b, count) in [
            ("", "", 0),
            ("", "abc", 3),
            ("albedo", "albedo", 0),
            ("albdo", "albedo", 1),
            ("albeddo", "albedo", 1),
            ("albado", "albedo", 1),
            ("labedo", "albedo", 1),
            ("kitten", "sitting", 3),
        ] {
            assert_eq!(slips(a, b), count, "{a} {b}");
            assert_eq!(slips(b, a), count, "{b} {a}");
        }
    }

    /// A hint must help: nothing is better than something far away.
    #[test]
    fn only_near_names_are_suggested() {
        let keys = ["position", "look_at", "up", "k"];
        assert_eq!(nearest("positon", keys), Some("position"));
        assert_eq!(nearest("Look_At", keys), Some("look_at"));
        assert_eq!(nearest("lookat", keys), Some("look_at"));
        for far in ["", "x", "temperature", &"a".repeat(100_000)] {
            assert_eq!(nearest(far, keys), None);
        }
    }
}
