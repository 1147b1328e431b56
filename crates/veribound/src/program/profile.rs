//! The times of a simulated record, and the inputs over time.

use super::arguments::Simulate;
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;
use veribound_data::{Record, RecordOptions};
use veribound_interval::{Decimal, Interval};
use veribound_model::Model;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};

/// One sample of the record to be: inputs hold from here to the next.
pub struct Stretch {
    /// Time of the sample.
    pub time: Decimal,
    /// The inputs as they are written, in the order of the model.
    pub texts: Vec<Decimal>,
    /// The inputs.
    pub inputs: Vec<Interval>,
    /// Time to the next sample; none at the last.
    pub to_next: Option<Decimal>,
}

/// Times and inputs of a record to be.
pub struct Profile {
    /// Times at which inputs take new values, with these.
    points: Vec<(Decimal, Vec<Decimal>)>,
    until: Decimal,
    /// Time between samples; none: the times of the points.
    every: Option<Decimal>,
}

impl Profile {
    /// Reads the profile that the flags name.
    pub fn read(arguments: &Simulate, model: &Model) -> Result<Profile, Diagnostics> {
        let points = match &arguments.input {
            Some(path) => read(path, model)?,
            None if model.inputs.is_empty() => vec![(Decimal::zero(), Vec::new())],
            None => {
                let name = model.inputs.first().map_or("", |input| input.name.as_str());
                return Err(Diagnostic::new("E0607", format!("the model has the input `{name}`"))
                    .help(format!(
                        "give its values with `--input PROFILE`, a CSV file with the header `t,{name}`"
                    ))
                    .into());
            }
        };
        if arguments
            .every
            .as_ref()
            .is_some_and(|every| *every <= Decimal::zero())
        {
            return Err(
                Diagnostic::new("E0608", "the time between two samples must be above 0 s")
                    .help("write, for instance, `--every 0.01`")
                    .into(),
            );
        }
        if arguments.every.is_none() && points.len() < 2 {
            return Err(
                Diagnostic::new("E0607", "the times of the samples are not given")
                    .help("say how long and how often: `--until 10 --every 0.01`")
                    .into(),
            );
        }
        let last = points.last().map(|(time, _)| time.clone());
        let until = arguments
            .until
            .clone()
            .or(last)
            .unwrap_or_else(Decimal::zero);
        Ok(Profile {
            points,
            until,
            every: arguments.every.clone(),
        })
    }

    /// The samples in the order of time.
    ///
    /// An error: inputs would change between two samples, which no record could say.
    pub fn stretches(&self) -> impl Iterator<Item = Result<Stretch, Diagnostic>> {
        let mut next = self.points.first().map(|(time, _)| time.clone());
        let mut held: &[Decimal] = &[];
        let mut points = self.points.iter().peekable();
        std::iter::from_fn(move || {
            let time = next.take().filter(|time| *time <= self.until)?;
            while let Some((at, values)) = points.next_if(|(at, _)| *at <= time) {
                if *at < time {
                    return Some(Err(between(at)));
                }
                held = values;
            }
            let following = match &self.every {
                Some(every) => Some(&time + every),
                None => points.peek().map(|(at, _)| at.clone()),
            };
            let following = following.filter(|following| *following <= self.until);
            let to_next = following.as_ref().map(|following| following - &time);
            next = following;
            Some(Ok(Stretch {
                time,
                texts: held.to_vec(),
                inputs: held.iter().map(Decimal::to_interval).collect(),
                to_next,
            }))
        })
    }
}

/// Checks the profile as a record of inputs, then takes the decimals as they are written: the record
/// to be repeats them.
fn read(path: &Path, model: &Model) -> Result<Vec<(Decimal, Vec<Decimal>)>, Diagnostics> {
    let mut inputs = model.clone();
    inputs.outputs.clear();
    inputs.signals.clear();
    let record = Record::open(path, &inputs, RecordOptions::default())?;
    let refuse = |what: String| {
        Diagnostic::new(
            "E0417",
            format!("`{}` cannot be read again: {what}", path.display()),
        )
        .help("run again when nothing writes to the profile")
    };
    let separator = separator(path).map_err(|error| refuse(error.to_string()))?;
    let mut table = csv::ReaderBuilder::new()
        .delimiter(separator)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|error| refuse(error.to_string()))?;
    let header = table
        .headers()
        .map_err(|error| refuse(error.to_string()))?
        .clone();
    let mut places = Vec::new();
    for (variable, column) in record.columns() {
        let place = header.iter().position(|name| name == column);
        let message = format!("`{variable}` must be one column of plain numbers, not `{column}`");
        let no_column = || Diagnostic::new("E0608", message).help("write one value per line");
        places.push(place.ok_or_else(no_column)?);
    }
    let mut points = Vec::new();
    for row in table.records() {
        let row = row.map_err(|error| refuse(error.to_string()))?;
        let decimals = places
            .iter()
            .map(|place| Decimal::parse(row.get(*place)?).ok());
        let mut decimals: Vec<Decimal> = decimals
            .collect::<Option<_>>()
            .ok_or_else(|| refuse(format!("line {} is not complete", points.len() + 2)))?;
        if !decimals.is_empty() {
            points.push((decimals.remove(0), decimals));
        }
    }
    Ok(points)
}

/// The separator of the header line, by the rule of the record reader: tab, then semicolon, then
/// comma.
fn separator(path: &Path) -> std::io::Result<u8> {
    for line in BufReader::new(File::open(path)?).lines() {
        let line = line?;
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let found = [b'\t', b';']
            .into_iter()
            .find(|mark| line.as_bytes().contains(mark));
        return Ok(found.unwrap_or(b','));
    }
    Ok(b',')
}

fn between(time: &Decimal) -> Diagnostic {
    Diagnostic::new(
        "E0608",
        format!("the profile changes at t = {time} s, between two samples of the record"),
    )
    .help("choose `--every` so that every time of the profile is the time of a sample")
}
