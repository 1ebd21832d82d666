//! Moving by keys: by how long they are held, not by how often a frame is drawn.
//!
//! Time is cut into steps of a 240th of a second, counted from a fixed moment.
//! A move is the sum of the steps during which its key was down: the same
//! presses at the same times lead to the same place however many frames were
//! drawn meanwhile. A key that goes down and up between two frames counts for
//! one step.

use crate::keys::Action;
use crate::pose::Pose;
use std::collections::BTreeMap;

/// Steps in a second.
const STEPS_PER_SECOND: f64 = 240.0;

/// Turning, in radians per second.
const TURNING: f64 = 1.2;

/// After a pause longer than this (the machine slept, a dialog was open) no more than this is made
/// up for, in seconds.
const LONGEST: f64 = 0.5;

/// Keys that are down, and up to when they have moved the camera.
#[derive(Clone, Debug, Default)]
pub struct Flight {
    /// With the steps that each is still owed at least.
    held: BTreeMap<Action, u64>,
    /// The step up to which all has been done.
    done: u64,
}

impl Flight {
    /// A key went down at `time`, in seconds. Repetitions by the keyboard change nothing.
    pub fn press(&mut self, action: Action, time: f64, pose: &mut Pose, speed: f64) {
        self.advance(time, pose, speed);
        if velocity(action).is_some() {
            self.held.entry(action).or_insert(1);
        }
    }

    /// A key went up at `time`.
    pub fn release(&mut self, action: Action, time: f64, pose: &mut Pose, speed: f64) {
        self.advance(time, pose, speed);
        if let Some(owed) = self.held.remove(&action)
            && owed > 0
        {
            step(pose, [action].into_iter(), speed);
        }
    }

    /// All keys count as up: the window lost the keyboard.
    pub fn release_all(&mut self) {
        self.held.clear();
    }

    /// Whether a key is down that moves the camera.
    pub fn is_moving(&self) -> bool {
        !self.held.is_empty()
    }

    /// Moves up to `time`, in seconds; `speed` is in metres per second.
    pub fn advance(&mut self, time: f64, pose: &mut Pose, speed: f64) {
        let now = (time.max(0.0) * STEPS_PER_SECOND) as u64;
        let steps = now.saturating_sub(self.done).min((LONGEST * STEPS_PER_SECOND) as u64);
        self.done = self.done.max(now);
        if steps == 0 || self.held.is_empty() {
            return;
        }
        for _ in 0..steps {
            step(pose, self.held.keys().copied(), speed);
        }
        self.held.values_mut().for_each(|owed| *owed = owed.saturating_sub(steps));
    }
}

/// One step of all keys that are down.
fn step(pose: &mut Pose, held: impl Iterator<Item = Action>, speed: f64) {
    let (mut way, mut turn) = ([0.0; 3], [0.0; 2]);
    for velocity in held.filter_map(velocity) {
        match velocity {
            Velocity::Along(axis, sign) => way[axis] += sign * speed / STEPS_PER_SECOND,
            Velocity::Around(axis, sign) => turn[axis] += sign * TURNING / STEPS_PER_SECOND,
        }
    }
    if turn != [0.0; 2] {
        pose.turn(turn[0], turn[1]);
    }
    if way != [0.0; 3] {
        pose.fly(way);
    }
}

enum Velocity {
    /// Right, up, forward.
    Along(usize, f64),
    /// Left, up.
    Around(usize, f64),
}

/// How a key moves the camera while it is down.
fn velocity(action: Action) -> Option<Velocity> {
    Some(match action {
        Action::Right => Velocity::Along(0, 1.0),
        Action::Left => Velocity::Along(0, -1.0),
        Action::Up => Velocity::Along(1, 1.0),
        Action::Down => Velocity::Along(1, -1.0),
        Action::Forward => Velocity::Along(2, 1.0),
        Action::Back => Velocity::Along(2, -1.0),
        Action::TurnLeft => Velocity::Around(0, 1.0),
        Action::TurnRight => Velocity::Around(0, -1.0),
        Action::LookUp => Velocity::Around(1, 1.0),
        Action::LookDown => Velocity::Around(1, -1.0),
        Action::JumpForward
        | Action::JumpBack
        | Action::ToggleDepth
        | Action::PrintPose
        | Action::Pause
        | Action::Panels
        | Action::FitAll
        | Action::Overlay
        | Action::StoreSnapshot
        | Action::Help
        | Action::Close => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rutilant_geom::Vec3;

    const START: Pose =
        Pose { position: Vec3::new(0.0, 0.0, 10.0), look_at: Vec3::ZERO, up: Vec3::Y };

    /// A log of keys: when, which, down or up.
    const LOG: [(f64, Action, bool); 8] = [
        (1.0, Action::Forward, true),
        (1.5, Action::TurnLeft, true),
        (2.0, Action::TurnLeft, false),
        (2.5, Action::Forward, false),
        (3.0, Action::Right, true),
        (3.25, Action::Up, true),
        (3.5, Action::Right, false),
        (4.0, Action::Up, false),
    ];

    /// Plays the log with a frame at every one of `frames`, at which keys that came before are told.
    fn play(frames: impl Iterator<Item = f64>) -> Pose {
        let (mut flight, mut pose) = (Flight::default(), START);
        let mut log = LOG.iter().peekable();
        for frame in frames {
            while let Some(&&(time, action, down)) = log.peek()
                && time <= frame
            {
                log.next();
                if down {
                    flight.press(action, time, &mut pose, 2.0);
                } else {
                    flight.release(action, time, &mut pose, 2.0);
                }
            }
            flight.advance(frame, &mut pose, 2.0);
        }
        pose
    }

    /// The same presses lead to the same place, to the last bit, at 10, 60 and 144 frames a second
    /// and at irregular ones. The old program moved by a step each frame.
    #[test]
    fn frames_do_not_matter() {
        let at_60 = play((0..300).map(|i| f64::from(i) / 60.0));
        assert_ne!(at_60, START);
        assert_eq!(at_60, play((0..50).map(|i| f64::from(i) / 10.0)));
        assert_eq!(at_60, play((0..720).map(|i| f64::from(i) / 144.0)));
        let irregular = (0..200_u32).scan(0.0, |t, i| {
            *t += f64::from(i * 7919 % 97) / 97.0 * 0.06;
            Some(*t)
        });
        assert_eq!(at_60, play(irregular));
    }

    /// A second forward at two metres a second is two metres; half a second of turning is 0.6 rad.
    #[test]
    fn speed_is_in_metres_and_radians_per_second() {
        let (mut flight, mut pose) = (Flight::default(), START);
        flight.press(Action::Forward, 1.0, &mut pose, 2.0);
        for frame in 0..20 {
            flight.advance(1.0 + f64::from(frame) * 0.05, &mut pose, 2.0);
        }
        flight.release(Action::Forward, 2.0, &mut pose, 2.0);
        assert!(pose.position.distance(Vec3::Z * 8.0) < 1e-4, "{pose:?}");
        flight.press(Action::TurnLeft, 3.0, &mut pose, 2.0);
        flight.release(Action::TurnLeft, 3.5, &mut pose, 2.0);
        let direction = (pose.look_at - pose.position).normalize();
        assert!((direction.x + 0.6_f32.sin()).abs() < 1e-4, "{direction}");
    }

    /// A tap between two frames moves by one step; keyboard repetition adds nothing.
    #[test]
    fn a_tap_counts_once() {
        let (mut flight, mut pose) = (Flight::default(), START);
        flight.press(Action::Right, 1.0, &mut pose, 240.0);
        flight.press(Action::Right, 1.0, &mut pose, 240.0);
        flight.release(Action::Right, 1.0, &mut pose, 240.0);
        assert!(pose.position.distance(Vec3::new(1.0, 0.0, 10.0)) < 1e-5, "{pose:?}");
        assert!(!flight.is_moving());
        flight.advance(2.0, &mut pose, 240.0);
        assert!(pose.position.distance(Vec3::new(1.0, 0.0, 10.0)) < 1e-5, "{pose:?}");
    }

    /// After a long sleep one is not at the other end of the world.
    #[test]
    fn sleep_is_not_made_up_for() {
        let (mut flight, mut pose) = (Flight::default(), START);
        flight.press(Action::Right, 1.0, &mut pose, 1.0);
        flight.advance(1e6, &mut pose, 1.0);
        assert!(pose.position.x < 0.6, "{pose:?}");
    }
}
