//! XML as Mitsuba's scenes have it: elements with attributes, each with its place in the text.
//!
//! Document types are refused, and with them all entities but the five that every XML file has: none
//! of them is needed, and with others a few lines can stand for gigabytes. Text between elements
//! has no meaning and is refused as well; comments and instructions are stepped over.

use crate::error::SceneErrorKind;
use crate::limits::Limits;
use crate::shown::{quoted, shown};
use quick_xml::Reader;
use quick_xml::escape::unescape;
use quick_xml::events::{BytesStart, Event};
use std::borrow::Cow;

/// The elements of a file, in the order in which they begin; the first is the root.
pub(super) struct Tree<'t> {
    pub(super) elements: Vec<Element<'t>>,
}

/// An element.
pub(super) struct Element<'t> {
    pub(super) tag: &'t str,
    /// The byte at which it begins.
    pub(super) at: usize,
    pub(super) attributes: Vec<Attribute<'t>>,
    /// The numbers of the elements in it.
    pub(super) children: Vec<usize>,
}

/// An attribute.
pub(super) struct Attribute<'t> {
    pub(super) name: &'t str,
    pub(super) value: Cow<'t, str>,
    /// The byte at which its value begins.
    pub(super) at: usize,
}

/// What is wrong, and at which byte.
pub(super) type Wrong = (usize, SceneErrorKind);

/// No element of any version of Mitsuba has more attributes.
const MOST_ATTRIBUTES: usize = 16;

/// Deeper nesting is refused whatever the limits say: it is followed by calls within calls.
const DEEPEST: u64 = 500;

/// The elements of a text.
pub(super) fn parse<'t>(text: &'t str, limits: &Limits) -> Result<Tree<'t>, Wrong> {
    let mut reader = Reader::from_str(text);
    let mut tree = Tree { elements: Vec::new() };
    let mut open: Vec<usize> = Vec::new();
    let allowed = limits.nesting.min(DEEPEST);
    loop {
        let at = reader.buffer_position() as usize;
        let event = reader.read_event().map_err(|error| {
            let at = (reader.error_position() as usize).min(text.len());
            (at, SceneErrorKind::Invalid(shown_whole(&error.to_string())))
        })?;
        match event {
            Event::Start(start) => {
                let element = tree.begin(text, at, &start, &open)?;
                open.push(element);
                let asked = open.len() as u64;
                if asked > allowed {
                    let what = "levels of nesting";
                    return Err((at, SceneErrorKind::Limit { what, asked, allowed }));
                }
            }
            Event::Empty(start) => {
                tree.begin(text, at, &start, &open)?;
            }
            Event::End(_) => {
                open.pop();
            }
            Event::Text(words) => stray(at, &words)?,
            Event::CData(words) => stray(at, &words)?,
            Event::DocType(_) => {
                let what = "a document type, and entities with it, are not read here: write \
                            what they stand for";
                return Err((at, SceneErrorKind::Unsupported(what.to_owned())));
            }
            Event::GeneralRef(_) => {
                let what = "text between elements has no meaning here";
                return Err((at, SceneErrorKind::Invalid(what.to_owned())));
            }
            Event::Decl(_) | Event::PI(_) | Event::Comment(_) => {}
            Event::Eof => break,
        }
    }
    if let Some(&last) = open.last() {
        let Element { tag, at, .. } = tree.elements[last];
        return Err((at, SceneErrorKind::Invalid(format!("<{}> is never closed", shown(tag)))));
    }
    if tree.elements.is_empty() {
        let what = "there is no element in it: a Mitsuba scene is a <scene>".to_owned();
        return Err((0, SceneErrorKind::Invalid(what)));
    }
    Ok(tree)
}

impl<'t> Tree<'t> {
    fn begin(
        &mut self,
        text: &'t str,
        at: usize,
        start: &BytesStart<'t>,
        open: &[usize],
    ) -> Result<usize, Wrong> {
        let number = self.elements.len();
        match open.last() {
            Some(&parent) => self.elements[parent].children.push(number),
            None if number > 0 => {
                let what = "a second element beside the first: a file has one".to_owned();
                return Err((at, SceneErrorKind::Invalid(what)));
            }
            None => {}
        }
        let within = Within { text, element: at };
        let mut attributes = Vec::new();
        for attribute in start.attributes().with_checks(false) {
            let attribute = attribute
                .map_err(|error| (at, SceneErrorKind::Invalid(shown_whole(&error.to_string()))))?;
            let Cow::Borrowed(raw) = attribute.value else { continue };
            let (name, _) = within.find(attribute.key.as_ref());
            let (raw, at) = within.find(raw);
            let value = unescape(raw)
                .map_err(|error| (at, SceneErrorKind::Invalid(shown_whole(&error.to_string()))))?;
            if attributes.len() == MOST_ATTRIBUTES {
                let what = format!("an element has at most {MOST_ATTRIBUTES} attributes");
                return Err((at, SceneErrorKind::Invalid(what)));
            }
            if attributes.iter().any(|known: &Attribute<'_>| known.name == name) {
                let what = format!("{} comes twice", shown(name));
                return Err((at, SceneErrorKind::Invalid(what)));
            }
            attributes.push(Attribute { name, value, at });
        }
        let (tag, _) = within.find(start.name().as_ref());
        self.elements.push(Element { tag, at, attributes, children: Vec::new() });
        Ok(number)
    }
}

/// Where the bytes of an element stand in a text.
struct Within<'t> {
    text: &'t str,
    element: usize,
}

impl<'t> Within<'t> {
    /// A part of the text again, with its place: told by where it lies in memory.
    fn find(&self, part: &[u8]) -> (&'t str, usize) {
        let at = (part.as_ptr() as usize).wrapping_sub(self.text.as_ptr() as usize);
        match self.text.get(at..at.saturating_add(part.len())) {
            Some(found) => (found, at),
            None => ("", self.element),
        }
    }
}

/// Only blanks may stand between elements.
fn stray(at: usize, words: &[u8]) -> Result<(), Wrong> {
    let blank = words.iter().position(|byte| !byte.is_ascii_whitespace());
    match blank {
        // The byte order mark of a file that was not stripped of it, or words.
        Some(first) => {
            let word = words[first..].split(u8::is_ascii_whitespace).next().unwrap_or_default();
            let what =
                format!("{} stands between elements, where nothing has a meaning", quoted(word));
            Err((at + first, SceneErrorKind::Invalid(what)))
        }
        None => Ok(()),
    }
}

/// The words of the XML reader, in one line that is no page.
fn shown_whole(words: &str) -> String {
    words.split_inclusive(' ').take(40).map(shown).collect()
}
