//! `veribound observe`: from a model file and a record to proved bounds.

use super::arguments::{Observe, Showing};
use super::ending::Ending;
use super::files::{Files, figure_meta};
use super::flags::ZoomFlag;
use super::interrupt::Interrupt;
use super::{
    Outcome, assumptions, message, overlay, overwriting, page, progress, reading, run_info, table,
    verdict,
};
use std::path::Path;
use std::time::Instant;
use veribound_data::{
    FileInfo, ParameterSummary, Record, Start, StateSummary, Summary, TableSource, Work,
};
use veribound_estimate::{Estimate, Observer, Refutation, Undecided, Verdict};
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_model::{Model, Sample};
use veribound_report::Zoom;

/// What a run came to.
pub struct Findings {
    /// How it ended.
    pub ending: Ending,
    /// The last estimate and its time; none when not even the first sample was decided.
    pub last: Option<(Decimal, Estimate)>,
    /// The proof that model and record contradict each other.
    pub refutation: Option<Refutation>,
    /// Why the run stopped without a proof.
    pub undecided: Option<Undecided>,
    /// For every parameter the time of its last reset.
    pub resets: Vec<Option<Decimal>>,
    /// Samples after which the model was not refuted.
    pub samples: usize,
    /// What it cost.
    pub work: Work,
}

/// What a run works on, all of it checked.
pub struct Prepared {
    /// The model, weakened as the flags say.
    pub model: Model,
    /// The record.
    pub record: Record,
    /// What is assumed beside the model file, in sentences.
    pub said: Vec<String>,
    observer: Observer,
    /// The files of the run from which this one starts.
    start: Vec<FileInfo>,
}

/// A run that is done.
pub struct Done {
    /// The model, weakened as the flags say.
    pub model: Model,
    /// The record.
    pub record: Record,
    /// What it came to.
    pub found: Findings,
    /// The boxes that are left; none of a refuted model.
    pub cells: Vec<veribound_estimate::Cell>,
    /// `summary.json`.
    pub json: String,
}

/// Observes. Everything that can be wrong with the input is found before anything is written.
pub fn run(arguments: &Observe) -> Outcome {
    // [1/4] Input: model, flags, record, earlier runs.
    refuse_flags(arguments)?;
    let model = Model::from_file(&arguments.model)?;
    let quiet = arguments.showing.output.quiet;
    let source = TableSource::from(&arguments.record);
    let bar = progress::of_parts(source.bytes(), "of the record checked", quiet);
    let prepared = Prepared::new(arguments, model, source, &mut |bytes| {
        bar.set_position(bytes);
    });
    bar.finish_and_clear();
    let prepared = prepared?;
    reading::remarks(
        std::slice::from_ref(&prepared.record),
        &prepared.said,
        quiet,
    );

    // [2/4] and [3/4] The record, sample by sample, and the files.
    let interrupt = Interrupt::listen();
    let bar = progress::of_samples(prepared.record.len(), quiet);
    let done = prepared.carry_out(arguments, true, &mut |_, _| bar.inc(1), &|| {
        !interrupt.is_asked()
    });
    bar.finish_and_clear();
    let Done {
        model,
        record,
        found,
        json,
        ..
    } = done?;

    // [4/4] What the user is told.
    verdict::explain(&model, &record, &found, !quiet);
    if arguments.showing.output.json {
        message::say(&json);
    } else if !quiet {
        let place = (
            arguments.output.as_path(),
            arguments.showing.output.pictures(),
        );
        message::say(&table::of(&model, &record, &found, place));
    }
    Ok(found.ending)
}

impl Prepared {
    /// Checks flags, record and the run to start from; tells `watch` how many bytes of the record have
    /// been checked.
    pub fn new(
        arguments: &Observe,
        mut model: Model,
        source: TableSource,
        watch: &mut dyn FnMut(u64),
    ) -> Result<Prepared, Diagnostics> {
        let mut said = assumptions::weaken(&mut model, &arguments.assumptions.weakening)?;
        assumptions::refuse_outliers(&model)?;
        let record = reading::open(source, &model, &arguments.reading, watch)?;
        let records = std::slice::from_ref(&record);
        said.extend(reading::assumed(&model, records, &arguments.reading));
        let mut observer = Observer::new(&model, arguments.method.options());
        let start = match &arguments.assumptions.start_from {
            Some(folder) => start_from(folder, &model, &mut observer, &mut said)?,
            None => Vec::new(),
        };
        Ok(Prepared {
            model,
            record,
            said,
            observer,
            start,
        })
    }

    /// Goes through the record, as long as `go_on` says so, and writes the files if they are wanted. `each`
    /// is told every sample with its estimate.
    pub fn carry_out(
        self,
        arguments: &Observe,
        wants_files: bool,
        each: &mut dyn FnMut(&Sample, &Estimate),
        go_on: &dyn Fn() -> bool,
    ) -> Result<Done, Diagnostics> {
        let Prepared {
            model,
            record,
            said,
            mut observer,
            start,
        } = self;
        let mut written = None;
        let showing = &arguments.showing.output;
        if wants_files {
            let mut meta = figure_meta(&model, zoom(arguments), sample_time_ms(&record));
            meta.page = page::is_wanted(showing);
            let other = arguments.showing.overlay.as_deref();
            let other = other
                .map(|folder| overlay::read(folder, &model, &meta))
                .transpose()?;
            let (other, overlay) = other.unzip();
            let earlier = run_info::Earlier { start, overlay };
            let info = run_info::of(arguments, (&model, &record), earlier, &said);
            let folder = showing.folder(&arguments.output)?;
            written = Some((Files::create(&model, folder, meta)?, other, info));
        }
        let mut take = |sample: &Sample, estimate: &Estimate, seconds: f64| {
            each(sample, estimate);
            match &mut written {
                Some((files, ..)) => files.sample(sample, estimate, seconds),
                None => Ok(()),
            }
        };
        let found = follow(&record, &model, &mut observer, &mut take, go_on)?;
        let cells = if found.refutation.is_some() {
            Vec::new()
        } else {
            observer.cells().to_vec()
        };
        let json = summary(&model, &record, &found, said.clone()).to_json()?;
        if let Some((mut files, other, info)) = written {
            if let Some(refutation) = &found.refutation {
                files.refuted_at(refutation);
            }
            let page = page::Material::page_if_wanted(
                showing,
                (&model, &info),
                (&json, &said),
                |material| page::observation(material, &record, &found, arguments.method.boxes),
            )?;
            let end = found.last.as_ref().map_or(record.first(), |(time, _)| time);
            let formats = showing.figures.as_slice();
            let drawn = (formats, other.as_ref());
            files.finish((end, &cells), &info, &json, (drawn, page))?;
        }
        Ok(Done {
            model,
            record,
            found,
            cells,
            json,
        })
    }
}

fn zoom(arguments: &Observe) -> Zoom {
    match &arguments.showing.zoom {
        ZoomFlag::Auto => Zoom::Auto,
        ZoomFlag::Off => Zoom::Off,
        ZoomFlag::Window(from, to) => {
            Zoom::Window(from.to_interval().mid(), to.to_interval().mid())
        }
    }
}

/// Refuses what no run could do, and results in the place of what the run reads.
pub fn refuse_flags(arguments: &Observe) -> Result<(), Diagnostic> {
    let Showing {
        output, overlay, ..
    } = &arguments.showing;
    output.refuse()?;
    let files = [
        ("the model file", arguments.model.as_path()),
        ("the record", arguments.record.as_path()),
    ];
    let start = arguments.assumptions.start_from.as_deref();
    let start = start.map(|folder| ("from which this one starts", folder));
    let overlay = overlay.as_deref();
    let overlay = overlay.map(|folder| ("which the figures are to show", folder));
    let earlier: Vec<_> = start.into_iter().chain(overlay).collect();
    overwriting::refuse_results(&arguments.output, &files, &earlier)
}

/// Puts the boxes of an earlier run into the observer; gives the files they come from.
fn start_from(
    folder: &Path,
    model: &Model,
    observer: &mut Observer,
    said: &mut Vec<String>,
) -> Result<Vec<FileInfo>, Diagnostic> {
    let start = Start::read(folder, model)?;
    let boxes = if start.boxes.is_empty() {
        vec![start.params]
    } else {
        start.boxes
    };
    if !observer.start_from(&boxes) {
        let shown = folder.display();
        let message = format!("no box of the run in `{shown}` lies inside the priors of the model");
        return Err(Diagnostic::new("E0606", message)
            .help("start from a run of a model with priors that overlap these"));
    }
    let which = match boxes.len() {
        1 => "the box".to_owned(),
        count => format!("the {count} boxes"),
    };
    let mut change = format!(
        "the parameters lie in {which} that the run in {} left (--start-from)",
        folder.display()
    );
    let resettable = |at: usize| {
        model
            .signals
            .iter()
            .any(|signal| signal.resets.iter().any(|reset| reset.param == at))
    };
    let names: Vec<&str> = (model.params.iter().enumerate())
        .filter(|(at, _)| resettable(*at))
        .map(|(_, param)| param.name.as_str())
        .collect();
    if !names.is_empty() {
        let names = message::list(names);
        change.push_str(&format!("; not taken for {names}, which can be reset"));
    }
    said.push(change);
    let earlier = start.assumptions.into_iter();
    said.extend(earlier.map(|assumption| format!("that run assumed: {assumption}")));
    Ok(start.files)
}

/// The average time between two samples.
fn sample_time_ms(record: &Record) -> Option<f64> {
    let whole = (record.last() - record.first()).to_interval().mid();
    (record.len() > 1).then(|| whole / (record.len() - 1) as f64 * 1e3)
}

/// Steps the observer through the record, and tells `each` what is known after every sample.
fn follow(
    record: &Record,
    model: &Model,
    observer: &mut Observer,
    each: &mut dyn FnMut(&Sample, &Estimate, f64) -> Result<(), Diagnostic>,
    go_on: &dyn Fn() -> bool,
) -> Result<Findings, Diagnostics> {
    let started = Instant::now();
    let mut found = Findings {
        ending: Ending::Done,
        last: None,
        refutation: None,
        undecided: None,
        resets: vec![None; model.params.len()],
        samples: 0,
        work: Work::default(),
    };
    for sample in record.samples()? {
        if !go_on() {
            found.ending = Ending::Interrupted;
            break;
        }
        let sample: Sample = sample?;
        let begun = Instant::now();
        let verdict = observer
            .step(&sample)
            .map_err(|misuse| changed(record, &misuse))?;
        let seconds = begun.elapsed().as_secs_f64();
        found.work.worst_sample_s = found.work.worst_sample_s.max(seconds);
        match verdict {
            Verdict::Consistent(estimate) => {
                each(&sample, &estimate, seconds)?;
                for (last, is_reset) in found.resets.iter_mut().zip(&estimate.resets) {
                    if *is_reset {
                        *last = Some(sample.time.clone());
                    }
                }
                found.samples += 1;
                found.last = Some((sample.time, estimate));
            }
            Verdict::Inconsistent(refutation) => {
                found.ending = Ending::Inconsistent;
                found.refutation = Some(refutation);
                break;
            }
            Verdict::Undecided(undecided) => {
                found.ending = Ending::Undecided;
                found.undecided = Some(undecided);
                break;
            }
        }
    }
    found.work.wall_s = started.elapsed().as_secs_f64();
    found.work.box_steps = observer.box_steps();
    found.work.boxes_max = observer.boxes_max();
    Ok(found)
}

/// The record was checked before; a sample that does not fit now means that it was changed.
fn changed(record: &Record, misuse: &veribound_estimate::Misuse) -> Diagnostic {
    let name = record.path().display();
    Diagnostic::new(
        "E0417",
        format!("`{name}` was changed while it was read: {misuse}"),
    )
    .help("run again when nothing writes to the record")
}

fn summary(model: &Model, record: &Record, found: &Findings, assumptions: Vec<String>) -> Summary {
    let refuted = found.refutation.is_some();
    let last = found.last.as_ref().map(|(_, estimate)| estimate);
    let known = |bounds: Option<&Interval>, before: Interval| {
        if refuted {
            Interval::EMPTY
        } else {
            bounds.copied().unwrap_or(before)
        }
    };
    let params = model.params.iter().enumerate().map(|(at, param)| {
        let bounds = known(last.and_then(|last| last.params.get(at)), param.bounds);
        (param.name.clone(), ParameterSummary::new(param, bounds))
    });
    let states = model.states.iter().enumerate().map(|(at, state)| {
        let bounds = known(last.and_then(|last| last.states.get(at)), state.init);
        (state.name.clone(), StateSummary::new(state, bounds))
    });
    let (verdict, reason) = verdict::in_words(model, found);
    Summary {
        verdict,
        reason,
        refutation: found
            .refutation
            .as_ref()
            .map(|refutation| verdict::entry(model, refutation)),
        samples: found.samples,
        parameters: params.collect(),
        states: states.collect(),
        work: found.work,
        interrupted: found.ending == Ending::Interrupted,
        assumptions,
        missing: record.missing().to_vec(),
    }
}
