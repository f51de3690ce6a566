//! A refused flow map in the words of the settings that help.

use density::flow_map::refused::Limit;
use density::flow_map::{Cause, Refused};
use kit::Failure;

/// What a map is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum By {
    /// Cells of the cloud.
    Cells,
    /// Orbit and time on the orbit, in the plane.
    ActionAngle,
}

/// What has been asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    /// What the map was to be made of.
    pub by: By,
    /// Whether the scenario has a map by action and angle.
    pub may_be_by_angle: bool,
}

/// Why there is no map, and what to do.
pub(super) fn in_words(refused: &Refused, asked: Asked) -> Failure {
    let Refused::CoversTooLittle { unresolved, .. } = refused else { return Failure::Refused(refused.to_string()) };
    let mut ways = Vec::new();
    if unresolved.limit != Limit::NoGain {
        ways.push("with more samples a map may have more orbits and smaller cells");
    }
    if unresolved.limit == Limit::Orbits && matches!(unresolved.cause, Cause::Bends { .. }) {
        ways.push("with a larger map_error it needs fewer");
    }
    if asked.by == By::Cells && asked.may_be_by_angle {
        ways.push("node = \"flow-map\" with by = \"action-angle\" takes far fewer orbits");
    }
    ways.push("node = \"mc\" without a map follows every orbit");
    Failure::Refused(format!("{refused}; {}", ways.join("; ")))
}

#[cfg(test)]
mod tests {
    use density::flow_map::Unresolved;
    use density::model::plane::VARIABLES;
    use density::model::variable::Place;

    use super::*;

    #[test]
    fn only_ways_out_that_exist_are_told() {
        let told = |cause, limit, by, may_be_by_angle| {
            let unresolved = Unresolved { place: Place::new(&VARIABLES, |_| 0.5), share: 0.1, cause, limit };
            let refused =
                Refused::CoversTooLittle { orbits: 10, mapped: 0.2, least: 0.5, unresolved: Box::new(unresolved) };
            in_words(&refused, Asked { by, may_be_by_angle }).to_string()
        };
        let bends = Cause::Bends { years: 2.0, error: 0.1 };
        let has = |text: &str| ["more samples", "map_error", "action-angle", "follows"].map(|way| text.contains(way));
        assert_eq!(has(&told(bends, Limit::Orbits, By::Cells, true)), [true, true, true, true]);
        assert_eq!(has(&told(bends, Limit::Share, By::Cells, false)), [true, false, false, true]);
        assert_eq!(has(&told(Cause::FirstPassages, Limit::Orbits, By::Cells, false)), [true, false, false, true]);
        assert_eq!(has(&told(bends, Limit::NoGain, By::ActionAngle, true)), [false, false, false, true]);
    }
}
