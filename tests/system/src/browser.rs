//! A headless Chromium, led by the DevTools protocol.

use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use test_bus::Tries;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// How long the browser may take to start, and for any answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// How often is looked whether something is so.
const GLANCE: Duration = Duration::from_millis(50);

/// A browser with one page; ended when dropped.
pub struct Browser {
    chromium: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: String,
    last: u64,
    /// Errors that the page's program has thrown, and what its policy has refused.
    pub complaints: Vec<String>,
    _folder: TempDir,
}

impl Browser {
    /// Starts.
    pub fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder for the browser");
        let mut command = Command::new("chromium");
        command.args([
            "--headless=new",
            "--disable-gpu",
            "--no-first-run",
            "--disable-extensions",
            "--hide-scrollbars",
        ]);
        // Root, as in containers, has no sandbox; the page is ours.
        command.args(["--no-sandbox", "--disable-dev-shm-usage", "--remote-debugging-port=0"]);
        command.arg(format!("--user-data-dir={}", folder.path().display())).arg("about:blank");
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let chromium =
            command.spawn().unwrap_or_else(|error| panic!("chromium: {error}; `cargo xtask setup` installs it"));
        let end = Instant::now() + PATIENCE;
        let port = folder.path().join("DevToolsActivePort");
        let address = loop {
            let words = std::fs::read_to_string(&port).unwrap_or_default();
            if let [port, path] = words.lines().collect::<Vec<_>>()[..] {
                break format!("ws://127.0.0.1:{port}{path}");
            }
            assert!(Instant::now() < end, "chromium does not open its DevTools");
            std::thread::sleep(GLANCE);
        };
        let (socket, _) = tungstenite::connect(&address).expect("DevTools");
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        }
        let mut browser =
            Self { chromium, socket, session: String::new(), last: 0, complaints: Vec::new(), _folder: folder };
        let target = browser.ask("Target.createTarget", json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = browser.ask("Target.attachToTarget", attach)["sessionId"].as_str().expect("a session").to_owned();
        browser.session = session;
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            browser.ask(domain, json!({}));
        }
        browser
    }

    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut request = json!({ "id": self.last, "method": method, "params": parameters });
        if !self.session.is_empty() {
            request["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(request.to_string())).expect("DevTools listen");
        loop {
            let message = self.socket.read().expect("DevTools answer");
            let Message::Text(text) = message else { continue };
            let told: Value = serde_json::from_str(&text).expect("JSON");
            if told["id"] == json!(self.last) {
                assert!(told["error"].is_null(), "{method}: {}", told["error"]);
                return told["result"].clone();
            }
            let kind = told["method"].as_str().unwrap_or_default();
            if kind == "Runtime.exceptionThrown"
                || (kind == "Log.entryAdded" && told["params"]["entry"]["level"] == "error")
            {
                self.complaints.push(told["params"].to_string());
            }
        }
    }

    /// Shows a page in a window of this size (CSS pixels), light or dark.
    pub fn open(&mut self, url: &str, size: [u32; 2], dark: bool) {
        self.look(size, dark);
        self.ask("Page.navigate", json!({ "url": url }));
        self.until("document.readyState === 'complete'");
    }

    /// Changes the window.
    pub fn look(&mut self, [width, height]: [u32; 2], dark: bool) {
        let phone = width < 600;
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": if phone { 2 } else { 1 }, "mobile": phone });
        self.ask("Emulation.setDeviceMetricsOverride", size);
        let scheme =
            json!({ "features": [{ "name": "prefers-color-scheme", "value": if dark { "dark" } else { "light" } }] });
        self.ask("Emulation.setEmulatedMedia", scheme);
    }

    /// What an expression gives in the page.
    pub fn eval(&mut self, expression: &str) -> Value {
        self.given(expression).unwrap_or_else(|exception| panic!("{expression}: {exception}"))
    }

    /// What an expression gives in the page, or the exception it throws.
    fn given(&mut self, expression: &str) -> Result<Value, Value> {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut result = self.ask("Runtime.evaluate", parameters);
        match result["exceptionDetails"].take() {
            Value::Null => Ok(result["result"]["value"].take()),
            exception => Err(exception),
        }
    }

    /// Waits until an expression is true. An element that it reads may not have been made yet: an exception counts as not true.
    pub fn until(&mut self, expression: &str) {
        let end = Instant::now() + PATIENCE;
        loop {
            let given = self.given(expression);
            if given == Ok(json!(true)) {
                return;
            }
            if Instant::now() > end {
                let words = self.eval("document.body.innerText");
                panic!("never true: {expression}; it gives {given:?}; {:?}; the page: {words}", self.complaints);
            }
            std::thread::sleep(GLANCE);
        }
    }

    /// Presses a key until an expression is true: a busy PC loses the servo now and then, and a finger that has lost it must be
    /// asked again.
    pub fn press_until(&mut self, key: &str, expression: &str) {
        let mut tries = Tries::of("a key");
        loop {
            self.press(key);
            let end = Instant::now() + PATIENCE / 4;
            while Instant::now() < end {
                if self.given(expression) == Ok(json!(true)) {
                    return;
                }
                std::thread::sleep(GLANCE);
            }
            tries.spoilt();
        }
    }

    /// Presses and lets go a key.
    pub fn press(&mut self, key: &str) {
        let text = if key.chars().count() == 1 { key } else { "" };
        let code = match key {
            "Escape" => 27,
            "Enter" => 13,
            "Tab" => 9,
            _ => key.to_uppercase().bytes().next().unwrap_or_default(),
        };
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({ "type": kind, "key": key, "windowsVirtualKeyCode": code });
            if kind == "keyDown" && !text.is_empty() {
                event["text"] = json!(text);
            }
            self.ask("Input.dispatchKeyEvent", event);
        }
    }

    /// Clicks in the middle of an element, which must be visible and not covered.
    pub fn click(&mut self, selector: &str) {
        let middle = self.eval(&format!(
            "(() => {{ const e = document.querySelector({selector:?}); e.scrollIntoView({{ block: 'center' }}); \
             const r = e.getBoundingClientRect(), p = [r.x + r.width / 2, r.y + r.height / 2]; \
             return e.contains(document.elementFromPoint(...p)) ? p : null; }})()"
        ));
        assert!(middle.is_array(), "{selector} is hidden or covered");
        for kind in ["mousePressed", "mouseReleased"] {
            let event = json!({ "type": kind, "x": middle[0], "y": middle[1], "button": "left", "clickCount": 1 });
            self.ask("Input.dispatchMouseEvent", event);
        }
    }

    /// Writes a picture of the window.
    pub fn picture(&mut self, file: &Path) {
        let picture = self.ask("Page.captureScreenshot", json!({ "format": "png" }));
        let bytes = base64(picture["data"].as_str().expect("a picture"));
        std::fs::write(file, bytes).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    }
}

/// Decodes base64 without line breaks.
fn base64(text: &str) -> Vec<u8> {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digits = text.bytes().filter_map(|byte| LETTERS.iter().position(|&letter| letter == byte));
    let (mut bits, mut count, mut bytes) = (0_u32, 0, Vec::with_capacity(text.len() * 3 / 4));
    for digit in digits {
        bits = (bits << 6 | digit as u32) & 0xFFFF;
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    bytes
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.chromium.kill();
        let _ = self.chromium.wait();
    }
}
