//! Damage to a file: bits, bytes, runs, lines and numbers, as transmission, editors and enemies do it.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// Numbers that break things.
const NUMBERS: [&str; 16] = [
    "0",
    "-1",
    "1",
    "1e999",
    "-1e-999",
    "nan",
    "inf",
    "-inf",
    "4294967296",
    "2147483648",
    "18446744073709551616",
    "65535",
    "65536",
    "0.1",
    "9223372036854775807",
    "1e18",
];
/// Bytes that do.
const BYTES: [u8; 8] = [0, 1, 0x7f, 0x80, 0xff, b'\n', b' ', b'"'];
/// Changes of one file, at most.
const CHANGES: u64 = 6;

/// Which of the files is damaged in this case, and what is left of it.
pub fn damaged(files: &[Vec<u8>], case: u64) -> (usize, Vec<u8>) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(case);
    let mut below = |most: usize| (random.next_u64() % most.max(1) as u64) as usize;
    let which = below(files.len());
    let mut bytes = files[which].clone();
    for _ in 0..1 + below(CHANGES as usize) {
        let at = below(bytes.len());
        let longest = 1 << below(8);
        let run = 1 + below(longest);
        let end = (at + run).min(bytes.len());
        match below(11) {
            _ if bytes.is_empty() => {}
            0 => bytes[at] ^= 1 << below(8),
            1 => bytes[at] = BYTES[below(BYTES.len())],
            2 => bytes[at] = below(256) as u8,
            3 => drop(bytes.drain(at..end)),
            4 => {
                let run = bytes[at..end].to_vec();
                let to = below(bytes.len());
                bytes.splice(to..to, run);
            }
            5 => bytes[at..end].fill(BYTES[below(BYTES.len())]),
            6 if below(4) == 0 => bytes.truncate(at),
            7 => {
                let other = &files[below(files.len())];
                let from = below(other.len());
                let piece = &other[from..(from + run).min(other.len())];
                bytes.splice(at..end, piece.iter().copied());
            }
            8 | 9 => replace_number(&mut bytes, at, NUMBERS[below(NUMBERS.len())]),
            _ => swap_lines(&mut bytes, at, below(4096)),
        }
    }
    (which, bytes)
}

/// Puts another number in place of the first that begins at or after `at`.
fn replace_number(bytes: &mut Vec<u8>, at: usize, number: &str) {
    let numeric = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
    let Some(start) = bytes[at..].iter().position(u8::is_ascii_digit).map(|i| at + i) else { return };
    let length = bytes[start..].iter().take_while(|b| numeric(b)).count();
    bytes.splice(start..start + length, number.bytes());
}

/// Swaps the line at `at` with another below it.
fn swap_lines(bytes: &mut Vec<u8>, at: usize, further: usize) {
    let line = |bytes: &[u8], at: usize| {
        let start = bytes[..at].iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
        let end = bytes[at..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |i| at + i);
        start..end
    };
    let first = line(bytes, at);
    let there = (first.end + further).min(bytes.len().saturating_sub(1));
    let second = line(bytes, there);
    if first.end >= second.start {
        return;
    }
    let (a, b) = (bytes[first.clone()].to_vec(), bytes[second.clone()].to_vec());
    bytes.splice(second, a);
    bytes.splice(first, b);
}
