//! A model that is not ours: a rigid rotation in space, with three variables, no Hamiltonian and an answer in closed
//! form.

use std::f64::consts::TAU;

use density::flow::FromEquations;
use density::model::{Kind, Model, Quantity, Variable};

/// Points turn about an axis through the origin by `turns` radians a year. The state is Cartesian; points are given and
/// read out by their angle about the `z` axis, their distance from it and their height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidRotation {
    /// A unit vector along the axis.
    pub axis: [f64; 3],
    /// \[rad/yr\].
    pub turns: f64,
}

impl Model for RigidRotation {
    type State<T: Quantity> = [T; 3];
    type Variables = [f64; 3];
    type Series<const P: usize> = FromEquations<Self, P>;

    const VARIABLES: &'static [Variable] = &[
        Variable { name: "angle", symbol: "psi", unit: "rad", kind: Kind::Circle },
        Variable { name: "distance", symbol: "r", unit: "m", kind: Kind::Interval { low: 0.0, high: 100.0 } },
        Variable { name: "height", symbol: "z", unit: "m", kind: Kind::Interval { low: -100.0, high: 100.0 } },
    ];
    const REENTRY: usize = 2;

    fn rate<T: Quantity>(&self, _: T, [x, y, z]: [T; 3]) -> [T; 3] {
        let [a, b, c] = self.axis.map(|component| component * self.turns);
        [z * b - y * c, x * c - z * a, y * a - x * b]
    }

    fn is_inside(&self, [x, y, z]: [f64; 3]) -> bool {
        x.hypot(y) < 100.0 && z.abs() < 100.0
    }

    fn state(&self, _: f64, [angle, distance, height]: [f64; 3]) -> [f64; 3] {
        [distance * angle.cos(), distance * angle.sin(), height]
    }

    fn read_out(&self, _: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [y.atan2(x).rem_euclid(TAU), x.hypot(y), z]
    }

    fn clearance<T: Quantity>(&self, [_, _, z]: [T; 3]) -> T {
        -z
    }

    fn critical_clearance(&self, critical: f64) -> f64 {
        -critical
    }

    /// Volume is kept, which is the distance for each unit of the variables.
    fn density_growth(&self, [x0, y0, _]: [f64; 3], [x, y, _]: [f64; 3]) -> Option<f64> {
        Some(x.hypot(y) / x0.hypot(y0))
    }
}
