//! Densities that their propagator itself has computed on the comparison grid.

use density::angle::Circular;
use density::estimate::{Estimate, Moments};
use density::trust::Diagnosis;
use messages::content::{Content, DENSITY_HEAD, Density};

use super::{Estimated, Kind, Memory, Place, Snapshot};
use crate::breach::{Breach, Rule};
use crate::space::Space;

/// Error estimates at the end of the head of a density.
const ESTIMATES: usize = 4;

impl Kind for Density {
    /// A method may withhold figures by writing NaN; its error estimates give the accuracy that was reached.
    fn breach(&self, space: &Space, _: usize, items: &[f64]) -> Option<Breach> {
        let stated = space.quantities().len();
        let head = (stated + ESTIMATES).min(items.len());
        let found = in_head(&items[..head], stated).or_else(|| in_joint(&items[head..], head));
        found.map(|what| Breach { rule: Rule::Finite, what })
    }

    /// NaN stands for figures that are withheld.
    fn estimate(&self, snapshot: &Snapshot, _: &mut Memory, at: &Place) -> Result<Estimated, String> {
        let [values] = snapshot.columns()?;
        let grid = at.grid()?;
        let (bins, stated) = (grid.len(), at.assignment.space.quantities().len());
        let head = stated + ESTIMATES;
        if values.len() != head + bins {
            let count = values.len();
            return Err(format!("it holds {count} numbers, not {head} and one for each of {bins} bins"));
        }
        let diagnosis = Diagnosis::stated(std::array::from_fn(|k| values[stated + k]));
        // The estimate in the plane has the marginals; the moments may be of more variables.
        let unknown = Circular { mean: f64::NAN, resultant: f64::NAN };
        let estimate = Estimate::from_joint(grid, values[head..].to_vec(), Moments::NONE, unknown);
        let (values, errors) = (values[..stated].to_vec(), vec![f64::NAN; stated]);
        Ok(Estimated { values, errors, diagnosis, ..estimate.into() })
    }

    fn of_all_shards(&self) -> Result<Content, String> {
        Err("a density is one piece; it cannot be put together from shards".into())
    }

    fn may_withhold(&self) -> bool {
        true
    }

    /// Whether it states neither a moment nor a bin.
    fn withholds_all(&self, items: &[f64]) -> bool {
        // The moments of the plane come first, whatever follows them.
        let Some((head, rest)) = items.split_first_chunk::<DENSITY_HEAD>() else { return false };
        !rest.is_empty() && head[..6].iter().chain(rest).all(|number| number.is_nan())
    }
}

fn in_head(head: &[f64], count: usize) -> Option<String> {
    let (stated, estimates) = head.split_at(count.min(head.len()));
    if let Some(row) = stated.iter().position(|value| value.is_infinite()) {
        return Some(format!(
            "row {row} of column 0 is {}; a moment is finite, or NaN where it is withheld",
            stated[row]
        ));
    }
    let place = estimates.iter().position(|estimate| estimate.is_nan() || *estimate < 0.0)?;
    let (row, estimate) = (count + place, estimates[place]);
    Some(format!("row {row} of column 0 is {estimate}; an error estimate is 0 or more, infinite if unknown"))
}

fn in_joint(joint: &[f64], head: usize) -> Option<String> {
    let bad = joint.iter().position(|value| !value.is_finite())?;
    let row = head + bad;
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
        let Estimated { values, densities, mass_on_grid, diagnosis, .. } = estimated;
        assert!(mass_on_grid.is_nan() && densities.iter().flatten().all(|density| density.is_nan()));
        assert!(values[2].is_nan() && values[0] == 0.25);
        assert_eq!(diagnosis, Diagnosis::stated([0.25; 4]), "how far it came is told");
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
