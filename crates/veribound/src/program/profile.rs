//! The times of a simulated record, and the inputs over time.

use super::arguments::Times;
use super::{progress, same_units};
use std::path::{Path, PathBuf};
use veribound_data::{Record, RecordOptions, TableReader, TableSource};
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

/// Times and inputs of a record to be, in the order of time; memory does not grow with their number.
pub struct Profile {
    points: Points,
    /// The point after those that hold at `next`.
    following: Option<Point>,
    held: Vec<Decimal>,
    /// Time of the next sample.
    next: Option<Decimal>,
    from: Decimal,
    until: Decimal,
    /// Time between samples; none: the times of the points.
    every: Option<Decimal>,
}

/// A time at which the inputs take new values, and these.
struct Point {
    time: Decimal,
    values: Vec<Decimal>,
}

impl Profile {
    /// Opens the profile of these times, with inputs from a file or from memory.
    pub fn open(
        times: &Times,
        inputs: Option<TableSource>,
        model: &Model,
    ) -> Result<Profile, Diagnostics> {
        same_units::of_columns(model)?;
        let (mut points, last, count) = match inputs {
            Some(source) => {
                let record = check(&source, model)?;
                same_units::of_profile(&record)?;
                let (last, count) = (record.last().clone(), record.len());
                (Points::of_table(source, record)?, last, count)
            }
            None if model.recorded_inputs().next().is_none() => (Points::Start, Decimal::zero(), 1),
            None => {
                let mut names = model.recorded_inputs().map(|input| input.name.as_str());
                let name = names.next().unwrap_or("");
                return Err(Diagnostic::new("E0607", format!("the model has the input `{name}`"))
                    .help(format!(
                        "give its values with `--input PROFILE`, a CSV file with the header `t,{name}`"
                    ))
                    .into());
            }
        };
        if times
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
        if times.every.is_none() && count < 2 {
            return Err(
                Diagnostic::new("E0607", "the times of the samples are not given")
                    .help("say how long and how often: `--until 10 --every 0.01`")
                    .into(),
            );
        }
        let first = points.next()?;
        let from = first
            .as_ref()
            .map_or_else(Decimal::zero, |first| first.time.clone());
        Ok(Profile {
            points,
            following: first,
            held: Vec::new(),
            next: Some(from.clone()),
            from,
            until: times.until.clone().unwrap_or(last),
            every: times.every.clone(),
        })
    }

    /// The record of inputs that was read, if there is one.
    pub fn record(&self) -> Option<&Record> {
        match &self.points {
            Points::Table { record, .. } => Some(record),
            _ => None,
        }
    }

    /// The next sample; `None` after the last.
    ///
    /// An error: inputs would change between two samples, which no record could say.
    pub fn next(&mut self) -> Result<Option<Stretch>, Diagnostic> {
        let Some(time) = self.next.take().filter(|time| *time <= self.until) else {
            return Ok(None);
        };
        while let Some(point) = self.following.take_if(|point| point.time <= time) {
            if point.time < time {
                return Err(between(&point.time));
            }
            self.held = point.values;
            self.following = self.points.next()?;
        }
        let following = match &self.every {
            Some(every) => Some(&time + every),
            None => self.following.as_ref().map(|point| point.time.clone()),
        };
        self.next = following.filter(|following| *following <= self.until);
        Ok(Some(Stretch {
            to_next: self.next.as_ref().map(|next| next - &time),
            time,
            texts: self.held.clone(),
            inputs: self.held.iter().map(Decimal::to_interval).collect(),
        }))
    }

    /// How far `time` is on the way from the first to the last sample, in parts of a bar.
    pub fn part_at(&self, time: &Decimal) -> u64 {
        let whole = (&self.until - &self.from).to_interval().mid();
        let done = (time - &self.from).to_interval().mid();
        (done / whole * progress::PARTS as f64) as u64
    }
}

/// Where inputs come from.
enum Points {
    /// A model without inputs: it starts at zero.
    Start,
    /// That was it.
    End,
    /// A profile; the time, then the inputs, with their columns.
    Table {
        table: Box<TableReader>,
        places: Vec<usize>,
        path: PathBuf,
        record: Box<Record>,
    },
}

impl Points {
    fn of_table(source: TableSource, record: Record) -> Result<Points, Diagnostic> {
        let path = source.path().to_path_buf();
        let table =
            TableReader::open(source).map_err(|problem| changed(&path, &problem.message))?;
        let mut places = Vec::new();
        for (variable, column) in record.columns() {
            let message =
                format!("`{variable}` must be one column of plain numbers, not `{column}`");
            let no_column = || Diagnostic::new("E0608", message).help("write one value per line");
            places.push(table.column(column).ok_or_else(no_column)?);
        }
        Ok(Points::Table {
            table: Box::new(table),
            places,
            path,
            record: Box::new(record),
        })
    }

    /// The decimals of the next point as they are written: the record to be repeats them.
    fn next(&mut self) -> Result<Option<Point>, Diagnostic> {
        let (table, places, path) = match self {
            Points::Start => {
                *self = Points::End;
                return Ok(Some(Point {
                    time: Decimal::zero(),
                    values: Vec::new(),
                }));
            }
            Points::End => return Ok(None),
            Points::Table {
                table,
                places,
                path,
                ..
            } => (table, places, path),
        };
        let row = table.next_row();
        let Some(row) = row.map_err(|problem| changed(path, &problem.message))? else {
            return Ok(None);
        };
        let decimals = places.iter().map(|at| Decimal::parse(&row.field(*at)).ok());
        let incomplete = || changed(path, &format!("line {} is not complete", row.line()));
        let mut values: Vec<Decimal> = decimals.collect::<Option<_>>().ok_or_else(incomplete)?;
        if values.is_empty() {
            return Err(incomplete());
        }
        let time = values.remove(0);
        Ok(Some(Point { time, values }))
    }
}

/// Checks the whole profile, as a record of inputs.
fn check(source: &TableSource, model: &Model) -> Result<Record, Diagnostics> {
    let mut inputs = model.clone();
    inputs.outputs.clear();
    inputs.signals.clear();
    let bar = progress::of_parts(source.bytes(), "of the profile checked", false);
    let mut watch = |bytes| bar.set_position(bytes);
    let record = Record::open_watched(
        source.clone(),
        &inputs,
        RecordOptions::default(),
        &mut watch,
    );
    bar.finish_and_clear();
    record
}

/// The profile was checked before; what cannot be read now means that it was changed.
fn changed(path: &Path, what: &str) -> Diagnostic {
    Diagnostic::new(
        "E0417",
        format!("`{}` was changed while it was read: {what}", path.display()),
    )
    .help("run again when nothing writes to the profile")
}

fn between(time: &Decimal) -> Diagnostic {
    Diagnostic::new(
        "E0608",
        format!("the profile changes at t = {time} s, between two samples of the record"),
    )
    .help("choose `--every` so that every time of the profile is the time of a sample")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn a_profile_that_changes_under_way_is_told_word_for_word() {
        let model = "format = 1\nstates = [\"x\"]\ninit.x = 0\ninputs = [\"u\"]\nder.x = \"u\"\n\
            outputs.y = \"x +- 0.1\"\n";
        let model = Model::from_text("m.toml", model).unwrap();
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("p.csv");
        fs::write(&path, "t,u\n0,1\n1,1\n").unwrap();
        let source = TableSource::from(&path);
        let record = check(&source, &model).unwrap();
        fs::write(&path, "t,u\n0,1\n1,fast\n").unwrap();
        let mut points = Points::of_table(source, record).unwrap();
        points.next().unwrap();
        let Err(said) = points.next() else {
            panic!("a word was taken for a number")
        };
        let wanted = format!(
            "error[E0417]: `{}` was changed while it was read: line 3 is not complete\n |\n = help: run again when \
             nothing writes to the profile\n",
            path.display()
        );
        assert_eq!(Diagnostics::from(said).render(false), wanted);
    }
}
