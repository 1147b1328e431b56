//! Flags of `veribound identify`.

use super::super::arguments::{Reading, Shown, Weakening, count};
use super::super::flags::{ShareFlag, times};
use clap::Args;
use std::path::PathBuf;
use std::thread::available_parallelism;
use veribound_estimate::identify::IdentifyOptions;

/// Flags of `veribound identify`.
#[derive(Debug, Args)]
pub struct Identify {
    /// What was typed, word by word.
    #[arg(skip = super::super::run_info::typed())]
    pub words: Vec<String>,
    /// Model file (TOML)
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Records (CSV with a header, MATLAB MAT, HDF5 or Parquet) of one machine: they share the parameters, and
    /// each has start states of its own
    #[arg(value_name = "RECORD", required = true)]
    pub records: Vec<PathBuf>,
    /// Folder for the results; it is made where it does not exist, and results of an earlier run in it
    /// are replaced when all new ones are complete
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,

    /// How the records are read.
    #[command(flatten)]
    pub reading: Reading,
    /// What the run assumes.
    #[command(flatten)]
    pub weakening: Weakening,

    /// Bounds that are proved to be at most so many times as wide as possible are tight enough
    #[arg(long, value_name = "TIMES", default_value_t = IdentifyOptions::default().tightness,
          value_parser = times, help_heading = "Method")]
    pub tightness: f64,
    /// Divide the prior into tiles proved inside, proved outside and undecided, until the undecided ones are
    /// this share of the box that is left, as in 1%
    #[arg(long, value_name = "SHARE", help_heading = "Method")]
    pub paving: Option<ShareFlag>,
    /// Also tell how often the declared measurement errors must be taken at least for anything to agree; this is always
    /// told where nothing agrees
    #[arg(long, help_heading = "Method")]
    pub least_error: bool,
    /// Also tell how often the declared errors of inputs and the disturbances must be taken at least for anything to
    /// agree
    #[arg(long, help_heading = "Method")]
    pub least_disturbance: bool,
    /// Most sets of parameters that are looked at
    #[arg(long, value_name = "N", default_value_t = IdentifyOptions::default().sets,
          value_parser = count(1), help_heading = "Method")]
    pub sets: usize,
    /// Threads, as many as the machine has if not given; results do not depend on them
    #[arg(short = 'j', long, value_name = "N", value_parser = count(1), help_heading = "Method")]
    pub threads: Option<usize>,

    /// Memory in MiB for sets and tiles, beside those in work; nothing is divided further when it is taken
    #[arg(long, value_name = "MIB", value_parser = count(1), help_heading = "Method")]
    pub memory: Option<usize>,
    /// Go on where an earlier run with the same flags was ended by force or by Ctrl-C, from the
    /// checkpoint in the folder of the results; the result is that of a run that was never ended
    #[arg(long, help_heading = "Method")]
    pub resume: bool,

    /// What the run shows.
    #[command(flatten)]
    pub showing: Shown,
}

impl Identify {
    /// The settings in the estimator's own words.
    pub fn options(&self) -> IdentifyOptions {
        let machine = || available_parallelism().map_or(1, usize::from);
        IdentifyOptions {
            tightness: self.tightness,
            // Rounded down: not more is left than was asked for.
            undecided: self.paving.as_ref().map(|share| share.0.to_interval().lo()),
            sets: self.sets,
            threads: self.threads.unwrap_or_else(machine),
            memory: self
                .memory
                .map_or(usize::MAX, |mib| mib.saturating_mul(1 << 20)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::arguments::{Arguments, Command};
    use super::*;
    use clap::Parser;

    fn parse(more: &str) -> Box<Identify> {
        let typed = format!("veribound identify m.toml r.csv s.csv -o out {more}");
        match Arguments::parse_from(typed.split_whitespace()).command {
            Command::Identify(identify) => identify,
            _ => panic!("not an identification"),
        }
    }

    #[test]
    fn flags_that_are_not_given_are_the_estimators_defaults() {
        let identify = parse("-j 1");
        assert_eq!(identify.options(), IdentifyOptions::default());
        assert_eq!(identify.records.len(), 2);
        assert!(parse("").options().threads >= 1);
    }

    #[test]
    fn flags_mean_what_they_say() {
        let more = "--paving 1% --tightness 1.2 --sets 7 --threads 3 --memory 5 --from 1 --until 2";
        let identify = parse(more);
        let options = IdentifyOptions {
            tightness: 1.2,
            undecided: Some(0.01_f64.next_down()),
            sets: 7,
            threads: 3,
            memory: 5 << 20,
        };
        let found = identify.options();
        assert_eq!((found.sets, found.threads), (options.sets, options.threads));
        assert_eq!(
            (found.tightness, found.memory),
            (options.tightness, options.memory)
        );
        let share = found.undecided.unwrap();
        assert!(share <= 0.01 && share > 0.009_999_999);
        let last = identify.reading.to.as_ref().unwrap();
        assert_eq!(last.to_string(), "2");
        assert_eq!(parse("--to 2").reading.to.as_ref(), Some(last));
    }
}
