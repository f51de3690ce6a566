//! How the message with a snapshot is made from what a propagator writes: as it stands, or reduced.

use density::grid::Grid;
use density::sample_sums::SampleSums;
use messages::content::{Content, Reduced};
use messages::port::{Draft, Outlet};
use messages::topic::Snapshot;

use crate::assignment::{Assignment, Plane};
use crate::failure::Failure;
use crate::kind;
use crate::propagator::{Form, Propagator};
use crate::reduced;
use crate::session::Session;

/// How the snapshots are made from what a propagator writes.
pub(crate) struct Drafting {
    content: Content,
    /// The most numbers that a message can have.
    pub most_numbers: usize,
    /// The content of the samples, if they are reduced before they are sent.
    reduces: Option<Content>,
}

impl Drafting {
    pub fn of(session: &Session, form: &Form, assignment: &Assignment) -> Result<Self, Failure> {
        let Form { content, most_rows, .. } = *form;
        if !session.reduce {
            let columns = content.column_count(assignment.space.variables.len());
            return Ok(Self { content, most_numbers: most_rows * columns, reduces: None });
        }
        if !kind::of(&content).may_be_reduced() {
            return Err(Failure::Refused("only independent samples can be reduced; leave out `reduce`".into()));
        }
        let plane = reduced::plane_of(assignment)?;
        let most_bins = plane.grids.iter().map(Grid::len).max().unwrap_or(0);
        let most_numbers = reduced::most_numbers(most_bins);
        Ok(Self { content: Reduced.into(), most_numbers, reduces: Some(content) })
    }

    /// The content of the snapshot that `propagator` has reached.
    pub fn content(&self, propagator: &impl Propagator) -> Result<Content, Failure> {
        let content = if self.reduces.is_some() { self.content } else { propagator.content(self.content) };
        if content.kind() != self.content.kind() {
            let planned = self.content;
            return Err(Failure::Refused(format!("a snapshot is {content:?} where {planned:?} was announced")));
        }
        Ok(content)
    }

    /// The message with the snapshot that `propagator` has reached, and its number of rows.
    pub fn draft(
        &self,
        outlet: &Outlet<Snapshot>,
        propagator: &impl Propagator,
        rows: usize,
        assignment: &Assignment,
        index: usize,
    ) -> Result<(Draft<Snapshot>, usize), Failure> {
        let Some(samples_content) = self.reduces else {
            let mut draft = outlet.draft(rows * self.content.column_count(assignment.space.variables.len()))?;
            propagator.write(draft.items_mut());
            return Ok((draft, rows));
        };
        let refused = |why: &dyn std::fmt::Display| Failure::Refused(format!("snapshot {index}: {why}"));
        let Plane { problem, grids } = assignment.plane()?;
        let sums = match propagator.reduce(&grids[index], problem.critical_e) {
            Some(sums) => sums,
            None => {
                let mut samples = vec![0.0; 2 * rows];
                propagator.write(&mut samples);
                if let Some(breach) = kind::of(&samples_content).breach(&assignment.space, rows, &samples) {
                    return Err(refused(&breach));
                }
                let (phi, e) = samples.split_at(rows);
                SampleSums::reduce(phi, e, &grids[index], problem.critical_e)
            }
        };
        let numbers = reduced::to_numbers(&sums.map_err(|why| refused(&why))?)?;
        let mut draft = outlet.draft(numbers.len())?;
        draft.items_mut().copy_from_slice(&numbers);
        Ok((draft, numbers.len()))
    }
}
