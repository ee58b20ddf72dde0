//! Tiles and tile films: the unit of work and what comes back from it.

/// Side of a tile in pixels.
pub const TILE: u32 = 32;

/// Names of a first-hit film's channels, in order. Where a ray hits nothing, `object` is -1 and the rest is 0.
/// Depth is along the camera's z axis in metres; normal and position in world coordinates; `object` is the index in the
/// capture's list. `incidence` is the angle between the normal and the view, `half` the angle between the normal and
/// the half vector of view and first point-like light that is on (0 where there is none), in radians.
pub const FIRST_HIT_CHANNELS: [&str; 10] = [
    "depth",
    "normal.x",
    "normal.y",
    "normal.z",
    "object",
    "position.x",
    "position.y",
    "position.z",
    "half",
    "incidence",
];

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Tile {
    /// Leftmost column.
    pub x: u32,
    /// Top row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Tile {
    /// The tiles that cover an image, row by row.
    pub fn cover(width: u32, height: u32) -> impl Iterator<Item = Self> {
        (0..height.div_ceil(TILE)).flat_map(move |j| {
            (0..width.div_ceil(TILE)).map(move |i| {
                let (x, y) = (i * TILE, j * TILE);
                Self { x, y, width: TILE.min(width - x), height: TILE.min(height - y) }
            })
        })
    }

    /// Number of pixels.
    #[must_use]
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether it has no pixel.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Which pixels of a tile are wanted, one bit each, row-major, lowest bit first.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PixelSet {
    bits: Vec<u8>,
    len: usize,
}

impl PixelSet {
    /// A set from one flag per pixel.
    pub fn from_flags(flags: impl IntoIterator<Item = bool>) -> Self {
        let mut set = Self::default();
        for flag in flags {
            if set.len.is_multiple_of(8) {
                set.bits.push(0);
            }
            if let (true, Some(last)) = (flag, set.bits.last_mut()) {
                *last |= 1 << (set.len % 8);
            }
            set.len += 1;
        }
        set
    }

    /// A set from its bytes; `None` unless there is exactly one bit for each of `len` pixels.
    #[must_use]
    pub fn from_bytes(bytes: &[u8], len: usize) -> Option<Self> {
        (bytes.len() == len.div_ceil(8)).then(|| Self { bits: bytes.to_vec(), len })
    }

    /// The bytes that [`PixelSet::from_bytes`] reads.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        &self.bits
    }

    /// Indices of the pixels in the set, ascending.
    pub fn indices(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len).filter(|i| self.bits[i / 8] >> (i % 8) & 1 == 1)
    }

    /// Number of pixels in the set.
    #[must_use]
    pub fn count(&self) -> usize {
        self.indices().count()
    }
}

/// What a task returns: for both halves and every plane, the mean over the task's samples at each wanted pixel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TileFilm {
    /// Wanted pixels.
    pub pixels: usize,
    /// Channels of each half: three for radiance and for each derivative plane, or the first-hit channels.
    pub channels: usize,
    /// Halves: two, or one for first hits.
    pub halves: usize,
    /// `[half][pixel][channel]`, `halves * pixels * channels` numbers.
    pub data: Vec<f32>,
    /// Samples that were NaN or infinite in radiance or any derivative, and count as zero.
    pub invalid_samples: u64,
}

impl TileFilm {
    /// The channels of one pixel in one half.
    #[must_use]
    pub fn pixel(&self, half: usize, pixel: usize) -> &[f32] {
        let start = (half * self.pixels + pixel) * self.channels;
        &self.data[start..start + self.channels]
    }
}
