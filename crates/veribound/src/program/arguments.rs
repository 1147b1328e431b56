//! What can be typed.

use super::flags::{
    Assignment, ColumnFlag, ErrorBoundFlag, ErrorFlag, InputErrorFlag, PlaneFlag, ResetFlag,
    ZoomFlag, any_count, decimal, not_negative, positive, whole,
};
pub use super::identify::arguments::Identify;
use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::{Path, PathBuf};
use veribound_data::ResultFolder;
use veribound_estimate::{ObserverOptions, ParameterRule};
use veribound_flow::engine::Engine;
use veribound_interval::Decimal;
use veribound_model::diagnostic::Diagnostic;

/// Proved parameter and state bounds for dynamic systems with switches.
///
/// What is printed is proved: if the record's errors stay inside the bounds of the model file, the
/// true values lie inside the printed ones.
#[derive(Debug, Parser)]
#[command(
    name = "veribound",
    version,
    max_term_width = 100,
    arg_required_else_help = true
)]
pub struct Arguments {
    /// Colours: on a terminal, if the environment does not say NO_COLOR; always; or never
    #[arg(
        long,
        value_enum,
        value_name = "WHEN",
        default_value = "auto",
        global = true
    )]
    pub color: Color,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// When there are colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal
    Auto,
    /// Also in a file
    Always,
    /// Never
    Never,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Read a model file and say what it was understood to mean
    Check(Check),
    /// Bound the parameters and states of a model from a record, sample by sample
    #[command(
        after_help = "Exit codes: 0 consistent, 1 proved inconsistent, 2 wrong input or \
                            usage, 3 undecided, 130 interrupted (files complete up to the last \
                            sample)."
    )]
    Observe(Box<Observe>),
    /// Bound the parameters of a model from whole records, from both sides: what is proved to hold all
    /// values, and what is proved to be reached
    #[command(
        after_help = "Exit codes: 0 consistent, 1 proved inconsistent, 2 wrong input or \
                            usage, 3 undecided, 130 interrupted (what is proved until then is \
                            written)."
    )]
    Identify(Box<Identify>),
    /// Make a record of a model with known parameters; its errors are proved to stay in bounds
    Simulate(Box<Simulate>),
    /// Enclose all solutions of a model: no record needed, nothing estimated
    #[command(
        after_help = "Exit codes: 0 proved to the end, 2 wrong input or usage, 3 proved only to an earlier \
                            time, 130 interrupted (what is proved is written)."
    )]
    Enclose(Box<Enclose>),
    /// Make a folder with an example that runs: model, record, and how to go on
    New(New),
    /// Look at the program and the machine: arithmetic, processor, threads
    #[command(after_help = "Exit codes: 0 all is well, 2 something is wrong.")]
    Doctor(Doctor),
    /// Print what completes commands in a shell
    Completions(Completions),
    /// Print the manual page, or write the pages of all commands into a folder
    Man(Man),
    /// Tell what an error code means, why it matters and how to repair it; without a code, list all
    Explain(Explain),
}

/// Flags of `veribound check`.
#[derive(Debug, Args)]
pub struct Check {
    /// Model file (TOML)
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

/// Flags of `veribound new`.
#[derive(Debug, Args)]
pub struct New {
    /// Name of the folder; it is made
    #[arg(value_name = "NAME")]
    pub name: PathBuf,
    /// What is in it
    #[arg(
        long,
        value_name = "EXAMPLE",
        value_enum,
        default_value = "drive-train"
    )]
    pub example: super::starter::Example,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

/// Flags of `veribound doctor`.
#[derive(Debug, Args)]
pub struct Doctor {
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `veribound completions`.
#[derive(Debug, Args)]
pub struct Completions {
    /// The shell
    #[arg(value_name = "SHELL", value_enum)]
    pub shell: clap_complete::Shell,
}

/// Flags of `veribound man`.
#[derive(Debug, Args)]
pub struct Man {
    /// Folder for the pages of all commands; it is made where it does not exist
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Flags of `veribound observe`.
#[derive(Debug, Args)]
pub struct Observe {
    /// What was typed, word by word.
    #[arg(skip = super::run_info::typed())]
    pub words: Vec<String>,
    /// Model file (TOML)
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Record (CSV with a header, MATLAB MAT, HDF5 or Parquet); an output or signal that is empty or NaN is a
    /// missing value, counted in the results and otherwise passed over
    #[arg(value_name = "RECORD")]
    pub record: PathBuf,
    /// Folder for the results; it is made where it does not exist, and results of an earlier run in it
    /// are replaced when all new ones are complete
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// How the record is read.
    #[command(flatten)]
    pub reading: Reading,
    /// What the run assumes.
    #[command(flatten)]
    pub assumptions: Assumptions,
    /// How the observer works.
    #[command(flatten)]
    pub method: Method,
    /// What the run shows.
    #[command(flatten)]
    pub showing: Showing,
}

/// How the record is read.
#[derive(Debug, Args)]
#[command(next_help_heading = "Reading the record")]
pub struct Reading {
    /// Column with the time in seconds, if it is not called t, time, timestamp or stamp
    #[arg(long, value_name = "COLUMN")]
    pub time: Option<String>,
    /// Column of a variable of the model; may be given several times
    #[arg(long, value_name = "VARIABLE=COLUMN")]
    pub column: Vec<ColumnFlag>,
    /// First time to use, in seconds on the record's clock; the start intervals of the model file are
    /// then taken to hold at the first sample from it on
    #[arg(long, value_name = "SECONDS", value_parser = decimal, allow_hyphen_values = true)]
    pub from: Option<Decimal>,
    /// Last time to use, in seconds on the record's clock
    #[arg(long, visible_alias = "until", value_name = "SECONDS", value_parser = decimal,
          allow_hyphen_values = true)]
    pub to: Option<Decimal>,
}

/// What the run assumes beside the model file. Flags can only weaken what the model file says;
/// `--start-from` adds what an earlier run proved, and the run says so.
#[derive(Debug, Args)]
#[command(next_help_heading = "Assumptions")]
pub struct Assumptions {
    /// What lets in more solutions.
    #[command(flatten)]
    pub weakening: Weakening,
    /// Start from the parameter boxes that an earlier run left in its folder, instead of the prior;
    /// assumes that its record has the same parameters
    #[arg(long, value_name = "DIR")]
    pub start_from: Option<PathBuf>,
}

/// What lets in more solutions than the model file does.
#[derive(Debug, Args)]
#[command(next_help_heading = "Assumptions")]
pub struct Weakening {
    /// Let a parameter take a new value inside its prior at every sample at which a signal has been
    /// true for SECONDS (0 if not given; an event of the model brings its own time)
    #[arg(long, value_name = "PARAM@SIGNAL[:SECONDS]")]
    pub reset: Vec<ResetFlag>,
    /// Let an input differ from the record by more than the model file says: a share (10%) or an
    /// absolute bound (0.02). The error may be any function of time; with @sample behind the bound it is constant
    /// from each sample to the next, with @level as long as the recorded value stays the same
    #[arg(long, value_name = "INPUT=BOUND[@HOLD]")]
    pub input_error: Vec<InputErrorFlag>,
    /// Let a measured output differ from the record by more than the model file says, in the same way
    #[arg(long, value_name = "OUTPUT=BOUND")]
    pub output_error: Vec<ErrorBoundFlag>,
}

/// How the observer works. No flag here changes what is proved; they change how tight the bounds are
/// and what they cost.
#[derive(Debug, Args)]
#[command(next_help_heading = "Method")]
pub struct Method {
    /// Number of boxes that merging reduces the list to
    #[arg(long, value_name = "L", default_value_t = ObserverOptions::default().boxes,
          value_parser = count(1))]
    pub boxes: usize,
    /// Bisections in a row
    #[arg(long, value_name = "M", default_value_t = ObserverOptions::default().bisections,
          value_parser = count(0))]
    pub bisections: usize,
    /// Samples between two rounds of bisection and merging
    #[arg(long, value_name = "K", default_value_t = ObserverOptions::default().every,
          value_parser = count(1))]
    pub every: usize,
    /// How far beyond the deciding value an ambiguous guard is split, as a share of the prior's width
    #[arg(long, value_name = "SHARE", default_value_t = ObserverOptions::default().epsilon,
          value_parser = not_negative)]
    pub epsilon: f64,
    /// Split a switching state when its width times this many sampling times reaches the width of the
    /// measured states
    #[arg(long, value_name = "SAMPLES", default_value_t = ObserverOptions::default().velocity_horizon,
          value_parser = not_negative)]
    pub velocity_horizon: f64,
    /// Stretches of the past, in samples, over which a rate is bounded by how far its integral moved;
    /// 0 for none
    #[arg(
        long,
        value_name = "SAMPLES,...",
        value_delimiter = ',',
        default_value = "4,16,64",
        value_parser = any_count
    )]
    pub windows: Vec<u64>,
    /// Split a switching state into three while several modes are possible
    #[arg(long)]
    pub trisect: bool,
    /// How the parameter to split is chosen
    #[arg(long, value_name = "RULE", value_enum,
          default_value_t = Rule::of(ObserverOptions::default().parameter_rule))]
    pub parameter_rule: Rule,
    /// Let merging join boxes with different active modes
    #[arg(long)]
    pub merge_across_modes: bool,
    /// Order of the Taylor series where one smooth right-hand side is certain
    #[arg(long, value_name = "N", default_value_t = ObserverOptions::default().step.order,
          value_parser = count_up_to(1, 12))]
    pub order: usize,
    /// How often a step that cannot be proved may be halved
    #[arg(long, value_name = "N", default_value_t = ObserverOptions::default().step.halvings,
          value_parser = |text: &str| whole(text, 0, u32::MAX))]
    pub halvings: u32,
    /// Longest single step; longer gaps between samples are divided
    #[arg(long, value_name = "SECONDS", default_value_t = ObserverOptions::default().step.longest,
          value_parser = positive)]
    pub longest_step: f64,
    /// What moves boxes besides their own step: forms and closed keep from sample to sample how they depend on parameters,
    /// which narrows more with few boxes and takes many times as long; auto leaves it at boxes
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub engine: EngineName,
    /// How what samples say is kept
    #[arg(long, value_name = "NAME", value_enum, default_value_t = MethodName::Boxes)]
    pub method: MethodName,
    /// polytope: rows that are kept when there are twice so many
    #[arg(long, value_name = "N", default_value_t = ObserverOptions::default().rows,
          value_parser = count(1))]
    pub rows: usize,
    /// polytope: how many samples each of two sets may meet when one comes in
    #[arg(long, value_name = "N", default_value_t = ObserverOptions::default().replay,
          value_parser = count(1))]
    pub replay: usize,
    /// polytope: samples that may be met again; the oldest are forgotten
    #[arg(long, value_name = "N", default_value_t = ObserverOptions::default().history,
          value_parser = count(2))]
    pub history: usize,
    /// polytope: work that a sample may take, in products of coefficients, a million of which are about a millisecond; what takes
    /// longer is put aside, and goes on with the next sample
    #[arg(long, value_name = "N", default_value_t = ObserverOptions::default().budget,
          value_parser = count_up_to(1, MOST_WORK))]
    pub budget: usize,
}

/// Names of methods of the observer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MethodName {
    /// In a list of boxes alone
    Boxes,
    /// In boxes and, beside them, in a polytope of what all samples say together
    Polytope,
}

/// What the run shows.
#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub struct Showing {
    /// As every command with results.
    #[command(flatten)]
    pub output: Shown,
    /// Stretch of time that the figure of the outputs enlarges: FROM..TO in seconds, auto, or off
    #[arg(
        long,
        value_name = "FROM..TO",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    pub zoom: ZoomFlag,
    /// Show the parameters of an earlier run in its folder behind those of this one
    #[arg(long, value_name = "DIR")]
    pub overlay: Option<PathBuf>,
}

/// What every command with a folder of results can show.
#[derive(Debug, Args)]
pub struct Shown {
    /// Formats of the figures
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "FORMAT",
        default_value = "svg,png",
        help_heading = "Output"
    )]
    pub figures: Vec<Format>,
    /// The page with all of it, report.html: tables, and plots that can be zoomed
    #[arg(
        long,
        value_enum,
        value_name = "FORMAT",
        default_value = "html",
        help_heading = "Output"
    )]
    pub report: PageFormat,
    /// Write every table as a Parquet file, too
    #[arg(long, help_heading = "Output")]
    pub parquet: bool,
    /// Print summary.json to stdout instead of the table
    #[arg(long, help_heading = "Output")]
    pub json: bool,
    /// Print nothing but problems and warnings
    #[arg(short, long, help_heading = "Output")]
    pub quiet: bool,
}

impl Shown {
    /// What the files beside the tables are called in a list of results.
    pub fn pictures(&self) -> String {
        let page = match self.report {
            PageFormat::Html => ", report.html",
            PageFormat::None => "",
        };
        let figures = if self.figures.contains(&Format::None) {
            ""
        } else {
            ", figures in fig/"
        };
        format!("{page}{figures}")
    }

    /// The folder for the results.
    pub fn folder(&self, place: &Path) -> Result<ResultFolder, Diagnostic> {
        Ok(ResultFolder::create(place)?.with_parquet(self.parquet))
    }

    /// Refuses figures and no figures.
    ///
    /// *Errors*: `E0612`.
    pub fn refuse(&self) -> Result<(), Diagnostic> {
        refuse_formats(&self.figures)
    }
}

/// Refuses figures and no figures.
///
/// *Errors*: `E0612`.
pub fn refuse_formats(formats: &[Format]) -> Result<(), Diagnostic> {
    let wanted = |format: &Format| *format != Format::None;
    if formats.contains(&Format::None) && formats.iter().any(wanted) {
        let message = "`--figures` asks for no figures and for figures";
        return Err(Diagnostic::new("E0612", message)
            .help("write `--figures none`, or the formats alone, as in `--figures svg,png`"));
    }
    Ok(())
}

/// A budget of so many products is none: a quarter of an hour for one sample.
const MOST_WORK: u64 = 1_000_000_000_000;

/// Decimal places that a float can hold of a number of about 1.
pub const MOST_DECIMALS: usize = 15;

/// Flags of `veribound simulate`.
#[derive(Debug, Args)]
pub struct Simulate {
    /// Model file (TOML)
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Value of every parameter that the model does not fix
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',')]
    pub params: Vec<Assignment>,
    /// Start value of the states; needed where the model file has an interval
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',')]
    pub start: Vec<Assignment>,
    /// New values of parameters from a time on, as in 40:T_Fs=0.2; may be given several times
    #[arg(long, value_name = "SECONDS:NAME=VALUE")]
    pub change: Vec<String>,
    /// When and how long.
    #[command(flatten)]
    pub times: Times,
    /// Largest error of a written output, or `worst`: errors at the end of the model's bound with
    /// random signs
    #[arg(long, value_name = "BOUND|worst")]
    pub error: Option<ErrorFlag>,
    /// Value of a disturbance for the whole record; the middle of its bounds where none is given
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',')]
    pub disturbance: Vec<Assignment>,
    /// Draw what is not given from the model file: parameters and start values once, disturbances and errors of inputs
    /// anew at every sample
    #[arg(long)]
    pub random: bool,
    /// Chooses the errors, and what is drawn
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = any_count)]
    pub seed: u64,
    /// Decimal places of the written outputs
    #[arg(long, value_name = "N", default_value_t = 4,
          value_parser = count_up_to(0, MOST_DECIMALS as u64))]
    pub decimals: usize,
    /// Internal steps per sample: more make the enclosure narrower and take longer
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = count_up_to(1, 100_000))]
    pub steps: usize,
    /// Record to write (CSV); it appears when all of it is proved
    #[arg(short, long, value_name = "RECORD")]
    pub output: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
    /// Folder for the trajectory itself: states, outputs and modes over time, and figures of them
    #[arg(long, value_name = "DIR")]
    pub trajectory: Option<PathBuf>,
    /// Formats of the figures in that folder
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "FORMAT",
        default_value = "svg,png"
    )]
    pub figures: Vec<Format>,
}

/// Flags of `veribound enclose`.
#[derive(Debug, Args)]
pub struct Enclose {
    /// What was typed, word by word.
    #[arg(skip = super::run_info::typed())]
    pub words: Vec<String>,
    /// Model file (TOML); its start boxes, parameter bounds, disturbances and input errors are the set
    /// of all solutions that are enclosed
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// When and how long.
    #[command(flatten)]
    pub times: Times,
    /// Parts that the set may be divided into where it is too wide
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = count_up_to(1, 100_000))]
    pub parts: usize,
    /// How the bounds are proved; what is proved is true whichever is taken
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub engine: EngineName,
    /// Folder for the results; it is made where it does not exist, and results of an earlier run in it
    /// are replaced when all new ones are complete
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// Draw so many random true trajectories and compare them with the bounds
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = count_up_to(0, 1_000_000))]
    pub sample: usize,
    /// Chooses the trajectories
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = any_count)]
    pub seed: u64,
    /// The two states of the phase plane; auto takes a state with its rate
    #[arg(long, value_name = "X,Y|auto|off", default_value = "auto")]
    pub plane: PlaneFlag,
    /// What the run shows.
    #[command(flatten)]
    pub showing: Shown,
}

/// Inputs over time, and the times of the results.
#[derive(Debug, Args)]
pub struct Times {
    /// Inputs over time (CSV with a header); each value holds until the next line
    #[arg(long, value_name = "PROFILE")]
    pub input: Option<PathBuf>,
    /// Time of the last sample
    #[arg(long, value_name = "SECONDS", value_parser = decimal)]
    pub until: Option<Decimal>,
    /// Time between two samples; by default the samples are at the times of the profile
    #[arg(long, value_name = "SECONDS", value_parser = decimal)]
    pub every: Option<Decimal>,
}

/// Arguments of `veribound explain`.
#[derive(Debug, Args)]
pub struct Explain {
    /// Codes as in `error[E0213]`: E0213, or 213
    #[arg(value_name = "CODE")]
    pub codes: Vec<String>,
    /// Print one JSON document
    #[arg(long)]
    pub json: bool,
}

/// Formats of figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Vector graphics
    Svg,
    /// Pixels
    Png,
    /// No figures
    None,
}

/// Formats of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PageFormat {
    /// One file that a browser shows, also without a network
    Html,
    /// No page
    None,
}

/// Names of the rules of [`ParameterRule`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Rule {
    /// The parameter of the widest term of the derivative
    WidestTerm,
    /// The parameter of the last term if it overlaps another, else of the first
    OverlappingTerms,
    /// The parameter whose own width contributes most to the width of the derivative
    WidestInfluence,
}

impl Rule {
    fn of(rule: ParameterRule) -> Rule {
        match rule {
            ParameterRule::WidestTerm => Rule::WidestTerm,
            ParameterRule::OverlappingTerms => Rule::OverlappingTerms,
            ParameterRule::WidestInfluence => Rule::WidestInfluence,
        }
    }
}

impl Method {
    /// The settings in the observer's own words.
    pub fn options(&self) -> ObserverOptions {
        let mut options = ObserverOptions {
            boxes: self.boxes,
            bisections: self.bisections,
            every: self.every,
            epsilon: self.epsilon,
            velocity_horizon: self.velocity_horizon,
            windows: self.windows.clone(),
            trisect: self.trisect,
            parameter_rule: match self.parameter_rule {
                Rule::WidestTerm => ParameterRule::WidestTerm,
                Rule::OverlappingTerms => ParameterRule::OverlappingTerms,
                Rule::WidestInfluence => ParameterRule::WidestInfluence,
            },
            merge_across_modes: self.merge_across_modes,
            step: ObserverOptions::default().step,
            engine: self.engine.into(),
            method: match self.method {
                MethodName::Boxes => veribound_estimate::Method::Boxes,
                MethodName::Polytope => veribound_estimate::Method::Polytope,
            },
            rows: self.rows,
            replay: self.replay,
            history: self.history,
            budget: self.budget,
        };
        options.step.order = self.order;
        options.step.halvings = self.halvings;
        options.step.longest = self.longest_step;
        options
    }
}

/// A whole number from `least` on.
pub fn count(least: u64) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync {
    count_up_to(least, 1_000_000)
}

/// A whole number in a range.
fn count_up_to(
    least: u64,
    most: u64,
) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync {
    move |text| whole(text, least, most).map(|count| count as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_flags_fit_together() {
        Arguments::command().debug_assert();
    }

    fn observing(flag: &str, value: &str) -> Result<Arguments, clap::Error> {
        let typed = format!("{flag}={value}");
        let words = ["veribound", "observe", "m.toml", "r.csv", "-o", "out"];
        Arguments::try_parse_from(words.into_iter().chain([typed.as_str()]))
    }

    /// The default is no limit: who has time may give a sample more.
    #[test]
    fn a_budget_may_be_larger_than_the_default() {
        let is_taken = |budget: &str| observing("--budget", budget).is_ok();
        assert!(is_taken("1000000000") && is_taken("1") && !is_taken("0") && !is_taken("-1"));
    }

    /// Wherever a whole number is asked for, the message says so, and which ones there are.
    #[test]
    fn what_is_no_whole_number_is_told_what_is_expected() {
        let said = |flag: &str, value: &str| match observing(flag, value) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("{flag}={value} is taken"),
        };
        let counts = [
            ("--boxes", "from 1 to 1000000"),
            ("--bisections", "from 0 to 1000000"),
            ("--order", "from 1 to 12"),
            ("--halvings", "from 0 to 4294967295"),
            ("--windows", "from 0 to 18446744073709551615"),
            ("--budget", "from 1 to "),
        ];
        for (flag, range) in counts {
            for value in ["abc", "", "-1", "1.5", "99999999999999999999"] {
                let said = said(flag, value);
                let wanted = format!("expected a whole number {range}");
                assert!(said.contains(&wanted) && said.contains(flag), "{said}");
            }
        }
        let said = said("--to", "abc");
        assert!(said.contains("expected a number, as in 0.1"), "{said}");
    }

    #[test]
    fn flags_that_are_not_given_are_the_observers_defaults() {
        let typed = ["veribound", "observe", "m.toml", "r.csv", "-o", "out"];
        let Command::Observe(observe) = Arguments::parse_from(typed).command else {
            panic!("not an observation")
        };
        assert_eq!(observe.method.options(), ObserverOptions::default());
    }
}

/// Names of engines.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum EngineName {
    /// What fits the model, as `veribound check` says
    Auto,
    /// One box that forgets what it depends on: the reference
    Boxes,
    /// Sets that keep how states depend on start values and parameters
    Forms,
    /// Two corners of what is monotone
    Comparison,
    /// As forms, in closed form where a mode is affine in the states
    Closed,
}

impl From<EngineName> for Engine {
    fn from(name: EngineName) -> Engine {
        match name {
            EngineName::Auto => Engine::Auto,
            EngineName::Boxes => Engine::Boxes,
            EngineName::Forms => Engine::Forms,
            EngineName::Comparison => Engine::Comparison,
            EngineName::Closed => Engine::Closed,
        }
    }
}
