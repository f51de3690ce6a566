//! A small server for one page, which only this machine can reach.
//!
//! | address | what |
//! |---|---|
//! | `/` | the page, which asks for the rest |
//! | `/state` | how far the run is, as JSON |
//! | `/report` | the report of what has arrived |

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use serde_json::{Value, json};
use tiny_http::{Header, Method, Request, Response, Server as Http};

const PAGE: &str = include_str!("page.html");

/// What is served.
#[derive(Debug, Default)]
struct Served {
    state: Value,
    report: Option<String>,
    /// How many reports there have been.
    version: u64,
}

/// A server on a thread of its own, until it is dropped.
pub struct Server {
    http: Arc<Http>,
    served: Arc<Mutex<Served>>,
    address: SocketAddr,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    /// Begins to serve at this port of the loopback interface; 0 stands for any free one.
    ///
    /// # Errors
    /// Why the port cannot be had.
    pub fn start(port: u16) -> Result<Self, String> {
        let place = (Ipv4Addr::LOCALHOST, port);
        let http = Http::http(place).map_err(|e| format!("--web: port {port} of this machine cannot be had: {e}"))?;
        let address = http.server_addr().to_ip().ok_or("--web: the server has no address")?;
        let (http, served) = (Arc::new(http), Arc::new(Mutex::new(Served::default())));
        let thread = std::thread::spawn({
            let (http, served) = (http.clone(), served.clone());
            move || http.incoming_requests().for_each(|request| answer(request, address, &served))
        });
        Ok(Self { http, served, address, thread: Some(thread) })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Sets how far the run is.
    pub fn set_state(&self, state: Value) {
        self.served.lock().unwrap_or_else(PoisonError::into_inner).state = state;
    }

    /// Sets the report.
    pub fn set_report(&self, report: String) {
        let mut served = self.served.lock().unwrap_or_else(PoisonError::into_inner);
        served.version += 1;
        served.report = Some(report);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.http.unblock();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn answer(request: Request, address: SocketAddr, served: &Mutex<Served>) {
    let path = request.url().split('?').next().unwrap_or_default().to_owned();
    let (status, kind, body) = match (request.method(), path.as_str()) {
        _ if !is_for(&request, address) => (403, "text/plain", "this page is for its own machine".to_owned()),
        (Method::Get | Method::Head, "/") => (200, "text/html", PAGE.to_owned()),
        (Method::Get | Method::Head, "/state") => {
            let served = served.lock().unwrap_or_else(PoisonError::into_inner);
            (200, "application/json", json!({"run": served.state, "version": served.version}).to_string())
        }
        (Method::Get | Method::Head, "/report") => {
            let report = served.lock().unwrap_or_else(PoisonError::into_inner).report.clone();
            report.map_or((404, "text/plain", "no case has arrived yet".to_owned()), |page| (200, "text/html", page))
        }
        (Method::Get | Method::Head, _) => (404, "text/plain", "there are /, /state and /report".to_owned()),
        _ => (405, "text/plain", "only GET".to_owned()),
    };
    let mut response = Response::from_string(body).with_status_code(status);
    let headers = [("Content-Type", format!("{kind}; charset=utf-8")), ("Cache-Control", "no-store".to_owned())];
    for (name, value) in headers {
        if let Ok(header) = Header::from_bytes(name, value) {
            response.add_header(header);
        }
    }
    // A reader that has gone away needs no answer.
    let _ = request.respond(response);
}

/// Whether a request names this server as its host. A page from elsewhere that has given its own name this machine's
/// address does not.
fn is_for(request: &Request, address: SocketAddr) -> bool {
    let host = request.headers().iter().find(|header| header.field.equiv("Host")).map(|header| header.value.as_str());
    let own = [address.to_string(), format!("localhost:{}", address.port())];
    host.is_some_and(|host| own.iter().any(|own| own == host))
}
