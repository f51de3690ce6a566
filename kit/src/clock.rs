//! The time of day, for names and records only. Durations are measured with a clock that nobody can set.

use std::time::{Duration, SystemTime};

/// The last second of the year 9999, the last one that can be written \[s since 1970\].
const LAST: Duration = Duration::from_secs(253_402_300_799);

/// Now, or the nearest time that can be written: a machine whose clock was never set may report a year before 1970.
pub fn now() -> SystemTime {
    writable(SystemTime::now())
}

/// Now in UTC, to a second.
pub fn seconds() -> String {
    humantime::format_rfc3339_seconds(now()).to_string()
}

/// Now in UTC, to a millisecond.
pub fn millis() -> String {
    humantime::format_rfc3339_millis(now()).to_string()
}

fn writable(time: SystemTime) -> SystemTime {
    time.clamp(SystemTime::UNIX_EPOCH, SystemTime::UNIX_EPOCH + LAST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_before_1970_or_after_9999_can_still_be_written() {
        let year = Duration::from_secs(31_557_600);
        for (time, written) in [
            (SystemTime::UNIX_EPOCH - year, "1970-01-01T00:00:00Z"),
            (SystemTime::UNIX_EPOCH + year, "1971-01-01T06:00:00Z"),
            (SystemTime::UNIX_EPOCH + 9000 * year, "9999-12-31T23:59:59Z"),
        ] {
            assert_eq!(humantime::format_rfc3339_seconds(writable(time)).to_string(), written);
        }
    }
}
