//! The description of a scenario in its results folder, by its message.

use density::grid::{Axis, Grid};
use density::model::registry::Planar;
use density::problem::Problem;
use kit::assignment::{Assignment, Plane};
use kit::space::Quantity;
use messages::scenario::Range;
use results::description::{self, Description, Parameter, Projection, Statistic, Variable};

/// The description of a scenario in the plane.
pub fn in_plane(name: &str, problem: &Problem<Planar>) -> Description {
    // The description does not say how many bins there are.
    let bin = Axis { low: 0.0, high: 1.0, bins: 1 };
    let grids = vec![Grid { phi: bin, e: bin }];
    of(&Assignment::in_plane(0, name, (0, 1), Plane { problem: problem.clone(), grids }))
}

/// The description of a scenario.
pub(super) fn of(assignment: &Assignment) -> Description {
    let (said, space) = (&assignment.description, &assignment.space);
    let parameter = |p: &messages::scenario::Parameter| Parameter {
        name: p.name.clone(),
        symbol: p.symbol.clone(),
        value: p.value,
    };
    let variable = |v: &messages::scenario::Variable| Variable {
        name: v.name.clone(),
        symbol: v.symbol.clone(),
        unit: v.unit.clone(),
        bounds: match v.range {
            Range::Circle => None,
            Range::Interval { low, high } => Some([low, high]),
        },
    };
    let quantity = |quantity: Quantity| {
        let (statistic, variables) = match quantity {
            Quantity::Mean(k) => (Statistic::Mean, vec![k]),
            Quantity::Deviation(k) => (Statistic::Deviation, vec![k]),
            Quantity::Covariance(a, b) => (Statistic::Covariance, vec![a, b]),
            Quantity::AboveCritical => (Statistic::AboveCritical, vec![space.reentry]),
            Quantity::CircularMean(k) => (Statistic::CircularMean, vec![k]),
            Quantity::ResultantLength(k) => (Statistic::ResultantLength, vec![k]),
        };
        let (name, column) = (space.name(quantity), space.column(quantity));
        description::Quantity { statistic, variables, name, column }
    };
    let projection = |projection: &messages::scenario::Projection| Projection {
        density: space.density_name(projection),
        variables: projection.axes().map(|(variable, _)| variable).collect(),
    };
    Description {
        name: said.name.clone(),
        model: said.model.clone(),
        parameters: said.parameters.iter().map(parameter).collect(),
        variables: said.variables.iter().map(variable).collect(),
        reentry: said.reentry,
        critical: said.critical,
        mean: said.mean.clone(),
        covariance: said.covariance.clone(),
        times: said.snapshots.iter().map(|snapshot| snapshot.time).collect(),
        quantities: space.quantities().into_iter().map(quantity).collect(),
        projections: space.projections.iter().map(projection).collect(),
    }
}
