//! A function of the angle to the normal and its parameter derivatives, tabulated for fast evaluation.

use super::dual::Dual;

/// Intervals of a smooth table, equal in `sqrt(cos)` so that grazing angles are resolved.
const INTERVALS: usize = 64;
/// The cosine that stands for grazing, where the integrals have finite limits but divide by zero.
const GRAZING: f64 = 1e-7;

/// Cubic polynomial `c0 + c1 t + c2 t^2 + c3 t^3` on one interval, `t` in `[0, 1]`.
type Cubic = [f32; 4];

/// A function of `cos(theta)` with its derivatives with respect to alpha and index of refraction.
///
/// Each is a piecewise polynomial. Those are linear in the values at their nodes, so interpolating the derivatives gives
/// the derivatives of the interpolation.
#[derive(Clone, Debug)]
pub struct AngularTable {
    axis: Axis,
    // One block per interval: value, d/d alpha, d/d ior. Evaluating all three touches one cache line.
    intervals: Box<[[Cubic; 3]]>,
}

/// The variable in which intervals are equal.
#[derive(Clone, Copy, Debug)]
enum Axis {
    Cosine,
    RootOfCosine,
}

impl AngularTable {
    /// A C2 cubic spline in `sqrt(cos)` of a smooth `function` of the cosine, defined on `(0, 1]`.
    pub fn smooth(function: impl Fn(f64) -> Dual) -> Self {
        let samples: Vec<Dual> = (0..=INTERVALS)
            .map(|i| {
                let x = i as f64 / INTERVALS as f64;
                function((x * x).max(GRAZING))
            })
            .collect();
        Self::interpolate(Axis::RootOfCosine, &samples, spline)
    }

    /// Linear between `samples` at equally spaced cosines from 0 to 1, at least two.
    pub fn linear(samples: &[Dual]) -> Self {
        Self::interpolate(Axis::Cosine, samples, |values| {
            values.windows(2).map(|pair| [pair[0] as f32, (pair[1] - pair[0]) as f32, 0.0, 0.0]).collect()
        })
    }

    fn interpolate(axis: Axis, samples: &[Dual], rule: impl Fn(&[f64]) -> Vec<Cubic>) -> Self {
        let cubics = |part: fn(&Dual) -> f64| rule(&samples.iter().map(part).collect::<Vec<_>>());
        let (value, d_alpha, d_ior) = (cubics(|s| s.value), cubics(|s| s.d_alpha), cubics(|s| s.d_ior));
        let intervals = value.into_iter().zip(d_alpha).zip(d_ior).map(|((v, a), n)| [v, a, n]).collect();
        Self { axis, intervals }
    }

    /// The function at `cos` in `[0, 1]`.
    #[inline]
    pub fn value(&self, cos: f32) -> f32 {
        let (block, t) = self.locate(cos);
        horner(&block[0], t)
    }

    /// The function, its derivative with respect to alpha, and with respect to the index of refraction.
    #[inline]
    pub fn value_and_derivatives(&self, cos: f32) -> [f32; 3] {
        let (block, t) = self.locate(cos);
        [horner(&block[0], t), horner(&block[1], t), horner(&block[2], t)]
    }

    #[inline]
    fn locate(&self, cos: f32) -> (&[Cubic; 3], f32) {
        const OUTSIDE: &[Cubic; 3] = &[[0.0; 4]; 3];
        let cos = cos.clamp(0.0, 1.0);
        let x = match self.axis {
            Axis::Cosine => cos,
            Axis::RootOfCosine => cos.sqrt(),
        } * self.intervals.len() as f32;
        let index = (x as usize).min(self.intervals.len().saturating_sub(1));
        // The index is in range by construction; `get` spares the panic path.
        (self.intervals.get(index).unwrap_or(OUTSIDE), x - index as f32)
    }
}

#[inline]
fn horner(c: &Cubic, t: f32) -> f32 {
    c[0] + t * (c[1] + t * (c[2] + t * c[3]))
}

/// Coefficients of the C2 cubic spline through equally spaced values.
///
/// The slope is zero at the first node (the functions are smooth in `cos`, hence flat in its square root at 0) and that of
/// the cubic through the last four at the last node.
fn spline(values: &[f64]) -> Vec<Cubic> {
    let n = values.len();
    let at = |i: usize| values.get(i).copied().unwrap_or_default();
    let mut slopes = vec![0.0; n];
    slopes[n - 1] = (11.0 * at(n - 1) - 18.0 * at(n - 2) + 9.0 * at(n - 3) - 2.0 * at(n - 4)) / 6.0;
    // Thomas algorithm on  s[i-1] + 4 s[i] + s[i+1] = 3 (v[i+1] - v[i-1]).
    let mut upper = vec![0.0; n];
    for i in 1..n - 1 {
        let mut right = 3.0 * (at(i + 1) - at(i - 1));
        if i == n - 2 {
            right -= slopes[n - 1];
        }
        let pivot = 1.0 / (4.0 - upper[i - 1]);
        upper[i] = pivot;
        slopes[i] = (right - slopes[i - 1]) * pivot;
    }
    for i in (1..n - 2).rev() {
        slopes[i] -= upper[i] * slopes[i + 1];
    }
    (0..n - 1)
        .map(|i| {
            let (rise, s0, s1) = (at(i + 1) - at(i), slopes[i], slopes[i + 1]);
            [at(i), s0, 3.0 * rise - 2.0 * s0 - s1, s0 + s1 - 2.0 * rise].map(|c| c as f32)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polynomial of degree 1 in the cosine is one of degree 2 in its root: the spline must carry it exactly.
    #[test]
    fn reproduces_a_parabola() {
        let table = AngularTable::smooth(|c| Dual { value: 1.0 - 0.5 * c, d_alpha: c, d_ior: 3.0 });
        for i in 0..=1000 {
            let cos = i as f32 / 1000.0;
            let [value, d_alpha, d_ior] = table.value_and_derivatives(cos);
            assert!((value - (1.0 - 0.5 * cos)).abs() < 1e-6);
            assert!((d_alpha - cos).abs() < 1e-6);
            assert!((d_ior - 3.0).abs() < 1e-6);
            assert_eq!(value, table.value(cos));
        }
    }

    #[test]
    fn is_linear_between_samples() {
        let table = AngularTable::linear(&[1.0, 3.0, 2.0].map(Dual::constant));
        for (cos, value) in [(0.0, 1.0), (0.25, 2.0), (0.5, 3.0), (0.875, 2.25), (1.0, 2.0)] {
            assert_eq!(table.value_and_derivatives(cos), [value, 0.0, 0.0]);
        }
    }

    #[test]
    fn is_fourth_order_inside() {
        let table = AngularTable::smooth(|c| Dual::constant(libm::sin(6.0 * c.sqrt()) - 6.0 * c.sqrt()));
        let worst = (0..=5000)
            .map(|i| {
                let x = f64::from(i) / 5000.0;
                let exact = libm::sin(6.0 * x) - 6.0 * x;
                (f64::from(table.value((x * x) as f32)) - exact).abs()
            })
            .fold(0.0, f64::max);
        // 5/384 h^4 f'''' is 1e-6; the slope at the end adds as much, and f32 an epsilon.
        assert!(worst < 4e-6, "{worst}");
    }
}
