//! A form on its way through stretches of time, from one right-hand side to the next.
//!
//! While one smooth right-hand side is certain (`regime.rs`), steps are those of [`super`]. When an expression
//! that is watched may change its sign, a step ends before; then all solutions are taken across together,
//! each at its own time (`crossing.rs`). Where that is not possible, as where some solutions graze or nothing
//! is decided, boxes go on for a moment (`mixed.rs`).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per state, stretch or input, from the same lists"
)]

use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::Arc;

use super::allowance::Allowance;
use super::closed::Chains;
use super::creeping::Creep;
use super::flow::{Diverged, Flow};
use super::output::Strip;
use super::parting::{Portion, Undecided};
use super::piece::Piece;
use super::proved::{Mark, Proved};
use super::regime::{Field, Reason, Regime};
use super::run::Stretch;
use super::set::Form;
use super::several::{Ahead, Reach, Several};
use super::step::{Arrival, End, Obstacle, Prepared, Scratch};
use super::surfaces::Signs;
use super::watching::{Look, Search, Trouble};
use crate::step::Workspace;
use veribound_interval::Interval;
use veribound_model::Level;

/// Shortest step, as share of the time to go.
const SHORTEST: f64 = 1e-7;

/// A step that ends before something may change its sign is worth it when it is this share of the time
/// that the crossing will take.
const APPROACH: f64 = 0.5;

/// A crossing begins so much earlier than the first solution may meet the surface, as share of the time that all
/// of them take: the times of crossings are polynomials, which may be early.
const SLACK: f64 = 0.3;

/// What a step takes, in multiplications of polynomials,
const STEP: f64 = 4.0;

/// what one takes that was prepared before,
const AHEAD: f64 = 2.0;

/// and what a window takes in which a sign is asked, in products for each coefficient.
const WINDOW: f64 = 40.0;

/// A regime, compiled, with scratch for the form at hand.
pub(super) struct Acting {
    pub(super) regime: Regime,
    pub(super) piece: Arc<Piece>,
    pub(super) scratch: Scratch,
    /// Inputs that the watches depend on.
    inputs: Vec<Vec<usize>>,
    /// Inputs that what is held depends on.
    held: Vec<usize>,
    /// Whether the closed form may take it further in this stretch.
    leaps: bool,
}

impl Acting {
    pub(super) fn new(flow: &Flow, regime: Regime, form: &Form) -> Acting {
        let piece = flow.piece(&regime);
        let watches = regime.watches.iter();
        let surfaces = flow.switching.surfaces.list.iter().zip(&regime.signs);
        let held = surfaces.filter(|(_, signs)| **signs == Signs::ZERO);
        Acting {
            held: held.flat_map(|(s, _)| s.inputs.iter().copied()).collect(),
            inputs: watches.map(|watch| flow.inputs_of(watch.expr)).collect(),
            scratch: Scratch::new(&piece, form),
            leaps: form.options.closed,
            regime,
            piece,
        }
    }

    /// A prepared step of at most `longest`.
    pub(super) fn prepare(
        &mut self,
        form: &Form,
        inputs: &[Interval],
        longest: Interval,
        shortest: f64,
    ) -> Result<Prepared, Obstacle> {
        let none = vec![0.0; form.states.len()];
        let given = (inputs, &none[..]);
        self.piece
            .prepare(form, &mut self.scratch, given, longest, shortest)
    }

    /// For every watch whether it is a function of the state alone.
    pub(super) fn steady(&self, inputs: &[Interval]) -> Vec<bool> {
        let exact = |list: &Vec<usize>| list.iter().all(|input| inputs[*input].is_point());
        self.inputs.iter().map(exact).collect()
    }

    /// Whether what is held stays where it is: a surface that an input moves lets go.
    pub(super) fn holds_on(&self, inputs: &[Interval]) -> bool {
        self.held.iter().all(|input| inputs[*input].is_point())
    }

    /// Whether neither what is watched nor what is held is moved by an input.
    pub(super) fn is_of_states(&self, watch: usize) -> bool {
        self.held.is_empty() && self.inputs[watch].is_empty()
    }

    /// Whether it may end with the next values of the inputs.
    pub(super) fn depends_on_inputs(&self) -> bool {
        !self.held.is_empty() || self.inputs.iter().any(|inputs| !inputs.is_empty())
    }
}

/// A place on the way of a form.
pub(super) struct Place {
    pub(super) form: Form,
    pub(super) current: usize,
    left: Interval,
    begin: Interval,
    before: Vec<Interval>,
    proved: Mark,
}

/// A form at the end of a stretch, and where it is.
pub(super) struct Ended {
    pub(super) states: Vec<Vec<f64>>,
    pub(super) rest: Vec<Interval>,
    pub(super) hull: Vec<Interval>,
}

/// So many of the last places are remembered.
const REMEMBERED: usize = 4;

/// All solutions of a form at the begin of a stretch, or at the end of the last.
///
/// Guarantee: every solution of the form lies in it at that time.
///
/// ```
/// use veribound_flow::form::{Arriving, Contradiction, Flow, FormOptions, Meeting, Output, OutputForm, Strip, Stretch};
/// use veribound_interval::Interval;
///
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1.1]\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let (start, params) = ([model.states[0].init], [model.params[0].bounds]);
/// let flow = Flow::new(&model);
/// let output = Output::new(&model, model.outputs[0].expr);
/// let second = [Stretch { inputs: vec![], dt: Interval::ONE }];
/// let form = flow.start(&start, &params, FormOptions::default());
/// let (mut left, mut captured) = (Vec::new(), 0);
/// let mut meet = |meeting: Meeting<'_>| {
///     let arriving: &Option<Arriving> = &meeting.arriving;
///     captured += usize::from(arriving.is_some());
///     if meeting.stretch == 1 {
///         let strip: Strip = meeting.form.strip(&output, &[]).unwrap();
///         let exact: OutputForm = meeting.form.output(&output, &[]).unwrap();
///         assert_eq!(strip.slopes.len(), exact.slopes.len());
///         // A measurement of 0.5 +- 0.01 after a second narrows k.
///         let measured = Interval::point(0.5).inflate(0.01);
///         let narrowed: Result<bool, Contradiction> = meeting.form.contract(&exact, measured);
///         assert_eq!(narrowed, Ok(true));
///         left = meeting.form.param_box();
///     }
/// };
/// flow.follow(form, &second, &mut meet, &|_| true).map_err(|stopped| format!("{stopped:?}"))?;
/// assert!(left[0].contains(0.7) && left[0].width() < 0.45 && captured == 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Meeting<'a> {
    /// Number of stretches behind.
    pub stretch: usize,
    /// The form, which may be narrowed ([`Form::narrow`], [`Form::contract`]): then the rest is about what is left.
    pub form: &'a mut Form,
    /// Whether it is a copy on the way across a surface, which some solutions have passed and others have not;
    /// that it is narrowed is forgotten.
    pub is_passing: bool,
    /// The state that is captured by that surface, if one is.
    pub arriving: Option<Arriving>,
}

/// A state on its way to a level that captures it, each solution at a time of its own.
///
/// Guarantee: a solution is on the level at that time if and only if the state without capture, which lies in
/// `ahead`, is on the level or beyond it. For before the crossing the state is on this side; and the state without
/// capture moves one way at all times of the window, beyond the level too (`crossing.rs`).
///
/// Example: [`Meeting`].
#[derive(Debug, Clone, PartialEq)]
pub struct Arriving {
    /// Position of the state.
    pub state: usize,
    /// The level.
    pub level: Interval,
    /// The state without capture, as function of the unknowns.
    pub ahead: Strip,
    /// Solutions come from above.
    pub from_above: bool,
}

/// A form and how far it has come.
pub(super) struct Journey<'a> {
    pub(super) flow: &'a Flow,
    pub(super) stretches: &'a [Stretch],
    pub(super) form: Form,
    /// The stretch at hand, and what is left of it.
    pub(super) current: usize,
    pub(super) left: Interval,
    /// The stretch before which it ends.
    pub(super) until: usize,
    /// Whether the form itself must be at the end of the last stretch, and not only a box around it.
    pub(super) whole_at_end: bool,
    /// It is a failure when the share of a width that is no function of the unknowns passes this.
    pub(super) most: f64,
    pub(super) proved: Proved,
    /// Asked at every step whether to go on.
    pub(super) go_on: &'a (dyn Fn(&Form) -> bool + Sync),
    /// Work that may be done before it is put aside.
    pub(super) allowance: Option<&'a Allowance>,
    /// Shown the form wherever a stretch begins, and at the end of the last one.
    pub(super) meet: Option<&'a mut (dyn FnMut(Meeting<'_>) + Send + Sync)>,
    /// Forms at begins of stretches that the last crossing went over.
    pub(super) passed_by: Vec<(usize, Form, Option<Arriving>)>,
    /// Whether outputs are told, too.
    pub(super) tells_outputs: bool,
    pub(super) acting: Option<Acting>,
    /// A regime that acts now, for want of a better one.
    certain: Option<Acting>,
    pub(super) workspace: Option<Workspace>,
    /// Length of the next step where nothing is decided: a hint.
    pub(super) moment: f64,
    /// How much each unknown decides when surfaces are met that could not be crossed.
    pub(super) torn: Vec<f64>,
    /// Closed forms that were met.
    pub(super) chains: Chains,
    /// How many parts a set may be divided into where outcomes part.
    pub(super) may_part: usize,
    /// How many parts there are besides.
    pub(super) others: usize,
    /// Whether outcomes part somewhere in this set, so near to everywhere that no smaller part is worth it.
    pub(super) is_border: bool,
    /// The last places on the way through one regime.
    pub(super) earlier: VecDeque<Place>,
    /// Where outcomes part, if a crossing failed for that.
    pub(super) undecided: Option<Undecided>,
    /// The parts, if the form was divided instead of moved.
    pub(super) parts: Vec<Journey<'a>>,
    /// Solutions that may creep away from where they stand.
    pub(super) creep: Option<Creep>,
    /// The end of the last stretch: what stands need not be bounded again.
    pub(super) ended: Option<Ended>,
    /// A step that was prepared for more stretches,
    pub(super) ahead: Option<Ahead>,
    /// and for how many the next one is.
    pub(super) several: Several,
    pub(super) begin: Interval,
    before: Vec<Interval>,
}

impl<'a> Journey<'a> {
    pub(super) fn new(flow: &'a Flow, form: Form, stretches: &'a [Stretch]) -> Journey<'a> {
        let mut journey = Journey {
            begin: form.elapsed,
            before: form.quick_hull(),
            torn: vec![0.0; form.unknowns.len()],
            chains: Chains::default(),
            may_part: 1,
            others: 0,
            is_border: false,
            earlier: VecDeque::new(),
            undecided: None,
            parts: Vec::new(),
            creep: None,
            ended: None,
            ahead: None,
            several: Several::new(),
            flow,
            stretches,
            form,
            current: 0,
            left: Interval::ZERO,
            until: stretches.len(),
            whole_at_end: false,
            most: f64::INFINITY,
            proved: Proved::default(),
            go_on: &|_| true,
            allowance: None,
            meet: None,
            passed_by: Vec::new(),
            tells_outputs: false,
            acting: None,
            certain: None,
            workspace: None,
            moment: f64::INFINITY,
        };
        journey.enter(0);
        journey
    }

    /// Tells outputs, too, from the start on.
    pub(super) fn telling_outputs(mut self) -> Journey<'a> {
        self.tells_outputs = true;
        if !self.stretches.is_empty() {
            let outputs = self.outputs_now(&self.form.hull());
            self.proved.begin(outputs);
        }
        self
    }

    /// Encloses the outputs at the start of the stretch at hand, where the form is in `states`.
    fn outputs_now(&self, states: &[Interval]) -> Vec<Interval> {
        if !self.tells_outputs {
            return Vec::new();
        }
        let inputs = self.inputs();
        let quantities = self.quantities(states, inputs);
        let outputs = &self.flow.outputs;
        outputs.on_form(&self.form, &quantities, inputs)
    }

    /// Encloses the outputs on a box of states, with inputs in `inputs`.
    pub(super) fn outputs_on(&self, states: &[Interval], inputs: &[Interval]) -> Vec<Interval> {
        if !self.tells_outputs {
            return Vec::new();
        }
        let quantities = self.quantities(states, inputs);
        self.flow.outputs.on_box(&quantities)
    }

    /// Begins a stretch.
    pub(super) fn enter(&mut self, stretch: usize) {
        self.current = stretch;
        self.left = self.stretches.get(stretch).map_or(Interval::ZERO, |s| s.dt);
        self.begin = self.form.elapsed;
        self.form.tube = self.form.quick_hull();
        self.before.clone_from(&self.form.tube);
        if let Some(acting) = &mut self.acting {
            acting.leaps = self.form.options.closed;
        }
    }

    /// Remembers the place.
    fn remember(&mut self) {
        if self.may_part < 2 {
            return;
        }
        if self.earlier.len() == REMEMBERED {
            self.earlier.pop_front();
        }
        self.earlier.push_back(Place {
            form: self.form.clone(),
            current: self.current,
            left: self.left,
            begin: self.begin,
            before: self.before.clone(),
            proved: self.proved.mark(),
        });
    }

    /// Goes back to a place on the way.
    pub(super) fn back_to(&mut self, place: Place) {
        self.form = place.form;
        (self.current, self.left) = (place.current, place.left);
        (self.begin, self.before) = (place.begin, place.before);
        self.proved.back_to(place.proved);
    }

    /// Goes through all stretches, or to where the form was divided: then the parts are in [`Journey::parts`]. On
    /// failure the form stands somewhere on the way.
    pub(super) async fn run(&mut self) -> Result<(), Diverged> {
        self.meet_form();
        while self.current < self.until {
            if self.left.hi() <= 0.0 {
                self.form.elapsed = self.begin + self.stretches[self.current].dt;
                let end = self.end_hull();
                self.proved.end(end.clone(), self.form.tube.clone());
                if self.acting.as_ref().is_some_and(Acting::depends_on_inputs) {
                    self.acting = None;
                }
                self.certain = None;
                self.enter(self.current + 1);
                self.meet_form();
                if self.current < self.stretches.len() {
                    let outputs = self.outputs_now(&end);
                    self.proved.begin(outputs);
                }
                continue;
            }
            let known = self.proved.len();
            let step = if self.ahead.is_some() { AHEAD } else { STEP };
            self.spend(step).await;
            let mut moved = if (self.go_on)(&self.form) {
                self.step_on().await
            } else {
                Err(Obstacle::Interrupted)
            };
            if !self.parts.is_empty() {
                return Ok(());
            }
            if moved.is_ok() && !self.is_in_domain(known) {
                // What was passed on the way is proved no more than the rest.
                self.proved.truncate(known);
                moved = Err(Obstacle::LeavesDomain);
            }
            if moved.is_ok() {
                self.meet_passed();
            }
            let moved = match moved {
                Ok(()) if self.most < 1.0 && self.form.excess() > self.most => {
                    Err(Obstacle::TooLong)
                }
                moved => moved,
            };
            if let Err(obstacle) = moved {
                return Err(Diverged {
                    obstacle,
                    state: widest_growth(&self.before, &self.form.quick_hull()),
                    reached: self.form.elapsed,
                });
            }
        }
        Ok(())
    }

    /// As [`Journey::run`], on the way of another one.
    pub(super) fn run_beside(
        &mut self,
    ) -> Pin<Box<dyn Future<Output = Result<(), Diverged>> + Send + '_>> {
        Box::pin(self.run())
    }

    /// Spends so many multiplications of polynomials, and waits where that was more than is allowed now.
    pub(super) async fn spend(&self, multiplications: f64) {
        if let Some(allowance) = self.allowance {
            allowance.spend(multiplications * self.form.cost()).await;
        }
    }

    /// Encloses the states at the end of a stretch.
    fn end_hull(&mut self) -> Vec<Interval> {
        // Who meets the form asks it for what is wanted.
        if self.meet.is_some() {
            return self.form.quick_hull();
        }
        let rest = self.form.frame.hull();
        if let Some(known) = &self.ended
            && known.states == self.form.states
            && known.rest == rest
        {
            return known.hull.clone();
        }
        let hull = self.form.hull();
        self.ended = Some(Ended {
            states: self.form.states.clone(),
            rest,
            hull: hull.clone(),
        });
        hull
    }

    /// Whether it stands at the begin of a stretch.
    pub(super) fn is_at(&self, stretch: usize) -> bool {
        let whole = self.stretches.get(stretch);
        self.current == stretch && self.left == whole.map_or(Interval::ZERO, |stretch| stretch.dt)
    }

    /// Shows the form at the begin of the stretch at hand.
    fn meet_form(&mut self) {
        if let Some(meet) = &mut self.meet {
            meet(Meeting {
                stretch: self.current,
                form: &mut self.form,
                is_passing: false,
                arriving: None,
            });
        }
    }

    /// Shows where solutions were at begins of stretches that a crossing went over.
    fn meet_passed(&mut self) {
        if let Some(meet) = &mut self.meet {
            for (stretch, mut form, arriving) in self.passed_by.drain(..) {
                meet(Meeting {
                    stretch,
                    form: &mut form,
                    is_passing: true,
                    arriving,
                });
            }
        }
    }

    /// Whether guards are proved to leave no gap wherever solutions have been since `known` stretches were done.
    fn is_in_domain(&self, known: usize) -> bool {
        let Some(domain) = &self.flow.system.domain else {
            return true;
        };
        let within = |list: &[Interval], allowed: &[Interval]| {
            list.iter()
                .zip(allowed)
                .all(|(x, allowed)| x.is_subset_of(*allowed))
        };
        let tubes = self.proved.tubes[known..].iter();
        let mut tubes = tubes.chain([&self.form.tube]);
        let mut inputs = self.stretches[known..]
            .iter()
            .take(self.proved.len() + 1 - known);
        tubes.all(|tube| within(tube, &domain.states))
            && inputs.all(|stretch| within(&stretch.inputs, &domain.inputs))
    }

    /// Shortest step worth trying now.
    pub(super) fn shortest(&self) -> f64 {
        SHORTEST * self.stretches[self.current].dt.hi()
    }

    pub(super) fn inputs(&self) -> &'a [Interval] {
        &self.stretches[self.current].inputs
    }

    /// States, parameters and inputs in one list.
    pub(super) fn quantities(&self, states: &[Interval], inputs: &[Interval]) -> Vec<Interval> {
        [states, &self.form.param_box(), inputs].concat()
    }

    /// A journey of the same solutions from here on, as far as they are in `portion`.
    pub(super) fn fork(&self, portion: Portion) -> Journey<'a> {
        Journey {
            is_border: portion.is_border,
            proved: self.proved.fork(),
            tells_outputs: self.tells_outputs,
            may_part: self.may_part,
            most: self.most,
            ..self.beside(portion.form)
        }
    }

    /// A journey with this form from here on, of which nobody is told.
    pub(super) fn beside(&self, form: Form) -> Journey<'a> {
        Journey {
            chains: Chains::default(),
            form,
            proved: Proved::default(),
            tells_outputs: false,
            may_part: 1,
            most: f64::INFINITY,
            torn: self.torn.clone(),
            before: self.before.clone(),
            acting: None,
            certain: None,
            workspace: None,
            meet: None,
            passed_by: Vec::new(),
            earlier: VecDeque::new(),
            undecided: None,
            parts: Vec::new(),
            creep: None,
            ended: None,
            ahead: None,
            ..*self
        }
    }

    /// One step of whatever kind is possible.
    async fn step_on(&mut self) -> Result<(), Obstacle> {
        if let Some(ahead) = self.ahead.take()
            && self.go_ahead(ahead).is_some()
        {
            return Ok(());
        }
        if let Some(creep) = self.creep.take() {
            // Other inputs may tell what solutions do that were left open.
            let is_decided = !creep.is_final && self.is_at(self.current) && self.regime().is_ok();
            if !is_decided && self.creep_on(creep).is_some() {
                return Ok(());
            }
        }
        if self.acting.is_none() {
            self.acting = match self.regime() {
                Ok(regime) => Some(Acting::new(self.flow, regime, &self.form)),
                Err(undecided) => {
                    let certain = self.certain.take();
                    if let (None, Some(undecided)) = (&certain, undecided)
                        && self.left == self.stretches[self.current].dt
                        && self.break_away(&undecided).await.is_some()
                    {
                        return Ok(());
                    }
                    certain
                }
            };
        }
        self.certain = None;
        match self.acting.take() {
            Some(acting) => self.smooth(acting).await,
            None => self.mixed(None, Obstacle::Jump).await,
        }
    }

    /// The regime that is certain now.
    ///
    /// Errors: what decides whether solutions leave the one surface that they rest on, if only that stands in the way.
    pub(super) fn regime(&self) -> Result<Regime, Option<Undecided>> {
        let smooth = || self.flow.resolve(None, &[]).ok_or(None);
        if self.flow.is_smooth() {
            return smooth();
        }
        let Some(mut field) = self.field() else {
            return smooth();
        };
        let signs = self.signs(&field);
        let form = || self.form.clone();
        let found = self.resolve_on((&mut field, &signs), &form, self.inputs());
        found.map_err(|open| {
            let surface = open.first()?.surface;
            let alone = open.iter().all(|other| other.surface == surface);
            if !alone || signs[surface] != Signs::ZERO {
                return None;
            }
            self.undecided_at(surface, &field, &signs, open)
        })
    }

    /// Surfaces and right-hand sides on a box around the form.
    pub(super) fn field(&self) -> Option<Field> {
        let quantities = self.quantities(&self.form.quick_hull(), self.inputs());
        self.flow.switching.field(&quantities)
    }

    /// What is known of the surfaces now: what was, and what the box of `field` says.
    pub(super) fn signs(&self, field: &Field) -> Vec<Signs> {
        self.flow
            .switching
            .narrowed(field.signs(), &self.form.signs)
    }

    /// A step of the regime, as far as it is certain.
    async fn smooth(&mut self, mut acting: Acting) -> Result<(), Obstacle> {
        if acting.leaps {
            let leap = self.leap(&acting)?;
            acting.leaps = leap.unwrap_or(false);
            if leap.is_some() {
                self.form.signs.clone_from(&acting.regime.signs);
                self.acting = Some(acting);
                return Ok(());
            }
        }
        let inputs = self.inputs();
        let prepared = match self.prepare_several(&mut acting) {
            Some(Reach::Several(prepared)) => return self.set_out(acting, prepared),
            Some(Reach::Less(prepared)) => Ok(prepared),
            None => acting.prepare(&self.form, inputs, self.left, self.shortest()),
        };
        let prepared = match prepared {
            Ok(prepared) => prepared,
            // What may jump or has no slope somewhere may still have bounds.
            Err(why @ (Obstacle::Jump | Obstacle::Undefined)) => {
                self.form.undefined += usize::from(why == Obstacle::Undefined);
                return self.mixed(None, why).await;
            }
            Err(obstacle) => return Err(obstacle),
        };
        let span = prepared.bounds.span;
        let trouble = self.trouble(&acting, span).await;
        let Some(trouble) = trouble else {
            return self.move_whole(acting, &prepared);
        };
        let unit = prepared.unit;
        let takes = acting.crossing_time(trouble.watch, unit);
        let takes_of_span = takes.min(span);
        let from = trouble.from * (1.0 - 1e-9) - SLACK * takes_of_span;
        if from * unit > self.shortest() && from >= APPROACH * takes_of_span {
            let end = End::At {
                scaled: from,
                off: 0.0,
            };
            self.arrive(
                &acting,
                &prepared,
                &end,
                Interval::point(from) * Interval::point(unit),
            )?;
            self.form.signs.clone_from(&acting.regime.signs);
            self.form.step = 2.0 * span * unit;
            // Another choice of what to watch may last longer, but boxes may not see any.
            self.certain = Some(acting);
            return Ok(());
        }
        let before = self.form.excesses();
        let mut shares = vec![0.0; self.torn.len()];
        acting.blame(trouble.watch, &mut shares);
        if self.cross(&mut acting, trouble.watch, unit).await.is_some() {
            self.form.tear(&before, &shares);
            return Ok(());
        }
        if let Some(undecided) = self.undecided.take()
            && self
                .part(acting.regime.watches[trouble.watch], &undecided)
                .is_some()
        {
            return Ok(());
        }
        acting.blame(trouble.watch, &mut self.torn);
        if acting.regime.watches[trouble.watch].reason == Reason::Kink
            && let Some(regime) = self.bent()
        {
            let acting = Acting::new(self.flow, regime, &self.form);
            return Box::pin(self.smooth(acting)).await;
        }
        self.mixed(Some((acting, takes * unit)), Obstacle::Jump)
            .await
    }

    /// The first time of a prepared step, up to `span`, at which something watched may change its sign, as of [`Search`].
    async fn trouble(&self, acting: &Acting, span: f64) -> Option<Trouble> {
        let monomials = &*self.form.monomials;
        let place = (&*acting.piece, &acting.scratch, monomials);
        let steady = acting.steady(self.inputs());
        let coefficients = (monomials.len() * self.form.order) as f64;
        let window = WINDOW * coefficients / self.form.cost();
        let mut first: Option<Trouble> = None;
        for (watch, asked) in acting.regime.watches.iter().enumerate() {
            let end = first.map_or(span, |trouble| trouble.from);
            let mut search = Search::new(place, (watch, asked.sign, steady[watch]), end);
            loop {
                self.spend(window).await;
                match search.look() {
                    Look::Open => {}
                    Look::Calm => break,
                    Look::Trouble(from) => {
                        first = Some(Trouble { from, watch });
                        break;
                    }
                }
            }
        }
        first
    }

    /// The regime that is certain now, with all its kinks.
    fn bent(&self) -> Option<Regime> {
        let field = self.field()?;
        self.flow.unbent(&field, &self.signs(&field))
    }

    fn move_whole(&mut self, acting: Acting, prepared: &Prepared) -> Result<(), Obstacle> {
        let (unit, span) = (prepared.unit, prepared.bounds.span);
        let (end, moved) = if prepared.last {
            (Piece::last(self.left, unit), self.left)
        } else {
            let moved = Interval::point(span) * Interval::point(unit);
            let end = End::At {
                scaled: span,
                off: 0.0,
            };
            (end, moved)
        };
        self.arrive(&acting, prepared, &end, moved)?;
        if prepared.last {
            self.left = Interval::ZERO;
        }
        self.form.step = prepared.next_step(self.form.step);
        self.form.signs.clone_from(&acting.regime.signs);
        if acting.regime.has_kinks && !self.flow.is_smooth() {
            // They may have been left behind.
            self.certain = Some(acting);
        } else {
            self.acting = Some(acting);
        }
        Ok(())
    }

    /// What is held has its value, for all.
    pub(super) fn hold(&self, regime: &Regime, arrival: &mut Arrival) {
        let n = arrival.states.len();
        let surfaces = &self.flow.switching.surfaces.list;
        for (surface, signs) in regime.signs.iter().enumerate() {
            if *signs == Signs::ZERO
                && let Some(Level { state, value, .. }) = surfaces[surface].level
            {
                arrival.states[state].fill(0.0);
                arrival.states[state][0] = value.mid();
                arrival.lows[state] = 0.0;
                arrival.more[state] = value - Interval::point(value.mid());
                arrival.map[state * n..(state + 1) * n].fill(Interval::ZERO);
            }
        }
    }

    /// Puts the form to the end of a prepared step.
    pub(super) fn arrive(
        &mut self,
        acting: &Acting,
        prepared: &Prepared,
        end: &End,
        moved: Interval,
    ) -> Result<(), Obstacle> {
        let piece = &acting.piece;
        let arrival = piece.arrival(&self.form, &acting.scratch, prepared, end)?;
        self.remember();
        let outputs = self.outputs_on(&arrival.during, self.inputs());
        self.proved.pass(&outputs, acting.regime.modes);
        self.land(acting, arrival, moved)
    }

    /// Puts the form to where it arrives after `moved`, once tube and outputs on the way are known.
    pub(super) fn land(
        &mut self,
        acting: &Acting,
        mut arrival: Arrival,
        moved: Interval,
    ) -> Result<(), Obstacle> {
        for (tube, during) in self.form.tube.iter_mut().zip(&arrival.during) {
            *tube = tube.hull(*during);
        }
        self.proved.steps += 1;
        self.hold(&acting.regime, &mut arrival);
        arrival.land(&mut self.form);
        self.form.settle()?;
        self.form.elapsed += moved;
        self.left -= moved;
        Ok(())
    }
}

impl Acting {
    /// Adds how much each unknown decides when a watched expression's zero is passed.
    fn blame(&self, watch: usize, torn: &mut [f64]) {
        let stride = self.scratch.series.stride;
        let block = self.scratch.series.block(self.piece.probes[watch].value);
        let slopes = block.iter().step_by(stride).skip(1);
        let total: f64 = slopes.clone().map(|x| x.abs()).sum();
        for (slot, slope) in torn.iter_mut().zip(slopes) {
            *slot += slope.abs() / (total + 1e-300);
        }
    }

    /// About the scaled time in which all solutions pass a watched expression's zero.
    fn crossing_time(&self, watch: usize, unit: f64) -> f64 {
        let rate = self.piece.probes[watch].rate;
        let speed = (self.scratch.errors.sizes[rate].centre * unit).abs();
        self.spread(watch) / (speed + 1e-300)
    }

    /// About how much a watched expression differs over the set.
    pub(super) fn spread(&self, watch: usize) -> f64 {
        let value = self.piece.probes[watch].value;
        let spread: f64 = self.scratch.errors.sizes[value].degree[1..].iter().sum();
        2.0 * (spread + self.scratch.radii[1][value])
    }
}

/// The state whose width grew most.
fn widest_growth(before: &[Interval], after: &[Interval]) -> usize {
    let growth = |i: usize| {
        let start = before[i].width() + 1e-12 * before[i].mag() + 1e-300;
        after[i].width() / start
    };
    (0..before.len())
        .max_by(|a, b| growth(*a).total_cmp(&growth(*b)))
        .unwrap_or(0)
}
