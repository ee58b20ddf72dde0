//! Small text in pixels.

use image::{Rgb, RgbImage};

/// From one character to the next, pixels.
pub const ADVANCE: u32 = 8;
/// Of a character, pixels.
pub const HEIGHT: u32 = 10;
/// Characters of three columns and five rows, three bits a row, top row first.
const GLYPHS: [(char, u16); 39] = [
    ('0', 0b111_101_101_101_111),
    ('1', 0b010_110_010_010_111),
    ('2', 0b111_001_111_100_111),
    ('3', 0b111_001_111_001_111),
    ('4', 0b101_101_111_001_001),
    ('5', 0b111_100_111_001_111),
    ('6', 0b111_100_111_101_111),
    ('7', 0b111_001_010_010_010),
    ('8', 0b111_101_111_101_111),
    ('9', 0b111_101_111_001_111),
    ('a', 0b010_101_111_101_101),
    ('b', 0b110_101_110_101_110),
    ('c', 0b011_100_100_100_011),
    ('d', 0b110_101_101_101_110),
    ('e', 0b111_100_110_100_111),
    ('f', 0b111_100_110_100_100),
    ('g', 0b011_100_101_101_011),
    ('h', 0b101_101_111_101_101),
    ('i', 0b111_010_010_010_111),
    ('j', 0b001_001_001_101_010),
    ('k', 0b101_101_110_101_101),
    ('l', 0b100_100_100_100_111),
    ('m', 0b101_111_111_101_101),
    ('n', 0b110_101_101_101_101),
    ('o', 0b010_101_101_101_010),
    ('p', 0b110_101_110_100_100),
    ('q', 0b010_101_101_111_011),
    ('r', 0b110_101_110_101_101),
    ('s', 0b011_100_010_001_110),
    ('t', 0b111_010_010_010_010),
    ('u', 0b101_101_101_101_111),
    ('v', 0b101_101_101_101_010),
    ('w', 0b101_101_111_111_101),
    ('x', 0b101_101_010_101_101),
    ('y', 0b101_101_010_010_010),
    ('z', 0b111_001_010_100_111),
    ('-', 0b000_000_111_000_000),
    ('/', 0b001_001_010_100_100),
    ('.', 0b000_000_000_000_010),
];

/// Writes text with its upper left corner at a place, each pixel of a character doubled; what has no glyph is a space.
pub fn write(image: &mut RgbImage, text: &str, x: u32, y: u32) {
    for (place, character) in text.chars().enumerate() {
        let bits = GLYPHS.iter().find(|(c, _)| *c == character).map_or(0, |(_, bits)| *bits);
        for bit in (0..15u32).filter(|bit| bits >> (14 - bit) & 1 == 1) {
            for step in 0..4 {
                let (px, py) = (x + ADVANCE * place as u32 + 2 * (bit % 3) + step % 2, y + 2 * (bit / 3) + step / 2);
                image.put_pixel(px, py, Rgb([60; 3]));
            }
        }
    }
}
