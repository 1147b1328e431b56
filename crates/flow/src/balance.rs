//! Balances: equations of a model, to be integrated against functions of time.
//!
//! Where a state `x` has the rate `w`, and `w' = A(p) w + r(x, p, u)` in every mode, every solution satisfies for every
//! absolutely continuous function `ψ` of time, by parts,
//!
//! > `[ψ w] - ∫ (ψ' + a ψ) w dt = (A(p) - a) ∫ ψ w dt + ∫ ψ r dt`
//!
//! with any number `a`. If `ψ' + a ψ` is constant for a while, the integral on the left is a difference of two values of
//! `x`, which may be measured. So what the parameters are is told by a few states at a few times and by bounds of `r`, though
//! inputs have any course and no set of solutions is ever moved: nothing grows on the way. Modulating functions
//! (Shinbrot 1957; Preisig and Rippin 1993) are functions `ψ` of this kind; that bounds are proved, for solutions
//! that switch, is own.
//!
//! What is told here are bounds of `A` and `r` as linear functions of the parameters.
//!
//! # Proof of these bounds
//!
//! Let `g` be a function of the parameters that is locally Lipschitz, `e` a corner of a box of parameters and `p` a point of it. Going from
//! `e` to `p` along one axis after the other (Hansen 1968),
//!
//! > `g(p) - g(e) = Σ_j s_j (p_j - e_j)`,
//!
//! where `s_j` is a generalised slope in the parameter `j` at a point whose first `j` coordinates are in the box, and the
//! others those of `e`. Since `p_j - e_j` has one sign on all of the box, the ends of `s_j` bound `g` from both sides by linear functions; for
//! a product of two parameters the four of two opposite corners are McCormick's. Where several modes may act, `w'` is for
//! almost all times in the convex hull of their rates (Filippov), at a point at which they act: one convex
//! combination of their values at `e`, and the same one of their slopes. Where `w` rests on a level `c` ([`Acting`]), `w'` is zero, and `r = -A c`.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: lists have the lengths of the model's layout"
)]

use crate::acting::Acting;
use crate::system::{System, demanded_equalities, put_levels};
use veribound_interval::Interval;
use veribound_interval::lanes::{Interval8, LANES};
use veribound_model::{ExprId, Graph, Layout, Model, Tape, Var};

/// Encloses a function of the parameters on a box of these, seen from a corner `e` of it.
///
/// Guarantee: for every `p` of the box the function, whatever else it depends on, lies in
/// `at + Σ slopes[j] (p_j - e_j)`.
///
/// Example: [`Balance`].
#[derive(Debug, Clone, PartialEq)]
pub struct FromCorner {
    /// At the corner.
    pub at: Interval,
    /// Per parameter.
    pub slopes: Vec<Interval>,
}

impl FromCorner {
    /// A function that is zero.
    pub fn zero(params: usize) -> FromCorner {
        FromCorner {
            at: Interval::ZERO,
            slopes: vec![Interval::ZERO; params],
        }
    }

    /// Adds a multiple of another function, seen from the same corner.
    pub fn add(&mut self, factor: Interval, other: &FromCorner) {
        self.at += factor * other.at;
        for (own, other) in self.slopes.iter_mut().zip(&other.slopes) {
            *own += factor * *other;
        }
    }

    fn hull(&mut self, other: &FromCorner) {
        self.at = self.at.hull(other.at);
        for (own, other) in self.slopes.iter_mut().zip(&other.slopes) {
            *own = own.hull(*other);
        }
    }
}

/// Bounds from the corner of all lower ends, and from that of all upper ends.
///
/// Example: [`Balance`].
pub type FromCorners = [FromCorner; 2];

/// A function with its derivatives in the parameters.
#[derive(Debug, Clone)]
struct Function {
    value: Tape,
    /// Parameters it depends on, and its derivatives in these.
    params: Vec<usize>,
    slopes: Tape,
}

impl Function {
    fn compile(graph: &mut Graph, layout: Layout, e: ExprId) -> Function {
        let variables = graph.variables(e).into_iter();
        let params = variables.filter_map(|var| match var {
            Var::Param(param) => Some(param),
            _ => None,
        });
        let params: Vec<usize> = params.collect();
        let slopes = params.iter();
        let slopes = slopes.map(|param| graph.derivative(e, Var::Param(*param)));
        let slopes: Vec<ExprId> = slopes.collect();
        Function {
            value: Tape::compile(graph, layout, &[e]),
            params,
            slopes: Tape::compile(graph, layout, &slopes),
        }
    }

    /// Nothing where it is not defined and continuous on all of the box.
    fn bounds(&self, layout: Layout, quantities: &[Interval]) -> Option<FromCorners> {
        let first = layout.states;
        let whole = &quantities[first..first + layout.params];
        let sides = [false, true];
        let all = sides.into_iter().flat_map(|upper| {
            let slopes = self.params.iter().map(|param| Some(*param));
            std::iter::once(None)
                .chain(slopes)
                .map(move |slope| (upper, slope))
        });
        let all: Vec<(bool, Option<usize>)> = all.collect();
        let mut both = [
            FromCorner::zero(layout.params),
            FromCorner::zero(layout.params),
        ];
        let (mut value, mut slopes) = (self.value.registers(), self.slopes.registers());
        for part in all.chunks(LANES) {
            // Of the box on which the slope in a parameter is asked for, or of the corner for the value there.
            let lane = |quantity: usize| {
                let x = quantities[quantity];
                let param = quantity.checked_sub(first).filter(|own| *own < whole.len());
                let Some(param) = param else {
                    return Interval8::splat(x);
                };
                Interval8::from_fn(|lane| {
                    let (upper, slope) = part.get(lane).unwrap_or(&part[0]);
                    if slope.is_some_and(|slope| param <= slope) {
                        x
                    } else {
                        Interval::point(if *upper { x.hi() } else { x.lo() })
                    }
                })
            };
            let eight: Vec<Interval8> = (0..quantities.len()).map(lane).collect();
            let is_continuous = self.value.eval(&eight, &mut value).is_continuous();
            let are_defined = self.slopes.eval(&eight, &mut slopes).is_defined();
            for (lane, (upper, slope)) in part.iter().enumerate() {
                if !(is_continuous & are_defined).get(lane) {
                    return None;
                }
                let own = &mut both[usize::from(*upper)];
                match slope {
                    None => own.at = self.value.output(0, &value).get(lane),
                    Some(param) => {
                        let position = self.params.iter().position(|own| own == param)?;
                        own.slopes[*param] = self.slopes.output(position, &slopes).get(lane);
                    }
                }
            }
        }
        let bounded = |own: &FromCorner| {
            own.at.is_bounded() && own.slopes.iter().all(|slope| slope.is_bounded())
        };
        both.iter().all(bounded).then_some(both)
    }
}

/// The equation of a rate, `w' = A(p) w + r`, with `x' = w`.
///
/// ```
/// use veribound_flow::Acting;
/// use veribound_flow::balance::{Balance, FromCorner, FromCorners};
/// use veribound_interval::Interval;
///
/// let text = r#"
///     format = 1
///     states = ["x", "w"]
///     inputs = ["u"]
///     init = { x = 0, w = 0 }
///     params = { a = [-2, -1], b = [3, 5] }
///     der = { x = "w", w = "a*w + b*u" }
///     outputs.y = "x +- 0.1"
/// "#;
/// let model = veribound_model::Model::from_text("m.toml", text)?;
/// let balances = Balance::of(&model);
/// let balance = &balances[0];
/// assert_eq!((balance.state(), balance.rate()), (0, 1));
/// let mut one = Acting::default();
/// one.modes.insert(0);
/// let params = [Interval::new(-2.0, -1.0).unwrap(), Interval::new(3.0, 5.0).unwrap()];
/// let states = [Interval::ENTIRE, Interval::new(0.0, 1.0).unwrap()];
/// let inputs = [Interval::point(0.5)];
/// // `b u` from b = 3 on, whatever the states are.
/// let rest: FromCorners = balance.rest((&states, &params, &inputs), &one).unwrap();
/// let low: &FromCorner = &rest[0];
/// assert_eq!((low.at, low.slopes[1]), (Interval::point(1.5), Interval::point(0.5)));
/// let [low, _] = balance.factor(&params).unwrap();
/// assert_eq!((low.at, low.slopes[0]), (Interval::point(-2.0), Interval::ONE));
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone)]
pub struct Balance {
    layout: Layout,
    state: usize,
    rate: usize,
    factor: Function,
    /// `r` of every mode that governs the rate.
    rests: Vec<(usize, Function)>,
    /// The states and inputs, as quantities, that any of these depends on.
    needs: Vec<usize>,
}

impl Balance {
    /// The balances of a model: one for every state that is the integral of another one, of which neither jumps.
    pub fn of(model: &Model) -> Vec<Balance> {
        let mut graph = model.graph.clone();
        let system = System::new(model);
        let pairs = system.integrals().iter();
        let pairs = pairs.filter(|pair| !model.jumps_in(pair.rate));
        pairs
            .map(|pair| Balance::compile(&mut graph, model, (pair.state, pair.rate)))
            .collect()
    }

    fn compile(graph: &mut Graph, model: &Model, (state, rate): (usize, usize)) -> Balance {
        let layout = model.layout();
        let zero = graph.integer(0);
        let modes: Vec<(usize, ExprId)> = model.governing(rate).collect();
        let slopes: Vec<ExprId> = modes
            .iter()
            .map(|(_, rhs)| graph.derivative(*rhs, Var::State(rate)))
            .collect();
        let is_constant = |e: &&ExprId| {
            let mut variables = graph.variables(**e).into_iter();
            **e != zero && variables.all(|var| matches!(var, Var::Param(_)))
        };
        let factor = slopes.iter().find(is_constant).copied().unwrap_or(zero);
        let own = graph.var(Var::State(rate));
        let mut needs = Vec::new();
        let rests = modes.iter().zip(slopes).map(|((mode, rhs), slope)| {
            let rest = if slope == factor {
                graph.substitute(*rhs, &|var| (var == Var::State(rate)).then_some(zero))
            } else {
                let product = graph.mul(factor, own);
                graph.sub(*rhs, product)
            };
            // Where a mode acts, the states that its guard demands to be on a level are there.
            let mut levels = Vec::new();
            demanded_equalities(graph, &model.modes[*mode].guard, &mut levels);
            let rest = put_levels(graph, rest, &levels);
            needs.extend(
                graph
                    .variables(rest)
                    .into_iter()
                    .filter_map(|var| match var {
                        Var::State(state) => Some(state),
                        Var::Input(input) => Some(layout.states + layout.params + input),
                        _ => None,
                    }),
            );
            (*mode, Function::compile(graph, layout, rest))
        });
        let rests = rests.collect();
        needs.sort_unstable();
        needs.dedup();
        Balance {
            layout,
            state,
            rate,
            rests,
            needs,
            factor: Function::compile(graph, layout, factor),
        }
    }

    /// The state `x`.
    pub fn state(&self) -> usize {
        self.state
    }

    /// Its rate `w`.
    pub fn rate(&self) -> usize {
        self.rate
    }

    /// Bounds of `A`; nothing where it is not defined and continuous.
    pub fn factor(&self, params: &[Interval]) -> Option<FromCorners> {
        let mut quantities = vec![Interval::ENTIRE; self.layout.len()];
        quantities[self.layout.states..][..params.len()].copy_from_slice(params);
        self.factor.bounds(self.layout, &quantities)
    }

    /// Whether the bounds of `r` are the same for these states and inputs as for those, whatever the parameters are.
    pub fn are_alike(
        &self,
        (states, inputs): (&[Interval], &[Interval]),
        (other_states, other_inputs): (&[Interval], &[Interval]),
    ) -> bool {
        let first = self.layout.states + self.layout.params;
        self.needs.iter().all(|need| match need.checked_sub(first) {
            Some(input) => inputs[input] == other_inputs[input],
            None => states[*need] == other_states[*need],
        })
    }

    /// Bounds of `r` while states, parameters and inputs are in these boxes, and this acts on the rate; nothing where it is
    /// not defined and continuous.
    pub fn rest(
        &self,
        (states, params, inputs): (&[Interval], &[Interval], &[Interval]),
        acting: &Acting,
    ) -> Option<FromCorners> {
        let quantities = [states, params, inputs].concat();
        let mut hull: Option<FromCorners> = None;
        let mut join = |own: FromCorners| match &mut hull {
            Some(hull) => hull.iter_mut().zip(&own).for_each(|(a, b)| a.hull(b)),
            None => hull = Some(own),
        };
        for (mode, rest) in &self.rests {
            if acting.modes.contains(*mode) {
                join(rest.bounds(self.layout, &quantities)?);
            }
        }
        for level in &acting.levels {
            let factor = self.factor(params)?;
            join(factor.map(|side| {
                let mut own = FromCorner::zero(self.layout.params);
                own.add(Interval::point(-level), &side);
                own
            }));
        }
        hull
    }

    /// Bounds of `w'` under the same conditions.
    pub fn bend(
        &self,
        (states, params, inputs): (&[Interval], &[Interval], &[Interval]),
        acting: &Acting,
    ) -> Option<Interval> {
        let range = |both: &FromCorners| {
            let ends = [Interval::lo, Interval::hi];
            let pairs = both.iter().zip(ends);
            pairs.fold(Interval::ENTIRE, |range, (side, end)| {
                let slopes = side.slopes.iter().zip(params);
                let side = slopes.fold(side.at, |sum, (slope, param)| {
                    sum + *slope * (*param - Interval::point(end(*param)))
                });
                range.intersect(side)
            })
        };
        let mut bend = Interval::EMPTY;
        if !acting.levels.is_empty() {
            bend = Interval::ZERO;
        }
        if !acting.modes.is_empty() {
            let moving = Acting {
                modes: acting.modes,
                levels: Vec::new(),
            };
            let rest = self.rest((states, params, inputs), &moving)?;
            let factor = self.factor(params)?;
            bend = bend.hull(range(&factor) * states[self.rate] + range(&rest));
        }
        Some(bend)
    }
}
