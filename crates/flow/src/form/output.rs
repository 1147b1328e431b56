//! Quantities of a form, and what measurements of them tell.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one polynomial per quantity, one coefficient per monomial"
)]

use super::code::{Code, Op};
use super::error::{Errors, Trouble};
use super::function::Functions;
use super::outward::raised;
use super::series::Series;
use super::set::{Form, OutputForm};
use super::step::Obstacle;
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Model, Node, Var};

/// An expression of a model, compiled to be evaluated on forms of that model.
///
/// Example: [`Meeting`](crate::form::Meeting).
#[derive(Debug, Clone)]
pub struct Output {
    /// The state that it is, if it is one.
    state: Option<usize>,
    code: Code,
    functions: Functions,
}

/// A quantity as an affine function of the unknowns, with quick bounds of what is not affine.
///
/// Guarantee: that of [`OutputForm`](super::OutputForm), which is narrower and dearer.
///
/// Example: [`Meeting`](crate::form::Meeting).
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Value for all unknowns in their middles.
    pub centre: f64,
    /// One for every unknown.
    pub slopes: Vec<f64>,
    /// What is not affine, and what is not known.
    pub remainder: Interval,
    /// One for every product of two unknowns, in the order of [`Form::products`]: a part of what is not affine,
    pub products: Vec<f64>,
    /// and what there is besides.
    pub rest: Interval,
}

/// A measurement contradicts the form: no solution in it has such a value.
///
/// Example: [`Meeting`](crate::form::Meeting).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Contradiction;

impl Output {
    /// The state that it is, if it is one.
    pub fn state(&self) -> Option<usize> {
        self.state
    }

    /// Compiles `expr` of `model`.
    pub fn new(model: &Model, expr: ExprId) -> Output {
        Output::compile(&mut model.graph.clone(), model.states.len(), expr)
    }

    pub(super) fn compile(graph: &mut Graph, states: usize, expr: ExprId) -> Output {
        let state = match *graph.node(expr) {
            Node::Var(Var::State(state)) => Some(state),
            _ => None,
        };
        let expr = graph.elementary(expr);
        let code = Code::compile(graph, &vec![false; states], &[expr], &[]);
        let functions = Functions::of(&code);
        Output {
            state,
            code,
            functions,
        }
    }
}

impl Form {
    /// A quantity as a function of the unknowns.
    ///
    /// Guarantee: that of [`OutputForm`], for all values of the inputs in `inputs`.
    ///
    /// Errors: [`Obstacle::Undefined`] and [`Obstacle::Jump`] where the expression has no value or a
    /// `sign` that is not decided, [`Obstacle::Unbounded`] where it is too large.
    pub fn output(&self, output: &Output, inputs: &[Interval]) -> Result<OutputForm, Obstacle> {
        if let Some(state) = output.state {
            return Ok(self.state(state));
        }
        let (polynomial, radius) = self.evaluate(output, inputs)?;
        Ok(self.affine(&polynomial, Interval::symmetric(radius)))
    }

    /// As [`Form::output`], faster and wider.
    ///
    /// Cost: one addition per monomial, for a state; else that of a step of order 0.
    ///
    /// Errors: those of [`Form::output`].
    pub fn strip(&self, output: &Output, inputs: &[Interval]) -> Result<Strip, Obstacle> {
        if let Some(state) = output.state {
            return Ok(self.straight(&self.states[state], self.frame.hull()[state]));
        }
        let (polynomial, radius) = self.evaluate(output, inputs)?;
        Ok(self.straight(&polynomial, Interval::symmetric(radius)))
    }

    /// Every state as in [`Form::strip`].
    pub fn strips(&self) -> Vec<Strip> {
        let states = self.states.iter().zip(self.frame.hull());
        states
            .map(|(polynomial, rest)| self.straight(polynomial, rest))
            .collect()
    }

    /// The affine part of a polynomial, and quick bounds of the rest with `rest`.
    ///
    /// A monomial of even exponents is never negative.
    pub(super) fn straight(&self, polynomial: &[f64], rest: Interval) -> Strip {
        let count = self.unknowns.len();
        let (mut below, mut above) = (0.0, 0.0);
        // Of those alone that are no products of two unknowns.
        let (mut under, mut over) = (0.0, 0.0);
        let mut products = Vec::new();
        for (a, x) in polynomial.iter().enumerate().skip(1 + count) {
            let is_product = self.is_product(a);
            if is_product {
                products.push(*x);
            }
            if *x == 0.0 {
                continue;
            }
            let even = self.monomials.is_even(a);
            let (down, up) = if even {
                ((-x).max(0.0), x.max(0.0))
            } else {
                (x.abs(), x.abs())
            };
            (below, above) = (below + down, above + up);
            if !is_product {
                (under, over) = (under + down, over + up);
            }
        }
        // What is zero stays so: a state that is held has its value exactly.
        let sum = |x: f64| {
            if x == 0.0 {
                0.0
            } else {
                raised(x, polynomial.len())
            }
        };
        let around = |below: f64, above: f64| {
            let curved = Interval::new(-sum(below), sum(above));
            curved.unwrap_or(Interval::ENTIRE) + rest
        };
        Strip {
            centre: polynomial[0],
            slopes: polynomial[1..=count].to_vec(),
            remainder: around(below, above),
            products,
            rest: around(under, over),
        }
    }

    /// Whether a monomial is the product of two unknowns, the square of one included.
    fn is_product(&self, monomial: usize) -> bool {
        let (own, fresh) = self
            .monomials
            .exponents(monomial)
            .split_at(self.unknowns.len());
        own.iter().sum::<u8>() == 2 && fresh.iter().all(|e| *e == 0)
    }

    /// The unknowns of which strips have the products, each pair in order; those of forms of degree one have none.
    pub fn products(&self) -> Vec<(usize, usize)> {
        let count = self.unknowns.len();
        let products = (1 + count..self.monomials.len()).filter(|a| self.is_product(*a));
        let pair = |a: usize| {
            let exponents = self.monomials.exponents(a).iter().enumerate();
            let mut own = exponents.flat_map(|(v, e)| (0..*e).map(move |_| v));
            Some((own.next()?, own.next()?))
        };
        products.filter_map(pair).collect()
    }

    /// A quantity as polynomial in the unknowns, and how far it can be from that.
    pub(super) fn evaluate(
        &self,
        output: &Output,
        inputs: &[Interval],
    ) -> Result<(Vec<f64>, f64), Obstacle> {
        let (code, functions) = (&output.code, &output.functions);
        let mut series = Series::new(code, &self.monomials, 0);
        for (register, step) in code.instructions.iter().enumerate() {
            match step.op {
                Op::Constant(value) => series.start(register, &[value.mid()]),
                Op::Param(i) => series.start(register, &self.params[i].polynomial),
                Op::Input(i) => series.start(register, &[inputs[i].mid()]),
                Op::State(i) => series.start(register, &self.states[i]),
                _ => {}
            }
        }
        let mut run = || -> Result<(Vec<f64>, f64), Trouble> {
            let done = series.compute((code, &self.monomials, functions), (0, 0));
            done.map_err(|_| Trouble::Undefined)?;
            let mut errors = Errors::new(code, &self.monomials, series.stride);
            let given = |op: Op| match op {
                Op::Constant(value) => value.rad(),
                Op::Param(i) => self.params[i].radius,
                Op::Input(i) => inputs[i].rad(),
                _ => 0.0,
            };
            let context = (code, &*self.monomials, functions);
            errors.measure(context, &series, (0.0, 0, 0), &given)?;
            let reach: Vec<f64> = self.frame.hull().iter().map(|x| x.mag()).collect();
            let mut radii = vec![0.0; code.instructions.len()];
            errors.radii(code, functions, &reach, &mut radii)?;
            let register = code.roots[0];
            let block = series.block(register).iter();
            let polynomial = block.step_by(series.stride).copied().collect();
            Ok((polynomial, radii[register]))
        };
        run().map_err(Obstacle::from)
    }

    /// Narrows the unknowns to those for which the quantity `output` of this form can lie in `measured`;
    /// returns whether anything became narrower.
    ///
    /// Guarantee: no solution with such a value is lost, now and later: the polynomials are written anew
    /// around the middle of the narrowed unknowns, so that states and unknowns stay related. What
    /// dependence could not keep is not touched.
    ///
    /// Errors: [`Contradiction`] where no value of the quantity lies in `measured`; that is a proof.
    pub fn contract(
        &mut self,
        output: &OutputForm,
        measured: Interval,
    ) -> Result<bool, Contradiction> {
        if !output.hull.intersects(measured) {
            return Err(Contradiction);
        }
        let target = measured - output.remainder - Interval::point(output.centre);
        let unit = Interval::symmetric(1.0);
        let mut parts = vec![unit; output.slopes.len()];
        for v in 0..parts.len() {
            let slope = output.slopes[v];
            if slope == 0.0 {
                continue;
            }
            let others = (0..parts.len()).filter(|l| *l != v);
            let rest = others.fold(target, |sum, l| {
                sum - Interval::point(output.slopes[l]) * parts[l]
            });
            parts[v] = parts[v].intersect(rest / Interval::point(slope));
            if parts[v].is_empty() {
                return Err(Contradiction);
            }
        }
        let narrower = parts.iter().any(|part| *part != unit);
        if narrower {
            self.narrow(&parts);
        }
        Ok(narrower)
    }

    /// Restricts the unknowns to parts of the unit box, and calls these the unit box.
    ///
    /// Guarantee: that of [`Form`], for solutions with unknowns in the parts.
    pub fn narrow(&mut self, parts: &[Interval]) {
        let mut lost = vec![0.0; self.states.len()];
        for (v, part) in parts.iter().enumerate() {
            if *part == Interval::symmetric(1.0) {
                continue;
            }
            let (middle, radius) = part.mid_rad();
            let range = &mut self.unknowns[v];
            range.middle += range.radius * Interval::point(middle);
            range.radius *= Interval::point(radius);
            for (polynomial, lost) in self.states.iter_mut().zip(&mut lost) {
                *lost += self.monomials.substitute(polynomial, v, middle, radius);
            }
            for param in self.params.iter_mut().chain(&mut self.within) {
                let off = self
                    .monomials
                    .substitute(&mut param.polynomial, v, middle, radius);
                param.radius = raised(param.radius + off, 1);
            }
        }
        // What stands on a level stays there to the last bit.
        let by = lost.iter().map(|x| {
            let off = if *x == 0.0 {
                0.0
            } else {
                raised(*x, parts.len())
            };
            Interval::symmetric(off)
        });
        let by: Vec<Interval> = by.collect();
        self.widen(&by);
    }

    /// From now on a parameter has another value: any in `offset + slopes·δ` for solutions that belong to `δ`.
    ///
    /// Guarantee: that of [`Form`] for such solutions.
    pub fn set_param(&mut self, param: usize, slopes: &[f64], offset: Interval) {
        let (middle, radius) = offset.mid_rad();
        let own = &mut self.params[param];
        own.polynomial.fill(0.0);
        own.polynomial[0] = middle;
        own.polynomial[1..=slopes.len()].copy_from_slice(slopes);
        own.radius = radius;
        // What was known of surfaces may have rested on the value before.
        self.signs.clear();
    }

    /// Adds a box to the states.
    pub(super) fn widen(&mut self, by: &[Interval]) {
        let n = self.states.len();
        let identity: Vec<Interval> = (0..n * n)
            .map(|i| Interval::point(if i % (n + 1) == 0 { 1.0 } else { 0.0 }))
            .collect();
        self.transport(&identity, &vec![0.0; n], by);
    }
}
