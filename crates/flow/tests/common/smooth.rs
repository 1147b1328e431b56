//! Smooth models with their right-hand sides in plain floating point, and an integrator for those.

use super::{Rng, interval};
use veribound_interval::Interval;

pub type Rate = fn(&[f64], &[f64], &[f64], &mut [f64]);

/// A smooth model, boxes to draw from, and a time that it is well-behaved for.
pub struct Smooth {
    pub name: &'static str,
    pub text: &'static str,
    pub rate: Rate,
    pub states: &'static [(f64, f64)],
    pub params: &'static [(f64, f64)],
    pub inputs: &'static [(f64, f64)],
    pub time: f64,
}

pub const SMOOTH: &[Smooth] = &[
    Smooth {
        name: "Lotka-Volterra",
        text: "format = 1\nstates = [\"x\", \"y\"]\n[init]\nx = 1\ny = 1\n[params]\na = [2, 4]\nb = [0.5, 1.5]\n\
               [der]\nx = \"a*x*(1 - y)\"\ny = \"b*y*(x - 1)\"\n[outputs]\nm = \"x +- 1\"\n",
        rate: |x, p, _, d| {
            d[0] = p[0] * x[0] * (1.0 - x[1]);
            d[1] = p[1] * x[1] * (x[0] - 1.0);
        },
        states: &[(0.8, 1.3), (0.8, 1.3)],
        params: &[(2.0, 4.0), (0.5, 1.5)],
        inputs: &[],
        time: 3.0,
    },
    Smooth {
        name: "pendulum with a drive",
        text: "format = 1\nstates = [\"q\", \"w\"]\ninputs = [\"u\"]\n[init]\nq = 1\nw = 1\n[params]\nk = [5, 20]\nd = [0, 1]\n\
               [der]\nq = \"w\"\nw = \"u - k*sin(q) - d*w\"\n[outputs]\nm = \"q +- 1\"\n",
        rate: |x, p, u, d| {
            d[0] = x[1];
            d[1] = u[0] - p[0] * x[0].sin() - p[1] * x[1];
        },
        states: &[(-2.0, 2.0), (-2.0, 2.0)],
        params: &[(5.0, 20.0), (0.0, 1.0)],
        inputs: &[(-2.0, 2.0)],
        time: 1.5,
    },
    Smooth {
        name: "Michaelis and Menten",
        text: "format = 1\nstates = [\"s\"]\n[init]\ns = 1\n[params]\nv = [0.5, 2]\nk = [0.5, 5]\n\
               [der]\ns = \"-v*s/(k + s)\"\n[outputs]\nm = \"s +- 1\"\n",
        rate: |x, p, _, d| d[0] = -p[0] * x[0] / (p[1] + x[0]),
        states: &[(1.0, 10.0)],
        params: &[(0.5, 2.0), (0.5, 5.0)],
        inputs: &[],
        time: 8.0,
    },
    Smooth {
        name: "tanks",
        text: "format = 1\nstates = [\"h1\", \"h2\"]\ninputs = [\"q\"]\n[init]\nh1 = 1\nh2 = 1\n[params]\nc = [0.3, 0.5]\n\
               [der]\nh1 = \"q - c*sqrt(h1)\"\nh2 = \"c*sqrt(h1) - 0.3*sqrt(h2)\"\n[outputs]\nm = \"h2 +- 1\"\n",
        rate: |x, p, u, d| {
            d[0] = u[0] - p[0] * x[0].sqrt();
            d[1] = p[0] * x[0].sqrt() - 0.3 * x[1].sqrt();
        },
        states: &[(0.5, 1.0), (0.5, 1.0)],
        params: &[(0.3, 0.5)],
        inputs: &[(0.2, 0.4)],
        time: 3.0,
    },
    Smooth {
        name: "functions",
        text: "format = 1\nstates = [\"x\", \"y\", \"z\"]\n[init]\nx = 1\ny = 1\nz = 0\n[params]\np = [0.5, 1]\n\
               [der]\nx = \"cos(y) - p*atan(x) + tanh(z)\"\ny = \"exp(-y)*log(2 + x^2) - tan(0.3*y)\"\n\
               z = \"asin(0.2*z)*x - z/cosh(x) + p^-2*sinh(0.1*y)\"\n[outputs]\nm = \"x +- 1\"\n",
        rate: |x, p, _, d| {
            d[0] = x[1].cos() - p[0] * x[0].atan() + x[2].tanh();
            d[1] = (-x[1]).exp() * (2.0 + x[0] * x[0]).ln() - (0.3 * x[1]).tan();
            d[2] = (0.2 * x[2]).asin() * x[0] - x[2] / x[0].cosh()
                + p[0].powi(-2) * (0.1 * x[1]).sinh();
        },
        states: &[(0.0, 1.5), (0.2, 1.5), (-0.5, 0.5)],
        params: &[(0.5, 1.0)],
        inputs: &[],
        time: 2.0,
    },
    Smooth {
        name: "van der Pol",
        text: "format = 1\nstates = [\"x\", \"y\"]\n[init]\nx = 1\ny = 1\n[der]\nx = \"y\"\ny = \"(1 - x^2)*y - x\"\n\
               [outputs]\nm = \"x +- 1\"\n",
        rate: |x, _, _, d| {
            d[0] = x[1];
            d[1] = (1.0 - x[0] * x[0]) * x[1] - x[0];
        },
        states: &[(1.0, 1.5), (2.0, 2.4)],
        params: &[],
        inputs: &[],
        time: 3.0,
    },
    Smooth {
        name: "kinks that are continuous",
        text: "format = 1\nstates = [\"x\", \"v\"]\ninputs = [\"u\"]\n[init]\nx = 1\nv = 1\n[params]\nk = [1, 3]\n\
               [der]\nx = \"v\"\nv = \"u - k*abs(x) - max(v, 0.3)\"\n[outputs]\nm = \"x +- 1\"\n",
        rate: |x, p, u, d| {
            d[0] = x[1];
            d[1] = u[0] - p[0] * x[0].abs() - x[1].max(0.3);
        },
        states: &[(-1.0, 1.0), (-1.0, 1.0)],
        params: &[(1.0, 3.0)],
        inputs: &[(-1.0, 1.0)],
        time: 0.6,
    },
    Smooth {
        name: "Lorenz",
        text: "format = 1\nstates = [\"x\", \"y\", \"z\"]\n[init]\nx = 1\ny = 1\nz = 1\n[params]\nr = [27, 29]\n\
               [der]\nx = \"10*(y - x)\"\ny = \"x*(r - z) - y\"\nz = \"x*y - 8/3*z\"\n[outputs]\nm = \"x +- 1\"\n",
        rate: |x, p, _, d| {
            d[0] = 10.0 * (x[1] - x[0]);
            d[1] = x[0] * (p[0] - x[2]) - x[1];
            d[2] = x[0] * x[1] - 8.0 / 3.0 * x[2];
        },
        states: &[(10.0, 15.0), (10.0, 15.0), (30.0, 36.0)],
        params: &[(27.0, 29.0)],
        inputs: &[],
        time: 0.5,
    },
    Smooth {
        name: "angles, roots, powers, and steps that are not met",
        text: "format = 1\nstates = [\"x\", \"y\", \"z\"]\n[init]\nx = 1\ny = 1\nz = 0\n[params]\na = [0.5, 2]\n\
               [der]\nx = \"-y*a\"\ny = \"x*a\"\nz = \"atan2(y, x)*(1 + x^2)^a - cbrt(x + 3)*(z + 3)^1.5 + floor(x/9 + 0.5)\"\n\
               [outputs]\nm = \"x +- 1\"\n",
        rate: |x, p, _, d| {
            d[0] = -x[1] * p[0];
            d[1] = x[0] * p[0];
            let drive = x[1].atan2(x[0]) * (1.0 + x[0] * x[0]).powf(p[0]);
            d[2] =
                drive - (x[0] + 3.0).cbrt() * (x[2] + 3.0).powf(1.5) + (x[0] / 9.0 + 0.5).floor();
        },
        states: &[(0.3, 0.8), (0.6, 1.2), (-0.2, 0.2)],
        params: &[(0.5, 1.5)],
        inputs: &[],
        time: 0.3,
    },
];

/// Moves `x` by `time` with Gragg's method, extrapolated; errors are near rounding for smooth rates.
pub fn travel(rate: Rate, x: &mut [f64], p: &[f64], u: &[f64], time: f64, longest: f64) {
    let n = x.len();
    let steps = (time / longest).ceil().max(1.0);
    let h = time / steps;
    for _ in 0..steps as u32 {
        // One more column of the table at each level.
        let mut above: Vec<Vec<f64>> = Vec::new();
        for level in 1..=7_u32 {
            let mut line = vec![midpoints(rate, x, p, u, h, 2 * level)];
            for (m, other) in above.iter().enumerate() {
                let finer = f64::from(level) / f64::from(level - 1 - m as u32);
                let share = finer * finer - 1.0;
                let last = &line[m];
                line.push(
                    (0..n)
                        .map(|i| last[i] + (last[i] - other[i]) / share)
                        .collect(),
                );
            }
            above = line;
        }
        x.copy_from_slice(&above[6]);
    }
}

/// Gragg's modified midpoint rule with `parts` parts.
fn midpoints(rate: Rate, x: &[f64], p: &[f64], u: &[f64], h: f64, parts: u32) -> Vec<f64> {
    let d = h / f64::from(parts);
    let slope = |x: &[f64]| {
        let mut slope = vec![0.0; x.len()];
        rate(x, p, u, &mut slope);
        slope
    };
    let move_by = |x: &[f64], d: f64, slope: &[f64]| -> Vec<f64> {
        x.iter().zip(slope).map(|(x, s)| x + d * s).collect()
    };
    let mut before = x.to_vec();
    let mut now = move_by(x, d, &slope(x));
    for _ in 1..parts {
        let next = move_by(&before, 2.0 * d, &slope(&now));
        before = std::mem::replace(&mut now, next);
    }
    let after = move_by(&before, d, &slope(&now));
    now.iter().zip(&after).map(|(a, b)| 0.5 * (a + b)).collect()
}

/// A part of `[lo, hi]`: a point, thin or wide.
pub fn part(rng: &mut Rng, (lo, hi): (f64, f64), widest: f64) -> Interval {
    let width = match rng.below(4) {
        0 => 0.0,
        1 => 1e-6,
        2 => 0.01 * (hi - lo),
        _ => rng.unit() * widest * (hi - lo),
    };
    let from = rng.between(lo, hi - width);
    interval(from, (from + width).min(hi))
}
