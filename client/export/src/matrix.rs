//! 4x4 matrices, row-major, acting on column vectors.

/// A matrix.
pub type Matrix = [[f64; 4]; 4];

/// The matrix product `a b`.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// A diagonal matrix with 1 in its last place.
pub fn diagonal([x, y, z]: [f64; 3]) -> Matrix {
    [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0], [0.0, 0.0, 0.0, 1.0]]
}

/// The point `p` moved by `m`.
pub fn point(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3])
}

/// The direction `d` turned by `m`.
pub fn direction(m: &Matrix, d: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| m[i][0] * d[0] + m[i][1] * d[1] + m[i][2] * d[2])
}

/// `m` without its translation.
pub fn rotation(m: &Matrix) -> Matrix {
    let mut turned = *m;
    turned.iter_mut().for_each(|row| row[3] = 0.0);
    turned[3][3] = 1.0;
    turned
}

/// The inverse of a rigid motion.
pub fn rigid_inverse(m: &Matrix) -> Matrix {
    let mut inverse = [0, 1, 2, 3].map(|i| [0, 1, 2, 3].map(|j| if i < 3 && j < 3 { m[j][i] } else { 0.0 }));
    let shift = direction(&inverse, [m[0][3], m[1][3], m[2][3]]);
    inverse.iter_mut().zip(shift).for_each(|(row, shift)| row[3] = -shift);
    inverse[3][3] = 1.0;
    inverse
}

/// The turn about z by `angle` radians, from x towards y.
pub fn about_z(angle: f64) -> Matrix {
    let (sin, cos) = libm::sincos(angle);
    [[cos, -sin, 0.0, 0.0], [sin, cos, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
}

/// `m`'s numbers column by column: the order of glTF and pbrt, and of USD's row vectors.
pub fn columns(m: &Matrix) -> [f64; 16] {
    std::array::from_fn(|i| m[i % 4][i / 4])
}

/// A unit vector along `v`.
pub fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

/// The cross product.
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A rotation that carries the z axis to the unit vector `z`.
pub fn with_z(z: [f64; 3]) -> Matrix {
    let aside = if z[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let x = unit(cross(aside, z));
    let y = cross(z, x);
    let row = |i: usize| [x[i], y[i], z[i], 0.0];
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rigid_motion_and_its_inverse_are_nothing() {
        let mut m = product(&about_z(0.7), &with_z(unit([1.0, -2.0, 0.5])));
        (m[0][3], m[1][3], m[2][3]) = (0.3, -4.0, 2.0);
        let nothing = product(&m, &rigid_inverse(&m));
        for (i, row) in nothing.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                assert!((entry - f64::from(u8::from(i == j))).abs() < 1e-14, "{nothing:?}");
            }
        }
        let z = direction(&m, [0.0, 0.0, 1.0]);
        assert!((z.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-15);
        assert_eq!(columns(&m)[12..], [0.3, -4.0, 2.0, 1.0]);
    }
}
