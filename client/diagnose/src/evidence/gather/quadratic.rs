//! Sums over photos as a quadratic in the parameters: chi-square(theta) = e'e + 2 theta'g + theta'H theta.

use gonio_scene::PhotoStatistics;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Directions whose curvature, after the others are projected out, is below this part of what it was before, are not
/// determined: rounding and the render's noise are as large.
const DETERMINED: f64 = 1e-4;

/// Part of all photos' information that stays when one is left out.
const KEPT: f64 = 0.05;

/// One photo's, or several photos', chi-square as a function of the parameters' moves.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// J'We.
    pub gradient: DVector<f64>,
    /// J'WJ.
    pub matrix: DMatrix<f64>,
    /// Covariance of `gradient` that is due to the render's noise.
    pub noise: DMatrix<f64>,
}

impl Quadratic {
    /// From a photo's Gram matrix, of these columns (counted without the residual), each times a factor.
    #[must_use]
    pub fn new(photo: &PhotoStatistics, columns: &[(usize, f64)]) -> Self {
        let side = libm::sqrt(photo.gram.len() as f64) as usize;
        let at = |i: usize, j: usize| photo.gram.get(i * side + j).copied().unwrap_or(0.0);
        let n = columns.len();
        let gradient = DVector::from_fn(n, |i, _| columns[i].1 * at(1 + columns[i].0, 0));
        let matrix =
            DMatrix::from_fn(n, n, |i, j| columns[i].1 * columns[j].1 * at(1 + columns[i].0, 1 + columns[j].0));
        let moved = |i: usize, j: usize| photo.noise.get(i * side + j).copied().unwrap_or(0.0);
        let noise =
            DMatrix::from_fn(n, n, |i, j| columns[i].1 * columns[j].1 * moved(1 + columns[i].0, 1 + columns[j].0));
        Self { gradient, matrix, noise }
    }

    /// The sum of several.
    #[must_use]
    pub fn sum<'a>(all: impl IntoIterator<Item = &'a Self>) -> Option<Self> {
        let mut all = all.into_iter();
        let first = all.next()?.clone();
        Some(all.fold(first, |sum, q| Self {
            gradient: sum.gradient + &q.gradient,
            matrix: sum.matrix + &q.matrix,
            noise: sum.noise + &q.noise,
        }))
    }

    /// This sum over photos where it also knows [`KEPT`] of what all of them know: one photo may be the only one that
    /// determines a direction (the sharpest highlight), and without it a fit would go where no quadratic holds.
    #[must_use]
    pub fn reminded_of(self, all: &Self) -> Self {
        Self { matrix: self.matrix + KEPT * &all.matrix, ..self }
    }

    /// The change of chi-square by a move.
    #[must_use]
    pub fn change(&self, step: &DVector<f64>) -> f64 {
        2.0 * step.dot(&self.gradient) + step.dot(&(&self.matrix * step))
    }

    /// What is left of the columns from `own` on once the first `own` are fitted: gradient D'Me and matrix D'MD.
    #[must_use]
    pub fn projected(&self, own: usize) -> Self {
        let n = self.gradient.len() - own;
        if own == 0 {
            return self.clone();
        }
        let head = self.matrix.view((0, 0), (own, own)).into_owned();
        let cross = self.matrix.view((own, 0), (n, own)).into_owned();
        let inverse = pseudo_inverse(&head, 1e-10);
        let through = &cross * inverse;
        let gradient = self.gradient.rows(own, n) - &through * self.gradient.rows(0, own);
        let matrix = self.matrix.view((own, own), (n, n)) - &through * cross.transpose();
        let beside = &through * self.noise.view((0, own), (own, n));
        let noise = self.noise.view((own, own), (n, n)) - &beside - beside.transpose()
            + &through * self.noise.view((0, 0), (own, own)) * through.transpose();
        Self { gradient, matrix, noise }
    }

    /// The move to the minimum: -(J'WJ)^-1 J'We in the determined directions, none in the others; and their number.
    ///
    /// `before` is the diagonal that the matrix had before anything was projected out of it.
    #[must_use]
    pub fn minimum(&self, before: &DVector<f64>) -> (DVector<f64>, usize) {
        let n = self.gradient.len();
        let largest = before.iter().fold(0.0_f64, |m, d| m.max(*d));
        let inverse = before.map(|d| if d > 1e-18 * largest && d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
        if n == 0 || largest <= 0.0 {
            return (DVector::zeros(n), 0);
        }
        let scaled = DMatrix::from_fn(n, n, |i, j| self.matrix[(i, j)] * inverse[i] * inverse[j]);
        let eigen = SymmetricEigen::new(scaled);
        let floor = eigen.eigenvalues.iter().fold(DETERMINED, |f, v| f.max(-2.0 * v));
        let along = eigen.eigenvectors.transpose() * self.gradient.component_mul(&inverse);
        let mut rank = 0;
        let step = DVector::from_fn(n, |i, _| {
            if eigen.eigenvalues[i] > floor {
                rank += 1;
                -along[i] / eigen.eigenvalues[i]
            } else {
                0.0
            }
        });
        ((&eigen.eigenvectors * step).component_mul(&inverse), rank)
    }

    /// The move to the minimum of all columns.
    #[must_use]
    pub fn solve(&self) -> DVector<f64> {
        self.minimum(&self.matrix.diagonal()).0
    }

    /// What g'H^-1 g comes to per degree of freedom where only noise moves the gradient g: 1 for the photos' own, whose covariance
    /// is H, and the mean of H^-1 N for the render's.
    #[must_use]
    pub fn dispersion(&self) -> f64 {
        let n = self.gradient.len();
        let inverse = pseudo_inverse(&self.matrix, DETERMINED);
        1.0 + (inverse * &self.noise).trace().max(0.0) / (n as f64).max(1.0)
    }

    /// The columns in `keep`.
    #[must_use]
    pub fn select(&self, keep: &[usize]) -> Self {
        let n = keep.len();
        Self {
            gradient: DVector::from_fn(n, |i, _| self.gradient[keep[i]]),
            matrix: DMatrix::from_fn(n, n, |i, j| self.matrix[(keep[i], keep[j])]),
            noise: DMatrix::from_fn(n, n, |i, j| self.noise[(keep[i], keep[j])]),
        }
    }
}

/// The inverse of a symmetric matrix on the eigenvectors, after scaling to a unit diagonal, above `floor`.
pub fn pseudo_inverse(matrix: &DMatrix<f64>, floor: f64) -> DMatrix<f64> {
    let n = matrix.nrows();
    let scale = matrix.diagonal().map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let eigen = SymmetricEigen::new(scaled);
    let floor = eigen.eigenvalues.iter().fold(floor, |f, v| f.max(-2.0 * v));
    let inverse = eigen.eigenvalues.map(|v| if v > floor { 1.0 / v } else { 0.0 });
    let full = &eigen.eigenvectors * DMatrix::from_diagonal(&inverse) * eigen.eigenvectors.transpose();
    DMatrix::from_fn(n, n, |i, j| full[(i, j)] * scale[i] * scale[j])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Statistics of exact residuals and derivatives with unit weights.
    fn exact(residuals: &[f64], columns: &[Vec<f64>]) -> PhotoStatistics {
        let all: Vec<&[f64]> = std::iter::once(residuals).chain(columns.iter().map(Vec::as_slice)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let gram: Vec<f64> = all.iter().flat_map(|a| all.iter().map(|b| dot(a, b))).collect();
        PhotoStatistics { gram, ..PhotoStatistics::default() }
    }

    #[test]
    fn projecting_out_leaves_what_a_joint_fit_finds() {
        let (one, x) = (vec![1.0; 4], vec![0.0, 1.0, 2.0, 4.0]);
        let residuals: Vec<f64> = x.iter().map(|x| 5.0 - 3.0 * x).collect();
        let photo = exact(&residuals, &[one, x]);
        let q = Quadratic::new(&photo, &[(0, 1.0), (1, 1.0)]);
        let joint = q.solve();
        assert!((joint[0] + 5.0).abs() < 1e-9 && (joint[1] - 3.0).abs() < 1e-9);
        assert!((q.change(&joint) + photo.gram[0]).abs() < 1e-9);
        let d = q.projected(1);
        let (step, rank) = d.minimum(&q.matrix.diagonal().rows(1, 1).into_owned());
        assert_eq!(rank, 1);
        assert!((step[0] - 3.0).abs() < 1e-9);
    }

    #[test]
    fn a_column_that_the_model_has_already_is_not_determined() {
        let photo = exact(&[1.0, 2.0, 0.5], &[vec![1.0, 1.0, 1.0], vec![2.0, 2.0, 2.0]]);
        let q = Quadratic::new(&photo, &[(0, 1.0), (1, 1.0)]);
        let (step, rank) = q.projected(1).minimum(&q.matrix.diagonal().rows(1, 1).into_owned());
        assert_eq!((step[0], rank), (0.0, 0));
    }
}
