//! Colours of other primaries, brought to those that an image has here: Rec. 709 with a white of D65.

use glam::{DMat3, DVec3};

use super::Image;

/// Where red, green, blue and white lie: CIE 1931 x and y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Primaries(pub [[f64; 2]; 4]);

/// ITU-R BT.709-6, table 1.
pub(super) const REC709: Primaries = Primaries([[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]]);

/// Primaries that differ by less are written with fewer digits.
const SAME: f64 = 1e-3;

impl Primaries {
    /// Whether they are those of Rec. 709, but for the digits that files have.
    pub(super) fn is_rec709(&self) -> bool {
        self.0.as_flattened().iter().zip(REC709.0.as_flattened()).all(|(a, b)| (a - b).abs() <= SAME)
    }

    /// From these primaries to Rec. 709: white stays white, adapted by Bradford's matrix (ICC.1:2022, annex E) where it has
    /// another place. `None` where the primaries span no colours.
    pub(super) fn to_rec709(self) -> Option<DMat3> {
        let (own, target) = (self.to_xyz()?, REC709.to_xyz()?);
        let bradford = DMat3::from_cols_array(&[
            0.8951, -0.7502, 0.0389, //
            0.2664, 1.7135, -0.0685, //
            -0.1614, 0.0367, 1.0296,
        ]);
        let scale = (bradford * (target * DVec3::ONE)) / (bradford * (own * DVec3::ONE));
        let adapt = bradford.inverse() * DMat3::from_diagonal(scale) * bradford;
        let matrix = target.inverse() * adapt * own;
        matrix.is_finite().then_some(matrix)
    }

    /// SMPTE RP 177: the columns are the primaries, scaled so that their sum is the white.
    fn to_xyz(self) -> Option<DMat3> {
        let [red, green, blue, white] = self.0.map(|[x, y]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y));
        let columns = DMat3::from_cols(red, green, blue);
        let scale = columns.inverse() * white;
        let matrix = columns * DMat3::from_diagonal(scale);
        let sound = matrix.is_finite() && columns.determinant().abs() > 1e-9;
        sound.then_some(matrix)
    }
}

/// From CIE XYZ, whose white is D65, to Rec. 709.
pub(super) fn xyz_to_rec709() -> Option<DMat3> {
    REC709.to_xyz().map(|matrix| matrix.inverse())
}

/// Multiplies every pixel by `matrix`.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn convert(image: &mut Image, matrix: DMat3) {
    for pixel in &mut image.pixels {
        *pixel = (matrix * DVec3::from_array(pixel.map(f64::from))).as_vec3().to_array();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ITU-R BT.2020-2, table 3.
    const REC2020: Primaries = Primaries([[0.708, 0.292], [0.17, 0.797], [0.131, 0.046], [0.3127, 0.329]]);

    #[test]
    fn rec_2020_as_itu_r_bt_2087_has_it() {
        // ITU-R BT.2407, annex 1: the inverse of BT.2087's matrix.
        let expected = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        let found = REC2020.to_rec709().unwrap().transpose().to_cols_array_2d();
        for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
            assert!((found - expected).abs() < 1e-4, "{found} {expected}");
        }
        assert!(!REC2020.is_rec709() && REC709.is_rec709());
    }

    #[test]
    fn white_stays_white_and_degenerate_primaries_are_none() {
        // ACES (SMPTE ST 2065-1) has another white.
        let aces = Primaries([[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]]);
        let white = aces.to_rec709().unwrap() * DVec3::ONE;
        assert!((white - DVec3::ONE).length() < 1e-9, "{white}");
        assert!(Primaries([[0.3, 0.3]; 4]).to_rec709().is_none());
        assert!(Primaries([[0.0; 2]; 4]).to_rec709().is_none());
        assert!(Primaries([[f64::NAN; 2]; 4]).to_rec709().is_none());
    }

    #[test]
    fn xyz_of_d65_is_white() {
        let white = xyz_to_rec709().unwrap() * DVec3::new(0.950_456, 1.0, 1.089_058);
        assert!((white - DVec3::ONE).length() < 1e-3, "{white}");
    }
}
