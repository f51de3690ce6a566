//! Who reports on `phasecloud/status`.

use std::fmt;

use crate::service::Service;

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

impl Reporter {
    /// The process of this name: that of a service, or a label, followed by `/` and the number of a shard.
    pub fn named(name: &str) -> Self {
        if let Some(service) = Service::named(name) {
            return Self::Service(service);
        }
        let of_shard = name.rsplit_once('/').and_then(|(label, number)| {
            let shard = number.parse().ok().filter(|shard: &u32| shard.to_string() == number)?;
            Some(Self::Propagator { label: label.into(), shard: Some(shard) })
        });
        of_shard.unwrap_or_else(|| Self::Propagator { label: name.into(), shard: None })
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

    #[test]
    fn a_name_is_read_once_and_written_as_it_was() {
        let of_shard = Reporter::Propagator { label: "mc".into(), shard: Some(3) };
        assert_eq!(Reporter::named("mc/3"), of_shard);
        assert_eq!(Reporter::named("recorder"), Reporter::Service(Service::Recorder));
        for name in ["mc", "mc/3", "recorder", "mc/x", "mc/03", "a/b/1", ""] {
            assert_eq!(Reporter::named(name).to_string(), name);
        }
        assert_eq!((of_shard.label(), of_shard.service()), ("mc", None));
    }
}
