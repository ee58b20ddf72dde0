//! Tiles and tile films: the unit of work and what comes back from it.

/// Side of a tile in pixels, where all of its pixels may be wanted.
pub const TILE: u32 = 32;

/// Side of the largest tile, of which few pixels are wanted. Its [`PixelSet`] has 32 kB: sixty-four of them fit into a message.
pub const LARGEST_TILE: u32 = 512;

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
        Self::cover_by(TILE, width, height)
    }

    /// The tiles of another side that cover an image, row by row.
    pub fn cover_by(side: u32, width: u32, height: u32) -> impl Iterator<Item = Self> {
        (0..height.div_ceil(side)).flat_map(move |j| {
            (0..width.div_ceil(side)).map(move |i| {
                let (x, y) = (i * side, j * side);
                Self { x, y, width: side.min(width - x), height: side.min(height - y) }
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

    /// A set of `len` pixels' indices; those beyond are left out.
    pub fn from_indices(len: usize, indices: impl IntoIterator<Item = usize>) -> Self {
        let mut bits = vec![0; len.div_ceil(8)];
        for index in indices.into_iter().filter(|index| *index < len) {
            bits[index / 8] |= 1 << (index % 8);
        }
        Self { bits, len }
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
        // A large tile's bytes are mostly empty.
        let bytes = self.bits.iter().enumerate().filter(|(_, byte)| **byte != 0);
        let all =
            bytes.flat_map(|(i, byte)| (0..8).filter(move |bit| byte >> bit & 1 == 1).map(move |bit| 8 * i + bit));
        all.take_while(|index| *index < self.len)
    }

    /// Number of pixels in the set.
    #[must_use]
    pub fn count(&self) -> usize {
        let whole = self.len / 8;
        let ones = |bytes: &[u8]| bytes.iter().map(|byte| byte.count_ones() as usize).sum::<usize>();
        // What a last byte holds beyond the end is no pixel.
        let rest = self.bits.get(whole).map_or(0, |byte| (byte & ((1 << (self.len % 8)) - 1)).count_ones() as usize);
        ones(&self.bits[..whole]) + rest
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_hold_the_same_pixels_however_they_were_made() {
        let wanted = [0, 7, 8, 300, 1020];
        let flags = PixelSet::from_flags((0..1021).map(|i| wanted.contains(&i)));
        let indices = PixelSet::from_indices(1021, wanted.into_iter().chain([1021, 5000]));
        assert_eq!(flags, indices);
        assert_eq!(flags.indices().collect::<Vec<_>>(), wanted);
        assert_eq!(flags.count(), 5);
        // Bits beyond the end are no pixels.
        let beyond = PixelSet::from_bytes(&[0b1000_0001, 0xff], 10).unwrap();
        assert_eq!(beyond.indices().collect::<Vec<_>>(), [0, 7, 8, 9]);
        assert_eq!(beyond.count(), 4);
    }

    #[test]
    fn tiles_of_every_side_cover_each_pixel_once() {
        for side in [32, 512] {
            let mut times = vec![0; 700 * 33];
            for tile in Tile::cover_by(side, 700, 33) {
                for (x, y) in (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y))) {
                    times[((tile.y + y) * 700 + tile.x + x) as usize] += 1;
                }
            }
            assert!(times.iter().all(|n| *n == 1));
        }
    }
}
