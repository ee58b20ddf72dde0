//! A real browser without a screen, driven by its DevTools protocol: Chromium, or what is built from it.

use crate::cluster::Process;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// What it may be called.
pub const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Longer than any answer takes, on a machine that does other things as well.
const PATIENCE: Duration = Duration::from_secs(60);

/// A browser with one page open.
pub struct Browser {
    say: ChildStdin,
    hear: Receiver<Value>,
    last: u64,
    session: String,
    /// What it said unasked: the console's lines, exceptions, what the network refused.
    pub events: Vec<Value>,
    process: Process,
    profile: tempfile::TempDir,
}

/// Where a browser is, if this machine has one.
pub fn find() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    let found =
        std::env::split_paths(&path).flat_map(|folder| NAMES.map(|name| folder.join(name))).find(|f| f.is_file());
    if found.is_none() {
        eprintln!("skipped: none of {NAMES:?} is on the PATH");
    }
    found
}

impl Browser {
    /// Starts a browser with a window of so many pixels.
    pub fn start(program: &Path, width: u32, height: u32) -> Self {
        Self::start_with(program, &[], width, height)
    }

    /// The same with further arguments.
    pub fn start_with(program: &Path, more: &[&str], width: u32, height: u32) -> Self {
        let profile = tempfile::tempdir().unwrap();
        // The protocol is spoken on descriptors 3 and 4, which a shell can open.
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 0</dev/null 1>/dev/null 2>/dev/null"]).arg(program);
        command.args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run"]);
        command.args(["--remote-debugging-pipe", "--hide-scrollbars", "--disable-background-networking"]);
        command.args(more).arg(format!("--user-data-dir={}", profile.path().display()));
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let (say, out) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let (sender, hear) = channel();
        std::thread::spawn(move || {
            for message in BufReader::new(out).split(0).map_while(Result::ok) {
                let message: Value = serde_json::from_slice(&message).unwrap();
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let mut browser =
            Self { say, hear, last: 0, session: String::new(), events: Vec::new(), process: child.into(), profile };
        let target = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let target = target["targetId"].as_str().unwrap().to_owned();
        let attached = browser.call("Target.attachToTarget", &json!({ "targetId": target, "flatten": true }));
        browser.session = attached["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Page.enable", "Runtime.enable", "Log.enable", "Network.enable"] {
            browser.call(domain, &json!({}));
        }
        // What the page takes, whoever else uses the processors.
        browser.call("Performance.enable", &json!({ "timeDomain": "threadTicks" }));
        browser.resize(width, height);
        browser
    }

    /// Asks, and waits for the answer.
    pub fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": parameters });
        if !self.session.is_empty() {
            message["sessionId"] = self.session.as_str().into();
        }
        self.say.write_all(&[message.to_string().as_bytes(), b"\0"].concat()).unwrap();
        loop {
            let heard = self.hear.recv_timeout(PATIENCE).unwrap_or_else(|error| panic!("{method}: {error}"));
            if heard["id"] == self.last {
                assert!(heard["error"].is_null(), "{method}: {}", heard["error"]);
                return heard["result"].clone();
            }
            self.events.push(heard);
        }
    }

    /// Opens an address, and waits until it is loaded.
    pub fn open(&mut self, url: &str) {
        let answer = self.call("Page.navigate", &json!({ "url": url }));
        assert!(answer["errorText"].is_null(), "{url}: {answer}");
        self.wait("document.readyState === 'complete'");
    }

    /// The value of an expression on the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.call("Runtime.evaluate", &parameters);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true; how long that took.
    pub fn wait(&mut self, expression: &str) -> Duration {
        self.wait_for(expression, PATIENCE)
    }

    /// The same for what takes longer than an answer.
    pub fn wait_for(&mut self, expression: &str, patience: Duration) -> Duration {
        let begin = Instant::now();
        while self.value(&format!("Boolean({expression})")) != true {
            assert!(begin.elapsed() < patience, "never: {expression}\n{}", self.value("document.body.innerText"));
            std::thread::sleep(Duration::from_millis(20));
        }
        begin.elapsed()
    }

    /// Gives the window another size.
    pub fn resize(&mut self, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500 });
        self.call("Emulation.setDeviceMetricsOverride", &size);
    }

    /// Light or dark, as the reader's system would say.
    pub fn scheme(&mut self, scheme: &str) {
        let feature = json!({ "name": "prefers-color-scheme", "value": scheme });
        self.call("Emulation.setEmulatedMedia", &json!({ "features": [feature] }));
    }

    /// A picture of the page: of the window, or of all of it.
    pub fn screenshot(&mut self, file: &Path, whole: bool) {
        use base64::Engine;
        let answer = self.call("Page.captureScreenshot", &json!({ "format": "png", "captureBeyondViewport": whole }));
        let png = base64::engine::general_purpose::STANDARD.decode(answer["data"].as_str().unwrap()).unwrap();
        std::fs::write(file, png).unwrap();
    }

    /// What went wrong on the page so far: the console's warnings and errors, exceptions, refusals.
    pub fn complaints(&mut self) -> Vec<String> {
        // Whatever was said before this answer has been heard after it.
        self.value("0");
        let bad = |event: &&Value| {
            let said = event["params"].to_string();
            match event["method"].as_str().unwrap_or_default() {
                "Runtime.exceptionThrown" => true,
                "Log.entryAdded" => ["error", "warning"].iter().any(|l| event["params"]["entry"]["level"] == *l),
                "Runtime.consoleAPICalled" => {
                    said.contains("\"type\":\"error\"") || said.contains("\"type\":\"warning\"")
                }
                _ => false,
            }
        };
        self.events.iter().filter(bad).map(|event| event["params"].to_string()).collect()
    }

    /// The hosts from which anything was asked for.
    pub fn hosts(&self) -> std::collections::BTreeSet<String> {
        let asked = self.events.iter().filter(|event| event["method"] == "Network.requestWillBeSent");
        let address = |event: &Value| event["params"]["request"]["url"].as_str().unwrap_or_default().to_owned();
        let host = |url: String| url.split('/').nth(2).unwrap_or_default().to_owned();
        asked.map(address).filter(|url| !url.starts_with("data:")).map(host).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Its children go with it, and may still write to the profile.
        let _ = self.say.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        let _ = self.process.wait_for(Duration::from_secs(5));
        let _ = std::fs::remove_dir_all(self.profile.path());
    }
}
