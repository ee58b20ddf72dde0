//! The part of an image from which the response is learnt.

use std::str::FromStr;

/// A rectangle of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Region {
    /// All of it.
    All,
    /// The middle, as a part (0..1] of width and height; of the front half where the image is equirectangular (twice as
    /// wide as high), because a lens's fall-off is least there (Iversen, Wilm and Kraft, IROS 2019).
    Central(f64),
}

impl Region {
    /// First column, first row, end of columns, end of rows.
    pub fn bounds(self, width: usize, height: usize) -> [usize; 4] {
        let Self::Central(part) = self else { return [0, 0, width, height] };
        let across = if width == 2 * height { width as f64 / 2.0 } else { width as f64 };
        let span = |middle: usize, size: f64| {
            let half = (0.5 * size * part).max(4.0);
            let centre = middle as f64 / 2.0;
            ((centre - half).max(0.0) as usize, ((centre + half).ceil() as usize).min(middle))
        };
        let ((left, right), (top, bottom)) = (span(width, across), span(height, height as f64));
        [left, top, right, bottom]
    }
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mend = "write `all`, or `central:PART` with a part above 0 and at most 1, such as central:0.25";
        if text == "all" {
            return Ok(Self::All);
        }
        let part = text.strip_prefix("central:").and_then(|part| part.parse::<f64>().ok()).ok_or(mend)?;
        if part > 0.0 && part <= 1.0 { Ok(Self::Central(part)) } else { Err(mend.to_owned()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_central_quarter_of_a_panorama_lies_in_its_front_half() {
        assert_eq!(Region::Central(0.25).bounds(800, 400), [350, 150, 450, 250]);
        assert_eq!(Region::Central(0.25).bounds(400, 400), [150, 150, 250, 250]);
        assert_eq!(Region::All.bounds(40, 30), [0, 0, 40, 30]);
        assert!("central:0".parse::<Region>().is_err());
        assert_eq!("central:0.5".parse(), Ok(Region::Central(0.5)));
    }
}
