//! A real browser without a window, driven through its debugging pipe: real clicks and keys, not events of a script.
#![allow(dead_code)]

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::{Value, json};

/// Far longer than a healthy machine needs; only ends a test that would hang.
pub const WATCHDOG: Duration = Duration::from_secs(180);

/// The browser's command, or `None` after printing that there is none; unless `PHASECLOUD_REQUIRE_CHROMIUM=1`.
pub fn chromium() -> Option<&'static str> {
    let answers = |name: &&&str| {
        let output = Command::new(name).arg("--version").stdin(Stdio::null()).output();
        output.is_ok_and(|output| output.status.success())
    };
    let found = ["chromium", "chromium-browser", "google-chrome"].iter().find(answers).copied();
    if found.is_none() {
        let is_required = std::env::var_os("PHASECLOUD_REQUIRE_CHROMIUM").is_some_and(|value| value == "1");
        assert!(!is_required, "no Chromium");
        println!("skipped: no Chromium");
    }
    found
}

/// The arguments of a browser that may run as root, where it has no sandbox, on pages that are our own.
pub fn arguments(folder: &Path) -> Vec<String> {
    let fixed = ["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--no-first-run"];
    fixed.map(String::from).into_iter().chain([format!("--user-data-dir={}", folder.display())]).collect()
}

/// Ends a browser that a failed test would leave behind.
pub struct Killed(pub Child);

impl Drop for Killed {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A browser with one page.
pub struct Browser {
    to: File,
    from: Receiver<Value>,
    number: u64,
    session: Option<String>,
    /// The addresses that the page has asked for.
    pub asked: Vec<String>,
    _process: Killed,
}

impl Browser {
    /// Starts a browser with its files in `folder`, and opens a page of this size \[px\].
    pub fn open(chromium: &str, folder: &Path, address: &str, [width, height]: [u32; 2]) -> Self {
        std::fs::create_dir_all(folder).unwrap();
        let [to, from] = ["to", "from"].map(|name| folder.join(name));
        let made = Command::new("mkfifo").args([&to, &from]).status().unwrap();
        assert!(made.success());
        let mut command = Command::new("sh");
        command.args(["-c", r#"exec "$@" 3<"$TO" 4>"$FROM""#, "sh", chromium]).env("TO", &to).env("FROM", &from);
        command.args(arguments(&folder.join("profile"))).arg("--remote-debugging-pipe");
        command.arg(format!("--window-size={width},{height}")).arg("about:blank");
        let process = Killed(command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap());
        let to = File::options().write(true).open(to).unwrap();
        let (send, messages) = channel();
        let from = BufReader::new(File::open(from).unwrap());
        std::thread::spawn(move || {
            for message in from.split(0).map_while(Result::ok) {
                if serde_json::from_slice(&message).is_ok_and(|message: Value| send.send(message).is_err()) {
                    return;
                }
            }
        });
        let mut browser = Self { to, from: messages, number: 0, session: None, asked: Vec::new(), _process: process };
        let page = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let attached = browser.call("Target.attachToTarget", json!({"targetId": page["targetId"], "flatten": true}));
        browser.session = Some(attached["sessionId"].as_str().unwrap().to_owned());
        browser.call("Network.enable", json!({}));
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        browser.call("Emulation.setDeviceMetricsOverride", size);
        browser.go_to(address);
        browser
    }

    /// Opens another page and waits until it is there.
    pub fn go_to(&mut self, address: &str) {
        self.call("Page.navigate", json!({"url": address}));
        self.wait_for("document.readyState === 'complete' && location.href !== 'about:blank'");
    }

    /// Sends a command of the debugging protocol and returns its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let mut message = json!({"id": self.number, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            message["sessionId"] = session.clone().into();
        }
        self.to.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let answer = self.from.recv_timeout(WATCHDOG).expect("the browser answers");
            if answer["method"] == "Network.requestWillBeSent" {
                self.asked.push(answer["params"]["request"]["url"].as_str().unwrap_or_default().to_owned());
            }
            if answer["id"] == self.number {
                assert!(answer.get("error").is_none(), "{method}: {answer}");
                return answer["result"].clone();
            }
        }
    }

    /// The value of an expression in the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let asked = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let answer = self.call("Runtime.evaluate", asked);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// The text of the element that a selector finds.
    pub fn text(&mut self, selector: &str) -> String {
        self.value(&format!("document.querySelector(`{selector}`).textContent")).as_str().unwrap().to_owned()
    }

    /// Waits until an expression is true.
    pub fn wait_for(&mut self, expression: &str) {
        let started = std::time::Instant::now();
        while self.value(expression) != true {
            assert!(started.elapsed() < WATCHDOG, "never true: {expression}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The place in the window \[px\] that is at these shares of an element's width and height, scrolled into view.
    pub fn place(&mut self, selector: &str, [across, down]: [f64; 2]) -> [f64; 2] {
        let place = self.value(&format!(
            "(() => {{ const e = document.querySelector(`{selector}`); e.scrollIntoView({{block: 'center', behavior: 'instant'}}); \
             const b = e.getBoundingClientRect(); return [b.left + {across} * b.width, b.top + {down} * b.height]; }})()"
        ));
        [0, 1].map(|k| place[k].as_f64().unwrap())
    }

    /// Moves the pointer to a place in an element.
    pub fn point(&mut self, selector: &str, shares: [f64; 2]) {
        let [x, y] = self.place(selector, shares);
        self.call("Input.dispatchMouseEvent", json!({"type": "mouseMoved", "x": x, "y": y}));
    }

    /// Clicks at a place in an element.
    pub fn click(&mut self, selector: &str, shares: [f64; 2]) {
        let [x, y] = self.place(selector, shares);
        for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
            let event = json!({"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1});
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// Presses a key.
    pub fn press(&mut self, key: &str) {
        let code = match key {
            "ArrowLeft" => 37,
            "ArrowUp" => 38,
            "ArrowRight" => 39,
            "ArrowDown" => 40,
            "Home" => 36,
            "End" => 35,
            "Tab" => 9,
            " " => 32,
            other => panic!("{other} is not a key of this keyboard"),
        };
        for kind in ["rawKeyDown", "keyUp"] {
            let event = json!({"type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code});
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// A picture of the window as a PNG in base64.
    pub fn picture(&mut self) -> String {
        self.call("Page.captureScreenshot", json!({"format": "png"}))["data"].as_str().unwrap().to_owned()
    }
}
