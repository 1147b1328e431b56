//! `veribound enclose`: bounds of all solutions of a model, without a record.

mod diagnosis;
pub mod files;
mod page;
pub mod told;
mod trajectories;

use super::arguments::Enclose;
use super::ending::Ending;
use super::interrupt::Interrupt;
use super::message::{remark, say};
use super::page::Material;
use super::profile::{Profile, Stretch};
use super::{Outcome, engine, overwriting, progress, run_info};
use diagnosis::{Cause, PastUse};
pub use files::{meta, mode_names, plane};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use trajectories::Drawn;
use veribound_data::{EnclosureSummary, RecordInfo, TableSource};
use veribound_flow::engine::{Engines, Task};
use veribound_flow::form::{self, Effort, Enclosure, FormOptions, Standing};
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
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

/// What a run works on, all of it checked.
pub struct Prepared {
    /// The model.
    pub model: Model,
    /// What is assumed beside the model file, in sentences.
    pub said: Vec<String>,
    course: Course,
    plane: files::Plane,
}

/// A run that is done.
pub struct Done {
    /// The model.
    pub model: Model,
    /// The times that are proved.
    pub times: Vec<Decimal>,
    /// What it came to.
    pub found: Findings,
    /// What is told of it.
    pub summary: EnclosureSummary,
}

/// Encloses, and writes as much as is proved.
pub fn run(arguments: &Enclose) -> Outcome {
    // [1/4] Input: flags, model, profile.
    refuse_flags(arguments)?;
    let model = Model::from_file(&arguments.model)?;
    let source = arguments.times.input.as_ref().map(TableSource::from);
    let prepared = Prepared::new(arguments, model, source)?;
    if !arguments.showing.quiet {
        let said = prepared.said.iter();
        said.for_each(|note| remark(&format!("note: {note}")));
    }

    // [2/4] and [3/4] The enclosure, true trajectories in it, and the files.
    let interrupt = Interrupt::listen();
    let bar = progress::of_standing(arguments.showing.quiet);
    let first = prepared.first();
    let done = prepared.carry_out(arguments, true, &|standing| {
        bar.set_message(in_words(standing, first));
        bar.tick();
        !interrupt.is_asked()
    });
    bar.finish_and_clear();
    let Done {
        model,
        times,
        found,
        summary,
    } = done?;

    // [4/4] What the user is told.
    told::explain(&model, &times, &found);
    if arguments.showing.json {
        say(&summary.to_json()?);
    } else if !arguments.showing.quiet {
        let place = (arguments.output.as_path(), arguments.showing.pictures());
        say(&told::table(&model, &times, (&found, &summary), place));
    }
    Ok(found.ending)
}

/// Refuses what no run could do, and results in the place of what the run reads.
pub fn refuse_flags(arguments: &Enclose) -> Result<(), Diagnostic> {
    arguments.showing.refuse()?;
    let mut files = vec![("the model file", arguments.model.as_path())];
    let profile = arguments.times.input.as_deref();
    files.extend(profile.map(|path| ("the profile", path)));
    overwriting::refuse_results(&arguments.output, &files, &[])
}

/// Where a run stands, in one line; `first` is the time of its start.
pub fn in_words(standing: Standing, first: f64) -> String {
    let time = first + standing.reached;
    let (part, parts) = (standing.done + 1, standing.done + standing.waiting + 1);
    format!("at {time:.4} s, part {part} of {parts}")
}

impl Prepared {
    /// Checks flags and profile.
    pub fn new(
        arguments: &Enclose,
        model: Model,
        inputs: Option<TableSource>,
    ) -> Result<Prepared, Diagnostics> {
        let plane = files::plane(&model, &arguments.plane)?;
        let course = course(Profile::open(&arguments.times, inputs, &model)?, &model)?;
        let mut said = Vec::new();
        if let Coverage::Unproved(place) = &model.coverage {
            said.push(format!(
                "the guards of the modes leave no gap, which is not proved: {place}"
            ));
        }
        Ok(Prepared {
            model,
            said,
            course,
            plane,
        })
    }

    /// The time of the start, in seconds.
    pub fn first(&self) -> f64 {
        let first = self.course.times.first();
        first.map_or(0.0, |t| t.to_interval().mid())
    }

    /// Encloses, as long as `go_on` says so, and writes the files if they are wanted.
    pub fn carry_out(
        self,
        arguments: &Enclose,
        wants_files: bool,
        go_on: &(dyn Fn(Standing) -> bool + Sync),
    ) -> Result<Done, Diagnostics> {
        let Prepared {
            model,
            said,
            course,
            plane,
        } = self;
        let folder = wants_files.then(|| arguments.showing.folder(&arguments.output));
        let folder = folder.transpose()?;
        let found = enclose(arguments, &model, &course, go_on)?;
        let mut times = course.times;
        times.truncate(found.rows);
        let summary = told::summary(&model, &times, &found, said.clone());
        if let Some(folder) = folder {
            let json = summary.to_json()?;
            let info = run_info::of_enclosure(arguments, &model, course.profile, &said);
            let page = Material::page_if_wanted(
                &arguments.showing,
                (&model, &info),
                (&json, &said),
                |material| page::page(material, &times, &found),
            )?;
            files::write(
                (&folder, &arguments.showing.figures, plane),
                &model,
                (&times, &found),
                (&info, &json, page),
            )?;
        }
        Ok(Done {
            model,
            times,
            found,
            summary,
        })
    }
}

/// The times of the rows, and what holds between them.
fn course(mut profile: Profile, model: &Model) -> Result<Course, Diagnostic> {
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
    go_on: &(dyn Fn(Standing) -> bool + Sync),
) -> Result<Findings, Diagnostics> {
    let start: Vec<Interval> = model.states.iter().map(|state| state.init).collect();
    let params: Vec<Interval> = model.params.iter().map(|param| param.bounds).collect();
    let effort = Effort {
        parts: arguments.parts,
        ..Effort::default()
    };
    let is_interrupted = AtomicBool::new(false);
    let go_on = |standing: Standing| {
        let goes_on = go_on(standing);
        is_interrupted.store(!goes_on, Ordering::Relaxed);
        goes_on
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
    let is_interrupted = is_interrupted.into_inner();
    let rows = course.times.len().min(enclosure.ends.len() + 1);
    let ending = match &enclosure.stopped {
        _ if is_interrupted => Ending::Interrupted,
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
