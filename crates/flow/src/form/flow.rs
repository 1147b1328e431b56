//! A model compiled for forms.
#![allow(clippy::indexing_slicing, reason = "PROOF: one entry per state")]

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::closed::{Linear, balanced, slopes_of};
use super::journey::{Journey, Meeting};
use super::output::Output;
use super::piece::{Piece, Shape, drift, gradient};
use super::proved::Outputs;
use super::regime::{Field, Regime, Switching, Watch};
use super::run::Stretch;
use super::set::{Form, FormOptions, Parallelotope};
use super::step::Obstacle;
use super::surfaces::Signs;
use crate::modes::ModeSet;
use crate::step::{StepOptions, Workspace};
use crate::system::System;
use veribound_interval::Interval;
use veribound_model::{ExprId, Graph, Layout, Model, Var};

/// A model compiled for forms. Shared between threads; right-hand sides of modes are compiled when they
/// are first met.
///
/// ```
/// use veribound_flow::form::{BoxAfter, Flow, FormOptions, Stretch};
/// use veribound_interval::Interval;
///
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1.1]\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let (start, params) = ([model.states[0].init], [model.params[0].bounds]);
/// let flow = Flow::new(&model);
/// let mut form = flow.start(&start, &params, FormOptions::default());
/// flow.advance(&mut form, &[], Interval::ONE).map_err(|stopped| format!("{stopped:?}"))?;
/// assert!(form.hull()[0].contains((-0.7_f64).exp()) && form.hull()[0].width() < 0.35);
/// // A box forgets that all solutions have one value of k each.
/// let second = Stretch { inputs: vec![], dt: Interval::ONE };
/// let BoxAfter { states, rests } = flow.box_after(&start, &params, &second).unwrap();
/// assert!(form.hull()[0].is_subset_of(states[0]) && !rests);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Flow {
    pub(super) layout: Layout,
    pub(super) switching: Switching,
    pub(super) outputs: Outputs,
    /// The boxes that go on where no smooth right-hand side is certain.
    pub(super) system: System,
    /// The right-hand side of a model that never switches.
    only: Option<Regime>,
    store: Mutex<Store>,
}

/// Where solutions from a box are after a stretch.
///
/// Example: [`Flow`].
#[derive(Debug, Clone, PartialEq)]
pub struct BoxAfter {
    /// Encloses every state.
    pub states: Vec<Interval>,
    /// Proved: each solution stays where it starts, for all that time.
    pub rests: bool,
}

/// What is made on demand.
#[derive(Debug)]
struct Store {
    graph: Graph,
    pieces: HashMap<Shape, Arc<Piece>>,
    /// Of right-hand sides that are affine in the states.
    linear: HashMap<Shape, Option<Arc<Linear>>>,
    quantities: HashMap<ExprId, Arc<Output>>,
}

/// A stretch of time could not be proved. It says nothing about the existence of solutions.
///
/// ```
/// use veribound_flow::form::{Diverged, Flow, FormOptions, Obstacle};
/// use veribound_interval::Interval;
///
/// // x' = x² from 1 is infinite after a second.
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nder.x = \"x^2\"\noutputs.y = \"x +- 0.01\"";
/// let model = veribound_model::Model::from_text("m.toml", text)?;
/// let flow = Flow::new(&model);
/// let mut form = flow.start(&[Interval::ONE], &[], FormOptions::default());
/// let stopped: Diverged = flow.advance(&mut form, &[], Interval::point(2.0)).unwrap_err();
/// assert!(stopped.reached.hi() < 1.0 && stopped.state == 0);
/// assert_ne!(stopped.obstacle, Obstacle::Jump);
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Diverged {
    /// Why.
    pub obstacle: Obstacle,
    /// Where the width is largest, compared to what it was at the start of the stretch.
    pub state: usize,
    /// Time since the start up to which the form was moved.
    pub reached: Interval,
}

impl Flow {
    /// Compiles `model`.
    ///
    /// Cost: that of [`System::new`], and one symbolic derivative per pair of states and right-hand side that
    /// is met.
    pub fn new(model: &Model) -> Flow {
        let mut graph = model.graph.clone();
        let switching = Switching::compile(&mut graph, model);
        let only = match &switching.rates[..] {
            [mode] if switching.sets.is_empty() => {
                let rates: Vec<ExprId> = mode.iter().map(|rate| rate.1).collect();
                Some(Regime {
                    has_kinks: rates.iter().any(|rate| graph.has_kinks(*rate)),
                    rates,
                    watches: Vec::new(),
                    modes: all_modes(model),
                    signs: Vec::new(),
                    bars: Vec::new(),
                })
            }
            _ => None,
        };
        Flow {
            layout: model.layout(),
            outputs: Outputs::compile(&mut graph, model),
            switching,
            system: System::new(model),
            only,
            store: Mutex::new(Store {
                graph,
                pieces: HashMap::new(),
                linear: HashMap::new(),
                quantities: HashMap::new(),
            }),
        }
    }

    /// The form of all start values in `states` and parameters in `params`.
    ///
    /// Quantities whose width is not negligible become unknowns that dependence is kept on.
    pub fn start(&self, states: &[Interval], params: &[Interval], options: FormOptions) -> Form {
        Form::new(states, params, options)
    }

    /// The form of a parallelotope of start values and parameters, whose axes become its unknowns.
    pub fn start_in(&self, set: &Parallelotope, options: FormOptions) -> Form {
        Form::of(self.layout.states, set, options)
    }

    /// Moves a form over `dt` seconds, in as many steps as it takes.
    ///
    /// Guarantee: for all unknowns, and for inputs that are any measurable functions of time in
    /// `inputs`, every solution of the model exists that long and lies in the form afterwards, and in
    /// [`Form::tube`] at all times between; the end may lie anywhere in `dt`. On failure the form stands
    /// where it was.
    ///
    /// Errors: [`Diverged`] where no step could be proved.
    pub fn advance(
        &self,
        form: &mut Form,
        inputs: &[Interval],
        dt: Interval,
    ) -> Result<(), Diverged> {
        let stretch = Stretch {
            inputs: inputs.to_vec(),
            dt,
        };
        let mut journey = Journey::new(self, form.clone(), std::slice::from_ref(&stretch));
        journey.whole_at_end = true;
        journey.run()?;
        let tube = journey.proved.tubes.pop();
        *form = journey.form;
        form.tube = tube.unwrap_or_else(|| form.quick_hull());
        Ok(())
    }

    /// Moves a form through stretches, and shows it to `meet` wherever one begins and at the end of the last;
    /// `go_on` is asked at every step whether to go on.
    ///
    /// Guarantee: that of [`Meeting`], for inputs that are any measurable functions in those of the
    /// stretches. What `meet` narrows is narrowed from then on: solutions outside are no longer enclosed. On
    /// failure what was met before stays proved.
    ///
    /// Errors: [`Diverged`] where no step could be proved.
    pub fn follow(
        &self,
        form: Form,
        stretches: &[Stretch],
        meet: &mut dyn FnMut(Meeting<'_>),
        go_on: &dyn Fn(&Form) -> bool,
    ) -> Result<(), Diverged> {
        let mut journey = Journey::new(self, form, stretches);
        journey.whole_at_end = true;
        journey.go_on = go_on;
        journey.meet = Some(meet);
        journey.run()
    }

    /// Whether the state can jump at all.
    pub fn has_jumps(&self) -> bool {
        !self.switching.sets.is_empty()
    }

    /// Whether a solution of the form may jump at once, with inputs in these.
    pub fn may_jump(&self, form: &Form, inputs: &[Interval]) -> bool {
        if !self.has_jumps() {
            return false;
        }
        let quantities = [&form.hull()[..], &form.param_box(), inputs].concat();
        let field = self.switching.field(&quantities);
        field.is_none_or(|field| self.switching.jump_possible(&field.signs()))
    }

    /// Encloses by a box where solutions from a box of states are after a stretch, with all parameters of another
    /// box; `None` where that could not be proved.
    pub fn box_after(
        &self,
        states: &[Interval],
        params: &[Interval],
        stretch: &Stretch,
    ) -> Option<BoxAfter> {
        let mut workspace = Workspace::new(&self.system, StepOptions::default());
        let mut states = states.to_vec();
        let (inputs, dt) = (&stretch.inputs, stretch.dt);
        let moved = self
            .system
            .step(&mut states, params, inputs, dt, &mut workspace);
        moved.ok()?;
        // On the tube itself velocities are narrower than on the box that it was proved with.
        let inside = (!self.has_jumps())
            .then(|| self.system.velocity_in_tube(&mut workspace))
            .flatten();
        let inside = inside.as_deref().unwrap_or(workspace.velocity());
        let both = workspace.tube().iter().zip(inside);
        let mut rests = both.map(|(tube, velocity)| tube.is_point() || *velocity == Interval::ZERO);
        Some(BoxAfter {
            rests: rests.all(|rests| rests),
            states,
        })
    }

    /// The model compiled for boxes.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// Encloses the outputs wherever they are defined on a box of states, parameters and inputs.
    pub(crate) fn outputs_on(&self, quantities: &[Interval]) -> Vec<Interval> {
        self.outputs.on_box(quantities)
    }

    /// The regime on a box of states, parameters and inputs.
    pub(super) fn resolve(&self, field: Option<&Field>, signs: &[Signs]) -> Option<Regime> {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(only) = &self.only {
            let mut regime = only.clone();
            if let (Some(field), true) = (field, only.has_kinks) {
                self.switching
                    .straighten(&mut store.graph, field, None, &mut regime);
            }
            return Some(regime);
        }
        self.switching
            .resolve(&mut store.graph, field?, signs.to_vec())
    }

    /// As [`Flow::resolve`], with all kinks in place.
    pub(super) fn unbent(&self, field: &Field, signs: &[Signs]) -> Option<Regime> {
        if self.only.is_some() {
            return self.only.clone();
        }
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        self.switching
            .unbent(&mut store.graph, field, signs.to_vec())
    }

    /// Takes the kinks out of a regime whose sides are known on the box of `field`, or given.
    pub(super) fn straighten(&self, field: &Field, known: (ExprId, Signs), regime: &mut Regime) {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        self.switching
            .straighten(&mut store.graph, field, Some(known), regime);
    }

    /// True if there is one right-hand side without kinks, and no jump.
    pub(super) fn is_smooth(&self) -> bool {
        self.only.as_ref().is_some_and(|only| !only.has_kinks)
    }

    /// The code of a regime.
    pub(super) fn piece(&self, regime: &Regime) -> Arc<Piece> {
        let watched = regime.watches.iter().map(|watch| watch.expr);
        let shape = self.shape(regime, watched.collect());
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let store = &mut *store;
        if let Some(piece) = store.pieces.get(&shape) {
            return Arc::clone(piece);
        }
        let piece = Arc::new(Piece::compile(&mut store.graph, self.layout, &shape));
        store.pieces.insert(shape, Arc::clone(&piece));
        piece
    }

    /// A regime as affine function of the states; `None` if it is not.
    pub(super) fn linear(&self, regime: &Regime) -> Option<Arc<Linear>> {
        let shape = self.shape(regime, Vec::new());
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let store = &mut *store;
        if let Some(known) = store.linear.get(&shape) {
            return known.clone();
        }
        let linear = Linear::compile(&mut store.graph, self.layout, &shape).map(Arc::new);
        store.linear.insert(shape, linear.clone());
        linear
    }

    fn shape(&self, regime: &Regime, watched: Vec<ExprId>) -> Shape {
        let surfaces = self.switching.surfaces.list.iter().zip(&regime.signs);
        let held = surfaces.filter(|(_, signs)| **signs == Signs::ZERO);
        let held = held.filter_map(|(surface, _)| surface.level);
        Shape {
            rates: regime.rates.clone(),
            watched,
            held: held.map(|level| (level.state, level.expr)).collect(),
        }
    }

    /// A state whose rate is not affine in the states, in some mode and on some side of its kinks; `None` where all
    /// are.
    pub fn curved(&self) -> Option<usize> {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let graph = &mut store.graph;
        let mut rates = self.switching.rates.iter().flatten();
        let curved = rates.find(|(_, rate)| {
            [true, false].into_iter().any(|side| {
                let straight = graph.straightened(*rate, &mut |_, _| Some(side));
                slopes_of(graph, straight).is_none()
            })
        });
        curved.map(|(state, _)| *state)
    }

    /// About how fast states of an affine model change each other in the middle of a set, in its fastest modes:
    /// the spectral radius of the absolute values of their slopes, per second. A hint.
    ///
    /// `None` where some rate is not affine in the states.
    pub fn steepness(&self, quantities: &[Interval]) -> Option<f64> {
        if self.curved().is_some() {
            return None;
        }
        let (n, layout) = (self.layout.states, self.layout);
        let value = |var: Var| {
            let all = quantities.get(layout.index(var));
            Interval::point(all.map_or(0.0, |x| x.mid()))
        };
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let graph = &mut store.graph;
        let mut slopes = vec![0.0_f64; n * n];
        for (state, rate) in self.switching.rates.iter().flatten() {
            let straight = graph.straightened(*rate, &mut |_, _| Some(true));
            for (by, slope) in slopes_of(graph, straight)? {
                let size = graph.eval_interval(slope, &value).mag();
                let entry = &mut slopes[state * n + by];
                *entry = entry.max(size);
            }
        }
        Some(balanced(n, &slopes).1)
    }

    /// An expression to be evaluated on forms.
    pub(super) fn quantity(&self, e: ExprId) -> Arc<Output> {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let store = &mut *store;
        let known = store.quantities.entry(e);
        Arc::clone(known.or_insert_with(|| {
            let states = self.layout.states;
            Arc::new(Output::compile(&mut store.graph, states, e))
        }))
    }

    /// What must be watched so that modes drive back from the side of a surface, which is held in `regime`, that a jump bars, too; but not
    /// `known`. Nothing, where no jump does.
    pub(super) fn back_from_bar(
        &self,
        surface: usize,
        regime: &Regime,
        known: Option<ExprId>,
    ) -> Option<Vec<Watch>> {
        let Some(bar) = regime.bars.iter().find(|bar| bar.0 == surface) else {
            return Some(Vec::new());
        };
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let graph = &mut store.graph;
        self.switching.back_from(graph, *bar, &regime.signs, known)
    }

    /// The rate of change of a surface in a mode, where that governs all states that the surface depends on.
    pub(super) fn drift_in(&self, surface: usize, mode: usize) -> Option<ExprId> {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        self.switching.drift_in(&mut store.graph, surface, mode)
    }

    /// How fast an expression changes along the right-hand side of a regime.
    pub(super) fn rate_of(&self, e: ExprId, regime: &Regime) -> ExprId {
        let mut store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let graph = &mut store.graph;
        let slopes = gradient(graph, e);
        drift(graph, &slopes, &|state| regime.rates[state])
    }

    /// The inputs that an expression depends on.
    pub(super) fn inputs_of(&self, e: ExprId) -> Vec<usize> {
        let store = self.store.lock().unwrap_or_else(PoisonError::into_inner);
        let inputs = store.graph.variables(e).into_iter();
        let inputs = inputs.filter_map(|var| match var {
            Var::Input(i) => Some(i),
            _ => None,
        });
        inputs.collect()
    }
}

fn all_modes(model: &Model) -> ModeSet {
    let mut all = ModeSet::EMPTY;
    (0..model.modes.len()).for_each(|mode| all.insert(mode));
    all
}

#[cfg(test)]
#[allow(clippy::panic, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// Where it is decided which piece of a table acts, nothing of the others is computed.
    #[test]
    fn a_decided_table_is_short() {
        let points: Vec<String> = (0..20).map(|k| format!("{k}, {}", k * k)).collect();
        let text = format!(
            "format = 1\nstates = [\"x\"]\n[init]\nx = 0\n[der]\nx = \"table(x, {})\"\n[outputs]\nm = \"x +- 1\"\n",
            points.join(", ")
        );
        let model = Model::from_text("table", &text);
        let model = model.unwrap_or_else(|problems| panic!("{}", problems.render(false)));
        let flow = Flow::new(&model);
        let size = |lo: f64, hi: f64| {
            let x = Interval::new(lo, hi).unwrap_or(Interval::ENTIRE);
            let field = flow.switching.field(&[x]);
            let regime = flow.resolve(field.as_ref(), &[]);
            let regime = regime.unwrap_or_else(|| panic!("one right-hand side"));
            flow.piece(&regime).code.instructions.len()
        };
        let (decided, one_kink, open) = (size(4.2, 4.8), size(4.8, 5.1), size(0.0, 19.0));
        assert!(
            10 * decided < open && 5 * one_kink < open,
            "{decided} {one_kink} {open}"
        );
    }
}
