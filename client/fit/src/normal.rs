//! The normal equations of a weighted least-squares fit, and steps from them.
//!
//! With residual r, derivatives J and weights W the step is -(J'WJ)^-1 J'Wr. The two products come debiased from the
//! coordinator (one factor from each half buffer), so that the render's noise does not pull the estimate; in return
//! J'WJ need not be positive definite at few samples, and is floored here.

use gonio_scene::PhotoStatistics;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// J'WJ, J'Wr and the sums of the photos that they come from.
#[derive(Debug, Clone)]
pub struct Normal {
    /// J'WJ in the coordinates asked for.
    pub matrix: DMatrix<f64>,
    /// J'Wr in the same coordinates; half the gradient of the loss.
    pub gradient: DVector<f64>,
    /// Covariance of `gradient` that is due to the render's noise.
    pub noise: DMatrix<f64>,
    /// What drawing pixels adds to the covariance of `gradient`, under the right model.
    pub draw: DMatrix<f64>,
    /// The photos' sums; its Gram matrix stays in physical units.
    pub total: PhotoStatistics,
}

impl Normal {
    /// Sums photos and goes over to coordinates by the chain rule; `slopes` are d value / d coordinate, all ones for
    /// physical units. Every Gram matrix must have `(1 + slopes.len())^2` numbers.
    #[must_use]
    pub fn new(photos: &[PhotoStatistics], slopes: &[f64]) -> Self {
        let mut total = PhotoStatistics::default();
        for photo in photos {
            total.add(photo);
        }
        let n = slopes.len();
        let gram = |i: usize, j: usize| total.gram.get(i * (n + 1) + j).copied().unwrap_or(0.0);
        let moved = |i: usize, j: usize| total.noise.get(i * (n + 1) + j).copied().unwrap_or(0.0);
        let slope = DVector::from_column_slice(slopes);
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            // Products of different halves are symmetric only in expectation.
            0.5 * (gram(i + 1, j + 1) + gram(j + 1, i + 1)) * slope[i] * slope[j]
        });
        let gradient = DVector::from_fn(n, |i, _| 0.5 * (gram(i + 1, 0) + gram(0, i + 1)) * slope[i]);
        let noise = DMatrix::from_fn(n, n, |i, j| moved(i + 1, j + 1) * slope[i] * slope[j]);
        let drawn = |i: usize, j: usize| total.draw.get(i * (n + 1) + j).copied().unwrap_or(0.0);
        let draw = DMatrix::from_fn(n, n, |i, j| drawn(i + 1, j + 1) * slope[i] * slope[j]);
        Self { matrix, gradient, noise, draw, total }
    }

    /// Observations as a float.
    #[must_use]
    pub fn observations(&self) -> f64 {
        count(self.total.observations)
    }

    /// Reduced chi-square, at least 1: by how much the squared errors of a model that does not fit exceed what the photos'
    /// noise explains.
    #[must_use]
    pub fn misfit(&self) -> f64 {
        self.total.reduced_chi_square().max(1.0)
    }

    /// The equations restricted to the parameters for which `keep` is set; the others stay where they are.
    #[must_use]
    pub fn restricted(&self, keep: &[bool]) -> Self {
        let mut copy = self.clone();
        for (i, _) in keep.iter().enumerate().filter(|(_, k)| !**k) {
            copy.matrix.row_mut(i).fill(0.0);
            copy.matrix.column_mut(i).fill(0.0);
            copy.gradient[i] = 0.0;
            copy.noise.row_mut(i).fill(0.0);
            copy.noise.column_mut(i).fill(0.0);
            copy.draw.row_mut(i).fill(0.0);
            copy.draw.column_mut(i).fill(0.0);
        }
        copy
    }

    /// The equations scaled to a unit diagonal and diagonalised.
    #[must_use]
    pub fn spectrum(&self) -> Spectrum {
        let n = self.gradient.len();
        if n == 0 {
            let none = DVector::zeros(0);
            return Spectrum {
                inverse_scale: none.clone(),
                values: none.clone(),
                vectors: DMatrix::zeros(0, 0),
                gradient: none,
            };
        }
        let largest = self.matrix.diagonal().iter().fold(0.0_f64, |m, d| m.max(*d));
        // A parameter without any effect on a pixel gets no step, instead of one that divides by zero.
        let inverse_scale =
            self.matrix.diagonal().map(|d| if d > 1e-18 * largest && d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_fn(n, n, |i, j| self.matrix[(i, j)] * inverse_scale[i] * inverse_scale[j]);
        let eigen = SymmetricEigen::new(scaled);
        let gradient = eigen.eigenvectors.transpose() * self.gradient.component_mul(&inverse_scale);
        Spectrum { inverse_scale, values: eigen.eigenvalues, vectors: eigen.eigenvectors, gradient }
    }
}

/// A symmetric scaled matrix D^-1/2 J'WJ D^-1/2 by its eigenvalues, D the diagonal of J'WJ.
#[derive(Debug, Clone)]
pub struct Spectrum {
    /// D^-1/2; 0 for a parameter that no observation depends on.
    pub inverse_scale: DVector<f64>,
    /// Eigenvalues; negative ones are noise.
    pub values: DVector<f64>,
    /// Eigenvectors, in columns, of the scaled matrix.
    pub vectors: DMatrix<f64>,
    /// J'Wr in the eigenvectors' frame.
    gradient: DVector<f64>,
}

impl Spectrum {
    /// Eigenvalues below this are not told from zero: rounding, or the size that noise has shown by a negative one.
    fn floor(&self) -> f64 {
        self.values.iter().fold(1e-10, |floor, v| floor.max(-2.0 * v))
    }

    /// Eigenvalues as far as they can be trusted.
    fn floored(&self) -> DVector<f64> {
        let floor = self.floor();
        self.values.map(|v| v.max(floor))
    }

    /// The step -(J'WJ + damping D)^-1 J'Wr (Levenberg 1944, Marquardt 1963).
    #[must_use]
    pub fn step(&self, damping: f64) -> DVector<f64> {
        let along = self.gradient.component_div(&self.floored().add_scalar(damping));
        -(&self.vectors * along).component_mul(&self.inverse_scale)
    }

    /// r'WJ (J'WJ)^-1 J'Wr: the square of the undamped step in standard errors (Newton's decrement), which is also the
    /// decrease of chi-square that the step promises.
    #[must_use]
    pub fn decrement(&self) -> f64 {
        self.gradient.iter().zip(self.floored().iter()).map(|(g, v)| g * g / v).sum()
    }

    /// (J'WJ)^-1: the covariance of the estimate under the weights' noise.
    #[must_use]
    pub fn covariance(&self) -> DMatrix<f64> {
        let n = self.values.len();
        let inverse = DMatrix::from_diagonal(&self.floored().map(|v| 1.0 / v));
        let scaled = &self.vectors * inverse * self.vectors.transpose();
        DMatrix::from_fn(n, n, |i, j| scaled[(i, j)] * self.inverse_scale[i] * self.inverse_scale[j])
    }
}

/// A count as a float; counts of pixels stay far below 2^53.
#[allow(clippy::cast_precision_loss)]
pub(crate) fn count(n: u64) -> f64 {
    n as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Statistics of exact residuals and derivatives with unit weights.
    fn exact(residuals: &[f64], columns: &[Vec<f64>]) -> PhotoStatistics {
        let all: Vec<&[f64]> = std::iter::once(residuals).chain(columns.iter().map(Vec::as_slice)).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let gram: Vec<f64> = all.iter().flat_map(|a| all.iter().map(|b| dot(a, b))).collect();
        let observations = residuals.len() as u64;
        PhotoStatistics { observations, noise_floor: residuals.len() as f64, gram, ..PhotoStatistics::default() }
    }

    #[test]
    fn one_step_solves_a_straight_line_whatever_the_coordinates() {
        let x = [0.0, 1.0, 2.0, 5.0];
        let residuals: Vec<f64> = x.iter().map(|x| 3.0 - 2.0 * x).collect();
        let photo = exact(&residuals, &[vec![1.0; 4], x.to_vec()]);
        for slopes in [[1.0, 1.0], [1e-4, 30.0]] {
            let spectrum = Normal::new(std::slice::from_ref(&photo), &slopes).spectrum();
            let step = spectrum.step(0.0);
            assert!((step[0] * slopes[0] + 3.0).abs() < 1e-9 && (step[1] * slopes[1] - 2.0).abs() < 1e-9);
            assert!((spectrum.decrement() - photo.gram[0]).abs() < 1e-9 * photo.gram[0]);
        }
    }

    #[test]
    fn the_covariance_inverts_the_matrix() {
        let photo = exact(&[1.0, 0.0, 0.0], &[vec![1.0, 2.0, 3.0], vec![0.5, -1.0, 4.0]]);
        let normal = Normal::new(&[photo], &[1.0, 1.0]);
        let product = normal.spectrum().covariance() * &normal.matrix;
        assert!((product - DMatrix::identity(2, 2)).norm() < 1e-10);
    }

    #[test]
    fn a_parameter_without_effect_gets_no_step() {
        let photo = exact(&[1.0, 2.0], &[vec![1.0, 1.0], vec![0.0, 0.0]]);
        let step = Normal::new(&[photo], &[1.0, 1.0]).spectrum().step(0.0);
        assert_eq!(step[1], 0.0);
        assert!((step[0] + 1.5).abs() < 1e-12);
    }

    #[test]
    fn a_negative_eigenvalue_bounds_the_step() {
        let mut photo = exact(&[1.0, 1.0], &[vec![1.0, 0.0], vec![0.0, 1.0]]);
        // Correlation above 1: impossible but for noise.
        (photo.gram[5], photo.gram[7]) = (1.1, 1.1);
        let spectrum = Normal::new(&[photo], &[1.0, 1.0]).spectrum();
        assert!(spectrum.values.iter().any(|v| *v < 0.0));
        assert!(spectrum.decrement() > 0.0 && spectrum.step(0.0).amax() < 100.0);
    }
}
