//! `veribound identify`: what whole records leave of the parameters, proved from both sides.

pub mod arguments;
mod checkpoint;
mod course;
pub mod files;
mod page;
pub mod told;
pub mod verdict;

use super::arguments::Reading;
use super::ending::Ending;
use super::interrupt::Interrupt;
use super::message::say;
use super::numbers::show_times;
use super::page::Material;
use super::{Outcome, assumptions, overwriting, progress, reading, run_info};
use arguments::Identify;
use checkpoint::Checkpoint;
use indicatif::ProgressBar;
use std::time::Instant;
use veribound_data::{Record, TableSource};
use veribound_estimate::identify::{
    Bounds, Checkpoints, Conclusion, Identified, LeastError, Progress, Unreadable,
    least_disturbance, least_error, resume,
};
use veribound_interval::Interval;
use veribound_interval::text::upper;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_model::{Input, Model, Sample};

/// The records of a run, and all that was read from them.
pub struct Data {
    /// One or more.
    pub records: Vec<Record>,
    /// The samples of each.
    pub samples: Vec<Vec<Sample>>,
}

/// What a run came to.
pub struct Findings {
    /// What is proved.
    pub identified: Identified,
    /// How large measurement errors must be for anything to agree, where that was looked for.
    pub least: Option<LeastError>,
    /// The least errors of inputs and disturbances, where that was asked for.
    pub least_disturbance: Option<LeastError>,
    /// Time spent, in seconds.
    pub seconds: f64,
    /// How it ended.
    pub ending: Ending,
}

/// What a run works on, all of it checked.
pub struct Prepared {
    /// The model, weakened as the flags say.
    pub model: Model,
    /// The records.
    pub data: Data,
    /// What is assumed beside the model file, in sentences.
    pub said: Vec<String>,
}

/// A run that is done.
pub struct Done {
    /// The model, weakened as the flags say.
    pub model: Model,
    /// The records.
    pub data: Data,
    /// What it came to.
    pub found: Findings,
    /// `summary.json`.
    pub json: String,
}

/// Identifies. Everything that can be wrong with the input is found before anything is written.
pub fn run(arguments: &Identify) -> Outcome {
    // [1/4] Input: flags, model, records.
    refuse_flags(arguments)?;
    let quiet = arguments.showing.quiet;
    let model = Model::from_file(&arguments.model)?;
    let sources = arguments.records.iter().map(TableSource::from);
    let prepared = Prepared::new(arguments, model, sources.collect(), &mut |source| {
        progress::of_parts(source.bytes(), "of the record checked", quiet)
    })?;
    reading::remarks(&prepared.data.records, &prepared.said, quiet);

    // [2/4] and [3/4] The identification and its files.
    let interrupt = Interrupt::listen();
    let bar = progress::of_standing(quiet);
    let done = prepared.carry_out(arguments, true, &|standing| {
        bar.set_message(in_words(standing));
        bar.tick();
        !interrupt.is_asked()
    });
    bar.finish_and_clear();
    let Done {
        model,
        data,
        found,
        json,
    } = done?;

    // [4/4] What the user is told.
    verdict::explain(&model, &data, &found, !quiet);
    if arguments.showing.json {
        say(&json);
    } else if !quiet {
        let place = (arguments.output.as_path(), arguments.showing.pictures());
        say(&told::table(&model, &data, &found, place));
    }
    Ok(found.ending)
}

impl Prepared {
    /// Checks flags and records; `bar` gives a bar for the check of each.
    pub fn new(
        arguments: &Identify,
        mut model: Model,
        sources: Vec<TableSource>,
        bar: &mut dyn FnMut(&TableSource) -> ProgressBar,
    ) -> Result<Prepared, Diagnostics> {
        let mut said = assumptions::weaken(&mut model, &arguments.weakening)?;
        let is_uncertain = |input: &Input| {
            let error = &input.error;
            input.within.is_some() || !error.absolute.is_zero() || !error.relative.is_zero()
        };
        if arguments.least_disturbance && !model.inputs.iter().any(is_uncertain) {
            return Err(nothing_uncertain(&model).into());
        }
        let data = Data::read(sources, &model, &arguments.reading, bar)?;
        said.extend(reading::assumed(&model, &data.records, &arguments.reading));
        Ok(Prepared { model, data, said })
    }

    /// Lets the estimator work, as long as `go_on` says so, and writes the files if they are wanted.
    pub fn carry_out(
        self,
        arguments: &Identify,
        wants_files: bool,
        go_on: &(dyn Fn(&Progress) -> bool + Sync),
    ) -> Result<Done, Diagnostics> {
        let Prepared { model, data, said } = self;
        let folder = wants_files.then(|| arguments.showing.folder(&arguments.output));
        let folder = folder.transpose()?;
        let checkpoint = folder
            .as_ref()
            .map(|folder| Checkpoint::new(folder, arguments, &model, &data));
        let found = find((&model, &data), arguments, checkpoint.as_ref(), go_on)?;
        let json = told::summary(&model, &data, &found, said.clone()).to_json()?;
        if let Some(folder) = &folder {
            let info = run_info::of_identification(arguments, (&model, &data.records), &said);
            let page = Material::page_if_wanted(
                &arguments.showing,
                (&model, &info),
                (&json, &said),
                |material| page::page(material, &data, &found),
            )?;
            let courses = match &page {
                Some(_) => {
                    let standing = found.standing(&model);
                    course::all(&model, &data, &found, &|| go_on(&standing))?
                }
                None => Vec::new(),
            };
            files::write(
                (folder, &arguments.showing.figures),
                (&model, &data, &found),
                (&info, &json, page, &courses),
            )?;
        }
        // A run that was interrupted can go on.
        if let Some(checkpoint) = checkpoint.filter(|_| !found.identified.interrupted) {
            checkpoint.remove();
        }
        Ok(Done {
            model,
            data,
            found,
            json,
        })
    }
}

/// Refuses what no run could do, and results in the place of what the run reads.
pub fn refuse_flags(arguments: &Identify) -> Result<(), Diagnostic> {
    arguments.showing.refuse()?;
    let records = arguments.records.iter();
    let mut files = vec![("the model file", arguments.model.as_path())];
    files.extend(records.map(|record| ("the record", record.as_path())));
    overwriting::refuse_results(&arguments.output, &files, &[])
}

impl Data {
    fn read(
        sources: Vec<TableSource>,
        model: &Model,
        reading: &Reading,
        bar: &mut dyn FnMut(&TableSource) -> ProgressBar,
    ) -> Result<Data, Diagnostics> {
        let sources = sources.into_iter();
        let records: Vec<Record> = sources
            .map(|source| {
                let bar = bar(&source);
                let mut watch = |bytes| bar.set_position(bytes);
                let record = reading::open(source, model, reading, &mut watch);
                bar.finish_and_clear();
                record
            })
            .collect::<Result<_, _>>()?;
        let samples = records.iter().map(Record::all_samples);
        Ok(Data {
            samples: samples.collect::<Result<_, _>>()?,
            records,
        })
    }

    /// The name of a record as the user gave it.
    pub fn name(&self, record: usize) -> String {
        let record = self.records.get(record);
        record.map_or_else(String::new, |record| record.path().display().to_string())
    }

    /// Lines of the file with the samples at these positions.
    pub fn lines(&self, record: usize, samples: &[usize]) -> Vec<usize> {
        let all = self.samples.get(record).map_or(&[][..], Vec::as_slice);
        let lines = samples.iter().filter_map(|at| Some(all.get(*at)?.line));
        lines.collect()
    }

    /// Number of samples of all records.
    pub fn count(&self) -> usize {
        self.samples.iter().map(Vec::len).sum()
    }
}

impl Findings {
    /// Bounds of the parameters, in the order of the model; the prior where nothing was proved.
    pub fn params(&self, model: &Model) -> Vec<Bounds> {
        let priors = model.params.iter().map(|param| param.bounds);
        or_prior(&self.identified.params, priors)
    }

    /// Where the run stands at its end.
    fn standing(&self, model: &Model) -> Progress {
        let bounds = self.params(model);
        let shares = model.params.iter().zip(&bounds);
        let shares = shares.filter(|(param, _)| !param.bounds.is_point());
        Progress {
            sets: self.identified.sets,
            waiting: 0,
            left: shares
                .map(|(param, both)| both.outer.width() / param.bounds.width())
                .product(),
            tightness: bounds.iter().map(Bounds::tightness).fold(1.0, f64::max),
        }
    }

    /// Bounds of the states at the first sample of a record.
    pub fn start(&self, model: &Model, record: usize) -> Vec<Bounds> {
        let found = self.identified.starts.get(record);
        let priors = model.states.iter().map(|state| state.init);
        or_prior(found.map_or(&[][..], Vec::as_slice), priors)
    }
}

fn or_prior(found: &[Bounds], priors: impl Iterator<Item = Interval>) -> Vec<Bounds> {
    let unknown = |outer| Bounds { outer, inner: None };
    let bounds = priors.enumerate();
    bounds
        .map(|(at, prior)| found.get(at).copied().unwrap_or(unknown(prior)))
        .collect()
}

/// What the verdict tells of the least errors: as declared they are enough where something agrees, and too small where
/// nothing does.
fn with_verdict(mut least: LeastError, identified: &Identified) -> LeastError {
    let told = match identified.conclusion {
        Conclusion::Consistent => Interval::new(0.0, 1.0),
        Conclusion::Inconsistent(_) => Interval::new(1.0, f64::INFINITY),
        Conclusion::Undecided => None,
    };
    let factor = told.map(|told| least.factor.intersect(told));
    if let Some(factor) = factor.filter(|factor| !factor.is_empty()) {
        if factor.hi() < least.factor.hi() {
            least.point = identified.points.first().cloned();
        }
        least.factor = factor;
    }
    least
}

fn nothing_uncertain(model: &Model) -> Diagnostic {
    let message =
        "no input has an error, and there is no disturbance, whose least size could be told";
    let how = match model.recorded_inputs().next() {
        Some(input) => format!("with `--input-error {}=1%`", input.name),
        None => {
            "a `[disturbances]` section with `d = [-0.1, 0.1]`, and `d` in an equation".to_owned()
        }
    };
    Diagnostic::new("E0617", message).help(format!(
        "declare one, as {how}, or leave out `--least-disturbance`"
    ))
}

/// Lets the estimator work.
fn find(
    (model, data): (&Model, &Data),
    arguments: &Identify,
    checkpoint: Option<&Checkpoint<'_>>,
    go_on: &(dyn Fn(&Progress) -> bool + Sync),
) -> Result<Findings, Diagnostic> {
    let options = arguments.options();
    let begin = Instant::now();
    let kept = match checkpoint.filter(|_| arguments.resume) {
        Some(checkpoint) => checkpoint.read()?,
        None => None,
    };
    let save = |bytes: &dyn Fn() -> Vec<u8>| {
        if let Some(checkpoint) = checkpoint {
            checkpoint.save(bytes);
        }
    };
    let checkpoints = Checkpoints {
        from: kept.as_deref(),
        save: &save,
    };
    let identified = resume(model, &data.samples, &options, &checkpoints, go_on);
    let identified = match (identified, checkpoint) {
        (Ok(identified), _) => identified,
        (Err(Unreadable), Some(checkpoint)) => return Err(checkpoint.refuse("it is damaged")),
        (Err(Unreadable), None) => unreachable!("PROOF: nothing was read"),
    };
    // Who reads that nothing agrees asks how far it is from that.
    let is_refuted = matches!(identified.conclusion, Conclusion::Inconsistent(_));
    let is_asked = (is_refuted || arguments.least_error) && !identified.interrupted;
    let least = is_asked.then(|| {
        let least = least_error(model, &data.samples, &options, go_on);
        with_verdict(least, &identified)
    });
    let mut disturbed = None;
    if arguments.least_disturbance && !identified.interrupted {
        disturbed = least_disturbance(model, &data.samples, &options, go_on)
            .map(|least| with_verdict(least, &identified));
        if disturbed.is_none() {
            return Err(nothing_uncertain(model));
        }
    }
    Ok(Findings {
        ending: ending(&identified),
        identified,
        least,
        least_disturbance: disturbed,
        seconds: begin.elapsed().as_secs_f64(),
    })
}

/// What was proved stays proved, also of a run that was interrupted later.
fn ending(identified: &Identified) -> Ending {
    match identified.conclusion {
        Conclusion::Inconsistent(_) => Ending::Inconsistent,
        _ if identified.interrupted => Ending::Interrupted,
        Conclusion::Consistent => Ending::Done,
        Conclusion::Undecided => Ending::Undecided,
    }
}

/// Where a run stands, in one line.
pub fn in_words(standing: &Progress) -> String {
    let left = upper(100.0 * standing.left, 3);
    let bounds = match show_times(standing.tightness) {
        none if none.is_empty() => String::new(),
        times => format!(", bounds at most {times} too wide"),
    };
    format!(
        "{} sets looked at, {} wait, {left} % of the prior left{bounds}",
        standing.sets, standing.waiting
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_agrees_needs_no_larger_errors_than_declared() {
        let open = LeastError {
            factor: Interval::new(0.9, f64::INFINITY).unwrap(),
            point: None,
            sets: 1,
            passes: 1,
            interrupted: false,
        };
        let found = told::tests::found();
        let known = with_verdict(open.clone(), &found.identified);
        assert_eq!(known.factor, Interval::new(0.9, 1.0).unwrap());
        assert_eq!(known.point.as_ref(), found.identified.points.first());
        assert!(known.point.is_some());
        let mut refuted = found.identified;
        refuted.conclusion = Conclusion::Undecided;
        assert_eq!(with_verdict(open.clone(), &refuted), open);
        refuted.conclusion = Conclusion::Inconsistent(veribound_estimate::identify::Refuted {
            record: 0,
            samples: Vec::new(),
            time: veribound_interval::Decimal::zero(),
            line: 1,
        });
        let known = with_verdict(open, &refuted);
        assert_eq!(known.factor, Interval::new(1.0, f64::INFINITY).unwrap());
        assert_eq!(known.point, None);
    }

    #[test]
    fn a_line_says_where_it_stands() {
        let mut standing = Progress {
            sets: 12,
            waiting: 3,
            left: 0.012_34,
            tightness: f64::INFINITY,
        };
        assert_eq!(
            in_words(&standing),
            "12 sets looked at, 3 wait, 1.24 % of the prior left"
        );
        standing.tightness = 1.311_1;
        assert_eq!(
            in_words(&standing),
            "12 sets looked at, 3 wait, 1.24 % of the prior left, bounds at most 1.312 x too wide"
        );
    }
}
