//! Models and exact solutions that several tests use.
#![allow(dead_code)]

use std::sync::Arc;
use veribound_interval::{Decimal, Interval};
use veribound_model::{
    ErrorBound, Graph, Guard, Input, Mode, Model, Output, Param, Relation, SourceText, State,
    Unary, Var,
};

/// A small repeatable generator (splitmix64).
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
}

/// Exact flow of the rig over `h` with constant `u`: stop, stick and reversal included.
pub fn rig_step(phi: f64, w: f64, u: f64, p: [f64; 3], h: f64) -> (f64, f64) {
    let [a, b, level] = p;
    let (mut phi, mut w, mut t) = (phi, w, 0.0);
    while t < h {
        let rest = h - t;
        if w == 0.0 && u.abs() <= level {
            return (phi, 0.0);
        }
        let s = if w == 0.0 { u.signum() } else { w.signum() };
        let c = b * (u - s * level) / a;
        let q = c / (w + c);
        let stop = if w != 0.0 && w + c != 0.0 && q > 0.0 && q < 1.0 {
            q.ln() / a
        } else {
            f64::INFINITY
        };
        let d = rest.min(stop);
        let e = (a * d).exp_m1();
        phi += (w + c) * e / a - c * d;
        w = if stop <= rest { 0.0 } else { (w + c) * (e + 1.0) - c };
        t += d;
        if stop > rest {
            break;
        }
    }
    (phi, w)
}

pub fn rig_model() -> Model {
    let mut g = Graph::default();
    let (phi, w) = (g.var(Var::State(0)), g.var(Var::State(1)));
    let (a, b, t) = (g.var(Var::Param(0)), g.var(Var::Param(1)), g.var(Var::Param(2)));
    let u = g.var(Var::Input(0));
    let zero = g.integer(0);
    let aw = g.mul(a, w);
    let minus = g.sub(u, t);
    let plus = g.add(u, t);
    let bm = g.mul(b, minus);
    let bp = g.mul(b, plus);
    let fwd = g.add(aw, bm);
    let bwd = g.add(aw, bp);
    let au = g.unary(Unary::Abs, u);
    let stick = g.sub(au, t);
    let atom = |expr, relation| Guard::Atom { expr, relation };
    let mode = |name: &str, guard, der| Mode { name: name.into(), guard, der };
    let modes = vec![
        mode("forward", Guard::Any(vec![atom(w, Relation::Greater), Guard::All(vec![atom(w, Relation::Equal), atom(minus, Relation::Greater)])]), vec![w, fwd]),
        mode("stick", Guard::All(vec![atom(w, Relation::Equal), atom(stick, Relation::LessEqual)]), vec![zero, zero]),
        mode("backward", Guard::Any(vec![atom(w, Relation::Less), Guard::All(vec![atom(w, Relation::Equal), atom(plus, Relation::Less)])]), vec![w, bwd]),
    ];
    let d = |s: &str| Decimal::parse(s).unwrap();
    let err = |s: &str| ErrorBound { absolute: d(s), relative: d("0") };
    let iv = |lo, hi| Interval::new(lo, hi).unwrap();
    let state = |name: &str| State { name: name.into(), unit: String::new(), init: Interval::ZERO, domain: None };
    let param = |name: &str, bounds| Param { name: name.into(), unit: String::new(), bounds, nominal: None };
    Model {
        name: "rig".into(),
        states: vec![state("phi"), state("omega")],
        inputs: vec![Input { name: "u".into(), unit: String::new(), column: None, error: err("0"), domain: None }],
        params: vec![param("alpha", iv(-6.0, -0.05)), param("beta", iv(1.0, 400.0)), param("T_Fs", iv(0.0, 0.3))],
        modes,
        outputs: vec![Output { name: "phi_m".into(), unit: String::new(), column: None, expr: phi, error: err("0.1") }],
        signals: vec![],
        coverage: veribound_model::Coverage::Everywhere,
        notes: vec![],
        source: Arc::new(SourceText { name: "rig".into(), text: String::new(), first_line: 1 }),
        graph: g,
    }
}
