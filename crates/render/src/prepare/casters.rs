//! Balls around everything that sends light on in single directions: glass, mirrors.
//!
//! Light paths are aimed at them: what they throw on other surfaces are caustics. A ball knows
//! nothing of what is in it but how much of its light goes on; whether a path meets it is found by
//! tracing.
//!
//! Source: the cone of directions to a ball as in Pharr, Jakob, Humphreys, *Physically Based
//! Rendering*, 4th ed., section 6.2.4; weights of several by the density of all that could have
//! been chosen (Veach 1997, section 9.2.4).

use crate::math::distribution::choose;
use crate::math::warp;
use rutilant_geom::{Aabb, Frame, Sphere, Vec2, Vec3, real};
use std::f32::consts::PI;

/// Balls that hold all casters of caustics.
#[derive(Clone, Debug, Default)]
pub(crate) struct Casters(Vec<Caster>);

/// A ball around one or several of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caster {
    pub(super) ball: Sphere,
    /// How much of the light that comes to it is sent on in single directions.
    pub(super) casts: f32,
}

/// How a point of a lamp sees a ball.
struct View {
    /// What the ball fills of the directions in which the lamp shines, in sr.
    solid_angle: f32,
    /// The way to its centre, as a unit vector, and one minus the cosine of half the opening of the
    /// cone around it; `None` from within, where the ball is all around.
    cone: Option<(Vec3, f32)>,
}

/// A lamp as one of its points sees the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outlook {
    pub(crate) position: Vec3,
    /// The unit normal of the lamp, on its front.
    pub(crate) normal: Vec3,
    /// Whether its back shines as well.
    pub(crate) two_sided: bool,
}

/// How light is sent to a ball.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// Where it enters the ball; `None` for a lamp that stands in it.
    ///
    /// A ray that starts here meets what is in the ball exactly, however far away the light is.
    pub(crate) entry: Option<Vec3>,
    /// The unit vector along which it goes.
    pub(crate) direction: Vec3,
}

impl Caster {
    /// More than this are taken together.
    const MOST: usize = 16;

    /// Around what fills a box and reaches so far from its middle.
    pub(super) fn around(bounds: &Aabb, reach: f32, casts: f32) -> Self {
        /// Room for what rounding does to points on the surface, in parts of the ball's radius and
        /// of its distance from the origin.
        const ROOM: [f32; 2] = [1e-4, 1e-6];
        let center = bounds.center();
        let radius = reach * (1.0 + ROOM[0]) + center.abs().max_element() * ROOM[1];
        Self { ball: Sphere { center, radius }, casts }
    }

    /// The area of the disk as which it is seen from far away.
    fn disk(&self) -> f32 {
        PI * self.ball.radius * self.ball.radius
    }

    /// How often it is chosen, next to others, where it fills `part` of the way of light. Less than
    /// in proportion: where a floor is polished, what stands on it must not go without.
    fn weight(&self, part: f32) -> f32 {
        self.casts * part.sqrt()
    }

    /// Whether light that has come along the unit vector `direction` to `point` was in the ball, or
    /// is now.
    fn was_entered(&self, point: Vec3, direction: Vec3) -> bool {
        let Sphere { center, radius } = self.ball;
        let (way, radius2) = (point - center, radius * radius);
        let behind = way.dot(direction) > 0.0 && way.cross(direction).length_squared() <= radius2;
        behind || way.length_squared() <= radius2
    }

    /// Where light along the unit vector `direction` enters that passes the ball's centre at
    /// `aside`, which is square to it.
    fn entry(&self, aside: Vec3, direction: Vec3) -> Vec3 {
        let Sphere { center, radius } = self.ball;
        let half = (radius * radius - aside.length_squared()).max(0.0).sqrt();
        center + (aside - direction * half)
    }
}

impl Casters {
    /// Those, or fewer that hold all of them.
    pub(super) fn new(mut casters: Vec<Caster>) -> Self {
        let mut kept = Vec::new();
        if !casters.is_empty() {
            gather(&mut casters, Caster::MOST, &mut kept);
        }
        Self(kept)
    }

    /// True where there is nothing to throw light.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Aims light of a lamp at one of them, for a `choice` in [0, 1) and `u` in [0, 1)². `None`
    /// where the lamp turns its back on all of them.
    pub(crate) fn aim(&self, from: &Outlook, choice: f32, u: Vec2) -> Option<Aim> {
        let weights = || {
            self.0.iter().map(|caster| {
                let view = from.view(&caster.ball);
                let weight = caster.weight(view.solid_angle);
                ((caster, view), weight)
            })
        };
        let all: f32 = weights().map(|(_, weight)| weight).sum();
        let (caster, View { cone, .. }) = choose(weights(), choice * all)?;
        let (axis, most) = cone.unwrap_or((from.normal, if from.two_sided { 2.0 } else { 1.0 }));
        let one_minus_cos = u.x * most;
        let (cos, sin2) = (1.0 - one_minus_cos, one_minus_cos * (2.0 - one_minus_cos));
        let sin = sin2.max(0.0).sqrt();
        let (s, c) = real::sin_cos(2.0 * PI * u.y);
        let across = Frame::around(axis).to_world(Vec3::new(c, s, 0.0));
        let direction = (axis * cos + across * sin).normalize();
        let entry = cone.map(|_| {
            // By angles, which stay exact where positions do not.
            let distance = from.position.distance(caster.ball.center);
            caster.entry((across * cos - axis * sin) * (distance * sin), direction)
        });
        Some(Aim { entry, direction })
    }

    /// The density, in 1/sr, with which [`aim`](Self::aim) sends light along the unit vector
    /// `direction` so that it comes to `point`, as far as nothing is in its way.
    pub(crate) fn pdf(&self, from: &Outlook, direction: Vec3, point: Vec3) -> f32 {
        let mut sums = (0.0, 0.0);
        for caster in &self.0 {
            let View { solid_angle, cone } = from.view(&caster.ball);
            if solid_angle == 0.0 {
                continue;
            }
            let weight = caster.weight(solid_angle);
            let aimed = match cone {
                Some((axis, _)) => {
                    axis.dot(direction) > 0.0 && caster.was_entered(point, direction)
                }
                None => from.two_sided || direction.dot(from.normal) > 0.0,
            };
            sums.0 += if aimed { weight / solid_angle } else { 0.0 };
            sums.1 += weight;
        }
        if sums.0 > 0.0 { sums.0 / sums.1 } else { 0.0 }
    }

    /// Aims light that comes in straight lines from the direction `wi`, from infinitely far away,
    /// by a `choice` in [0, 1) and `u` in [0, 1)²; evenly over the disk as which a ball is seen from
    /// there. `None` where there are no balls.
    pub(crate) fn aim_from_sky(&self, wi: Vec3, choice: f32, u: Vec2) -> Option<Aim> {
        let weights = || self.0.iter().map(|c| (c, c.weight(c.disk())));
        let all: f32 = weights().map(|(_, weight)| weight).sum();
        let caster = choose(weights(), choice * all)?;
        let aside = warp::concentric_disk(u) * caster.ball.radius;
        let aside = Frame::around(wi).to_world(aside.extend(0.0));
        Some(Aim { entry: Some(caster.entry(aside, -wi)), direction: -wi })
    }

    /// The density, in 1/m² across it, with which [`aim_from_sky`](Self::aim_from_sky) sends light
    /// that comes from the unit vector `wi` so that it comes to `point`, as far as nothing is in its
    /// way.
    pub(crate) fn pdf_from_sky(&self, wi: Vec3, point: Vec3) -> f32 {
        let all: f32 = self.0.iter().map(|c| c.weight(c.disk())).sum();
        let entered = self.0.iter().filter(|c| c.was_entered(point, -wi));
        entered.map(|c| c.weight(c.disk()) / c.disk()).sum::<f32>() / all
    }
}

impl Outlook {
    fn view(&self, ball: &Sphere) -> View {
        let way = ball.center - self.position;
        let (distance2, radius2) = (way.length_squared(), ball.radius * ball.radius);
        if distance2 <= radius2 {
            let solid_angle = if self.two_sided { 4.0 * PI } else { 2.0 * PI };
            return View { solid_angle, cone: None };
        }
        let sin2 = radius2 / distance2;
        let one_minus_cos = sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt());
        let behind = !self.two_sided && self.normal.dot(way) < -ball.radius;
        View {
            solid_angle: if behind { 0.0 } else { 2.0 * PI * one_minus_cos },
            cone: Some((way / distance2.sqrt(), one_minus_cos)),
        }
    }
}

/// Takes those together that lie close, into no more than `most`.
fn gather(casters: &mut [Caster], most: usize, into: &mut Vec<Caster>) {
    if casters.len() == 1 {
        into.push(casters[0]);
        return;
    }
    let bounds = casters.iter().fold(Aabb::EMPTY, |all, c| all.union(c.ball.bounds()));
    if most == 1 {
        let reach = casters.iter().map(|c| bounds.center().distance(c.ball.center) + c.ball.radius);
        let casts = casters.iter().map(|c| c.casts).fold(0.0, f32::max);
        into.push(Caster::around(&bounds, reach.fold(0.0, f32::max), casts));
        return;
    }
    let extent = bounds.extent();
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    casters.sort_by(|a, b| a.ball.center[axis].total_cmp(&b.ball.center[axis]));
    let (low, high) = casters.split_at_mut(casters.len() / 2);
    gather(low, most / 2, into);
    gather(high, most - most / 2, into);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Independent, Sampler, Sequence};

    fn ball(x: f32, y: f32, z: f32, radius: f32) -> Caster {
        let middle = Vec3::new(x, y, z);
        Caster::around(&Aabb::around([middle]), radius, 1.0)
    }

    fn sampler(i: u64) -> Independent {
        Independent::new(&Sequence::new(1, 1), [0, 0], i)
    }

    /// Directions are drawn with the density that is said: over a grid of the sphere they come as
    /// often, for a ball far away, two that overlap, one behind, one around the lamp. Light that
    /// comes to a point in front of a ball was not aimed at it.
    #[test]
    fn directions_follow_their_density() {
        let casters = [
            vec![ball(3.0, 1.0, 0.5, 0.6)],
            vec![ball(2.0, 0.0, 1.0, 0.8), ball(2.5, 0.7, 1.0, 0.9), ball(0.0, 0.0, -4.0, 1.0)],
            vec![ball(0.3, 0.0, 0.2, 1.0), ball(-2.0, 0.3, 0.4, 0.7)],
        ];
        // So far from the lamp light comes to a surface: behind all balls, and before some.
        let reaches = [100.0, 2.0];
        let cases = casters.iter().flat_map(|c| reaches.map(|reach| (c, reach)));
        for ((casters, reach), two_sided) in cases.flat_map(|c| [(c, false), (c, true)]) {
            let casters = Casters::new(casters.clone());
            let from = Outlook { position: Vec3::ZERO, normal: Vec3::Z, two_sided };
            const CELLS: usize = 24;
            let cell = |d: Vec3| {
                let turn = (real::atan2(d.y, d.x) / PI * 0.5 + 0.5) * CELLS as f32;
                let up = (d.z * 0.5 + 0.5) * CELLS as f32;
                (up as usize).min(CELLS - 1) * CELLS + (turn as usize).min(CELLS - 1)
            };
            const SAMPLES: u64 = 1 << 18;
            let (mut drawn, mut missed) = ([0.0; CELLS * CELLS], 0);
            for sampler in (0..SAMPLES).map(sampler) {
                let Aim { entry, direction } =
                    casters.aim(&from, sampler.d1(0), sampler.d2(1)).unwrap();
                // Those blocked before they enter their ball do not count.
                if entry.is_some_and(|entry| entry.length() > reach) {
                    continue;
                }
                // By rounding, one in very many just misses.
                missed += u32::from(casters.pdf(&from, direction, direction * reach) == 0.0);
                drawn[cell(direction)] += 1.0;
            }
            assert!(missed < 10, "{missed}");
            // As many as a fine grid of directions expects.
            const FINE: usize = 40 * CELLS;
            let mut expected = [0.0; CELLS * CELLS];
            for (i, j) in (0..FINE).flat_map(|i| (0..FINE).map(move |j| (i, j))) {
                let part = |k: usize| (k as f32 + 0.5) / FINE as f32;
                let (z, (s, c)) = (2.0 * part(i) - 1.0, real::sin_cos(2.0 * PI * part(j) - PI));
                let r = (1.0 - z * z).sqrt();
                let direction = Vec3::new(r * c, r * s, z);
                let share = 4.0 * PI * SAMPLES as f32 / (FINE * FINE) as f32;
                let pdf = casters.pdf(&from, direction, direction * reach);
                expected[cell(direction)] += pdf * share;
            }
            let [all, counted] =
                [&expected, &drawn].map(|n| n.iter().sum::<f32>() / SAMPLES as f32);
            assert!((all - counted).abs() < 0.01, "{all} {counted}");
            assert!(reach < 100.0 || (all - 1.0).abs() < 0.01, "{all}");
            for (drawn, expected) in drawn.into_iter().zip(expected) {
                let noise = 5.0 * f32::sqrt(expected) + 0.02 * expected + 3.0;
                assert!((drawn - expected).abs() < noise, "{drawn} {expected}");
            }
        }
    }

    /// However far the light is, its rays enter the ball where the light sees it, in its full width,
    /// and the density there is one over its solid angle.
    #[test]
    fn light_from_far_away_meets_its_ball() {
        let (casters, center) =
            (Casters::new(vec![ball(0.3, 0.2, 0.1, 0.5)]), Vec3::new(0.3, 0.2, 0.1));
        for distance in [1.0, 1e3, 1e6, 1e9, 1e12_f32] {
            let towards = Vec3::new(0.6, 0.48, 0.64);
            let normal = -towards;
            let from = Outlook { position: center + towards * distance, normal, two_sided: false };
            let solid_angle = PI * 0.25 / (distance * distance);
            let mut mean = 0.0;
            const SAMPLES: u64 = 4096;
            for sampler in (0..SAMPLES).map(sampler) {
                for aim in [
                    casters.aim(&from, sampler.d1(0), sampler.d2(1)),
                    casters.aim_from_sky(towards, sampler.d1(0), sampler.d2(1)),
                ] {
                    let Aim { entry, direction } = aim.unwrap();
                    let way = center - entry.unwrap();
                    assert!((way.length() - 0.5).abs() < 1e-3, "{distance}: {way}");
                    assert!(way.dot(direction) > -1e-3 && (direction.length() - 1.0).abs() < 1e-6);
                    mean += way.cross(direction).length_squared() / (2 * SAMPLES) as f32;
                    let inside = entry.unwrap() + direction * way.dot(direction);
                    let pdf = casters.pdf(&from, direction, inside) * solid_angle;
                    assert!(distance < 100.0 || (pdf - 1.0).abs() < 1e-3, "{distance}: {pdf}");
                    let pdf = casters.pdf_from_sky(-direction, inside) * PI * 0.25;
                    assert!((pdf - 1.0).abs() < 1e-3, "{distance}: {pdf}");
                }
            }
            // As of an evenly lit disk: half its squared radius.
            assert!(distance < 100.0 || (mean - 0.125).abs() < 0.003, "{distance}: {mean}");
        }
    }

    /// A wide polished floor takes some of the light paths of a lamp above it, not nearly all: a
    /// glass on it keeps its own.
    #[test]
    fn a_floor_leaves_light_for_the_glass() {
        let (mut floor, glass) = (ball(0.0, 0.0, 0.0, 1000.0), ball(0.0, 0.5, 0.0, 0.5));
        floor.casts = 0.12;
        let casters = Casters::new(vec![floor, glass]);
        let (position, normal) = (Vec3::new(0.5, 4.0, 0.0), Vec3::NEG_Y);
        let from = Outlook { position, normal, two_sided: false };
        let aims = (0..4096).map(sampler).map(|s| casters.aim(&from, s.d1(0), s.d2(1)).unwrap());
        let at_glass = aims.filter(|aim| aim.entry.is_some()).count();
        assert!((1600..3600).contains(&at_glass), "{at_glass} of 4096");
    }

    /// However many there are, all are held, by no more balls than can be looked through quickly.
    #[test]
    fn many_are_taken_together() {
        let many: Vec<Caster> = (0..1000)
            .map(|i| ball((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32, 0.3))
            .collect();
        let casters = Casters::new(many.clone());
        assert_eq!(casters.0.len(), Caster::MOST);
        for Caster { ball: small, .. } in many {
            let held = |Caster { ball: large, .. }: &Caster| {
                large.center.distance(small.center) + small.radius <= large.radius * (1.0 + 1e-5)
            };
            assert!(casters.0.iter().any(held));
        }
        assert!(Casters::new(Vec::new()).is_empty());
    }
}
