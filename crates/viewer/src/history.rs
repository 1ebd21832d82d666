//! Undo and redo.
//!
//! Every state that was left is kept as a whole. What belongs to one gesture,
//! a drag of a slider for example, is one step: the states in between are
//! forgotten.

use std::sync::Arc;

/// States kept at most, in either direction.
const MOST: usize = 500;

/// The states before and after the present one.
#[derive(Debug)]
pub(crate) struct History<T> {
    present: Arc<T>,
    /// The oldest first.
    past: Vec<Arc<T>>,
    /// The nearest last.
    future: Vec<Arc<T>>,
    /// The gesture that made the present state, as long as it goes on.
    gesture: Option<u64>,
}

impl<T: PartialEq> History<T> {
    pub(crate) fn new(present: T) -> Self {
        Self { present: Arc::new(present), past: Vec::new(), future: Vec::new(), gesture: None }
    }

    pub(crate) fn present(&self) -> &Arc<T> {
        &self.present
    }

    /// Goes to another state. With a number, changes of the same gesture are one step. Returns
    /// false, and does nothing, where it is the state that there is.
    pub(crate) fn change(&mut self, next: T, gesture: Option<u64>) -> bool {
        if next == *self.present {
            return false;
        }
        let before = std::mem::replace(&mut self.present, Arc::new(next));
        let goes_on = gesture.is_some() && gesture == self.gesture;
        if !goes_on {
            self.past.push(before);
            if self.past.len() > MOST {
                self.past.remove(0);
            }
        }
        self.future.clear();
        self.gesture = gesture;
        true
    }

    /// Makes the present state another object, equal to the one it was.
    pub(crate) fn renew(&mut self)
    where
        T: Clone,
    {
        self.present = Arc::new(T::clone(&self.present));
    }

    /// The gesture that there was, if there was one, is over.
    pub(crate) fn end_gesture(&mut self) {
        self.gesture = None;
    }

    pub(crate) fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    pub(crate) fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Goes back by a step, if there is one.
    pub(crate) fn undo(&mut self) -> bool {
        let Some(before) = self.past.pop() else { return false };
        self.future.push(std::mem::replace(&mut self.present, before));
        self.gesture = None;
        true
    }

    /// Takes back an undo.
    pub(crate) fn redo(&mut self) -> bool {
        let Some(next) = self.future.pop() else { return false };
        self.past.push(std::mem::replace(&mut self.present, next));
        self.gesture = None;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Undo goes back step by step to the very first state, redo forward to the last, and a new
    /// change cuts off what was undone.
    #[test]
    fn steps_can_be_taken_back_and_again() {
        let mut history = History::new(0);
        for state in 1..=5 {
            assert!(history.change(state, None));
        }
        assert!(!history.change(5, None));
        let back: Vec<i32> =
            std::iter::from_fn(|| history.undo().then(|| **history.present())).collect();
        assert_eq!(back, [4, 3, 2, 1, 0]);
        assert!(history.redo() && history.redo() && history.can_redo());
        assert!(history.change(9, None) && !history.can_redo());
        assert!(history.undo());
        assert_eq!(**history.present(), 2);
    }

    /// A drag is one step, the next drag of the same slider another.
    #[test]
    fn a_gesture_is_one_step() {
        let mut history = History::new(0);
        for state in 1..=5 {
            history.change(state, Some(7));
        }
        history.end_gesture();
        for state in 6..=9 {
            history.change(state, Some(7));
        }
        history.change(10, Some(8));
        assert!(history.undo());
        assert_eq!(**history.present(), 9);
        assert!(history.undo());
        assert_eq!(**history.present(), 5);
        assert!(history.undo() && !history.undo());
        assert_eq!(**history.present(), 0);
        // A gesture that goes on after an undo is a new one.
        history.change(1, Some(8));
        history.undo();
        history.change(2, Some(8));
        assert!(history.undo());
        assert_eq!(**history.present(), 0);
    }

    /// It does not grow without end.
    #[test]
    fn the_past_is_bounded() {
        let mut history = History::new(0);
        for state in 1..10_000 {
            history.change(state, None);
        }
        assert_eq!(std::iter::from_fn(|| history.undo().then_some(())).count(), MOST);
    }
}
