//! The ways of scattering of layers, and how often each is drawn.

use std::ops::{Index, IndexMut};

/// One of the ways of scattering.
#[derive(Clone, Copy)]
pub(super) enum Way {
    /// Into the mirrored direction.
    Mirror,
    /// Straight through, or bent as by smooth glass.
    Window,
    /// Into the direction that a smooth coat with a normal of its own mirrors.
    CoatMirror,
    Coat,
    Sheen,
    /// By one facet of metal, gloss or the clear border, to either side.
    Facet,
    /// By several facets of metal or gloss.
    Many,
    /// By several facets of the border, to either side.
    ManyGlass,
    /// By several facets, through something thin.
    ManyThin,
    Matte,
    MatteThrough,
}

impl Way {
    /// Those into single directions first.
    const ALL: [Self; 11] = [
        Self::Mirror,
        Self::Window,
        Self::CoatMirror,
        Self::Coat,
        Self::Sheen,
        Self::Facet,
        Self::Many,
        Self::ManyGlass,
        Self::ManyThin,
        Self::Matte,
        Self::MatteThrough,
    ];
    const DELTAS: usize = 3;
}

/// A number about each way.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ways([f32; Way::ALL.len()]);

impl Index<Way> for Ways {
    type Output = f32;

    fn index(&self, way: Way) -> &f32 {
        &self.0[way as usize]
    }
}

impl IndexMut<Way> for Ways {
    fn index_mut(&mut self, way: Way) -> &mut f32 {
        &mut self.0[way as usize]
    }
}

impl Ways {
    pub(super) fn sum(&self) -> f32 {
        self.0.iter().sum()
    }

    /// The sum over the ways into single directions.
    pub(super) fn deltas(&self) -> f32 {
        self.0[..Way::DELTAS].iter().sum()
    }

    pub(super) fn scaled(&self, by: f32) -> Self {
        Self(self.0.map(|number| number * by))
    }

    /// The same without the others.
    pub(super) fn only(&self, kept: &[Way]) -> Self {
        let mut only = Self::default();
        for &way in kept {
            only[way] = self[way];
        }
        only
    }

    /// Draws one of them, which add up to 1; what is left of the choice is as good as new.
    pub(super) fn choose(&self, choice: f32) -> Option<(Way, f32)> {
        let (mut left, mut chosen) = (choice, None);
        for (way, pmf) in Way::ALL.into_iter().zip(self.0) {
            if pmf > 0.0 {
                chosen = Some((way, (left / pmf).min(1.0 - 0.5 * f32::EPSILON)));
                if left < pmf {
                    break;
                }
                left -= pmf;
            }
        }
        chosen
    }
}
