//! The Taylor series of any model, from its equations of motion alone.
//!
//! A model's [`Model::rate`] is run once over [`Term`]s, which record the operations that the rate is made of. For
//! every operation, a recurrence gives the Taylor coefficient of order `n` of the result from the coefficients of its
//! operands up to order `n` (Jorba & Zou, Exp. Math. 14, 2005, Prop. 2.1):
//!
//! ```text
//! c = a b       c_n = Σ_{j=0..n} a_j b_{n-j}
//! c = a/b       c_n = (a_n - Σ_{j=1..n} b_j c_{n-j})/b_0
//! c = sqrt(a)   c_n = (a_n - Σ_{j=1..n-1} c_j c_{n-j})/(2 c_0)
//! s = sin(a)    s_n =  1/n Σ_{j=1..n} j a_j c_{n-j}      c = cos(a)    c_n = -1/n Σ_{j=1..n} j a_j s_{n-j}
//! ```
//!
//! and the state follows by `x_{n+1} = rate_n/(n + 1)`. A recurrence written by hand is faster: it shares more between
//! its products, keeps its coefficients in the first cache and need not look up which operation comes next. The paper's
//! model by its own recurrence is seven times as fast as the model with the Sun and the Moon by its equations
//! (`flow_sun_moon_to_1e_12` of the benchmarks).

use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::model::Quantity;
use crate::model::quantity::with_plain_number;

#[cfg(doc)]
use crate::model::Model;

/// Index of the Taylor coefficients of a quantity.
pub(super) type Slot = usize;

/// An operation on quantities, each of which is in a slot; its result goes into the next free slot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Operation {
    Sum(Slot, Slot),
    Difference(Slot, Slot),
    Product(Slot, Slot),
    Quotient(Slot, Slot),
    /// A plain number divided by a quantity.
    Inverse(f64, Slot),
    /// A quantity times a plain number.
    Scaled(Slot, f64),
    /// A quantity plus a plain number.
    Shifted(Slot, f64),
    Root(Slot),
    /// The sine; the cosine of the same angle follows.
    Sine(Slot),
    /// The cosine of the angle whose sine is in the slot before.
    Cosine(Slot),
}

/// The operations recorded so far, in the order in which they were made.
#[derive(Debug)]
pub(super) struct Recorder {
    /// Number of slots of the time and the state.
    inputs: usize,
    operations: RefCell<Vec<Operation>>,
}

/// A quantity whose operations are recorded.
#[derive(Debug, Clone, Copy)]
pub struct Term<'a>(Content<'a>);

#[derive(Debug, Clone, Copy)]
enum Content<'a> {
    Number(f64),
    Recorded(&'a Recorder, Slot),
}

/// A quantity after recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Outcome {
    Number(f64),
    In(Slot),
}

impl Recorder {
    pub(super) fn new(inputs: usize) -> Self {
        Self { inputs, operations: RefCell::default() }
    }

    /// The quantity in one of the first slots.
    pub(super) fn input(&self, slot: Slot) -> Term<'_> {
        Term(Content::Recorded(self, slot))
    }

    fn record(&self, operation: Operation) -> Term<'_> {
        let mut operations = self.operations.borrow_mut();
        operations.push(operation);
        Term(Content::Recorded(self, self.inputs + operations.len() - 1))
    }

    /// The slot of a recorded quantity.
    pub(super) fn slot(&self, term: Term<'_>) -> Slot {
        match term.outcome() {
            Outcome::In(slot) => slot,
            Outcome::Number(_) => 0,
        }
    }

    /// Number of operations so far.
    pub(super) fn len(&self) -> usize {
        self.operations.borrow().len()
    }

    pub(super) fn into_operations(self) -> Vec<Operation> {
        self.operations.into_inner()
    }
}

impl Term<'_> {
    pub(super) fn outcome(self) -> Outcome {
        match self.0 {
            Content::Number(number) => Outcome::Number(number),
            Content::Recorded(_, slot) => Outcome::In(slot),
        }
    }
}

impl From<f64> for Term<'_> {
    fn from(number: f64) -> Self {
        Self(Content::Number(number))
    }
}

impl Neg for Term<'_> {
    type Output = Self;
    fn neg(self) -> Self {
        self * Self::from(-1.0)
    }
}

impl<'a> Add for Term<'a> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        use Content::{Number, Recorded};
        match (self.0, other.0) {
            (Number(a), Number(b)) => Self::from(a + b),
            (Recorded(recorder, a), Recorded(_, b)) => recorder.record(Operation::Sum(a, b)),
            (Recorded(recorder, a), Number(b)) | (Number(b), Recorded(recorder, a)) => {
                recorder.record(Operation::Shifted(a, b))
            }
        }
    }
}

impl Sub for Term<'_> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match (self.0, other.0) {
            (Content::Recorded(recorder, a), Content::Recorded(_, b)) => recorder.record(Operation::Difference(a, b)),
            _ => self + -other,
        }
    }
}

impl Mul for Term<'_> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        use Content::{Number, Recorded};
        match (self.0, other.0) {
            (Number(a), Number(b)) => Self::from(a * b),
            (Recorded(recorder, a), Recorded(_, b)) => recorder.record(Operation::Product(a, b)),
            (Recorded(recorder, a), Number(b)) | (Number(b), Recorded(recorder, a)) => {
                recorder.record(Operation::Scaled(a, b))
            }
        }
    }
}

impl Div for Term<'_> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        use Content::{Number, Recorded};
        match (self.0, other.0) {
            (Number(a), Number(b)) => Self::from(a / b),
            (Recorded(recorder, a), Recorded(_, b)) => recorder.record(Operation::Quotient(a, b)),
            (Recorded(recorder, a), Number(b)) => recorder.record(Operation::Scaled(a, 1.0 / b)),
            (Number(a), Recorded(recorder, b)) => recorder.record(Operation::Inverse(a, b)),
        }
    }
}

with_plain_number!(['a] Term<'a>, Add, add);
with_plain_number!(['a] Term<'a>, Sub, sub);
with_plain_number!(['a] Term<'a>, Mul, mul);
with_plain_number!(['a] Term<'a>, Div, div);

impl Quantity for Term<'_> {
    /// By repeated squaring, so that the result is also right where the quantity is 0.
    fn powi(self, exponent: i32) -> Self {
        if exponent < 0 {
            return Self::from(1.0) / self.powi(-exponent);
        }
        let half = || self.powi(exponent / 2);
        match (exponent, exponent % 2) {
            (0, _) => Self::from(1.0),
            (1, _) => self,
            (_, 0) => {
                let half = half();
                half * half
            }
            _ => self * self.powi(exponent - 1),
        }
    }

    fn sqrt(self) -> Self {
        match self.0 {
            Content::Number(number) => Self::from(number.sqrt()),
            Content::Recorded(recorder, slot) => recorder.record(Operation::Root(slot)),
        }
    }

    fn sin_cos(self) -> (Self, Self) {
        match self.0 {
            Content::Number(number) => {
                let (sin, cos) = number.sin_cos();
                (Self::from(sin), Self::from(cos))
            }
            Content::Recorded(recorder, slot) => {
                let sine = recorder.record(Operation::Sine(slot));
                (sine, recorder.record(Operation::Cosine(slot)))
            }
        }
    }

    fn number(self) -> f64 {
        match self.0 {
            Content::Number(number) => number,
            Content::Recorded(..) => f64::NAN,
        }
    }
}
