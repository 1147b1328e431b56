//! Taylor coefficients of the elementary functions, enclosed.

use std::collections::HashMap;

use super::code::{Code, Op};
use veribound_interval::Interval;
use veribound_interval::lanes::{Arithmetic, Kernel, Value};
use veribound_model::{Coefficients, Graph, Layout, SeriesTape, Unary, Var};

/// One tape for every function that a model uses.
#[derive(Debug, Clone, Default)]
pub(super) struct Functions {
    tapes: HashMap<Unary, SeriesTape>,
}

const ONE_STATE: Layout = Layout {
    states: 1,
    params: 0,
    inputs: 0,
};

impl Functions {
    /// Those that `code` calls.
    pub(super) fn of(code: &Code) -> Functions {
        let mut functions = Functions::default();
        for step in &code.instructions {
            if let Op::Call { function, .. } = step.op {
                functions.learn(function);
            }
        }
        functions
    }

    fn learn(&mut self, function: Unary) {
        self.tapes.entry(function).or_insert_with(|| {
            let mut graph = Graph::default();
            let x = graph.var(Var::State(0));
            let value = graph.unary(function, x);
            SeriesTape::compile(&graph, ONE_STATE, &[value])
        });
    }

    /// Encloses `g^(m)(x) / m!` for every `x` in `at` and `m` up to `orders`; `None` where the
    /// function is not smooth on all of `at`.
    pub(super) fn expand(
        &self,
        function: Unary,
        at: Interval,
        orders: usize,
    ) -> Option<Vec<Interval>> {
        let tape = self.tapes.get(&function)?;
        let mut coefficients = tape.coefficients::<Interval>(orders);
        tape.set_quantity(0, 0, at, &mut coefficients);
        if orders > 0 {
            tape.set_quantity(0, 1, Interval::ONE, &mut coefficients);
        }
        let smooth = Interval::run(Expand {
            tape,
            orders,
            coefficients: &mut coefficients,
        });
        let list: Vec<Interval> = (0..=orders)
            .map(|m| tape.output(0, m, &coefficients))
            .collect();
        (smooth && list.iter().all(|x| !x.is_empty() && x.is_bounded())).then_some(list)
    }
}

struct Expand<'a> {
    tape: &'a SeriesTape,
    orders: usize,
    coefficients: &'a mut Coefficients<Interval>,
}

impl Kernel<Interval> for Expand<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval>>(self) -> bool {
        (0..=self.orders).all(|m| self.tape.compute::<A>(m, self.coefficients).is_smooth())
    }
}
