//! The same equations in other parameters: at random points and parameters they mean the same.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Guard, Model, Ratio, Relation, Var};

/// Numbers that are always the same.
struct Draw(u64);

impl Draw {
    fn between(&mut self, from: f64, to: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn value(graph: &Graph, e: ExprId, x: &[f64], p: &[Interval], u: &[f64]) -> Interval {
    graph.eval_interval(e, &|var| match var {
        Var::State(i) => Interval::point(x[i]),
        Var::Param(i) => p[i],
        Var::Input(i) => Interval::point(u[i]),
    })
}

/// The atoms of a guard, in order.
fn atoms(guard: &Guard, found: &mut Vec<(ExprId, Relation)>) {
    match guard {
        Guard::Always => {}
        Guard::Atom { expr, relation } => found.push((*expr, *relation)),
        Guard::All(parts) | Guard::Any(parts) => {
            parts.iter().for_each(|part| atoms(part, found));
        }
    }
}

fn model(states: &str, params: &str, der: &str, more: &str) -> Model {
    let text = format!(
        "format = 1\nstates = [{states}]\ninputs = [\"u\"]\n[init]\nx = [-1, 1]\nv = [-2, 2]\n[params]\n{params}\n[der]\n{der}\n\
         [outputs]\ny = \"x +- 0.1\"\n{more}"
    );
    match Model::from_text("m.toml", text) {
        Ok(model) => model,
        Err(wrong) => panic!("{wrong:?}"),
    }
}

/// At random points: rates are the same, guards have the same signs, and new parameters are in their bounds and give the
/// old ones.
fn means_the_same(model: &Model) -> (Model, Vec<Option<Ratio>>) {
    let (new, ratios) = model.with_ratios();
    assert_eq!(new.modes.len(), model.modes.len());
    let mut draw = Draw(11);
    for _ in 0..300 {
        let old: Vec<f64> = model
            .params
            .iter()
            .map(|p| draw.between(p.bounds.lo(), p.bounds.hi()))
            .collect();
        let x = [draw.between(-1.0, 1.0), draw.between(-2.0, 2.0)];
        let u = [draw.between(-3.0, 3.0)];
        let before: Vec<Interval> = old.iter().map(|p| Interval::point(*p)).collect();
        let after: Vec<Interval> = ratios
            .iter()
            .enumerate()
            .map(|(param, ratio)| match ratio {
                None => before[param],
                Some(Ratio { over: None, under }) => Interval::ONE / before[*under],
                Some(Ratio {
                    over: Some(over),
                    under,
                }) => {
                    assert_eq!(*over, param);
                    before[*over] / before[*under]
                }
            })
            .collect();
        for ((own, bounds), (ratio, old)) in after
            .iter()
            .zip(new.params.iter().map(|p| p.bounds))
            .zip(ratios.iter().zip(&old))
        {
            assert!(own.intersects(bounds), "{own} {bounds}");
            if let Some(Ratio { over, under }) = ratio {
                let above = over.map_or(Interval::ONE, |over| after[over]);
                assert!((above / after[*under]).contains(*old));
            }
        }
        let near = |a: Interval, b: Interval| {
            assert!(
                a.intersects(b) && b.width() < 1e-9,
                "{a} {b} at {x:?} {u:?} {old:?}"
            );
        };
        let pairs = model.modes.iter().zip(&new.modes);
        for (one, other) in pairs {
            for (a, b) in one.der.iter().zip(&other.der) {
                let a = value(&model.graph, *a, &x, &before, &u);
                near(a, value(&new.graph, *b, &x, &after, &u));
            }
            let (mut left, mut right) = (Vec::new(), Vec::new());
            atoms(&one.guard, &mut left);
            atoms(&other.guard, &mut right);
            assert_eq!(left.len(), right.len());
            for ((a, relation), (b, same)) in left.iter().zip(&right) {
                assert_eq!(relation, same);
                let a = value(&model.graph, *a, &x, &before, &u);
                let b = value(&new.graph, *b, &x, &after, &u);
                let both = (a * b).hi();
                assert!(
                    both >= 0.0 && (a == Interval::ZERO) == (b == Interval::ZERO),
                    "{a} {b}"
                );
            }
        }
        for (a, b) in model.outputs.iter().zip(&new.outputs) {
            let a = value(&model.graph, a.expr, &x, &before, &u);
            near(a, value(&new.graph, b.expr, &x, &after, &u));
        }
    }
    (new, ratios)
}

fn has(ratios: &[Option<Ratio>], wanted: &[Option<Option<usize>>], under: usize) {
    let wanted: Vec<Option<Ratio>> = wanted
        .iter()
        .map(|over| over.map(|over| Ratio { over, under }))
        .collect();
    assert_eq!(ratios, wanted);
}

/// A mass with friction and an offset is affine in the inverse of the mass and three ratios.
#[test]
fn a_mass_with_friction() {
    let params = "M = [50, 150]\nd = [0, 600]\nc = [0, 60]\no = [-20, 20]";
    let der = "x = \"v\"\nv = \"(u - d*v - o - friction(v, u - d*v - o, c))/M\"";
    let model = model("\"x\", \"v\"", params, der, "");
    let (new, ratios) = means_the_same(&model);
    has(
        &ratios,
        &[Some(None), Some(Some(1)), Some(Some(2)), Some(Some(3))],
        0,
    );
    for mode in &new.modes {
        // Affine: what a parameter adds does not depend on the others.
        for e in &mode.der {
            let at = |p: [f64; 4]| {
                let p: Vec<Interval> = p.iter().map(|p| Interval::point(*p)).collect();
                value(&new.graph, *e, &[0.5, -1.0], &p, &[2.0]).mid()
            };
            let (zero, one) = (at([0.0; 4]), at([1.0; 4]));
            let alone: f64 = (0..4)
                .map(|k| {
                    let mut p = [0.0; 4];
                    p[k] = 1.0;
                    at(p) - zero
                })
                .sum();
            assert!((one - zero - alone).abs() < 1e-12);
        }
    }
}

/// What is not always divided by the same divisor alone stays: a spring that is told, too, a gain of two divisors, what
/// stands in a sine, what may be zero, what is reset.
#[test]
fn what_stays_as_it_is() {
    let states = "\"x\", \"v\"";
    let told = model(
        states,
        "M = [1, 3]\nk = [1, 2]\nd = [1, 2]",
        "x = \"v + k\"\nv = \"(u - k*x - d*v)/M\"",
        "",
    );
    has(
        &means_the_same(&told).1,
        &[Some(None), None, Some(Some(2))],
        0,
    );
    let both = model(
        states,
        "M = [1, 3]\nN = [2, 3]\nk = [1, 2]\ng = [3, 4]",
        "x = \"v - k*x/N + g/N\"\nv = \"-k*x/M + u*abs(v)/M\"",
        "",
    );
    let ratios = means_the_same(&both).1;
    assert_eq!(
        ratios[0],
        Some(Ratio {
            over: None,
            under: 0
        })
    );
    assert_eq!(
        ratios[1],
        Some(Ratio {
            over: None,
            under: 1
        })
    );
    assert_eq!(ratios[2], None);
    assert_eq!(
        ratios[3],
        Some(Ratio {
            over: Some(3),
            under: 1
        })
    );
    let sine = model(
        states,
        "M = [1, 3]\nk = [1, 2]",
        "x = \"v + sin(M*x)\"\nv = \"-k*x/M\"",
        "",
    );
    has(&means_the_same(&sine).1, &[None, None], 0);
    let zero = model(
        states,
        "M = [-1, 3]\nk = [1, 2]",
        "x = \"v\"\nv = \"-k*x*M\"",
        "",
    );
    has(&means_the_same(&zero).1, &[None, None], 0);
    let sum = model(
        states,
        "M = [1, 3]\nk = [1, 2]",
        "x = \"v\"\nv = \"-k*x/(M + x^2)\"",
        "",
    );
    has(&means_the_same(&sum).1, &[None, None], 0);
    let events = "[signals]\nstill = { proves = \"v == 0\", latency = 0 }\n[events]\nrest = { when = \"still\", lasts = 0.1, action = \"reset c\" }\n";
    let reset = model(
        states,
        "M = [1, 3]\nc = [1, 2]\nd = [1, 2]",
        "x = \"v\"\nv = \"(u - d*v - friction(v, u, c))/M\"",
        events,
    );
    has(
        &means_the_same(&reset).1,
        &[Some(None), None, Some(Some(2))],
        0,
    );
}

/// A size is a factor of its own, whose divisor is taken out: also where it stands in a rate.
#[test]
fn sizes_of_sums() {
    let model = model(
        "\"x\", \"v\"",
        "M = [1, 3]\nk = [1, 2]\nd = [1, 2]",
        "x = \"v\"\nv = \"(u - d*abs(v - x) - abs(k*x + k*v))/M - d*v^2/M\"",
        "",
    );
    let (_, ratios) = means_the_same(&model);
    has(&ratios, &[Some(None), None, Some(Some(2))], 0);
}
