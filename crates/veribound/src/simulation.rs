//! Proved simulation of one solution: start state and parameters are points.

use std::fmt;
use veribound_flow::{StepFailure, StepOptions, System, Workspace};
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
    system: System,
    workspace: Workspace,
    steps: usize,
    params: Vec<Interval>,
    /// Boxes that together contain the states: more than one only while some solutions in the
    /// enclosure have jumped and others have not.
    boxes: Vec<Vec<Interval>>,
    /// Their hull.
    states: Vec<Interval>,
}

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
        let system = System::new(model);
        // Stretches are divided here: their length is not known in advance.
        let options = StepOptions {
            order: ORDER,
            longest: f64::INFINITY,
            ..StepOptions::default()
        };
        Simulation {
            workspace: Workspace::new(&system, options),
            steps: steps.max(1),
            params: params.to_vec(),
            boxes: vec![start.to_vec()],
            states: start.to_vec(),
            system,
        }
    }

    /// Begins anew with other parameters, at another start.
    pub fn restart(&mut self, params: &[Interval], start: &[Interval]) {
        self.params = params.to_vec();
        self.boxes = vec![start.to_vec()];
        self.states = start.to_vec();
    }

    /// Makes so many internal steps for every stretch from now on.
    pub fn divide(&mut self, steps: usize) {
        self.steps = steps.max(1);
    }

    /// The states now.
    pub fn states(&self) -> &[Interval] {
        &self.states
    }

    /// The parameters now.
    pub fn params(&self) -> &[Interval] {
        &self.params
    }

    /// Gives a parameter a new value from now on.
    pub fn change(&mut self, param: usize, value: Interval) {
        if let Some(param) = self.params.get_mut(param) {
            *param = value;
        }
    }

    /// Goes on by `dt` seconds with constant inputs.
    ///
    /// *Errors*: [`Stopped`] when a step cannot be proved.
    pub fn advance(&mut self, inputs: &[Interval], dt: Interval) -> Result<(), Stopped> {
        let part = dt / Interval::point(self.steps as f64);
        let mut boxes = self.boxes.clone();
        for _ in 0..self.steps {
            let mut next: Vec<Vec<Interval>> = Vec::new();
            for states in &boxes {
                let params = &self.params;
                let ends =
                    self.system
                        .step_apart(states, params, inputs, part, &mut self.workspace);
                next.extend(ends.map_err(Stopped)?);
            }
            boxes = veribound_flow::reduced(next);
        }
        self.boxes = boxes;
        self.states = self.boxes.iter().skip(1).fold(
            self.boxes.first().cloned().unwrap_or_default(),
            |hull, states| hull.iter().zip(states).map(|(a, b)| a.hull(*b)).collect(),
        );
        Ok(())
    }
}
