//! Models with an order, some of it only for a while.

use super::models::Target;
use super::truth::{Switch, Truth};

const SLIDER: Target = Target {
    name: "slider",
    text: r#"
format = 1
states = ["v"]
inputs = ["u"]
init = { v = 0 }
[params]
c = [0, 1]
d = [0, 1]
[der]
v = "u - d*v - c*sign(v)"
[outputs]
m = "v +- 1"
"#,
    truth: Truth {
        states: 1,
        f: |x, p, u, d| d[0] = u[0] - p[1] * x[0],
        switches: &[Switch {
            g: |x, _, _| x[0],
            b: |_, p, _, d| d[0] = -p[0],
        }],
        kinks: &[],
        longest: 1e-2,
    },
    states: &[(-1.0, 1.0, &[0.0])],
    params: &[(0.0, 1.0), (0.0, 1.0)],
    inputs: &[(-2.0, 2.0, &[0.0])],
};

const CART: Target = Target {
    name: "cart",
    text: r#"
format = 1
states = ["x", "v", "w"]
inputs = ["u"]
init = { x = 0, v = 0, w = 0 }
[params]
a = [-2, 0]
b = [1, 2]
T = [0.1, 0.4]
[der]
x = "v"
v = "a*v + b*(u - friction(v, u, T)) + 0.3*max(w, 0)"
w = "0.5*x - w"
[outputs]
m = "x +- 1"
"#,
    truth: Truth {
        states: 3,
        f: |x, p, u, d| {
            d[0] = x[1];
            d[1] = p[0] * x[1] + p[1] * u[0] + 0.3 * x[2].max(0.0);
            d[2] = 0.5 * x[0] - x[2];
        },
        switches: &[Switch {
            g: |x, _, _| x[1],
            b: |_, p, _, d| d[1] = -p[1] * p[2],
        }],
        kinks: &[|x, _, _| x[2]],
        longest: 1e-3,
    },
    states: &[(-0.5, 0.5, &[0.0]), (-0.5, 0.5, &[0.0]), (-2.0, -0.1, &[])],
    params: &[(-2.0, 0.0), (1.0, 2.0), (0.1, 0.4)],
    inputs: &[(-1.0, 1.0, &[0.0])],
};

const RIVALS: Target = Target {
    name: "rivals",
    text: r#"
format = 1
states = ["x", "y"]
inputs = ["u"]
init = { x = 0, y = 0 }
[params]
k = [0, 2]
s = [0.1, 1]
[der]
x = "u - x - k*max(0, y - 0.3)"
y = "0.5 - s*y - 0.4*min(x, 1)^3"
[outputs]
m = "x +- 1"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, u, d| {
            d[0] = u[0] - x[0] - p[0] * (x[1] - 0.3).max(0.0);
            d[1] = 0.5 - p[1] * x[1] - 0.4 * x[0].min(1.0).powi(3);
        },
        switches: &[],
        kinks: &[|x, _, _| x[1] - 0.3, |x, _, _| x[0] - 1.0],
        longest: 5e-3,
    },
    states: &[(0.0, 1.5, &[0.0, 1.0]), (0.0, 1.0, &[0.0, 0.3])],
    params: &[(0.0, 2.0), (0.1, 1.0)],
    inputs: &[(0.0, 2.0, &[0.0])],
};

const TIMED: Target = Target {
    name: "timed",
    text: r#"
format = 1
states = ["x", "t"]
init = { x = 0, t = 0 }
[params]
k = [0.2, 1]
a = [0.5, 2]
[der]
x = "a*(if t < 0.4 then 1 else -0.2) - k*x + cos(3*t)"
t = "1"
[outputs]
m = "x +- 1"
"#,
    truth: Truth {
        states: 2,
        f: |x, p, _, d| {
            d[0] = 0.4 * p[1] - p[0] * x[0] + (3.0 * x[1]).cos();
            d[1] = 1.0;
        },
        switches: &[Switch {
            g: |x, _, _| x[1] - 0.4,
            b: |_, p, _, d| d[0] = -0.6 * p[1],
        }],
        kinks: &[],
        longest: 5e-3,
    },
    states: &[(0.0, 1.0, &[]), (0.0, 1.0, &[0.0, 0.4])],
    params: &[(0.2, 1.0), (0.5, 2.0)],
    inputs: &[],
};

const BRAKES: Target = Target {
    name: "brakes",
    text: r#"
format = 1
states = ["v", "w"]
inputs = ["u"]
init = { v = 0, w = 0 }
[params]
c = [0.1, 1]
e = [0.1, 1]
[der]
v = "u + 0.5*w - c*sign(v)"
w = "0.5*v - e*sign(w - 0.2)"
[outputs]
m = "v +- 1"
"#,
    truth: Truth {
        states: 2,
        f: |x, _, u, d| {
            d[0] = u[0] + 0.5 * x[1];
            d[1] = 0.5 * x[0];
        },
        switches: &[
            Switch {
                g: |x, _, _| x[0],
                b: |_, p, _, d| d[0] = -p[0],
            },
            Switch {
                g: |x, _, _| x[1] - 0.2,
                b: |_, p, _, d| d[1] = -p[1],
            },
        ],
        kinks: &[],
        longest: 2e-3,
    },
    states: &[(-1.0, 1.0, &[0.0]), (-0.8, 1.2, &[0.2])],
    params: &[(0.1, 1.0), (0.1, 1.0)],
    inputs: &[(-2.0, 2.0, &[0.0])],
};

pub const ALL: [&Target; 5] = [&SLIDER, &CART, &RIVALS, &TIMED, &BRAKES];
