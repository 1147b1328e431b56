//! The cases: random ones of awkward kinds, and all combinations of special numbers.

use std::f64::consts::{FRAC_PI_2, PI};

use veribound_interval::Interval;

use super::operation::{Kind, Operation};
use super::support::Source;

/// Arguments that are hard to round: function, argument, bits, and for powers the exponent.
const HARD: &str = include_str!("../../testdata/hard_to_round.txt");

fn hard(name: &str) -> Vec<[f64; 2]> {
    let number = |text: &str| text.parse().unwrap();
    HARD.lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split_whitespace().collect::<Vec<_>>())
        .filter(|words| words[0] == name)
        .map(|words| {
            [
                number(words[1]),
                words.get(3).map_or(0.0, |text| number(text)),
            ]
        })
        .collect()
}

/// A stream of random cases of one operation.
pub struct Draw<'a> {
    operation: &'a Operation,
    hard: Vec<[f64; 2]>,
    source: Source,
}

impl Draw<'_> {
    pub fn new(operation: &Operation, seed: u64) -> Draw<'_> {
        // Every operation and seed its own stream, FNV-1a of both.
        let bytes = operation.name.bytes().chain(seed.to_le_bytes());
        let start = bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        });
        Draw {
            operation,
            hard: hard(operation.name),
            source: Source(start),
        }
    }

    pub fn columns(&mut self, count: usize) -> Vec<Vec<Interval>> {
        let mut columns = vec![Vec::with_capacity(count); self.operation.arity()];
        for _ in 0..count {
            for (column, x) in columns.iter_mut().zip(self.case()) {
                column.push(x);
            }
        }
        columns
    }

    fn case(&mut self) -> Vec<Interval> {
        let kinds = self.operation.kinds;
        if let [Kind::Any, Kind::Any, rest @ ..] = kinds {
            let (a, b) = self.source.floats();
            let mut case = vec![self.around(a, Kind::Any), self.around(b, Kind::Any)];
            for kind in rest {
                // A summand that may cancel the product.
                let c = match self.source.below(3) {
                    0 => -a * b,
                    1 => -a * b * (1.0 + self.source.between(-1.0, 1.0) * 2_f64.powi(-40)),
                    _ => self.number(*kind),
                };
                case.push(self.around(if c.is_finite() { c } else { 1.0 }, *kind));
            }
            return case;
        }
        let mut case: Vec<Interval> = Vec::with_capacity(kinds.len());
        for &kind in kinds {
            let x = match kind {
                Kind::Degree => {
                    let n = self.degree();
                    if self.source.below(4) == 0 {
                        // A power that neither overflows nor vanishes, whatever the degree.
                        let size = self.source.between(-1100.0, 1100.0) / f64::from(n.abs().max(1));
                        let x = self.around(size.exp2().min(f64::MAX), Kind::Any);
                        case[0] = if self.source.below(2) == 0 { -x } else { x };
                    }
                    Interval::point(f64::from(n))
                }
                Kind::Exponent => self.exponent(case[0]),
                _ => {
                    let x = self.number(kind);
                    self.around(x, kind)
                }
            };
            case.push(x);
        }
        case
    }

    fn degree(&mut self) -> i32 {
        let size = match self.source.below(64) {
            0..40 => self.source.below(6),
            40..62 => self.source.below(25),
            _ => self.source.below(1100),
        };
        if self.source.below(3) == 0 {
            -(size as i32)
        } else {
            size as i32
        }
    }

    /// An exponent for which most powers of the elements of `x` neither overflow nor vanish.
    fn exponent(&mut self, x: Interval) -> Interval {
        let small = [0.5, 1.0, 2.0, 3.0, 1.5, 0.25, -1.0, -0.5, 10.0];
        let near = x.mid().abs();
        let most = (1100.0 / near.log2().abs().max(1e-300)).min(1e300);
        let y = match self.source.below(8) {
            0 => small[self.source.below(small.len() as u64) as usize],
            1 => self.source.float(),
            2 => self.source.between(-1100.0, 1100.0).round(),
            _ => self.source.between(-most, most),
        };
        self.around(y, Kind::Any)
    }

    /// A number of a kind, finite.
    fn number(&mut self, kind: Kind) -> f64 {
        let source = &mut self.source;
        if !self.hard.is_empty() && source.below(32) == 0 {
            let [x, _] = self.hard[source.below(self.hard.len() as u64) as usize];
            return stepped(x, source.below(9) as i64 - 4);
        }
        match kind {
            Kind::Range(from, to, turns) => match source.below(16) {
                0..3 => source
                    .float()
                    .clamp(from.next_down().max(f64::MIN), to.next_up().min(f64::MAX)),
                3..6 if !turns.is_empty() => {
                    let turn = turns[source.below(turns.len() as u64) as usize];
                    let x = stepped(turn, source.below(9) as i64 - 4);
                    // Also at a middling distance, where a value is near its limit.
                    if source.below(2) == 0 {
                        x
                    } else {
                        x + source.between(-1.0, 1.0) * 2_f64.powi(-(source.below(50) as i32))
                    }
                }
                6 => source.between(from.max(-2000.0), to.min(2000.0)).round(),
                // The exponent evenly, down to where functions are nearly straight.
                7..10 => {
                    let top = to.abs().max(from.abs()).log2();
                    let x = source.between(-70.0, top).exp2();
                    if from < 0.0 && source.below(2) == 0 {
                        -x
                    } else {
                        x
                    }
                }
                10 if to == f64::MAX => f64::from_bits(source.below(f64::INFINITY.to_bits())),
                _ => source.between(from.max(-1e6), to.min(1e6)),
            },
            Kind::Angle => match source.below(16) {
                0..3 => source.float(),
                // Floats next to multiples of π/2, small and large.
                3..6 => {
                    let bits = 1 + source.below(53);
                    let turns = source.below(1 << bits) as f64;
                    stepped(turns * FRAC_PI_2, source.below(5) as i64 - 2)
                }
                6 => 2_f64.powi(source.below(1024) as i32) * (1.0 + source.unit()),
                7..10 => source.between(-60.0, 20.0).exp2(),
                _ => source.between(-100.0, 100.0),
            },
            _ => source.float(),
        }
    }

    /// An interval with the number as an end: itself alone, a few floats, a bit more, wide, unbounded.
    fn around(&mut self, x: f64, kind: Kind) -> Interval {
        let choice = self.source.below(64);
        let other = match choice {
            0..20 => x,
            20..28 => stepped(x, 1 + self.source.below(4) as i64),
            28..38 => x + x.abs() * 2_f64.powi(-(self.source.below(53) as i32)),
            38..44 if matches!(kind, Kind::Angle) => x + self.source.between(0.0, 7.0),
            44..47 if matches!(kind, Kind::Angle) => x + self.source.below(6) as f64 * FRAC_PI_2,
            38..50 => self.number(kind),
            50..56 => x + self.source.between(0.0, 1.0),
            56..59 => 0.0,
            59 => -x,
            60 => f64::INFINITY,
            61 => f64::NEG_INFINITY,
            62 if self.source.below(8) == 0 => return Interval::EMPTY,
            62 if self.source.below(8) == 0 => return Interval::ENTIRE,
            _ => self.source.float(),
        };
        if other.is_nan() {
            return Interval::point(x);
        }
        Interval::new(x.min(other), x.max(other)).unwrap_or(Interval::point(x))
    }
}

/// The float so many steps further; the largest one at most.
fn stepped(x: f64, steps: i64) -> f64 {
    let walk = |x: f64, _| {
        if steps > 0 {
            x.next_up()
        } else {
            x.next_down()
        }
    };
    (0..steps.unsigned_abs())
        .fold(x, walk)
        .clamp(f64::MIN, f64::MAX)
}

/// All combinations of special arguments of an operation.
pub struct Directed {
    choices: Vec<Vec<Interval>>,
    pairs: Vec<[Interval; 2]>,
}

impl Directed {
    pub fn len(&self) -> usize {
        self.choices.iter().map(Vec::len).product::<usize>() + self.pairs.len()
    }

    /// Some of the cases, counted from `first`.
    pub fn columns(&self, first: usize, count: usize) -> Vec<Vec<Interval>> {
        let cases = first..(first + count).min(self.len());
        let combined: usize = self.choices.iter().map(Vec::len).product();
        (0..self.choices.len())
            .map(|column| {
                let before: usize = self.choices[..column].iter().map(Vec::len).product();
                let choice = |case: usize| {
                    if case >= combined {
                        return self.pairs[case - combined][column];
                    }
                    let choices = &self.choices[column];
                    choices[case / before % choices.len()]
                };
                cases.clone().map(choice).collect()
            })
            .collect()
    }
}

pub fn directed(operation: &Operation) -> Directed {
    let alone = operation.arity() == 1;
    let hard = hard(operation.name);
    let choices = operation.kinds.iter().map(|&kind| match kind {
        Kind::Degree => (-24..=24)
            .chain([-1075, -1074, -100, -53, 53, 100, 1023, 1024, 1074])
            .map(|n| Interval::point(f64::from(n)))
            .collect(),
        _ => {
            let numbers = match operation.arity() {
                1 => many(kind, &hard),
                2 => some(),
                _ => few(),
            };
            intervals(&numbers, alone)
        }
    });
    let hard_pairs = hard.iter().filter(|_| !alone);
    Directed {
        choices: choices.collect(),
        pairs: hard_pairs.map(|case| case.map(Interval::point)).collect(),
    }
}

/// All intervals between these numbers and the infinities, and the empty set.
fn intervals(positive: &[f64], neighbours: bool) -> Vec<Interval> {
    let mut numbers: Vec<f64> = positive.iter().flat_map(|&x| [x, -x]).collect();
    if neighbours {
        let next = numbers.clone();
        numbers.extend(next.iter().flat_map(|x| [x.next_up(), x.next_down()]));
    }
    numbers.extend([0.0, f64::INFINITY, f64::NEG_INFINITY]);
    numbers.sort_by(f64::total_cmp);
    numbers.dedup();
    let mut all = vec![Interval::EMPTY];
    for (first, &lo) in numbers.iter().enumerate() {
        all.extend(
            numbers[first..]
                .iter()
                .filter_map(|&hi| Interval::new(lo, hi)),
        );
    }
    all
}

fn few() -> Vec<f64> {
    vec![f64::from_bits(1), 1.0, 1.0 + f64::EPSILON, 3.0, f64::MAX]
}

fn some() -> Vec<f64> {
    let mut numbers = few();
    numbers.extend([
        f64::MIN_POSITIVE.next_down(),
        f64::MIN_POSITIVE,
        2_f64.powi(-537),
        1e-160,
        1.0 - 0.5 * f64::EPSILON,
        0.5,
        2.0,
        1024.0,
        2_f64.powi(53) + 2.0,
        1e160,
        f64::MAX.next_down(),
    ]);
    numbers
}

/// Special numbers of a function of one argument.
fn many(kind: Kind, hard: &[[f64; 2]]) -> Vec<f64> {
    let mut numbers = some();
    numbers.extend(
        [
            -1022, -960, -500, -480, -53, -27, -26, -10, -2, 10, 52, 480, 511, 960, 1023,
        ]
        .map(|e| 2_f64.powi(e)),
    );
    numbers.extend([10.0, 1.0 / 3.0, 0.1, 20.0]);
    numbers.extend(hard.iter().map(|[x, _]| x.abs()));
    match kind {
        Kind::Range(from, to, turns) => {
            numbers.extend(turns.iter().map(|x| x.abs()));
            numbers.extend([from.abs(), to.abs()]);
        }
        Kind::Angle => numbers.extend([
            FRAC_PI_2,
            PI,
            3.0 * FRAC_PI_2,
            2.0 * PI,
            100.0 * PI,
            1e5,
            1e22,
            2_f64.powi(53) * FRAC_PI_2,
            // The float nearest to a multiple of π/2, relative to it.
            6_381_956_970_095_103.0 * 2_f64.powi(797),
        ]),
        _ => {}
    }
    numbers
}
