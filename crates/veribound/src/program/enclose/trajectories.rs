//! Random true trajectories, compared with the bounds that are proved for all.

use super::super::noise::Noise;
use super::Course;
use crate::Simulation;
use veribound_data::Trajectories;
use veribound_flow::form::Enclosure;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::{Hold, Model, Var};

/// Pieces of a stretch, each with inputs of its own.
const PIECES: usize = 3;

/// Steps of the simulation for a piece; more are tried where these fail.
const STEPS: [usize; 3] = [8, 64, 512];

/// One trajectory.
pub struct Drawn {
    /// Where states and outputs are, at every time to which it could be followed.
    places: Vec<Vec<Interval>>,
    /// Whether it is proved to be inside wherever it was compared.
    is_inside: bool,
    /// Whether it could be followed to the end.
    is_whole: bool,
    comparisons: u64,
}

impl Drawn {
    /// Where states and outputs are at a row; nothing from where that is not known any more.
    pub fn at(&self, row: usize) -> Vec<(f64, f64)> {
        let place = self.places.get(row).into_iter().flatten();
        place.map(|x| (x.lo(), x.hi())).collect()
    }
}

/// How all of them compare.
pub fn counted(drawn: &[Drawn]) -> Trajectories {
    Trajectories {
        drawn: drawn.len(),
        inside: drawn.iter().filter(|one| one.is_inside).count(),
        followed: drawn.iter().filter(|one| one.is_whole).count(),
        comparisons: drawn.iter().map(|one| one.comparisons).sum(),
    }
}

/// Draws so many trajectories with start values and parameters of the sets and inputs inside their bounds, and
/// compares them with the enclosure at every time and between.
///
/// *Errors*: `E0614` where one is proved to lie outside.
pub fn draw(
    model: &Model,
    course: &Course,
    enclosure: &Enclosure,
    (count, seed): (usize, u64),
) -> Result<Vec<Drawn>, Diagnostic> {
    let mut noise = Noise::new(seed, 0);
    let mut simulation = Simulation::new(model, &[], &[], 1);
    let mut all = Vec::with_capacity(count);
    for number in 1..=count {
        let init = model.states.iter().map(|state| state.init);
        let start: Vec<Interval> = init.map(|x| point(x, &mut noise)).collect();
        let bounds = model.params.iter().map(|param| param.bounds);
        let params: Vec<Interval> = bounds.map(|x| point(x, &mut noise)).collect();
        simulation.restart(&params, &start);
        let follow = Follow {
            model,
            course,
            enclosure,
            params,
            number,
        };
        all.push(follow.follow(&mut simulation, &mut noise)?);
    }
    Ok(all)
}

/// A trajectory on its way.
struct Follow<'f> {
    model: &'f Model,
    course: &'f Course,
    enclosure: &'f Enclosure,
    params: Vec<Interval>,
    number: usize,
}

impl Follow<'_> {
    fn follow(&self, simulation: &mut Simulation, noise: &mut Noise) -> Result<Drawn, Diagnostic> {
        let found = self.enclosure;
        let mut drawn = Drawn {
            places: Vec::new(),
            is_inside: true,
            is_whole: true,
            comparisons: 0,
        };
        let zero = Decimal::zero();
        for (row, stretch) in self.course.stretches.iter().enumerate() {
            let time = self.course.times.get(row).unwrap_or(&zero);
            let mut inputs: Vec<Interval> =
                stretch.inputs.iter().map(|x| point(*x, noise)).collect();
            let outputs = self.outputs(simulation.states(), &inputs);
            if let Some(known) = found.outputs.get(row) {
                self.compare(&mut drawn, &outputs, (known, &self.model.outputs), time)?;
            }
            let states = simulation.states().iter().copied();
            drawn.places.push(states.chain(outputs).collect());
            // The last time has no stretch behind it.
            let is_last = row + 1 == self.course.stretches.len();
            let (Some(tube), Some(end), false) =
                (found.tubes.get(row), found.ends.get(row), is_last)
            else {
                break;
            };
            let part = stretch.dt / Interval::point(PIECES as f64);
            for _ in 0..PIECES {
                if !advance(simulation, &inputs, part) {
                    drawn.is_whole = false;
                    return Ok(drawn);
                }
                let outputs = self.outputs(simulation.states(), &inputs);
                let states = simulation.states().to_vec();
                self.compare(&mut drawn, &states, (tube, &self.model.states), time)?;
                if let Some(known) = found.output_tubes.get(row) {
                    self.compare(&mut drawn, &outputs, (known, &self.model.outputs), time)?;
                }
                for ((input, bounds), now) in self
                    .model
                    .inputs
                    .iter()
                    .zip(&stretch.inputs)
                    .zip(&mut inputs)
                {
                    if input.hold == Hold::Free {
                        *now = point(*bounds, noise);
                    }
                }
            }
            let states = simulation.states().to_vec();
            self.compare(&mut drawn, &states, (end, &self.model.states), time)?;
        }
        Ok(drawn)
    }

    fn outputs(&self, states: &[Interval], inputs: &[Interval]) -> Vec<Interval> {
        let value = |var: Var| {
            let found = match var {
                Var::State(i) => states.get(i),
                Var::Param(i) => self.params.get(i),
                Var::Input(i) => inputs.get(i),
            };
            found.copied().unwrap_or(Interval::ENTIRE)
        };
        let outputs = self.model.outputs.iter();
        outputs
            .map(|output| self.model.graph.eval_interval(output.expr, &value))
            .collect()
    }

    /// Compares quantities after `time` with their bounds.
    fn compare(
        &self,
        drawn: &mut Drawn,
        values: &[Interval],
        (bounds, names): (&[Interval], &[impl Named]),
        time: &Decimal,
    ) -> Result<(), Diagnostic> {
        drawn.comparisons += 1;
        for ((value, known), named) in values.iter().zip(bounds).zip(names) {
            if !value.intersects(*known) {
                return Err(outside(self.number, named.name(), time, (*value, *known)));
            }
            drawn.is_inside &= value.is_subset_of(*known);
        }
        Ok(())
    }
}

/// Goes on for `part` seconds with constant inputs; in more steps where it has to be.
fn advance(simulation: &mut Simulation, inputs: &[Interval], part: Interval) -> bool {
    STEPS.iter().any(|steps| {
        simulation.divide(*steps);
        simulation.advance(inputs, part).is_ok()
    })
}

/// A random number of an interval.
fn point(x: Interval, noise: &mut Noise) -> Interval {
    let (middle, radius) = x.mid_rad();
    Interval::point((middle + noise.share() * radius).clamp(x.lo(), x.hi()))
}

/// What has a name.
trait Named {
    fn name(&self) -> &str;
}

impl Named for veribound_model::State {
    fn name(&self) -> &str {
        &self.name
    }
}

impl Named for veribound_model::Output {
    fn name(&self) -> &str {
        &self.name
    }
}

/// A contradiction between two proofs.
fn outside(
    number: usize,
    name: &str,
    time: &Decimal,
    (value, known): (Interval, Interval),
) -> Diagnostic {
    let message = format!(
        "true trajectory {number} leaves the bounds: from t = {time} s on `{name}` is in {value}, and proved to be \
         in {known}"
    );
    Diagnostic::new("E0614", message).help(
        "two proofs contradict each other, so this is an error of veribound and no result is written: please report \
         it with the model and the command line",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_flow::form::{Effort, Flow, FormOptions, Stretch};
    use veribound_model::diagnostic::Diagnostics;

    /// Bounds that are cut too narrow are found out.
    #[test]
    fn a_contradiction_is_told_word_for_word() {
        let text = "format = 1\nstates = [\"x\"]\ninit.x = [0, 1]\nder.x = \"-x\"\noutputs.y = \"2*x +- 0.1\"\n";
        let model = Model::from_text("m.toml", text).unwrap();
        let number = |text: &str| Decimal::parse(text).unwrap();
        let stretch = |dt: &str| Stretch {
            inputs: Vec::new(),
            dt: number(dt).to_interval(),
        };
        let course = Course {
            times: ["0", "0.5", "1"].map(number).to_vec(),
            stretches: ["0.5", "0.5", "0"].map(stretch).to_vec(),
            profile: None,
        };
        let flow = Flow::new(&model);
        let start = [model.states[0].init];
        let whole = || {
            flow.enclose(
                &start,
                &[],
                &course.stretches,
                FormOptions::default(),
                Effort::default(),
            )
        };
        let drawn = draw(&model, &course, &whole(), (20, 1)).unwrap();
        let counts = counted(&drawn);
        assert!(counts.inside == 20 && counts.followed == 20 && counts.comparisons == 20 * 17);
        let half = Interval::new(0.0, 0.1).unwrap();
        let broken: [fn(&mut Enclosure, Interval); 4] = [
            |found, half| found.ends[0][0] = half,
            |found, half| found.tubes[1][0] = half,
            |found, half| found.outputs[1][0] = half,
            |found, half| found.output_tubes[0][0] = half,
        ];
        for damage in broken {
            let mut found = whole();
            damage(&mut found, half);
            let Err(said) = draw(&model, &course, &found, (20, 1)) else {
                panic!("a trajectory outside was not told")
            };
            let said = Diagnostics::from(said).render(false);
            assert!(
                said.starts_with("error[E0614]: true trajectory 1 leaves the bounds: from t = 0")
            );
            let end = "is an error of veribound and no result is written: please report it with the model and the command \
                line\n";
            assert!(said.ends_with(end), "{said}");
        }
    }
}
