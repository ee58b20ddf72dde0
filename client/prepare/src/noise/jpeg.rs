//! What JPEG does to noise: its blocks, and what their rounding adds.
//!
//! Rounding takes the noise out of a block's fine cosines and leaves it in the block's mean, to which it adds a twelfth of the
//! step's square (ITU-T T.81, A.3.4; Sheppard's correction). So means of whole blocks show the noise that was there before.

/// How a JPEG file is coded, as far as its blocks' means go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blocks {
    /// Side of the blocks that no coefficient reaches beyond, pixels: 8, or 16 with chroma of half the size.
    pub side: usize,
    /// What rounding adds to a channel's noise as means of blocks have it, in value squared: red, green, blue.
    pub rounding: [f64; 3],
}

/// The blocks of a JPEG file; `None` where its bytes do not say.
#[must_use]
pub fn blocks(bytes: &[u8]) -> Option<Blocks> {
    let mut tables = [0.0_f64; 4];
    let mut rest = bytes.strip_prefix(&[0xff, 0xd8])?;
    loop {
        let &[0xff, marker, high, low, ..] = rest else { return None };
        let length = usize::from(u16::from_be_bytes([high, low]));
        let segment = rest.get(4..2 + length)?;
        rest = rest.get(2 + length..)?;
        match marker {
            0xdb => {
                let mut table = segment;
                while let &[kind, ..] = table {
                    let wide = kind >> 4 > 0;
                    // The first entry is the step of the mean.
                    let step = if wide {
                        u16::from_be_bytes([*table.get(1)?, *table.get(2)?])
                    } else {
                        u16::from(*table.get(1)?)
                    };
                    *tables.get_mut(usize::from(kind & 15))? = f64::from(step);
                    table = table.get(if wide { 129 } else { 65 }..)?;
                }
            }
            0xc0..=0xc2 => {
                let components = segment.get(6..)?.as_chunks::<3>().0;
                let step =
                    |k: usize| components.get(k).and_then(|[_, _, table]| tables.get(usize::from(*table)).copied());
                let sampled = |k: usize| components.get(k).map(|[_, factors, _]| [factors >> 4, factors & 15]);
                let [wide, high] = sampled(0)?;
                // The mean's step, and the planes' own rounding to whole numbers, once by the encoder and once by the decoder.
                let plane = |step: f64| (step * step + 2.0) / 12.0;
                let luma = plane(step(0)?);
                let squared = 255.0 * 255.0;
                if components.len() < 3 {
                    return Some(Blocks { side: 8, rounding: [luma / squared; 3] });
                }
                let [across, down] = sampled(1)?;
                let each = |all: u8, own: u8| {
                    usize::from(all).checked_div(usize::from(own)).filter(|part| (1..=4).contains(part))
                };
                let [across, down] = [each(wide, across)?, each(high, down)?];
                // A chroma sample stands for several pixels, whose mean its noise is; before and after that, pixels are rounded.
                let pixels = (across * down) as f64;
                let single = if pixels > 1.0 { 2.0 / 12.0 } else { 0.0 };
                let chroma = |k: usize| Some(pixels * plane(step(k)?) + single);
                let [cb, cr] = [chroma(1)?, chroma(2)?];
                // JFIF 1.02: R = Y + 1.402 Cr, G = Y - 0.34414 Cb - 0.71414 Cr, B = Y + 1.772 Cb.
                let rounding = [
                    luma + 1.402 * 1.402 * cr,
                    luma + 0.344_14 * 0.344_14 * cb + 0.714_14 * 0.714_14 * cr,
                    luma + 1.772 * 1.772 * cb,
                ];
                return Some(Blocks { side: 8 * across.max(down), rounding: rounding.map(|value| value / squared) });
            }
            0xda => return None,
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_gives_side_and_steps() {
        let table = |kind: u8, step: u8| [&[0xff, 0xdb, 0, 67, kind, step][..], &[9; 63]].concat();
        let frame = |factors: u8| [0xff, 0xc0, 0, 17, 8, 0, 16, 0, 16, 3, 1, factors, 0, 2, 0x11, 1, 3, 0x11, 1];
        let file = |factors: u8| [&[0xff, 0xd8][..], &table(0, 2), &table(1, 3), &frame(factors)].concat();
        let half = blocks(&file(0x22)).unwrap();
        assert_eq!(half.side, 16);
        let blue = (6.0 / 12.0 + 1.772 * 1.772 * (4.0 * 11.0 / 12.0 + 2.0 / 12.0)) / 65025.0;
        assert!((half.rounding[2] / blue - 1.0).abs() < 1e-12, "{half:?}");
        assert_eq!(blocks(&file(0x11)).unwrap().side, 8);
        for end in 0..file(0x22).len() {
            assert_eq!(blocks(&file(0x22)[..end]), None, "{end}");
        }
    }
}
