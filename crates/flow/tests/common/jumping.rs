//! Models that jump, each with its truth.

use veribound_interval::Interval;

use super::hybrid::{Hybrid, Jump};
use super::{Rng, interval};

/// A model to attack.
#[derive(Clone, Copy)]
pub struct Jumping {
    pub name: &'static str,
    pub text: &'static str,
    pub hybrid: Hybrid,
    /// Where states start, and what parameters and inputs are taken from.
    pub start: &'static [(f64, f64)],
    pub params: &'static [(f64, f64)],
    pub inputs: &'static [(f64, f64)],
    /// Lengths of steps.
    pub steps: &'static [f64],
    /// Widest start.
    pub widest: f64,
}

impl Jumping {
    /// Boxes of start values and of parameters, at most `width` wide.
    pub fn draw(&self, rng: &mut Rng, width: f64) -> (Vec<Interval>, Vec<Interval>) {
        let mut some = |range: &(f64, f64), share: f64| {
            let lo = rng.inside(interval(range.0, range.1));
            interval(lo, (lo + share * width * rng.unit()).min(range.1))
        };
        let start = self.start.iter().map(|range| some(range, 1.0)).collect();
        (
            start,
            self.params.iter().map(|range| some(range, 0.3)).collect(),
        )
    }
}

const fn hybrid(states: usize, f: super::hybrid::Field, jumps: &'static [Jump]) -> Hybrid {
    Hybrid {
        states,
        f,
        jumps,
        longest: 2e-3,
    }
}

/// A ball above a plate that moves: it comes to rest on it and moves on with it.
const PLATE: Jumping = Jumping {
    name: "plate",
    text: r#"
        format = 1
        states = ["h", "v", "s"]
        init = { h = 1, v = 0, s = 0 }
        params = { e = [0, 1], w = [-1, 1], g = [1, 10] }
        outputs = { y = "h +- 1" }
        der = { h = "v", v = "-g", s = "w" }
        jumps.bounce = { when = "h <= s and v < w", set = { v = "w - e*(v - w)" } }
    "#,
    hybrid: hybrid(
        3,
        |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[2];
            d[2] = p[1];
        },
        &[Jump {
            when: &[&[|x, _, _| x[0] - x[2], |x, p, _| x[1] - p[1]]],
            sets: &[1],
            set: |x, p, _, y| y[1] = p[1] - p[0] * (x[1] - p[1]),
        }],
    ),
    start: &[(0.0, 0.3), (-1.0, 1.0), (-0.1, 0.0)],
    params: &[(0.0, 0.6), (-0.5, 0.5), (3.0, 8.0)],
    inputs: &[],
    steps: &[0.01, 0.05],
    widest: 0.1,
};

/// A mass between stops, and something else that goes on all the time.
const STOPS: Jumping = Jumping {
    name: "stops",
    text: r#"
        format = 1
        states = ["x", "v", "y"]
        inputs = ["F"]
        init = { x = 0, v = 0, y = 0 }
        outputs = { y_m = "x +- 1" }
        der = { x = "v", v = "F - v", y = "1 - 0.5*y + x" }
        [jumps]
        lower = { when = "x <= 0 and v < 0", set = { v = "0" } }
        upper = { when = "x >= 1 and v > 0", set = { v = "0" } }
    "#,
    hybrid: hybrid(
        3,
        |x, _, u, d| {
            d[0] = x[1];
            d[1] = u[0] - x[1];
            d[2] = 1.0 - 0.5 * x[2] + x[0];
        },
        &[
            Jump {
                when: &[&[|x, _, _| x[0], |x, _, _| x[1]]],
                sets: &[1],
                set: |_, _, _, y| y[1] = 0.0,
            },
            Jump {
                when: &[&[|x, _, _| 1.0 - x[0], |x, _, _| -x[1]]],
                sets: &[1],
                set: |_, _, _, y| y[1] = 0.0,
            },
        ],
    ),
    start: &[(0.0, 1.0), (-1.0, 1.0), (-1.0, 1.0)],
    params: &[],
    inputs: &[(-8.0, 8.0)],
    steps: &[0.02, 0.05],
    widest: 0.1,
};

/// A memory decides the acceleration.
const RELAY: Jumping = Jumping {
    name: "relay",
    text: r#"
        format = 1
        states = ["x", "v", "m"]
        init = { x = 0, v = 0, m = 0 }
        params = { c = [0, 1], a = [1, 5] }
        outputs = { y = "x +- 1" }
        der = { x = "v", v = "a - 2*a*m", m = "0" }
        [jumps]
        on  = { when = "x > c and m < 0.5",  set = { m = "1" } }
        off = { when = "x < -c and m > 0.5", set = { m = "0" } }
    "#,
    hybrid: hybrid(
        3,
        |x, p, _, d| {
            d[0] = x[1];
            d[1] = p[1] - 2.0 * p[1] * x[2];
            d[2] = 0.0;
        },
        &[
            Jump {
                when: &[&[|x, p, _| p[0] - x[0], |x, _, _| x[2] - 0.5]],
                sets: &[2],
                set: |_, _, _, y| y[2] = 1.0,
            },
            Jump {
                when: &[&[|x, p, _| x[0] + p[0], |x, _, _| 0.5 - x[2]]],
                sets: &[2],
                set: |_, _, _, y| y[2] = 0.0,
            },
        ],
    ),
    start: &[(-0.5, 0.5), (-1.0, 1.0), (0.0, 0.0)],
    params: &[(0.1, 0.3), (1.0, 4.0)],
    inputs: &[],
    steps: &[0.02, 0.1],
    widest: 0.3,
};

/// Two masses that are pushed together and collide.
const COLLISION: Jumping = Jumping {
    name: "collision",
    text: r#"
        format = 1
        states = ["x", "v", "y", "w"]
        init = { x = 0, v = 0, y = 1, w = 0 }
        params = { e = [0, 1], k = [0, 9] }
        outputs = { y_m = "x +- 1" }
        der = { x = "v", v = "-k*x", y = "w", w = "-k*y" }
        [jumps.hit]
        when = "x >= y and v > w"
        set  = { v = "0.5*(v + w) - 0.5*e*(v - w)", w = "0.5*(v + w) + 0.5*e*(v - w)" }
    "#,
    hybrid: hybrid(
        4,
        |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[1] * x[0];
            d[2] = x[3];
            d[3] = -p[1] * x[2];
        },
        &[Jump {
            when: &[&[|x, _, _| x[2] - x[0], |x, _, _| x[3] - x[1]]],
            sets: &[1, 3],
            set: |x, p, _, y| {
                let (mean, half) = (0.5 * (x[1] + x[3]), 0.5 * p[0] * (x[1] - x[3]));
                y[1] = mean - half;
                y[3] = mean + half;
            },
        }],
    ),
    start: &[(-0.3, 0.0), (0.0, 1.0), (0.0, 0.3), (-1.0, 0.0)],
    params: &[(0.0, 0.8), (1.0, 5.0)],
    inputs: &[],
    steps: &[0.02, 0.05],
    widest: 0.05,
};

/// One condition or the other.
const EITHER: Jumping = Jumping {
    name: "either",
    text: r#"
        format = 1
        states = ["x", "y", "z"]
        init = { x = 0, y = 0, z = 0 }
        params = { a = [0, 2], b = [0, 2] }
        outputs = { y_m = "x +- 1" }
        der = { x = "a", y = "b - 0.3*y", z = "x - z" }
        [jumps.both]
        when = "x > 1 or (y > 0.5 and z > 0)"
        set  = { x = "0.3*x - 0.2", y = "y - 0.7", z = "z + 0.1*y" }
    "#,
    hybrid: hybrid(
        3,
        |x, p, _, d| {
            d[0] = p[0];
            d[1] = p[1] - 0.3 * x[1];
            d[2] = x[0] - x[2];
        },
        &[Jump {
            when: &[
                &[|x, _, _| 1.0 - x[0]],
                &[|x, _, _| 0.5 - x[1], |x, _, _| -x[2]],
            ],
            sets: &[0, 1, 2],
            set: |x, _, _, y| {
                y[0] = 0.3 * x[0] - 0.2;
                y[1] = x[1] - 0.7;
                y[2] = x[2] + 0.1 * x[1];
            },
        }],
    ),
    start: &[(-0.2, 1.2), (-0.2, 0.6), (-0.5, 0.5)],
    params: &[(0.2, 1.5), (0.2, 1.5)],
    inputs: &[],
    steps: &[0.05, 0.2],
    widest: 0.2,
};

/// One jump leads to the condition of the next.
const CASCADE: Jumping = Jumping {
    name: "cascade",
    text: r#"
        format = 1
        states = ["x", "m"]
        inputs = ["u"]
        init = { x = 0, m = 0 }
        outputs = { y_m = "x +- 1" }
        der = { x = "u", m = "0" }
        [jumps]
        first  = { when = "x > 1 and m < 0.5", set = { m = "1" } }
        second = { when = "m > 0.5 and m < 1.5", set = { m = "2", x = "x - 2" } }
        third  = { when = "x > 0 and m > 1.5", set = { m = "0", x = "0.5*x" } }
    "#,
    hybrid: hybrid(
        2,
        |_, _, u, d| {
            d[0] = u[0];
            d[1] = 0.0;
        },
        &[
            Jump {
                when: &[&[|x, _, _| 1.0 - x[0], |x, _, _| x[1] - 0.5]],
                sets: &[1],
                set: |_, _, _, y| y[1] = 1.0,
            },
            Jump {
                when: &[&[|x, _, _| 0.5 - x[1], |x, _, _| x[1] - 1.5]],
                sets: &[1, 0],
                set: |x, _, _, y| {
                    y[1] = 2.0;
                    y[0] = x[0] - 2.0;
                },
            },
            Jump {
                when: &[&[|x, _, _| -x[0], |x, _, _| 1.5 - x[1]]],
                sets: &[1, 0],
                set: |x, _, _, y| {
                    y[1] = 0.0;
                    y[0] = 0.5 * x[0];
                },
            },
        ],
    ),
    start: &[(-1.0, 1.5), (0.0, 0.0)],
    params: &[],
    inputs: &[(0.5, 4.0)],
    steps: &[0.05, 0.25],
    widest: 0.3,
};

/// What fires at an uncertain threshold.
const NEURON: Jumping = Jumping {
    name: "neuron",
    text: r#"
        format = 1
        states = ["v", "w"]
        inputs = ["I"]
        init = { v = 0, w = 0 }
        params = { c = [0.5, 2], d = [0, 1] }
        outputs = { y_m = "v +- 1" }
        der = { v = "I - v - w", w = "0.5*(v - w)" }
        jumps.fire = { when = "v > c", set = { v = "0.1*v", w = "w + d" } }
    "#,
    hybrid: hybrid(
        2,
        |x, _, u, d| {
            d[0] = u[0] - x[0] - x[1];
            d[1] = 0.5 * (x[0] - x[1]);
        },
        &[Jump {
            when: &[&[|x, p, _| p[0] - x[0]]],
            sets: &[0, 1],
            set: |x, p, _, y| {
                y[0] = 0.1 * x[0];
                y[1] = x[1] + p[1];
            },
        }],
    ),
    start: &[(0.0, 1.3), (0.0, 0.5)],
    params: &[(0.8, 1.2), (0.0, 0.3)],
    inputs: &[(-1.0, 8.0)],
    steps: &[0.05, 0.2],
    widest: 0.2,
};

/// A ball in a round room.
const BILLIARD: Jumping = Jumping {
    name: "billiard",
    text: r#"
        format = 1
        states = ["x", "y", "v", "w"]
        init = { x = 0, y = 0, v = 1, w = 0 }
        params = { e = [0, 1], g = [0, 10] }
        outputs = { y_m = "x +- 1" }
        [der]
        x = "v"
        y = "w"
        v = "0"
        w = "-g"
        [let]
        out = "(x*v + y*w)/(x*x + y*y + 0.1)"
        [jumps.wall]
        when = "x*x + y*y >= 1 and x*v + y*w > 0"
        set  = { v = "v - (1 + e)*1.1*out*x", w = "w - (1 + e)*1.1*out*y" }
    "#,
    hybrid: hybrid(
        4,
        |x, p, _, d| {
            d[0] = x[2];
            d[1] = x[3];
            d[2] = 0.0;
            d[3] = -p[1];
        },
        &[Jump {
            when: &[&[
                |x, _, _| 1.0 - x[0] * x[0] - x[1] * x[1],
                |x, _, _| -x[0] * x[2] - x[1] * x[3],
            ]],
            sets: &[2, 3],
            set: |x, p, _, y| {
                let out = (x[0] * x[2] + x[1] * x[3]) / (x[0] * x[0] + x[1] * x[1] + 0.1);
                y[2] = x[2] - (1.0 + p[0]) * 1.1 * out * x[0];
                y[3] = x[3] - (1.0 + p[0]) * 1.1 * out * x[1];
            },
        }],
    ),
    start: &[(-0.6, 0.6), (-0.6, 0.6), (-2.0, 2.0), (-2.0, 2.0)],
    params: &[(0.5, 1.0), (0.0, 5.0)],
    inputs: &[],
    steps: &[0.01, 0.02],
    widest: 0.02,
};

/// Inputs that jump decide, at once.
const SWITCHED: Jumping = Jumping {
    name: "switched",
    text: r#"
        format = 1
        states = ["x", "m"]
        inputs = ["u"]
        init = { x = 0, m = 0 }
        params = { c = [0, 2] }
        outputs = { y_m = "x +- 1" }
        der = { x = "m - x", m = "0" }
        [jumps]
        on  = { when = "u + x > c and m < 0.5",  set = { m = "1 + 0.1*u" } }
        off = { when = "u + x < -c and m > 0.5", set = { m = "0" } }
    "#,
    hybrid: hybrid(
        2,
        |x, _, _, d| {
            d[0] = x[1] - x[0];
            d[1] = 0.0;
        },
        &[
            Jump {
                when: &[&[|x, p, u| p[0] - u[0] - x[0], |x, _, _| x[1] - 0.5]],
                sets: &[1],
                set: |_, _, u, y| y[1] = 1.0 + 0.1 * u[0],
            },
            Jump {
                when: &[&[|x, p, u| u[0] + x[0] + p[0], |x, _, _| 0.5 - x[1]]],
                sets: &[1],
                set: |_, _, _, y| y[1] = 0.0,
            },
        ],
    ),
    start: &[(-0.5, 0.5), (0.0, 0.0)],
    params: &[(0.8, 1.5)],
    inputs: &[(-2.0, 2.0)],
    steps: &[0.05, 0.2],
    widest: 0.2,
};

/// A clock jumps exactly at samples.
const CLOCK: Jumping = Jumping {
    name: "clock",
    text: r#"
        format = 1
        states = ["s", "x", "n"]
        init = { s = 0, x = 0, n = 0 }
        params = { a = [0, 1] }
        outputs = { y_m = "x +- 1" }
        der = { s = "1", x = "a*n - x", n = "0" }
        jumps.tick = { when = "s >= 0.5", set = { s = "s - 0.5", n = "1 - n" } }
    "#,
    hybrid: hybrid(
        3,
        |x, p, _, d| {
            d[0] = 1.0;
            d[1] = p[0] * x[2] - x[1];
            d[2] = 0.0;
        },
        &[Jump {
            when: &[&[|x, _, _| 0.5 - x[0]]],
            sets: &[0, 2],
            set: |x, _, _, y| {
                y[0] = x[0] - 0.5;
                y[2] = 1.0 - x[2];
            },
        }],
    ),
    start: &[(0.0, 0.0), (0.0, 0.5), (0.0, 0.0)],
    params: &[(0.5, 1.0)],
    inputs: &[],
    steps: &[0.125, 0.25, 0.1],
    widest: 0.1,
};

/// Whole numbers decide.
const STAIRS: Jumping = Jumping {
    name: "stairs",
    text: r#"
        format = 1
        states = ["x", "v", "n"]
        init = { x = 0, v = 1, n = 0 }
        params = { a = [0, 3] }
        outputs = { y_m = "x +- 1" }
        der = { x = "v", v = "-a*x", n = "0" }
        jumps.step = { when = "floor(x) > n + 0.5 and v > 0", set = { n = "n + 1", v = "0.9*v" } }
    "#,
    hybrid: hybrid(
        3,
        |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[0] * x[0];
            d[2] = 0.0;
        },
        &[Jump {
            when: &[&[|x, _, _| x[2] + 0.5 - x[0].floor(), |x, _, _| -x[1]]],
            sets: &[1, 2],
            set: |x, _, _, y| {
                y[1] = 0.9 * x[1];
                y[2] = x[2] + 1.0;
            },
        }],
    ),
    start: &[(-0.5, 0.9), (-1.0, 4.0), (0.0, 0.0)],
    params: &[(0.2, 1.0)],
    inputs: &[],
    steps: &[0.05, 0.1],
    widest: 0.1,
};

/// A latch that is touched with no speed, more or less.
const LATCH: Jumping = Jumping {
    name: "latch",
    text: r#"
        format = 1
        states = ["x", "v", "m", "y"]
        init = { x = 0, v = 0, m = 0, y = 0 }
        params = { a = [0, 8] }
        outputs = { y_m = "x +- 1" }
        der = { x = "v", v = "a", m = "0", y = "m - y" }
        jumps.touch = { when = "x < 0 and m < 0.5", set = { m = "1" } }
    "#,
    hybrid: hybrid(
        4,
        |x, p, _, d| {
            d[0] = x[1];
            d[1] = p[0];
            d[2] = 0.0;
            d[3] = x[2] - x[3];
        },
        &[Jump {
            when: &[&[|x, _, _| x[0], |x, _, _| x[2] - 0.5]],
            sets: &[2],
            set: |_, _, _, y| y[2] = 1.0,
        }],
    ),
    start: &[(0.125, 0.125), (-1.001, -0.999), (0.0, 0.0), (0.0, 0.0)],
    params: &[(3.99, 4.01)],
    inputs: &[],
    steps: &[0.05, 0.125],
    widest: 0.01,
};

/// A kick by an input changes a velocity at once.
const KICK: Jumping = Jumping {
    name: "kick",
    text: r#"
        format = 1
        states = ["x", "v", "m"]
        inputs = ["u"]
        init = { x = 0, v = 0, m = 0 }
        params = { b = [0, 9] }
        outputs = { y_m = "x +- 1" }
        der = { x = "v", v = "-x", m = "0" }
        [jumps]
        kick = { when = "u > 1 and m < 0.5", set = { v = "v + b", m = "1" } }
        rest = { when = "u < 0 and m > 0.5", set = { v = "0", m = "0" } }
    "#,
    hybrid: hybrid(
        3,
        |x, _, _, d| {
            d[0] = x[1];
            d[1] = -x[0];
            d[2] = 0.0;
        },
        &[
            Jump {
                when: &[&[|_, _, u| 1.0 - u[0], |x, _, _| x[2] - 0.5]],
                sets: &[1, 2],
                set: |x, p, _, y| {
                    y[1] = x[1] + p[0];
                    y[2] = 1.0;
                },
            },
            Jump {
                when: &[&[|_, _, u| u[0], |x, _, _| 0.5 - x[2]]],
                sets: &[1, 2],
                set: |_, _, _, y| {
                    y[1] = 0.0;
                    y[2] = 0.0;
                },
            },
        ],
    ),
    start: &[(-0.5, 0.5), (-1.0, 1.0), (0.0, 0.0)],
    params: &[(3.0, 6.0)],
    inputs: &[(-2.0, 3.0)],
    steps: &[0.05, 0.1],
    widest: 0.2,
};

pub const ALL: &[Jumping] = &[
    KICK, PLATE, STOPS, RELAY, COLLISION, EITHER, CASCADE, NEURON, BILLIARD, SWITCHED, CLOCK,
    STAIRS, LATCH,
];
