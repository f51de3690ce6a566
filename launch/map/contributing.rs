//! A worker's end of a map that is computed on several hosts: it asks home for parts, computes them, and brings what it
//! has found.

use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::spawn;
use std::time::{Duration, Instant};

use bridge::dealing::{Answer, Asker, Brought};
use bridge::greeting::Hello;
use bridge::plan::MapPlan;
use bridge::zenoh::Session;
use density::exact::Estimated;
use messages::wait::Signals;
use nodes::files::input::InputFile;
use nodes::files::map_file::MapFile;

use super::parts::{Found, Parts, Place};

/// Longest time between two questions while parts are computed: home takes a host for lost that is silent for much
/// longer.
const SIGN_OF_LIFE: Duration = Duration::from_millis(500);
/// Time between two questions while there is nothing to do, and between two looks for a request to stop.
const PAUSE: Duration = Duration::from_millis(50);

/// How a worker's contribution has ended.
pub struct Contribution {
    /// Whether the map is complete; if not, the user has asked to stop.
    pub is_complete: bool,
    /// How many parts were computed here and brought home.
    pub parts: usize,
}

/// Computes parts of the map of `plan` until home says that it has ended.
///
/// # Errors
/// Why the map cannot be completed, or why it cannot be contributed to.
pub fn contribute(zenoh: &Session, plan: &MapPlan, hello: &Hello, signals: &Signals) -> Result<Contribution, String> {
    let workshop = Workshop::open(read(plan)?)?;
    let asker = Asker::new(zenoh, plan.map_id, hello.process);
    let (mut done, mut under_way, mut parts) = (Vec::new(), 0, 0);
    while !signals.stop_requested() {
        let is_free = under_way == 0;
        if let Some(answer) = asker.ask(&done, is_free).map_err(|e| e.to_string())? {
            parts += done.len();
            done.clear();
            match answer {
                Answer::Compute(places) if is_free => {
                    under_way = places.len();
                    workshop.begin(places)?;
                }
                Answer::Compute(_) | Answer::Nothing => {}
                Answer::Complete => {
                    asker.leave(&[]);
                    return Ok(Contribution { is_complete: true, parts });
                }
                Answer::Failed(why) => {
                    asker.leave(&[]);
                    return Err(format!("the map at home has failed: {why}"));
                }
                Answer::Interrupted => {
                    asker.leave(&[]);
                    return Err(INTERRUPTED.into());
                }
                Answer::Stranger => return Err(STRANGER.into()),
            }
        }
        workshop.wait(&mut under_way, &mut done, signals)?;
    }
    asker.leave(&done);
    Ok(Contribution { is_complete: false, parts: parts + done.len() })
}

const INTERRUPTED: &str =
    "home was interrupted; what was computed here is kept there, and `phasecloud join` joins again once home goes on";
const STRANGER: &str = "home does not know this process any more: home was started anew, or another process has joined under this name; \
                        `phasecloud join` joins again";

/// The map of a plan, which was checked at home and so is good here.
fn read(plan: &MapPlan) -> Result<MapFile, String> {
    let file = InputFile::from_text(&plan.file, &plan.text);
    let scenario = InputFile::from_text(Path::new("the scenario file at home"), &plan.scenario);
    MapFile::check_with_scenario(&file, &scenario).map_err(|e| e.to_string())
}

/// A thread that computes parts, while another one talks to home.
struct Workshop {
    orders: Sender<Vec<Place>>,
    results: Receiver<Brought>,
}

impl Workshop {
    fn open(map: MapFile) -> Result<Self, String> {
        Parts::of(&map)?;
        let (orders, to_do) = channel::<Vec<Place>>();
        let (finished, results) = channel();
        spawn(move || {
            let Ok(parts) = Parts::of(&map) else { return };
            for places in to_do {
                parts.compute(&places, |place, found| {
                    // If nobody waits any more, this process ends.
                    let _ = finished.send(brought(place, found));
                });
            }
        });
        Ok(Self { orders, results })
    }

    fn begin(&self, places: Vec<Place>) -> Result<(), String> {
        self.orders.send(places).map_err(|_| CRASHED.to_owned())
    }

    /// Waits until all that is under way is done, or it is time to ask home again.
    fn wait(&self, under_way: &mut usize, done: &mut Vec<Brought>, signals: &Signals) -> Result<(), String> {
        let start = Instant::now();
        let longest = if *under_way == 0 { PAUSE } else { SIGN_OF_LIFE };
        while start.elapsed() < longest && !signals.stop_requested() {
            match self.results.recv_timeout(PAUSE) {
                Ok(part) => {
                    done.push(part);
                    *under_way = under_way.saturating_sub(1);
                    if *under_way == 0 {
                        break;
                    }
                }
                Err(RecvTimeoutError::Disconnected) => return Err(CRASHED.into()),
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
        Ok(())
    }
}

const CRASHED: &str = "the computation of a part of the map has crashed here";

/// What has been found for a part, to the last bit.
fn brought(place: Place, found: Found) -> Brought {
    let bits = |Estimated { value, error }: Estimated| [value.to_bits(), error.to_bits()];
    Brought { place, found: found.map(|numbers| numbers.into_iter().map(bits).collect()) }
}
