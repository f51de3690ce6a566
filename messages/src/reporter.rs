//! Who reports on `phasecloud/status`.

use std::fmt;

use crate::layout::role;
use crate::service::Service;
use crate::text::unpack;

/// A process that reports, or that is reported on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reporter {
    /// A service of the run.
    Service(Service),
    /// A propagator, or one shard of it.
    Propagator {
        /// The label of its case.
        label: String,
        /// Which shard of the case it is, if the case has several.
        shard: Option<u32>,
    },
}

/// A report whose sender, or whose subject, is of a kind that this version does not know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("its role is {0}, which no node has")]
pub struct UnknownRole(u32);

impl Reporter {
    /// The only process of the case `label`, or the case as a whole.
    pub fn case(label: impl Into<String>) -> Self {
        Self::Propagator { label: label.into(), shard: None }
    }

    /// One shard of the case `label`.
    pub fn shard(label: impl Into<String>, number: u32) -> Self {
        Self::Propagator { label: label.into(), shard: Some(number) }
    }

    /// The process that was started as `label`: the service of that name, which no case may have, or else the case or
    /// the shard of it.
    pub fn started_as(label: &str, shard: Option<u32>) -> Self {
        Service::named(label).map_or_else(|| Self::Propagator { label: label.into(), shard }, Self::Service)
    }

    /// The process that a message names by its role, its shard and its packed label.
    ///
    /// # Errors
    /// [`UnknownRole`].
    pub fn from_parts(role: u32, shard: u32, label: &[u8]) -> Result<Self, UnknownRole> {
        match role {
            role::CASE => Ok(Self::case(unpack(label))),
            role::SHARD => Ok(Self::shard(unpack(label), shard)),
            _ => {
                let service = Service::ALL.into_iter().find(|service| service.code() == role);
                service.map(Self::Service).ok_or(UnknownRole(role))
            }
        }
    }

    /// Its code in [`role`], and the number of its shard, 0 if it is none.
    pub fn codes(&self) -> (u32, u32) {
        match self {
            Self::Service(service) => (service.code(), 0),
            Self::Propagator { shard: None, .. } => (role::CASE, 0),
            Self::Propagator { shard: Some(number), .. } => (role::SHARD, *number),
        }
    }

    /// The service, if it is one.
    pub fn service(&self) -> Option<Service> {
        match self {
            Self::Service(service) => Some(*service),
            Self::Propagator { .. } => None,
        }
    }

    /// Whether it is this service.
    pub fn is(&self, service: Service) -> bool {
        self.service() == Some(service)
    }

    /// The label of its case; the name of a service.
    pub fn label(&self) -> &str {
        match self {
            Self::Service(service) => service.name(),
            Self::Propagator { label, .. } => label,
        }
    }
}

/// The name of its node: that of a service, or a label, followed by `/` and the number of a shard.
impl fmt::Display for Reporter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Propagator { label, shard: Some(shard) } => write!(f, "{label}/{shard}"),
            other => f.write_str(other.label()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::pack;

    #[test]
    fn a_process_is_read_as_it_was_written_whatever_its_label_looks_like() {
        let services = Service::ALL.map(Reporter::Service).into_iter();
        let labels = ["mc", "mc/3", "recorder", ""].into_iter();
        for reporter in services.chain(labels.flat_map(|label| [Reporter::case(label), Reporter::shard(label, 3)])) {
            let (role, shard) = reporter.codes();
            assert_eq!(Reporter::from_parts(role, shard, &pack::<32>(reporter.label())), Ok(reporter));
        }
        assert_eq!(Reporter::from_parts(7, 0, &[]), Err(UnknownRole(7)));
    }

    #[test]
    fn its_name_is_that_of_its_node() {
        let names = [Reporter::Service(Service::Recorder), Reporter::case("mc"), Reporter::shard("mc", 3)];
        assert_eq!(names.map(|reporter| reporter.to_string()), ["recorder", "mc", "mc/3"]);
    }
}
