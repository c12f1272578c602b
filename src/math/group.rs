//! What light is told apart by: groups of emitters, or orders of scattering.

/// Groups of emitters that light is told apart by, at most.
///
/// Unit: count. Limit: on the memory of caches and the time of rays.
pub const MAX_GROUPS: usize = 8;

/// A group of emitters, by its index among those of the scene, below [`MAX_GROUPS`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Group(pub u8);

/// Orders of scattering that light is told apart by where it is not by groups: 0 as it left its emitter, 1 scattered once by media
/// and by nothing else, 2 all other light. Each is a part of light, like a group of this index.
///
/// Unit: count. Definition: of these orders.
pub const ORDERS: usize = 3;

/// The parts of a colour that each group has, or each order of scattering.
pub type GroupParts = [[f32; 3]; MAX_GROUPS];

/// The parts of the light of one camera ray, in all and by component, W/(m² sr).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RayParts {
    /// Of all light; of that of media where it is told apart by order of scattering.
    pub all: GroupParts,
    /// Of light of media.
    pub media: GroupParts,
    /// Of direct light of surfaces; of none of these where it is told apart by order.
    pub direct: GroupParts,
    /// Of indirect light of surfaces.
    pub indirect: GroupParts,
    /// Of visible emission.
    pub emission: GroupParts,
}
