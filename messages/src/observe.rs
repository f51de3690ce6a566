//! Observers: readers that never delay a run.
//!
//! A publisher waits for a reader whose buffer is full, since overflow is off. It does not wait for an observer,
//! which it recognizes by the name of its port; the observer misses the messages that do not fit into its buffer. The
//! node of an observer is called `observer-...`; what observers that were killed leave behind is removed by the next
//! observer.

use iceoryx2::node::NodeView;
use iceoryx2::prelude::*;

use crate::domain::{Domain, Place};
use crate::port::{Inlet, OBSERVER, PortError};
use crate::topic::Topic;

/// The beginning of the name of an observer's node; its purpose and its process id follow.
const NODE_PREFIX: &str = "observer-";

/// An observer's access to a domain.
#[derive(Debug)]
pub struct Observer {
    domain: Domain,
}

/// How many ports a topic has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Census {
    /// Ports that send.
    pub publishers: usize,
    /// Ports that receive and for which publishers wait.
    pub readers: usize,
    /// Ports of observers.
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

    /// A way to receive the messages of a topic, those that its publishers still keep and those that follow. No
    /// publisher waits for it.
    ///
    /// # Errors
    /// [`PortError`] if the topic does not exist, is of another version, or has no room for another reader.
    pub fn inlet<T: Topic>(&self) -> Result<Inlet<T>, PortError> {
        Inlet::create(self.domain.open::<T>()?, OBSERVER)
    }

    /// How many ports a topic has at this moment.
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
            // Another observer may have removed them already.
            let _ = view.try_remove_stale_resources();
        }
        CallbackProgression::Continue
    });
    listed.map_err(|e| PortError::new("list the nodes of", &place.root.display().to_string(), &e))
}
