//! Sending and receiving without silent loss of messages.

use std::fmt::Debug;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{BackpressureAction, BackpressureInfo, LoanError};
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::port_factory::{event, publish_subscribe};

use crate::patience::Attention;
pub use crate::port_error::PortError;
use crate::topic::Topic;
use crate::wait::Awaited;

/// Event of a publisher: there are messages, or there may be.
pub const SENT: EventId = EventId::new(1);
/// Event of a reader: it has joined and wants what was sent before.
pub const JOINED: EventId = EventId::new(2);

/// Port name of a reader for which no publisher waits.
pub const OBSERVER: &str = "observer";
/// Port name of every other reader.
pub const READER: &str = "reader";

/// Name of a listener that only waits for readers to join: messages do not wake it.
const EAR: &str = "ear";

/// Messages that a publisher may write at once.
pub(crate) const MOST_DRAFTS: usize = 2;

/// Both services of a topic.
pub(crate) type Services<T> = (
    publish_subscribe::PortFactory<ipc::Service, [<T as Topic>::Item], <T as Topic>::Header>,
    event::PortFactory<ipc::Service>,
);

/// Sends messages on a topic. Keep it until the receivers are done: a message dies with its publisher.
#[derive(Debug)]
pub struct Outlet<T: Topic> {
    publisher: Publisher<ipc::Service, [T::Item], T::Header>,
    notifier: Notifier<ipc::Service>,
    listener: Listener<ipc::Service>,
}

/// What a publisher does about a reader whose buffer is full: it waits a bounded time, but not at all for an
/// observer, which misses the message. Time in which the publisher's own process was stopped does not count.
fn when_full<P, H>(
    readers: &publish_subscribe::PortFactory<ipc::Service, P, H>,
    info: &BackpressureInfo,
    patience: Duration,
    waited: &Mutex<Attention>,
) -> BackpressureAction
where
    P: IceoryxSend + Debug + ?Sized,
    H: ZeroCopySend + Debug,
{
    let mut observer = false;
    readers.dynamic_config().list_subscribers(|reader| {
        if reader.subscriber_id.value() == info.receiver_port_id {
            observer = reader.subscriber_name == OBSERVER;
            return CallbackProgression::Stop;
        }
        CallbackProgression::Continue
    });
    if observer {
        BackpressureAction::DiscardData
    } else if waited.lock().unwrap_or_else(PoisonError::into_inner).count(info.elapsed_time) > patience {
        BackpressureAction::DiscardDataAndFail
    } else {
        BackpressureAction::Retry
    }
}

/// A message being written, in the memory in which it will be read.
#[derive(Debug)]
pub struct Draft<T: Topic> {
    sample: SampleMut<ipc::Service, [T::Item], T::Header>,
}

impl<T: Topic> Outlet<T> {
    pub(crate) fn create(
        (messages, events): Services<T>,
        most_items: usize,
        patience: Duration,
    ) -> Result<Self, PortError> {
        let failed = |error: &dyn Debug| PortError::new("publish on", T::NAME, error);
        let messages = Arc::new(messages);
        let readers = Arc::clone(&messages);
        let waited = Mutex::default();
        let publisher = messages
            .publisher_builder()
            .initial_max_slice_len(most_items)
            .allocation_strategy(AllocationStrategy::Static)
            .backpressure_strategy(BackpressureStrategy::RetryUntilDelivered)
            .set_backpressure_handler(move |info| when_full(&readers, info, patience, &waited))
            .max_loaned_samples(MOST_DRAFTS)
            .create()
            .map_err(|e| failed(&format_args!("{e:?} for {most_items} items a message; is there memory for them?")))?;
        let notifier = events.notifier_builder().create().map_err(|e| failed(&e))?;
        let ear = PortName::new(EAR).map_err(|e| failed(&e))?;
        let listener = events.listener_builder().name(&ear).create().map_err(|e| failed(&e))?;
        let outlet = Self { publisher, notifier, listener };
        outlet.wake();
        Ok(outlet)
    }

    /// Borrows memory for a message of `items` items, all zero.
    ///
    /// # Errors
    /// [`PortError`] if `items` is more than the outlet was made for, or too many drafts are open.
    pub fn draft(&self, items: usize) -> Result<Draft<T>, PortError> {
        let loan: Result<_, LoanError> = self.publisher.loan_slice(items);
        loan.map(|sample| Draft { sample }).map_err(|e| PortError::new("borrow memory on", T::NAME, &e))
    }

    /// Sends a draft and wakes the readers. Readers that come later get it as history; all readers check the count
    /// and the order of messages.
    ///
    /// # Errors
    /// [`PortError`] if a reader has not taken its messages for the domain's patience.
    pub fn send(&self, draft: Draft<T>, header: T::Header) -> Result<(), PortError> {
        let mut sample = draft.sample;
        *sample.user_header_mut() = header;
        sample.send().map_err(|e| PortError::new("send on", T::NAME, &e))?;
        self.wake();
        Ok(())
    }

    /// Copies `items` into a message and sends it.
    ///
    /// # Errors
    /// As [`Outlet::draft`] and [`Outlet::send`].
    pub fn send_items(&self, header: T::Header, items: &[T::Item]) -> Result<(), PortError> {
        let mut draft = self.draft(items.len())?;
        draft.items_mut().copy_from_slice(items);
        self.send(draft, header)
    }

    /// Wakes all listeners on the topic except those of publishers.
    fn wake(&self) {
        self.notifier.for_each_listener(|one, details| {
            if details.listener_name != EAR {
                let _ = one.notify_with_custom_event_id(SENT);
            }
            CallbackProgression::Continue
        });
    }
}

impl<T: Topic> Draft<T> {
    /// The items to write.
    pub fn items_mut(&mut self) -> &mut [T::Item] {
        self.sample.payload_mut()
    }
}

/// Receives the messages of a topic.
#[derive(Debug)]
pub struct Inlet<T: Topic> {
    subscriber: Subscriber<ipc::Service, [T::Item], T::Header>,
    listener: Listener<ipc::Service>,
    _notifier: Notifier<ipc::Service>,
}

/// A received message; its memory is freed when it is dropped.
#[derive(Debug)]
pub struct Message<T: Topic> {
    sample: Sample<ipc::Service, [T::Item], T::Header>,
}

impl<T: Topic> Inlet<T> {
    pub(crate) fn create((messages, events): Services<T>, name: &str) -> Result<Self, PortError> {
        let failed = |error: &dyn Debug| PortError::new("subscribe to", T::NAME, error);
        let name = PortName::new(name).map_err(|e| failed(&e))?;
        let listener = events.listener_builder().create().map_err(|e| failed(&e))?;
        let subscriber = messages.subscriber_builder().name(&name).create().map_err(|e| failed(&e))?;
        let notifier = events.notifier_builder().create().map_err(|e| failed(&e))?;
        let _ = notifier.notify_with_custom_event_id(JOINED);
        Ok(Self { subscriber, listener, _notifier: notifier })
    }

    /// The next message, if one has arrived.
    ///
    /// # Errors
    /// [`PortError`] if too many messages are held, or the connection to a publisher is broken.
    pub fn receive(&self) -> Result<Option<Message<T>>, PortError> {
        let received = self.subscriber.receive().map_err(|e| PortError::new("receive on", T::NAME, &e))?;
        Ok(received.map(|sample| Message { sample }))
    }
}

impl<T: Topic> Inlet<T> {
    /// Sleeps until something may have arrived, at most for `timeout`; for threads that serve only one topic.
    ///
    /// # Errors
    /// [`PortError`] if the topic cannot be waited for.
    pub fn wait(&self, timeout: Duration) -> Result<(), PortError> {
        match self.listener.timed_wait(|_| (), timeout) {
            // A signal ends the wait and is no error.
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(()),
            Err(error) => Err(PortError::new("wait on", T::NAME, &error)),
        }
    }
}

impl<T: Topic> Message<T> {
    /// The header.
    pub fn header(&self) -> &T::Header {
        self.sample.user_header()
    }

    /// The items.
    pub fn items(&self) -> &[T::Item] {
        self.sample.payload()
    }

    /// The id of the process that sent the message, according to the transport; nothing that the sender writes into a
    /// header changes it.
    pub fn sender(&self) -> Option<u32> {
        let process = self.sample.header().node_id().pid::<ipc::Service>().ok()?;
        u32::try_from(process.value()).ok()
    }

    /// The run that the message belongs to.
    pub fn run_id(&self) -> u64 {
        T::run_id(self.header())
    }
}

impl<T: Topic> Awaited for Inlet<T> {
    fn listener(&self) -> &Listener<ipc::Service> {
        &self.listener
    }

    /// Discards the events: they only say that there may be messages; the messages wait in the buffer.
    fn attend(&self) {
        let _ = self.listener.try_wait(|_| ());
    }
}

impl<T: Topic> Awaited for Outlet<T> {
    fn listener(&self) -> &Listener<ipc::Service> {
        &self.listener
    }

    /// Delivers what has been sent to readers that have joined since.
    fn attend(&self) {
        let mut joined = false;
        let _ = self.listener.try_wait(|event| joined |= event.id == JOINED);
        if joined {
            let _ = self.publisher.update_connections();
            self.wake();
        }
    }
}
