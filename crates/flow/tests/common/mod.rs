//! What several tests share: a repeatable generator, the rig with its exact closed form, a simulator
//! for switching systems, and models to attack.
#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking; every test file uses a part of this"
)]

pub mod case;
pub mod hybrid;
pub mod jumping;
pub mod models;
pub mod monotone;
pub mod smooth;
pub mod stem;
pub mod truth;

use veribound_interval::Interval;
use veribound_model::Model;

/// A small repeatable generator (splitmix64).
#[derive(Clone)]
pub struct Rng(pub u64);

impl Rng {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, lo: f64, hi: f64) -> f64 {
        (lo + (hi - lo) * self.unit()).clamp(lo, hi)
    }

    /// One of `0..n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    /// A point of `x`, often one of its ends.
    pub fn inside(&mut self, x: Interval) -> f64 {
        match self.below(4) {
            0 => x.lo(),
            1 => x.hi(),
            _ => self.between(x.lo(), x.hi()),
        }
    }
}

pub fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

/// The model in `text`; panics with the reader's own message.
pub fn read(name: &str, text: &str) -> Model {
    Model::from_text(name, text)
        .unwrap_or_else(|problems| panic!("{name}:\n{}", problems.render(false)))
}

/// Exact flow of the rig over `h` with constant `u`: stop, stick and reversal included.
///
/// `w(t) = (w0 + c) e^(at) - c` with `c = b (u - s T)/a` for motion of sign `s`; it stops after
/// `ln(1 + w0/c) / -a` where `w0/c > 0`, and never otherwise. Needs `a < 0`.
pub fn rig_step(phi: f64, w: f64, u: f64, p: [f64; 3], h: f64) -> (f64, f64) {
    let [a, b, level] = p;
    let (mut phi, mut w, mut rest) = (phi, w, h);
    while rest > 0.0 {
        if w == 0.0 && u.abs() <= level {
            return (phi, 0.0);
        }
        let s = if w == 0.0 { u.signum() } else { w.signum() };
        let c = b * (u - s * level) / a;
        let stop = if w != 0.0 && w / c > 0.0 {
            (w / c).ln_1p() / -a
        } else {
            f64::INFINITY
        };
        let d = rest.min(stop);
        let e = (a * d).exp_m1();
        phi += (w + c) * e / a - c * d;
        w = if stop <= rest { 0.0 } else { w + (w + c) * e };
        rest -= d;
    }
    (phi, w)
}

/// How a rig's model file is written.
#[derive(Clone)]
pub struct RigText {
    /// Three modes with guards, or the friction law.
    pub explicit: bool,
    pub phi: [String; 2],
    pub omega: [String; 2],
    pub alpha: [String; 2],
    pub beta: [String; 2],
    pub level: [String; 2],
    pub input_error: &'static str,
    pub output_error: &'static str,
    /// Latency, and how long a standstill lasts before the level may be new.
    pub still: Option<(&'static str, Option<&'static str>)>,
}

impl Default for RigText {
    fn default() -> Self {
        let pair = |lo: &str, hi: &str| [lo.to_string(), hi.to_string()];
        RigText {
            explicit: true,
            phi: pair("-0.2", "0.2"),
            omega: pair("0", "0"),
            alpha: pair("-6", "-0.05"),
            beta: pair("1", "400"),
            level: pair("0", "0.3"),
            input_error: "{ relative = 0 }",
            output_error: "0.1",
            still: None,
        }
    }
}

impl RigText {
    pub fn text(&self) -> String {
        let list = |[lo, hi]: &[String; 2]| format!("[{lo}, {hi}]");
        let resets = matches!(self.still, Some((_, Some(_))));
        let reset = if resets {
            ", resets = \"standstill\""
        } else {
            ""
        };
        let mut text = format!(
            "format = 1\nname = \"rig\"\n[states]\nphi = {{ init = {} }}\nomega = {{ init = {} }}\n\
             [inputs]\nu = {{ error = {} }}\n\
             [params]\nalpha = {{ bounds = {} }}\nbeta = {{ bounds = {} }}\n\
             T_Fs = {{ bounds = {}{reset} }}\n",
            list(&self.phi),
            list(&self.omega),
            self.input_error,
            list(&self.alpha),
            list(&self.beta),
            list(&self.level),
        );
        text += if self.explicit {
            "[let]\ndrive = \"beta * u + alpha * omega\"\n[modes]\n\
             forward  = { when = \"omega > 0 or (omega == 0 and u > T_Fs)\", der = { phi = \"omega\", omega = \"drive - beta * T_Fs\" } }\n\
             stick    = { when = \"omega == 0 and abs(u) <= T_Fs\", der = { phi = \"0\", omega = \"0\" } }\n\
             backward = { when = \"omega < 0 or (omega == 0 and u < -T_Fs)\", der = { phi = \"omega\", omega = \"drive + beta * T_Fs\" } }\n"
        } else {
            "[der]\nphi = \"omega\"\nomega = \"alpha*omega + beta*(u - friction(omega, u, T_Fs))\"\n"
        };
        if let Some((latency, lasts)) = self.still {
            text += &format!(
                "[signals]\nstill = {{ from = \"column\", type = \"bool\", proves = \"omega == 0\", latency = {latency} }}\n"
            );
            if let Some(lasts) = lasts {
                text += &format!(
                    "[events.standstill]\nwhen = \"still\"\nlasts = {lasts}\naction = \"reset T_Fs\"\n"
                );
            }
        }
        text += &format!(
            "[outputs]\nphi_m = {{ expr = \"phi\", error = {} }}\n",
            self.output_error
        );
        text
    }

    pub fn model(&self) -> Model {
        read("rig", &self.text())
    }
}

/// The rig with the priors of the plots, three modes, angle measured within 0.1 rad.
pub fn rig_model() -> Model {
    RigText::default().model()
}

/// How many true solutions were looked for in what is proved of their sets.
///
/// `./nightly` adds up the lines that these print.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trials {
    /// Random points of random sets whose solutions were followed.
    pub solutions: u64,
    /// Times at which one of them was compared with bounds.
    pub checks: u64,
}

impl Trials {
    pub fn add(&mut self, other: Trials) {
        self.solutions += other.solutions;
        self.checks += other.checks;
    }

    pub fn told(self, sweep: &str) {
        let Trials { solutions, checks } = self;
        println!("trials of {sweep}: {solutions} solutions, {checks} comparisons");
    }
}

/// A number from the environment, as `VERIBOUND_SEED`, or the usual one.
pub fn number(name: &str, usual: u64) -> u64 {
    let text = std::env::var(name).unwrap_or_default();
    text.parse().unwrap_or(usual)
}
