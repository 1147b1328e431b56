//! One step of a form. The theorem is in the comment of [`super`].
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: vectors have one entry per state, matrices `n * n`; orders stay below the stride"
)]

use super::ahead::{ahead, around, later};
use super::code::Op;
use super::compare::exponential;
use super::error::Errors;
use super::outward::{UNIT, raised};
use super::piece::Piece;
use super::series::{Recursion, Series};
use super::set::Form;
use veribound_interval::lanes::Value;
use veribound_interval::{Interval, Interval8};

/// Rounds in which the bound of the deviation may grow before a step is called too long.
const ROUNDS: usize = 8;

/// Rounds in which the units of states are balanced.
const BALANCING: usize = 8;

/// Times a step is shortened before it is given up.
const SHORTENINGS: usize = 40;

/// Why a step could not be proved.
///
/// Example: [`Diverged`](crate::form::Diverged).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstacle {
    /// Even the shortest step allowed finds no bound: the set grew too much.
    TooLong,
    /// A function is not defined, or not smooth, somewhere on the set.
    Undefined,
    /// The right-hand side may jump on the set.
    Jump,
    /// Numbers became too large.
    Unbounded,
    /// The set, or an input, may leave the domain in which the guards of the modes are proved to leave no
    /// gap.
    LeavesDomain,
    /// Whoever watched did not want to go on.
    Interrupted,
    /// Comparison bounds end: the right-hand side is not proved to be monotone.
    NotMonotone,
    /// There is no closed form: the rate of the state is not affine in the states.
    NotAffine,
    /// Comparison bounds end: they would take many times the work of forms.
    Costly,
}

/// Scratch for steps of one shape of forms.
#[derive(Debug, Clone)]
pub(super) struct Scratch {
    pub(super) series: Series,
    pub(super) errors: Errors,
    /// Radii on the polynomial itself, and on everything within the bound of the deviation.
    pub(super) radii: [Vec<f64>; 2],
    orders: usize,
}

impl Scratch {
    pub(super) fn new(piece: &Piece, form: &Form) -> Scratch {
        let orders = form.order;
        let count = piece.code.instructions.len();
        let mut series = Series::new(&piece.code, &form.monomials, orders);
        for (register, step) in piece.code.instructions.iter().enumerate() {
            if let Op::Constant(value) = step.op {
                series.start(register, &[value.mid()]);
            }
        }
        Scratch {
            errors: Errors::new(&piece.code, &form.monomials, series.stride),
            series,
            radii: [vec![0.0; count], vec![0.0; count]],
            orders,
        }
    }

    /// Encloses a register at all times of a prepared step, for all solutions within the deviation.
    pub(super) fn around(&self, register: usize) -> Interval {
        let size = &self.errors.sizes[register];
        let off = raised(size.deviation + self.radii[1][register], 1);
        Interval::point(size.centre).inflate(off)
    }
}

/// A step that is proved to be possible up to some time.
pub(super) struct Prepared {
    /// Length of the unit of time.
    pub(super) unit: f64,
    pub(super) bounds: Bounds,
    /// As long as was asked for.
    pub(super) last: bool,
}

impl Prepared {
    /// How long the next step should be, where this one was tried with that length.
    pub(super) fn next_step(&self, tried: f64) -> f64 {
        let span = self.bounds.span;
        let reached = if self.last {
            span.max(tried / self.unit)
        } else {
            2.0 * span
        };
        self.unit * reached
    }
}

/// When a step ends, in scaled time.
pub(super) enum End {
    /// At one time for all solutions, known up to `off` seconds.
    At { scaled: f64, off: f64 },
    /// At a time of its own for every `δ`; where that is before the start or after `last`, nothing is claimed.
    Own { scaled: Vec<f64>, last: f64 },
}

impl End {
    /// All the times.
    fn times(&self) -> Interval {
        match self {
            End::At { scaled, .. } => Interval::point(*scaled),
            // Before the start nobody is on the way.
            End::Own { scaled, last } => {
                let all = around(scaled);
                let [lo, hi] = [all.lo(), all.hi()].map(|x| x.clamp(0.0, *last));
                Interval::new(lo, hi).unwrap_or(all)
            }
        }
    }
}

/// Where solutions are at some time: at `states(δ) + map e + lows + more` for what dependence could
/// not keep of them before, `e`.
pub(super) struct Arrival {
    pub(super) states: Vec<Vec<f64>>,
    pub(super) lows: Vec<f64>,
    pub(super) map: Vec<Interval>,
    pub(super) more: Vec<Interval>,
    /// At all times of the prepared step.
    pub(super) during: Vec<Interval>,
}

impl Arrival {
    /// Moves `form`, which set out, there; not its tube.
    pub(super) fn land(self, form: &mut Form) {
        form.states = self.states;
        form.transport(&self.map, &self.lows, &self.more);
    }
}

/// What a step proved.
pub(super) struct Bounds {
    /// Time at the end, scaled.
    pub(super) span: f64,
    /// How far solutions can be from the polynomial during the step.
    pub(super) deviation: Vec<f64>,
    /// How fast they can move away from it at once, in scaled time.
    pub(super) defect: Vec<f64>,
    /// `|∂f/∂x|`, scaled by the length of the step.
    pub(super) steepness: Vec<f64>,
}

impl Piece {
    /// Expands the solution of `form` and bounds the deviation from it for at most `longest`, where a
    /// promising length and the bound say so; the inputs are any measurable functions in `inputs`, and
    /// the rates may be off by `extra` besides.
    pub(super) fn prepare(
        &self,
        form: &Form,
        scratch: &mut Scratch,
        (inputs, extra): (&[Interval], &[f64]),
        longest: Interval,
        shortest: f64,
    ) -> Result<Prepared, Obstacle> {
        let mut unit = binary(form.step.min(2.0 * longest.hi()));
        // A shorter unit has to make a shorter step also where no coefficient limits it, as of polynomial solutions.
        let furthest = raised(longest.hi() / unit, 1);
        let mut attempts = 0;
        loop {
            attempts += 1;
            let most = raised(longest.hi() / unit, 1);
            let reach = most.min(furthest);
            let obstacle = match self.attempt(form, scratch, (inputs, extra), reach, unit) {
                Ok(bounds) => {
                    return Ok(Prepared {
                        last: bounds.span >= most,
                        unit,
                        bounds,
                    });
                }
                Err(obstacle) if attempts > SHORTENINGS || unit < shortest => {
                    return Err(obstacle);
                }
                Err(obstacle) => obstacle,
            };
            unit *= match obstacle {
                Obstacle::Unbounded => 1.0 / 64.0,
                _ => 0.25,
            };
            // What is no number must not meet the zeros of the next attempt.
            scratch.series.clear(&self.code);
        }
    }

    /// One attempt in time scaled by `unit`, a power of two.
    fn attempt(
        &self,
        form: &Form,
        scratch: &mut Scratch,
        given: (&[Interval], &[f64]),
        most: f64,
        unit: f64,
    ) -> Result<Bounds, Obstacle> {
        self.expand(form, scratch, given.0, unit)?;
        let mut span = self.promising(form, scratch, unit).min(most);
        let reach = form.frame.hull();
        let mut tries = 0;
        loop {
            tries += 1;
            match self.bound(form, scratch, given, (unit, span), &reach) {
                Ok(bounds) => return Ok(bounds),
                Err(obstacle) if tries > 3 || obstacle == Obstacle::Unbounded => {
                    return Err(obstacle);
                }
                Err(_) => span *= 0.5,
            }
        }
    }

    /// The length of time that ends a prepared step of `longest`, and the same in scaled time.
    pub(super) fn last(longest: Interval, unit: f64) -> End {
        let middle = longest.mid();
        let scaled = middle / unit;
        let off = (longest - Interval::point(scaled) * Interval::point(unit)).mag();
        End::At { scaled, off }
    }

    /// Where solutions are at the end of a prepared step.
    pub(super) fn arrival(
        &self,
        form: &Form,
        scratch: &Scratch,
        prepared: &Prepared,
        end: &End,
    ) -> Result<Arrival, Obstacle> {
        let (n, orders) = (self.states, scratch.orders);
        let Prepared { unit, bounds, .. } = prepared;
        let reach = form.frame.hull();
        let map = self.fundamental(form, scratch, *unit, end.times());
        let leak = self.leak(scratch, &map, *unit, bounds, &reach);
        let leak = leak.ok_or(Obstacle::TooLong)?;
        let errors = &scratch.errors;
        let mut arrival = Arrival {
            states: Vec::with_capacity(n),
            lows: vec![0.0; n],
            map: map.matrix,
            more: vec![Interval::ZERO; n],
            during: Vec::with_capacity(n),
        };
        for (i, (leak, &register)) in leak.iter().zip(&self.code.states).enumerate() {
            let (block, size) = (scratch.series.block(register), &errors.sizes[register]);
            let (polynomial, lost) = match end {
                End::At { scaled, off } => {
                    let place = ahead(block, size, (orders, *scaled), &errors.weights);
                    arrival.lows[i] = place.low;
                    let rate = self.rates[i];
                    let speed = errors.sizes[rate].total + scratch.radii[1][rate];
                    (place.polynomial, raised(place.lost + off * speed, 2))
                }
                End::Own { scaled, .. } => later(
                    &form.monomials,
                    block,
                    (orders, scratch.series.stride),
                    scaled,
                ),
            };
            arrival.more[i] = Interval::symmetric(raised(leak + lost, 4));
            arrival.states.push(polynomial);
            let reach = raised(size.deviation + bounds.deviation[i], 1);
            arrival
                .during
                .push(Interval::point(size.centre).inflate(reach));
        }
        Ok(arrival)
    }

    /// Taylor coefficients of the polynomial solution.
    fn expand(
        &self,
        form: &Form,
        scratch: &mut Scratch,
        inputs: &[Interval],
        unit: f64,
    ) -> Result<(), Obstacle> {
        let (orders, secondary) = (scratch.orders, form.slopes());
        let series = &mut scratch.series;
        for (register, step) in self.code.instructions.iter().enumerate() {
            match step.op {
                Op::State(i) => series.start(register, &form.states[i]),
                Op::Param(i) => series.start(register, &form.params[i].polynomial),
                Op::Input(i) => series.start(register, &[inputs[i].mid()]),
                _ => {}
            }
        }
        let states = self.code.states.iter().copied();
        let rates = states.zip(self.rates.iter().copied());
        let moves = |(state, _): &(usize, usize)| self.code.instructions[*state].moving;
        let rates: Vec<(usize, usize)> = rates.filter(moves).collect();
        let done = Interval8::run(Recursion {
            series,
            context: (&self.code, &form.monomials, &self.functions),
            rates: &rates,
            orders: (orders, secondary),
            unit,
        });
        done.map_err(|_| Obstacle::Undefined)
    }

    /// The scaled time after which the first neglected term reaches the tolerance: a hint.
    fn promising(&self, form: &Form, scratch: &Scratch, unit: f64) -> f64 {
        let orders = scratch.orders;
        let stride = scratch.series.stride;
        let mut span = f64::INFINITY;
        for (i, rate) in self.rates.iter().enumerate() {
            let block = scratch.series.block(*rate);
            let norm = |j: usize| -> f64 {
                let row = block.chunks_exact(stride);
                unit * row.map(|row| row[j].abs()).sum::<f64>()
            };
            let tolerance = form.tolerance(i);
            for j in [orders - 1, orders] {
                let size = norm(j);
                if size > 0.0 {
                    span = span.min((tolerance / size).powf(1.0 / (j + 1) as f64));
                }
            }
        }
        let span = span.min(form.options.steepest / self.steepness(scratch, unit));
        if span.is_finite() { span } else { 1e6 }
    }

    /// About the spectral radius of `|∂f/∂x|`, from above: that of the comparison equation, whatever the units of
    /// states are (Collatz and Wielandt: `max (C v)_i / v_i` for any positive `v`).
    fn steepness(&self, scratch: &Scratch, unit: f64) -> f64 {
        let slopes = self.slopes.iter();
        let entries: Vec<(usize, usize, f64)> = slopes
            .map(|&(i, l, register)| (i, l, scratch.series.block(register)[0].abs() * unit))
            .collect();
        let mut v = vec![1.0; self.states];
        let mut least = f64::INFINITY;
        for _ in 0..BALANCING {
            let mut product = vec![0.0; self.states];
            for (i, l, x) in &entries {
                product[*i] += x * v[*l];
            }
            let ratios = product.iter().zip(&v).map(|(x, v)| x / v);
            least = least.min(ratios.fold(0.0, f64::max));
            // Shifted, so that rotations settle.
            let shift = 0.5 * least + 1e-300;
            let largest = product.iter().zip(&v).map(|(x, v)| x + shift * v);
            let largest = largest.fold(0.0, f64::max) + 1e-300;
            for (v, x) in v.iter_mut().zip(&product) {
                *v = ((x + shift * *v) / largest).max(1e-100);
            }
        }
        least
    }

    /// Bounds the deviation of every solution that starts within `reach` of the polynomial.
    fn bound(
        &self,
        form: &Form,
        scratch: &mut Scratch,
        (inputs, extra): (&[Interval], &[f64]),
        (unit, span): (f64, f64),
        reach: &[Interval],
    ) -> Result<Bounds, Obstacle> {
        let (n, orders) = (self.states, scratch.orders);
        let given = |op: Op| match op {
            Op::Constant(value) => value.rad(),
            Op::Param(i) => form.params[i].radius,
            Op::Input(i) => inputs[i].rad(),
            _ => 0.0,
        };
        let errors = &mut scratch.errors;
        errors
            .measure(
                (&self.code, &form.monomials, &self.functions),
                &scratch.series,
                (span, orders, form.slopes()),
                &given,
            )
            .map_err(Obstacle::from)?;
        let [exact, near] = &mut scratch.radii;
        let on_it = vec![0.0; n];
        errors
            .radii(&self.code, &self.functions, &on_it, exact)
            .map_err(Obstacle::from)?;
        let defect: Vec<f64> = self
            .rates
            .iter()
            .zip(extra)
            .map(|(&rate, extra)| {
                let size = &errors.sizes[rate];
                let open = if size.top == orders {
                    size.time[orders]
                } else {
                    0.0
                };
                // Division by a power of two is exact.
                let divided = size.time[..=size.top].iter().enumerate();
                let rounding: f64 = divided
                    .filter(|(j, _)| !(j + 1).is_power_of_two())
                    .map(|(_, x)| 2.01 * UNIT * x)
                    .sum();
                raised(unit * (exact[rate] + open + rounding + extra), orders + 5)
            })
            .collect();
        let from: Vec<f64> = reach.iter().map(|x| x.mag()).collect();
        let over: Vec<f64> = defect.iter().map(|d| raised(d * span, 1)).collect();
        let mut deviation: Vec<f64> = from
            .iter()
            .zip(&over)
            .map(|(a, b)| 2.0 * (a + b) + 1e-200)
            .collect();
        let mut steepness = vec![0.0; n * n];
        for _ in 0..ROUNDS {
            errors
                .radii(&self.code, &self.functions, &deviation, near)
                .map_err(Obstacle::from)?;
            steepness.fill(0.0);
            for &(i, l, register) in &self.slopes {
                let size = &errors.sizes[register];
                let around = raised(size.deviation + near[register], 1);
                let most = if i == l {
                    (size.centre + around).max(0.0)
                } else {
                    size.centre.abs() + around
                };
                steepness[i * n + l] = raised(most * unit * span, 3);
            }
            let start = exponential(n, &steepness, &from, 0).ok_or(Obstacle::TooLong)?;
            let gained = exponential(n, &steepness, &over, 1).ok_or(Obstacle::TooLong)?;
            let bound: Vec<f64> = start
                .iter()
                .zip(&gained)
                .map(|(a, b)| raised(a + b, 1))
                .collect();
            if bound.iter().zip(&deviation).all(|(b, d)| b < d) {
                return Ok(Bounds {
                    span,
                    deviation,
                    defect,
                    steepness,
                });
            }
            for (d, b) in deviation.iter_mut().zip(&bound) {
                *d = d.max(1.5 * b);
            }
        }
        Err(Obstacle::TooLong)
    }
}

/// The largest power of two that is not above `x`.
fn binary(x: f64) -> f64 {
    if x.is_normal() {
        f64::from_bits(x.to_bits() & (0x7ff << 52))
    } else {
        1.0
    }
}
