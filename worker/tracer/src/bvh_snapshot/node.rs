//! The memory layout of the hierarchy: eight boxes per node, [`BLOCK`] triangles per leaf.

/// Children per node.
pub(super) const WIDTH: usize = 8;
/// Triangles per leaf.
pub(super) const BLOCK: usize = 4;

/// What a child slot refers to: a node, or a block of triangles where [`Child::LEAF`] is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Child;

impl Child {
    pub const LEAF: u32 = 1 << 31;
}

/// Eight child boxes as planes, so that one 8-lane load fetches one plane of every child.
///
/// Four cache lines, aligned to them. An unused slot holds an inside-out box, which no ray enters.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower x, upper x, lower y, upper y, lower z, upper z of the eight children.
    pub planes: [[f32; WIDTH]; 6],
    /// See [`Child`].
    pub children: [u32; WIDTH],
}

impl Node {
    pub const EMPTY: Self = {
        let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { planes: [low, high, low, high, low, high], children: [0; WIDTH] }
    };
}

/// The triangles of a leaf, vertex coordinates side by side. Unused lanes hold a point, which no ray hits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(super) struct Block {
    /// x, y, z of the first vertex, then of the second, then of the third.
    pub vertices: [[f32; BLOCK]; 9],
    /// Indices into the caller's triangles.
    pub triangles: [u32; BLOCK],
}

impl Block {
    pub const EMPTY: Self = Self { vertices: [[0.0; BLOCK]; 9], triangles: [u32::MAX; BLOCK] };
}
