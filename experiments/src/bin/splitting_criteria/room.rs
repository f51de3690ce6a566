//! What `benches/peers/pyest_splits.py` reads.

use density::mixture::library::Library;
use serde_json::{Value, json};

use crate::COMPONENTS;
use crate::plane::{All, Case, CriterionSplits};

/// Cases, libraries and splits as JSON.
pub fn written(All { cases, of_criteria }: &All, libraries: &[Library]) -> String {
    let case = |Case { scenario, time, grid, exact, .. }: &Case| {
        let axis = |axis: &density::grid::Axis| json!([axis.low, axis.high, axis.bins]);
        json!({"scenario": scenario, "time": time, "phi": axis(&grid.phi), "e": axis(&grid.e), "exact": exact.joint})
    };
    let library =
        |Library { sigma, weights, means, .. }: &Library| json!({"sigma": sigma, "weights": weights, "means": means});
    let split = |CriterionSplits { case, criterion, angle, splits }: &CriterionSplits| {
        let of = |(count, (components, l1)): (&usize, &(Vec<density::mixture::PlanarComponent>, f64))| -> Value {
            let rows: Vec<[f64; 6]> = components.iter().map(|component| component.to_array()).collect();
            json!({"count": count, "components": rows, "l1": l1})
        };
        let splits: Vec<Value> = COMPONENTS.iter().zip(splits).map(of).collect();
        json!({"case": case, "criterion": criterion.name(), "angle": angle, "splits": splits})
    };
    let all = json!({
        "cases": cases.iter().map(case).collect::<Vec<_>>(),
        "libraries": libraries.iter().map(library).collect::<Vec<_>>(),
        "splits": of_criteria.iter().map(split).collect::<Vec<_>>(),
    });
    all.to_string()
}
