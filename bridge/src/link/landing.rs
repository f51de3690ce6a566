//! Puts the messages that have been pulled into the local domain, each snapshot once, however often it comes.

use std::collections::BTreeMap;

use kit::failure::Failure;
use kit::shard::Shard;
use messages::domain::{Domain, Place};
use messages::layout::{MOST_PASSAGE, PassageHeader, SnapshotHeader, StatusHeader};
use messages::port::{Draft, Outlet};
use messages::report::Report;
use messages::service::Service;
use messages::text::unpack;
use messages::topic::{Passage, Snapshot, Status, Topic};
use messages::wait::Awaited;

use super::pull::Sink;
use crate::plan::Share;

/// A topic whose messages come home.
pub trait ComesHome: Topic {
    /// The name of the process that has sent the message.
    fn member(header: &Self::Header) -> String;
    /// The place of the message among those of its process, in ascending order: scenario, attempt, index. `None` if the
    /// message may be heard twice.
    fn position(header: &Self::Header) -> Option<(u32, u32, u32)>;
    /// The scenario it belongs to.
    fn scenario(header: &Self::Header) -> u32;
    /// The most items that a message of the same process can have in the same scenario.
    fn most_items(header: &Self::Header) -> usize;
    /// The header of the same message as sent by a bridge that has been restarted `attempts` times.
    fn again(header: Self::Header, attempts: u32) -> Self::Header;
}

impl ComesHome for Snapshot {
    fn member(header: &SnapshotHeader) -> String {
        Shard { index: header.shard, count: header.shards }.process_of(&unpack(&header.label)).to_string()
    }

    fn position(header: &SnapshotHeader) -> Option<(u32, u32, u32)> {
        Some((header.scenario, header.attempt, header.index))
    }

    fn scenario(header: &SnapshotHeader) -> u32 {
        header.scenario
    }

    fn most_items(header: &SnapshotHeader) -> usize {
        header.rows.max(header.most_rows) as usize * header.columns as usize
    }

    /// A higher attempt replaces what came before, which a restarted bridge sends once more.
    fn again(header: SnapshotHeader, attempts: u32) -> SnapshotHeader {
        SnapshotHeader { attempt: header.attempt.saturating_add(attempts), ..header }
    }
}

impl ComesHome for Passage {
    fn member(header: &PassageHeader) -> String {
        Shard { index: header.shard, count: header.shards }.process_of(&unpack(&header.label)).to_string()
    }

    /// None, because the recorder takes the last curve.
    fn position(_: &PassageHeader) -> Option<(u32, u32, u32)> {
        None
    }

    fn scenario(header: &PassageHeader) -> u32 {
        header.scenario
    }

    fn most_items(_: &PassageHeader) -> usize {
        MOST_PASSAGE
    }

    fn again(header: PassageHeader, _: u32) -> PassageHeader {
        header
    }
}

impl ComesHome for Status {
    fn member(header: &StatusHeader) -> String {
        Report::sender(header).map_or_else(|unknown| unknown.to_string(), |sender| sender.to_string())
    }

    fn position(_: &StatusHeader) -> Option<(u32, u32, u32)> {
        None
    }

    /// Always 0, because one outlet serves all scenarios.
    fn scenario(_: &StatusHeader) -> u32 {
        0
    }

    fn most_items(_: &StatusHeader) -> usize {
        2
    }

    fn again(header: StatusHeader, _: u32) -> StatusHeader {
        header
    }
}

/// The way into the local domain for the messages of one host's processes on one topic.
pub struct Landing<T: ComesHome> {
    domain: Domain,
    host: String,
    members: BTreeMap<String, MemberOutlet<T>>,
    attempts: u32,
}

/// The outlet for the messages of one process in one scenario, as in the process's own domain, and the position of the
/// last message that has been delivered.
struct MemberOutlet<T: ComesHome> {
    scenario: u32,
    outlet: Option<Outlet<T>>,
    last: Option<(u32, u32, u32)>,
}

impl<T: ComesHome> Landing<T> {
    /// Opens the way for the messages of `members` on `host`; this process has been restarted `attempts` times.
    ///
    /// # Errors
    /// [`Failure::Port`] if the domain cannot be entered.
    pub fn new(place: &Place, host: &str, members: &[Share], attempts: u32) -> Result<Self, Failure> {
        let member_outlet =
            |share: &Share| (share.name.clone(), MemberOutlet { scenario: 0, outlet: None, last: None });
        let members = members.iter().map(member_outlet).collect();
        Ok(Self { domain: Domain::enter(place, Service::Bridge.name())?, host: host.into(), members, attempts })
    }
}

impl<T: ComesHome> Sink<T> for Landing<T> {
    fn room(&mut self, header: &T::Header, items: usize) -> Result<Option<Draft<T>>, Failure> {
        let member = T::member(header);
        let Some(member_outlet) = self.members.get_mut(&member) else {
            if Service::Bridge.is(&member) {
                return Ok(None); // a report of the other bridge about itself
            }
            tracing::warn!(
                "{} sends for \"{}\", which is not its share; it is left out",
                self.host,
                member.escape_debug()
            );
            return Ok(None);
        };
        let position = T::position(header);
        if position.is_some() && position <= member_outlet.last {
            return Ok(None);
        }
        if items > T::most_items(header) {
            tracing::warn!("{}: {member} sends {items} items on {}, more than it may", self.host, T::NAME);
            return Ok(None);
        }
        let outlet = match member_outlet
            .outlet
            .take()
            .filter(|_| member_outlet.scenario == <T as ComesHome>::scenario(header))
        {
            Some(outlet) => outlet,
            None => self.domain.outlet(T::most_items(header))?,
        };
        member_outlet.scenario = <T as ComesHome>::scenario(header);
        Ok(Some(member_outlet.outlet.insert(outlet).draft(items)?))
    }

    fn deliver(&mut self, header: T::Header, draft: Draft<T>) -> Result<(), Failure> {
        let Some(member_outlet) = self.members.get_mut(&T::member(&header)) else { return Ok(()) };
        member_outlet.last = T::position(&header).or(member_outlet.last);
        if let Some(outlet) = &member_outlet.outlet {
            outlet.send(draft, T::again(header, self.attempts))?;
        }
        Ok(())
    }

    fn idle(&mut self) {
        self.members.values().filter_map(|member_outlet| member_outlet.outlet.as_ref()).for_each(Awaited::attend);
    }
}
