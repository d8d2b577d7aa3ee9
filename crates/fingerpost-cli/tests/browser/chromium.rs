//! Chromium without a window, driven through its DevTools protocol over a pair of pipes.

use std::fs::{self, File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::{Value, json};
use tempfile::TempDir;

/// A page in a browser that ends with the value.
pub(crate) struct Page {
    browser: Child,
    commands: File,
    answers: BufReader<File>,
    session: Option<String>,
    next_id: u64,
    /// Messages of the page's console and its errors.
    pub(crate) complaints: Vec<String>,
    _profile: TempDir,
}

impl Page {
    /// Opens an address in a window of 1280 x 800 pixels.
    pub(crate) fn open(address: &str) -> Self {
        let profile = TempDir::new().unwrap();
        let pipes = ["commands", "answers"].map(|name| profile.path().join(name));
        assert!(Command::new("mkfifo").args(&pipes).status().unwrap().success());
        let program = std::env::var("FINGERPOST_CHROMIUM").unwrap_or_else(|_| "chromium".to_owned());
        // The browser reads commands from file descriptor 3 and answers through 4.
        let line = r#"exec "$0" --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --window-size=1280,800 \
            --user-data-dir="$1/profile" --remote-debugging-pipe about:blank 3<"$2" 4>"$3""#;
        let browser = Command::new("sh")
            .args(["-c", line, &program])
            .arg(profile.path())
            .args(&pipes)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let commands = OpenOptions::new().write(true).open(&pipes[0]).unwrap();
        let answers = BufReader::new(File::open(&pipes[1]).unwrap());
        let mut page = Self {
            browser,
            commands,
            answers,
            session: None,
            next_id: 0,
            complaints: Vec::new(),
            _profile: profile,
        };
        let target = page.call("Target.createTarget", json!({ "url": "about:blank" }))["targetId"].clone();
        let attached = page.call("Target.attachToTarget", json!({ "targetId": target, "flatten": true }));
        page.session = Some(attached["sessionId"].as_str().unwrap().to_owned());
        page.resize([1280, 800]);
        page.call("Emulation.setScrollbarsHidden", json!({ "hidden": true }));
        page.call("Runtime.enable", json!({}));
        page.call("Page.enable", json!({}));
        page.go_to(address);
        page
    }

    /// Goes to another address.
    pub(crate) fn go_to(&mut self, address: &str) {
        self.call("Page.navigate", json!({ "url": address }));
    }

    /// Makes the window another size, pixels.
    pub(crate) fn resize(&mut self, [width, height]: [u32; 2]) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Asks for pages in `light` or `dark`.
    pub(crate) fn prefer(&mut self, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Calls a method of the protocol; what the page complains about meanwhile is kept.
    fn call(&mut self, method: &str, params: Value) -> Value {
        self.next_id += 1;
        let mut message = json!({ "id": self.next_id, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).unwrap();
        loop {
            let mut answer = Vec::new();
            self.answers.read_until(0, &mut answer).unwrap();
            assert_eq!(answer.pop(), Some(0), "the browser has gone; is it installed?");
            let mut answer: Value = serde_json::from_slice(&answer).unwrap();
            if answer["method"] == "Runtime.exceptionThrown" || answer["params"]["type"] == "error" {
                self.complaints.push(answer["params"].to_string());
            }
            if answer["id"] == self.next_id {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
        }
    }

    /// What an expression of the page is worth.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut result = self.call("Runtime.evaluate", params);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {result}");
        result["result"]["value"].take()
    }

    /// Waits until an expression is true.
    pub(crate) fn wait_for(&mut self, expression: &str) {
        let patient = format!(
            "new Promise((done) => {{ let left = 400; const look = () => {{
                 let seen = false; try {{ seen = !!({expression}); }} catch {{}}
                 seen || !left-- ? done(seen) : setTimeout(look, 25); }}; look(); }})"
        );
        assert_eq!(self.value(&patient), json!(true), "{expression} stays false; {:?}", self.complaints);
    }

    /// A movement or press of the mouse; `kind` is `mouseMoved`, `mousePressed` or `mouseReleased`.
    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], button: &str) {
        let buttons = u8::from(kind != "mouseReleased" && button == "left");
        let params = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1, "pointerType": "mouse"
        });
        self.call("Input.dispatchMouseEvent", params);
    }

    /// A click with a button of the mouse.
    pub(crate) fn click(&mut self, at: [f64; 2], button: &str) {
        self.mouse("mouseMoved", at, "none");
        self.mouse("mousePressed", at, button);
        self.mouse("mouseReleased", at, button);
    }

    /// Drags with the left button.
    pub(crate) fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.mouse("mouseMoved", from, "none");
        self.mouse("mousePressed", from, "left");
        let middle = [0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1])];
        self.mouse("mouseMoved", middle, "left");
        self.mouse("mouseMoved", to, "left");
        self.mouse("mouseReleased", to, "left");
    }

    /// Turns the wheel upwards.
    pub(crate) fn wheel_up(&mut self, [x, y]: [f64; 2]) {
        let params = json!({ "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": -400 });
        self.call("Input.dispatchMouseEvent", params);
    }

    /// Presses a key; `modifiers` is 2 for Ctrl, 8 for Shift.
    pub(crate) fn key(&mut self, key: &str, modifiers: u8) {
        for kind in ["rawKeyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", json!({ "type": kind, "key": key, "modifiers": modifiers }));
        }
    }

    /// Asserts that a screen reader has a name for everything that can be used or is a picture.
    pub(crate) fn has_names(&mut self) {
        let nameless = self.value(
            "[...document.querySelectorAll('button, input, [role=img], [role=group], summary')]
                 .filter((one) => !(one.getAttribute('aria-label') || one.labels?.[0]?.textContent || one.textContent).trim())
                 .map((one) => one.outerHTML)",
        );
        assert_eq!(nameless, json!([]));
    }

    /// Asserts that the page is no wider than windows of phones and of computers and has no serious fault for those who see or
    /// move otherwise, light and dark, and writes what each shows to `NAME_SCHEME_WIDTH.png`.
    pub(crate) fn is_shown_in_every_window(&mut self, name: &str) {
        for scheme in ["light", "dark"] {
            self.prefer(scheme);
            for width in [1280, 390] {
                self.resize([width, 800]);
                let wide = self.value("document.documentElement.scrollWidth").as_f64().unwrap();
                assert!(wide <= f64::from(width), "the page is {wide} pixels wide in a window of {width}");
                let file = format!("{name}_{scheme}_{width}.png");
                self.screenshot(&Path::new(env!("CARGO_TARGET_TMPDIR")).join(file));
                assert_eq!(self.serious_faults(), json!([]), "{name}, {scheme}, {width}");
            }
        }
    }

    /// What axe-core, the file that FINGERPOST_AXE names, finds serious or critical: each rule with the elements that break it.
    fn serious_faults(&mut self) -> Value {
        let path = std::env::var("FINGERPOST_AXE").unwrap();
        if self.value("typeof axe") != "object" {
            self.value(&format!("{}; 0", fs::read_to_string(path).unwrap()));
        }
        self.value(
            "axe.run().then(({ violations }) => violations
                 .filter(({ impact }) => impact === 'serious' || impact === 'critical')
                 .map(({ id, nodes }) => [id, ...nodes.map(({ html, failureSummary }) => `${html}: ${failureSummary}`)]))",
        )
    }

    /// Writes the page, also what of it is out of sight, as a PNG file.
    pub(crate) fn screenshot(&mut self, path: &Path) {
        let params = json!({ "format": "png", "captureBeyondViewport": true });
        let data = self.call("Page.captureScreenshot", params)["data"].take();
        let mut decode = Command::new("base64");
        decode.arg("-d").stdin(Stdio::piped()).stdout(File::create(path).unwrap());
        let mut decode = decode.spawn().unwrap();
        decode.stdin.take().unwrap().write_all(data.as_str().unwrap().as_bytes()).unwrap();
        assert!(decode.wait().unwrap().success());
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // Closing the pipe ends the browser; one that hangs is killed.
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}
