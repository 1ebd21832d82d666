//! Which key does what.
//!
//! Every action has one key, which people may change. The file that keeps
//! their choice names keys as egui does: `forward = "W"`.

use eframe::egui::Key;
use std::collections::BTreeMap;

/// Something that a key does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Action {
    /// Forward, while it is held.
    Forward,
    /// Back, while it is held.
    Back,
    /// To the left, while it is held.
    Left,
    /// To the right, while it is held.
    Right,
    /// Up, while it is held.
    Up,
    /// Down, while it is held.
    Down,
    /// Turns to the left, while it is held.
    TurnLeft,
    /// Turns to the right, while it is held.
    TurnRight,
    /// Turns up, while it is held.
    LookUp,
    /// Turns down, while it is held.
    LookDown,
    /// As far forward as one flies in a second.
    JumpForward,
    /// As far back as one flies in a second.
    JumpBack,
    /// Between direct light alone and all light.
    ToggleDepth,
    /// Prints where the camera stands.
    PrintPose,
    /// Stops rendering, or goes on.
    Pause,
    /// Hides all panels, or shows them.
    Panels,
    /// Looks at the whole scene.
    FitAll,
    /// Marks what cannot be shown.
    Overlay,
    /// Keeps the picture to compare with.
    StoreSnapshot,
    /// Shows what keys do.
    Help,
    /// Closes what is open, or the window.
    Close,
}

/// Each action with its name in files, what it does in words, and its usual key.
const ACTIONS: [(Action, &str, &str, Key); 21] = [
    (Action::Forward, "forward", "Forward", Key::W),
    (Action::Back, "back", "Back", Key::S),
    (Action::Left, "left", "Left", Key::A),
    (Action::Right, "right", "Right", Key::D),
    (Action::Up, "up", "Up", Key::R),
    (Action::Down, "down", "Down", Key::F),
    (Action::TurnLeft, "turn_left", "Turn left", Key::ArrowLeft),
    (Action::TurnRight, "turn_right", "Turn right", Key::ArrowRight),
    (Action::LookUp, "look_up", "Look up", Key::ArrowUp),
    (Action::LookDown, "look_down", "Look down", Key::ArrowDown),
    (Action::JumpForward, "jump_forward", "Jump forward", Key::E),
    (Action::JumpBack, "jump_back", "Jump back", Key::Q),
    (Action::ToggleDepth, "toggle_depth", "Direct light only, or all light", Key::H),
    (Action::PrintPose, "print_pose", "Print and copy the camera as TOML", Key::P),
    (Action::Pause, "pause", "Pause or continue", Key::Space),
    (Action::Panels, "panels", "Hide or show the panels", Key::N),
    (Action::FitAll, "fit_all", "See the whole scene", Key::Home),
    (Action::Overlay, "overlay", "Mark what cannot be shown", Key::O),
    (Action::StoreSnapshot, "store_snapshot", "Keep this picture to compare with", Key::B),
    (Action::Help, "help", "Show the keys", Key::F1),
    (Action::Close, "close", "Close what is open, or the window", Key::Escape),
];

impl Action {
    /// All of them.
    pub fn all() -> impl Iterator<Item = Self> {
        ACTIONS.iter().map(|row| row.0)
    }

    /// What it does, for people.
    pub fn label(self) -> &'static str {
        self.row().2
    }

    fn row(self) -> &'static (Self, &'static str, &'static str, Key) {
        // The table lists the actions in their order: a test sees to that.
        &ACTIONS[self as usize]
    }
}

/// The key of each action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyMap(BTreeMap<Action, Key>);

impl Default for KeyMap {
    fn default() -> Self {
        Self(ACTIONS.iter().map(|row| (row.0, row.3)).collect())
    }
}

impl KeyMap {
    /// The key of an action.
    pub fn key(&self, action: Action) -> Key {
        self.0.get(&action).copied().unwrap_or(action.row().3)
    }

    /// What a key does, if anything.
    pub fn action(&self, key: Key) -> Option<Action> {
        self.0.iter().find(|(_, k)| **k == key).map(|(action, _)| *action)
    }

    /// Gives an action another key. The action that had it, if there is one, gets the old key of
    /// this one, so that no action is without a key.
    pub fn set(&mut self, action: Action, key: Key) {
        let old = self.key(action);
        if let Some(other) = self.action(key) {
            self.0.insert(other, old);
        }
        self.0.insert(action, key);
    }

    /// The keys that are not the usual ones, by the names of actions and keys.
    pub fn to_names(&self) -> BTreeMap<String, String> {
        let changed = ACTIONS.iter().filter(|row| self.key(row.0) != row.3);
        changed.map(|row| (row.1.to_owned(), self.key(row.0).name().to_owned())).collect()
    }

    /// The usual keys but for those named. Names that mean nothing are returned.
    pub fn from_names(names: &BTreeMap<String, String>) -> (Self, Vec<String>) {
        let (mut map, mut unknown) = (Self::default(), Vec::new());
        for (action, key) in names {
            let row = ACTIONS.iter().find(|row| row.1 == action);
            match (row, Key::from_name(key)) {
                (Some(row), Some(key)) => map.set(row.0, key),
                _ => unknown.push(format!("{action} = \"{key}\"")),
            }
        }
        (map, unknown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table is in the order of the enum, and no two actions share a name or a key.
    #[test]
    fn the_table_is_sound() {
        for (number, (action, name, _, key)) in ACTIONS.iter().enumerate() {
            assert_eq!(*action as usize, number, "{name}");
            let same = ACTIONS.iter().filter(|row| row.1 == *name || row.3 == *key).count();
            assert_eq!(same, 1, "{name}");
        }
    }

    /// A key that is given away is swapped, so that everything can still be done; and what was
    /// changed comes back from its names.
    #[test]
    fn keys_are_swapped_and_remembered() {
        let mut map = KeyMap::default();
        map.set(Action::Forward, Key::E);
        assert_eq!(map.key(Action::JumpForward), Key::W);
        map.set(Action::Up, Key::PageUp);
        assert_eq!(map.action(Key::R), None);
        for action in Action::all() {
            assert_eq!(map.action(map.key(action)), Some(action));
        }
        let (again, unknown) = KeyMap::from_names(&map.to_names());
        assert_eq!((again, unknown), (map, vec![]));
    }

    /// A file from another version, or one with a slip, costs no more than its own lines.
    #[test]
    fn unknown_names_are_told() {
        let names = [("forward", "Zz"), ("fly", "W"), ("back", "X")];
        let names = names.map(|(a, b)| (a.to_owned(), b.to_owned())).into();
        let (map, unknown) = KeyMap::from_names(&names);
        assert_eq!(map.key(Action::Back), Key::X);
        assert_eq!(map.key(Action::Forward), Key::W);
        assert_eq!(unknown, [r#"fly = "W""#, r#"forward = "Zz""#]);
    }
}
