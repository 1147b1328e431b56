//! Forms on the problems that integrators are compared with: widths, times, and what was to be reached.
//!
//! `cargo bench -p veribound-flow --bench forms`; an argument that is part of a row's name chooses rows.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a benchmark fails by panicking"
)]

use std::time::Instant;

use veribound_flow::form::{Effort, Enclosure, Flow, FormOptions, Stretch};
use veribound_interval::{Decimal, Interval};
use veribound_model::Model;

/// A problem, its sampled hull where there is one, and the widths and milliseconds to be reached.
struct Case {
    name: &'static str,
    model: &'static str,
    start: Vec<[&'static str; 2]>,
    params: Vec<[&'static str; 2]>,
    /// Length and inputs of each stretch.
    stretches: Vec<(&'static str, Vec<&'static str>)>,
    /// State, width sampled inside, largest width allowed.
    wanted: Vec<(usize, f64, f64)>,
    milliseconds: f64,
}

fn model(states: &str, inputs: &str, params: &str, der: &str) -> String {
    let names: Vec<&str> = states.split(' ').collect();
    let inits: String = names.iter().map(|x| format!("{x} = 0\n")).collect();
    let inputs = if inputs.is_empty() {
        String::new()
    } else {
        format!("inputs = [\"{inputs}\"]\n")
    };
    let params = if params.is_empty() {
        String::new()
    } else {
        format!("[params]\n{params}\n")
    };
    format!(
        "format = 1\nstates = {names:?}\n{inputs}[init]\n{inits}{params}[der]\n{der}\n[outputs]\nmeasured = \"{} +- 1\"\n",
        names[0]
    )
}

fn decimal(text: &str) -> Interval {
    Decimal::parse(text).unwrap().to_interval()
}

fn between(ends: [&str; 2]) -> Interval {
    decimal(ends[0]).hull(decimal(ends[1]))
}

const LAUB_LOOMIS: &str = "x1 = \"1.4*x3 - 0.9*x1\"\nx2 = \"2.5*x5 - 1.5*x2\"\n\
    x3 = \"0.6*x7 - 0.8*x2*x3\"\nx4 = \"2 - 1.3*x3*x4\"\nx5 = \"0.7*x1 - x4*x5\"\n\
    x6 = \"0.3*x1 - 3.1*x6\"\nx7 = \"1.8*x6 - 1.5*x2*x7\"";

fn laub_loomis(name: &'static str, start: [[&'static str; 2]; 7], width: f64) -> Case {
    Case {
        name,
        model: model_text("x1 x2 x3 x4 x5 x6 x7", "", "", LAUB_LOOMIS),
        start: start.to_vec(),
        params: vec![],
        stretches: vec![("20", vec![])],
        wanted: vec![(3, width, 1.15 * width)],
        milliseconds: 1000.0,
    }
}

fn leak(text: &str) -> &'static str {
    Box::leak(text.to_string().into_boxed_str())
}

fn model_text(states: &str, inputs: &str, params: &str, der: &str) -> &'static str {
    leak(&model(states, inputs, params, der))
}

/// A motor with dry friction.
fn motor() -> &'static str {
    model_text(
        "x1 x2",
        "u",
        "alpha = [-2.05, -1.95]\nbeta = [99, 101]\nT = [0.098, 0.102]",
        "x1 = \"x2\"\nx2 = \"alpha*x2 + beta*(u - friction(x2, u, T))\"",
    )
}

/// Another level every two seconds, sampled every 10 ms.
fn levels(seconds: u32) -> Vec<(&'static str, Vec<&'static str>)> {
    let list = [
        "0.4", "0.1", "-0.3", "0.2", "-0.1", "-0.5", "0.05", "0.3", "-0.2", "0",
    ];
    (0..100 * seconds)
        .map(|k| ("0.01", vec![list[(k / 200) as usize % list.len()]]))
        .collect()
}

/// A motor with dry friction under a sampled sine, ten seconds long.
fn sampled_sine() -> Vec<(&'static str, Vec<&'static str>)> {
    let level = |k: u32| leak(&format!("{:.17}", 0.25 * (0.8 * f64::from(k) * 0.01).sin()));
    (0..1000).map(|k| ("0.01", vec![level(k)])).collect()
}

fn cases() -> Vec<Case> {
    let staircase = (0..10).map(|k| ("0.5", vec![if k % 2 == 0 { "0.5" } else { "0.3" }]));
    vec![
        Case {
            name: "Lorenz",
            model: model_text(
                "x y z",
                "",
                "",
                "x = \"10*(y - x)\"\ny = \"x*(28 - z) - y\"\nz = \"x*y - 8/3*z\"",
            ),
            start: vec![["15", "15"], ["15", "15"], ["36", "36"]],
            params: vec![],
            stretches: vec![("10", vec![])],
            wanted: vec![(0, 0.0, 1.35e-7), (1, 0.0, 1.35e-7), (2, 0.0, 1.35e-7)],
            milliseconds: 30.0,
        },
        Case {
            name: "LV",
            model: model_text("x y", "", "", "x = \"3*x - 3*x*y\"\ny = \"x*y - y\""),
            start: vec![["1.292", "1.308"], ["0.992", "1.008"]],
            params: vec![],
            stretches: vec![("3.64", vec![])],
            wanted: vec![(0, 0.01617, 0.01627), (1, 0.01648, 0.01653)],
            milliseconds: 20.0,
        },
        Case {
            name: "VdP",
            model: model_text("x y", "", "", "x = \"y\"\ny = \"(1 - x^2)*y - x\""),
            start: vec![["1.25", "1.55"], ["2.35", "2.45"]],
            params: vec![],
            stretches: vec![("7", vec![])],
            wanted: vec![(0, 0.1042, 0.1227), (1, 0.4360, 0.4902)],
            milliseconds: 100.0,
        },
        Case {
            name: "B2",
            model: model_text(
                "x1 x2",
                "u",
                "alpha = [-2.2, -1.8]\nbeta = [95, 105]",
                "x1 = \"x2\"\nx2 = \"alpha*x2 + beta*(u - 0.1)\"",
            ),
            start: vec![["0", "0"], ["0.5", "0.5"]],
            params: vec![["-2.2", "-1.8"], ["95", "105"]],
            stretches: staircase.collect(),
            wanted: vec![
                (0, 19.3297436, 1.01 * 19.3297436),
                (1, 4.2441, 1.01 * 4.2441),
            ],
            milliseconds: 10.0,
        },
        Case {
            name: "B3",
            model: motor(),
            start: vec![["0", "0"], ["0", "0"]],
            params: vec![["-2.05", "-1.95"], ["99", "101"], ["0.098", "0.102"]],
            stretches: sampled_sine(),
            wanted: vec![(0, 0.474, 1.2 * 0.474), (1, 0.556, 1.2 * 0.556)],
            milliseconds: 100.0,
        },
        Case {
            name: "rig, 80 s",
            model: motor(),
            start: vec![["0", "0"], ["0", "0"]],
            params: vec![
                ["-2.001", "-1.999"],
                ["199.9", "200.1"],
                ["0.149925", "0.150075"],
            ],
            stretches: levels(80),
            wanted: vec![(0, 0.0, 1e9), (1, 0.0, 1e9)],
            milliseconds: 800.0,
        },
        Case {
            name: "pendulum, 30 s",
            model: model_text(
                "theta omega",
                "",
                "a = [48.60, 48.62]\nb = [0.017, 0.018]\nc = [0.48, 0.485]",
                "theta = \"omega\"\nomega = \"-a*sin(theta) - b*omega - friction(omega, -a*sin(theta), c)\"",
            ),
            start: vec![["1", "1"], ["0", "0"]],
            params: vec![["48.60", "48.62"], ["0.017", "0.018"], ["0.48", "0.485"]],
            stretches: vec![("0.1", vec![]); 300],
            wanted: vec![(0, 0.0, 1e9), (1, 0.0, 1e9)],
            milliseconds: 800.0,
        },
        Case {
            name: "belt",
            model: model_text(
                "x v",
                "",
                "mu = [0.3, 0.35]",
                "x = \"v\"\nv = \"-x - 0.1*v - friction(v - 0.2, -x - 0.1*v, mu)\"",
            ),
            start: vec![["1", "1.05"], ["0", "0"]],
            params: vec![["0.3", "0.35"]],
            stretches: vec![("20", vec![])],
            wanted: vec![(0, 0.0661, 1.2 * 0.0661), (1, 0.0377, 1.2 * 0.0377)],
            milliseconds: 100.0,
        },
        Case {
            name: "tanks",
            model: model_text(
                "h1 h2",
                "",
                "c12 = [0.36, 0.44]",
                "h1 = \"0.35 - c12*sqrt(h1) - 2*max(0, h1 - 0.5)\"\nh2 = \"c12*sqrt(h1) - 0.3*sqrt(h2)\"",
            ),
            start: vec![["0.1", "0.15"], ["0.2", "0.3"]],
            params: vec![["0.36", "0.44"]],
            stretches: vec![("1", vec![]); 10],
            wanted: vec![(0, 0.0, 1.0), (1, 0.0, 1.0)],
            milliseconds: 100.0,
        },
        Case {
            name: "ball",
            model: leak(
                "format = 1\nstates = [\"h\", \"v\"]\n[init]\nh = 1\nv = 0\n[der]\nh = \"v\"\nv = \"-9.81\"\n[jumps]\n\
                 bounce = { when = \"h <= 0 and v < 0\", set = { v = \"-0.75*v\" } }\n[outputs]\nmeasured = \"h +- 1\"\n",
            ),
            start: vec![["0.95", "1.05"], ["-0.05", "0.05"]],
            params: vec![],
            stretches: vec![("0.1", vec![]); 17],
            wanted: vec![(0, 0.0, 1.0), (1, 0.0, 1.0)],
            milliseconds: 100.0,
        },
        laub_loomis(
            "Laub-Loomis 0.01",
            [
                ["1.19", "1.21"],
                ["1.04", "1.06"],
                ["1.49", "1.51"],
                ["2.39", "2.41"],
                ["0.99", "1.01"],
                ["0.09", "0.11"],
                ["0.44", "0.46"],
            ],
            0.002516,
        ),
        laub_loomis(
            "Laub-Loomis 0.05",
            [
                ["1.15", "1.25"],
                ["1", "1.1"],
                ["1.45", "1.55"],
                ["2.35", "2.45"],
                ["0.95", "1.05"],
                ["0.05", "0.15"],
                ["0.4", "0.5"],
            ],
            0.012623,
        ),
        laub_loomis(
            "Laub-Loomis 0.1",
            [
                ["1.1", "1.3"],
                ["0.95", "1.15"],
                ["1.4", "1.6"],
                ["2.3", "2.5"],
                ["0.9", "1.1"],
                ["0", "0.2"],
                ["0.35", "0.55"],
            ],
            0.025505,
        ),
    ]
}

fn run(case: &Case, flow: &Flow, options: FormOptions, effort: Effort) -> Enclosure {
    let start: Vec<Interval> = case.start.iter().map(|x| between(*x)).collect();
    let params: Vec<Interval> = case.params.iter().map(|x| between(*x)).collect();
    let stretches = case.stretches.iter().map(|(dt, inputs)| Stretch {
        inputs: inputs.iter().map(|x| decimal(x)).collect(),
        dt: decimal(dt),
    });
    let stretches: Vec<Stretch> = stretches.collect();
    flow.enclose(&start, &params, &stretches, options, effort)
}

/// A chain of so many masses between springs, each with dry friction.
fn chain(masses: usize) -> String {
    format!(
        "format = 1\nstates = [\"x{{i=1..n}}\", \"v{{i=1..n}}\"]\ninputs = [\"F\"]\noutputs.y = \"x1 +- 1\"\n\
         params = {{ k = [99, 101], T = [0.98, 1.02] }}\n[sizes]\nn = {masses}\n[init]\n\"x{{i=1..n}}\" = 0\n\"v{{i=1..n}}\" = 0\n\
         [let]\n\"pull1\" = \"F + k*(x2 - x1)\"\n\"pull{{i=2..n-1}}\" = \"k*(x{{i-1}} - 2*x{{i}} + x{{i+1}})\"\n\
         \"pull{{n}}\" = \"k*(x{{n-1}} - x{{n}})\"\n[der]\n\"x{{i=1..n}}\" = \"v{{i}}\"\n\
         \"v{{i=1..n}}\" = \"pull{{i}} - friction(v{{i}}, pull{{i}}, T)\"\n"
    )
}

/// How long a step takes in chains of more and more masses, and by what power of their number it grows.
fn chains(options: FormOptions, effort: Effort) {
    let mut before: Option<(usize, f64)> = None;
    for masses in [2, 5, 10, 20, 50] {
        let name = format!("chain of {masses}");
        let model = Model::from_text(&name, chain(masses));
        let model = model.unwrap_or_else(|problems| panic!("{}", problems.render(false)));
        let flow = Flow::new(&model);
        let start = vec![Interval::ZERO; 2 * masses];
        let params = [between(["99", "101"]), between(["0.98", "1.02"])];
        // Pulled for a while, then let go.
        let stretches = (0..40).map(|k| Stretch {
            inputs: vec![decimal(if k < 20 { "3" } else { "0" })],
            dt: decimal("0.01"),
        });
        let stretches: Vec<Stretch> = stretches.collect();
        let begin = (Instant::now(), processor_time());
        // One part tells how long a step takes as well as many.
        let alone = Effort { parts: 1, ..effort };
        let last = flow.enclose(&start, &params, &stretches, options, alone);
        let seconds = seconds_since(begin);
        let each = seconds * 1e3 / last.steps as f64;
        let power = before.map_or(String::new(), |(fewer, less)| {
            let power = (each / less).ln() / (masses as f64 / fewer as f64).ln();
            format!(", power {power:.2}")
        });
        let reached = last.ends.len();
        let widest = last.ends.last().map_or(f64::NAN, |end| {
            end.iter().map(|x| x.width()).fold(0.0, f64::max)
        });
        println!(
            "{name:18} {each:9.3} ms a step, {} steps, {seconds:.2} s, {reached} of 40 stretches, widest {widest:.2e}{power}",
            last.steps
        );
        before = Some((masses, each));
    }
}

type Begin = (Instant, Option<f64>);

fn seconds_since(begin: Begin) -> f64 {
    match (begin.1, processor_time()) {
        (Some(from), Some(to)) => to - from,
        _ => begin.0.elapsed().as_secs_f64(),
    }
}

/// Seconds this thread has been on a processor, where the system tells.
fn processor_time() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split(' ').next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}

fn main() {
    let mut options = FormOptions::default();
    let mut effort = Effort::default();
    let mut chosen = Vec::new();
    let mut runs = 5;
    let number = |text: &str| text.parse::<f64>().unwrap();
    for argument in std::env::args().skip(1) {
        match argument.split_once('=') {
            Some(("excess", x)) => effort.excess = number(x),
            Some(("parts", x)) => effort.parts = number(x) as usize,
            Some(("runs", x)) => runs = number(x) as u32,
            Some(("order", x)) => options.order = Some(number(x) as usize),
            Some(("degree", x)) => options.degree = Some(number(x) as usize),
            Some(("tolerance", x)) => options.tolerance = number(x),
            Some(("share", x)) => options.share = number(x),
            Some(("fresh", x)) => options.fresh = Some(number(x) as usize),
            Some(("absorb", x)) => options.absorb = number(x),
            Some(("steepest", x)) => options.steepest = number(x),
            _ if argument.starts_with("--") => {}
            _ => chosen.push(argument),
        }
    }
    for case in cases() {
        if !chosen.is_empty() && !chosen.iter().any(|text| case.name.contains(&text[..])) {
            continue;
        }
        let model = Model::from_text(case.name, case.model)
            .unwrap_or_else(|problems| panic!("{}", problems.render(false)));
        let flow = Flow::new(&model);
        let begin = (Instant::now(), processor_time());
        let mut count = 0;
        let mut last = run(&case, &flow, options, effort);
        // The clock of the processor ticks in milliseconds.
        while count < runs || (runs > 1 && begin.0.elapsed().as_secs_f64() < 0.3) {
            last = run(&case, &flow, options, effort);
            count += 1;
        }
        let milliseconds = seconds_since(begin) * 1e3 / f64::from(count + 1);
        println!(
            "{:18} {milliseconds:9.2} ms of {} ms",
            case.name, case.milliseconds
        );
        if let Some(why) = &last.stopped {
            println!("    {why:?}");
        }
        let Some(hull) = last.ends.last() else {
            continue;
        };
        for (state, inner, most) in &case.wanted {
            let width = hull[*state].width();
            let verdict = if width <= *most { "reached" } else { "" };
            println!(
                "    {:5} {:24} width {width:12.6e}  inner {inner:9.4e}  wanted {most:9.4e} {verdict} ({} parts)",
                model.states[*state].name,
                format!("{}", hull[*state]),
                last.parts.len(),
            );
        }
    }
    if chosen.is_empty() || chosen.iter().any(|text| "chain".contains(&text[..])) {
        chains(options, effort);
    }
}
