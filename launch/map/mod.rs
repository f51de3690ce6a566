//! A map: its parts are computed, here and on other hosts, kept as they come so that an interrupted map goes on where
//! it was, and written with their figure.
//!
//! | module | what is in it |
//! |---|---|
//! | `order` | what is to be drawn |
//! | `parts` | the points that are computed together |
//! | `allotment` | who computes which parts |
//! | `folder` | the folder in which all this lies, and which may be used |
//! | `computed` | the file with what has been computed so far |
//! | `interruption` | what happens when the user asks to stop |
//! | `output` | the files of a finished map |
//! | `progress` | how far it is |
//! | `welcome`, `contributing` | several hosts, home's end and a worker's end |

mod allotment;
mod computed;
#[cfg(feature = "hosts")]
pub mod contributing;
mod folder;
mod interruption;
mod order;
mod output;
mod parts;
mod progress;
#[cfg(feature = "hosts")]
mod welcome;

use std::sync::Arc;

use density::reliability::refinement::{Cell, Known, fill};

use allotment::{Allotment, HOME, Outcome};
use computed::Computed;
use interruption::Watch;
use parts::{Parts, Place};
use progress::{Progress, Tally};

pub use folder::prepare;
pub use order::Order;
pub use output::{FIGURE, PAGE, TABLE};

#[cfg(feature = "hosts")]
use welcome::with_others;

/// Computes a map, keeps its parts in its folder, and writes its files.
///
/// # Errors
/// What is wrong with a point, which file cannot be written, or why other hosts cannot be reached.
pub fn draw(order: &Order<'_>) -> Result<(), String> {
    let parts = Parts::of(order.map)?;
    let kept = Computed::open(order.folder)?;
    let known = kept.known().clone();
    let tally = Arc::new(Tally::of(known.len(), usize::from(order.hosts.is_some())));
    let allotment = Arc::new(Allotment::new(kept, parts, Arc::clone(&tally)));
    let size = parts.size();
    let watch = Watch::begin(&allotment, size.0 * size.1, order.folder)?;
    let drawn = with_others(order, &allotment, || {
        let cells = compute(order, parts, &allotment, known, &tally);
        let drawn = cells.and_then(|cells| output::write(order.map, &cells, order.folder));
        allotment.end(match &drawn {
            Ok(()) => Outcome::Complete,
            Err(why) => Outcome::Failed(why.clone()),
        });
        drawn
    });
    watch.end();
    drawn
}

/// Without the feature `hosts` there are no others.
#[cfg(not(feature = "hosts"))]
fn with_others(_: &Order<'_>, _: &Arc<Allotment>, draw: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    draw()
}

fn compute(
    order: &Order<'_>,
    parts: Parts<'_>,
    allotment: &Allotment,
    mut known: Known,
    tally: &Arc<Tally>,
) -> Result<Vec<Cell>, String> {
    let size = parts.size();
    let progress = Progress::new(size.0 * size.1, tally, order.is_quiet);
    let cells = fill(size, order.map.tolerance, &mut known, |missing, known: &mut Known| {
        known.extend(compute_all(parts, allotment, missing)?);
        Ok::<(), String>(())
    })?;
    progress.end();
    Ok(parts.join(&cells))
}

/// Has parts computed, and computes those that nobody else does.
fn compute_all(parts: Parts<'_>, allotment: &Allotment, missing: &[Place]) -> Result<Known, String> {
    allotment.lay_out(missing);
    while let Some(places) = allotment.next_at_home()? {
        parts.compute(&places, |place, found| allotment.bring(HOME, place, found));
    }
    Ok(allotment.collect())
}
