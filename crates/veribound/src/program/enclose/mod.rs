//! `veribound enclose`: bounds of all solutions of a model, without a record.

mod diagnosis;
mod files;
mod told;
mod trajectories;

use super::arguments::{Enclose, Format};
use super::ending::Ending;
use super::interrupt::Interrupt;
use super::message::{remark, say};
use super::profile::{Profile, Stretch};
use super::{Outcome, engine, overwriting, progress, run_info};
use diagnosis::{Cause, PastUse};
pub use files::{meta, mode_names, plane};
use std::time::Instant;
use trajectories::Drawn;
use veribound_data::{RecordInfo, ResultFolder};
use veribound_flow::engine::{Engines, Task};
use veribound_flow::form::{self, Effort, Enclosure, FormOptions, Standing};
use veribound_interval::{Decimal, Interval};
use veribound_model::{Coverage, Model};

/// The times of the table, and what holds from each to the next.
pub struct Course {
    /// One per row.
    pub times: Vec<Decimal>,
    /// One per time; the last has no length.
    pub stretches: Vec<form::Stretch>,
    /// The profile that was read.
    profile: Option<RecordInfo>,
}

/// What a run came to.
pub struct Findings {
    /// What is proved.
    pub enclosure: Enclosure,
    /// The engines that proved it, and why no others.
    pub engine: String,
    /// Number of rows that are proved, the start included.
    pub rows: usize,
    /// True trajectories.
    pub drawn: Vec<Drawn>,
    /// Whether they were asked for.
    pub asked: bool,
    /// States whose widths grew past use.
    pub past_use: Vec<PastUse>,
    /// What stood in the way, where the enclosure ended early.
    pub obstacle: Option<Cause>,
    /// Time spent, in seconds.
    pub seconds: f64,
    /// How it ended.
    pub ending: Ending,
}

/// Encloses, and writes as much as is proved.
pub fn run(arguments: &Enclose) -> Outcome {
    // [1/4] Input: flags, model, profile.
    arguments.showing.refuse()?;
    let mut files = vec![("the model file", arguments.model.as_path())];
    let profile = arguments.times.input.as_deref();
    files.extend(profile.map(|path| ("the profile", path)));
    overwriting::refuse_results(&arguments.output, &files, &[])?;
    let model = Model::from_file(&arguments.model)?;
    let plane = files::plane(&model, &arguments.plane)?;
    let course = course(arguments, &model)?;
    let mut said = Vec::new();
    if let Coverage::Unproved(place) = &model.coverage {
        said.push(format!(
            "the guards of the modes leave no gap, which is not proved: {place}"
        ));
    }
    if !arguments.showing.quiet {
        said.iter()
            .for_each(|note| remark(&format!("note: {note}")));
    }
    let folder = ResultFolder::create(&arguments.output)?;

    // [2/4] The enclosure, and true trajectories in it.
    let interrupt = Interrupt::listen();
    let found = enclose(arguments, &model, &course, &interrupt)?;

    // [3/4] The files.
    let times = course.times.get(..found.rows).unwrap_or_default();
    let summary = told::summary(&model, times, &found, said.clone());
    let json = summary.to_json()?;
    let info = run_info::of_enclosure(arguments, &model, course.profile.clone(), &said);
    files::write(
        (&folder, &arguments.showing.figures, plane),
        &model,
        (times, &found),
        (&info, &json),
    )?;

    // [4/4] What the user is told.
    told::explain(&model, times, &found);
    if arguments.showing.json {
        say(&json);
    } else if !arguments.showing.quiet {
        let figures = !arguments.showing.figures.contains(&Format::None);
        let place = (arguments.output.as_path(), figures);
        say(&told::table(&model, times, (&found, &summary), place));
    }
    Ok(found.ending)
}

/// The times of the rows, and what holds between them.
fn course(arguments: &Enclose, model: &Model) -> Result<Course, veribound_model::Diagnostics> {
    let mut profile = Profile::open(&arguments.times, model)?;
    let mut course = Course {
        times: Vec::new(),
        stretches: Vec::new(),
        profile: profile.record().map(RecordInfo::of),
    };
    while let Some(stretch) = profile.next()? {
        let Stretch {
            time,
            inputs,
            to_next,
            ..
        } = stretch;
        let recorded = model.recorded_inputs().zip(inputs);
        let mut inputs: Vec<Interval> = recorded
            .map(|(input, value)| input.error.enclose(value))
            .collect();
        inputs.extend(model.disturbances().map(|(_, bounds)| bounds));
        course.times.push(time);
        let dt = to_next.map_or(Interval::ZERO, |dt| dt.to_interval());
        course.stretches.push(form::Stretch { inputs, dt });
    }
    Ok(course)
}

/// Encloses, and draws trajectories.
fn enclose(
    arguments: &Enclose,
    model: &Model,
    course: &Course,
    interrupt: &Interrupt,
) -> Result<Findings, veribound_model::Diagnostics> {
    let start: Vec<Interval> = model.states.iter().map(|state| state.init).collect();
    let params: Vec<Interval> = model.params.iter().map(|param| param.bounds).collect();
    let effort = Effort {
        parts: arguments.parts,
        ..Effort::default()
    };
    let bar = progress::of_standing(arguments.showing.quiet);
    let first = course.times.first().map_or(0.0, |t| t.to_interval().mid());
    let go_on = |standing: Standing| {
        let time = first + standing.reached;
        let (part, parts) = (standing.done + 1, standing.done + standing.waiting + 1);
        bar.set_message(format!("at {time:.4} s, part {part} of {parts}"));
        bar.tick();
        !interrupt.is_asked()
    };
    let begin = Instant::now();
    let task = Task {
        states: &start,
        params: &params,
        stretches: &course.stretches,
        options: FormOptions::default(),
        effort,
    };
    let answer = Engines::new(model).enclose(arguments.engine.into(), task, &go_on);
    let engine = engine::told(model, &answer);
    let enclosure = answer.enclosure;
    let seconds = begin.elapsed().as_secs_f64();
    bar.finish_and_clear();
    let rows = course.times.len().min(enclosure.ends.len() + 1);
    let ending = match &enclosure.stopped {
        _ if interrupt.is_asked() => Ending::Interrupted,
        Some(_) if rows < course.times.len() => Ending::Undecided,
        _ => Ending::Done,
    };
    let times = course.times.get(..rows).unwrap_or_default();
    let proved = (times, &enclosure);
    let past_use = diagnosis::past_use(model, course, proved, arguments.parts);
    let obstacle = diagnosis::obstacle(model, course, &enclosure, arguments.parts);
    let drawn = if arguments.sample > 0 && ending != Ending::Interrupted {
        trajectories::draw(
            model,
            course,
            &enclosure,
            (arguments.sample, arguments.seed),
        )?
    } else {
        Vec::new()
    };
    Ok(Findings {
        enclosure,
        engine,
        rows,
        drawn,
        asked: arguments.sample > 0 && ending != Ending::Interrupted,
        past_use,
        obstacle,
        seconds,
        ending,
    })
}
