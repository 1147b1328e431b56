//! Engines: ways to enclose all solutions, and the choice between them.
//!
//! All prove the same claim, that of [`Enclosure`], so bounds of several of them may be cut with each other, and none
//! can say what another one refutes. [`Engine::Auto`] takes comparison bounds alone where nothing uncertain is left
//! out of the order, since these are exact hulls; else forms, cut with comparison bounds where these have corners and
//! the forms keep too little. Corners that keep unknowns are forms themselves, and they are asked piece by piece, with one
//! order after the other: they are given up where they are foreseen or found to cost four times as much as the forms.

mod boxes;

use crate::comparison::{Compared, Comparison, Disorder, Outlook};
use crate::form::{
    Diverged, Effort, Enclosure, Flow, FormOptions, Obstacle, Part, Standing, Stretch,
};
use std::cell::Cell;
use std::sync::OnceLock;
use veribound_interval::Interval;
use veribound_model::Model;

/// Comparison bounds that keep unknowns may cost so many times as much as forms.
const WORTH: f64 = 4.0;

/// Comparison bounds that are asked for alone may cost so many steps of forms a stretch, or as if there were at least
/// so many stretches.
const FAIR: f64 = 8.0;
const LEAST: usize = 64;

/// A way to enclose all solutions.
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
}

impl Engine {
    /// All engines.
    pub const ALL: [Engine; 4] = [
        Engine::Auto,
        Engine::Boxes,
        Engine::Forms,
        Engine::Comparison,
    ];

    /// Its name in commands and results.
    pub fn name(self) -> &'static str {
        match self {
            Engine::Auto => "auto",
            Engine::Boxes => "boxes",
            Engine::Forms => "forms",
            Engine::Comparison => "comparison",
        }
    }
}

/// What was proved, and how.
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
        go_on: &dyn Fn(Standing) -> bool,
    ) -> Answer {
        match engine {
            Engine::Auto => self.best(task, go_on),
            Engine::Boxes => Answer::of(self.boxes(task, go_on), Engine::Boxes),
            Engine::Forms => Answer::of(self.forms(task, go_on), Engine::Forms),
            Engine::Comparison => match self.compare(task, self.fair(task), go_on) {
                Ok(compared) => Answer::compared(compared),
                Err(disorders) => Answer {
                    disorders,
                    ..Answer::of(self.not_ordered(task), Engine::Comparison)
                },
            },
        }
    }

    fn forms(&self, task: Task<'_>, go_on: &dyn Fn(Standing) -> bool) -> Enclosure {
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
        go_on: &dyn Fn(Standing) -> bool,
    ) -> Result<Compared, Vec<Disorder>> {
        let set = (task.states, task.params);
        let settings = (task.options, task.effort, most);
        self.comparison()
            .enclose(&self.flow, set, task.stretches, settings, go_on)
    }

    /// Nothing proved, since nothing is ordered.
    fn not_ordered(&self, task: Task<'_>) -> Enclosure {
        let stopped = Diverged {
            obstacle: Obstacle::NotMonotone,
            state: 0,
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

    fn best(&self, task: Task<'_>, go_on: &dyn Fn(Standing) -> bool) -> Answer {
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
        let spent = Cell::new(0.0);
        let forms = self.forms(task, &|standing| {
            spent.set(spent.get() + standing.cost);
            go_on(standing)
        });
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
                compared = Some(self.compare(task, WORTH * spent.get(), go_on));
            }
        }
        let mut answer = Answer::of(forms, Engine::Forms);
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

    /// The order at the start, and what has no place in it.
    pub fn outlook(&self, task: Task<'_>) -> Outlook {
        self.comparison()
            .outlook(task.states, task.params, task.stretches)
    }
}
