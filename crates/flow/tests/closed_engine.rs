//! The closed form of right-hand sides that are affine in the states, against exact solutions.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

mod common;

use common::{Rng, interval, read};
use veribound_flow::form::{Flow, FormOptions};
use veribound_interval::Interval;
use std::time::Instant;

fn flow(text: &str) -> Flow {
    Flow::new(&read("closed", text))
}

#[test]
fn smoke() {
    let mut rng = Rng(1);
    let _ = rng.unit();
    for (der, start, t) in [
        ("-1000*x + u", interval(1.0, 1.0), 1.0),
        ("-2*x + u", interval(0.9, 1.1), 3.0),
        ("-p*x + u", interval(0.9, 1.1), 3.0),
        ("p*x*0.1 + u", interval(0.9, 1.1), 3.0),
    ] {
        let flow = flow(&format!(
            "format = 1\nstates = [\"x\"]\ninputs=[\"u\"]\n[params]\np=[0.9,1.1]\n[init]\nx = 0\n[der]\nx = \"{der}\"\n[outputs]\nm = \"x +- 1\"\n"
        ));
        for closed in [false, true] {
            for u in [interval(0.5, 0.5), interval(0.4, 0.6)] {
                let options = FormOptions { closed, ..FormOptions::default() };
                let mut form = flow.start(&[start], &[interval(0.9, 1.1)], options);
                let before = Instant::now();
                let done = flow.advance(&mut form, &[u], Interval::point(t));
                println!("{der} {closed} {u} {done:?} {} tube {} {:?}", form.hull()[0], form.tube()[0], before.elapsed());
            }
        }
    }
    let flow = flow("format = 1\nstates = [\"x\", \"v\"]\ninputs=[\"u\"]\n[params]\np=[0.9,1.1]\n[init]\nx = 0\nv = 0\n[der]\nx = \"v\"\nv = \"-k*x - 0.1*v + u\"\n[let]\nk=\"400\"\n[outputs]\nm = \"x +- 1\"\n");
    for closed in [false, true] {
        for u in [interval(0.5, 0.5), interval(0.4, 0.6)] {
            let options = FormOptions { closed, ..FormOptions::default() };
            let mut form = flow.start(&[interval(0.9,1.1), interval(0.0, 0.1)], &[interval(1.0, 1.0)], options);
            let before = Instant::now();
            let done = flow.advance(&mut form, &[u], Interval::point(10.0));
            println!("osc {closed} {u} {done:?} {:?} tube {:?} {:?}", form.hull(), form.tube(), before.elapsed());
        }
    }
}
