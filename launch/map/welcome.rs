//! Home's end of a map that is computed on several hosts: worker hosts are welcomed, get parts, and are told how the
//! map has ended.

use std::collections::BTreeMap;
use std::sync::Arc;

use bridge::dealing::{Answer, Brought, Dealer, Dealing, Question};
use bridge::plan::MapPlan;
use density::exact::Estimated;

use super::allotment::{Allotment, Outcome};
use super::order::Order;
use super::parts::Found;
use crate::domain;
use crate::plan::hosts::Hosts;

/// Draws a map while other hosts may contribute, if the map file names any; they are told how it has ended.
///
/// # Errors
/// Why the map cannot be drawn, or why others cannot be let in.
pub(super) fn with_others(
    order: &Order<'_>,
    allotment: &Arc<Allotment>,
    draw: impl FnOnce() -> Result<(), String>,
) -> Result<(), String> {
    let Some(Hosts { access, names, .. }) = order.hosts else { return draw() };
    let [text, scenario] = order.map.texts().map(str::to_owned);
    let plan = MapPlan { map_id: domain::fresh_run_id(), file: order.map.path().into(), text, scenario };
    let dealer = Arc::new(AllotmentDealer { allotment: Arc::clone(allotment), is_quiet: order.is_quiet });
    let dealing = Dealing::open(access, names, &plan, dealer).map_err(|e| e.to_string())?;
    if !order.is_quiet {
        remark!("{} may join at {}", names.join(", "), access.endpoint);
    }
    let drawn = draw();
    dealing.end();
    drawn
}

/// Gives out the parts of an allotment.
struct AllotmentDealer {
    allotment: Arc<Allotment>,
    is_quiet: bool,
}

impl Dealer for AllotmentDealer {
    fn answer(&self, Question { process, brought, is_free, is_leaving, .. }: Question) -> Answer {
        for part in brought {
            self.allotment.bring(process, part.place, found(part));
        }
        match self.allotment.outcome() {
            Some(Outcome::Complete) => Answer::Complete,
            Some(Outcome::Failed(why)) => Answer::Failed(why),
            Some(Outcome::Interrupted) => Answer::Interrupted,
            None if is_free && !is_leaving => match self.allotment.take(process) {
                places if places.is_empty() => Answer::Nothing,
                places => Answer::Compute(places),
            },
            None => Answer::Nothing,
        }
    }

    fn attend(&self, present: BTreeMap<u64, String>) {
        let (come, gone) = self.allotment.attend(present);
        if self.is_quiet || self.allotment.outcome().is_some() {
            return;
        }
        come.iter().for_each(|name| remark!("{name} has joined"));
        gone.iter().for_each(|name| remark!("{name} is gone; what it had is computed elsewhere"));
    }

    fn refused(&self, why: &str) {
        remark!("a host was refused: {why}");
    }
}

/// What a worker has found, as numbers again.
fn found(part: Brought) -> Found {
    let number = |[value, error]: [u64; 2]| Estimated { value: f64::from_bits(value), error: f64::from_bits(error) };
    part.found.map(|numbers| numbers.into_iter().map(number).collect())
}
