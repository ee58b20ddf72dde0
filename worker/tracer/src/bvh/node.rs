//! The memory layout of the hierarchy: eight boxes per node, up to eight triangles per leaf.

use bytemuck::{Pod, Zeroable};

/// Children per node, triangles per leaf, lanes per vector.
pub(super) const WIDTH: usize = 8;

/// Numbers per triangle in a leaf: nine coordinates and the index.
pub(super) const ROWS: usize = 10;

/// Triangles that [`Child`] can number.
pub(super) const MOST_TRIANGLES: usize = 1 << 28;

/// What a child slot refers to. Bit 31 clear: the node of that index. Set: a leaf, with its number of triangles less one
/// in bits 28 to 30 and the number of triangles stored before it in bits 0 to 27.
#[derive(Clone, Copy)]
pub(super) struct Child(pub u32);

impl Child {
    pub fn node(index: usize) -> Self {
        Self(index as u32)
    }

    /// A leaf of `count` triangles (1 to 8), `first` (below [`MOST_TRIANGLES`]) triangles from the start.
    pub fn leaf(first: usize, count: usize) -> Self {
        Self(1 << 31 | (count as u32 - 1) << 28 | first as u32)
    }

    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 >> 31 != 0
    }
}

/// Eight child boxes as planes, so that one 8-lane load fetches one plane of every child.
///
/// Four cache lines, aligned to them. An unused slot holds an inside-out box, which no ray enters.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Lower x, upper x, lower y, upper y, lower z, upper z of the children.
    pub planes: [[f32; WIDTH]; 6],
    /// See [`Child`].
    pub children: [u32; WIDTH],
    unused: [u32; WIDTH],
}

impl Node {
    pub const EMPTY: Self = {
        let (low, high) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { planes: [low, high, low, high, low, high], children: [0; WIDTH], unused: [0; WIDTH] }
    };
}

/// The triangles of one leaf, in rows as long as there are triangles: x, y, z of the first vertices, of the second, of
/// the third, then the triangles' indices as the bits of a float.
///
/// Rows are loaded eight lanes wide; the lanes beyond the leaf's triangles belong to what follows and are masked. So a
/// leaf takes no more memory than its triangles, and half empty leaves cost no cache lines.
#[derive(Clone, Copy)]
pub(super) struct Leaf<'a> {
    /// All rows and as much of what follows as the last load touches.
    pub rows: &'a [f32],
    pub count: usize,
}

impl<'a> Leaf<'a> {
    /// The leaf that `child` refers to, among all leaves of the hierarchy.
    #[inline(always)]
    pub fn of(leaves: &'a [f32], child: Child) -> Self {
        let first = (child.0 & (MOST_TRIANGLES as u32 - 1)) as usize * ROWS;
        let count = (child.0 >> 28 & 7) as usize + 1;
        Self { rows: &leaves[first..first + (ROWS - 1) * count + WIDTH], count }
    }

    /// The caller's index of the triangle in a lane.
    #[inline(always)]
    pub fn triangle(self, lane: usize) -> u32 {
        self.rows[(ROWS - 1) * self.count + lane].to_bits()
    }

    /// One coordinate of one vertex (0 to 2) of the triangle in a lane.
    pub fn coordinate(self, lane: usize, vertex: usize, axis: usize) -> f32 {
        self.rows[(vertex * 3 + axis) * self.count + lane]
    }
}
