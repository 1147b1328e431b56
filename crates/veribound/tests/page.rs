//! The page of a run: its numbers are those of the summary, texts cannot leave their place, and a browser shows it.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use support::{CART, Place, cart_record};

/// The numbers of a page: where each stands in the summary, and its text.
fn numbers(page: &str) -> Vec<(String, String)> {
    let parts = page.split("<data data-at=\"").skip(1);
    parts
        .map(|part| {
            let (at, rest) = part.split_once("\">").unwrap();
            let (text, _) = rest.split_once("</data>").unwrap();
            (unescaped(at), unescaped(text))
        })
        .collect()
}

fn unescaped(text: &str) -> String {
    let signs = [
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&quot;", "\""),
        ("&amp;", "&"),
    ];
    let plain = |text: String, (from, to): (&str, &str)| text.replace(from, to);
    signs.into_iter().fold(text.to_owned(), plain)
}

/// Every number of the page is the one at its place in the summary, digit for digit.
fn agree(numbers: &[(String, String)], summary: &str) -> Vec<String> {
    let told: Value = serde_json::from_str(summary).unwrap();
    for (at, text) in numbers {
        let there = told.pointer(at);
        let there = there.unwrap_or_else(|| panic!("no {at} in {summary}"));
        if there.is_null() {
            assert!(text == "∞" || text == "−∞", "{at}: {text}");
            continue;
        }
        // The reader of JSON rounds to a neighbour of the nearest float at times; the digits are compared below.
        let (number, shown) = (there.as_f64().unwrap(), text.parse::<f64>().unwrap());
        assert!((number - shown).abs() <= 1e-15 * number.abs(), "{at}");
        let key = at.rsplit('/').next().unwrap();
        let key = key.replace("~1", "/").replace("~0", "~");
        let digits = format!("\"{key}\": {text}");
        assert!(summary.contains(&digits), "no {digits} in {summary}");
    }
    numbers.iter().map(|(at, _)| at.clone()).collect()
}

/// The description of the plots.
fn scene(page: &str) -> Value {
    let (_, rest) = page
        .split_once("<script id=\"meta\" type=\"application/json\">")
        .unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn numbers_of_an_observation_are_those_of_the_summary() {
    let place = Place::new();
    let (model, record) = place.cart(41);
    let ran = place
        .typed(&format!("observe {model} {record} -o out --figures none"))
        .ended(0);
    assert!(ran.out.contains("run.toml, report.html\n"), "{}", ran.out);
    let page = place.read("out/report.html");
    let shown = agree(&numbers(&page), &place.read("out/summary.json"));
    for at in [
        "/parameters/k/lo",
        "/parameters/k/hi",
        "/parameters/k/prior/lo",
        "/states/x/hi",
        "/samples",
    ] {
        assert!(shown.iter().any(|known| known == at), "no {at}");
    }
    assert!(page.contains("<h1>Consistent: bounds are proved"));
    // Model, record and command stand on it.
    let info: toml::Table = place.read("out/run.toml").parse().unwrap();
    for digest in [&info["model"]["sha256"], &info["record"]["sha256"]] {
        assert!(page.contains(digest.as_str().unwrap()));
    }
    assert!(page.contains("veribound observe m.toml r.csv -o out --figures none"));
    let scene = scene(&page);
    assert_eq!(scene["tracks"][0]["cells"], 41);
    assert_eq!(scene["refuted"], Value::Null);
}

#[test]
fn a_refutation_is_shown_with_its_proof() {
    let place = Place::new();
    let model = place.file("m.toml", CART);
    let record = place.file("r.csv", cart_record(9).replace("0.4,1,", "0.4,1,9"));
    place
        .typed(&format!("observe {model} {record} -o out --figures none"))
        .ended(1);
    let page = place.read("out/report.html");
    let shown = agree(&numbers(&page), &place.read("out/summary.json"));
    for at in [
        "/refutation/time",
        "/refutation/line",
        "/refutation/enclosure/lo",
        "/refutation/measured/hi",
        "/refutation/gap",
    ] {
        assert!(shown.iter().any(|known| known == at), "no {at}");
    }
    assert!(!shown.iter().any(|at| at.starts_with("/parameters")));
    assert!(page.contains("<h1>Refuted: no parameter in the prior explains the data"));
    let scene = scene(&page);
    assert_eq!(scene["refuted"], 0.4);
    assert_eq!(
        scene["groups"][0]["panels"][0]["clash"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
}

#[test]
fn numbers_of_an_identification_are_those_of_the_summary() {
    let place = Place::new();
    let (model, record) = place.cart(9);
    let ran = place.typed(&format!(
        "identify {model} {record} -o out --figures none --paving 20% --sets 60"
    ));
    assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.err);
    let page = place.read("out/report.html");
    let summary = place.read("out/summary.json");
    let shown = agree(&numbers(&page), &summary);
    for at in [
        "/parameters/k/lo",
        "/parameters/k/prior/hi",
        "/starts/0/states/x/lo",
        "/samples",
    ] {
        assert!(shown.iter().any(|known| known == at), "no {at}");
    }
    let told: Value = serde_json::from_str(&summary).unwrap();
    if !told["parameters"]["k"]["inner"].is_null() {
        assert!(shown.contains(&"/parameters/k/inner/lo".to_owned()));
        assert!(shown.contains(&"/parameters/k/tightness".to_owned()));
    }
    // What is left along the record; parameters that keep one value have no course.
    let scene = scene(&page);
    let groups = scene["groups"].as_array().unwrap();
    let ids: Vec<&str> = groups.iter().filter_map(|one| one["id"].as_str()).collect();
    assert_eq!(ids, ["outputs", "states"]);
    assert_eq!(scene["tracks"][0]["cells"], 9);
    let note = groups[0]["note"].as_str().unwrap();
    assert!(note.starts_with("All that is left at each sample") && !note.contains("Beyond"));
}

/// What a reset may change has bounds of its own for every value, in the table and over time.
#[test]
fn values_after_resets_are_on_the_page() {
    let place = Place::new();
    let model = place.file(
        "m.toml",
        "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.c = [0, 1]\nsignals.new = { from = \"column\" }\n\
         events.lift = { when = \"new\", lasts = 0, action = \"reset c\" }\nder.x = \"-x\"\noutputs.y = \"x + c +- 0.01\"\n",
    );
    let record = "t,y,new\n0,1.5,0\n1,0.868,0\n2,0.385,1\n3,0.3,0\n";
    let record = place.file("r.csv", record);
    place
        .typed(&format!("identify {model} {record} -o out --figures none"))
        .ended(0);
    let page = place.read("out/report.html");
    let shown = agree(&numbers(&page), &place.read("out/summary.json"));
    for at in ["/resets/0/lo", "/resets/0/inner/hi", "/parameters/c/hi"] {
        assert!(shown.iter().any(|known| known == at), "no {at}");
    }
    assert!(page.contains("from 2 s to 3 s"));
    let scene = scene(&page);
    let last = scene["groups"].as_array().unwrap().last().unwrap();
    assert_eq!(
        (&last["id"], &last["panels"][0]["name"]),
        (&json!("parameters"), &json!("c"))
    );
}

#[test]
fn numbers_of_an_enclosure_are_those_of_the_summary() {
    let place = Place::new();
    let model = place.file(
        "m.toml",
        "format = 1\nstates = [\"x\", \"y\"]\ninit.x = [0.5, 1]\ninit.y = 0\nparams.k = [0.5, 0.6]\nder.x = \"-k * x\"\n\
         der.y = \"x\"\noutputs.z = \"x + y +- 0.1\"\n",
    );
    place
        .typed(&format!(
            "enclose {model} -o out --figures none --until 1 --every 0.1 --sample 2"
        ))
        .ended(0);
    let page = place.read("out/report.html");
    let shown = agree(&numbers(&page), &place.read("out/summary.json"));
    for at in [
        "/states/x/lo",
        "/states/y/always/hi",
        "/outputs/z/hi",
        "/times",
    ] {
        assert!(shown.iter().any(|known| known == at), "no {at}");
    }
    let scene = scene(&page);
    assert_eq!(scene["tracks"][1]["cells"], 10);
    assert_eq!(scene["planes"][0]["axes"][1]["name"], "y");
}

#[test]
fn no_page_is_written_where_none_is_wanted() {
    let place = Place::new();
    let (model, record) = place.cart(5);
    let words = [
        "observe",
        &model,
        &record,
        "-o",
        "out",
        "--figures",
        "none",
        "--report",
    ];
    place.run(&[&words[..], &["html"]].concat()).ended(0);
    assert!(place.files("out").contains(&"report.html".to_owned()));
    let ran = place.run(&[&words[..], &["none"]].concat()).ended(0);
    assert!(!place.files("out").contains(&"report.html".to_owned()));
    assert!(ran.out.contains("run.toml\n"), "{}", ran.out);
}

/// A model and a record whose names and texts would end their place, if they were not escaped.
fn evil(place: &Place) -> (String, String) {
    let sign = "</script><img src=x onerror=alert(1)>&amp;";
    let model = format!("name = \"{sign}\"\n# {sign}\n{CART}");
    let record = cart_record(21);
    (
        place.file("m&<b>.toml", model),
        place.file("r&<i>.csv", record),
    )
}

#[test]
fn texts_of_models_and_names_of_files_cannot_leave_their_place() {
    let place = Place::new();
    let (model, record) = evil(&place);
    place
        .typed(&format!("observe {model} {record} -o out --figures none"))
        .ended(0);
    let page = place.read("out/report.html");
    for bad in ["<img", "m&<b>", "r&<i>"] {
        assert!(!page.contains(bad), "{bad} in the page");
    }
    // Four elements: description, data, library, and the script that reads them.
    assert_eq!(page.matches("<script").count(), 4);
    assert_eq!(page.matches("</script>").count(), 4);
    assert!(page.contains("m&amp;&lt;b&gt;.toml"));
    assert!(scene(&page)["groups"].is_array());
}

/// A browser that a driver holds (WebDriver, a W3C recommendation).
struct Browser {
    driver: Child,
    port: u16,
    session: String,
}

impl Browser {
    /// Starts one, if Chromium and its driver are here.
    fn start(size: &str) -> Option<Browser> {
        let found = Command::new("chromedriver").arg("--version").output();
        let chromium = ["chromium", "chromium-browser", "google-chrome"];
        let chromium = chromium
            .into_iter()
            .find(|name| Command::new(name).arg("--version").output().is_ok());
        let (Ok(_), Some(chromium)) = (found, chromium) else {
            // Past the harness, which keeps what passing tests print.
            let told = b"\nSKIPPED pages in a browser: no Chromium with its driver here (Debian: chromium chromium-driver)\n";
            std::io::stderr().write_all(told).unwrap();
            return None;
        };
        let driver = Command::new("chromedriver")
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let mut driver = driver.unwrap();
        let mut lines = BufReader::new(driver.stdout.take().unwrap()).lines();
        let port = lines.find_map(|line| {
            let line = line.unwrap();
            let (_, port) = line.split_once("successfully on port ")?;
            port.trim_end_matches('.').parse().ok()
        });
        let mut browser = Browser {
            driver,
            port: port.unwrap(),
            session: String::new(),
        };
        let path = std::env::var_os("PATH").unwrap();
        let binary = std::env::split_paths(&path)
            .map(|folder| folder.join(chromium))
            .find(|file| file.exists());
        let flags = [
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            size,
        ];
        let wanted = json!({"capabilities": {"alwaysMatch": {
            "browserName": "chrome",
            "goog:chromeOptions": {"binary": binary.unwrap(), "args": flags},
            "goog:loggingPrefs": {"browser": "ALL"},
        }}});
        let session = browser.ask("POST", "/session", &wanted);
        browser.session = format!("/session/{}", session["sessionId"].as_str().unwrap());
        Some(browser)
    }

    fn ask(&self, method: &str, path: &str, body: &Value) -> Value {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(120)))
            .unwrap();
        let body = if method == "POST" {
            body.to_string()
        } else {
            String::new()
        };
        let head = format!(
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\nContent-Length: {}\r\n\r\n",
            body.len()
        );
        stream.write_all((head + &body).as_bytes()).unwrap();
        let mut answer = String::new();
        // The driver may keep the connection open: the length tells where the answer ends.
        let mut reader = BufReader::new(stream);
        let mut length = 0;
        loop {
            let mut line = String::new();
            reader.read_line(&mut line).unwrap();
            if let Some((name, value)) = line.split_once(':')
                && name.eq_ignore_ascii_case("content-length")
            {
                length = value.trim().parse().unwrap();
            }
            if line.trim().is_empty() {
                break;
            }
        }
        reader.take(length).read_to_string(&mut answer).unwrap();
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert!(answer["value"]["error"].is_null(), "{answer}");
        answer["value"].clone()
    }

    fn tell(&self, path: &str, body: &Value) -> Value {
        self.ask("POST", &format!("{}{path}", self.session), body)
    }

    /// The value of a script's `return`.
    fn run(&self, script: &str) -> Value {
        self.tell("/execute/sync", &json!({"script": script, "args": []}))
    }

    /// Waits until an expression holds.
    fn wait(&self, what: &str) {
        for _ in 0..600 {
            if self.run(&format!("return Boolean({what})")) == true {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        panic!("{what} never came true");
    }

    /// Opens a page, and waits for its plots.
    fn open(&self, page: &Path) {
        self.tell(
            "/url",
            &json!({"url": format!("file://{}", page.display().to_string().replace('&', "%26"))}),
        );
        self.wait("document.documentElement.dataset.ready");
        assert_eq!(
            self.run("return document.documentElement.dataset.ready"),
            "yes"
        );
    }

    /// Presses at one place of a plot, as shares of its width, and lets go at another.
    fn drag(&self, plot: &str, from: f64, to: f64) {
        self.run(&format!(
            "document.querySelector('{plot}').scrollIntoView({{block: 'center'}})"
        ));
        self.wait(&format!("document.querySelector('{plot} .nsewdrag')"));
        let rect = format!("document.querySelector('{plot} .nsewdrag').getBoundingClientRect()");
        let place = |share: f64| {
            let at = self.run(&format!("const r = {rect}; return [Math.round(r.left + {share} * r.width), Math.round(r.top + r.height / 2)]"));
            (at[0].as_i64().unwrap(), at[1].as_i64().unwrap())
        };
        let (a, b) = (place(from), place(to));
        let to = |at: (i64, i64), duration: u32| json!({"type": "pointerMove", "duration": duration, "x": at.0, "y": at.1});
        self.tell("/actions", &json!({"actions": [{"type": "pointer", "id": "mouse", "actions": [
            to(a, 0), {"type": "pointerDown", "button": 0}, to(((a.0 + b.0) / 2, a.1), 60), to(b, 60), {"type": "pointerUp", "button": 0},
        ]}]}));
    }

    /// What the console complained about.
    fn complaints(&self) -> Vec<String> {
        let log = self.tell("/se/log", &json!({"type": "browser"}));
        let entries = log.as_array().unwrap().iter();
        entries
            .filter(|entry| entry["level"] != "INFO" && entry["level"] != "DEBUG")
            .map(Value::to_string)
            .collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        if !self.session.is_empty() && !std::thread::panicking() {
            self.ask("DELETE", &self.session, &Value::Null);
        }
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}

const VIEW: &str = "return document.querySelector('#plot-outputs').layout.xaxis.range";

fn view(browser: &Browser) -> (f64, f64) {
    let range = browser.run(VIEW);
    (range[0].as_f64().unwrap(), range[1].as_f64().unwrap())
}

#[test]
fn a_browser_shows_the_page_and_zooms_all_plots_together() {
    let Some(browser) = Browser::start("--window-size=1100,900") else {
        return;
    };
    let place = Place::new();
    let (model, record) = evil(&place);
    place
        .typed(&format!("observe {model} {record} -o out --figures none"))
        .ended(0);
    browser.open(&place.path().join("out/report.html"));
    assert_eq!(browser.complaints(), [""; 0]);
    // What is shown equals the summary.
    let script = "return [...document.querySelectorAll('data')].map((it) => [it.dataset.at, it.textContent])";
    let shown: Vec<(String, String)> = serde_json::from_value(browser.run(script)).unwrap();
    assert!(shown.len() > 8, "{shown:?}");
    agree(&shown, &place.read("out/summary.json"));
    assert_eq!(view(&browser), (0.0, 2.0));
    browser.drag("#plot-outputs", 0.25, 0.5);
    browser.wait("document.querySelector('#plot-outputs').layout.xaxis.range[1] < 1.9");
    let (from, to) = view(&browser);
    assert!(
        (from - 0.5).abs() < 0.02 && (to - 1.0).abs() < 0.02,
        "{from} {to}"
    );
    // The other plots follow when they come into sight.
    for plot in ["#plot-states", "#plot-parameters", "#plot-work"] {
        browser.run(&format!(
            "document.querySelector('{plot}').scrollIntoView()"
        ));
        browser.wait(&format!(
            "document.querySelector('{plot}').layout?.xaxis.range[0] === {from}"
        ));
    }
    // Buttons go on from there, and back to all of it.
    browser.run("document.querySelector('#plot-outputs').scrollIntoView({block: 'center'})");
    std::thread::sleep(Duration::from_millis(300));
    browser.run("[...document.querySelectorAll('#tools button')].find((it) => it.textContent === '+').click()");
    let (a, b) = view(&browser);
    assert!((b - a - (to - from) / 2.0).abs() < 1e-9);
    browser.run("document.querySelector('#tools button').click()");
    assert_eq!(view(&browser), (0.0, 2.0));
    assert_eq!(browser.complaints(), [""; 0]);
    // Records of an identification have plots of their own, on one axis of time.
    let longer = place.file("longer.csv", cart_record(31));
    let ran = place.typed(&format!(
        "identify {model} {record} {longer} -o both --figures none"
    ));
    assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.err);
    browser.open(&place.path().join("both/report.html"));
    assert_eq!(view(&browser), (0.0, 3.0));
    browser.drag("#plot-outputs", 0.25, 0.5);
    browser.wait("document.querySelector('#plot-outputs').layout.xaxis.range[1] < 2.9");
    let (from, _) = view(&browser);
    for plot in ["#plot-outputs-2", "#plot-states-2"] {
        browser.run(&format!(
            "document.querySelector('{plot}').scrollIntoView()"
        ));
        browser.wait(&format!(
            "document.querySelector('{plot}').layout?.xaxis.range[0] === {from}"
        ));
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

/// Bands are never drawn narrower than the tables have them, at any zoom; hover texts are rounded outward.
#[test]
fn what_a_browser_draws_encloses_the_tables() {
    let Some(browser) = Browser::start("--window-size=700,900") else {
        return;
    };
    let place = Place::new();
    let model = place.file("m.toml", CART);
    // More samples than columns of pixels, up and down inside of a column.
    let mut at = 0;
    let mut row = |k: i32| {
        let up = if (k / 3) % 2 == 0 { 40 } else { -40 };
        let line = format!("{}.{:03},{up},{}e-3\n", k / 1000, k % 1000, at);
        at += 2 * up;
        line
    };
    let rows: String = (0..3000).map(&mut row).collect();
    let record = place.file("r.csv", format!("t,u,pos\n{rows}"));
    place
        .typed(&format!("observe {model} {record} -o out --figures none"))
        .ended(0);
    browser.open(&place.path().join("out/report.html"));
    browser.wait("document.querySelector('#plot-outputs .scatterlayer')");
    browser.run("document.querySelector('#plot-states').scrollIntoView({block: 'center'})");
    browser.wait("document.querySelector('#plot-states .scatterlayer')");
    let table = place.read("out/states.csv");
    let truth: Vec<(f64, f64, f64)> = table
        .lines()
        .skip(1)
        .map(|line| {
            let mut fields = line.split(',').map(|field| field.parse().unwrap());
            let mut next = || fields.next().unwrap();
            (next(), next(), next())
        })
        .take(3000)
        .collect();
    for (from, to) in [(0.0, 2.999), (1.0, 1.4), (1.0, 1.004)] {
        browser.run(&format!(
            "Plotly.relayout('plot-states', {{'xaxis.range': [{from}, {to}]}})"
        ));
        browser.wait(&format!("document.querySelector('#plot-states').layout.xaxis.range[1] === {to} && document.querySelector('#plot-outputs').layout.xaxis.range[1] === {to}"));
        let drawn = browser
            .run("const d = document.querySelector('#plot-states').data[0]; return [d.x, d.y]");
        let list = |at: usize| -> Vec<f64> {
            drawn[at]
                .as_array()
                .unwrap()
                .iter()
                .map(|v| v.as_f64().unwrap())
                .collect()
        };
        let (x, y) = (list(0), list(1));
        // One loop: along the upper edge, and back.
        let half = x.len() / 2;
        let upper: Vec<(f64, f64)> = x
            .iter()
            .copied()
            .zip(y.iter().copied())
            .take(half)
            .collect();
        let lower: Vec<(f64, f64)> = x
            .iter()
            .copied()
            .zip(y.iter().copied())
            .skip(half)
            .take(half)
            .rev()
            .collect();
        let reach = |edge: &[(f64, f64)], t: f64, pick: fn(f64, f64) -> f64, none: f64| {
            edge.windows(2)
                .filter(|w| w[0].0 <= t && t <= w[1].0)
                .fold(none, |best, w| {
                    let share = if w[1].0 > w[0].0 {
                        (t - w[0].0) / (w[1].0 - w[0].0)
                    } else {
                        0.0
                    };
                    pick(best, w[0].1 + share * (w[1].1 - w[0].1))
                })
        };
        let mut seen = 0;
        for (t, lo, hi) in &truth {
            if *t < from || *t > to {
                continue;
            }
            seen += 1;
            // The table is rounded outward by less than this.
            let slack = 1e-11;
            let (low, high) = (
                reach(&lower, *t, f64::min, f64::INFINITY),
                reach(&upper, *t, f64::max, f64::NEG_INFINITY),
            );
            assert!(
                low <= lo + slack && hi - slack <= high,
                "at {t}: [{low}, {high}] drawn, [{lo}, {hi}] proved"
            );
        }
        assert!(seen > 3);
    }
    // Numbers as text are rounded outward, and exact where they can be.
    for (x, digits, up, wanted) in [
        ("0.1", 3, true, "0.101"),
        ("0.1", 3, false, "0.1"),
        ("0.3", 3, false, "0.299"),
        ("0.3", 3, true, "0.3"),
        ("-0.1", 3, true, "-0.1"),
        ("-0.1", 3, false, "-0.101"),
        ("0.5", 3, true, "0.5"),
        ("999.96", 4, true, "1000"),
        ("1e-12", 3, true, "1e-12"),
        ("8001", 6, true, "8001"),
        ("-47.5507", 4, false, "-47.56"),
    ] {
        assert_eq!(
            browser.run(&format!("return rounded({x}, {digits}, {up})")),
            wanted,
            "{x} {up}"
        );
    }
    assert_eq!(browser.complaints(), [""; 0]);
}
