//! `veribound identify`: what whole records leave of the parameters, proved from both sides.

pub mod arguments;
mod files;
mod page;
mod told;
mod verdict;

use super::ending::Ending;
use super::interrupt::Interrupt;
use super::message::say;
use super::numbers::show_times;
use super::page::{Material, is_wanted};
use super::{Outcome, assumptions, overwriting, progress, reading, run_info};
use arguments::Identify;
use std::time::Instant;
use veribound_data::{Printed, Record, ResultFolder};
use veribound_estimate::identify::{
    Bounds, Conclusion, Identified, IdentifyOptions, Progress, identify,
};
use veribound_interval::Interval;
use veribound_interval::text::upper;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_model::{Model, Sample};

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
    /// Time spent, in seconds.
    pub seconds: f64,
    /// How it ended.
    pub ending: Ending,
}

/// Identifies. Everything that can be wrong with the input is found before anything is written.
pub fn run(arguments: &Identify) -> Outcome {
    // [1/4] Input: flags, model, records.
    refuse_flags(arguments)?;
    let quiet = arguments.showing.quiet;
    let mut model = Model::from_file(&arguments.model)?;
    let mut said = assumptions::weaken(&mut model, &arguments.weakening)?;
    let data = Data::read(arguments, &model)?;
    said.extend(reading::assumed(&model, &data.records, &arguments.reading));
    reading::remarks(&data.records, &said, quiet);
    let folder = ResultFolder::create(&arguments.output)?.with_parquet(arguments.showing.parquet);

    // [2/4] The identification.
    let found = find(&model, &data, &arguments.options(), quiet);

    // [3/4] The files.
    let summary = told::summary(&model, &data, &found, said.clone());
    let json = summary.to_json()?;
    let info = run_info::of_identification(arguments, (&model, &data.records), &said);
    let page = if is_wanted(&arguments.showing) {
        let material = Material {
            model: &model,
            info: &info,
            printed: &Printed::of(&json)?,
            assumed: &said,
        };
        Some(page::page(&material, &data, &found)?)
    } else {
        None
    };
    files::write(
        (&folder, &arguments.showing.figures),
        (&model, &data, &found),
        (&info, &json, page),
    )?;

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

/// Refuses what no run could do, and results in the place of what the run reads.
fn refuse_flags(arguments: &Identify) -> Result<(), Diagnostic> {
    arguments.showing.refuse()?;
    let records = arguments.records.iter();
    let mut files = vec![("the model file", arguments.model.as_path())];
    files.extend(records.map(|record| ("the record", record.as_path())));
    overwriting::refuse_results(&arguments.output, &files, &[])
}

impl Data {
    fn read(arguments: &Identify, model: &Model) -> Result<Data, Diagnostics> {
        let (reading, quiet) = (&arguments.reading, arguments.showing.quiet);
        let records = arguments.records.iter();
        let records: Vec<Record> = records
            .map(|path| reading::open(path, model, reading, quiet))
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

/// Lets the estimator work, and shows how far it is.
fn find(model: &Model, data: &Data, options: &IdentifyOptions, quiet: bool) -> Findings {
    let interrupt = Interrupt::listen();
    let bar = progress::of_standing(quiet);
    let go_on = |standing: &Progress| {
        bar.set_message(in_words(standing));
        bar.tick();
        !interrupt.is_asked()
    };
    let begin = Instant::now();
    let identified = identify(model, &data.samples, options, &go_on);
    let seconds = begin.elapsed().as_secs_f64();
    bar.finish_and_clear();
    Findings {
        ending: ending(&identified),
        identified,
        seconds,
    }
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

fn in_words(standing: &Progress) -> String {
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
