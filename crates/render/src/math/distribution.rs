//! Step functions to draw from, in one and two dimensions.
//!
//! Source: Pharr, Jakob, Humphreys, *Physically Based Rendering*, 4th ed.,
//! sections A.4.7 and A.5.6.

use rutilant_geom::Vec2;

/// The first of some choices whose weight, after those of all before it, exceeds `left`; the last
/// one that weighs anything where rounding leaves none. For choices that are too few, or differ too
/// often, for a table.
pub(crate) fn choose<T>(choices: impl Iterator<Item = (T, f32)>, mut left: f32) -> Option<T> {
    let mut chosen = None;
    for (choice, weight) in choices.filter(|(_, weight)| *weight > 0.0) {
        chosen = Some(choice);
        if left < weight {
            break;
        }
        left -= weight;
    }
    chosen
}

/// A density over [0, 1) with equal steps.
#[derive(Clone, Debug)]
pub struct Distribution1d {
    /// The share of all that lies before each step's end. The last is 1.
    cumulative: Vec<f32>,
}

impl Distribution1d {
    /// From one value a step, finite and not negative. `None` when there are no values or their sum is 0.
    ///
    /// A step that holds next to nothing is raised to a share of 2⁻¹⁸ (less for very many steps):
    /// numbers in [0, 1) are too coarse to draw it any more rarely, and it must not be lost.
    pub fn new(values: impl ExactSizeIterator<Item = f64> + Clone) -> Option<Self> {
        let total: f64 = values.clone().sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let least = total * (0.1 / values.len() as f64).min(1.0 / f64::from(1 << 18));
        let values = values.map(|v| if v > 0.0 { v.max(least) } else { 0.0 });
        let total: f64 = values.clone().sum();
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = values
            .map(|value| {
                sum += value;
                (sum / total) as f32
            })
            .collect();
        // Rounding may leave the end short of 1; the steps there that hold nothing stay empty.
        let last = cumulative.last().copied()?;
        for c in cumulative.iter_mut().rev().take_while(|c| **c == last) {
            *c = 1.0;
        }
        Some(Self { cumulative })
    }

    /// Number of steps.
    pub fn len(&self) -> usize {
        self.cumulative.len()
    }

    /// Never: a distribution has at least one step.
    pub fn is_empty(&self) -> bool {
        self.cumulative.is_empty()
    }

    /// The probability of a step.
    pub fn pmf(&self, step: usize) -> f32 {
        self.cumulative[step] - self.start(step)
    }

    /// A step for `u` in [0, 1), and how far into it `u` lies, in [0, 1).
    pub fn sample_step(&self, u: f32) -> (usize, f32) {
        let step = self.cumulative.partition_point(|&c| c <= u).min(self.len() - 1);
        let within = (u - self.start(step)) / self.pmf(step);
        (step, within.clamp(0.0, 1.0 - 0.5 * f32::EPSILON))
    }

    fn start(&self, step: usize) -> f32 {
        if step == 0 { 0.0 } else { self.cumulative[step - 1] }
    }
}

/// A density over the unit square with equal cells.
#[derive(Clone, Debug)]
pub struct Distribution2d {
    rows: Distribution1d,
    /// One for each row; a row that is never drawn has none.
    columns: Vec<Option<Distribution1d>>,
}

impl Distribution2d {
    /// From (`height`, `width`) values, finite and not negative. `None` when their sum is 0.
    pub fn new(width: usize, values: &[f64]) -> Option<Self> {
        let rows: Vec<f64> = values.chunks_exact(width).map(|row| row.iter().sum()).collect();
        Some(Self {
            rows: Distribution1d::new(rows.iter().copied())?,
            columns: values
                .chunks_exact(width)
                .map(|row| Distribution1d::new(row.iter().copied()))
                .collect(),
        })
    }

    /// A cell for `u` in [0, 1)², as column and row; how far into it `u` lies, in [0, 1)²; and the
    /// density there, over the unit square.
    pub fn sample(&self, u: Vec2) -> Option<([usize; 2], Vec2, f32)> {
        let (row, y) = self.rows.sample_step(u.y);
        let (column, x) = self.columns[row].as_ref()?.sample_step(u.x);
        Some(([column, row], Vec2::new(x, y), self.density([column, row])))
    }

    /// The density in a cell, over the unit square.
    pub fn density(&self, [column, row]: [usize; 2]) -> f32 {
        let Some(columns) = &self.columns[row] else { return 0.0 };
        let cells = columns.len() as f32 * self.columns.len() as f32;
        self.rows.pmf(row) * columns.pmf(column) * cells
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps are drawn as often as they weigh, and empty ones never, at either end of [0, 1) too.
    #[test]
    fn empty_steps_are_never_drawn() {
        let d = Distribution1d::new([0.0, 1.0, 0.0, 3.0, 0.0].into_iter()).unwrap();
        let mut counts = [0; 5];
        let n = 1 << 16;
        for i in 0..n {
            let (step, within) = d.sample_step(i as f32 / n as f32);
            assert!((0.0..1.0).contains(&within));
            counts[step] += 1;
        }
        assert_eq!(counts, [0, n / 4, 0, 3 * n / 4, 0]);
        assert_eq!(d.sample_step(1.0 - 0.5 * f32::EPSILON).0, 3);
        assert!(Distribution1d::new([0.0; 3].into_iter()).is_none());
        assert!(Distribution1d::new([].into_iter()).is_none());
    }

    /// Next to a sun everything else is dim, but none of it is never drawn.
    #[test]
    fn dim_steps_are_never_lost() {
        for len in [4, 1000, 100_000] {
            let sun = len / 2;
            let values = (0..len).map(|i| if i == sun { 1e12 } else { 1.0 });
            let d = Distribution1d::new(values).unwrap();
            assert!((0..len).all(|i| d.pmf(i) > 0.0), "{len}");
            assert!(d.pmf(sun) > 0.85, "{len}: {}", d.pmf(sun));
        }
    }

    /// The returned density is that of the cell, and it integrates to 1.
    #[test]
    fn densities_agree_and_add_to_one() {
        let values = [1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 4.0, 1.0, 0.5];
        let d = Distribution2d::new(3, &values).unwrap();
        let n = 64;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32;
            let (cell, within, pdf) = d.sample(u).unwrap();
            assert_eq!(pdf, d.density(cell));
            assert!(pdf > 0.0);
            assert!(within.cmpge(Vec2::ZERO).all() && within.cmplt(Vec2::ONE).all());
        }
        let cells = (0..9).map(|i| d.density([i % 3, i / 3]) / 9.0);
        assert!((cells.sum::<f32>() - 1.0).abs() < 1e-6);
    }
}
