//! `summary.json`: the verdict of a run and the bounds it proved.

use super::number::{Number, Time};
use crate::{inward, outward};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use veribound_interval::{Decimal, Interval, text};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::model::{Param, State};

/// What a run says about model and record.
///
/// ```
/// assert_eq!(veribound_data::Verdict::Undecided.name(), "undecided");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Some set of parameters and states was never refuted; it is in the bounds.
    Consistent,
    /// Proved: no parameter in the prior explains the record.
    Inconsistent,
    /// Neither was proved.
    Undecided,
}

impl Verdict {
    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Consistent => "consistent",
            Verdict::Inconsistent => "inconsistent",
            Verdict::Undecided => "undecided",
        }
    }
}

/// The content of `summary.json`.
///
/// *Guarantee*: bounds are decimal numbers rounded outward from what was proved, gaps and shrinks
/// are rounded down. An infinite bound is `null`; where nothing is left, `"empty": true` stands for
/// the bounds.
///
/// ```
/// use veribound_data::{
///     Kind, ParameterSummary, Refutation, ResultFolder, Start, StateSummary, Summary, Verdict, Work,
/// };
/// use veribound_interval::{Decimal, Interval};
/// use veribound_model::Model;
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// let model = Model::from_text("decay.toml", text)?;
/// let proved = Interval::new(0.96875, 1.03125).unwrap();
/// let mut summary = Summary {
///     verdict: Verdict::Consistent,
///     reason: None,
///     refutation: None,
///     samples: 3,
///     parameters: vec![("k".to_owned(), ParameterSummary::new(&model.params[0], proved))],
///     states: vec![("x".to_owned(), StateSummary::new(&model.states[0], Interval::ONE))],
///     work: Work { box_steps: 40, ..Work::default() },
///     interrupted: false,
///     assumptions: Vec::new(),
///     missing: Vec::new(),
/// };
/// // A later run can start from it.
/// # let place = std::env::temp_dir().join(format!("veribound-doc-summary-{}", std::process::id()));
/// let folder = ResultFolder::create(&place)?;
/// folder.publish(vec![folder.write("summary.json", summary.to_json()?.as_bytes())?])?;
/// assert_eq!(Start::read(&place, &model)?.params, [proved]);
/// # std::fs::remove_dir_all(place)?;
/// // What refutes a model is told with its gap, rounded down.
/// let (time, measured) = (Decimal::parse("0.5")?, Interval::point(1.5));
/// summary.verdict = Verdict::Inconsistent;
/// summary.refutation = Some(Refutation::new(Kind::Output, (2, 4, &time), ("y", "m"), (Interval::ONE, measured)));
/// assert!(summary.to_json()?.contains("\"gap\": 0.5"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// The verdict.
    pub verdict: Verdict,
    /// Why, in one sentence; none where the verdict says it all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What refutes the model, when it is refuted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refutation: Option<Refutation>,
    /// Number of samples that were processed.
    pub samples: usize,
    /// Every parameter under its name, in the order of the model.
    #[serde(serialize_with = "by_name")]
    pub parameters: Vec<(String, ParameterSummary)>,
    /// Every state under its name, at the last sample.
    #[serde(serialize_with = "by_name")]
    pub states: Vec<(String, StateSummary)>,
    /// What the run cost.
    pub work: Work,
    /// True when the user ended the run before the end of the record.
    pub interrupted: bool,
    /// What was assumed beside the model file, in sentences.
    pub assumptions: Vec<String>,
    /// Outputs and signals with missing values, and how many each has in the window.
    #[serde(serialize_with = "by_name", skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<(String, usize)>,
}

/// Bounds of one parameter.
///
/// Example: [`Summary`].
#[derive(Debug, Clone, Serialize)]
pub struct ParameterSummary {
    #[serde(flatten)]
    bounds: Ends,
    unit: String,
    prior: Ends,
}

/// Bounds of one state.
///
/// Example: [`Summary`].
#[derive(Debug, Clone, Serialize)]
pub struct StateSummary {
    #[serde(flatten)]
    bounds: Ends,
    unit: String,
}

/// The sample at which the last box was refuted.
///
/// Example: [`Summary`].
#[derive(Debug, Clone, Serialize)]
pub struct Refutation {
    kind: Kind,
    sample: u64,
    line: usize,
    time: Time,
    output: String,
    unit: String,
    gap: Number,
    enclosure: Ends,
    measured: Ends,
}

/// What the model's enclosure contradicts.
///
/// Example: [`Summary`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The measurement of an output.
    Output,
    /// What a signal proves.
    Signal,
    /// How far a state moved, by the measurements.
    Motion,
    /// What all samples say together of a state or parameter.
    Apart,
}

/// What a run cost.
///
/// Example: [`Summary`].
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct Work {
    /// Time for the whole record, in seconds.
    pub wall_s: f64,
    /// Longest time for one sample, in seconds.
    pub worst_sample_s: f64,
    /// Number of boxes times steps.
    pub box_steps: u64,
    /// Most boxes at one time.
    pub boxes_max: usize,
}

/// An interval, printed.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub(super) enum Ends {
    Between { lo: Number, hi: Number },
    Nothing { empty: bool },
}

impl ParameterSummary {
    /// Bounds proved for a parameter; the empty set when it was refuted.
    pub fn new(param: &Param, bounds: Interval) -> Self {
        ParameterSummary {
            bounds: Ends::inside_prior(bounds, param.bounds),
            unit: param.unit.clone(),
            prior: Ends::prior(param.bounds),
        }
    }
}

impl StateSummary {
    /// Bounds proved for a state; the empty set when it was refuted.
    pub fn new(state: &State, bounds: Interval) -> Self {
        StateSummary {
            bounds: Ends::outward(bounds),
            unit: state.unit.clone(),
        }
    }
}

impl Refutation {
    /// What is `measured` of an output, or said of a state in another way, at the sample of this
    /// index (from 0) on `line` at `time`, and the disjoint `enclosure` of all values that the model
    /// allows.
    pub fn new(
        kind: Kind,
        (sample, line, time): (u64, usize, &Decimal),
        (output, unit): (&str, &str),
        (enclosure, measured): (Interval, Interval),
    ) -> Self {
        let gap = (measured - enclosure).mig();
        Refutation {
            kind,
            sample,
            line,
            time: Time::new(time),
            output: output.to_owned(),
            unit: unit.to_owned(),
            // The smallest distance between the two sets, rounded down.
            gap: Number::new(text::lower(gap, outward::DIGITS)),
            enclosure: Ends::outward(enclosure),
            measured: Ends::outward(measured),
        }
    }
}

impl Summary {
    /// The text of `summary.json`.
    ///
    /// *Errors*: `E0503` when it has no form in JSON.
    pub fn to_json(&self) -> Result<String, Diagnostic> {
        to_json(self)
    }
}

/// The text of a document.
///
/// *Errors*: `E0503` when it has no form in JSON.
pub fn to_json(summary: &impl Serialize) -> Result<String, Diagnostic> {
    let mut text = serde_json::to_string_pretty(summary).map_err(|error| {
        Diagnostic::new(
            "E0503",
            format!("the document cannot be written as JSON: {error}"),
        )
    })?;
    text.push('\n');
    Ok(text)
}

impl Ends {
    pub(super) fn outward(bounds: Interval) -> Self {
        if bounds.is_empty() {
            return Ends::Nothing { empty: true };
        }
        Ends::new((outward::lower(bounds), outward::upper(bounds)))
    }

    /// Of what is proved to be reached; none where nothing is.
    pub(super) fn inward(bounds: Interval) -> Option<Self> {
        inward::ends(bounds).map(Ends::new)
    }

    /// Bounds of what lies, by the user's word, in the prior.
    pub(super) fn inside_prior(bounds: Interval, prior: Interval) -> Self {
        if bounds.is_empty() {
            return Ends::outward(bounds);
        }
        Ends::new(outward::inside_prior(bounds, prior))
    }

    /// The prior as the user spelled it.
    pub(super) fn prior(prior: Interval) -> Self {
        Ends::new(text::spelled(prior))
    }

    fn new((lo, hi): (String, String)) -> Self {
        Ends::Between {
            lo: Number::new(lo),
            hi: Number::new(hi),
        }
    }
}

/// A JSON object in the order of the list.
pub(super) fn by_name<T: Serialize, S: Serializer>(
    entries: &[(String, T)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut map = serializer.serialize_map(Some(entries.len()))?;
    for (name, value) in entries {
        map.serialize_entry(name, value)?;
    }
    map.end()
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_model::model::Model;

    fn interval(lo: &str, hi: &str) -> Interval {
        let end = |text| Decimal::parse(text).unwrap().to_interval();
        end(lo).hull(end(hi))
    }

    fn model() -> Model {
        let text = "format = 1\n\
            [states]\nomega = { unit = \"rad/s\", init = 0 }\n\
            [params]\nalpha = { unit = \"1/s\", bounds = [-6, -0.05] }\nbeta = [100, 400]\n\
            [der]\nomega = \"alpha * omega + beta\"\n\
            [outputs]\nphi_m = { expr = \"omega\", error = { absolute = 0.1 } }\n";
        Model::from_text("x.toml", text).unwrap()
    }

    #[test]
    fn the_file_has_its_fixed_shape() {
        let model = model();
        let [alpha, beta] = model.params.as_slice() else {
            panic!()
        };
        let half_line = interval("-1e-12", "0").hull(Interval::new(0.0, f64::INFINITY).unwrap());
        let (enclosure, measured) = (interval("62.61", "62.93"), interval("63.02", "63.22"));
        let time = Decimal::parse("41.25").unwrap();
        let summary = Summary {
            verdict: Verdict::Inconsistent,
            reason: Some("no parameter in the prior explains the data".to_owned()),
            refutation: Some(Refutation::new(
                Kind::Output,
                (4125, 4127, &time),
                ("phi_m", "rad"),
                (enclosure, measured),
            )),
            samples: 8001,
            parameters: vec![
                (
                    "alpha".to_owned(),
                    ParameterSummary::new(alpha, interval("-2.6", "-0.05")),
                ),
                (
                    "beta".to_owned(),
                    ParameterSummary::new(beta, Interval::EMPTY),
                ),
            ],
            states: vec![(
                "omega".to_owned(),
                StateSummary::new(&model.states[0], half_line),
            )],
            work: Work {
                wall_s: 1.5,
                worst_sample_s: 0.0003,
                box_steps: 12,
                boxes_max: 50,
            },
            interrupted: false,
            assumptions: vec!["the angle is in deg".to_owned()],
            missing: vec![("phi_m".to_owned(), 3)],
        };
        let expected = r#"{
  "verdict": "inconsistent",
  "reason": "no parameter in the prior explains the data",
  "refutation": {
    "kind": "output",
    "sample": 4125,
    "line": 4127,
    "time": 41.25,
    "output": "phi_m",
    "unit": "rad",
    "gap": 0.0899999999999,
    "enclosure": {
      "lo": 62.6099999999,
      "hi": 62.9300000001
    },
    "measured": {
      "lo": 63.0199999999,
      "hi": 63.2200000001
    }
  },
  "samples": 8001,
  "parameters": {
    "alpha": {
      "lo": -2.60000000001,
      "hi": -0.05,
      "unit": "1/s",
      "prior": {
        "lo": -6,
        "hi": -0.05
      }
    },
    "beta": {
      "empty": true,
      "unit": "",
      "prior": {
        "lo": 100,
        "hi": 400
      }
    }
  },
  "states": {
    "omega": {
      "lo": -1.00000000001e-12,
      "hi": null,
      "unit": "rad/s"
    }
  },
  "work": {
    "wall_s": 1.5,
    "worst_sample_s": 0.0003,
    "box_steps": 12,
    "boxes_max": 50
  },
  "interrupted": false,
  "assumptions": [
    "the angle is in deg"
  ],
  "missing": {
    "phi_m": 3
  }
}
"#;
        assert_eq!(summary.to_json().unwrap(), expected);
    }
}
