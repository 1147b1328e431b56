//! Proved simulation of one solution: start state and parameters are points.

use std::fmt;
use veribound_flow::form::{Flow, Form, FormOptions};
use veribound_flow::{ModeSet, StepFailure, StepOptions, Workspace};
use veribound_interval::Interval;
use veribound_model::Model;

/// Follows one solution of a model with known parameters, as an enclosure narrow enough to be read
/// as numbers.
///
/// *Guarantee*: after every [`Simulation::advance`] the enclosures contain the states of every
/// Filippov solution with the given start state, parameters and inputs. (Systems such as a rig with
/// dry friction have exactly one.)
///
/// ```
/// use veribound::{Decimal, Model, Simulation};
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [1, 3]\n\
///             der.x = \"-k * x\"\noutputs.y = \"x +- 0.1\"\n";
/// let model = Model::from_text("decay.toml", text)?;
/// let k = Decimal::parse("2").expect("a number");
/// let mut simulation = Simulation::new(&model, &[k.to_interval()], &[model.states[0].init], 10);
/// let second = Decimal::parse("1").expect("a number");
/// simulation.advance(&[], second.to_interval()).expect("an enclosure");
/// assert!(simulation.states()[0].contains((-2.0_f64).exp()));
/// assert!(simulation.states()[0].width() < 1e-3);
/// # Ok::<(), veribound::Diagnostics>(())
/// ```
pub struct Simulation {
    flow: Flow,
    workspace: Workspace,
    steps: usize,
    params: Vec<Interval>,
    /// Boxes that together contain the states: more than one only while some solutions in the
    /// enclosure have jumped and others have not.
    boxes: Vec<Vec<Interval>>,
    /// Their hull.
    states: Vec<Interval>,
    /// Whether forms are asked.
    keeps: bool,
    /// None where it has to begin anew.
    form: Option<Form>,
    tube: Vec<Interval>,
    modes: ModeSet,
}

/// A form begins anew where it is so many times as wide as the boxes.
const WORSE: f64 = 2.0;

/// Order of the Taylor series: high, since the boxes are narrow and the steps are few.
const ORDER: usize = 6;

/// The simulation cannot go on; the states are those before the step.
///
/// ```
/// use veribound::{Interval, Model, Simulation};
///
/// // x' = x^2 from 1 is infinite after a second.
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nder.x = \"x^2\"\noutputs.y = \"x +- 0.1\"";
/// let model = Model::from_text("explosion.toml", text)?;
/// let mut simulation = Simulation::new(&model, &[], &[Interval::ONE], 10);
/// assert!(simulation.advance(&[], Interval::point(0.5)).is_ok());
/// let stopped = simulation.advance(&[], Interval::point(2.0)).unwrap_err();
/// assert_eq!(stopped.to_string(), "no bounding box holds the solution, even for short steps");
/// # Ok::<(), veribound::Diagnostics>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped(pub StepFailure);

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            StepFailure::Apriori(_) => "no bounding box holds the solution, even for short steps",
            StepFailure::Unbounded => "the enclosure grew beyond all numbers",
            StepFailure::LeavesDomain { .. } | StepFailure::InputOutsideDomain { .. } => {
                "the solution leaves the domain in which the guards of the modes leave no gap"
            }
        })
    }
}

impl std::error::Error for Stopped {}

impl Simulation {
    /// A simulation of `model` at its start; `steps` internal steps are made for every stretch.
    ///
    /// `params` and `start` have one interval per parameter and state of the model, as narrow as
    /// they are known.
    pub fn new(model: &Model, params: &[Interval], start: &[Interval], steps: usize) -> Simulation {
        let flow = Flow::new(model);
        // Stretches are divided here: their length is not known in advance.
        let options = StepOptions {
            order: ORDER,
            longest: f64::INFINITY,
            ..StepOptions::default()
        };
        Simulation {
            workspace: Workspace::new(flow.system(), options),
            steps: steps.max(1),
            params: params.to_vec(),
            boxes: vec![start.to_vec()],
            states: start.to_vec(),
            keeps: false,
            form: None,
            tube: start.to_vec(),
            modes: ModeSet::EMPTY,
            flow,
        }
    }

    /// Begins anew with other parameters, at another start.
    pub fn restart(&mut self, params: &[Interval], start: &[Interval]) {
        self.params = params.to_vec();
        self.boxes = vec![start.to_vec()];
        self.states = start.to_vec();
        self.tube = start.to_vec();
        self.form = None;
    }

    /// Keeps, from now on or no more, how states depend on each other: boxes, which forget it, grow with every turn of
    /// an oscillation. The states are narrower, and take longer.
    pub fn keeping(mut self, keeps: bool) -> Simulation {
        self.keeps = keeps;
        self
    }

    /// Makes so many internal steps for every stretch from now on.
    pub fn divide(&mut self, steps: usize) {
        self.steps = steps.max(1);
    }

    /// The states now.
    pub fn states(&self) -> &[Interval] {
        &self.states
    }

    /// The states at all times of the last stretch.
    pub fn tube(&self) -> &[Interval] {
        &self.tube
    }

    /// The modes that may have acted during the last stretch.
    pub fn modes(&self) -> ModeSet {
        self.modes
    }

    /// The parameters now.
    pub fn params(&self) -> &[Interval] {
        &self.params
    }

    /// Gives a parameter a new value from now on.
    pub fn change(&mut self, param: usize, value: Interval) {
        if let Some(param) = self.params.get_mut(param) {
            *param = value;
            self.form = None;
        }
    }

    /// Goes on by `dt` seconds with constant inputs.
    ///
    /// *Errors*: [`Stopped`] when a step cannot be proved.
    pub fn advance(&mut self, inputs: &[Interval], dt: Interval) -> Result<(), Stopped> {
        let form = self.formed(inputs, dt);
        let hull = form.as_ref().map(Form::hull);
        match (self.boxed(inputs, dt), &form, &hull) {
            (Ok(boxes), Some(form), Some(hull)) => {
                // Solutions lie in some box, and in the form.
                cut(&mut self.tube, form.tube());
                self.boxes = boxes;
                for states in &mut self.boxes {
                    cut(states, hull);
                }
            }
            (Ok(boxes), ..) => self.boxes = boxes,
            (Err(_), Some(form), Some(hull)) => {
                self.tube = form.tube().to_vec();
                self.boxes = vec![hull.clone()];
                let all = 0..self.flow.system().mode_count();
                all.for_each(|mode| self.modes.insert(mode));
            }
            (Err(stopped), ..) => return Err(stopped),
        }
        self.states = hull_of(&self.boxes);
        let is_worse = |hull: &Vec<Interval>| {
            let mut both = hull.iter().zip(&self.states);
            both.any(|(own, x)| own.width() > WORSE * x.width())
        };
        self.form = form.filter(|_| !hull.as_ref().is_some_and(is_worse));
        Ok(())
    }

    /// The form after `dt`, which boxes that jump one after the other have none of.
    fn formed(&mut self, inputs: &[Interval], dt: Interval) -> Option<Form> {
        let form = self.form.take();
        if !self.keeps || self.boxes.len() > 1 {
            return None;
        }
        let options = FormOptions::default();
        let start = || self.flow.start(&self.states, &self.params, options);
        let mut form = form.unwrap_or_else(start);
        let moved = self.flow.advance(&mut form, inputs, dt);
        moved.ok().map(|()| form)
    }

    /// The boxes after `dt`; the tube and the modes become those of the way there.
    fn boxed(&mut self, inputs: &[Interval], dt: Interval) -> Result<Vec<Vec<Interval>>, Stopped> {
        let part = dt / Interval::point(self.steps as f64);
        let mut boxes = self.boxes.clone();
        self.tube.clone_from(&self.states);
        self.modes = ModeSet::EMPTY;
        for _ in 0..self.steps {
            let mut next: Vec<Vec<Interval>> = Vec::new();
            for states in &boxes {
                let (params, system) = (&self.params, self.flow.system());
                let ends = system.step_apart(states, params, inputs, part, &mut self.workspace);
                let (ends, report) = ends.map_err(Stopped)?;
                next.extend(ends);
                self.modes = self.modes.union(report.modes_during);
                for (tube, x) in self.tube.iter_mut().zip(self.workspace.tube()) {
                    *tube = tube.hull(*x);
                }
            }
            boxes = veribound_flow::reduced(next);
        }
        Ok(boxes)
    }
}

/// Cuts intervals with others, unless that leaves nothing.
fn cut(x: &mut [Interval], with: &[Interval]) {
    for (x, y) in x.iter_mut().zip(with).filter(|(x, y)| x.intersects(**y)) {
        *x = x.intersect(*y);
    }
}

fn hull_of(boxes: &[Vec<Interval>]) -> Vec<Interval> {
    let first = boxes.first().cloned().unwrap_or_default();
    boxes.iter().skip(1).fold(first, |hull, states| {
        hull.iter().zip(states).map(|(a, b)| a.hull(*b)).collect()
    })
}
