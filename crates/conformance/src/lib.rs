//! Proves the renderer against closed forms, references and itself.
