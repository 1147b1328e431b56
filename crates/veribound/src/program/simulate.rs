//! `veribound simulate`: a record whose errors are proved to stay inside their bounds.

use super::arguments::{MOST_DECIMALS, Simulate, refuse_formats};
use super::ending::Ending;
use super::flags::{Assignment, ErrorFlag};
use super::interrupt::Interrupt;
use super::message::{flag_problem, list, remark, say_json};
use super::noise::{Noise, Written};
use super::profile::{Profile, Stretch};
use super::trajectory::Trajectory;
use super::{Outcome, numbers, overwriting, progress};
use crate::{Simulation, Stopped};
use serde::Serialize;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use veribound_data::{ResultFile, ResultFolder, TableSource};
use veribound_interval::{Decimal, Interval, round};
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_model::{ErrorBound, ExprId, Hold, Model, Output, Var};

/// The enclosure and the rounding to decimals may take this share of an error bound; more, and the
/// record would be made of the method's width instead of the asked errors.
const LARGEST_SLACK: f64 = 0.1;

/// What a simulation tells as JSON.
#[derive(Serialize)]
struct Simulated {
    record: String,
    samples: usize,
    seed: u64,
}

/// Values that nobody gave.
#[derive(Clone)]
struct Draws {
    noise: Noise,
    /// What was drawn once, by name.
    told: String,
}

impl Draws {
    /// Other numbers than those of the errors, for the same seed.
    fn new(seed: u64) -> Draws {
        Draws {
            noise: Noise::new(!seed, 0),
            told: String::new(),
        }
    }

    /// A number in these bounds, as the shortest decimal that says which float is meant.
    fn point(&mut self, bounds: Interval) -> Interval {
        self.decimal(bounds)
            .map_or(bounds, |(_, decimal)| decimal.to_interval())
    }

    fn named(&mut self, name: &str, bounds: Interval) -> Interval {
        let Some((text, decimal)) = self.decimal(bounds) else {
            return bounds;
        };
        let _ = write!(self.told, " {name}={text}");
        decimal.to_interval()
    }

    fn decimal(&mut self, bounds: Interval) -> Option<(String, Decimal)> {
        if is_number(bounds) || !bounds.is_bounded() {
            return None;
        }
        // Not at the ends, so that rounding to a decimal stays inside.
        let share = 0.5 + 0.4999 * self.noise.share();
        let x = bounds.lo() + share * (bounds.hi() - bounds.lo());
        let text = format!("{}", x.clamp(bounds.lo(), bounds.hi()));
        let decimal = Decimal::parse(&text).ok()?;
        Some((text, decimal)).filter(|(_, decimal)| decimal.to_interval().is_subset_of(bounds))
    }
}

/// A parameter that takes a new value.
struct Change {
    time: Decimal,
    param: usize,
    value: Decimal,
}

/// Simulates, and gives the record its name when all of it is proved.
pub fn run(arguments: &Simulate) -> Outcome {
    refuse_flags(arguments)?;
    overwriting::refuse_record(&arguments.output, &what_is_read(arguments))?;
    let model = Model::from_file(&arguments.model)?;
    let source = arguments.times.input.as_ref().map(TableSource::from);
    let prepared = Prepared::new(arguments, &model, source)?;
    prepared.notes.iter().for_each(|note| remark(note));
    let interrupt = Interrupt::listen();
    match write(arguments, &prepared, false, &interrupt) {
        Err(problems) if asks_for_forms(&problems) => write(arguments, &prepared, true, &interrupt),
        done => done,
    }
}

/// Refuses what no run could do, and a trajectory in the place of what the run reads.
pub fn refuse_flags(arguments: &Simulate) -> Result<(), Diagnostic> {
    refuse_formats(&arguments.figures)?;
    match &arguments.trajectory {
        Some(folder) => overwriting::refuse_results(folder, &what_is_read(arguments), &[]),
        None => Ok(()),
    }
}

fn what_is_read(arguments: &Simulate) -> Vec<(&'static str, &Path)> {
    let profile = arguments.times.input.as_deref();
    let profile = profile.map(|path| ("the profile", path));
    [("the model file", arguments.model.as_path())]
        .into_iter()
        .chain(profile)
        .collect()
}

/// Whether boxes grew too wide, and forms may do better. Records made by boxes alone stay what they are.
pub fn asks_for_forms(problems: &Diagnostics) -> bool {
    problems.0.iter().any(|problem| problem.code == "E0609")
}

/// Writes the record.
fn write(
    arguments: &Simulate,
    prepared: &Prepared<'_>,
    with_forms: bool,
    interrupt: &Interrupt,
) -> Outcome {
    let mut file = create(&arguments.output)?;
    let bar = progress::of_parts(progress::PARTS, "simulated", false);
    let mut take = |text: &str| {
        let written = file.write_all(text.as_bytes());
        written.map_err(|error| file.refuse(&error))
    };
    let go_on = |part| {
        bar.set_position(part);
        !interrupt.is_asked()
    };
    let samples = prepared.carry_out(arguments, with_forms, &mut take, &go_on);
    bar.finish_and_clear();
    let Some(samples) = samples? else {
        remark("interrupted: no record is written");
        return Ok(Ending::Interrupted);
    };
    file.finish()?.put_in_place()?;
    if arguments.json {
        say_json(&Simulated {
            record: arguments.output.display().to_string(),
            samples,
            seed: arguments.seed,
        })?;
    } else {
        remark(&format!(
            "  {samples} samples in {}",
            arguments.output.display()
        ));
    }
    Ok(Ending::Done)
}

/// What a simulation works on, all of it checked.
pub struct Prepared<'m> {
    model: &'m Model,
    params: Vec<Interval>,
    start: Vec<Interval>,
    disturbances: Vec<Held>,
    changes: Vec<Change>,
    draws: Option<Draws>,
    inputs: Option<TableSource>,
    /// What the user should know: values outside of the prior.
    pub notes: Vec<String>,
}

impl<'m> Prepared<'m> {
    /// Checks values and profile.
    pub fn new(
        arguments: &Simulate,
        model: &'m Model,
        inputs: Option<TableSource>,
    ) -> Result<Prepared<'m>, Diagnostics> {
        let mut draws = arguments.random.then(|| Draws::new(arguments.seed));
        let params = params(model, &arguments.params, draws.as_mut())?;
        let start = start(model, &arguments.start, draws.as_mut())?;
        let changes = changes(model, &arguments.change)?;
        let disturbances = disturbances(model, &arguments.disturbance, arguments.random)?;
        Ok(Prepared {
            notes: outside_the_prior(model, &params, &changes),
            model,
            params,
            start,
            disturbances,
            changes,
            draws,
            inputs,
        })
    }

    /// Gives the lines of the record to `take`, and writes the folder of the trajectory if it is wanted, as long as
    /// `go_on` says so, which is told how many parts of [`progress::PARTS`] are done; the number of samples, or nothing
    /// where it was ended.
    pub fn carry_out(
        &self,
        arguments: &Simulate,
        with_forms: bool,
        take: &mut dyn FnMut(&str) -> Result<(), Diagnostic>,
        go_on: &dyn Fn(u64) -> bool,
    ) -> Result<Option<usize>, Diagnostics> {
        let model = self.model;
        let mut profile = Profile::open(&arguments.times, self.inputs.clone(), model)?;
        let simulation = Simulation::new(model, &self.params, &self.start, arguments.steps);
        let mut simulation = simulation.keeping(with_forms);
        let mut draws = self.draws.clone();
        let mut noise = Noise::new(arguments.seed, arguments.decimals);
        let mut open = self.changes.iter().peekable();
        let trajectory = arguments.trajectory.as_ref();
        let trajectory = trajectory.map(|folder| Trajectory::create(folder, model));
        let mut trajectory = trajectory.transpose()?;
        let mut text = header(arguments, model, draws.as_ref());
        let mut samples = 0;
        // Errors drawn last, each with its input and what was recorded.
        let mut last: Vec<(usize, Interval, Interval)> = Vec::new();
        while let Some(stretch) = profile.next()? {
            let Stretch {
                time,
                texts,
                mut inputs,
                to_next,
            } = stretch;
            if !go_on(profile.part_at(&time)) {
                return Ok(None);
            }
            if let Some(draws) = &mut draws {
                let recorded = inputs.clone();
                for (at, input) in model.recorded_inputs().enumerate() {
                    let Some(value) = inputs.get_mut(at) else {
                        continue;
                    };
                    let same = last.iter().find(|(of, was, _)| *of == at && was == value);
                    *value = match same {
                        Some((.., drawn)) if input.hold == Hold::Level => *drawn,
                        _ => draws.point(input.error.enclose(*value)),
                    };
                }
                let pairs = recorded.into_iter().zip(&inputs).enumerate();
                last = pairs.map(|(at, (was, drawn))| (at, was, *drawn)).collect();
            }
            let held = self.disturbances.iter();
            inputs.extend(held.map(|known| match (known, &mut draws) {
                (Held::Free(bounds), Some(draws)) => draws.point(*bounds),
                (Held::Free(x) | Held::At(x), _) => *x,
            }));
            while let Some(change) = open.next_if(|change| change.time <= time) {
                simulation.change(change.param, change.value.to_interval());
            }
            let now = Now {
                model,
                simulation: &simulation,
                inputs: &inputs,
            };
            now.write(
                &mut text,
                (&time, &texts),
                arguments.error.as_ref(),
                &mut noise,
            )?;
            if let Some(trajectory) = &mut trajectory {
                trajectory.push(&time, &simulation, &inputs)?;
            }
            take(&text)?;
            text.clear();
            samples += 1;
            if let Some(dt) = to_next {
                simulation
                    .advance(&inputs, dt.to_interval())
                    .map_err(|stopped| too_wide(&time, &stopped))?;
            }
        }
        take(&text)?;
        if let Some(trajectory) = trajectory {
            trajectory.finish(&arguments.figures)?;
        }
        Ok(Some(samples))
    }
}

/// What is known at one sample.
struct Now<'s> {
    model: &'s Model,
    simulation: &'s Simulation,
    inputs: &'s [Interval],
}

impl Now<'_> {
    /// Appends the row of the sample.
    fn write(
        &self,
        text: &mut String,
        (time, inputs): (&Decimal, &[Decimal]),
        error: Option<&ErrorFlag>,
        noise: &mut Noise,
    ) -> Result<(), Diagnostic> {
        // Writing to a String cannot fail.
        let _ = write!(text, "{time}");
        for value in inputs {
            let _ = write!(text, ",{value}");
        }
        for output in &self.model.outputs {
            let written = self.measure(output, time, error, noise)?;
            let _ = write!(text, ",{written}");
        }
        for signal in &self.model.signals {
            // Standing still is claimed only where it is proved; a 0 claims nothing.
            let proved = !signal.proves_zero.is_empty()
                && signal
                    .proves_zero
                    .iter()
                    .all(|expr| self.value(*expr) == Interval::ZERO);
            let _ = write!(text, ",{}", u8::from(proved));
        }
        text.push('\n');
        Ok(())
    }

    fn value(&self, expr: ExprId) -> Interval {
        self.model.graph.eval_interval(expr, &|var| {
            let found = match var {
                Var::State(i) => self.simulation.states().get(i),
                Var::Param(i) => self.simulation.params().get(i),
                Var::Input(i) => self.inputs.get(i),
            };
            found.copied().unwrap_or(Interval::ENTIRE)
        })
    }

    /// A value of the output with an error, as it is written.
    ///
    /// Guarantee: the difference to the true output is at most the asked error, and the bound of the
    /// model holds; both are checked on the decimal that is written.
    fn measure(
        &self,
        output: &Output,
        time: &Decimal,
        error: Option<&ErrorFlag>,
        noise: &mut Noise,
    ) -> Result<Written, Diagnostic> {
        let value = self.value(output.expr);
        let size = size_of(&output.error, value);
        let bound = match error {
            Some(ErrorFlag::Within(bound)) => bound.to_interval().lo(),
            Some(ErrorFlag::Worst) | None => size,
        };
        let slack = round::add_up(value.rad(), noise.rounding());
        let allowed = LARGEST_SLACK * if bound > 0.0 { bound } else { size };
        if slack.is_nan() || slack > allowed {
            return Err(imprecise(output, time, value, noise));
        }
        let reach = (bound - slack).max(0.0);
        let share = if error == Some(&ErrorFlag::Worst) {
            noise.sign()
        } else {
            noise.share()
        };
        let written = noise.write(value.mid() + share * reach);
        let within = bound.max(slack);
        let is_near = (written.exact() - value).mag() <= within;
        if !is_near || !value.is_subset_of(output.error.enclose(written.exact())) {
            return Err(not_allowed(output, time, bound));
        }
        Ok(written)
    }
}

/// A size that errors may surely have, for every value in `value`.
fn size_of(bound: &ErrorBound, value: Interval) -> f64 {
    let absolute = bound.absolute.to_interval().lo();
    // The share is of the recorded value, which lies nearer to zero by at most the error itself.
    let relative = bound.relative.to_interval();
    let relative = (relative / (Interval::ONE + relative)).lo() * value.mig();
    (absolute + relative) * (1.0 - f64::EPSILON * 4.0)
}

fn params(
    model: &Model,
    given: &[Assignment],
    mut draws: Option<&mut Draws>,
) -> Result<Vec<Interval>, Diagnostics> {
    let names: Vec<&str> = model
        .params
        .iter()
        .map(|param| param.name.as_str())
        .collect();
    let values = assigned(("--params", "parameter"), &names, given)?;
    let known = model.params.iter().zip(&values).map(|(param, value)| {
        let own = Some(param.bounds).filter(|bounds| is_number(*bounds));
        let known = value.as_ref().map(Decimal::to_interval).or(own);
        known.or_else(|| Some(draws.as_mut()?.named(&param.name, param.bounds)))
    });
    let values: Vec<Option<Interval>> = known.collect();
    let missing = names
        .iter()
        .zip(&values)
        .filter(|(_, value)| value.is_none());
    let missing: Vec<&str> = missing.map(|(name, _)| *name).collect();
    if !missing.is_empty() {
        let message = format!("no value is given for {}", list(missing.iter().copied()));
        let example: Vec<String> = missing.iter().map(|name| format!("{name}=VALUE")).collect();
        return Err(Diagnostic::new("E0607", message)
            .help(format!("add `--params {}`", example.join(",")))
            .into());
    }
    Ok(values.into_iter().flatten().collect())
}

/// Whether an interval stands for one number: a decimal fills at most two neighbouring floats.
fn is_number(x: Interval) -> bool {
    x.is_point() || x.lo().next_up() == x.hi()
}

fn start(
    model: &Model,
    given: &[Assignment],
    mut draws: Option<&mut Draws>,
) -> Result<Vec<Interval>, Diagnostics> {
    let names: Vec<&str> = model
        .states
        .iter()
        .map(|state| state.name.as_str())
        .collect();
    let values = assigned(("--start", "state"), &names, given)?;
    let mut start = Vec::new();
    for (state, value) in model.states.iter().zip(values) {
        match value {
            Some(value) => start.push(value.to_interval()),
            None if is_number(state.init) => start.push(state.init),
            None if draws.is_some() => {
                let drawn = draws.as_mut();
                start.extend(drawn.map(|draws| draws.named(&state.name, state.init)));
            }
            None => {
                let init = numbers::show_prior(state.init);
                let message = format!("the state `{}` starts anywhere in {init}", state.name);
                return Err(Diagnostic::new("E0607", message)
                    .help(format!("say where, as in `--start {}=0`", state.name))
                    .into());
            }
        }
    }
    Ok(start)
}

/// What a disturbance is.
enum Held {
    /// This all the time.
    At(Interval),
    /// Anything in here, drawn anew at every sample.
    Free(Interval),
}

/// What every disturbance is: as asked, else anything where it is drawn, else the middle of its bounds.
fn disturbances(
    model: &Model,
    given: &[Assignment],
    is_random: bool,
) -> Result<Vec<Held>, Diagnostic> {
    let names: Vec<&str> = model
        .disturbances()
        .map(|(input, _)| input.name.as_str())
        .collect();
    let values = assigned(("--disturbance", "disturbance"), &names, given)?;
    let mut held = Vec::new();
    for ((input, bounds), value) in model.disturbances().zip(values) {
        if value.is_none() && is_random {
            held.push(Held::Free(bounds));
            continue;
        }
        let value = value.map_or(Interval::point(bounds.mid()), |value| value.to_interval());
        if !value.is_subset_of(bounds) {
            let message = format!(
                "the disturbance `{}` cannot be {}",
                input.name,
                numbers::show_prior(value)
            );
            let bounds = numbers::show_prior(bounds);
            return Err(Diagnostic::new("E0608", message)
                .help(format!("choose a value in {bounds}, or change the model")));
        }
        held.push(Held::At(value));
    }
    Ok(held)
}

/// The values of `names` in the list, each given at most once.
fn assigned(
    (flag, kind): (&str, &str),
    names: &[&str],
    given: &[Assignment],
) -> Result<Vec<Option<Decimal>>, Diagnostic> {
    let mut values = vec![None; names.len()];
    for Assignment { name, value } in given {
        let typed = format!("{name}={value}");
        let place = (flag, typed.as_str(), 0..name.len());
        let Some(slot) = names
            .iter()
            .position(|known| known == name)
            .and_then(|at| values.get_mut(at))
        else {
            let message = format!("the model has no {kind} `{name}`");
            let help = format!("it has {}", list(names.iter().copied()));
            return Err(flag_problem("E0601", message, place, "unknown", help));
        };
        if slot.replace(value.clone()).is_some() {
            let message = format!("the {kind} `{name}` is given twice");
            return Err(flag_problem(
                "E0608",
                message,
                place,
                "once more",
                "give it once",
            ));
        }
    }
    Ok(values)
}

/// `SECONDS:NAME=VALUE`, in the order of time.
fn changes(model: &Model, given: &[String]) -> Result<Vec<Change>, Diagnostic> {
    let mut changes = Vec::new();
    for text in given {
        let read = text.split_once(':').and_then(|(time, rest)| {
            Decimal::parse(time)
                .ok()
                .zip(rest.parse::<Assignment>().ok())
        });
        let whole = ("--change", text.as_str(), 0..text.len());
        let Some((time, Assignment { name, value })) = read else {
            let help = "write SECONDS:NAME=VALUE, as in 40:T_Fs=0.2";
            let message = format!("`{text}` does not say when which parameter changes");
            return Err(flag_problem(
                "E0608",
                message,
                whole,
                "not understood",
                help,
            ));
        };
        let Some(param) = model.params.iter().position(|param| param.name == name) else {
            let known = list(model.params.iter().map(|param| param.name.as_str()));
            let message = format!("the model has no parameter `{name}`");
            return Err(flag_problem(
                "E0601",
                message,
                whole,
                "unknown",
                format!("it has {known}"),
            ));
        };
        changes.push(Change { time, param, value });
    }
    changes.sort_by(|a, b| a.time.cmp(&b.time));
    Ok(changes)
}

/// The comment that repeats the record, and the names of the columns.
fn header(arguments: &Simulate, model: &Model, draws: Option<&Draws>) -> String {
    let assignments = |list: &[Assignment]| {
        let each = list.iter().map(|one| format!("{}={}", one.name, one.value));
        each.collect::<Vec<_>>().join(",")
    };
    let file = |path: &Path| {
        path.file_name()
            .map_or(String::new(), |name| name.to_string_lossy().into_owned())
    };
    let mut line = format!("# veribound simulate {}", file(&arguments.model));
    let mut flag = |name: &str, value: String| {
        let _ = write!(line, " --{name}");
        if !value.is_empty() {
            let _ = write!(line, " {value}");
        }
    };
    if !arguments.params.is_empty() {
        flag("params", assignments(&arguments.params));
    }
    if !arguments.start.is_empty() {
        flag("start", assignments(&arguments.start));
    }
    if !arguments.disturbance.is_empty() {
        flag("disturbance", assignments(&arguments.disturbance));
    }
    arguments
        .change
        .iter()
        .for_each(|change| flag("change", change.clone()));
    if let Some(input) = &arguments.times.input {
        flag("input", file(input));
    }
    for (name, time) in [
        ("until", &arguments.times.until),
        ("every", &arguments.times.every),
    ] {
        if let Some(time) = time {
            flag(name, time.to_string());
        }
    }
    match &arguments.error {
        Some(ErrorFlag::Within(bound)) => flag("error", bound.to_string()),
        Some(ErrorFlag::Worst) => flag("error", "worst".to_owned()),
        None => {}
    }
    if arguments.random {
        flag("random", String::new());
    }
    flag("seed", arguments.seed.to_string());
    flag("decimals", arguments.decimals.to_string());
    flag("steps", arguments.steps.to_string());
    let column = |name: &str, own: Option<&String>, unit: &str| {
        let name = own.map_or(name, String::as_str);
        if unit.is_empty() || name.contains('[') {
            name.to_owned()
        } else {
            format!("{name} [{unit}]")
        }
    };
    let mut columns = vec!["t [s]".to_owned()];
    let inputs = model
        .recorded_inputs()
        .map(|x| column(&x.name, x.column.as_ref(), &x.unit));
    let outputs = model
        .outputs
        .iter()
        .map(|y| column(&y.name, y.column.as_ref(), &y.unit));
    let signals = model
        .signals
        .iter()
        .map(|s| column(&s.name, s.column.as_ref(), ""));
    columns.extend(inputs.chain(outputs).chain(signals));
    let drawn = draws.map_or("", |draws| draws.told.as_str());
    if !drawn.is_empty() {
        let _ = write!(line, "\n# drawn:{drawn}");
    }
    format!("{line}\n{}\n", columns.join(","))
}

/// Starts the record.
fn create(path: &Path) -> Result<ResultFile, Diagnostic> {
    let Some(name) = path.file_name() else {
        let message = format!("`{}` is no name of a file", path.display());
        return Err(
            Diagnostic::new("E0608", message).help("name the record, as in `-o record.csv`")
        );
    };
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = ResultFolder::create(folder.unwrap_or(Path::new(".")))?;
    folder.file(&name.to_string_lossy())
}

/// Says which values no observation with the priors of the model file can find.
fn outside_the_prior(model: &Model, params: &[Interval], changes: &[Change]) -> Vec<String> {
    let mut notes = Vec::new();
    let given = params.iter().copied().enumerate();
    let changed = changes
        .iter()
        .map(|change| (change.param, change.value.to_interval()));
    for (at, value) in given.chain(changed) {
        let Some(param) = model.params.get(at) else {
            continue;
        };
        if !value.is_subset_of(param.bounds) {
            notes.push(format!(
                "note: {} = {} lies outside its prior {}",
                param.name,
                numbers::show(value),
                numbers::show_prior(param.bounds)
            ));
        }
    }
    notes
}

fn too_wide(time: &Decimal, stopped: &Stopped) -> Diagnostic {
    Diagnostic::new(
        "E0609",
        format!("the simulation stopped at t = {time} s: {stopped}"),
    )
    .help("use more internal steps with `--steps`, or stop earlier with `--until`")
}

fn imprecise(output: &Output, time: &Decimal, value: Interval, noise: &Noise) -> Diagnostic {
    let decimals = noise.decimals();
    if value.rad() < noise.rounding() {
        let message = format!(
            "at t = {time} s rounding `{}` to {decimals} decimals takes too much of its error bound",
            output.name
        );
        let help = if decimals < MOST_DECIMALS {
            "use more decimals: `--decimals`"
        } else {
            "ask for larger errors: `--error`"
        };
        return Diagnostic::new("E0609", message).help(help);
    }
    let message = format!(
        "at t = {time} s `{}` is known to lie in {} only; written with {decimals} decimals this \
         takes too much of its error bound",
        output.name,
        numbers::show(value)
    );
    Diagnostic::new("E0609", message).help(
        "use more internal steps (`--steps`) or decimals (`--decimals`), or a larger `--error`",
    )
}

fn not_allowed(output: &Output, time: &Decimal, bound: f64) -> Diagnostic {
    let message = format!(
        "at t = {time} s an error of `{}` up to {bound} is more than the model allows",
        output.name
    );
    Diagnostic::new("E0610", message).help("choose a smaller `--error`")
}
