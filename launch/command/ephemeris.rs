//! An unaveraged orbit as an Orbit Ephemeris Message in key-value notation (CCSDS 502.0-B-3, Orbit Data Messages, Sect.
//! 5).
//!
//! The model's axes are the mean equator and equinox of the epoch, which the registry of frames of version 3 calls
//! MOE_EARTH. Times are terrestrial time, which has no leap seconds.

use std::time::SystemTime;

use density::model::{earth, osculating};
use nodes::files::scenario_file::Epoch;

/// How the states of the model become positions and velocities at dates.
#[derive(Debug)]
pub(super) struct Ephemeris {
    pub epoch: Epoch,
    /// Nominal semi-major axis, the unit of length \[Earth radii\].
    pub semi_major_axis: f64,
}

impl Ephemeris {
    /// Prints what comes before the states at `times` \[yr\].
    pub fn head(&self, name: &str, times: &[f64]) {
        let at = |time: Option<&f64>| self.instant(time.copied().unwrap_or(0.0));
        let created = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        say!("CCSDS_OEM_VERS = 3.0");
        say!("CREATION_DATE = {}", created.trim_end_matches('Z'));
        say!("ORIGINATOR = PHASECLOUD");
        say!("");
        say!("META_START");
        say!("OBJECT_NAME = {name}");
        say!("OBJECT_ID = UNKNOWN");
        say!("CENTER_NAME = EARTH");
        say!("REF_FRAME = MOE_EARTH");
        say!("REF_FRAME_EPOCH = {}", at(None));
        say!("TIME_SYSTEM = TT");
        say!("START_TIME = {}", at(times.first()));
        say!("STOP_TIME = {}", at(times.last()));
        say!("META_STOP");
        say!("COMMENT Position in km and velocity in km/s; the axes are the mean equator and equinox of the epoch.");
    }

    /// The instant at a time \[yr\]. The caller has seen to it that there is one.
    fn instant(&self, time: f64) -> String {
        self.epoch.instant_after(time).unwrap_or_default()
    }

    /// Prints the state at `time` \[yr\].
    pub fn row(&self, time: f64, state: osculating::State) {
        const METRES_OF_KM: f64 = 1e3;
        let length = self.semi_major_axis * earth::RADIUS / METRES_OF_KM;
        let speed = length * earth::mean_motion(self.semi_major_axis);
        let [x, y, z, vx, vy, vz] = state;
        let [position, velocity] = [([x, y, z], length), ([vx, vy, vz], speed)]
            .map(|(vector, unit)| vector.map(|part| format!("{:.9}", part * unit)).join(" "));
        say!("{} {position} {velocity}", self.instant(time));
    }
}
