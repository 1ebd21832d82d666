//! Faces and strips of a PLY file as triangles.

use super::header::{Element, Property};
use super::numbers::Body;
use super::reader::{Reader, singular};
use crate::error::{SceneError, SceneErrorKind};
use crate::shown::shown;

impl Reader<'_> {
    pub(super) fn faces<B: Body>(
        &mut self,
        element: &Element,
        body: &mut B,
    ) -> Result<(), SceneError> {
        let indices = self.index_list(element)?;
        self.note_unread(element, |i| i == indices);
        self.check_triangles(element.count, element)?;
        self.mesh.triangles.reserve(element.count as usize);
        let (mut face, mut corners) = (Vec::new(), Vec::new());
        for i in 0..element.count {
            for (j, property) in element.properties.iter().enumerate() {
                match property.count {
                    Some(_) if j == indices => {
                        self.index_list_of(property, element, i, body, &mut face)?;
                    }
                    _ => self.skip_property(property, element, i, body)?,
                }
            }
            // Its indices are in range, and a triangle is a triangle.
            let triangles = &mut self.mesh.triangles;
            match *face {
                [a, b, c] => triangles.push([a, b, c]),
                [] | [_] | [_, _] => {
                    let (count, _) = self.too_small.get_or_insert((0, i));
                    *count += 1;
                }
                _ => {
                    corners.clear();
                    corners.extend(face.iter().map(|&v| self.mesh.positions[v as usize]));
                    self.cuts.triangulate(&corners, |t| {
                        triangles.push(t.map(|corner| face[corner as usize]));
                    });
                    self.check_triangles(self.mesh.triangles.len() as u64, element)?;
                }
            }
        }
        Ok(())
    }

    /// Strips: each further vertex makes a triangle with the two before it, every second one
    /// turned; −1 begins a new strip.
    pub(super) fn strips<B: Body>(
        &mut self,
        element: &Element,
        body: &mut B,
    ) -> Result<(), SceneError> {
        let indices = self.index_list(element)?;
        self.note_unread(element, |i| i == indices);
        for i in 0..element.count {
            for (j, property) in element.properties.iter().enumerate() {
                let Some(count) = property.count.filter(|_| j == indices) else {
                    self.skip_property(property, element, i, body)?;
                    continue;
                };
                let length = self.list_length(property, count, element, i, body)?;
                self.mesh.triangles.reserve(length);
                let mut strip: [Option<u32>; 2] = [None; 2];
                let mut turned = false;
                for _ in 0..length {
                    let start = body.at();
                    let index = body
                        .integer(property.scalar)
                        .map_err(|trouble| self.trouble(&trouble, element, i, body))?;
                    if index == -1 {
                        strip = [None; 2];
                        turned = false;
                        continue;
                    }
                    let c = self.checked_index(index, element, i, body, start)?;
                    if let [Some(a), Some(b)] = strip {
                        // Triangles with a corner twice only lead from one part to the next.
                        if a != b && b != c && c != a {
                            let triangle = if turned { [b, a, c] } else { [a, b, c] };
                            self.mesh.triangles.push(triangle);
                        }
                        turned = !turned;
                    }
                    strip = [strip[1], Some(c)];
                }
                self.check_triangles(self.mesh.triangles.len() as u64, element)?;
            }
        }
        Ok(())
    }

    fn check_triangles(&self, asked: u64, element: &Element) -> Result<(), SceneError> {
        let allowed = self.limits.triangles;
        if asked <= allowed {
            return Ok(());
        }
        let kind = SceneErrorKind::Limit { what: "triangles", asked, allowed };
        Err(self.error_at(element.at, kind))
    }

    /// Which property of a face names its vertices.
    fn index_list(&self, element: &Element) -> Result<usize, SceneError> {
        let name = |p: &Property| p.name == "vertex_indices" || p.name == "vertex_index";
        let found = element.properties.iter().position(|p| p.count.is_some() && name(p));
        let Some(found) = found else {
            return Err(self.invalid_at(
                element.at,
                format!("element \"{}\" has no list \"vertex_indices\"", shown(&element.name)),
            ));
        };
        let property = &element.properties[found];
        if !property.scalar.is_integer() {
            let what = format!("\"{}\" must be of an integer type", shown(&property.name));
            return Err(self.invalid_at(property.at, what));
        }
        Ok(found)
    }

    /// The vertices that a list names, into `face`.
    fn index_list_of<B: Body>(
        &self,
        property: &Property,
        element: &Element,
        i: u64,
        body: &mut B,
        face: &mut Vec<u32>,
    ) -> Result<(), SceneError> {
        let Some(count) = property.count else { return Ok(()) };
        let length = self.list_length(property, count, element, i, body)?;
        face.clear();
        for _ in 0..length {
            let start = body.at();
            let index = body
                .integer(property.scalar)
                .map_err(|trouble| self.trouble(&trouble, element, i, body))?;
            face.push(self.checked_index(index, element, i, body, start)?);
        }
        Ok(())
    }

    /// An index as a vertex number, if there is such a vertex; it was read at `start`.
    #[inline]
    fn checked_index<B: Body>(
        &self,
        index: i64,
        element: &Element,
        i: u64,
        body: &mut B,
        start: usize,
    ) -> Result<u32, SceneError> {
        let count = self.mesh.positions.len();
        match u32::try_from(index) {
            Ok(vertex) if (vertex as usize) < count => Ok(vertex),
            _ => {
                body.go_to(start);
                let what = format!(
                    "{} {i} names vertex {index}, but there are only {count} (numbered from 0)",
                    singular(&element.name)
                );
                Err(self.error_in_body(what, body))
            }
        }
    }
}
