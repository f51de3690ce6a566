//! An outlet that is kept from scenario to scenario, and made anew only when a scenario needs more room.

use messages::domain::Domain;
use messages::port::Outlet;
use messages::topic::Topic;

use kit::failure::Failure;

/// An outlet, with the most items that its messages can have.
#[derive(Debug)]
pub struct Roomy<T: Topic> {
    /// The outlet.
    pub outlet: Outlet<T>,
    most_items: usize,
}

impl<T: Topic> Roomy<T> {
    /// The outlet in `slot` if it has room for `most_items` items per message, else a new one, which takes the slot.
    ///
    /// # Errors
    /// [`Failure::Port`] if no outlet can be created.
    pub fn with_room<'a>(
        slot: &'a mut Option<Self>,
        domain: &Domain,
        most_items: usize,
    ) -> Result<&'a Outlet<T>, Failure> {
        // An outlet that is too small frees its memory before the new one takes its own.
        let roomy = match slot.take().filter(|roomy| roomy.most_items >= most_items) {
            Some(roomy) => roomy,
            None => Self { outlet: domain.outlet(most_items)?, most_items },
        };
        Ok(&slot.insert(roomy).outlet)
    }
}
