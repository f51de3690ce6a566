//! Looking on without ever holding up a run.
//!
//! A publisher waits for a reader whose buffer is full, since overflow is off. An observer is a reader that it does not wait
//! for: the name of its port says so, and it misses what its buffer cannot take. Its node is called `observer-...`; the
//! remains of observers that were killed are removed by the next one.

use iceoryx2::node::NodeView;
use iceoryx2::prelude::*;

use crate::domain::{Domain, Place};
use crate::port::{Inlet, OBSERVER, PortError};
use crate::topic::Topic;

/// What an observer's node is called, before its purpose and process id.
const NODE_PREFIX: &str = "observer-";

/// An observer's access to a domain.
#[derive(Debug)]
pub struct Observer {
    domain: Domain,
}

/// How many take part in a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Census {
    /// Ports that send.
    pub publishers: usize,
    /// Ports that receive and are waited for.
    pub readers: usize,
    /// Ports that look on.
    pub observers: usize,
}

impl Observer {
    /// Enters the domain at `place` to do `what`, after removing what observers that were killed have left.
    ///
    /// # Errors
    /// [`PortError`] if the place cannot be used.
    pub fn enter(place: &Place, what: &str) -> Result<Self, PortError> {
        remove_dead_observers(place)?;
        let domain = Domain::enter(place, &format!("{NODE_PREFIX}{what}-{}", std::process::id()))?;
        Ok(Self { domain })
    }

    /// A way to receive messages of a topic, what its publishers still keep and what follows; nobody waits for it.
    ///
    /// # Errors
    /// [`PortError`] if the topic does not exist, is of another version, or has no room for another reader.
    pub fn inlet<T: Topic>(&self) -> Result<Inlet<T>, PortError> {
        Inlet::create(self.domain.open::<T>()?, OBSERVER)
    }

    /// How many take part in a topic at this moment.
    ///
    /// # Errors
    /// [`PortError`] if the topic does not exist or is of another version.
    pub fn census<T: Topic>(&self) -> Result<Census, PortError> {
        let (messages, _) = self.domain.open::<T>()?;
        let mut census =
            Census { publishers: messages.dynamic_config().number_of_publishers(), readers: 0, observers: 0 };
        messages.dynamic_config().list_subscribers(|reader| {
            *(if reader.subscriber_name == OBSERVER { &mut census.observers } else { &mut census.readers }) += 1;
            CallbackProgression::Continue
        });
        Ok(census)
    }
}

fn remove_dead_observers(place: &Place) -> Result<(), PortError> {
    let listed = Node::<ipc::Service>::list(&place.config()?, |node| {
        if let NodeState::Dead(view) = node
            && view.details().as_ref().is_some_and(|details| details.name().as_str().starts_with(NODE_PREFIX))
        {
            // Another observer may be quicker.
            let _ = view.try_remove_stale_resources();
        }
        CallbackProgression::Continue
    });
    listed.map_err(|e| PortError::new("list the nodes of", &place.root.display().to_string(), &e))
}
