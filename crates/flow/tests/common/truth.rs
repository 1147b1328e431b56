//! True solutions of switching systems, in plain floating point, with every event located.
//!
//! A system is `x' = f(x, p, u) + sum_i s_i b_i(x, p, u)` with `s_i` in `Sgn(g_i(x, p, u))`. Every
//! model that the tests attack has this form, whatever way its file writes it. While `g_i` stays at
//! zero, `s_i` is the value that keeps it there; where several continuations exist, one is drawn.
//! Steps of the classical Runge-Kutta method of order 4 are so short that their error is far below
//! the tolerance of the tests, and end at every event.

use super::Rng;

pub type Field = fn(&[f64], &[f64], &[f64], &mut [f64]);
pub type Scalar = fn(&[f64], &[f64], &[f64]) -> f64;

/// `g`, affine in the states, and `b`.
#[derive(Clone, Copy)]
pub struct Switch {
    pub g: Scalar,
    pub b: Field,
}

#[derive(Clone, Copy)]
pub struct Truth {
    pub states: usize,
    pub f: Field,
    pub switches: &'static [Switch],
    /// Where `f` or some `b` has a kink: steps end at zeros of these.
    pub kinks: &'static [Scalar],
    /// Longest step of the integrator.
    pub longest: f64,
}

/// What happened, to be sure that tests meet what they are about.
#[derive(Debug, Clone, Copy, Default)]
pub struct Events {
    pub crossings: u64,
    pub captures: u64,
    pub releases: u64,
    pub choices: u64,
    pub kinks: u64,
}

impl Events {
    pub fn add(&mut self, other: Events) {
        self.crossings += other.crossings;
        self.captures += other.captures;
        self.releases += other.releases;
        self.choices += other.choices;
        self.kinks += other.kinks;
    }
}

#[derive(Clone)]
pub struct Sim {
    truth: Truth,
    pub x: Vec<f64>,
    pub p: Vec<f64>,
    u: Vec<f64>,
    /// Per switch: -1, +1, or 0 while it is held at zero.
    side: Vec<i8>,
    pub events: Events,
}

const ON_SURFACE: f64 = 1e-12;

impl Sim {
    pub fn new(truth: Truth, x: &[f64], p: &[f64]) -> Sim {
        Sim {
            truth,
            x: x.to_vec(),
            p: p.to_vec(),
            u: Vec::new(),
            side: Vec::new(),
            events: Events::default(),
        }
    }

    /// New parameters from now on.
    pub fn set_params(&mut self, p: &[f64]) {
        self.p = p.to_vec();
        self.side.clear();
    }

    fn g(&self, i: usize, x: &[f64]) -> f64 {
        (self.truth.switches[i].g)(x, &self.p, &self.u)
    }

    /// Time derivative of `g_i` along `v`.
    fn slope(&self, i: usize, x: &[f64], v: &[f64]) -> f64 {
        let moved: Vec<f64> = x.iter().zip(v).map(|(x, v)| x + v).collect();
        self.g(i, &moved) - self.g(i, x)
    }

    fn b(&self, i: usize, x: &[f64]) -> Vec<f64> {
        let mut b = vec![0.0; self.truth.states];
        (self.truth.switches[i].b)(x, &self.p, &self.u, &mut b);
        b
    }

    /// The velocity with the given sides, and the values of the switches held at zero.
    fn velocity(&self, x: &[f64], side: &[i8]) -> Option<(Vec<f64>, Vec<f64>)> {
        let mut v = vec![0.0; self.truth.states];
        (self.truth.f)(x, &self.p, &self.u, &mut v);
        let mut s: Vec<f64> = side.iter().map(|s| f64::from(*s)).collect();
        for i in 0..side.len() {
            if side[i] != 0 {
                for (v, b) in v.iter_mut().zip(self.b(i, x)) {
                    *v += s[i] * b;
                }
            }
        }
        let held: Vec<usize> = (0..side.len()).filter(|i| side[*i] == 0).collect();
        if !held.is_empty() {
            let b: Vec<Vec<f64>> = held.iter().map(|i| self.b(*i, x)).collect();
            let n = held.len();
            let mut m = vec![vec![0.0; n + 1]; n];
            for (row, &i) in held.iter().enumerate() {
                for (column, b) in b.iter().enumerate() {
                    m[row][column] = self.slope(i, x, b);
                }
                m[row][n] = -self.slope(i, x, &v);
            }
            let values = solve(m)?;
            for ((&i, value), b) in held.iter().zip(&values).zip(&b) {
                s[i] = *value;
                for (v, b) in v.iter_mut().zip(b) {
                    *v += value * b;
                }
            }
        }
        Some((v, s))
    }

    /// Picks the sides of all switches at the present point.
    fn decide(&mut self, rng: &mut Rng) {
        let count = self.truth.switches.len();
        let mut open = Vec::new();
        let mut side = vec![0_i8; count];
        for i in 0..count {
            let g = self.g(i, &self.x);
            let was_held = self.side.get(i) == Some(&0);
            if g.abs() <= ON_SURFACE || (was_held && g.abs() <= 1e-9) {
                open.push(i);
            } else {
                side[i] = if g > 0.0 { 1 } else { -1 };
            }
        }
        if open.is_empty() {
            self.side = side;
            return;
        }
        for (tolerance, needed) in [(0.0, 1e-13), (1e-12, -1e-12), (1e-9, -1e-9)] {
            let mut fitting = Vec::new();
            for number in 0..3_usize.pow(open.len() as u32) {
                let mut rest = number;
                for &i in &open {
                    side[i] = [0, 1, -1][rest % 3];
                    rest /= 3;
                }
                let Some((v, s)) = self.velocity(&self.x, &side) else {
                    continue;
                };
                let fits = open.iter().all(|&i| match side[i] {
                    0 => s[i].abs() <= 1.0 + tolerance,
                    sign => f64::from(sign) * self.slope(i, &self.x, &v) >= needed,
                });
                if fits {
                    fitting.push(side.clone());
                }
            }
            if !fitting.is_empty() {
                if fitting.len() > 1 {
                    self.events.choices += 1;
                }
                let chosen = fitting[rng.below(fitting.len())].clone();
                for i in 0..count {
                    let before = self.side.get(i).copied().unwrap_or(chosen[i]);
                    match (before, chosen[i]) {
                        (a, b) if a == b => {}
                        (0, _) => self.events.releases += 1,
                        (_, 0) => self.events.captures += 1,
                        _ => self.events.crossings += 1,
                    }
                }
                self.side = chosen;
                return;
            }
        }
        panic!(
            "no continuation at {:?} p {:?} u {:?}",
            self.x, self.p, self.u
        );
    }

    fn runge_kutta(&self, d: f64) -> Vec<f64> {
        let at = |x: &[f64]| self.velocity(x, &self.side).map(|(v, _)| v);
        let shifted = |k: &[f64], d: f64| -> Vec<f64> {
            self.x.iter().zip(k).map(|(x, k)| x + d * k).collect()
        };
        let step = || {
            let a = at(&self.x)?;
            let b = at(&shifted(&a, d / 2.0))?;
            let c = at(&shifted(&b, d / 2.0))?;
            let e = at(&shifted(&c, d))?;
            let sum: Vec<f64> = (0..a.len())
                .map(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + e[i]) / 6.0)
                .collect();
            Some(shifted(&sum, d))
        };
        step().unwrap()
    }

    /// True when the sides no longer fit at `x`.
    fn left(&self, x: &[f64]) -> bool {
        let held = self.side.contains(&0).then(|| self.velocity(x, &self.side));
        (0..self.side.len()).any(|i| match self.side[i] {
            0 => held
                .as_ref()
                .and_then(Option::as_ref)
                .is_none_or(|(_, s)| s[i].abs() > 1.0 + 1e-13),
            sign => f64::from(sign) * self.g(i, x) < 0.0,
        })
    }

    /// A duration below `d` after which some `g` is past a dip below zero that the end of the step
    /// does not show.
    fn dip(&self, d: f64) -> Option<f64> {
        let end = self.runge_kutta(d);
        for i in 0..self.side.len() {
            let sign = f64::from(self.side[i]);
            if sign == 0.0 {
                continue;
            }
            let rate = |x: &[f64]| {
                let (v, _) = self.velocity(x, &self.side).unwrap();
                sign * self.slope(i, x, &v)
            };
            if rate(&self.x) < 0.0 && rate(&end) > 0.0 {
                let (mut lo, mut hi) = (0.0, d);
                for _ in 0..60 {
                    let middle = 0.5 * (lo + hi);
                    if rate(&self.runge_kutta(middle)) < 0.0 {
                        lo = middle;
                    } else {
                        hi = middle;
                    }
                }
                if sign * self.g(i, &self.runge_kutta(hi)) < 0.0 {
                    return Some(hi);
                }
            }
        }
        None
    }

    /// Moves on by `h` with constant inputs.
    pub fn advance(&mut self, u: &[f64], h: f64, rng: &mut Rng) {
        self.u = u.to_vec();
        self.decide(rng);
        let kinks = |x: &[f64], p: &[f64], u: &[f64]| -> Vec<bool> {
            self.truth.kinks.iter().map(|k| k(x, p, u) > 0.0).collect()
        };
        let mut rest = h;
        let mut stalled = 0;
        while rest > 0.0 {
            let mut d = rest.min(self.truth.longest);
            if let Some(earlier) = self.dip(d) {
                d = earlier;
            }
            let mut next = self.runge_kutta(d);
            if self.left(&next) {
                let (mut lo, mut hi) = (0.0, d);
                for _ in 0..60 {
                    let middle = 0.5 * (lo + hi);
                    if self.left(&self.runge_kutta(middle)) {
                        hi = middle;
                    } else {
                        lo = middle;
                    }
                }
                stalled = if hi < 1e-13 { stalled + 1 } else { 0 };
                if stalled > 3 {
                    // A tie that no rule at the point decides: look a moment later.
                    hi = 1e-10_f64.min(rest);
                    stalled = 0;
                }
                self.x = self.runge_kutta(hi);
                rest -= hi;
                self.decide(rng);
                continue;
            }
            let before = kinks(&self.x, &self.p, &self.u);
            if before != kinks(&next, &self.p, &self.u) {
                let (mut lo, mut hi) = (0.0, d);
                for _ in 0..60 {
                    let middle = 0.5 * (lo + hi);
                    let x = self.runge_kutta(middle);
                    if before == kinks(&x, &self.p, &self.u) {
                        lo = middle;
                    } else {
                        hi = middle;
                    }
                }
                d = hi;
                next = self.runge_kutta(d);
                self.events.kinks += 1;
            }
            self.x = next;
            rest -= d;
        }
    }
}

/// Solves the linear system whose rows are `[a | b]`; `None` when it is singular.
fn solve(mut m: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = m.len();
    for column in 0..n {
        let pivot =
            (column..n).max_by(|a, b| m[*a][column].abs().total_cmp(&m[*b][column].abs()))?;
        if m[pivot][column].abs() < 1e-9 {
            return None;
        }
        m.swap(column, pivot);
        for row in 0..n {
            if row != column {
                let factor = m[row][column] / m[column][column];
                for k in column..=n {
                    let value = m[column][k];
                    m[row][k] -= factor * value;
                }
            }
        }
    }
    Some((0..n).map(|i| m[i][n] / m[i][i]).collect())
}
