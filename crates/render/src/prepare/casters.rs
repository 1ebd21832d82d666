//! Balls around everything that sends light on in single directions: glass, mirrors.
//!
//! Light paths are aimed at them: what they throw on other surfaces are caustics.

use crate::light::EmitterSelection;
use crate::math::warp;
use crate::medium::Media;
use rutilant_geom::{Aabb, Frame, Sphere, Vec2, Vec3, real};
use std::f32::consts::PI;

/// What caustics come from.
#[derive(Clone, Debug)]
pub(crate) struct Casting {
    pub(super) casters: Casters,
    pub(super) lamps: EmitterSelection,
    /// The number of the sky among the emitters, where it is one that light paths start from.
    pub(super) sky: Option<u32>,
    /// What the lamps stand in, by the number of the first of each object's: only where something
    /// absorbs.
    pub(super) media: Vec<(u32, Media)>,
    /// The largest radiance of a light.
    pub(super) brightest: f32,
}

impl Casting {
    /// What light is aimed at.
    pub(crate) fn casters(&self) -> &Casters {
        &self.casters
    }

    /// The lamps that light paths start from.
    pub(crate) fn lamps(&self) -> &EmitterSelection {
        &self.lamps
    }

    /// The number of the sky, and how often light paths start from there: as often as from all
    /// lamps together.
    pub(crate) fn sky(&self) -> Option<(usize, f32)> {
        let alone = matches!(self.lamps, EmitterSelection::None);
        Some((self.sky? as usize, if alone { 1.0 } else { 0.5 }))
    }

    /// What the light of a lamp starts in.
    pub(crate) fn media(&self, emitter: u32) -> Media {
        let after = self.media.partition_point(|(first, _)| *first <= emitter);
        after.checked_sub(1).map_or(Media::NONE, |i| self.media[i].1)
    }

    /// The largest radiance of a light.
    pub(crate) fn brightest(&self) -> f32 {
        self.brightest
    }
}

/// Balls that hold all casters of caustics.
#[derive(Clone, Debug, Default)]
pub(crate) struct Casters(Vec<Sphere>);

/// How a point of a lamp sees a ball.
enum View {
    /// As a cone around the way to its centre, of `solid_angle`, whose cosine differs from one by
    /// `one_minus_cos`.
    Cone { axis: Vec3, one_minus_cos: f32 },
    /// All around.
    Everywhere,
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

impl Casters {
    /// More balls than this are taken together.
    const MOST: usize = 16;

    /// Balls around these objects, of which each holds one.
    pub(super) fn around(mut objects: Vec<Sphere>) -> Self {
        let mut balls = Vec::new();
        if !objects.is_empty() {
            gather(&mut objects, Self::MOST, &mut balls);
        }
        Self(balls)
    }

    /// True where there is nothing to throw light.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Draws a direction towards one of them, for a `choice` in [0, 1) and `u` in [0, 1)². `None`
    /// where the lamp turns its back on all of them.
    pub(crate) fn sample(&self, from: &Outlook, choice: f32, u: Vec2) -> Option<Vec3> {
        let mut left = choice * self.weights(from).sum::<f32>();
        let mut chosen = None;
        for (ball, weight) in self.0.iter().zip(self.weights(from)) {
            if weight > 0.0 {
                chosen = Some(ball);
                if left < weight {
                    break;
                }
                left -= weight;
            }
        }
        let (axis, most) = match from.view(chosen?) {
            View::Cone { axis, one_minus_cos } => (axis, one_minus_cos),
            View::Everywhere => (from.normal, if from.two_sided { 2.0 } else { 1.0 }),
        };
        let one_minus_cos = u.x * most;
        let sin = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
        let (s, c) = real::sin_cos(2.0 * PI * u.y);
        let local = Vec3::new(sin * c, sin * s, 1.0 - one_minus_cos);
        Some(Frame::around(axis).to_world(local).normalize())
    }

    /// The density, in 1/sr, with which [`sample`](Self::sample) draws the unit vector `direction`.
    pub(crate) fn pdf(&self, from: &Outlook, direction: Vec3) -> f32 {
        // Within a ball's solid angle the density is one over it, and so often it is chosen.
        let hit = self.0.iter().zip(self.weights(from)).filter(|(ball, weight)| {
            let towards = match from.view(ball) {
                View::Everywhere => from.two_sided || direction.dot(from.normal) > 0.0,
                View::Cone { .. } => {
                    let way = ball.center - from.position;
                    let past = way.cross(direction).length_squared();
                    way.dot(direction) > 0.0 && past <= ball.radius * ball.radius
                }
            };
            *weight > 0.0 && towards
        });
        let hits = hit.count();
        if hits == 0 { 0.0 } else { hits as f32 / self.weights(from).sum::<f32>() }
    }

    /// Draws a point in the way of light that comes along straight lines from the direction `wi`, by
    /// a `choice` in [0, 1) and `u` in [0, 1)²; evenly over the disks as which a ball is seen from
    /// there.
    pub(crate) fn sample_disk(&self, wi: Vec3, choice: f32, u: Vec2) -> Vec3 {
        let mut left = choice * self.disks();
        let mut chosen = self.0[0];
        for &ball in &self.0 {
            chosen = ball;
            let disk = PI * ball.radius * ball.radius;
            if left < disk {
                break;
            }
            left -= disk;
        }
        let at = warp::concentric_disk(u) * chosen.radius;
        chosen.center + Frame::around(wi).to_world(at.extend(0.0))
    }

    /// The density, in 1/m² across it, with which [`sample_disk`](Self::sample_disk) draws the
    /// straight line through `point` along the unit vector `wi`.
    pub(crate) fn pdf_disk(&self, wi: Vec3, point: Vec3) -> f32 {
        let hit =
            |b: &&Sphere| (b.center - point).cross(wi).length_squared() <= b.radius * b.radius;
        self.0.iter().filter(hit).count() as f32 / self.disks()
    }

    /// The area of all disks as which a ball is seen from far away.
    fn disks(&self) -> f32 {
        self.0.iter().map(|ball| PI * ball.radius * ball.radius).sum()
    }

    /// The solid angles that the balls fill as they are drawn from; 0 behind the lamp.
    fn weights(&self, from: &Outlook) -> impl Iterator<Item = f32> {
        self.0.iter().map(|ball| {
            let height = from.normal.dot(ball.center - from.position);
            match from.view(ball) {
                View::Everywhere if from.two_sided => 4.0 * PI,
                View::Everywhere => 2.0 * PI,
                View::Cone { .. } if !from.two_sided && height < -ball.radius => 0.0,
                View::Cone { one_minus_cos, .. } => 2.0 * PI * one_minus_cos,
            }
        })
    }
}

impl Outlook {
    fn view(&self, ball: &Sphere) -> View {
        let way = ball.center - self.position;
        let (distance2, radius2) = (way.length_squared(), ball.radius * ball.radius);
        if distance2 <= radius2 {
            return View::Everywhere;
        }
        let sin2 = radius2 / distance2;
        let cos = (1.0 - sin2).max(0.0).sqrt();
        View::Cone { axis: way / distance2.sqrt(), one_minus_cos: sin2 / (1.0 + cos) }
    }
}

/// The ball about the middle of a box that reaches as far as what is in it.
pub(super) fn ball_around(bounds: &Aabb, reach: f32) -> Sphere {
    /// Room for what rounding does to points on the ball's surface.
    const ROOM: f32 = 1.0 + 1e-4;
    Sphere { center: bounds.center(), radius: reach * ROOM }
}

/// Takes balls together where they lie close, into no more than `most`.
fn gather(balls: &mut [Sphere], most: usize, into: &mut Vec<Sphere>) {
    if balls.len() == 1 {
        into.push(balls[0]);
        return;
    }
    let bounds = balls.iter().fold(Aabb::EMPTY, |all, ball| all.union(ball.bounds()));
    if most == 1 {
        let center = bounds.center();
        let reach = balls.iter().map(|b| center.distance(b.center) + b.radius);
        into.push(ball_around(&bounds, reach.fold(0.0, f32::max)));
        return;
    }
    let extent = bounds.extent();
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    balls.sort_by(|a, b| a.center[axis].total_cmp(&b.center[axis]));
    let (low, high) = balls.split_at_mut(balls.len() / 2);
    gather(low, most / 2, into);
    gather(high, most - most / 2, into);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Independent, Sampler, Sequence};

    fn ball(x: f32, y: f32, z: f32, radius: f32) -> Sphere {
        Sphere { center: Vec3::new(x, y, z), radius }
    }

    /// Directions that are drawn have the density that is said: over a grid of the sphere they
    /// come as often, for a ball far away, two that overlap, one behind, one around the lamp.
    #[test]
    fn directions_follow_their_density() {
        let casters = [
            vec![ball(3.0, 1.0, 0.5, 0.6)],
            vec![ball(2.0, 0.0, 1.0, 0.8), ball(2.5, 0.7, 1.0, 0.9), ball(0.0, 0.0, -4.0, 1.0)],
            vec![ball(0.3, 0.0, 0.2, 1.0), ball(-2.0, 0.3, 0.4, 0.7)],
        ];
        for casters in casters {
            for two_sided in [false, true] {
                let casters = Casters::around(casters.clone());
                let from = Outlook { position: Vec3::ZERO, normal: Vec3::Z, two_sided };
                const CELLS: usize = 24;
                let cell = |d: Vec3| {
                    let turn = (real::atan2(d.y, d.x) / PI * 0.5 + 0.5) * CELLS as f32;
                    let up = (d.z * 0.5 + 0.5) * CELLS as f32;
                    (up as usize).min(CELLS - 1) * CELLS + (turn as usize).min(CELLS - 1)
                };
                const SAMPLES: u64 = 1 << 18;
                let mut drawn = [0.0; CELLS * CELLS];
                for i in 0..SAMPLES {
                    let sampler = Independent::new(&Sequence::new(1, 1), [0, 0], i);
                    let direction = casters.sample(&from, sampler.d1(0), sampler.d2(1)).unwrap();
                    assert!(casters.pdf(&from, direction) > 0.0, "{direction}");
                    drawn[cell(direction)] += 1.0;
                }
                // As many as a fine grid of directions expects.
                const FINE: usize = 40 * CELLS;
                let mut expected = [0.0; CELLS * CELLS];
                for (i, j) in (0..FINE).flat_map(|i| (0..FINE).map(move |j| (i, j))) {
                    let part = |k: usize| (k as f32 + 0.5) / FINE as f32;
                    let (z, (s, c)) = (2.0 * part(i) - 1.0, real::sin_cos(2.0 * PI * part(j) - PI));
                    let r = (1.0 - z * z).sqrt();
                    let direction = Vec3::new(r * c, r * s, z);
                    let share = 4.0 * PI * SAMPLES as f32 / (FINE * FINE) as f32;
                    expected[cell(direction)] += casters.pdf(&from, direction) * share;
                }
                let all = expected.iter().sum::<f32>() / SAMPLES as f32;
                assert!((all - 1.0).abs() < 0.01, "{all}");
                for (drawn, expected) in drawn.into_iter().zip(expected) {
                    let noise = 5.0 * f32::sqrt(expected) + 0.02 * expected + 3.0;
                    assert!((drawn - expected).abs() < noise, "{drawn} {expected}");
                }
            }
        }
    }

    /// However many there are, all are held, by no more balls than can be looked through quickly.
    #[test]
    fn many_are_taken_together() {
        let many: Vec<Sphere> = (0..1000)
            .map(|i| ball((i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32, 0.3))
            .collect();
        let casters = Casters::around(many.clone());
        assert_eq!(casters.0.len(), Casters::MOST);
        for small in many {
            let held = |large: &Sphere| {
                large.center.distance(small.center) + small.radius <= large.radius * (1.0 + 1e-5)
            };
            assert!(casters.0.iter().any(held));
        }
        assert!(Casters::around(Vec::new()).is_empty());
    }
}
