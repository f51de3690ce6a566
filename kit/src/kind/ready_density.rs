//! Densities that their propagator itself has computed on the comparison grid.

use density::angle::Circular;
use density::estimate::{Estimate, Moments};
use messages::content::{Content, DENSITY_HEAD, Density};
use messages::layout::diagnostic;

use super::{Estimated, Kind, Memory, Place, Snapshot};
use crate::snapshot_rules::{Breach, Rule};
use crate::space::Space;

/// Numbers before the error estimates in the head of a density.
const STATED: usize = DENSITY_HEAD - 4;
/// Moments at the beginning of the head.
const MOMENTS: usize = 6;

impl Kind for Density {
    /// A method may withhold figures by writing NaN; its error estimates give the accuracy that was reached.
    fn breach(&self, _: &Space, _: usize, items: &[f64]) -> Option<Breach> {
        let (head, joint) = items.split_at(DENSITY_HEAD.min(items.len()));
        in_head(head).or_else(|| in_joint(joint)).map(|what| Breach { rule: Rule::Finite, what })
    }

    /// NaN stands for figures that are withheld.
    fn estimate(&self, snapshot: &Snapshot, _: &mut Memory, at: &Place) -> Result<Estimated, String> {
        let [values] = snapshot.columns()?;
        let (_, grid) = at.in_plane()?;
        let bins = grid.len();
        let Some((&head, joint)) = values.split_first_chunk::<DENSITY_HEAD>().filter(|(_, joint)| joint.len() == bins)
        else {
            let count = values.len();
            return Err(format!("it holds {count} numbers, not {DENSITY_HEAD} and one for each of {bins} bins"));
        };
        let [a, b, c, d, e, f, mean, resultant, diagnostics @ ..] = head;
        let moments = Moments::from_array([a, b, c, d, e, f]);
        let estimate = Estimate::from_joint(grid, joint.to_vec(), moments, Circular { mean, resultant });
        Ok(Estimated { diagnostic: diagnostic::NUMERICAL, diagnostics, ..estimate.into() })
    }

    fn of_all_shards(&self) -> Result<Content, String> {
        Err("a density is one piece; it cannot be put together from shards".into())
    }

    fn may_withhold(&self) -> bool {
        true
    }

    /// Whether it states neither a moment nor a bin.
    fn withholds_all(&self, items: &[f64]) -> bool {
        let Some((head, joint)) = items.split_first_chunk::<DENSITY_HEAD>() else { return false };
        !joint.is_empty() && head[..MOMENTS].iter().chain(joint).all(|number| number.is_nan())
    }
}

fn in_head(head: &[f64]) -> Option<String> {
    let (stated, estimates) = head.split_at(STATED.min(head.len()));
    if let Some(row) = stated.iter().position(|value| value.is_infinite()) {
        return Some(format!(
            "row {row} of column 0 is {}; a moment is finite, or NaN where it is withheld",
            stated[row]
        ));
    }
    let place = estimates.iter().position(|estimate| estimate.is_nan() || *estimate < 0.0)?;
    let (row, estimate) = (STATED + place, estimates[place]);
    Some(format!("row {row} of column 0 is {estimate}; an error estimate is 0 or more, infinite if unknown"))
}

fn in_joint(joint: &[f64]) -> Option<String> {
    let bad = joint.iter().position(|value| !value.is_finite())?;
    let row = DENSITY_HEAD + bad;
    match joint.iter().find(|value| !value.is_nan()) {
        None => None,
        Some(_) if joint[bad].is_infinite() => Some(format!("row {row} of column 0 is {}", joint[bad])),
        Some(other) => Some(format!(
            "row {row} of column 0 is NaN beside {other}; a joint density is withheld as a whole or not at all"
        )),
    }
}

#[cfg(test)]
mod tests {
    use messages::layout::SnapshotHeader;

    use super::*;

    #[test]
    fn a_density_that_is_withheld_stays_withheld_and_so_do_its_marginals_and_its_mass() {
        let assignment = crate::example::assignment();
        let at = Place { assignment: &assignment, index: 0 };
        let mut values = vec![0.25; DENSITY_HEAD];
        values[2] = f64::NAN;
        values.extend([f64::NAN; 12]);
        let header = SnapshotHeader { rows: values.len() as u32, ..SnapshotHeader::default() }.with(Density);
        let snapshot = Snapshot { header: &header, content: Density.into(), items: &values };
        let estimated = Density.estimate(&snapshot, &mut Memory::default(), &at).unwrap();
        let Estimated { values, densities, mass_on_grid, diagnostics, .. } = estimated;
        assert!(mass_on_grid.is_nan() && densities.iter().flatten().all(|density| density.is_nan()));
        assert!(values[2].is_nan() && values[0] == 0.25);
        assert_eq!(diagnostics, [0.25; 4], "how far it came is told");
    }

    #[test]
    fn a_density_may_withhold_moments_and_the_whole_joint_but_no_part_of_it_and_no_estimate() {
        let density = |changes: &[(usize, f64)]| {
            let mut numbers = [0.5; DENSITY_HEAD + 4];
            changes.iter().for_each(|&(at, value)| numbers[at] = value);
            Density
                .breach(&crate::example::assignment().space, numbers.len(), &numbers)
                .map(|breach| (breach.rule, breach.what))
        };
        let (nan, infinite) = (f64::NAN, f64::INFINITY);
        let joint: Vec<(usize, f64)> = (DENSITY_HEAD..DENSITY_HEAD + 4).map(|at| (at, nan)).collect();
        assert_eq!(density(&[]), None);
        assert_eq!(density(&[(0, nan), (5, nan), (7, nan)]), None);
        assert_eq!(density(&joint), None);
        assert_eq!(density(&[(8, infinite), (11, infinite)]), None, "nobody knows how far off it is");
        for (changes, words) in [
            (&[(0, infinite)][..], "row 0 of column 0 is inf; a moment is finite"),
            (&[(8, nan)], "row 8 of column 0 is NaN; an error estimate is 0 or more"),
            (&[(11, -1e-3)], "row 11 of column 0 is -0.001; an error estimate"),
            (&[(13, nan)], "row 13 of column 0 is NaN beside 0.5; a joint density is withheld as a whole"),
            (&[(12, nan), (13, infinite)], "NaN beside"),
            (&[(14, infinite)], "row 14 of column 0 is inf"),
        ] {
            let (rule, what) = density(changes).unwrap();
            assert!(rule == Rule::Finite && what.contains(words), "{what}");
        }
    }
}
