//! Nanoseconds per interval, side by side in one run: one interval at a time, every path of eight this
//! machine has, and inari, built for any processor with FMA and for this one.
//!
//! `cargo bench -p veribound-interval`, with the folder of `peers/build native` in `VERIBOUND_PEERS` for
//! inari; text or, with `--json` after `--`, one JSON object. An argument that is part of a row's name
//! chooses rows. All contenders of a row take turns, round by round, and the fastest round of each counts.

use std::hint::black_box;
use std::time::Instant;

use veribound_interval::lanes::Path;
use veribound_interval::{Decimal, Interval, Interval8, text};

#[path = "../tests/oracle/peers.rs"]
mod peers;
#[path = "../tests/oracle/subject.rs"]
mod subject;

use peers::Peers;
use subject::{Batch, batch};

/// Three arrays of so many intervals fit the first cache of 32 KiB.
const NEAR: usize = 512;
/// So many do not fit the second one, and no branch predictor remembers their signs.
const FAR: usize = 100_000;
const ROUNDS: usize = 60;
/// Intervals that one contender works on before the next one's turn.
const TURN: usize = 1 << 16;

/// The builds of inari, the one for this machine last: it is what all are compared with.
const BUILDS: [&str; 2] = ["haswell", "native"];

/// What has to be reached: row, contender, rival, how many times as fast.
const TARGETS: [(&str, &str, &str, f64); 13] = [
    ("add", "avx512", "inari native", 3.5),
    ("mul", "avx512", "inari native", 6.0),
    ("sqr", "avx512", "inari native", 12.0),
    ("div", "avx512", "inari native", 3.5),
    ("exp", "avx512", "inari native", 50.0),
    ("sin", "avx512", "inari native", 50.0),
    (
        "mul, 100 000 of random signs",
        "avx512",
        "inari native",
        8.0,
    ),
    ("add", "portable", "inari haswell", 0.4),
    ("mul", "portable", "inari haswell", 0.4),
    ("sqr", "portable", "inari haswell", 0.4),
    ("div", "portable", "inari haswell", 0.4),
    ("exp", "portable", "inari haswell", 0.4),
    ("sin", "portable", "inari haswell", 0.4),
];

/// A small generator with a fixed seed (xorshift), so that every run sees the same numbers.
struct Source(u64);

impl Source {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Narrow intervals: about every two hundredth contains a given number.
    fn narrow(&mut self, from: f64, to: f64) -> Vec<Interval> {
        let one = |_| {
            let lo = self.between(from, to);
            let hi = lo + 0.01 * (to - lo) * self.unit();
            Interval::point(lo).hull(Interval::point(hi))
        };
        (0..NEAR).map(one).collect()
    }

    /// Two random ends: half of the intervals contain zero, the others have either sign.
    fn wide(&mut self, count: usize) -> Vec<Interval> {
        let one = |_| {
            let ends = [self.between(-10.0, 10.0), self.between(-10.0, 10.0)];
            Interval::point(ends[0]).hull(Interval::point(ends[1]))
        };
        (0..count).map(one).collect()
    }
}

/// One line of the table.
struct Row {
    name: &'static str,
    /// The operation in the tables of the tests and of the peers; empty if it is in none.
    operation: &'static str,
    columns: Vec<Vec<Interval>>,
    scalar: Batch,
}

/// Somebody who can do an operation on all intervals of a row.
struct Contender<'a> {
    name: String,
    pass: Box<dyn FnMut() + 'a>,
    fastest: f64,
}

impl<'a> Contender<'a> {
    fn new(name: impl Into<String>, pass: impl FnMut() + 'a) -> Contender<'a> {
        Contender {
            name: name.into(),
            pass: Box::new(pass),
            fastest: f64::INFINITY,
        }
    }
}

/// Nanoseconds per interval and contender.
type Times = Vec<(String, f64)>;

fn race(count: usize, mut contenders: Vec<Contender>) -> Times {
    let passes = (TURN / count).max(1);
    for _ in 0..ROUNDS {
        for contender in &mut contenders {
            // A first pass, not counted, brings the arrays back into the cache.
            (contender.pass)();
            // Slow ones have fewer passes: the first round tells.
            let passes = if contender.fastest > 100.0 {
                passes.div_ceil(50)
            } else {
                passes
            };
            let start = Instant::now();
            for _ in 0..passes {
                (contender.pass)();
            }
            let ns = start.elapsed().as_nanos() as f64 / (passes * count) as f64;
            contender.fastest = contender.fastest.min(ns);
        }
    }
    let time = |contender: Contender| (contender.name, contender.fastest);
    contenders.into_iter().map(time).collect()
}

fn measure(row: &Row, builds: &[(String, Peers)]) -> Times {
    let count = row.columns.first().map_or(0, Vec::len);
    let packed: Vec<Vec<Interval8>> = row.columns.iter().map(|x| subject::pack(x)).collect();
    let mut contenders = Vec::new();
    let mut out = vec![Interval::ZERO; count];
    contenders.push(Contender::new("scalar", move || {
        (row.scalar)(black_box(&row.columns), &mut out);
        black_box(&out);
    }));
    for path in Path::available() {
        if subject::lanes(path, row.operation, &[], &mut []) {
            let packed = &packed;
            let mut out = vec![Interval8::ZERO; packed.first().map_or(0, Vec::len)];
            let name = format!("{path:?}").to_lowercase();
            contenders.push(Contender::new(name, move || {
                subject::lanes(path, row.operation, black_box(packed), &mut out);
                black_box(&out);
            }));
        }
    }
    for (name, build) in builds {
        if let Some(mut batch) = build.prepare(row.operation, &row.columns) {
            contenders.push(Contender::new(name, move || batch.pass()));
        }
    }
    race(count, contenders)
}

fn rows() -> Vec<Row> {
    let mut source = Source(0x9e37_79b9_7f4a_7c15);
    let positive = source.narrow(0.1, 10.0);
    let other = source.narrow(0.2, 20.0);
    let mixed = source.narrow(-10.0, 10.0);
    let unit = source.narrow(-1.0, 1.0);
    let wide = [source.wide(NEAR), source.wide(NEAR)];
    let far = [source.wide(FAR), source.wide(FAR)];
    let one_end_zero: Vec<Interval> = mixed.iter().map(|x| x.hull(Interval::ZERO)).collect();
    let twos = vec![Interval::point(2.0); NEAR];
    let zeros = vec![Interval::ZERO; NEAR];

    // Rows with a name of their own, and those named as the operation.
    let row = |name, operation: &'static str, columns: &[&Vec<Interval>]| {
        subject::scalar(operation).map(|scalar| Row {
            name,
            operation,
            columns: columns.iter().map(|&column| column.clone()).collect(),
            scalar,
        })
    };
    let plain = |operation, columns: &[&Vec<Interval>]| row(operation, operation, columns);
    // Operations that only this crate has.
    let own = |name, columns: &[&Vec<Interval>], scalar| {
        Some(Row {
            name,
            operation: "",
            columns: columns.iter().map(|&column| column.clone()).collect(),
            scalar,
        })
    };
    let rows = [
        plain("add", &[&mixed, &other]),
        plain("sub", &[&mixed, &other]),
        plain("mul", &[&mixed, &wide[0]]),
        row("mul, all positive", "mul", &[&positive, &other]),
        row("mul, zero inside both", "mul", &[&wide[0], &wide[1]]),
        row("mul, 100 000 of random signs", "mul", &[&far[0], &far[1]]),
        row("mul, ends at zero", "mul", &[&one_end_zero, &other]),
        row("mul by zero", "mul", &[&mixed, &zeros]),
        row("mul by two", "mul", &[&mixed, &twos]),
        plain("div", &[&mixed, &other]),
        plain("sqr", &[&mixed]),
        plain("sqrt", &[&positive]),
        plain("recip", &[&other]),
        plain("fma", &[&mixed, &other, &positive]),
        plain("abs", &[&mixed]),
        plain("min", &[&mixed, &positive]),
        row(
            "powi 3",
            "powi",
            &[&mixed, &vec![Interval::point(3.0); NEAR]],
        ),
        row(
            "rootn 3",
            "rootn",
            &[&mixed, &vec![Interval::point(3.0); NEAR]],
        ),
        plain("pow", &[&positive, &mixed]),
        plain("exp", &[&mixed]),
        plain("exp2", &[&mixed]),
        plain("ln", &[&positive]),
        plain("log2", &[&positive]),
        plain("sin", &[&mixed]),
        plain("cos", &[&mixed]),
        plain("tan", &[&mixed]),
        plain("asin", &[&unit]),
        plain("atan", &[&mixed]),
        plain("atan2", &[&mixed, &positive]),
        plain("sinh", &[&mixed]),
        plain("tanh", &[&mixed]),
        own(
            "intersect",
            &[&positive, &other],
            batch!(|x, y| x.intersect(y)),
        ),
        own("hull", &[&positive, &other], batch!(|x, y| x.hull(y))),
        own(
            "mul_rev",
            &[&mixed, &other],
            batch!(|b, c| Interval::mul_rev(b, c, Interval::ENTIRE)),
        ),
        own(
            "sqr_rev",
            &[&positive, &other],
            batch!(|c, x| Interval::sqr_rev(c, x)),
        ),
        own(
            "sin_rev",
            &[&positive, &mixed],
            batch!(|c, x| Interval::sin_rev(c, x)),
        ),
    ];
    rows.into_iter().flatten().collect()
}

/// Decimal text: not an operation on intervals alone, so it has a clock of its own.
fn texts() -> [(&'static str, Times); 2] {
    let mixed = Source(0x2545_f491_4f6c_dd1d).narrow(-10.0, 10.0);
    let texts: Vec<String> = mixed.iter().map(|x| format!("{:.6}", x.mid())).collect();
    let read = Contender::new("scalar", || {
        for text in black_box(&texts) {
            black_box(Decimal::parse(text).map(|number| number.to_interval()).ok());
        }
    });
    let written = Contender::new("scalar", || {
        for x in black_box(&mixed) {
            black_box(text::lower(x.lo(), 10));
        }
    });
    [
        ("decimal in", race(NEAR, vec![read])),
        ("decimal out", race(NEAR, vec![written])),
    ]
}

fn time(times: &Times, contender: &str) -> Option<f64> {
    let mut found = times.iter().filter(|(name, _)| name == contender);
    found.next().map(|&(_, ns)| ns)
}

/// How many times as fast the contender is as the rival, where both ran.
fn ratio(times: &Times, contender: &str, rival: &str) -> Option<f64> {
    Some(time(times, rival)? / time(times, contender)?)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let json = arguments.iter().any(|argument| argument == "--json");
    let chosen = |name: &str| {
        let mut words = arguments
            .iter()
            .filter(|word| !word.starts_with("--"))
            .peekable();
        words.peek().is_none() || words.any(|word| name.contains(word.as_str()))
    };
    let mut builds = Vec::new();
    for build in BUILDS {
        match Peers::load(build) {
            Ok(Some(peers)) => builds.push((format!("inari {build}"), peers)),
            Ok(None) => {
                eprintln!(
                    "SKIPPED inari {build}: run `peers/build native` and set VERIBOUND_PEERS to its folder"
                );
            }
            Err(error) => eprintln!("SKIPPED inari {build}: {error}"),
        }
    }
    let rows: Vec<Row> = rows().into_iter().filter(|row| chosen(row.name)).collect();
    let measured = rows.iter().map(|row| (row.name, measure(row, &builds)));
    let mut results: Vec<(&str, Times)> = measured.collect();
    if chosen("decimal") {
        results.extend(texts());
    }
    if json {
        println!("{}", to_json(&results));
    } else {
        print_table(&results);
        print_targets(&results);
    }
}

fn to_json(results: &[(&str, Times)]) -> String {
    let object = |times: &mut dyn Iterator<Item = (String, f64)>| {
        let fields: Vec<String> = times
            .map(|(name, x)| format!("\"{name}\": {x:.3}"))
            .collect();
        format!("{{{}}}", fields.join(", "))
    };
    let rows: Vec<String> = results
        .iter()
        .map(|(name, times)| {
            let ns = object(&mut times.iter().cloned());
            let own = times.iter().filter(|(name, _)| !name.starts_with("inari"));
            let against = |rival: &str| {
                object(&mut own.clone().filter_map(|(name, _)| Some((name.clone(), ratio(times, name, rival)?))))
            };
            format!(
                "\"{name}\": {{\"ns\": {ns}, \"times as fast as inari native\": {}, \"times as fast as inari haswell\": {}}}",
                against("inari native"),
                against("inari haswell")
            )
        })
        .collect();
    format!("{{{}}}", rows.join(",\n"))
}

/// Times of all contenders, and how many times as fast as inari's build for this machine ours are.
fn print_table(results: &[(&str, Times)]) {
    let mut names: Vec<&str> = Vec::new();
    for name in results
        .iter()
        .flat_map(|(_, times)| times.iter().map(|(name, _)| name.as_str()))
    {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.sort_by_key(|name| name.starts_with("inari"));
    print!("{:<30}", "ns per interval");
    for name in &names {
        print!("{name:>15}");
    }
    println!("   (times as fast as inari native)");
    for (row, times) in results {
        print!("{row:<30}");
        for name in &names {
            let against = ratio(times, name, "inari native").filter(|_| !name.starts_with("inari"));
            let against = against.map_or(String::new(), |ratio| format!("({ratio:.1})"));
            let ns = time(times, name).map_or(String::new(), |ns| format!("{ns:.2}"));
            print!("{ns:>8}{against:>7}");
        }
        println!();
    }
}

fn print_targets(results: &[(&str, Times)]) {
    for (row, contender, rival, least) in TARGETS {
        let mut times = results.iter().filter(|(name, _)| *name == row);
        let reached = times
            .next()
            .and_then(|(_, times)| ratio(times, contender, rival));
        let verdict = match reached {
            Some(reached) if reached >= least => format!("{reached:.2}, reached"),
            Some(reached) => format!("{reached:.2}, MISSED"),
            None => "not measured here".to_owned(),
        };
        println!("target: {row}, {contender} at least {least} times as fast as {rival}: {verdict}");
    }
}
