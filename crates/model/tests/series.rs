//! Taylor coefficients along a trajectory and plain ranges must not contradict each other.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test fails by panicking"
)]

use veribound_interval::Interval;
use veribound_interval::lanes::{Arithmetic, Kernel, Value};
use veribound_model::{Coefficients, Layout, Model, SeriesTape, Tape};

const LAYOUT: Layout = Layout {
    states: 1,
    params: 0,
    inputs: 0,
};

fn model_of(velocity: &str) -> Model {
    let text = format!(
        "format = 1\n[states]\nx = {{ init = [1, 2] }}\n[der]\nx = \"{velocity}\"\n[outputs]\n\
         x_m = \"x +- 1\"\n"
    );
    Model::from_text("model.toml", &text)
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

struct Compute<'a> {
    series: &'a SeriesTape,
    order: usize,
    coefficients: &'a mut Coefficients<Interval>,
}

impl Kernel<Interval> for Compute<'_> {
    type Output = ();

    fn run<A: Arithmetic<Value = Interval>>(self) {
        self.series.compute::<A>(self.order, self.coefficients);
    }
}

#[test]
fn a_power_is_as_tight_in_a_series_as_in_a_range() {
    for n in [-7, -3, -2, -1, 2, 3, 5, 6, 7, 11] {
        let model = model_of(&format!("x^({n})"));
        let velocity = model.modes[0].der[0];
        let range = Tape::compile(&model.graph, LAYOUT, &[velocity]);
        let series = SeriesTape::compile(&model.graph, LAYOUT, &[velocity]);
        let mut registers = range.registers();
        let mut coefficients = series.coefficients(2);
        for (lo, hi) in [(0.1, 0.7), (1.1, 1.3), (-3.3, -0.1), (0.1, 0.1)] {
            let x = Interval::new(lo, hi).unwrap();
            range.eval(&[x], &mut registers);
            series.set_quantity(0, 0, x, &mut coefficients);
            series.set_quantity(0, 1, Interval::ZERO, &mut coefficients);
            for order in 0..2 {
                Interval::run(Compute {
                    series: &series,
                    order,
                    coefficients: &mut coefficients,
                });
            }
            let (first, second) = (
                series.output(0, 0, &coefficients),
                series.output(0, 1, &coefficients),
            );
            assert_eq!(first, range.output(0, &registers), "x^{n} on {x}");
            assert_eq!(second, Interval::ZERO, "a constant power, x^{n} on {x}");
        }
    }
}
