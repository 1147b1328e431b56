//! True solutions of systems that jump, in plain floating point, with every event located.
//!
//! A solution flows where no condition holds and jumps where one does. What keeps jumping to where it
//! is rests: the states that the jump sets stay at what it sets them to, the others go on. Steps of the
//! classical Runge-Kutta method end at every event; on the border of a condition it is drawn whether
//! the solution jumps.

use super::Rng;

pub type Field = fn(&[f64], &[f64], &[f64], &mut [f64]);
pub type Scalar = fn(&[f64], &[f64], &[f64]) -> f64;

/// A jump whose condition is that of any list all comparisons are below zero.
#[derive(Clone, Copy)]
pub struct Jump {
    pub when: &'static [&'static [Scalar]],
    /// States that it sets.
    pub sets: &'static [usize],
    /// Overwrites those with their new values.
    pub set: Field,
}

#[derive(Clone, Copy)]
pub struct Hybrid {
    pub states: usize,
    pub f: Field,
    pub jumps: &'static [Jump],
    /// Longest step of the integrator.
    pub longest: f64,
}

/// What happened, to be sure that tests meet what they are about.
#[derive(Debug, Clone, Copy, Default)]
pub struct Events {
    pub jumps: u64,
    pub rests: u64,
    pub choices: u64,
}

#[derive(Clone)]
pub struct Sim {
    hybrid: Hybrid,
    pub x: Vec<f64>,
    pub p: Vec<f64>,
    pub u: Vec<f64>,
    /// The jump at which the solution rests.
    resting: Option<usize>,
    pub events: Events,
}

/// What is this near to the border of a condition counts as on it.
const ON_BORDER: f64 = 1e-11;

/// Flights shorter than this are those of something at rest.
const SHORTEST: f64 = 1e-7;

impl Sim {
    pub fn new(hybrid: Hybrid, x: &[f64], p: &[f64], u: &[f64]) -> Sim {
        Sim {
            hybrid,
            x: x.to_vec(),
            p: p.to_vec(),
            u: u.to_vec(),
            resting: None,
            events: Events::default(),
        }
    }

    /// How far the condition of `jump` is from holding: it holds strictly below zero.
    fn distance(&self, jump: usize, x: &[f64]) -> f64 {
        let when = self.hybrid.jumps[jump].when.iter();
        let all = |list: &&[Scalar]| {
            let each = list.iter().map(|g| g(x, &self.p, &self.u));
            each.fold(f64::NEG_INFINITY, f64::max)
        };
        when.map(all).fold(f64::INFINITY, f64::min)
    }

    fn inside(&self, x: &[f64], depth: f64) -> Option<usize> {
        (0..self.hybrid.jumps.len()).find(|jump| self.distance(*jump, x) < -depth)
    }

    /// The velocity now; of something at rest, as it goes on.
    pub fn velocity(&self, x: &[f64]) -> Vec<f64> {
        let mut v = vec![0.0; self.hybrid.states];
        let mut x = x.to_vec();
        if let Some(jump) = self.resting {
            self.apply(jump, &mut x);
        }
        (self.hybrid.f)(&x, &self.p, &self.u, &mut v);
        if let Some(jump) = self.resting {
            for state in self.hybrid.jumps[jump].sets {
                v[*state] = 0.0;
            }
        }
        v
    }

    fn apply(&self, jump: usize, x: &mut [f64]) {
        let before = x.to_vec();
        (self.hybrid.jumps[jump].set)(&before, &self.p, &self.u, x);
    }

    fn flow(&self, x: &[f64], d: f64) -> Vec<f64> {
        let shifted =
            |k: &[f64], d: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + d * k).collect() };
        let a = self.velocity(x);
        let b = self.velocity(&shifted(&a, 0.5 * d));
        let c = self.velocity(&shifted(&b, 0.5 * d));
        let e = self.velocity(&shifted(&c, d));
        let mut end: Vec<f64> = (0..x.len())
            .map(|i| x[i] + d / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + e[i]))
            .collect();
        if let Some(jump) = self.resting {
            self.apply(jump, &mut end);
        }
        end
    }

    /// Jumps that happen at once, as after the input changed.
    pub fn jump_at_once(&mut self) {
        for _ in 0..20 {
            let Some(jump) = self.inside(&self.x, ON_BORDER) else {
                return;
            };
            let mut after = self.x.clone();
            self.apply(jump, &mut after);
            self.x = after;
            self.events.jumps += 1;
        }
    }

    /// Goes on for `time`.
    pub fn advance(&mut self, mut time: f64, rng: &mut Rng) {
        let mut jumps_at_once = 0;
        let mut rounds = 0;
        while time > 1e-15 {
            rounds += 1;
            assert!(
                rounds < 100_000,
                "no end at {:?}, {:?}",
                self.x,
                self.resting
            );
            if let Some(jump) = self.resting {
                self.resting = None;
                let free = self.flow(&self.x, SHORTEST);
                if self.inside(&free, 0.0) == Some(jump) {
                    self.resting = Some(jump);
                }
            }
            if self.resting.is_none() {
                // What flows leave at once, and what holds already.
                let ahead = self.flow(&self.x, SHORTEST.min(time));
                let must = self.inside(&self.x, ON_BORDER).or_else(|| {
                    let soon = self.inside(&ahead, 0.0)?;
                    (self.distance(soon, &self.x) <= ON_BORDER).then_some(soon)
                });
                let may = (0..self.hybrid.jumps.len())
                    .find(|jump| self.distance(*jump, &self.x).abs() <= ON_BORDER);
                let chosen = must.or_else(|| {
                    let jump = may.filter(|_| jumps_at_once == 0 && rng.chance(0.5))?;
                    self.events.choices += 1;
                    Some(jump)
                });
                if let Some(jump) = chosen {
                    let before = self.x.clone();
                    let mut after = before.clone();
                    self.apply(jump, &mut after);
                    self.x.clone_from(&after);
                    self.events.jumps += 1;
                    jumps_at_once += 1;
                    let moved = before.iter().zip(&after).any(|(a, b)| (a - b).abs() > 1e-7);
                    if !moved && must.is_some() {
                        self.resting = Some(jump);
                        self.events.rests += 1;
                    } else {
                        assert!(jumps_at_once < 20, "jumps forever at {:?}", self.x);
                        continue;
                    }
                }
            }
            jumps_at_once = 0;
            let step = time.min(self.hybrid.longest);
            let enters = |time: f64| {
                let x = self.flow(&self.x, time);
                let mut others =
                    (0..self.hybrid.jumps.len()).filter(|jump| self.resting != Some(*jump));
                others.any(|jump| self.distance(jump, &x) < 0.0)
            };
            // Also what is in and out again before the end.
            let looks = [0.02, 0.1, 0.25, 0.4, 0.5, 0.6, 0.75, 0.9, 1.0];
            let entered = looks.into_iter().find(|part| enters(part * step));
            let Some(part) = entered else {
                self.x = self.flow(&self.x, step);
                time -= step;
                continue;
            };
            let (mut before, mut after) = (0.0, part * step);
            for _ in 0..60 {
                let middle = 0.5 * (before + after);
                if enters(middle) {
                    after = middle;
                } else {
                    before = middle;
                }
            }
            // Just inside, where it has to jump.
            self.x = self.flow(&self.x, after);
            time -= after;
            if let Some(jump) = self.inside(&self.x, 0.0) {
                let mut after = self.x.clone();
                self.apply(jump, &mut after);
                self.x = after;
                self.events.jumps += 1;
            }
        }
    }
}

impl Events {
    pub fn add(&mut self, other: Events) {
        self.jumps += other.jumps;
        self.rests += other.rests;
        self.choices += other.choices;
    }
}
