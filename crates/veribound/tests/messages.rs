//! What the program says about its command line, about results and about the machine, word for word:
//! `testdata/messages.txt` shows every command and its answer. After a wanted change `BLESS=1` writes it anew.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use std::fmt::Write;
use support::{CART, Place, Ran, cart_record};

/// `x' = -k x`, measured within 0.1.
const DECAY: &str = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 3]\n\
    der.x = \"-k * x\"\noutputs.y = \"x +- 0.1\"\n";

/// Commands and their answers.
struct Session {
    place: Place,
    text: String,
}

impl Session {
    fn new() -> Session {
        let place = Place::new();
        place.cart(5);
        place.file("decay.toml", DECAY);
        place.file("profile.csv", "t,u\n0,1\n0.15,2\n1,0\n");
        Session {
            place,
            text: String::new(),
        }
    }

    /// Runs a command that must be refused; notes it and what was said.
    fn refused(&mut self, line: &str) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let ran = self.place.run(&words);
        assert_eq!(ran.code, Some(2), "{line}: {}", ran.err);
        self.note(&format!("veribound {line}"), &ran);
    }

    fn observe(&mut self, more: &str) {
        self.refused(&format!(
            "observe m.toml r.csv -o out --figures none {more}"
        ));
    }

    fn simulate(&mut self, arguments: &str) {
        self.refused(&format!("simulate {arguments} -o s.csv"));
        assert!(!self.place.path().join("s.csv").exists());
    }

    /// Writes the cart with a part replaced.
    fn cart(&self, from: &str, to: &str) {
        assert!(CART.contains(from), "{from}");
        self.place.file("m.toml", CART.replace(from, to));
    }

    fn note(&mut self, command: &str, ran: &Ran) {
        assert_eq!(ran.out, "", "{command}");
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        write!(self.text, "$ {command}\n{}", ran.err).unwrap();
    }
}

#[test]
fn what_is_refused_is_told_word_for_word() {
    let mut session = Session::new();
    flags_of_observe(&mut session);
    earlier_runs(&mut session);
    places_of_results(&mut session);
    session.refused("identify m.toml r.csv m.toml -o out");
    session.refused("identify m.toml r.csv missing.csv -o out");
    flags_of_simulate(&mut session);
    what_a_simulation_cannot_do(&mut session);
    what_is_declared(&mut session);
    the_machine(&mut session);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/messages.txt");
    if std::env::var_os("BLESS").is_some() {
        std::fs::write(path, &session.text).unwrap();
    }
    let wanted = std::fs::read_to_string(path).unwrap_or_default();
    for (seen, wanted) in session.text.split("\n$ ").zip(wanted.split("\n$ ")) {
        assert_eq!(seen, wanted);
    }
    assert_eq!(session.text, wanted);
}

/// Outliers of an observer, and a least disturbance of nothing.
fn what_is_declared(session: &mut Session) {
    let spikes = DECAY.replace(
        "\"x +- 0.1\"",
        "{ expr = \"x\", error = 0.1, outliers = \"1 in 10\" }",
    );
    session.place.file("spikes.toml", spikes);
    session.place.file("decay.csv", "t,y\n0,1\n0.1,0.9\n");
    session.refused("observe spikes.toml decay.csv -o out --figures none");
    session.refused("identify decay.toml decay.csv -o out --figures none --least-disturbance");
}

fn flags_of_observe(session: &mut Session) {
    session.observe("--column poss=pos");
    session.observe("--column zzz=pos");
    session.observe("--reset j@still");
    session.observe("--reset k@still");
    session.observe("--input-error w=10%");
    session.observe("--output-error y=10%");
    session.observe("--output-error pos=0.05");
    session.cart(
        "[\"u [V]\"]",
        "{ u = { unit = \"V\", error = { relative = 0.2 } } }",
    );
    session.observe("--input-error u=10%");
    session.place.file("m.toml", CART);
    session.refused("observe m.toml r.csv -o out --figures none,svg");
    // Numbers that stand in the place of a signal.
    let signal = format!("{CART}signals.still = {{ proves = \"x == 0\", latency = 0 }}\n");
    session.place.file("signal.toml", signal);
    session
        .place
        .file("signal.csv", "t,u,pos,still\n0,1,0,0\n0.1,1,0.2,2\n");
    session.refused("observe signal.toml signal.csv -o out");
}

fn earlier_runs(session: &mut Session) {
    session.observe("--start-from nowhere");
    session.observe("--overlay nowhere");
    session.place.observe("m.toml", "r.csv", &[]).ended(0);
    std::fs::rename(
        session.place.path().join("out"),
        session.place.path().join("first"),
    )
    .unwrap();
    session.cart("[0, 4]", "[40, 50]");
    session.observe("--start-from first");
    session.cart("params.k", "params.m = [0, 1]\nparams.k");
    session.observe("--start-from first");
    session.observe("--overlay first");
    session.place.file("m.toml", CART);
    let edit = |session: &Session, name: &str, from: &str, to: &str| {
        let whole = session.place.read(name);
        assert!(whole.contains(from), "{whole}");
        session.place.file(name, whole.replacen(from, to, 1));
        whole
    };
    let boxes = session.place.read("first/boxes.csv");
    let row = boxes.lines().nth(1).unwrap();
    let fields: Vec<&str> = row.split(',').collect();
    let head: Vec<&str> = boxes.lines().next().unwrap().split(',').collect();
    let at = |name: &str| head.iter().position(|column| *column == name).unwrap();
    let with = |name: &str, value: &str| {
        let mut fields = fields.clone();
        fields[at(name)] = value;
        fields.join(",")
    };
    for (name, value) in [("k.lo", "low"), ("k.lo", "5"), ("t", "then")] {
        edit(session, "first/boxes.csv", row, &with(name, value));
        session.observe("--start-from first");
        session.place.file("first/boxes.csv", &boxes);
    }
    session
        .place
        .file("first/boxes.csv", boxes.replacen("k.lo", "j.lo", 1));
    session.observe("--start-from first");
    session.place.file("first/boxes.csv", "");
    session.observe("--start-from first");
    session.place.file("first/boxes.csv", &boxes);
    let params = edit(session, "first/params.csv", "\n0,", "\nthen,");
    session.observe("--overlay first");
    session
        .place
        .file("first/params.csv", params.replacen("\n0.1,", "\n0,", 1));
    session.observe("--overlay first");
    let summary = edit(
        session,
        "first/summary.json",
        "\"consistent\"",
        "\"inconsistent\"",
    );
    session.observe("--start-from first");
    session
        .place
        .file("first/summary.json", "{ \"verdict\": \"consistent\", }\n");
    session.observe("--start-from first");
    let low = summary.split("\"k\"").nth(1).unwrap();
    let low = low
        .split("\"lo\": ")
        .nth(1)
        .unwrap()
        .split(',')
        .next()
        .unwrap();
    let low = format!("\"lo\": {low}");
    session
        .place
        .file("first/summary.json", summary.replacen(&low, "\"lo\": 9", 1));
    session.observe("--start-from first");
    std::fs::remove_file(session.place.path().join("first/summary.json")).unwrap();
    session.observe("--start-from first");
}

fn places_of_results(session: &mut Session) {
    session.place.file("file", "");
    session.refused("observe m.toml r.csv -o file --quiet");
    session.refused("observe m.toml r.csv -o file/below --quiet");
    std::fs::create_dir_all(session.place.path().join("blocked/params.csv/full")).unwrap();
    session.refused("observe m.toml r.csv -o blocked --quiet");
    session.place.file("params.csv", cart_record(5));
    session.refused("observe m.toml params.csv -o . --quiet");
    session.refused("observe m.toml r.csv -o first/ --quiet --overlay first");
    session.refused("observe m.toml r.csv -o first/ --quiet --start-from first");
    session.refused("simulate decay.toml --params k=1 --until 1 --every 0.1 -o decay.toml");
    session.refused("simulate m.toml --params k=1 --input profile.csv -o profile.csv");
}

fn flags_of_simulate(session: &mut Session) {
    let grid = "--until 1 --every 0.1";
    session.simulate(&format!("decay.toml --params j=1 {grid}"));
    session.simulate(&format!("decay.toml --params k=1 --start z=1 {grid}"));
    session.simulate(&format!("decay.toml --params k=1,k=2 {grid}"));
    session.simulate(&format!("decay.toml --params k=1 --change x {grid}"));
    session.simulate(&format!("decay.toml --params k=1 --change 0.5:j=2 {grid}"));
    session.simulate(&format!("decay.toml {grid}"));
    session.simulate("decay.toml --params k=1");
    session.simulate("decay.toml --params k=1 --until 1 --every 0");
    session.refused(&format!("simulate decay.toml --params k=1 {grid} -o .."));
    session.simulate(&format!("m.toml --params k=1 {grid}"));
    session.simulate(&format!("m.toml --params k=1 --start x=0 {grid}"));
    session.simulate(&format!(
        "m.toml --params k=1 --start x=0 --input profile.csv {grid}"
    ));
    session
        .place
        .file("bounds.csv", "t,u.lo,u.hi\n0,1,2\n1,1,2\n");
    session.simulate(&format!(
        "m.toml --params k=1 --start x=0 --input bounds.csv {grid}"
    ));
    session.place.file("milli.csv", "t,u [mV]\n0,1\n1,1\n");
    session.simulate(&format!(
        "m.toml --params k=1 --start x=0 --input milli.csv {grid}"
    ));
    session.cart(
        "\"x +- 0.1 [m]\"",
        "{ expr = \"x\", error = 0.1, unit = \"m\", column = \"x [mm]\" }",
    );
    session.simulate(&format!(
        "m.toml --params k=1 --start x=0 --input profile.csv {grid}"
    ));
    session.place.file("m.toml", CART);
    let disturbed = DECAY.replace("-k * x", "d - k * x");
    session.place.file(
        "disturbed.toml",
        format!("{disturbed}disturbances.d = [-0.3, 0.3]\n"),
    );
    session.simulate(&format!(
        "disturbed.toml --params k=1 --disturbance d=0.4 {grid}"
    ));
}

fn what_a_simulation_cannot_do(session: &mut Session) {
    let grid = "--until 1 --every 0.1";
    session.simulate(&format!("decay.toml --params k=1 --decimals 0 {grid}"));
    session.simulate(&format!("decay.toml --params k=1 --error 0.5 {grid}"));
    session
        .place
        .file("steep.toml", DECAY.replace("-k * x", "10 * k * x"));
    session.simulate("steep.toml --params k=1 --until 4 --every 0.5 --error 0.05");
    session.simulate(&format!(
        "decay.toml --params k=1 --error 1e-15 --decimals 15 {grid}"
    ));
    session
        .place
        .file("fast.toml", DECAY.replace("-k * x", "k * x^2"));
    session.simulate("fast.toml --params k=2 --until 1 --every 0.5 --error 0.05");
}

fn the_machine(session: &mut Session) {
    let mut command = session.place.command(&["check", "m.toml"]);
    command.env("VERIBOUND_LANES", "sse9");
    let mut ran = Ran::of(command.output().unwrap()).ended(2);
    // Which paths there are is a matter of the processor.
    let paths: Vec<&str> = veribound_interval::lanes::Path::available()
        .map(|path| path.name())
        .collect();
    ran.err = ran.err.replace(&paths.join(", "), "PATHS");
    session.note("VERIBOUND_LANES=sse9 veribound check m.toml", &ran);
}
