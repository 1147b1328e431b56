//! Models to attack, each with its true right-hand side.

use super::truth::{Field, Switch, Truth};

/// A model, the ranges its quantities are drawn from, and values worth hitting exactly.
pub struct Target {
    pub name: &'static str,
    pub text: &'static str,
    pub truth: Truth,
    pub states: &'static [(f64, f64, &'static [f64])],
    pub params: &'static [(f64, f64)],
    pub inputs: &'static [(f64, f64, &'static [f64])],
}

const NO_SWITCH: &[Switch] = &[];

pub const BELT: Target = Target {
    name: "belt",
    text: r#"
format = 1
[states]
x = { init = [1, 1.05] }
v = { init = 0 }
[params]
k = [0.5, 2]
c = [0, 0.5]
mu = [0, 0.5]
[let]
pull = "-k*x - c*v"
[der]
x = "v"
v = "pull - friction(v - 0.2, pull, mu)"
[outputs]
x_m = "x +- 0.005"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[0] * x[0] - p[1] * x[1];
        },
        switches: &[Switch {
            g: |x, _, _| x[1] - 0.2,
            b: |_, p, _, d| d[1] = -p[2],
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-1.2, 1.2, &[]), (-0.5, 0.5, &[0.2, 0.0])],
    params: &[(0.5, 2.0), (0.0, 0.5), (0.0, 0.5)],
    inputs: &[],
};

pub const PENDULUM: Target = Target {
    name: "pendulum",
    text: r#"
format = 1
[states]
theta = { init = [-1, 1], domain = [-100, 100] }
omega = { init = [-1, 1], domain = [-100, 100] }
[params]
stiffness = [20, 60]
offset = [-0.2, 0.2]
damping = [0, 1]
coulomb = [0, 5]
[der]
theta = "omega"
omega = "-stiffness*sin(theta - offset) - damping*omega - coulomb*sign(omega)"
[outputs]
angle = "theta +- 0.003"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[0] * (x[0] - p[1]).sin() - p[2] * x[1];
        },
        switches: &[Switch {
            g: |x, _, _| x[1],
            b: |_, p, _, d| d[1] = -p[3],
        }],
        kinks: &[],
        longest: 1e-3,
    },
    states: &[(-1.5, 1.5, &[0.0]), (-1.0, 1.0, &[0.0])],
    params: &[(20.0, 60.0), (-0.2, 0.2), (0.0, 1.0), (0.0, 5.0)],
    inputs: &[],
};

pub const CHAIN: Target = Target {
    name: "two masses, two friction elements",
    text: r#"
format = 1
states = ["x1", "v1", "x2", "v2"]
inputs = ["F"]
[init]
x1 = 0
v1 = 0
x2 = 0
v2 = 0
[params]
k = [1, 200]
d = [0, 3]
T1 = [0, 2]
T2 = [0, 2]
[let]
spring = "k*(x1 - x2) + d*(v1 - v2)"
[der]
x1 = "v1"
v1 = "F - spring - friction(v1, F - spring, T1)"
x2 = "v2"
v2 = "(spring - friction(v2, spring, T2))/2"
[outputs]
x_m = "x2 +- 0.01"
"#,
    truth: Truth {
        states: 4,
        f: |x, p, u, d| {
            let spring = p[0] * (x[0] - x[2]) + p[1] * (x[1] - x[3]);
            d[0] = x[1];
            d[1] = u[0] - spring;
            d[2] = x[3];
            d[3] = spring / 2.0;
        },
        switches: &[
            Switch {
                g: |x, _, _| x[1],
                b: |_, p, _, d| d[1] = -p[2],
            },
            Switch {
                g: |x, _, _| x[3],
                b: |_, p, _, d| d[3] = -p[3] / 2.0,
            },
        ],
        kinks: &[],
        longest: 1e-3,
    },
    states: &[
        (-0.1, 0.1, &[0.0]),
        (-0.1, 0.1, &[0.0]),
        (-0.1, 0.1, &[0.0]),
        (-0.1, 0.1, &[0.0]),
    ],
    params: &[(1.0, 200.0), (0.0, 3.0), (0.0, 2.0), (0.0, 2.0)],
    inputs: &[(-3.0, 3.0, &[0.0, 1.0])],
};

pub const CLUTCH: Target = Target {
    name: "friction between two bodies",
    text: r#"
format = 1
states = ["v1", "v2"]
inputs = ["F"]
[init]
v1 = 0
v2 = 0
[params]
T = [0, 3]
c = [0, 2]
[let]
grip = "T*sign(v1 - v2)"
[der]
v1 = "F - grip - c*v1"
v2 = "2*grip - c*v2"
[outputs]
v_m = "v1 +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            d[0] = u[0] - p[1] * x[0];
            d[1] = -p[1] * x[1];
        },
        switches: &[Switch {
            g: |x, _, _| x[0] - x[1],
            b: |_, p, _, d| {
                d[0] = -p[0];
                d[1] = 2.0 * p[0];
            },
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.3, 0.3, &[0.0, 0.1]), (-0.3, 0.3, &[0.0, 0.1])],
    params: &[(0.0, 3.0), (0.0, 2.0)],
    inputs: &[(-4.0, 4.0, &[0.0])],
};

pub const RELAY: Target = Target {
    name: "relay on a plane",
    text: r#"
format = 1
states = ["x1", "x2"]
inputs = ["u"]
[init]
x1 = 0
x2 = 0
[params]
a = [-3, 3]
m = [-3, 3]
[der]
x1 = "x2"
x2 = "-a*x1 + u - m*sign(x1 + x2)"
[outputs]
y = "x1 +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            d[0] = x[1];
            d[1] = -p[0] * x[0] + u[0];
        },
        switches: &[Switch {
            g: |x, _, _| x[0] + x[1],
            b: |_, p, _, d| d[1] = -p[1],
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.5, 0.5, &[0.0, 0.25]), (-0.5, 0.5, &[0.0, -0.25])],
    params: &[(-3.0, 3.0), (-3.0, 3.0)],
    inputs: &[(-2.0, 2.0, &[0.0])],
};

/// While `x1` slides, `x2` and `x3` move with a convex combination of what the modes say.
pub const SLIDING: Target = Target {
    name: "sliding with other components in the hull",
    text: r#"
format = 1
states = ["x1", "x2", "x3"]
[init]
x1 = 0
x2 = 0
x3 = 0
[params]
a = [-2, 2]
b = [-3, 3]
c = [-4, 4]
[modes.above]
when = "0.3 <= x1"
der = { x1 = "a - b", x2 = "c + x3", x3 = "x2 - c*x3" }
[modes.below]
when = "0.3 - x1 > 0"
der = { x1 = "a + b", x2 = "-c + x3", x3 = "x2 + c*x3" }
[outputs]
y = "x2 +- 0.01"
"#,
    truth: Truth {
        states: 3,
        f: |x, p, _, d| {
            d[0] = p[0];
            d[1] = x[2];
            d[2] = x[1];
        },
        switches: &[Switch {
            g: |x, _, _| x[0] - 0.3,
            b: |x, p, _, d| {
                d[0] = -p[1];
                d[1] = p[2];
                d[2] = -p[2] * x[2];
            },
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[
        (0.1, 0.5, &[0.3, 0.3]),
        (-1.0, 1.0, &[0.0]),
        (-1.0, 1.0, &[0.0]),
    ],
    params: &[(-2.0, 2.0), (-3.0, 3.0), (-4.0, 4.0)],
    inputs: &[],
};

/// Two levels on the position, jumps in the force.
pub const DEAD_ZONE: Target = Target {
    name: "dead zone",
    text: r#"
format = 1
states = ["x", "v"]
[init]
x = 0
v = 0
[params]
F = [-5, 5]
d = [-1, 1]
[modes.low]
when = "-x > 0.1 or x == -0.1"
der = { x = "v", v = "F - d*v" }
[modes.mid]
when = "-0.1 <= x and 0.1 >= x"
der = { x = "v", v = "-d*v" }
[modes.high]
when = "-10*x < -1 or 0.1 == x"
der = { x = "v", v = "-F - d*v" }
[outputs]
y = "x +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[1] * x[1];
        },
        switches: &[
            Switch {
                g: |x, _, _| x[0] + 0.1,
                b: |_, p, _, d| d[1] = -p[0] / 2.0,
            },
            Switch {
                g: |x, _, _| x[0] - 0.1,
                b: |_, p, _, d| d[1] = -p[0] / 2.0,
            },
        ],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.3, 0.3, &[-0.1, 0.1]), (-2.0, 2.0, &[0.0])],
    params: &[(-5.0, 5.0), (-1.0, 1.0)],
    inputs: &[],
};

/// Three levels on one state, two of them very close; every kind of switching at each.
pub const STAIRS: Target = Target {
    name: "three levels on one state",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
[init]
x = 0
y = 0
[params]
a = [-3, 3]
b = [-3, 3]
c = [-3, 3]
[der]
x = "u + a*sign(x + 0.1) + b*sign(x - 0.1) + c*sign(10*x - 1.001)"
y = "x - b*sign(x - 0.1) - a*y"
[outputs]
y_m = "y +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            d[0] = u[0];
            d[1] = x[0] - p[0] * x[1];
        },
        switches: &[
            Switch {
                g: |x, _, _| x[0] + 0.1,
                b: |_, p, _, d| d[0] = p[0],
            },
            Switch {
                g: |x, _, _| x[0] - 0.1,
                b: |_, p, _, d| {
                    d[0] = p[1];
                    d[1] = -p[1];
                },
            },
            Switch {
                g: |x, _, _| 10.0 * x[0] - 1.001,
                b: |_, p, _, d| d[0] = p[2],
            },
        ],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.3, 0.3, &[-0.1, 0.1, 0.1001]), (-1.0, 1.0, &[])],
    params: &[(-3.0, 3.0), (-3.0, 3.0), (-3.0, 3.0)],
    inputs: &[(-4.0, 4.0, &[0.0])],
};

pub const MOVING_LEVEL: Target = Target {
    name: "level that is a parameter",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
[init]
x = 0
y = 0
[params]
m = [-2, 2]
level = [-0.2, 0.2]
[modes.over]
when = "x > level"
der = { x = "u - m", y = "1 + y" }
[modes.under]
when = "level >= x"
der = { x = "u + m", y = "-1 - x*y" }
[outputs]
y_m = "y +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, _, u, d| {
            d[0] = u[0];
            d[1] = (x[1] - x[0] * x[1]) / 2.0;
        },
        switches: &[Switch {
            g: |x, p, _| x[0] - p[1],
            b: |x, p, _, d| {
                d[0] = -p[0];
                d[1] = 1.0 + (x[1] + x[0] * x[1]) / 2.0;
            },
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.3, 0.3, &[0.0, 0.1]), (-1.0, 1.0, &[0.0])],
    params: &[(-2.0, 2.0), (-0.2, 0.2)],
    inputs: &[(-3.0, 3.0, &[0.0])],
};

/// `x' = +m Sgn(x)`: solutions may leave the origin at any time.
pub const UNSTABLE: Target = Target {
    name: "unstable switching",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
[init]
x = 0
y = 0
[params]
m = [-2, 2]
a = [-3, 3]
[der]
x = "m*sign(x) + a*x + u"
y = "x + m*sign(x)*y"
[outputs]
y_m = "y +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            d[0] = p[1] * x[0] + u[0];
            d[1] = x[0];
        },
        switches: &[Switch {
            g: |x, _, _| x[0],
            b: |x, p, _, d| {
                d[0] = p[0];
                d[1] = p[0] * x[1];
            },
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.2, 0.2, &[0.0, 0.0]), (-1.0, 1.0, &[0.0])],
    params: &[(-2.0, 2.0), (-3.0, 3.0)],
    inputs: &[(-1.5, 1.5, &[0.0, 0.0])],
};

/// A guard that compares a state with an input.
pub const FOLLOW: Target = Target {
    name: "guard on an input",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
[init]
x = 0
y = 0
[params]
m = [-2, 2]
a = [-1, 1]
[der]
x = "a - m*sign(x - u)"
y = "sign(x - u)*x"
[outputs]
y_m = "y +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |_, p, _, d| d[0] = p[1],
        switches: &[Switch {
            g: |x, _, u| x[0] - u[0],
            b: |x, p, _, d| {
                d[0] = -p[0];
                d[1] = x[0];
            },
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.3, 0.3, &[0.0, 0.1]), (-1.0, 1.0, &[])],
    params: &[(-2.0, 2.0), (-1.0, 1.0)],
    inputs: &[(-0.3, 0.3, &[0.0, 0.1])],
};

/// A smooth oscillator drives a component whose derivative jumps.
pub const WATCHED: Target = Target {
    name: "jump in another component",
    text: r#"
format = 1
states = ["x1", "x2", "x3"]
[init]
x1 = 0
x2 = 0
x3 = 0
[params]
w = [1, 100]
a = [-2, 2]
b = [-2, 2]
[modes.inside]
when = "(x1 <= 0.1 and x1 >= -1) or x1 < -1"
der = { x1 = "x2", x2 = "-w*x1", x3 = "b - x3" }
[modes.outside]
when = "not (x1 < 0.1 or x1 == 0.1)"
der = { x1 = "x2", x2 = "-w*x1", x3 = "a + x1" }
[outputs]
y_m = "x3 +- 0.01"
"#,
    truth: Truth {
        states: 3,
        f: |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[0] * x[0];
            d[2] = (p[1] + x[0] + p[2] - x[2]) / 2.0;
        },
        switches: &[Switch {
            g: |x, _, _| x[0] - 0.1,
            b: |x, p, _, d| d[2] = (p[1] + x[0] - p[2] + x[2]) / 2.0,
        }],
        kinks: &[],
        longest: 1e-3,
    },
    states: &[
        (-0.3, 0.3, &[0.1, 0.1]),
        (-1.0, 1.0, &[0.0]),
        (-1.0, 1.0, &[]),
    ],
    params: &[(1.0, 100.0), (-2.0, 2.0), (-2.0, 2.0)],
    inputs: &[],
};

/// Two relays that drive each other.
pub const TWO_RELAYS: Target = Target {
    name: "two relays",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
[init]
x = 0
y = 0
[params]
a = [-3, 3]
b = [-3, 3]
m = [-2, 2]
[der]
x = "-m*sign(x) + a*y"
y = "-(1 + x^2)*sign(y - 0.05) - b*x + u"
[outputs]
y_m = "y +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            d[0] = p[0] * x[1];
            d[1] = -p[1] * x[0] + u[0];
        },
        switches: &[
            Switch {
                g: |x, _, _| x[0],
                b: |_, p, _, d| d[0] = -p[2],
            },
            Switch {
                g: |x, _, _| x[1] - 0.05,
                b: |x, _, _, d| d[1] = -(1.0 + x[0] * x[0]),
            },
        ],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-0.3, 0.3, &[0.0, 0.0]), (-0.3, 0.3, &[0.05, 0.05])],
    params: &[(-3.0, 3.0), (-3.0, 3.0), (-2.0, 2.0)],
    inputs: &[(-2.0, 2.0, &[0.0, 1.0])],
};

/// A point mass in free fall that grazes a line where something else switches (BM18).
pub const GRAZING: Target = Target {
    name: "grazing",
    text: r#"
format = 1
states = ["x", "y", "z"]
[init]
x = 0
y = 0
z = 0
[params]
g = [0.5, 2]
[der]
x = "y"
y = "-g"
z = "sign(x - 0.125) + z*sign(x - 0.125)"
[outputs]
z_m = "z +- 0.01"
"#,
    truth: Truth {
        states: 3,
        f: |x, p, _, d| {
            d[0] = x[1];
            d[1] = -p[0];
        },
        switches: &[Switch {
            g: |x, _, _| x[0] - 0.125,
            b: |x, _, _, d| d[2] = 1.0 + x[2],
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[
        (0.1, 0.13, &[0.125, 0.12, 0.1199]),
        (-0.3, 0.3, &[0.1, 0.0]),
        (-1.0, 1.0, &[0.0]),
    ],
    params: &[(0.5, 2.0)],
    inputs: &[],
};

/// Guards that touch zero and stay there: an input at its threshold, two states that move as one.
pub const GATES: Target = Target {
    name: "guards that stay at zero",
    text: r#"
format = 1
states = ["x", "y", "z"]
inputs = ["a", "u"]
[init]
x = 0
y = 0
z = 0
[modes.on]
when = "u >= 0.125"
der = { x = "a", y = "a", z = "1 + sign(x - y)" }
[modes.off]
when = "u < 0.125"
der = { x = "a", y = "a", z = "-1 + sign(x - y)" }
[outputs]
z_m = "z +- 0.01"
"#,
    truth: Truth {
        states: 3,
        f: |_, _, u, d| {
            d[0] = u[0];
            d[1] = u[0];
        },
        switches: &[
            Switch {
                g: |_, _, u| u[1] - 0.125,
                b: |_, _, _, d| d[2] = 1.0,
            },
            Switch {
                g: |x, _, _| x[0] - x[1],
                b: |_, _, _, d| d[2] = 1.0,
            },
        ],
        kinks: &[],
        longest: 1e-2,
    },
    states: &[
        (-0.5, 0.5, &[0.25, 0.25]),
        (-0.5, 0.5, &[0.25, 0.25]),
        (-1.0, 1.0, &[]),
    ],
    params: &[],
    inputs: &[(-1.0, 1.0, &[0.0, 0.0]), (-0.5, 0.5, &[0.125, 0.125])],
};

/// An input that may change inside the step, times something that changes sign there.
pub const FANNED: Target = Target {
    name: "input of indefinite influence",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
[init]
x = 0
y = 0
[params]
c = [-3, 3]
[der]
x = "u*y + 0.1*x"
y = "c"
[outputs]
y_m = "x +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            d[0] = u[0] * x[1] + 0.1 * x[0];
            d[1] = p[0];
        },
        switches: NO_SWITCH,
        kinks: &[|x, _, _| x[1]],
        longest: 1e-2,
    },
    states: &[(-0.5, 0.5, &[]), (-0.1, 0.1, &[0.0, -0.01, 0.01])],
    params: &[(-3.0, 3.0)],
    inputs: &[(-1.0, 1.0, &[])],
};

pub const FUNCTIONS: Target = Target {
    name: "all functions",
    text: r#"
format = 1
states = ["x", "y", "z"]
inputs = ["u"]
[init]
x = 0
y = 0
z = 0
[params]
a = [-1, 1]
b = [-2, 2]
[der]
x = "-sin(y)*exp(-abs(z)) + max(x, 0.5*y)*a + u"
y = "sqrt(1.5 + x*x)*tanh(z) - atan(y)*b"
z = "log(2 + cos(x)) - tan(0.3*tanh(y)) + min(z, a)/(1 + z^2)"
[outputs]
y_m = "y +- 0.01"
"#,
    truth: Truth {
        states: 3,
        f: |x, p, u, d| {
            let [a, b] = [p[0], p[1]];
            d[0] = -x[1].sin() * (-x[2].abs()).exp() + x[0].max(0.5 * x[1]) * a + u[0];
            d[1] = (1.5 + x[0] * x[0]).sqrt() * x[2].tanh() - x[1].atan() * b;
            d[2] = (2.0 + x[0].cos()).ln() - (0.3 * x[1].tanh()).tan()
                + x[2].min(a) / (1.0 + x[2] * x[2]);
        },
        switches: NO_SWITCH,
        kinks: &[
            |x, _, _| x[2],
            |x, _, _| x[0] - 0.5 * x[1],
            |x, p, _| x[2] - p[0],
        ],
        longest: 4e-3,
    },
    states: &[
        (-1.0, 1.0, &[0.0]),
        (-1.0, 1.0, &[0.0]),
        (-1.0, 1.0, &[0.0]),
    ],
    params: &[(-1.0, 1.0), (-2.0, 2.0)],
    inputs: &[(-1.0, 1.0, &[0.0])],
};

/// Kinks reached, left, touched and followed exactly.
pub const KINKS: Target = Target {
    name: "kinks",
    text: r#"
format = 1
states = ["x", "y", "z", "w"]
[init]
x = 0
y = 0
z = 0
w = 0
[params]
c = [-2, 2]
[der]
x = "c"
y = "min(max(x, -1), 1)"
z = "abs(x) - 2*max(x, 0)*min(1, x)"
w = "max(x, y) + min(1 - x, z) - w"
[outputs]
y_m = "y +- 0.01"
"#,
    truth: Truth {
        states: 4,
        f: |x, p, _, d| {
            d[0] = p[0];
            d[1] = x[0].clamp(-1.0, 1.0);
            d[2] = x[0].abs() - 2.0 * x[0].max(0.0) * x[0].min(1.0);
            d[3] = x[0].max(x[1]) + (1.0 - x[0]).min(x[2]) - x[3];
        },
        switches: NO_SWITCH,
        kinks: &[
            |x, _, _| x[0] - 1.0,
            |x, _, _| x[0] + 1.0,
            |x, _, _| x[0],
            |x, _, _| x[0] - x[1],
            |x, _, _| 1.0 - x[0] - x[2],
        ],
        longest: 1e-2,
    },
    states: &[
        (-1.3, 1.3, &[0.0, 1.0, -1.0]),
        (-1.0, 1.0, &[0.0, 1.0]),
        (-1.0, 1.0, &[0.0]),
        (-1.0, 1.0, &[0.0]),
    ],
    params: &[(-2.0, 2.0)],
    inputs: &[],
};

pub const BRANCHES: Target = Target {
    name: "if, table with a jump, dead zone, saturation",
    text: r#"
format = 1
states = ["x", "v"]
inputs = ["u"]
[init]
x = 0
v = 0
[params]
k = [0, 3]
c = [0, 2]
[der]
x = "v - 0.2*table(x, -1, -2, 0, 0, 0, 1, 1, 3)"
v = "(if v > 0.1 then u - k*x else 2*u) - deadzone(x, 0.2) - c*sat(v, -0.3, 0.4)"
[outputs]
x_m = "x +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            let table = -1.5 + 2.0 * (x[0].clamp(-1.0, 0.0) + 1.0) + 2.0 * x[0].clamp(0.0, 1.0);
            d[0] = x[1] - 0.2 * table;
            let dead = x[0] - x[0].clamp(-0.2, 0.2);
            d[1] = 0.5 * (3.0 * u[0] - p[0] * x[0]) - dead - p[1] * x[1].clamp(-0.3, 0.4);
        },
        switches: &[
            Switch {
                g: |x, _, _| x[0],
                b: |_, _, _, d| d[0] = -0.1,
            },
            Switch {
                g: |x, _, _| x[1] - 0.1,
                b: |x, p, u, d| d[1] = 0.5 * (-u[0] - p[0] * x[0]),
            },
        ],
        kinks: &[
            |x, _, _| x[0] - 1.0,
            |x, _, _| x[0] + 1.0,
            |x, _, _| x[0] - 0.2,
            |x, _, _| x[0] + 0.2,
            |x, _, _| x[1] - 0.4,
            |x, _, _| x[1] + 0.3,
        ],
        longest: 2e-3,
    },
    states: &[(-1.3, 1.3, &[0.0, 0.2, -1.0]), (-0.6, 0.6, &[0.1, 0.0])],
    params: &[(0.0, 3.0), (0.0, 2.0)],
    inputs: &[(-2.0, 2.0, &[0.0])],
};

pub const TANKS: Target = Target {
    name: "tanks",
    text: r#"
format = 1
states = ["h1", "h2"]
inputs = ["q"]
[init]
h1 = 0.4
h2 = 0.4
[params]
c = [0.3, 0.5]
over = [0, 3]
[let]
q12 = "c*sqrt(h1)"
[der]
h1 = "q - q12 - over*max(0, h1 - 0.5)"
h2 = "q12 - 0.3*sqrt(h2)"
[outputs]
h = "h2 +- 0.01"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            let q = p[0] * x[0].sqrt();
            d[0] = u[0] - q - p[1] * (x[0] - 0.5).max(0.0);
            d[1] = q - 0.3 * x[1].sqrt();
        },
        switches: NO_SWITCH,
        kinks: &[|x, _, _| x[0] - 0.5],
        longest: 1e-2,
    },
    states: &[(0.3, 0.7, &[0.5, 0.5]), (0.1, 0.8, &[])],
    params: &[(0.3, 0.5), (0.0, 3.0)],
    inputs: &[(0.0, 1.0, &[])],
};

pub const RIG_FIELD: Field = |x, p, u, d| {
    d[0] = x[1];
    d[1] = p[0] * x[1] + p[1] * u[0];
};

const RIG_TRUTH: Truth = Truth {
    states: 2,
    f: RIG_FIELD,
    switches: &[Switch {
        g: |x, _, _| x[1],
        b: |_, p, _, d| d[1] = -p[1] * p[2],
    }],
    kinks: &[],
    longest: 2e-3,
};

pub const RIG_SHORT: Target = Target {
    name: "rig, friction law",
    text: r#"
format = 1
states = ["phi", "omega"]
inputs = ["u"]
[init]
phi = 0
omega = 0
[params]
alpha = [-6, 0]
beta  = [1, 400]
T_Fs  = [0, 0.35]
[der]
phi   = "omega"
omega = "alpha*omega + beta*(u - friction(omega, u, T_Fs))"
[outputs]
phi_m = "phi +- 0.1"
"#,
    truth: RIG_TRUTH,
    states: &[(-1.0, 1.0, &[0.0]), (-1.0, 1.0, &[0.0, 0.0])],
    params: &[(-6.0, 0.0), (1.0, 400.0), (0.0, 0.35)],
    inputs: &[(-0.4, 0.4, &[0.0, 0.1, -0.2])],
};

/// The rig with three modes, which hold as these guards say.
macro_rules! rig_modes {
    ($forward:literal, $stick:literal, $backward:literal) => {
        concat!(
            r#"
format = 1
states = ["phi", "omega"]
inputs = ["u"]
[init]
phi = 0
omega = 0
[params]
alpha = [-6, 0]
beta  = [1, 400]
T_Fs  = [0, 0.35]
[let]
drive = "beta * u + alpha * omega"
[outputs]
phi_m = "phi +- 0.1"
[modes]
"#,
            "forward  = { when = \"",
            $forward,
            "\", der = { phi = \"omega\", omega = \"drive - beta * T_Fs\" } }\nstick    = { when = \"",
            $stick,
            "\", der = { phi = \"0\", omega = \"0\" } }\nbackward = { when = \"",
            $backward,
            "\", der = { phi = \"omega\", omega = \"drive + beta * T_Fs\" } }\n",
        )
    };
}

pub const RIG_EXPLICIT: Target = Target {
    name: "rig, three modes",
    text: rig_modes!(
        "omega > 0 or (omega == 0 and u >  T_Fs)",
        "omega == 0 and abs(u) <= T_Fs",
        "omega < 0 or (omega == 0 and u < -T_Fs)"
    ),
    ..RIG_SHORT
};

/// The same modes with their guards written from the other side.
pub const RIG_MIRRORED: Target = Target {
    name: "rig, mirrored guards",
    text: rig_modes!(
        "0 < omega or (0 == omega and T_Fs < u)",
        "-omega == 0 and T_Fs >= abs(u)",
        "-omega > 0 or (-2*omega == 0 and -u > T_Fs)"
    ),
    ..RIG_SHORT
};

/// Steps of the first state at whole numbers, as switches: half a step each.
macro_rules! steps {
    ($b:expr, $($level:literal),*) => {
        &[$(Switch { g: |x, _, _| x[0] - $level, b: $b }),*]
    };
}

/// `floor` of a state in its own equation, as a brake (sliding at whole numbers), or driving away from them.
pub const FLOOR: Target = Target {
    name: "floor",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
init = { x = 0, y = 0 }
[params]
a = [-1, 3]
b = [-2, 2]
[der]
x = "u - a*floor(x)"
y = "b*floor(x) - y*ceil(x)"
[outputs]
z = "y +- 1"
"#,
    truth: Truth {
        states: 2,
        f: |x, _, u, d| {
            d[0] = u[0];
            d[1] = -x[1];
        },
        switches: steps!(
            |x, p, _, d| {
                d[0] = -p[0] / 2.0;
                d[1] = (p[1] - x[1]) / 2.0;
            },
            -5.0,
            -4.0,
            -3.0,
            -2.0,
            -1.0,
            0.0,
            1.0,
            2.0,
            3.0,
            4.0,
            5.0,
            6.0
        ),
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-1.8, 1.8, &[-1.0, 0.0, 1.0]), (-1.0, 1.0, &[])],
    params: &[(-1.0, 3.0), (-2.0, 2.0)],
    inputs: &[(-2.0, 2.0, &[0.0, 1.0, -1.0])],
};

/// An encoder's position, fed back by a controller that rounds too; `trunc` has no step at zero.
pub const ENCODER: Target = Target {
    name: "encoder",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
init = { x = 0, y = 0 }
[params]
a = [0, 3]
b = [-2, 2]
[der]
x = "round(u/0.5)*0.5 - a*trunc(x)"
y = "b*trunc(x) + round(y/100)"
[outputs]
z = "0.5*floor(x/0.5) +- 0.1"
"#,
    truth: Truth {
        states: 2,
        f: |_, _, u, d| {
            d[0] = (u[0] / 0.5).round() * 0.5;
            d[1] = 0.0;
        },
        switches: steps!(
            |_, p, _, d| {
                d[0] = -p[0] / 2.0;
                d[1] = p[1] / 2.0;
            },
            -3.0,
            -2.0,
            -1.0,
            1.0,
            2.0,
            3.0
        ),
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-1.8, 1.8, &[-1.0, 0.0, 1.0]), (-1.0, 1.0, &[])],
    params: &[(0.0, 3.0), (-2.0, 2.0)],
    inputs: &[(-4.0, 4.0, &[0.25, -0.25, 0.75, 1.0])],
};

/// The angle of a point left of the origin jumps on the axis; the point slides along it or is driven away.
pub const ANGLE: Target = Target {
    name: "angle",
    text: r#"
format = 1
states = ["x", "y", "z"]
inputs = ["u"]
init = { x = -1, y = 0, z = 0 }
[params]
a = [-1, 1]
b = [-1, 1]
[der]
x = "-2 - x"
y = "u - a*atan2(y, x)"
z = "b*atan2(y, x) - z"
[outputs]
w = "atan2(y, x) +- 0.1"
"#,
    truth: Truth {
        states: 3,
        f: |x, p, u, d| {
            let angle = (x[1] / x[0]).atan();
            d[0] = -2.0 - x[0];
            d[1] = u[0] - p[0] * angle;
            d[2] = p[1] * angle - x[2];
        },
        switches: &[Switch {
            g: |x, _, _| x[1],
            b: |_, p, _, d| {
                d[1] = -p[0] * std::f64::consts::PI;
                d[2] = p[1] * std::f64::consts::PI;
            },
        }],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-3.0, -0.5, &[]), (-0.5, 0.5, &[0.0]), (-1.0, 1.0, &[])],
    params: &[(-1.0, 1.0), (-1.0, 1.0)],
    inputs: &[(-2.0, 2.0, &[0.0])],
};

pub const ALL: [&Target; 25] = [
    &FLOOR,
    &ENCODER,
    &ANGLE,
    &BRANCHES,
    &RIG_MIRRORED,
    &GATES,
    &FANNED,
    &BELT,
    &PENDULUM,
    &CHAIN,
    &CLUTCH,
    &RELAY,
    &SLIDING,
    &DEAD_ZONE,
    &STAIRS,
    &MOVING_LEVEL,
    &UNSTABLE,
    &FOLLOW,
    &WATCHED,
    &TWO_RELAYS,
    &GRAZING,
    &FUNCTIONS,
    &KINKS,
    &TANKS,
    &RIG_SHORT,
];
