//! Exact solutions of what jumps in the examples: a stem with stiction between two stops, and a ball.

/// A valve whose stem has a spring of 100 and room for 0.05.
pub const VALVE: &str = "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"p\"]\n[init]\nx = 0\nv = 0\n[params]\nc = [30, 90]\nFc = [0, 3]\n\
    [let]\ndrive = \"p - 100*x - c*v\"\n[der]\nx = \"v\"\nv = \"drive - friction(v, drive, Fc)\"\n[jumps]\n\
    closed = { when = \"x <= 0 and v < 0\", set = { v = \"0\" } }\nopen = { when = \"x >= 0.05 and v > 0\", set = { v = \"0\" } }\n\
    [outputs]\nstem = \"x +- 0.0003\"\n";

/// Parameters of a stem: `x'' = p - k x - c x' - Fc Sgn(x')`, held by stops at both ends of `room`.
///
/// Roots of the characteristic equation have to be real: `c^2 > 4 k`.
#[derive(Debug, Clone, Copy)]
pub struct Stem {
    pub k: f64,
    pub c: f64,
    pub friction: f64,
    pub room: [f64; 2],
}

/// What a stem does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    LeftStop,
    SlidingRight,
    Stopped,
    SlidingLeft,
    RightStop,
}

/// Speeds below this are rest: rounding of the closed form.
const REST: f64 = 1e-15;

impl Stem {
    /// What it does at a place and a speed under a pressure.
    pub fn way(&self, x: f64, v: f64, p: f64) -> Way {
        let [left, right] = self.room;
        let pull = p - self.k * x;
        if v > REST || (v.abs() <= REST && pull > self.friction && x < right) {
            Way::SlidingRight
        } else if v < -REST || (v.abs() <= REST && pull < -self.friction && x > left) {
            Way::SlidingLeft
        } else if x <= left {
            Way::LeftStop
        } else if x >= right {
            Way::RightStop
        } else {
            Way::Stopped
        }
    }

    /// Moves on by `h` at a constant pressure; `met` is told of each way that it goes.
    pub fn advance(&self, state: &mut [f64; 2], p: f64, h: f64, met: &mut dyn FnMut(Way)) {
        let mut rest = h;
        while rest > 0.0 {
            let [x, v] = *state;
            let way = self.way(x, v, p);
            met(way);
            let sign = match way {
                Way::SlidingRight => 1.0,
                Way::SlidingLeft => -1.0,
                _ => {
                    state[1] = 0.0;
                    return;
                }
            };
            let end = self.room[usize::from(sign > 0.0)];
            // `x = rest + slow e^(r t) + fast e^(s t)`
            let middle = (p - sign * self.friction) / self.k;
            let root = (0.25 * self.c * self.c - self.k).sqrt();
            let fast_rate = -0.5 * self.c - root;
            let slow_rate = self.k / fast_rate;
            let fast = (v - slow_rate * (x - middle)) / (fast_rate - slow_rate);
            let slow = x - middle - fast;
            let place =
                |t: f64| middle + slow * (slow_rate * t).exp() + fast * (fast_rate * t).exp();
            let speed = |t: f64| {
                slow * slow_rate * (slow_rate * t).exp() + fast * fast_rate * (fast_rate * t).exp()
            };
            // The speed has one zero at most.
            let share = -fast * fast_rate / (slow * slow_rate);
            let stops = (share > 1.0 + 1e-13).then(|| share.ln() / (slow_rate - fast_rate));
            let stops = stops.filter(|t| *t > 0.0 && v.abs() > REST);
            let until = rest.min(stops.unwrap_or(f64::INFINITY));
            let is_beyond = |t: f64| sign * (place(t) - end) > 0.0;
            if is_beyond(until) {
                let (mut lo, mut hi) = (0.0, until);
                for _ in 0..80 {
                    let half = 0.5 * (lo + hi);
                    if is_beyond(half) {
                        hi = half;
                    } else {
                        lo = half;
                    }
                }
                *state = [end, 0.0];
                rest -= hi;
            } else if stops.is_some_and(|t| t <= rest) {
                *state = [place(until), 0.0];
                rest -= until;
            } else {
                *state = [place(until), speed(until)];
                rest = 0.0;
            }
        }
    }
}

/// Moves a ball above the floor at zero on by `t`: gravity `g`, the share `e` of the speed after an impact.
pub fn bounce(state: &mut [f64; 2], [e, g]: [f64; 2], t: f64) {
    let mut rest = t;
    loop {
        let [h, v] = *state;
        if h <= 0.0 && v.abs() < 1e-12 {
            *state = [0.0, 0.0];
            return;
        }
        let lands = (v + (v * v + 2.0 * g * h).sqrt()) / g;
        if lands > rest {
            *state = [h + rest * (v - 0.5 * g * rest), v - g * rest];
            return;
        }
        *state = [0.0, -e * (v - g * lands)];
        rest -= lands;
    }
}
