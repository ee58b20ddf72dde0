//! The largest of everything that a message may hold. Both sides check what they receive against these, so that a hostile
//! or broken peer costs an error and not memory.

/// Largest encoded message, bytes. Senders stay far below: their largest payload is [`CHUNK_BYTES`].
pub const MESSAGE_BYTES: usize = 4 << 20;
/// Largest `data` field of a chunk, bytes; a multiple of four, so that no number is cut in two.
pub const CHUNK_BYTES: usize = 1 << 20;
/// HTTP/2 flow-control window of a stream, bytes: several films may be under way at once.
pub const STREAM_WINDOW_BYTES: u32 = 8 << 20;
/// HTTP/2 frame size, bytes.
pub const FRAME_BYTES: u32 = 1 << 20;
/// Largest blob, bytes; that of the largest file of a capture.
pub const BLOB_BYTES: u64 = 1 << 30;
/// Largest capture manifest, bytes.
pub const MANIFEST_BYTES: u64 = 16 << 20;
/// Largest design of observations, bytes: a byte for every cell of every photo.
pub const DESIGN_BYTES: u64 = 64 << 20;
/// Most files of a capture.
pub const FILES: usize = 10_000;
/// Most blobs asked about in one call.
pub const DIGESTS: usize = 10_000;
/// Most photos of a capture.
pub const PHOTOS: usize = 10_000;
/// Most numbers that a request sets.
pub const NUMBERS: usize = 10_000;
/// Most derivative columns.
pub const COLUMNS: usize = 256;
/// Most numbers that one parameter moves.
pub const TERMS: usize = 1_000;
/// Most samples per pixel, both halves together.
pub const SAMPLES: u32 = 10_000_000;
/// Most tasks of one evaluation.
pub const TASKS: u64 = 1 << 26;
/// Most tasks that one credit buys.
pub const TASKS_AT_ONCE: usize = 64;
/// Most render slots of a worker.
pub const SLOTS: u32 = 4_096;
/// Most credits of a worker that are outstanding.
pub const CREDITS: u32 = 4 * SLOTS;
/// Longest name, bytes.
pub const NAME_BYTES: usize = 1_024;
/// Longest path of a file, bytes.
pub const PATH_BYTES: usize = 4_096;
/// Longest text of an error, bytes; a longer one is cut.
pub const TEXT_BYTES: usize = 4_096;

/// Reads the seconds that a program has to end once it is told to stop: at most a day.
///
/// # Errors
/// Anything else, in words for who wrote it.
pub fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if (0.0..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err("must be a number of seconds, 0 to 86400".to_owned()),
    }
}
