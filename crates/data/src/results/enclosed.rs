//! `summary.json` of an enclosure: how far it is proved, and the sets at the end and over all times.

use super::number::Time;
use super::summary::{Ends, by_name, to_json};
use serde::Serialize;
use veribound_interval::Interval;
use veribound_model::diagnostic::Diagnostic;

/// Whether all solutions are enclosed to the time that was asked for.
///
/// Example: [`EnclosureSummary`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reach {
    /// They are.
    Proved,
    /// Only up to an earlier time.
    Undecided,
}

/// The content of `summary.json` of an enclosure.
///
/// *Guarantee*: bounds are decimal numbers rounded outward from what was proved. An infinite bound is
/// `null`.
///
/// ```
/// use veribound_data::{EnclosureSummary, EnclosureWork, PastUse, RangeSummary, Reach, Time, Trajectories};
/// use veribound_interval::{Decimal, Interval};
///
/// let (start, always) = (Interval::ONE, Interval::new(0.5, 1.0).unwrap());
/// let summary = EnclosureSummary {
///     verdict: Reach::Proved,
///     reason: None,
///     until: Time::new(&Decimal::parse("2.50")?),
///     times: 6,
///     states: vec![("x".to_owned(), RangeSummary::new("m", start, always))],
///     outputs: Vec::new(),
///     modes: Vec::new(),
///     engine: "forms".to_owned(),
///     parts: 1,
///     trajectories: Some(Trajectories { drawn: 8, inside: 8, followed: 8, comparisons: 40 }),
///     past_use: Vec::<PastUse>::new(),
///     work: EnclosureWork { wall_s: 0.1, steps: 12 },
///     interrupted: false,
///     assumptions: Vec::new(),
/// };
/// assert!(summary.to_json()?.contains("\"until\": 2.5"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize)]
pub struct EnclosureSummary {
    /// How far.
    pub verdict: Reach,
    /// What stood in the way, in one sentence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The last time up to which everything is proved, in seconds.
    pub until: Time,
    /// Number of times in the table, the start included.
    pub times: usize,
    /// Every state under its name, in the order of the model.
    #[serde(serialize_with = "by_name")]
    pub states: Vec<(String, RangeSummary)>,
    /// Every output under its name.
    #[serde(serialize_with = "by_name")]
    pub outputs: Vec<(String, RangeSummary)>,
    /// Modes that may have acted since the last time but one.
    pub modes: Vec<String>,
    /// The engines that proved the bounds, and what stood in the way of the best one.
    pub engine: String,
    /// Number of parts that the set was divided into.
    pub parts: usize,
    /// True trajectories that were compared, if any were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trajectories: Option<Trajectories>,
    /// States whose widths grew past use.
    pub past_use: Vec<PastUse>,
    /// What the run cost.
    pub work: EnclosureWork,
    /// True when the user ended the run.
    pub interrupted: bool,
    /// What was assumed beside the model file, in sentences.
    pub assumptions: Vec<String>,
}

/// Bounds of a state or an output.
///
/// Example: [`EnclosureSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct RangeSummary {
    #[serde(flatten)]
    end: Ends,
    /// Over all times.
    always: Ends,
    unit: String,
}

impl RangeSummary {
    /// Bounds at the end and over all times.
    pub fn new(unit: &str, end: Interval, always: Interval) -> Self {
        RangeSummary {
            end: Ends::outward(end),
            always: Ends::outward(always),
            unit: unit.to_owned(),
        }
    }
}

/// How true trajectories compare with the enclosure. One that is not inside would be an error of the program, and
/// no summary would be written.
///
/// Example: [`EnclosureSummary`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Trajectories {
    /// Number of random trajectories.
    pub drawn: usize,
    /// How many are proved to be inside wherever they were compared.
    pub inside: usize,
    /// How many could be followed to the end; the others were compared until they could not.
    pub followed: usize,
    /// Number of comparisons of a trajectory with the bounds at or between times.
    pub comparisons: u64,
}

/// A width that grew past use.
///
/// Example: [`EnclosureSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct PastUse {
    /// The state.
    pub state: String,
    /// The time from which on its width is larger than the range in which its middle moved before, and than ten
    /// times its width at the start.
    pub since: Time,
    /// The term of its right-hand side that made it grow most, as it is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub term: Option<String>,
    /// Where that is written: the line of the model file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<usize>,
    /// What to try.
    pub remedy: String,
}

/// What an enclosure cost.
///
/// Example: [`EnclosureSummary`].
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct EnclosureWork {
    /// Time in seconds.
    pub wall_s: f64,
    /// Number of steps that were proved.
    pub steps: u64,
}

impl EnclosureSummary {
    /// The text of `summary.json`.
    ///
    /// *Errors*: `E0503` when it has no form in JSON.
    pub fn to_json(&self) -> Result<String, Diagnostic> {
        to_json(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_interval::Decimal;

    #[test]
    fn the_file_has_its_fixed_shape() {
        let interval = |lo: f64, hi: f64| Interval::new(lo, hi).unwrap();
        let half = interval(0.5, f64::INFINITY);
        let time = |text: &str| Time::new(&Decimal::parse(text).unwrap());
        let summary = EnclosureSummary {
            verdict: Reach::Undecided,
            reason: Some("the set grows too fast for any step".to_owned()),
            until: time("0.750"),
            times: 4,
            states: vec![(
                "x".to_owned(),
                RangeSummary::new("m", interval(1.0, 2.0), half),
            )],
            outputs: Vec::new(),
            modes: vec!["slip".to_owned()],
            engine: "forms".to_owned(),
            parts: 2,
            trajectories: Some(Trajectories {
                drawn: 9,
                inside: 8,
                followed: 9,
                comparisons: 70,
            }),
            past_use: vec![PastUse {
                state: "x".to_owned(),
                since: time("0.5"),
                term: Some("x^2".to_owned()),
                line: Some(4),
                remedy: "a narrower start of `x`".to_owned(),
            }],
            work: EnclosureWork {
                wall_s: 0.5,
                steps: 12,
            },
            interrupted: false,
            assumptions: Vec::new(),
        };
        let expected = r#"{
  "verdict": "undecided",
  "reason": "the set grows too fast for any step",
  "until": 0.75,
  "times": 4,
  "states": {
    "x": {
      "lo": 1,
      "hi": 2,
      "always": {
        "lo": 0.5,
        "hi": null
      },
      "unit": "m"
    }
  },
  "outputs": {},
  "modes": [
    "slip"
  ],
  "engine": "forms",
  "parts": 2,
  "trajectories": {
    "drawn": 9,
    "inside": 8,
    "followed": 9,
    "comparisons": 70
  },
  "past_use": [
    {
      "state": "x",
      "since": 0.5,
      "term": "x^2",
      "line": 4,
      "remedy": "a narrower start of `x`"
    }
  ],
  "work": {
    "wall_s": 0.5,
    "steps": 12
  },
  "interrupted": false,
  "assumptions": []
}
"#;
        assert_eq!(summary.to_json().unwrap(), expected);
    }
}
