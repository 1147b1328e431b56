//! Engines: ways to enclose all solutions, and the choice between them.
//!
//! All prove the same claim, that of [`Enclosure`], so bounds of several of them may be cut with each other, and none
//! can say what another one refutes. [`Engine::Auto`] takes comparison bounds alone where nothing uncertain is left
//! out of the order, since these are exact hulls; else forms, by closed forms where modes are affine and inputs are held for
//! long, cut with comparison bounds where these have corners and the forms keep too little. Corners that keep unknowns are forms themselves, and they are asked piece by piece, with one
//! order after the other: they are given up where they are foreseen or found to cost four times as much as the forms.

mod boxes;

use crate::comparison::{Compared, Comparison, Disorder, Outlook};
use crate::form::{
    Diverged, Effort, Enclosure, Flow, FormOptions, Obstacle, Part, Spent, Standing, Stretch,
};
use std::sync::OnceLock;
use veribound_interval::Interval;
use veribound_model::Model;

/// Comparison bounds that keep unknowns may cost so many times as much as forms.
const WORTH: f64 = 4.0;

/// Closed forms are taken where the longest stretch, times how fast states change each other, is at least this: then
/// forms need several steps for it.
pub const LONG: f64 = 3.0;
/// Comparison bounds that are asked for alone may cost so many steps of forms a stretch, or as if there were at least
/// so many stretches.
const FAIR: f64 = 8.0;
const LEAST: usize = 64;

/// A way to enclose all solutions.
///
/// ```
/// use veribound_flow::engine::Engine;
///
/// let names: Vec<&str> = Engine::ALL.iter().map(|engine| engine.name()).collect();
/// assert_eq!(names, ["auto", "boxes", "forms", "comparison", "closed"]);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Engine {
    /// The best of the others, as far as is known.
    #[default]
    Auto,
    /// One box that forgets how states depend on anything, moved by its faces: the reference.
    Boxes,
    /// Sets that keep how states depend on start values and parameters.
    Forms,
    /// Two corners of a monotone right-hand side.
    Comparison,
    /// As forms, by the closed form of right-hand sides that are affine in the states.
    Closed,
}

impl Engine {
    /// All engines.
    pub const ALL: [Engine; 5] = [
        Engine::Auto,
        Engine::Boxes,
        Engine::Forms,
        Engine::Comparison,
        Engine::Closed,
    ];

    /// Its name in commands and results.
    pub fn name(self) -> &'static str {
        match self {
            Engine::Auto => "auto",
            Engine::Boxes => "boxes",
            Engine::Forms => "forms",
            Engine::Comparison => "comparison",
            Engine::Closed => "closed",
        }
    }
}

/// What was proved, and how.
///
/// ```
/// use veribound_flow::engine::{Engine, Engines, Task};
/// use veribound_flow::form::{Effort, FormOptions, Stretch};
/// # use veribound_interval::{Decimal, Interval};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let start = [model.states[0].init];
/// let params = [model.params[0].bounds];
/// let second = Stretch { inputs: vec![], dt: Interval::ONE };
/// let task = Task {
///     states: &start,
///     params: &params,
///     stretches: &[second],
///     options: FormOptions::default(),
///     effort: Effort::default(),
/// };
/// let answer = Engines::new(&model).enclose(Engine::Forms, task, &|_| true);
/// assert_eq!(answer.by, [Engine::Forms]);
/// assert!(answer.enclosure.stopped.is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The bounds.
    pub enclosure: Enclosure,
    /// The engines whose bounds were cut with each other; never [`Engine::Auto`].
    pub by: Vec<Engine>,
    /// Uncertain quantities that two corners stand for.
    pub corners: Vec<veribound_model::Var>,
    /// What stood in the way of an order of all quantities, where comparison bounds were asked.
    pub disorders: Vec<Disorder>,
}

impl Answer {
    fn of(enclosure: Enclosure, engine: Engine) -> Answer {
        Answer {
            enclosure,
            by: vec![engine],
            corners: Vec::new(),
            disorders: Vec::new(),
        }
    }

    fn compared(compared: Compared) -> Answer {
        Answer {
            corners: compared.corners,
            disorders: compared.disorders,
            ..Answer::of(compared.enclosure, Engine::Comparison)
        }
    }
}

/// What is asked of an engine.
///
/// Example: [`Engines`].
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// Start values.
    pub states: &'a [Interval],
    /// Parameters.
    pub params: &'a [Interval],
    /// What holds when.
    pub stretches: &'a [Stretch],
    /// Settings of forms.
    pub options: FormOptions,
    /// What may be spent.
    pub effort: Effort,
}

/// A model compiled for all engines; those that are not asked cost nothing.
///
/// ```
/// use veribound_flow::engine::{Engine, Engines, Task};
/// use veribound_flow::form::{Effort, FormOptions, Stretch};
/// # use veribound_interval::{Decimal, Interval};
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let start = [model.states[0].init];
/// let params = [model.params[0].bounds];
/// let second = Stretch { inputs: vec![], dt: Interval::ONE };
/// let task = Task {
///     states: &start,
///     params: &params,
///     stretches: &[second],
///     options: FormOptions::default(),
///     effort: Effort::default(),
/// };
/// let answer = Engines::new(&model).enclose(Engine::Auto, task, &|_| true);
/// let end = answer.enclosure.ends[0][0];
/// // From exp(-1) to exp(-1/2), nearly exactly.
/// assert!(end.contains((-1.0_f64).exp()) && end.contains((-0.5_f64).exp()));
/// assert!(end.width() < 0.24);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Engines {
    model: Model,
    flow: Flow,
    comparison: OnceLock<Comparison>,
}

impl Engines {
    /// Compiles `model`.
    pub fn new(model: &Model) -> Engines {
        Engines {
            flow: Flow::new(model),
            model: model.clone(),
            comparison: OnceLock::new(),
        }
    }

    /// The model compiled for forms.
    pub fn flow(&self) -> &Flow {
        &self.flow
    }

    /// The model compiled for comparison bounds.
    pub fn comparison(&self) -> &Comparison {
        self.comparison.get_or_init(|| Comparison::new(&self.model))
    }

    /// Encloses all solutions of `task`; `go_on` is asked at every step whether to go on.
    ///
    /// Guarantee: that of [`Enclosure`], whatever engine is asked.
    pub fn enclose(
        &self,
        engine: Engine,
        task: Task<'_>,
        go_on: &(dyn Fn(Standing) -> bool + Sync),
    ) -> Answer {
        match engine {
            Engine::Auto => self.best(task, go_on),
            Engine::Boxes => Answer::of(self.boxes(task, go_on), Engine::Boxes),
            Engine::Forms => Answer::of(self.forms(task, go_on), Engine::Forms),
            Engine::Comparison => match self.compare(task, self.fair(task), go_on) {
                Ok(compared) => Answer::compared(compared),
                Err(disorders) => Answer {
                    disorders,
                    ..Answer::of(
                        self.nothing(task, (Obstacle::NotMonotone, 0)),
                        Engine::Comparison,
                    )
                },
            },
            Engine::Closed => Answer::of(self.closed(task, go_on), Engine::Closed),
        }
    }

    fn forms(&self, task: Task<'_>, go_on: &(dyn Fn(Standing) -> bool + Sync)) -> Enclosure {
        let set = (task.states, task.params);
        self.flow
            .enclose_watched(set, task.stretches, task.options, task.effort, go_on)
    }

    /// What corners that keep unknowns may cost where nothing else is asked: about so many steps of forms with all
    /// unknowns. What needs more is a task for forms.
    fn fair(&self, task: Task<'_>) -> f64 {
        let form = self.flow.start(task.states, task.params, task.options);
        FAIR * task.stretches.len().max(LEAST) as f64 * form.cost()
    }

    /// Comparison bounds, of which corners that keep unknowns may cost `most` ([`Standing::cost`]).
    fn compare(
        &self,
        task: Task<'_>,
        most: f64,
        go_on: &(dyn Fn(Standing) -> bool + Sync),
    ) -> Result<Compared, Vec<Disorder>> {
        let set = (task.states, task.params);
        let settings = (task.options, task.effort, most);
        self.comparison()
            .enclose(&self.flow, set, task.stretches, settings, go_on)
    }

    /// Forms that move by closed forms.
    fn closed(&self, task: Task<'_>, go_on: &(dyn Fn(Standing) -> bool + Sync)) -> Enclosure {
        if let Some(state) = self.flow.curved() {
            return self.nothing(task, (Obstacle::NotAffine, state));
        }
        let options = FormOptions {
            closed: true,
            ..task.options
        };
        self.forms(Task { options, ..task }, go_on)
    }

    /// Nothing proved, for want of what the engine asks for.
    fn nothing(&self, task: Task<'_>, (obstacle, state): (Obstacle, usize)) -> Enclosure {
        let stopped = Diverged {
            obstacle,
            state,
            reached: Interval::ZERO,
        };
        let part = Part {
            states: task.states.to_vec(),
            params: task.params.to_vec(),
            passed: 0,
            end: Vec::new(),
        };
        let begin = task.stretches.first().map(|first| {
            let quantities = [task.states, task.params, &first.inputs].concat();
            self.flow.outputs_on(&quantities)
        });
        Enclosure {
            outputs: begin.into_iter().collect(),
            parts: vec![part],
            shares: vec![Vec::new(); task.states.len()],
            stopped: Some(stopped),
            ..Enclosure::default()
        }
    }

    fn best(&self, task: Task<'_>, go_on: &(dyn Fn(Standing) -> bool + Sync)) -> Answer {
        let outlook = self.outlook(task);
        let mut compared = None;
        if !outlook.corners.is_empty() && outlook.kept.is_empty() {
            match self.compare(task, 0.0, go_on) {
                Ok(exact) if exact.kept.is_empty() && exact.enclosure.stopped.is_none() => {
                    return Answer::compared(exact);
                }
                other => compared = Some(other),
            }
        }
        let spent = Spent::default();
        let watched = |standing: Standing| {
            spent.add(standing.cost);
            go_on(standing)
        };
        let (engine, forms) = if self.is_long(task) {
            (Engine::Closed, self.closed(task, &watched))
        } else {
            (Engine::Forms, self.forms(task, &watched))
        };
        let left = |shares: &Vec<(_, f64)>| 1.0 - shares.iter().map(|share| share.1).sum::<f64>();
        let tight = forms.stopped.is_none()
            && forms
                .shares
                .iter()
                .all(|shares| left(shares) <= task.effort.excess);
        let interrupted = forms
            .stopped
            .as_ref()
            .is_some_and(|stopped| stopped.obstacle == Obstacle::Interrupted);
        if !interrupted && !tight && !outlook.corners.is_empty() {
            let keeps = |known: &Result<Compared, _>| !matches!(known, Ok(c) if c.kept.is_empty());
            if compared.as_ref().is_none_or(keeps) {
                compared = Some(self.compare(task, WORTH * spent.all(), go_on));
            }
        }
        let mut answer = Answer::of(forms, engine);
        match compared {
            Some(Ok(compared)) if !compared.enclosure.ends.is_empty() => {
                answer.enclosure = answer.enclosure.both(compared.enclosure);
                answer.by.push(Engine::Comparison);
                answer.corners = compared.corners;
                answer.disorders = compared.disorders;
            }
            Some(Err(disorders)) => answer.disorders = disorders,
            _ => {}
        }
        answer
    }

    /// Whether there is a closed form, and a stretch that is long for forms.
    fn is_long(&self, task: Task<'_>) -> bool {
        let longest = task
            .stretches
            .iter()
            .max_by(|a, b| a.dt.mid().total_cmp(&b.dt.mid()));
        longest.is_some_and(|stretch| {
            let quantities = [task.states, task.params, &stretch.inputs].concat();
            let steepness = self.flow.steepness(&quantities);
            steepness.is_some_and(|steepness| steepness * stretch.dt.mid() >= LONG)
        })
    }

    /// The order at the start, and what has no place in it.
    pub fn outlook(&self, task: Task<'_>) -> Outlook {
        self.comparison()
            .outlook(task.states, task.params, task.stretches)
    }
}
