//! Groups of emitters.

/// Groups of emitters that light is told apart by, at most.
///
/// Unit: count. Limit: on the memory of caches and the time of rays.
pub const MAX_GROUPS: usize = 8;

/// A group of emitters, by its index among those of the scene, below [`MAX_GROUPS`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Group(pub u8);

/// The parts of a colour that each group has.
pub type GroupParts = [[f32; 3]; MAX_GROUPS];
