//! From which sides a surface is there.

/// From which sides a surface is there. What lets light through is there from both, whatever is
/// said: a body of glass is met from within as well as from outside.
///
/// Paths from the camera decide: rays that come from behind a surface that has only a front go on
/// as if there were nothing, and see what is before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// From its front and from behind.
    #[default]
    Both,
    /// From its front alone: the side that normals point to.
    Front,
}
