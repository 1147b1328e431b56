//! Which column belongs to which variable of the model.

use super::RecordOptions;
use super::header::{Header, NotFound, Place};
use super::problems::Problems;
use super::similar::closest;
use super::units;
use veribound_interval::{Decimal, Interval};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::model::{ErrorBound, Model};
use veribound_model::units::Conversion;

/// Usual names of the time column, in lower case.
const TIME_NAMES: [&str; 4] = ["t", "time", "timestamp", "stamp"];

/// A variable of the model and its columns.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    pub name: String,
    pub place: Place,
    pub error: ErrorBound,
    /// From the unit of the column to the unit of the model, where it is another one.
    pub conversion: Option<Conversion>,
}

impl Source {
    /// The smallest interval around a recorded number, in the unit of the model.
    pub(crate) fn enclose(&self, number: &Decimal) -> Interval {
        match &self.conversion {
            Some(conversion) => conversion.apply(number),
            None => number.to_interval(),
        }
    }
}

/// Where everything the model needs stands in a row.
#[derive(Debug, Clone)]
pub(crate) struct Layout {
    pub header: Header,
    pub time: usize,
    pub inputs: Vec<Source>,
    /// Bounds of the disturbances, which have no column.
    pub disturbances: Vec<Interval>,
    pub outputs: Vec<Source>,
    pub signals: Vec<(String, usize)>,
    /// Pairs of a variable and the header of its columns, time first.
    pub pairs: Vec<(String, String)>,
    /// Headers that nothing uses.
    pub ignored: Vec<String>,
    /// What a user should know and no rule forbids.
    pub warnings: Vec<String>,
    /// Columns whose numbers are converted, in sentences.
    pub conversions: Vec<String>,
}

/// What a variable is, for messages.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Input,
    Output,
    Signal,
}

impl Kind {
    fn word(self) -> &'static str {
        match self {
            Kind::Input => "input",
            Kind::Output => "output",
            Kind::Signal => "signal",
        }
    }
}

/// Finds the columns of a model in a header.
pub(crate) struct Finder<'a> {
    pub header: &'a Header,
    pub options: &'a RecordOptions,
    pub problems: &'a mut Problems,
    pub warnings: Vec<String>,
    pub conversions: Vec<String>,
}

impl Finder<'_> {
    /// Finds every column; every name without a column becomes a problem.
    pub(crate) fn find(mut self, model: &Model) -> Option<Layout> {
        if self
            .header
            .columns
            .iter()
            .all(|column| is_number(&column.text))
        {
            self.refuse_missing_header();
            return None;
        }
        self.refuse_unknown_variables(model);
        let time = self.time();
        let mut inputs = Vec::new();
        for input in model.recorded_inputs() {
            let names = (input.name.as_str(), input.unit.as_str());
            let column = input.column.as_deref();
            inputs.extend(self.source(names, column, &input.error, Kind::Input));
        }
        let mut outputs = Vec::new();
        for output in &model.outputs {
            let names = (output.name.as_str(), output.unit.as_str());
            let column = output.column.as_deref();
            outputs.extend(self.source(names, column, &output.error, Kind::Output));
        }
        let mut signals = Vec::new();
        for signal in &model.signals {
            match self.variable(&signal.name, "", signal.column.as_deref(), Kind::Signal) {
                Some(Place::Value(at)) => signals.push((signal.name.clone(), at)),
                Some(place) => self.signal_in_bounds(&signal.name, place),
                None => {}
            }
        }
        if !self.problems.is_empty() {
            return None;
        }
        let mut layout = Layout {
            header: self.header.clone(),
            time: time?,
            inputs,
            disturbances: model.disturbances().map(|(_, bounds)| bounds).collect(),
            outputs,
            signals,
            pairs: Vec::new(),
            ignored: Vec::new(),
            warnings: self.warnings,
            conversions: self.conversions,
        };
        layout.describe();
        Some(layout)
    }

    fn source(
        &mut self,
        (name, unit): (&str, &str),
        column: Option<&str>,
        error: &ErrorBound,
        kind: Kind,
    ) -> Option<Source> {
        let place = self.variable(name, unit, column, kind)?;
        Some(Source {
            name: name.to_owned(),
            place,
            error: error.clone(),
            conversion: self.conversion(place, name, unit),
        })
    }

    fn time(&mut self) -> Option<usize> {
        let at = match &self.options.time {
            Some(wanted) => match self.header.find_named(wanted) {
                Ok(Place::Value(at)) => at,
                Ok(_) | Err(NotFound::Missing) => {
                    let message = format!("the record has no time column `{wanted}`");
                    self.missing(wanted, message, "--time ");
                    return None;
                }
                Err(NotFound::Ambiguous(places)) => {
                    self.ambiguous("the time", &places, "--time ");
                    return None;
                }
            },
            None => self.usual_time()?,
        };
        self.refuse_other_times(at)
    }

    fn usual_time(&mut self) -> Option<usize> {
        let numbered = self.header.columns.iter().enumerate();
        let is_time = |name: &str| {
            let name = name.to_lowercase();
            let word = name.rsplit_once('_').filter(|(_, unit)| is_time_unit(unit));
            TIME_NAMES.contains(&word.map_or(name.as_str(), |(word, _)| word))
        };
        let places: Vec<Place> = numbered
            .filter(|(_, column)| is_time(&column.name))
            .map(|(at, _)| Place::Value(at))
            .collect();
        match places.as_slice() {
            [Place::Value(at)] => Some(*at),
            [] => {
                let problem = Diagnostic::new("E0410", "the record has no time column");
                let label = format!("columns: {}", self.header.list());
                let problem = self.header.mark(problem, label);
                let problem = problem
                    .help("call it `t`, `time` or `Time [s]`, or name it with `--time COLUMN`");
                self.problems.end(problem);
                None
            }
            _ => {
                self.ambiguous("the time", &places, "--time ");
                None
            }
        }
    }

    /// Stamps that are not in seconds would be wrong by a factor; stamps without a unit are seconds.
    fn refuse_other_times(&mut self, at: usize) -> Option<usize> {
        let column = self.header.columns.get(at)?;
        let appended = || column.name.rsplit_once('_').map(|(_, unit)| unit);
        let unit = match column.unit.as_deref() {
            Some(unit) if units::is_second(unit) => return Some(at),
            Some(unit) => unit,
            None => match appended().filter(|unit| units::in_seconds(unit).is_some()) {
                Some(unit) => unit,
                None => return Some(at),
            },
        };
        let help = match units::in_seconds(unit) {
            Some(factor) => format!("multiply the stamps by {factor} and call the column `t_s`"),
            None => "write the stamps in seconds and call the column `t_s`".to_owned(),
        };
        let problem = Diagnostic::new(
            "E0411",
            format!("the time column `{}` is not in seconds", column.text),
        );
        let problem = self.header.mark_column(at, problem, format!("in `{unit}`"));
        self.problems.end(problem.help(help));
        None
    }

    fn variable(
        &mut self,
        name: &str,
        unit: &str,
        column: Option<&str>,
        kind: Kind,
    ) -> Option<Place> {
        let chosen = self
            .options
            .columns
            .iter()
            .rfind(|(variable, _)| variable == name);
        let wanted = chosen.map(|(_, column)| column.as_str()).or(column);
        let found = match wanted {
            Some(wanted) => self.header.find_named(wanted),
            None => self.header.find_variable(name, unit),
        };
        match found {
            Ok(place) => Some(place),
            Err(NotFound::Missing) => {
                let word = kind.word();
                let message = match wanted {
                    Some(wanted) => {
                        format!("the record has no column `{wanted}` for the {word} `{name}`")
                    }
                    None => format!("the record has no column for the {word} `{name}`"),
                };
                self.missing(
                    wanted.unwrap_or(name),
                    message,
                    &format!("--column {name}="),
                );
                None
            }
            Err(NotFound::Ambiguous(places)) => {
                let what = format!("the {} `{name}`", kind.word());
                self.ambiguous(&what, &places, &format!("--column {name}="));
                None
            }
        }
    }

    fn missing(&mut self, wanted: &str, message: String, flag: &str) {
        let names = self
            .header
            .columns
            .iter()
            .map(|column| column.text.as_str());
        let help = match closest(wanted, names) {
            Some(name) => format!(
                "if `{name}` is meant, say so with `{flag}{}`",
                shell_word(name)
            ),
            None => format!("name the column with `{flag}COLUMN`"),
        };
        let problem = Diagnostic::new("E0408", message);
        let label = format!("columns: {}", self.header.list());
        self.problems
            .end(self.header.mark(problem, label).help(help));
    }

    fn ambiguous(&mut self, what: &str, places: &[Place], flag: &str) {
        let names: Vec<String> = places
            .iter()
            .map(|place| format!("`{}`", self.header.spell(*place)))
            .collect();
        let same = names.windows(2).all(|pair| pair.first() == pair.last());
        let problem = Diagnostic::new(
            "E0409",
            format!("{what} could be any of the columns {}", names.join(" and ")),
        );
        let help = if same {
            "give every column a name of its own".to_owned()
        } else {
            let first = places.first().map(|place| self.header.spell(*place));
            let word = shell_word(first.as_deref().unwrap_or_default());
            format!("name the one that is meant, for instance `{flag}{word}`")
        };
        let problem = match places.last() {
            Some(Place::Value(at) | Place::Bounds(at, _)) => {
                self.header.mark_column(*at, problem, "the last of them")
            }
            None => problem,
        };
        self.problems.end(problem.help(help));
    }

    fn signal_in_bounds(&mut self, name: &str, place: Place) {
        let problem = Diagnostic::new(
            "E0408",
            format!(
                "the signal `{name}` has bounds (`{}`) but no values",
                self.header.spell(place)
            ),
        );
        let label = format!("columns: {}", self.header.list());
        let help = format!("name its column with `--column {name}=COLUMN`");
        self.problems
            .end(self.header.mark(problem, label).help(help));
    }

    fn refuse_missing_header(&mut self) {
        let problem = Diagnostic::new("E0410", "the record has no header line");
        let problem = self
            .header
            .mark(problem, "numbers where names of columns are expected");
        self.problems.end(problem.help(
            "write the names of the columns into the first line, for instance `t,u,phi` \
             (a line that starts with `#` is a comment)",
        ));
    }

    fn refuse_unknown_variables(&mut self, model: &Model) {
        let inputs = model.recorded_inputs().map(|input| input.name.as_str());
        let outputs = model.outputs.iter().map(|output| output.name.as_str());
        let signals = model.signals.iter().map(|signal| signal.name.as_str());
        let known: Vec<&str> = inputs.chain(outputs).chain(signals).collect();
        for (variable, column) in &self.options.columns {
            if !known.contains(&variable.as_str()) {
                let problem = Diagnostic::new(
                    "E0420",
                    format!(
                        "`--column {variable}={column}`: the model has no input, output or signal `{variable}`"
                    ),
                );
                let help = match closest(variable, known.iter().copied()) {
                    Some(name) => format!("did you mean `{name}`?"),
                    None => format!("choose one of: {}", known.join(", ")),
                };
                self.problems.end(problem.help(help));
            }
        }
    }
}

impl Layout {
    fn describe(&mut self) {
        let time = Place::Value(self.time);
        let mut places = vec![("time".to_owned(), time)];
        let sources = self.inputs.iter().chain(&self.outputs);
        places.extend(sources.map(|source| (source.name.clone(), source.place)));
        let signals = self.signals.iter();
        places.extend(signals.map(|(name, at)| (name.clone(), Place::Value(*at))));
        let used = |at: usize| {
            places.iter().any(|(_, place)| match place {
                Place::Value(value) => *value == at,
                Place::Bounds(lo, hi) => *lo == at || *hi == at,
            })
        };
        let numbered = self.header.columns.iter().enumerate();
        self.ignored = numbered
            .filter(|(at, column)| !used(*at) && !column.text.is_empty())
            .map(|(_, column)| column.text.clone())
            .collect();
        let spelled = places.into_iter();
        self.pairs = spelled
            .map(|(name, place)| (name, self.header.spell(place)))
            .collect();
    }
}

fn is_time_unit(unit: &str) -> bool {
    units::is_second(unit) || units::in_seconds(unit).is_some()
}

fn is_number(text: &str) -> bool {
    veribound_interval::Decimal::parse(text).is_ok()
}

/// A name as it can be typed on a command line.
fn shell_word(name: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./".contains(c);
    if name.chars().all(plain) {
        name.to_owned()
    } else {
        format!("\"{name}\"")
    }
}
