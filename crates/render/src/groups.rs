//! Which light groups a scene has, and which of its emitters are of each.

use crate::light::{Light, LightGroup};
use crate::problem::{MOST_GROUPS, Place, SceneProblem};
use crate::scene::Scene;
use std::sync::Arc;

/// The groups of a scene and the first part that is of each, in the order of its materials, objects
/// and lights, the sky last.
pub(crate) fn groups_of(scene: &Scene) -> Vec<(LightGroup, Place)> {
    let materials = scene.materials.iter().map(|m| m.emission.and_then(|e| e.group));
    let materials = (0..).map(Place::Material).zip(materials);
    let objects = scene.objects.iter().map(|object| object.group);
    let objects = (0..).map(Place::Object).zip(objects);
    let lights = scene.lights.iter().map(Light::group);
    let lights = (0..).map(Place::Light).zip(lights);
    let sky = scene.environment.map(|sky| (Place::Environment, sky.group));
    let mut groups: Vec<(LightGroup, Place)> = Vec::new();
    for (place, group) in materials.chain(objects).chain(lights).chain(sky) {
        let Some(group) = group else { continue };
        // One that is too many is an error: no list of names grows long.
        if groups.len() <= MOST_GROUPS && !groups.iter().any(|(known, _)| *known == group) {
            groups.push((group, place));
        }
    }
    groups
}

/// Whether a scene has too many groups.
pub(crate) fn check_groups(scene: &Scene) -> Result<(), SceneProblem> {
    match groups_of(scene).get(MOST_GROUPS) {
        Some((group, place)) => Err(place.problem(
            "group",
            format!(
                "the light group \"{group}\" is one too many: a scene has {MOST_GROUPS} at most"
            ),
        )),
        None => Ok(()),
    }
}

/// Which group each emitter of a scene is of; nothing where no light has a group.
#[derive(Clone, Debug, Default)]
pub(crate) struct Groups {
    /// Their names; the rest, if there is one, comes last.
    names: Arc<[Arc<str>]>,
    of_emitter: Arc<[u32]>,
}

impl Groups {
    /// Of a valid scene, whose emitters are of these groups.
    pub(crate) fn new(scene: &Scene, emitters: &[Option<LightGroup>]) -> Self {
        let groups = groups_of(scene);
        if groups.is_empty() {
            return Self::default();
        }
        let mut names: Vec<Arc<str>> =
            groups.iter().map(|(group, _)| group.name().into()).collect();
        if emitters.iter().any(Option::is_none) {
            names.push(LightGroup::REST.into());
        }
        let number = |group: &Option<LightGroup>| {
            let known = groups.iter().position(|(known, _)| Some(*known) == *group);
            known.unwrap_or(groups.len()) as u32
        };
        let mut last = (None, groups.len() as u32);
        let of_emitter = emitters.iter().map(|group| {
            // The many triangles of a lamp are all of one.
            if last.0 != *group {
                last = (*group, number(group));
            }
            last.1
        });
        Self { of_emitter: of_emitter.collect(), names: names.into() }
    }

    /// What they are called.
    pub(crate) fn names(&self) -> &[Arc<str>] {
        &self.names
    }

    /// The number of the group of an emitter, where some light has a group.
    #[inline(always)]
    pub(crate) fn of(&self, emitter: usize) -> usize {
        self.of_emitter[emitter] as usize
    }
}
