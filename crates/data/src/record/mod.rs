//! Records in: a CSV file, or another table of numbers, becomes samples, one at a time.

mod cell;
mod conversion;
mod header;
mod layout;
mod messages;
mod problems;
mod row;
pub(crate) mod sheet;
mod similar;
mod units;

use crate::digest::{Digesting, sha256_of_file};
use crate::reader::lines::{Lines, quote};
use crate::reader::source::{Bytes, TableSource};
use crate::reader::{Line, bad_quotes, fields, is_comment};
use header::{Column, Header};
use layout::{Finder, Layout};
use problems::Problems;
use row::{Row, Rows};
use sheet::{Input, Sheet, SheetText};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::sync::Arc;
use veribound_interval::{Decimal, text};
use veribound_model::diagnostic::{Diagnostic, Diagnostics};
use veribound_model::model::{Model, Sample};

/// How to read a record.
///
/// ```
/// use veribound_data::{Record, RecordOptions, TableSource};
/// use veribound_interval::Decimal;
/// # use veribound_model::Model;
/// # let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = 0\nparams.k = [0, 2]\nder.x = \"k\"\noutputs.y = \"x +- 0.1\"";
/// # let model = Model::from_text("slide.toml", text)?;
/// let table = TableSource::text("r.csv", "zeit,weg\n0,0\n1,0.5\n2,1\n3,1.5\n");
/// let options = RecordOptions {
///     time: Some("zeit".to_string()),
///     columns: vec![("y".to_string(), "weg".to_string())],
///     from: Decimal::parse("1").ok(),
///     to: Decimal::parse("2.5").ok(),
/// };
/// assert_eq!(Record::open(table, &model, options)?.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct RecordOptions {
    /// Name of the time column; by default the one called `t`, `time`, `timestamp` or `stamp`.
    pub time: Option<String>,
    /// Pairs of a variable of the model and the column it is read from; they go before the
    /// columns that the model names.
    pub columns: Vec<(String, String)>,
    /// First time of the window, in seconds on the record's own clock; by default all samples.
    pub from: Option<Decimal>,
    /// Last time of the window, in seconds on the record's own clock; by default all samples.
    pub to: Option<Decimal>,
}

/// A record whose every line has been checked.
///
/// *Guarantee*: for every sample, the true value of an input (output) lies in its interval, if it
/// differed from the recorded decimal by no more than the error bound of the model. Recorded bounds
/// (`phi.lo`, `phi.hi`) are taken as recorded values too: the error bound widens them. A number in
/// another unit than the model's is multiplied by an enclosure of the exact factor first; error
/// bounds are in the unit of the model.
///
/// A MATLAB MAT file, an HDF5 file or a Parquet file is read as the table of its columns: the header is line 1, the
/// first sample line 2. A float in it means that float exactly.
///
/// An empty field or `NaN` of an output or a signal is a missing value: nothing was recorded there, so
/// nothing is claimed ([`Record::missing`] counts them). Of an input or of the time it is an error.
///
/// *Cost*: the file is read once here and once for every [`Record::samples`]; memory does not
/// grow with its length, except of files that are no text: their columns are held.
///
/// ```
/// use veribound_data::{Record, RecordOptions, TableSource};
/// # use veribound_model::Model;
/// # let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = 0\nparams.k = [0, 2]\nder.x = \"k\"\noutputs.y = \"x +- 0.1\"";
/// # let model = Model::from_text("slide.toml", text)?;
/// let table = TableSource::text("r.csv", "t,y [mm],note\n0,0,begin\n0.1,,\n0.2,250,end\n");
/// let record = Record::open(table, &model, RecordOptions::default())?;
/// assert_eq!((record.len(), record.last().to_string()), (3, "0.2".to_string()));
/// assert_eq!(record.missing(), [("y".to_string(), 1)]);
/// assert_eq!(record.ignored_columns(), ["note"]);
///
/// // A quarter of a metre, to 0.1 m: millimetres are converted, and the error bound is in metres.
/// let samples = record.all_samples()?;
/// let y = samples[2].outputs[0].unwrap();
/// assert!(y.contains(0.16) && y.contains(0.34) && !y.contains(0.36));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Record {
    source: TableSource,
    name: Arc<str>,
    layout: Arc<Layout>,
    options: RecordOptions,
    samples: usize,
    first: Decimal,
    last: Decimal,
    sha256: String,
    missing: Vec<(String, usize)>,
    hint: Option<String>,
    /// The columns, of a file that is no text.
    sheet: Option<Arc<Sheet>>,
}

impl Record {
    /// Reads the whole file once and checks it.
    ///
    /// The form of every line and the order of all time stamps are checked; values are checked
    /// inside the window.
    ///
    /// *Errors*: everything that is wrong with the file (the first problems in full, the rest
    /// counted), codes `E04xx`.
    pub fn open(
        source: impl Into<TableSource>,
        model: &Model,
        options: RecordOptions,
    ) -> Result<Record, Diagnostics> {
        Record::open_watched(source, model, options, &mut |_| {})
    }

    /// As [`Record::open`]; tells `watch` from time to time how many bytes have been checked.
    ///
    /// *Errors*: those of [`Record::open`].
    pub fn open_watched(
        source: impl Into<TableSource>,
        model: &Model,
        options: RecordOptions,
        watch: &mut dyn FnMut(u64),
    ) -> Result<Record, Diagnostics> {
        let source = source.into();
        let name: Arc<str> = Arc::from(source.path().display().to_string());
        let bytes = source.open(false)?;
        let sheet = source.sheet(&name)?.map(Arc::new);
        let input = match &sheet {
            Some(sheet) => Input::Sheet(SheetText::new(sheet)),
            None => Input::File(BufReader::with_capacity(BUFFER, Digesting::new(bytes))),
        };
        let mut lines = Lines::new(input, &name)?;
        let header = read_header(&mut lines, &name)?;
        let mut problems = Problems::default();
        let finder = Finder {
            header: &header,
            options: &options,
            problems: &mut problems,
            warnings: Vec::new(),
            conversions: Vec::new(),
        };
        let Some(layout) = finder.find(model) else {
            return Err(problems.into_error(&name));
        };
        let seen = check(&mut lines, &name, (&layout, &options), &mut problems, watch);
        if !problems.is_empty() {
            return Err(problems.into_error(&name));
        }
        let missing = seen.missing(&layout);
        let hint = header.columns.get(layout.time).and_then(|column| {
            let (first, last) = seen.window.as_ref()?;
            time_hint(column, first, last, seen.samples)
        });
        let Some((first, last)) = seen.window else {
            return Err(no_samples(&name, &options, seen.whole).into());
        };
        Ok(Record {
            sha256: match lines.into_input() {
                Input::File(file) => file.into_inner().finish(),
                Input::Sheet(_) => sha256_of_file(source.path())?,
            },
            sheet,
            source,
            missing,
            hint,
            layout: Arc::new(layout),
            options,
            samples: seen.samples,
            first,
            last,
            name,
        })
    }

    /// Reads the samples of the window from the start; may be called any number of times.
    ///
    /// *Errors*: when the file cannot be opened any more.
    pub fn samples(&self) -> Result<Samples, Diagnostics> {
        let mut lines = self.lines()?;
        read_header(&mut lines, &self.name)?;
        Ok(Samples {
            lines,
            name: Arc::clone(&self.name),
            layout: Arc::clone(&self.layout),
            options: self.options.clone(),
            rows: Rows::new(),
            is_done: false,
        })
    }

    /// The text of a line, by its number; of a file that is no text as [`Record`] tells. `None` where it cannot be
    /// read any more.
    pub fn line(&self, number: usize) -> Option<String> {
        if let Some(sheet) = &self.sheet {
            return sheet.line(number);
        }
        let mut lines = self.lines().ok()?;
        while let Ok(Some((text, at))) = lines.next_line() {
            if at == number {
                return Some(text.to_owned());
            }
        }
        None
    }

    fn lines(&self) -> Result<Lines<Input<Bytes>>, Diagnostic> {
        let input = match &self.sheet {
            Some(sheet) => Input::Sheet(SheetText::new(sheet)),
            None => {
                let bytes = self.source.open(false)?;
                Input::File(BufReader::with_capacity(BUFFER, bytes))
            }
        };
        Lines::new(input, &self.name)
    }

    /// All samples of the window together.
    ///
    /// *Errors*: when the file cannot be opened any more, or was changed since it was checked.
    ///
    /// *Cost*: memory grows with their number, unlike that of [`Record::samples`].
    pub fn all_samples(&self) -> Result<Vec<Sample>, Diagnostics> {
        self.samples()?.collect()
    }

    /// Number of samples in the window; at least one.
    pub fn len(&self) -> usize {
        self.samples
    }

    /// Never: a record without samples is an error.
    pub fn is_empty(&self) -> bool {
        self.samples == 0
    }

    /// Time of the first sample of the window.
    pub fn first(&self) -> &Decimal {
        &self.first
    }

    /// Time of the last sample of the window.
    pub fn last(&self) -> &Decimal {
        &self.last
    }

    /// SHA-256 of all bytes of the file, in hexadecimal digits.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Path as the user gave it, or the name of a text in memory.
    pub fn path(&self) -> &Path {
        self.source.path()
    }

    /// Pairs of a variable and the header of the column (or columns) it is read from; the first
    /// pair is `time`.
    pub fn columns(&self) -> &[(String, String)] {
        &self.layout.pairs
    }

    /// Headers of the columns that nothing uses.
    pub fn ignored_columns(&self) -> &[String] {
        &self.layout.ignored
    }

    /// Outputs and signals with missing values, and how many each has in the window.
    pub fn missing(&self) -> &[(String, usize)] {
        &self.missing
    }

    /// What was converted: every column in another unit than the model's, of the same dimension,
    /// with its factor.
    pub fn conversions(&self) -> &[String] {
        &self.layout.conversions
    }

    /// What may be a slip and changes nothing: time stamps without a unit that look like milliseconds.
    pub fn hint(&self) -> Option<&str> {
        self.hint.as_deref()
    }

    /// What the user should know: a column whose unit is not the model's and is not converted.
    pub fn warnings(&self) -> &[String] {
        &self.layout.warnings
    }
}

/// The samples of a record's window in the order of time.
///
/// An error means that the file was changed after [`Record::open`] checked it; nothing follows it.
///
/// ```
/// use veribound_data::{Record, RecordOptions, TableSource};
/// # use veribound_model::Model;
/// # let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = 0\nparams.k = [0, 2]\nder.x = \"k\"\noutputs.y = \"x +- 0.1\"";
/// # let model = Model::from_text("slide.toml", text)?;
/// let table = TableSource::text("r.csv", "t,y\n0,0\n1,0.5\n");
/// let record = Record::open(table, &model, RecordOptions::default())?;
/// for sample in record.samples()? {
///     let sample = sample?;
///     println!("line {}: t = {} s", sample.line, sample.time);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Samples {
    lines: Lines<Input<Bytes>>,
    name: Arc<str>,
    layout: Arc<Layout>,
    options: RecordOptions,
    rows: Rows,
    is_done: bool,
}

impl Iterator for Samples {
    type Item = Result<Sample, Diagnostics>;

    fn next(&mut self) -> Option<Self::Item> {
        while !self.is_done {
            let (text, number) = match self.lines.next_line() {
                Ok(Some(line)) => line,
                Ok(None) => break,
                Err(error) => {
                    self.is_done = true;
                    return Some(Err(error.into()));
                }
            };
            let mut problems = Problems::default();
            let line = Line {
                file: &self.name,
                text,
                number,
            };
            match self
                .rows
                .read(line, &self.layout, &self.options, &mut problems)
            {
                Row::Sample(sample) => return Some(Ok(sample)),
                Row::After => break,
                Row::Bad => {
                    self.is_done = true;
                    return Some(Err(problems.into_error(&self.name)));
                }
                Row::Nothing | Row::Before => {}
            }
        }
        self.is_done = true;
        None
    }
}

/// Bytes read from the disk at once.
const BUFFER: usize = 1 << 16;

/// How often a check says how far it is.
const LINES_BETWEEN_REPORTS: usize = 1000;

/// What [`check`] saw.
#[derive(Default)]
struct Seen {
    samples: usize,
    /// First and last time in the window.
    window: Option<(Decimal, Decimal)>,
    /// First and last time in the file.
    whole: Option<(Decimal, Decimal)>,
    /// Missing values in the window: of every output, then of every signal.
    missing: Vec<usize>,
}

impl Seen {
    fn count_missing(&mut self, sample: &Sample) {
        let outputs = sample.outputs.iter().map(Option::is_none);
        let signals = sample.signals.iter().map(Option::is_none);
        self.missing
            .resize(sample.outputs.len() + sample.signals.len(), 0);
        for (count, is_missing) in self.missing.iter_mut().zip(outputs.chain(signals)) {
            *count += usize::from(is_missing);
        }
    }

    fn missing(&self, layout: &Layout) -> Vec<(String, usize)> {
        let outputs = layout.outputs.iter().map(|output| &output.name);
        let names = outputs.chain(layout.signals.iter().map(|(name, _)| name));
        names
            .zip(&self.missing)
            .filter(|(_, count)| **count > 0)
            .map(|(name, count)| (name.clone(), *count))
            .collect()
    }
}

fn check<R: BufRead>(
    lines: &mut Lines<R>,
    name: &str,
    (layout, options): (&Layout, &RecordOptions),
    problems: &mut Problems,
    watch: &mut dyn FnMut(u64),
) -> Seen {
    let mut rows = Rows::new();
    let mut seen = Seen::default();
    let mut bytes = 0;
    loop {
        let (text, number) = match lines.next_line() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err(error) => {
                problems.end(error);
                break;
            }
        };
        let line = Line {
            file: name,
            text,
            number,
        };
        bytes += text.len() as u64 + 1;
        if number % LINES_BETWEEN_REPORTS == 0 {
            watch(bytes);
        }
        let row = rows.read(line, layout, options, problems);
        if let Row::Sample(sample) = row {
            seen.samples += 1;
            seen.count_missing(&sample);
            let first = seen.window.take().map(|(first, _)| first);
            seen.window = Some((first.unwrap_or_else(|| sample.time.clone()), sample.time));
        }
        if let (None, Some(time)) = (&seen.whole, rows.time()) {
            seen.whole = Some((time.clone(), time.clone()));
        }
    }
    if let (Some((_, last)), Some(time)) = (&mut seen.whole, rows.time()) {
        *last = time.clone();
    }
    seen
}

fn read_header<R: BufRead>(lines: &mut Lines<R>, name: &str) -> Result<Header, Diagnostic> {
    let mut is_empty = true;
    loop {
        let Some((text, number)) = lines.next_line()? else {
            let what = if is_empty {
                "is empty"
            } else {
                "holds nothing but comments"
            };
            return Err(Diagnostic::new("E0402", format!("`{name}` {what}")).help(
                "a record is a header line, for instance `t,u,phi`, then one line per sample",
            ));
        };
        if is_comment(text) {
            is_empty &= text.trim().is_empty();
            continue;
        }
        let line = Line {
            file: name,
            text,
            number,
        };
        let (source, _) = quote(name, text, number, 0..0);
        return Header::parse(text, fields::separator(text), &source)
            .map_err(|error| bad_quotes(line, error));
    }
}

/// Stamps that name no unit are seconds; a second and more from one to the next is slow for a rig.
fn time_hint(column: &Column, first: &Decimal, last: &Decimal, samples: usize) -> Option<String> {
    let steps = samples.checked_sub(1).filter(|steps| *steps > 0)?;
    let mean = (last.to_interval() - first.to_interval()).mid() / steps as f64;
    let says_unit = column.unit.is_some() || column.name.contains('_');
    let (name, mean_text) = (&column.name, text::upper(mean, 3));
    (!says_unit && (1.0..=1000.0).contains(&mean)).then(|| {
        format!(
            "the samples are {mean_text} s apart on average, since the column `{name}` names no unit and stamps \
             without one are seconds; if that is right, call it `{name}_s`; milliseconds have to be divided by 1000"
        )
    })
}

fn no_samples(
    name: &str,
    options: &RecordOptions,
    whole: Option<(Decimal, Decimal)>,
) -> Diagnostic {
    let Some((first, last)) = whole else {
        return Diagnostic::new("E0403", format!("`{name}` has a header but no samples"))
            .help("write one line per sample below the header");
    };
    if let (Some(from), Some(to)) = (&options.from, &options.to)
        && from > to
    {
        let message = format!("the window from {from} s to {to} s ends before it begins");
        return Diagnostic::new("E0416", message).help(format!(
            "take the smaller time for `--from` and the larger for `--to`; the time of `{name}` runs from {first} s \
             to {last} s"
        ));
    }
    let from = options.from.as_ref().map(|from| format!(" from {from} s"));
    let until = if from.is_some() { "to" } else { "up to" };
    let to = options.to.as_ref().map(|to| format!(" {until} {to} s"));
    Diagnostic::new(
        "E0416",
        format!(
            "`{name}` has no sample in the window{}{}",
            from.unwrap_or_default(),
            to.unwrap_or_default()
        ),
    )
    .help(format!(
        "its time runs from {first} s to {last} s: choose `--from` and `--to` inside"
    ))
}
