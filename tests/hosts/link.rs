//! A link on loopback that is slow, loses what it carries for a while, or is cut.
//!
//! It stands in for a real one: every byte comes 50 ms late, and one block in a hundred holds up all after it for 250
//! ms, as a lost segment does until TCP has sent it again.

use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::thread::spawn;
use std::time::{Duration, Instant};

const DELAY: Duration = Duration::from_millis(50);
const HOLD_UP: Duration = Duration::from_millis(250);
/// A block of bytes on the wire.
const BLOCK: usize = 16 << 10;

#[derive(Default)]
struct State {
    is_cut: AtomicBool,
    carried: Mutex<u64>,
    streams: Mutex<Vec<TcpStream>>,
}

/// The link; its end nearer to the worker is `port`.
pub struct Link {
    pub port: u16,
    state: Arc<State>,
}

impl Link {
    pub fn to(target: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let link = Self { port: listener.local_addr().unwrap().port(), state: Arc::default() };
        let state = Arc::clone(&link.state);
        spawn(move || {
            for near in listener.incoming().flatten() {
                if state.is_cut.load(Ordering::SeqCst) {
                    continue;
                }
                let Ok(far) = TcpStream::connect(("127.0.0.1", target)) else { continue };
                state.streams.lock().unwrap().extend([near.try_clone().unwrap(), far.try_clone().unwrap()]);
                carry(near.try_clone().unwrap(), far.try_clone().unwrap(), Arc::clone(&state));
                carry(far, near, Arc::clone(&state));
            }
        });
        link
    }

    /// Cuts the link: connections stand still, as over a cable that is pulled, and no new ones can be opened.
    pub fn cut(&self) {
        self.state.is_cut.store(true, Ordering::SeqCst);
    }

    /// Mends the link. The bytes that were under way when it was cut are lost, and so are their connections.
    pub fn mend(&self) {
        self.state.streams.lock().unwrap().drain(..).for_each(|stream| drop(stream.shutdown(Shutdown::Both)));
        self.state.is_cut.store(false, Ordering::SeqCst);
    }

    /// Bytes carried so far, both ways.
    pub fn carried(&self) -> u64 {
        *self.state.carried.lock().unwrap()
    }
}

fn carry(mut from: TcpStream, mut to: TcpStream, state: Arc<State>) {
    let (sender, receiver) = channel::<(Instant, Vec<u8>)>();
    spawn(move || {
        let mut block = vec![0; BLOCK];
        while let Ok(count @ 1..) = from.read(&mut block) {
            if sender.send((Instant::now() + DELAY, block[..count].to_vec())).is_err() {
                break;
            }
        }
    });
    spawn(move || {
        for (number, (due, block)) in receiver.iter().enumerate() {
            let due = if number % 100 == 99 { due + HOLD_UP } else { due };
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            if state.is_cut.load(Ordering::SeqCst) {
                break; // the block is lost, and TCP does not send it again
            }
            *state.carried.lock().unwrap() += block.len() as u64;
            if to.write_all(&block).is_err() {
                break;
            }
        }
        if !state.is_cut.load(Ordering::SeqCst) {
            let _ = to.shutdown(Shutdown::Both);
        }
    });
}
