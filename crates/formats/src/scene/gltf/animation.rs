//! Animations: values of nodes as functions of time.
//!
//! Between two keyframes a value stands still, goes on a straight line (for
//! rotations: on the shortest great circle) or on a cubic curve. Before the
//! first and after the last it stays what it is there.
//!
//! Source: Khronos Group, *glTF 2.0 Specification*, 2021, section 3.11 and
//! appendix C.

use super::accessor::Accessors;
use super::entry::{Entry, Result};
use super::mesh::Mesh;
use super::node::{Node, Placement};
use rutilant_geom::real;
use std::collections::HashSet;
use std::sync::Arc;

/// What of a node changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// Its translation.
    Translation,
    /// Its rotation.
    Rotation,
    /// Its scale.
    Scale,
    /// The weights of its mesh's morph targets.
    Weights,
}

/// How a value goes from keyframe to keyframe.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Straight.
    Linear,
    /// In steps.
    Step,
    /// On a cubic Hermite spline: each keyframe has the slope before it, its value, and the
    /// slope after it.
    Cubic,
}

/// One value of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Whose.
    pub node: usize,
    /// Which.
    pub target: Target,
    /// How it goes on.
    pub interpolation: Interpolation,
    /// Seconds of the keyframes: one at least, finite, each more than the one before.
    pub times: Arc<Vec<f32>>,
    /// Numbers of all keyframes, finite: `width` each, or three times as many for cubic ones.
    pub values: Arc<Vec<f32>>,
    /// Numbers of one value.
    pub width: usize,
}

/// Values that change together.
#[derive(Clone, Debug, PartialEq)]
pub struct Animation {
    /// What the author calls it; may be empty.
    pub name: String,
    /// No two change the same value of the same node.
    pub channels: Vec<Channel>,
}

impl Animation {
    /// Seconds of its first and its last keyframe; `None` where it has none.
    pub fn span(&self) -> Option<[f32; 2]> {
        let ends = self.channels.iter().filter_map(|c| Some([*c.times.first()?, *c.times.last()?]));
        ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }
}

impl Channel {
    /// Its value at a time in seconds, `width` numbers. Rotations may have any length but zero.
    pub fn at(&self, seconds: f32) -> Vec<f32> {
        let next = self.times.partition_point(|&time| time <= seconds);
        let last = self.times.len().saturating_sub(1);
        let (from, to) = (next.saturating_sub(1), next.min(last));
        let (start, end) = (self.value(from, 1), self.value(to, 1));
        if from == to || next == 0 {
            return (if next == 0 { self.value(0, 1) } else { start }).to_vec();
        }
        let span = f64::from(self.times[to]) - f64::from(self.times[from]);
        let t = (f64::from(seconds) - f64::from(self.times[from])) / span;
        match (self.interpolation, self.target) {
            (Interpolation::Step, _) => start.to_vec(),
            (Interpolation::Linear, Target::Rotation) => great_circle(start, end, t as f32),
            (Interpolation::Linear, _) => {
                let mix =
                    |(a, b): (&f32, &f32)| ((1.0 - t) * f64::from(*a) + t * f64::from(*b)) as f32;
                start.iter().zip(end).map(mix).collect()
            }
            (Interpolation::Cubic, _) => {
                // Appendix C.5.
                let (t2, t3) = (t * t, t * t * t);
                let weights = [
                    2.0 * t3 - 3.0 * t2 + 1.0,
                    span * (t3 - 2.0 * t2 + t),
                    -2.0 * t3 + 3.0 * t2,
                    span * (t3 - t2),
                ];
                let parts = [start, self.value(from, 2), end, self.value(to, 0)];
                let sum = |i: usize| {
                    let terms = weights.iter().zip(&parts);
                    let term = |(w, part): (&f64, &&[f32])| {
                        w * f64::from(part.get(i).copied().unwrap_or(0.0))
                    };
                    terms.map(term).sum::<f64>() as f32
                };
                (0..start.len()).map(sum).collect()
            }
        }
    }

    /// Of a keyframe: its value (1), or the slope before (0) or after (2) it.
    fn value(&self, keyframe: usize, part: usize) -> &[f32] {
        let place = match self.interpolation {
            Interpolation::Linear | Interpolation::Step => keyframe,
            Interpolation::Cubic => 3 * keyframe + part,
        };
        let start = place * self.width;
        self.values.get(start..start + self.width).unwrap_or_default()
    }
}

/// The shortest way from one rotation to another, at equal speed: Shoemake, *Animating Rotation
/// with Quaternion Curves*, 1985, and appendix C.4.
fn great_circle(from: &[f32], to: &[f32], t: f32) -> Vec<f32> {
    let unit = |q: &[f32]| {
        let length = q.iter().map(|x| x * x).sum::<f32>().sqrt();
        q.iter().map(|x| x / length).collect::<Vec<f32>>()
    };
    let (from, to) = (unit(from), unit(to));
    let dot: f32 = from.iter().zip(&to).map(|(a, b)| a * b).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    // The angle by sum and difference is exact where its cosine is not: Kahan, *How Futile are
    // Mindless Assessments of Roundoff*, 2006, section 12.
    let length = |other: f32| {
        let squares = from.iter().zip(&to).map(|(a, b)| (a + other * b) * (a + other * b));
        squares.sum::<f32>().sqrt()
    };
    let angle = 2.0 * real::atan2(length(-sign), length(sign));
    let sine = real::sin(angle);
    // So near to each other a line is a circle, within single precision.
    let [a, b] = if sine < 1e-3 {
        [1.0 - t, t]
    } else {
        [real::sin(angle * (1.0 - t)) / sine, real::sin(angle * t) / sine]
    };
    from.iter().zip(&to).map(|(p, q)| a * p + sign * b * q).collect()
}

/// What has been found right already, by accessor.
#[derive(Default)]
struct Checked {
    times: HashSet<usize>,
    values: HashSet<usize>,
}

/// The animations of a document.
pub(super) fn animations(
    root: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    nodes: &[Node],
    meshes: &[Mesh],
) -> Result<Vec<Animation>> {
    let mut checked = Checked::default();
    root.each("animations", |entry| {
        let list = entry.need("samplers")?;
        let samplers = list.items()?.map(|item| sampler(&item, accessors, &mut checked));
        let samplers = samplers.collect::<Result<Vec<_>>>()?;
        let list = entry.need("channels")?;
        let mut channels = Vec::new();
        let mut taken = HashSet::new();
        for item in list.items()? {
            let sampler = item.need("sampler")?.index("sampler", samplers.len())?;
            let Some(channel) = channel(&item, &samplers[sampler], nodes, meshes)? else {
                continue;
            };
            if !taken.insert((channel.node, channel.target)) {
                return Err(item.wrong("changes what another channel changes"));
            }
            channels.push(channel);
        }
        Ok(Animation { name: entry.name()?, channels })
    })
}

struct Sampler {
    interpolation: Interpolation,
    times: Arc<Vec<f32>>,
    values: Arc<Vec<f32>>,
}

fn sampler(
    entry: &Entry<'_, '_>,
    accessors: &mut Accessors<'_>,
    checked: &mut Checked,
) -> Result<Sampler> {
    let interpolation = match entry.text_or_empty("interpolation")? {
        "" | "LINEAR" => Interpolation::Linear,
        "STEP" => Interpolation::Step,
        "CUBICSPLINE" => Interpolation::Cubic,
        other => {
            let other = crate::shown::shown(other);
            return Err(entry.wrong(format_args!(
                "has an interpolation \"{other}\", but must have LINEAR, STEP or CUBICSPLINE"
            )));
        }
    };
    let input = entry.need("input")?;
    if !accessors.is(&input, "SCALAR")? {
        return Err(input.wrong("names an accessor that does not hold SCALAR"));
    }
    let times = accessors.scalars(&input)?;
    if checked.times.insert(accessors.index(&input)?) {
        let rises = times.is_sorted_by(|a, b| a < b) && times.iter().all(|time| time.is_finite());
        if times.is_empty() || !rises {
            return Err(input.wrong("names times that do not all grow, or are none"));
        }
    }
    let output = entry.need("output")?;
    let values = accessors.scalars(&output)?;
    if checked.values.insert(accessors.index(&output)?)
        && let Some(i) = values.iter().position(|value| !value.is_finite())
    {
        return Err(output.wrong(format_args!("names a value {i} that is not finite")));
    }
    Ok(Sampler { interpolation, times, values })
}

/// A channel; `None` for what changes nothing that is known here.
fn channel(
    entry: &Entry<'_, '_>,
    sampler: &Sampler,
    nodes: &[Node],
    meshes: &[Mesh],
) -> Result<Option<Channel>> {
    let place = entry.need("target")?;
    let path = place.need("path")?;
    let node = place.index_of("node", "node", nodes.len())?;
    let (target, width) = match path.text()? {
        "translation" => (Target::Translation, 3),
        "rotation" => (Target::Rotation, 4),
        "scale" => (Target::Scale, 3),
        "weights" => {
            let mesh = node.and_then(|node| nodes[node].mesh);
            (Target::Weights, mesh.map_or(0, |mesh| meshes[mesh].weights.len()))
        }
        _ => {
            entry
                .notes
                .add("animations of other things than nodes, left out", || entry.place.to_string());
            return Ok(None);
        }
    };
    let Some(node) = node else { return Ok(None) };
    let is_matrix = matches!(nodes[node].placement, Placement::Matrix(_));
    if width == 0 || (is_matrix && target != Target::Weights) {
        entry.notes.add("animations of nodes that cannot follow them, left out", || {
            entry.place.to_string()
        });
        return Ok(None);
    }
    let each = match sampler.interpolation {
        Interpolation::Linear | Interpolation::Step => width,
        Interpolation::Cubic => 3 * width,
    };
    let (keyframes, numbers) = (sampler.times.len(), sampler.values.len());
    if keyframes.checked_mul(each) != Some(numbers) {
        return Err(
            entry.wrong(format_args!("has {numbers} numbers for {keyframes} keyframes of {each}"))
        );
    }
    let channel = Channel {
        node,
        target,
        interpolation: sampler.interpolation,
        times: sampler.times.clone(),
        values: sampler.values.clone(),
        width,
    };
    Ok(Some(channel))
}
