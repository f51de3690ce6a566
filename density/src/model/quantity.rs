//! The types over which equations of motion are written.
//!
//! A model's equations are a generic function of a [`Quantity`], so that the same lines serve three purposes: plain
//! numbers give a rate, [`Dual`] numbers give its derivative, and [`crate::flow::equations::Term`]s give a record of
//! the operations, from which the integrator makes Taylor series.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or something that can be computed with like a number.
pub trait Quantity:
    Copy
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// A whole power.
    fn powi(self, exponent: i32) -> Self;

    /// Square root of a positive quantity.
    fn sqrt(self) -> Self;

    /// Sine and cosine of an angle \[rad\].
    fn sin_cos(self) -> (Self, Self);

    /// The number by itself; NaN where no numbers are known, but operations are recorded.
    fn number(self) -> f64;
}

impl Quantity for f64 {
    #[inline]
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }

    #[inline]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }

    #[inline]
    fn number(self) -> f64 {
        self
    }
}

/// A number and its derivative with respect to some variable: forward differentiation, exact to rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    /// The number.
    pub value: f64,
    /// Its derivative.
    pub derivative: f64,
}

impl Dual {
    /// From a number and its derivative.
    pub fn new(value: f64, derivative: f64) -> Self {
        Self { value, derivative }
    }
}

impl From<f64> for Dual {
    fn from(value: f64) -> Self {
        Self::new(value, 0.0)
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.value, -self.derivative)
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.value + other.value, self.derivative + other.derivative)
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.value - other.value, self.derivative - other.derivative)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.value * other.value, self.derivative * other.value + self.value * other.derivative)
    }
}

impl Div for Dual {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Self::new(value, (self.derivative - value * other.derivative) / other.value)
    }
}

/// Implements an operation with a plain number on the right by turning the number into a quantity.
macro_rules! with_plain_number {
    ([$($lifetime:tt)*] $quantity:ty, $operation:ident, $method:ident) => {
        impl<$($lifetime)*> std::ops::$operation<f64> for $quantity {
            type Output = Self;
            fn $method(self, number: f64) -> Self {
                std::ops::$operation::$method(self, Self::from(number))
            }
        }
    };
}
pub(crate) use with_plain_number;

with_plain_number!([] Dual, Add, add);
with_plain_number!([] Dual, Sub, sub);
with_plain_number!([] Dual, Mul, mul);
with_plain_number!([] Dual, Div, div);

impl Quantity for Dual {
    fn powi(self, exponent: i32) -> Self {
        let slope = f64::from(exponent) * self.value.powi(exponent - 1);
        Self::new(self.value.powi(exponent), slope * self.derivative)
    }

    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Self::new(root, 0.5 * self.derivative / root)
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.value.sin_cos();
        (Self::new(sin, cos * self.derivative), Self::new(cos, -sin * self.derivative))
    }

    fn number(self) -> f64 {
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivative_of_an_expression_is_its_difference_quotient() {
        fn expression<T: Quantity>(x: T) -> T {
            let (sin, cos) = (x * 2.0).sin_cos();
            (x.powi(3) / (cos + 3.0) - sin).sqrt() - -x
        }
        let (x, h) = (1.7, 1e-6);
        let quotient = (expression(x + h) - expression(x - h)) / (2.0 * h);
        let dual = expression(Dual::new(x, 1.0));
        assert_eq!(dual.value, expression(x));
        assert!((dual.derivative - quotient).abs() < 1e-8, "{} {quotient}", dual.derivative);
    }
}
