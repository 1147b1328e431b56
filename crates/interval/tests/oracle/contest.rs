//! Runs subjects against an oracle over directed and random cases, on all processors.

use std::fmt::Write as _;
use std::io::Write as _;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use veribound_interval::lanes::{LANES, Path};
use veribound_interval::{Interval, Interval8};

use super::OPERATIONS;
use super::draw::{Draw, directed};
use super::operation::Operation;
use super::subject::{lanes, pack, scalar};

/// Cases that are drawn, judged and forgotten together; a multiple of the number of lanes.
const CHUNK: usize = 4096;
/// Violations that are told in full.
const TOLD: usize = 10;

/// The smallest intervals, by another way; `None` for operations it does not have.
pub struct Oracle<'a> {
    pub name: &'static str,
    #[allow(clippy::type_complexity, reason = "one function")]
    pub evaluate: &'a (dyn Fn(&Operation, &[Vec<Interval>]) -> Option<Vec<Interval>> + Sync),
}

/// One implementation of one operation, over columns of arguments.
pub struct Subject {
    pub path: String,
    /// How many floats an end may lie further out than the tight one.
    pub slack: u32,
    #[allow(clippy::type_complexity, reason = "one function")]
    pub evaluate: Box<dyn Fn(&[Vec<Interval>]) -> Vec<Interval> + Sync>,
}

/// The scalar implementation of an operation and those of all paths of the lanes.
pub fn subjects(operation: &'static Operation) -> Vec<Subject> {
    let subject = |path: String, evaluate| Subject {
        path,
        slack: operation.slack,
        evaluate,
    };
    let mut all = Vec::new();
    if let Some(f) = scalar(operation.name) {
        let evaluate = move |columns: &[Vec<Interval>]| {
            let mut results = vec![Interval::ENTIRE; columns[0].len()];
            f(columns, &mut results);
            results
        };
        all.push(subject("scalar".to_owned(), Box::new(evaluate)));
    }
    for path in Path::available() {
        if !lanes(path, operation.name, &[], &mut []) {
            continue;
        }
        let evaluate = move |columns: &[Vec<Interval>]| {
            let packed: Vec<Vec<Interval8>> = columns.iter().map(|x| pack(x)).collect();
            let mut results = vec![Interval8::ENTIRE; packed[0].len()];
            assert!(lanes(path, operation.name, &packed, &mut results));
            let one = |case: usize| results[case / LANES].get(case % LANES);
            (0..columns[0].len()).map(one).collect()
        };
        all.push(subject(
            format!("{path:?}").to_lowercase(),
            Box::new(evaluate),
        ));
    }
    all
}

/// What a contest found.
#[derive(Default)]
pub struct Outcome {
    /// Arguments of operations, random and directed.
    pub cases: usize,
    /// Results judged: one per case and subject.
    pub judged: usize,
    pub violations: usize,
    told: String,
    oracle: &'static str,
}

impl Outcome {
    pub fn assert_none(&self) {
        let (cases, oracle) = (self.cases, self.oracle);
        assert!(cases > 0, "{oracle}: no case at all");
        assert!(
            self.violations == 0,
            "{oracle}: {} violations in {cases} cases\n{}",
            self.violations,
            self.told
        );
    }
}

/// Counts of one operation, shared between the threads.
#[derive(Default)]
struct Tally {
    cases: AtomicUsize,
    judged: AtomicUsize,
    tight: AtomicUsize,
    violations: AtomicUsize,
    told: Mutex<String>,
}

impl Tally {
    fn judge(
        &self,
        operation: &Operation,
        subject: &Subject,
        tight: &[Interval],
        columns: &[Vec<Interval>],
    ) {
        let results = (subject.evaluate)(columns);
        assert_eq!(results.len(), tight.len());
        let allowed = subject.slack;
        let mut exact = 0;
        for (case, (&result, &tight)) in results.iter().zip(tight).enumerate() {
            match fault(result, tight, allowed) {
                None => exact += usize::from(same(result, tight)),
                Some(fault) => {
                    let earlier = self.violations.fetch_add(1, Ordering::Relaxed);
                    if earlier < TOLD {
                        let arguments: Vec<Interval> =
                            columns.iter().map(|column| column[case]).collect();
                        let name = operation.name;
                        let path = &subject.path;
                        writeln!(
                            self.told.lock().unwrap(),
                            "{name} ({path}) {fault}: {arguments:?} gives {result:?}, tight is {tight:?}"
                        )
                        .unwrap();
                    }
                }
            }
        }
        self.judged.fetch_add(results.len(), Ordering::Relaxed);
        self.tight.fetch_add(exact, Ordering::Relaxed);
    }
}

fn same(a: Interval, b: Interval) -> bool {
    a.lo() == b.lo() && a.hi() == b.hi()
}

/// What is wrong with a result.
fn fault(result: Interval, tight: Interval, allowed: u32) -> Option<&'static str> {
    if result.is_empty() != tight.is_empty() {
        return Some("wrong about the empty set");
    }
    if result.is_empty() {
        return (result != Interval::EMPTY).then_some("another empty set");
    }
    if Interval::new(result.lo(), result.hi()).is_none() {
        return Some("no interval");
    }
    if result.lo() > tight.lo() || result.hi() < tight.hi() {
        return Some("loses values");
    }
    let least = (0..allowed).fold(tight.lo(), |x, _| x.next_down());
    let most = (0..allowed).fold(tight.hi(), |x, _| x.next_up());
    (result.lo() < least || result.hi() > most).then_some("too wide")
}

/// All operations that both sides know, `random` random cases each beside the directed ones.
pub fn contest(
    oracle: &Oracle,
    random: usize,
    subjects: &dyn Fn(&'static Operation) -> Vec<Subject>,
) -> Outcome {
    let begin = Instant::now();
    let mut outcome = Outcome {
        oracle: oracle.name,
        ..Outcome::default()
    };
    let mut table = format!(
        "{:<18} {:>11} {:>8} {:>8} {:>7}  paths\n",
        "operation", "cases", "tight", "wrong", "s"
    );
    let only = std::env::var("VERIBOUND_ORACLE_ONLY").ok();
    let wanted = |name: &str| {
        let only = only.as_deref();
        only.is_none_or(|names| names.split(',').any(|one| one == name))
    };
    for operation in OPERATIONS.iter().filter(|one| wanted(one.name)) {
        let subjects = subjects(operation);
        let none = vec![Vec::new(); operation.arity()];
        if subjects.is_empty() || (oracle.evaluate)(operation, &none).is_none() {
            continue;
        }
        let start = Instant::now();
        let tally = judge_operation(oracle, operation, &subjects, random);
        let count = |counter: &AtomicUsize| counter.load(Ordering::Relaxed);
        let judged = count(&tally.judged).max(1);
        let paths: Vec<&str> = subjects
            .iter()
            .map(|subject| subject.path.as_str())
            .collect();
        writeln!(
            table,
            "{:<18} {:>11} {:>7.3}% {:>8} {:>7.1}  {}",
            operation.name,
            count(&tally.cases),
            100.0 * count(&tally.tight) as f64 / judged as f64,
            count(&tally.violations),
            start.elapsed().as_secs_f64(),
            paths.join(", "),
        )
        .unwrap();
        outcome.cases += count(&tally.cases);
        outcome.judged += judged;
        outcome.violations += count(&tally.violations);
        outcome.told += &tally.told.into_inner().unwrap();
    }
    // On one's own terminal, and in the log of the nightly run.
    println!(
        "{table}{}: {} cases, {} results judged, {} violations, {:.0} s",
        oracle.name,
        outcome.cases,
        outcome.judged,
        outcome.violations,
        begin.elapsed().as_secs_f64()
    );
    outcome
}

fn judge_operation(
    oracle: &Oracle,
    operation: &Operation,
    subjects: &[Subject],
    random: usize,
) -> Tally {
    let tally = Tally::default();
    let directed = directed(operation);
    let fixed = directed.len().div_ceil(CHUNK);
    let chunks = fixed + random.div_ceil(CHUNK);
    let seed = number("VERIBOUND_ORACLE_SEED").unwrap_or(0) << 32;
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let chunk = next.fetch_add(1, Ordering::Relaxed);
            if chunk >= chunks {
                break;
            }
            let columns = if chunk < fixed {
                directed.columns(chunk * CHUNK, CHUNK)
            } else {
                let count = CHUNK.min(random - (chunk - fixed) * CHUNK);
                Draw::new(operation, seed + (chunk - fixed) as u64).columns(count)
            };
            let tight = (oracle.evaluate)(operation, &columns).unwrap();
            tally.cases.fetch_add(tight.len(), Ordering::Relaxed);
            for subject in subjects {
                tally.judge(operation, subject, &tight, &columns);
            }
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    tally
}

/// A number in the environment.
pub fn number(variable: &str) -> Option<u64> {
    let text = std::env::var(variable).ok()?;
    let Ok(number) = text.parse() else {
        panic!("{variable} is not a number: {text}");
    };
    Some(number)
}

/// Writes past the capture of the test program, which hides the output of tests that pass.
pub fn say(line: &str) {
    std::io::stderr()
        .write_all(format!("{line}\n").as_bytes())
        .unwrap();
}
