//! What a ray is inside of, where media overlap: the one with the highest priority fills the place.
//!
//! Ice in water in a glass is modelled as closed bodies, each with one index of
//! refraction, that overlap a little. A path keeps a list of the media it is
//! inside. Only where the strongest of them changes is there a border, with the
//! indices of the two strongest on its sides; at every other surface there is
//! nothing, and the ray goes straight on. No pair of indices has to be declared,
//! so none can be wrong.
//!
//! Surfaces without a priority take no part: they declare the indices on both
//! sides. What is around them absorbs as it did before they were entered.
//! Bodies must be closed; one that is left without having been entered is taken
//! to have been entered unseen. Surfaces nearer to each other than a ray's origin
//! is moved off them count as one, so bodies may touch as well as overlap.
//!
//! Source: Schmidt and Budge, "Simple Nested Dielectrics in Ray Traced Images",
//! JGT 7(2), 2002.

use crate::color::Spectrum;
use crate::dispersion::index;

/// A clear medium as it meets light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PreparedMedium {
    /// Index of refraction.
    pub(crate) ior: f32,
    /// How much that changes with the wavelength: 20 over the Abbe number.
    pub(crate) dispersion: f32,
    /// What it absorbs, in 1/m.
    pub(crate) absorption: Spectrum,
}

impl PreparedMedium {
    /// The index of refraction for light of this wavelength in nanometres.
    fn ior_at(&self, wavelength_nm: f32) -> f32 {
        if self.dispersion == 0.0 {
            return self.ior;
        }
        index(self.ior, self.dispersion, wavelength_nm)
    }

    /// Whether it bends all light as that other one does.
    pub(crate) fn bends_like(&self, other: &Self) -> bool {
        self.ior == other.ior && self.dispersion == other.dispersion
    }
}

/// What fills the space on both sides of a clear surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Border {
    /// Behind the surface, where its normals point away from.
    pub(crate) interior: PreparedMedium,
    /// In front of it; for a medium with a priority where no other is.
    pub(crate) exterior: PreparedMedium,
    /// The number of the material.
    pub(crate) material: u32,
    /// The number of the interior in the table of media with a priority: the smaller the stronger.
    pub(crate) rank: Option<u32>,
}

impl Border {
    /// Whether it bends light of each wavelength differently.
    pub(crate) fn disperses(&self) -> bool {
        self.interior.dispersion > 0.0 || self.exterior.dispersion > 0.0
    }

    /// The index of refraction behind it over that in front, for light of this wavelength in
    /// nanometres.
    pub(crate) fn eta_at(&self, wavelength_nm: f32) -> f32 {
        self.interior.ior_at(wavelength_nm) / self.exterior.ior_at(wavelength_nm)
    }

    /// The absorption in front of the surface, or behind it.
    pub(crate) fn absorption(&self, in_front: bool) -> Spectrum {
        if in_front { self.exterior.absorption } else { self.interior.absorption }
    }
}

/// What a ray is inside of, and what it goes through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Media {
    /// What the medium around the ray absorbs, in 1/m.
    pub(crate) absorption: Spectrum,
    /// The number of the band of the spectrum that the path is left with, where it met something
    /// that bends them differently.
    pub(crate) band: Option<u8>,
    /// The media with a priority that the ray is inside of, the strongest first.
    inside: [Inside; Self::MOST],
    /// How many of these there are.
    count: usize,
    /// How many bodies dropped out of the list, for want of room, and were not left since.
    dropped: u32,
    /// The materials without a priority that the ray went into by their fronts and has not left,
    /// the latest last, and what absorbed around them.
    around: [(u32, Spectrum); Self::MOST_DECLARED],
    /// How many of these there are.
    declared: usize,
}

/// A medium that a ray is inside of.
#[derive(Clone, Copy, Debug)]
struct Inside {
    rank: u32,
    /// How many bodies of it.
    times: u32,
}

impl Media {
    /// So many media with a priority can overlap at one point; of more, the weakest are overlooked:
    /// their bodies are passed straight through on the way out as well, so that no light is made.
    pub(crate) const MOST: usize = 8;

    /// So many media without a priority can lie in each other; of more, the outermost are forgotten.
    const MOST_DECLARED: usize = 4;

    /// Inside of nothing.
    pub(crate) const NONE: Self = Self {
        absorption: Spectrum::BLACK,
        band: None,
        inside: [Inside { rank: 0, times: 0 }; Self::MOST],
        count: 0,
        dropped: 0,
        around: [(0, Spectrum::BLACK); Self::MOST_DECLARED],
        declared: 0,
    };

    /// Goes on into what there is beyond a border, with the colour that the path has.
    pub(crate) fn go_on(&mut self, beyond: &Self) {
        *self = Self { band: self.band, ..*beyond };
    }

    /// Notes that the ray has come to a border without a priority. It knows what is behind it, and
    /// what is in front of it if it says that something absorbs there.
    #[inline(always)]
    pub(crate) fn arrive_declared(&mut self, border: &Border, from_front: bool) {
        let known = border.absorption(from_front);
        if !(from_front && known.is_black()) {
            self.absorption = known;
        }
    }

    /// Goes through a border without a priority.
    pub(crate) fn pass_declared(&mut self, border: &Border, from_front: bool) {
        let beyond = self.beyond_declared(border, from_front);
        if from_front {
            if self.declared == Self::MOST_DECLARED {
                self.around.copy_within(1.., 0);
                self.declared -= 1;
            }
            self.around[self.declared] = (border.material, self.absorption);
            self.declared += 1;
        } else if let Some(entered) = self.entered(border) {
            self.declared = entered;
        }
        self.absorption = beyond;
    }

    /// What absorbs behind a border without a priority, or in front of it: there what did so when
    /// it was entered, unless the border knows better.
    pub(crate) fn beyond_declared(&self, border: &Border, from_front: bool) -> Spectrum {
        let known = border.absorption(!from_front);
        if from_front || !known.is_black() {
            return known;
        }
        self.entered(border).map_or(known, |entered| self.around[entered].1)
    }

    /// Where in the list it stands that the ray went into this border's material. Bodies whose
    /// sides are of several materials are entered by one and left by another.
    fn entered(&self, border: &Border) -> Option<usize> {
        self.around[..self.declared].iter().rposition(|(m, _)| *m == border.material)
    }

    /// Notes that the ray has come to `border`, of this rank, and gives it as it is here, with the
    /// strongest media on both sides, and what the ray is inside of if it goes on beyond. Where
    /// both sides have the same index there is no border.
    ///
    /// `also` passes the surfaces at the very same place; `table` has the media by rank.
    pub(crate) fn arrive(
        &mut self,
        border: &Border,
        rank: u32,
        from_front: bool,
        also: impl FnOnce(&mut Self),
        table: &[PreparedMedium],
    ) -> (Border, Self) {
        let known = self.inside[..self.count].iter().any(|i| i.rank == rank);
        if !from_front && !known && self.dropped == 0 {
            self.enter(rank);
        }
        let mut beyond = *self;
        beyond.pass(rank, from_front);
        also(&mut beyond);
        let near = self.fill(&border.exterior, table);
        let far = beyond.fill(&border.exterior, table);
        let (exterior, interior) = if from_front { (near, far) } else { (far, near) };
        (Border { interior, exterior, ..*border }, beyond)
    }

    /// Finds what fills the place: the strongest medium, and `outside` where there is none.
    pub(crate) fn fill(
        &mut self,
        outside: &PreparedMedium,
        table: &[PreparedMedium],
    ) -> PreparedMedium {
        let strongest = self.inside[..self.count].first();
        let medium = strongest.map_or(*outside, |i| table[i.rank as usize]);
        self.absorption = medium.absorption;
        medium
    }

    /// Goes into a body of this medium by its front, or out of one.
    pub(crate) fn pass(&mut self, rank: u32, from_front: bool) {
        if from_front {
            self.enter(rank);
        } else {
            self.leave(rank);
        }
    }

    /// Notes one body more of this medium.
    fn enter(&mut self, rank: u32) {
        let at = self.inside[..self.count].partition_point(|i| i.rank < rank);
        match self.inside[..self.count].get_mut(at) {
            Some(known) if known.rank == rank => known.times = known.times.saturating_add(1),
            _ if at < Self::MOST => {
                // Room is made; the weakest of too many drops out.
                if self.count == Self::MOST {
                    self.dropped = self.dropped.saturating_add(self.inside[self.count - 1].times);
                }
                self.count = (self.count + 1).min(Self::MOST);
                self.inside.copy_within(at..self.count - 1, at + 1);
                self.inside[at] = Inside { rank, times: 1 };
            }
            _ => self.dropped = self.dropped.saturating_add(1),
        }
    }

    /// Notes one body less; one that was never entered changes nothing.
    fn leave(&mut self, rank: u32) {
        let Some(at) = self.inside[..self.count].iter().position(|i| i.rank == rank) else {
            self.dropped = self.dropped.saturating_sub(1);
            return;
        };
        self.inside[at].times -= 1;
        if self.inside[at].times == 0 {
            self.inside.copy_within(at + 1..self.count, at);
            self.count -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Media told apart by their indices: 2 for the strongest, 3 for the next.
    fn medium(ior: f32) -> PreparedMedium {
        PreparedMedium { ior, dispersion: 0.0, absorption: Spectrum::splat(ior) }
    }

    /// The indices in front and behind, after passing through.
    fn through(media: &mut Media, rank: u32, entering: bool) -> [f32; 2] {
        let table: Vec<_> = (0..99).map(|rank| medium(2.0 + rank as f32)).collect();
        let border = Border {
            interior: table[rank as usize],
            exterior: medium(1.0),
            material: 0,
            rank: Some(rank),
        };
        let (here, beyond) = media.arrive(&border, rank, entering, |_| {}, &table);
        *media = beyond;
        let around =
            media.inside[..media.count].first().map_or(1.0, |i| table[i.rank as usize].ior);
        assert_eq!(media.absorption, Spectrum::splat(around), "rank {rank}");
        [here.exterior.ior, here.interior.ior]
    }

    /// Into weak water, on into strong glass, out of the water while in glass, out of the glass:
    /// at each surface the strongest on both sides meet, and equal ones are no border.
    #[test]
    fn the_strongest_media_meet_at_a_border() {
        let mut none = Media::NONE;
        let media = &mut none;
        assert_eq!(through(media, 1, true), [1.0, 3.0]);
        assert_eq!(through(media, 0, true), [3.0, 2.0]);
        assert_eq!(through(media, 1, false), [2.0, 2.0]);
        assert_eq!(through(media, 0, false), [1.0, 2.0]);
        // Two bodies of one medium are one.
        assert_eq!(through(media, 1, true), [1.0, 3.0]);
        assert_eq!(through(media, 1, true), [3.0, 3.0]);
        assert_eq!(through(media, 1, false), [3.0, 3.0]);
        assert_eq!(through(media, 1, false), [1.0, 3.0]);
    }

    /// Out of glass and into the water that touches it, at one place: glass meets water there,
    /// and two bodies of one medium do not meet at all.
    #[test]
    fn bodies_that_touch_meet_each_other() {
        let table: Vec<_> = (0..2).map(|rank| medium(2.0 + rank as f32)).collect();
        let border =
            Border { interior: table[0], exterior: medium(1.0), material: 0, rank: Some(0) };
        for (other, expected) in [(1, 3.0), (0, 2.0)] {
            let mut media = Media::NONE;
            media.enter(0);
            let (here, beyond) = media.arrive(&border, 0, false, |m| m.pass(other, true), &table);
            assert_eq!([here.interior.ior, here.exterior.ior], [2.0, expected]);
            assert_eq!(beyond.absorption, Spectrum::splat(expected));
        }
    }

    /// What is left without having been entered is believed to have been around; nothing is left
    /// over.
    #[test]
    fn leaving_what_was_never_entered_is_believed() {
        let mut none = Media::NONE;
        let media = &mut none;
        assert_eq!(through(media, 3, false), [1.0, 5.0]);
        assert_eq!(media.count, 0);
        through(media, 4, true);
        assert_eq!(through(media, 3, false), [6.0, 5.0]);
        assert_eq!(through(media, 4, false), [1.0, 6.0]);
        assert_eq!(media.count, 0);
    }

    /// Against a list without limits and without order: random entering and leaving of few
    /// enough media at once gives the same neighbours, and of too many it forgets only weak ones.
    #[test]
    fn lists_of_any_length_keep_the_strongest() {
        for most in [Media::MOST as u32, 3 * Media::MOST as u32] {
            let (mut media, mut truth) = (Media::NONE, Vec::<u32>::new());
            let mut state = 12345_u32;
            for step in 0..20_000 {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let rank = (state >> 16) % most;
                let entering = state >> 31 == 0;
                let strongest = |list: &[u32]| list.iter().min().map_or(1.0, |r| 2.0 + *r as f32);
                let before = strongest(&truth);
                if entering {
                    truth.push(rank);
                } else if let Some(at) = truth.iter().position(|r| *r == rank) {
                    truth.swap_remove(at);
                } else {
                    continue;
                }
                let beyond = strongest(&truth);
                let [front, back] = through(&mut media, rank, entering);
                if most as usize == Media::MOST {
                    let expected = if entering { [before, beyond] } else { [beyond, before] };
                    assert_eq!([front, back], expected, "step {step}");
                }
                assert!(media.count <= Media::MOST);
                assert!(media.inside[..media.count].windows(2).all(|w| w[0].rank < w[1].rank));
            }
        }
    }
}
