//! Changes to the text of a scene that leave every other byte as it is.

use super::layout::{Entry, Layout, Node, NodeKind};
use super::said::{Group, Said, Written};
use std::ops::Range;
use toml::de::DeValue;

/// A text, and what is to be changed in it.
pub(super) struct Edits<'t> {
    text: &'t str,
    line_end: &'static str,
    changes: Vec<(Range<usize>, String)>,
}

impl<'t> Edits<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        let first = text.split_inclusive('\n').next().unwrap_or_default();
        let line_end = if first.ends_with("\r\n") { "\r\n" } else { "\n" };
        Self { text, line_end, changes: Vec::new() }
    }

    /// The changed text; `None` where two changes are in each other's way.
    pub(super) fn finish(mut self) -> Option<String> {
        self.changes.sort_by_key(|(at, _)| (at.start, at.end));
        let (mut result, mut done) = (String::with_capacity(self.text.len()), 0);
        for (at, new) in &self.changes {
            result.push_str(self.text.get(done..at.start)?);
            result.push_str(new);
            done = at.end;
        }
        result.push_str(self.text.get(done..)?);
        Some(result)
    }

    fn part(&self, at: Range<usize>) -> &'t str {
        self.text.get(at).unwrap_or_default()
    }

    pub(super) fn replace(&mut self, at: Range<usize>, new: impl Into<String>) {
        self.changes.push((at, new.into()));
    }

    fn line_start(&self, at: usize) -> usize {
        let start = self.part(0..at).rfind('\n').map_or(0, |end| end + 1);
        if start == 0 && self.text.starts_with('\u{feff}') { 3.min(at) } else { start }
    }

    /// The byte behind the end of the line of byte `at`.
    fn next_line(&self, at: usize) -> usize {
        self.part(at..self.text.len()).find('\n').map_or(self.text.len(), |end| at + end + 1)
    }

    /// Puts lines below the line of byte `at`.
    fn insert_below(&mut self, at: usize, lines: &str) {
        let at = self.next_line(at);
        let lines = lines.replace('\n', self.line_end);
        let unfinished = at == self.text.len() && !self.text.ends_with('\n');
        let lines = if unfinished {
            let lines = lines.strip_suffix(self.line_end).unwrap_or(&lines);
            format!("{}{lines}", self.line_end)
        } else {
            lines
        };
        self.replace(at..at, lines);
    }

    /// Puts a table below the line of byte `at`, with an empty line around it.
    pub(super) fn insert_table(&mut self, at: usize, table: &str) {
        let next = self.next_line(at);
        let line = self.part(next..self.next_line(next));
        let last = next == self.text.len();
        let behind = if last || line.trim().is_empty() { "" } else { "\n" };
        self.insert_below(at, &format!("\n{table}{behind}"));
    }

    /// Takes away the lines from that of byte `from` to that of byte `to`, and an empty one above.
    pub(super) fn remove_lines(&mut self, from: usize, to: usize) {
        let mut start = self.line_start(from);
        let above = self.line_start(start.saturating_sub(1));
        if above < start && self.part(above..start).trim().is_empty() {
            start = above;
        }
        self.replace(start..self.next_line(to), "");
    }

    /// Takes away the items of a list in brackets that `gone` names, and puts others at its end.
    pub(super) fn change_list(
        &mut self,
        inside: Range<usize>,
        items: &[Range<usize>],
        gone: &[bool],
        new: &[String],
    ) {
        let gone = |i: usize| gone.get(i).copied().unwrap_or(false);
        let kept = |i: &usize| !gone(*i);
        let last = (0..items.len()).rfind(kept);
        let first = (0..items.len()).find(kept);
        let mut i = 0;
        while i < items.len() {
            if !gone(i) {
                i += 1;
                continue;
            }
            let run = i;
            while i < items.len() && gone(i) {
                i += 1;
            }
            match (run.checked_sub(1), first) {
                (Some(before), _) => self.replace(items[before].end..items[i - 1].end, ""),
                (None, Some(next)) => self.replace(items[run].start..items[next].start, ""),
                (None, None) => self.replace(items[run].start..items[i - 1].end, ""),
            }
        }
        if new.is_empty() {
            return;
        }
        let new = new.join(", ");
        match (last, items.last()) {
            (Some(last), _) => self.replace(items[last].end..items[last].end, format!(", {new}")),
            // A comma may follow what has gone; it now follows what has come.
            (None, Some(end)) => self.replace(end.end..end.end, new),
            (None, None) => self.replace(inside.start + 1..inside.start + 1, format!(" {new} ")),
        }
    }
}

/// A table in the text.
#[derive(Clone)]
pub(super) struct TableAt<'l> {
    form: Form,
    /// Everything in the same brackets, or below the same header.
    all: &'l [Entry],
    /// What keys of this table begin with.
    prefix: Vec<String>,
}

#[derive(Clone)]
enum Form {
    /// A line for each key; the number and the header of its section.
    Lines { section: usize, header: Range<usize> },
    /// `{ a = 1, b = 2 }`.
    Inline { inside: Range<usize> },
}

impl<'l> TableAt<'l> {
    fn entries(&self) -> impl DoubleEndedIterator<Item = &'l Entry> {
        let prefix = self.prefix.clone();
        self.all
            .iter()
            .filter(move |e| e.path.len() == prefix.len() + 1 && e.path.starts_with(&prefix))
    }

    pub(super) fn entry(&self, key: &str) -> Option<&'l Entry> {
        self.entries().find(|entry| entry.path.last().is_some_and(|name| name == key))
    }

    /// What stands below `key` in dotted keys.
    fn below(&self, key: &str) -> Vec<&'l Entry> {
        let mut path = self.prefix.clone();
        path.push(key.to_owned());
        let is_below = |e: &&Entry| e.path.len() > path.len() && e.path.starts_with(&path);
        self.all.iter().filter(is_below).collect()
    }

    fn inline(node: &'l Node) -> Option<Self> {
        let NodeKind::Inline(all) = &node.kind else { return None };
        Some(Self { form: Form::Inline { inside: node.at.clone() }, all, prefix: Vec::new() })
    }
}

impl Layout {
    fn section(&self, at: usize) -> Option<TableAt<'_>> {
        let section = self.sections.get(at)?;
        let form = Form::Lines { section: at, header: section.header.clone() };
        Some(TableAt { form, all: &section.entries, prefix: Vec::new() })
    }

    fn sections_of(&self, key: &str) -> impl Iterator<Item = usize> {
        (1..self.sections.len()).filter(move |i| self.sections[*i].path == [key])
    }

    /// The table `key` of the scene, in whatever form it stands there.
    pub(super) fn table(&self, key: &str) -> Option<TableAt<'_>> {
        if let Some(section) = self.sections_of(key).next() {
            return self.section(section).filter(|_| !self.sections[section].is_array);
        }
        let root = self.section(0)?;
        if let Some(entry) = root.entry(key) {
            return TableAt::inline(&entry.value);
        }
        let dotted = !root.below(key).is_empty();
        dotted.then(|| TableAt { prefix: vec![key.to_owned()], ..root })
    }

    /// The tables of the array `key`, and the array itself where it is written in brackets.
    pub(super) fn tables(&self, key: &str) -> (Vec<TableAt<'_>>, Option<&Node>) {
        let node = self.section(0).and_then(|root| root.entry(key)).map(|entry| &entry.value);
        if let Some(node) = node {
            let NodeKind::Array(items) = &node.kind else { return (Vec::new(), None) };
            return (items.iter().filter_map(TableAt::inline).collect(), Some(node));
        }
        let sections = self.sections_of(key).filter(|i| self.sections[*i].is_array);
        (sections.filter_map(|i| self.section(i)).collect(), None)
    }

    /// The table `key` in a table.
    fn sub<'l>(&'l self, table: &TableAt<'l>, key: &str) -> Option<TableAt<'l>> {
        if let Some(entry) = table.entry(key) {
            return TableAt::inline(&entry.value);
        }
        if !table.below(key).is_empty() {
            let mut prefix = table.prefix.clone();
            prefix.push(key.to_owned());
            return Some(TableAt { prefix, ..table.clone() });
        }
        self.sub_section(table, key).and_then(|i| self.section(i))
    }

    /// The section `[table.key]` that belongs to a table with a header.
    fn sub_section(&self, table: &TableAt<'_>, key: &str) -> Option<usize> {
        let Form::Lines { section, .. } = table.form else { return None };
        let own = &self.sections.get(section)?.path;
        let following = section + 1..self.sections.len();
        let mut path = own.clone();
        path.push(key.to_owned());
        following
            .take_while(|i| self.sections[*i].path != *own)
            .find(|i| section > 0 && self.sections[*i].path == path)
    }

    /// The last byte of a section.
    fn end(&self, section: usize) -> usize {
        let Some(section) = self.sections.get(section) else { return 0 };
        section.entries.last().map_or(section.header.end, |entry| entry.value.at.end)
    }

    /// The last byte of all sections that belong to `key`; of what stands above them where there
    /// are none and `key` is empty.
    pub(super) fn end_of(&self, key: &str) -> Option<usize> {
        if key.is_empty() {
            return Some(self.end(0));
        }
        let own = |i: &usize| self.sections[*i].path.first().is_some_and(|name| name == key);
        (1..self.sections.len()).filter(own).map(|i| self.end(i)).max()
    }

    /// Takes a whole table away.
    pub(super) fn remove(&self, key: &str, edits: &mut Edits<'_>) {
        let Some(root) = self.section(0) else { return };
        if let Some(section) = self.sections_of(key).next() {
            edits.remove_lines(self.sections[section].header.start, self.end(section));
        }
        let entries = root.entry(key).into_iter().chain(root.below(key));
        let gone: Vec<_> = entries.collect();
        root.commit(&gone, &[], edits);
    }

    /// Takes the table of an array away that has a header of its own.
    pub(super) fn remove_item(&self, table: &TableAt<'_>, edits: &mut Edits<'_>) {
        if let Form::Lines { section, header } = &table.form {
            edits.remove_lines(header.start, self.end(*section));
        }
    }

    /// Changes a table that says `before`, so that it says `after`.
    pub(super) fn apply(
        &self,
        table: &TableAt<'_>,
        before: &[Group],
        after: &[Group],
        edits: &mut Edits<'_>,
    ) {
        let of = |groups: &'_ [Group], family| groups.iter().position(|g| g.family == family);
        let mut families: Vec<_> = before.iter().chain(after).map(|group| group.family).collect();
        families.dedup();
        let mut seen: Vec<&[&str]> = Vec::new();
        let (mut gone, mut new): (Vec<&Entry>, Vec<&Said>) = (Vec::new(), Vec::new());
        for family in families {
            if seen.contains(&family) {
                continue;
            }
            seen.push(family);
            let old = of(before, family).map_or(&[][..], |i| &before[i].says);
            let says = of(after, family).map_or(&[][..], |i| &after[i].says);
            if old == says {
                continue;
            }
            let (mut needed, mut spare): (Vec<&Said>, Vec<&Said>) = (Vec::new(), Vec::new());
            for said in says {
                let was = old.iter().find(|was| was.key == said.key).map(|was| &was.value);
                if let (Written::Table(groups), Some(Written::Table(were))) = (&said.value, was)
                    && let Some(sub) = self.sub(table, said.key)
                {
                    self.apply(&sub, were, groups, edits);
                    continue;
                }
                match table.entry(said.key) {
                    Some(_) if was == Some(&said.value) => {}
                    Some(entry) => {
                        let value = said.value.text();
                        if !reads_same(edits.part(entry.value.at.clone()), &value) {
                            edits.replace(entry.value.at.clone(), value);
                        }
                    }
                    None if said.usual => spare.push(said),
                    None => needed.push(said),
                }
            }
            let (mut needed, mut spare) = (needed.into_iter(), spare.into_iter());
            for key in family.iter().filter(|key| says.iter().all(|said| said.key != **key)) {
                if let Some(entry) = table.entry(key) {
                    // What says the same in another way takes its place, and keeps its comment,
                    // even if it would go without saying: other keys may need it.
                    match needed.next().or_else(|| spare.next()) {
                        Some(said) => {
                            let new = format!("{} = {}", said.key, said.value.text());
                            edits.replace(entry.key.start..entry.value.at.end, new);
                        }
                        None => gone.push(entry),
                    }
                } else if let Some(section) = self.sub_section(table, key) {
                    edits.remove_lines(self.sections[section].header.start, self.end(section));
                } else {
                    gone.extend(table.below(key));
                }
            }
            new.extend(needed);
        }
        table.commit(&gone, &new, edits);
    }
}

impl TableAt<'_> {
    /// Takes entries away, and puts others at the end.
    fn commit(&self, gone: &[&Entry], new: &[&Said], edits: &mut Edits<'_>) {
        let is_gone = |entry: &Entry| gone.iter().any(|other| other.start == entry.start);
        let depth = self.prefix.len();
        let prefix = match self.entries().next_back() {
            Some(entry) => edits.part(entry.start..entry.key.start).to_owned(),
            None => self.prefix.iter().map(|part| format!("{part}.")).collect(),
        };
        let new = new.iter().map(|said| format!("{prefix}{} = {}", said.key, said.value.text()));
        let header = match &self.form {
            Form::Inline { inside } => {
                let items: Vec<_> = self.all.iter().map(|e| e.start..e.value.at.end).collect();
                let gone: Vec<_> = self.all.iter().map(is_gone).collect();
                let new: Vec<_> = new.collect();
                edits.change_list(inside.clone(), &items, &gone, &new);
                return;
            }
            Form::Lines { header, .. } => header,
        };
        for entry in gone {
            let (from, to) = (edits.line_start(entry.start), edits.next_line(entry.value.at.end));
            let rest = edits.part(entry.value.at.end..to);
            match rest.find('#') {
                Some(comment) => edits.replace(entry.start..entry.value.at.end + comment, ""),
                None => edits.replace(from..to, ""),
            }
        }
        let own = |entry: &&Entry| entry.path.len() > depth && entry.path.starts_with(&self.prefix);
        let last = self.all.iter().rfind(own);
        let indent = last.map_or("", |entry| {
            let indent = edits.part(edits.line_start(entry.start)..entry.start);
            if indent.trim().is_empty() { indent } else { "" }
        });
        let lines: String = new.map(|line| format!("{indent}{line}\n")).collect();
        if !lines.is_empty() {
            edits.insert_below(last.map_or(header.end, |entry| entry.value.at.end), &lines);
        }
    }
}

/// Whether two values are the same, though they may be written differently.
fn reads_same(one: &str, other: &str) -> bool {
    let (Ok(one), Ok(other)) = (DeValue::parse(one), DeValue::parse(other)) else { return false };
    same(one.get_ref(), other.get_ref())
}

fn same(one: &DeValue<'_>, other: &DeValue<'_>) -> bool {
    let number = |value: &DeValue<'_>| match value {
        DeValue::Float(number) => number.as_str().parse().ok().map(f32::to_bits),
        // Whole numbers may be seeds of 64 bits.
        DeValue::Integer(number) if number.as_str().len() < 8 && number.radix() == 10 => {
            number.as_str().parse().ok().map(f32::to_bits)
        }
        _ => None,
    };
    if let (DeValue::Array(one), DeValue::Array(other)) = (one, other) {
        let mut pairs = one.iter().zip(other.iter());
        return one.len() == other.len() && pairs.all(|(a, b)| same(a.get_ref(), b.get_ref()));
    }
    if let (Some(one), Some(other)) = (one.as_str(), other.as_str()) {
        return one == other;
    }
    if let (Some(one), Some(other)) = (one.as_bool(), other.as_bool()) {
        return one == other;
    }
    number(one).is_some() && number(one) == number(other)
}
