//! Dual numbers: a value carried together with its derivatives, for the tables built once per material.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number and its derivatives with respect to the two parameters of a rough dielectric boundary.
///
/// Arithmetic on duals applies the chain rule (forward-mode automatic differentiation, Griewank & Walther 2008), so a
/// quadrature written once gives its integral and the exact derivatives of that quadrature.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dual {
    /// The number itself.
    pub value: f64,
    /// Derivative with respect to the GGX alpha.
    pub d_alpha: f64,
    /// Derivative with respect to the index of refraction.
    pub d_ior: f64,
}

impl Dual {
    /// A number that depends on neither parameter.
    pub const fn constant(value: f64) -> Self {
        Self { value, d_alpha: 0.0, d_ior: 0.0 }
    }

    /// The parameter alpha at `value`.
    pub const fn alpha(value: f64) -> Self {
        Self { value, d_alpha: 1.0, d_ior: 0.0 }
    }

    /// The parameter index of refraction at `value`.
    pub const fn ior(value: f64) -> Self {
        Self { value, d_alpha: 0.0, d_ior: 1.0 }
    }

    /// Square root; `self` must be positive for the derivatives to be finite.
    pub fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }

    /// `self * self`.
    pub fn square(self) -> Self {
        self * self
    }

    fn chain(self, value: f64, slope: f64) -> Self {
        Self { value, d_alpha: slope * self.d_alpha, d_ior: slope * self.d_ior }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, d_alpha: self.d_alpha + other.d_alpha, d_ior: self.d_ior + other.d_ior }
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, d_alpha: self.d_alpha - other.d_alpha, d_ior: self.d_ior - other.d_ior }
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            d_alpha: self.d_alpha * other.value + self.value * other.d_alpha,
            d_ior: self.d_ior * other.value + self.value * other.d_ior,
        }
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let inverse = 1.0 / other.value;
        let value = self.value * inverse;
        Self {
            value,
            d_alpha: (self.d_alpha - value * other.d_alpha) * inverse,
            d_ior: (self.d_ior - value * other.d_ior) * inverse,
        }
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Add<f64> for Dual {
    type Output = Self;
    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl Sub<f64> for Dual {
    type Output = Self;
    fn sub(self, other: f64) -> Self {
        self + -other
    }
}

impl Mul<f64> for Dual {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}
