//! `summary.json` of an identification: bounds from both sides.

use super::number::{Number, Time};
use super::summary::{Ends, Verdict, by_name, to_json};
use crate::outward::DIGITS;
use serde::Serialize;
use veribound_interval::{Decimal, Interval, text};
use veribound_model::diagnostic::Diagnostic;
use veribound_model::model::{Param, State};

/// The content of `summary.json` of an identification.
///
/// *Guarantee*: `lo` and `hi` are rounded outward from what was proved to hold all values, those of
/// `inner` inward from what is proved to be reached, `tightness` up. An infinite number is `null`, as is
/// `inner` where nothing is proved to be reached; where nothing is left, `"empty": true` stands for the
/// bounds.
///
/// ```
/// use veribound_data::{
///     IdentifiedParameter, IdentifiedReset, IdentifiedStart, IdentifiedState, IdentifiedSummary, IdentifiedWork,
///     LeastErrors, Paving, RefutedTogether, Verdict,
/// };
/// use veribound_interval::{Decimal, Interval};
/// use veribound_model::Model;
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = [0, 2]\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// let model = Model::from_text("decay.toml", text)?;
/// let (k, x) = (&model.params[0], &model.states[0]);
/// let both = (Interval::new(0.5, 1.0).unwrap(), Some(Interval::new(0.625, 0.875).unwrap()));
/// let (from, until) = (Decimal::zero(), Decimal::parse("2")?);
/// let summary = IdentifiedSummary {
///     verdict: Verdict::Consistent,
///     reason: None,
///     refutation: None::<RefutedTogether>,
///     samples: 20,
///     parameters: vec![("k".to_owned(), IdentifiedParameter::new(k, both, 2.0, Some("record")))],
///     starts: vec![IdentifiedStart {
///         record: "r.csv".to_owned(),
///         states: vec![("x".to_owned(), IdentifiedState::new(x, both, 2.0))],
///     }],
///     resets: vec![IdentifiedReset::new("r.csv".to_owned(), k, (&from, &until), both, 2.0)],
///     least_error: Some(LeastErrors::new(Interval::ONE, &model.params, None)),
///     least_disturbance: None,
///     paving: Some(Paving::new(12, [0.75, 0.125].map(Interval::point), Interval::point(0.5))),
///     points: 4,
///     work: IdentifiedWork::default(),
///     interrupted: false,
///     assumptions: Vec::new(),
///     missing: Vec::new(),
/// };
/// assert!(summary.to_json()?.contains("\"limited_by\": \"record\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize)]
pub struct IdentifiedSummary {
    /// The verdict.
    pub verdict: Verdict,
    /// Why, in one sentence; none where the verdict says it all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// What refutes the model, when it is refuted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refutation: Option<RefutedTogether>,
    /// Number of samples of all records.
    pub samples: usize,
    /// Every parameter under its name, in the order of the model.
    #[serde(serialize_with = "by_name")]
    pub parameters: Vec<(String, IdentifiedParameter)>,
    /// Start states, by record.
    pub starts: Vec<IdentifiedStart>,
    /// Values of parameters after resets, in order of records and time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub resets: Vec<IdentifiedReset>,
    /// How large measurement errors must be at least, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_error: Option<LeastErrors>,
    /// How large errors of inputs and disturbances must be at least, if that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_disturbance: Option<LeastErrors>,
    /// The paving, if one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paving: Option<Paving>,
    /// Number of points in `points.csv`.
    pub points: usize,
    /// What the run cost.
    pub work: IdentifiedWork,
    /// True when the user ended the run.
    pub interrupted: bool,
    /// What was assumed beside the model file, in sentences.
    pub assumptions: Vec<String>,
    /// Outputs and signals with missing values, and how many each has in all records.
    #[serde(serialize_with = "by_name", skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<(String, usize)>,
}

/// Bounds from both sides.
#[derive(Debug, Clone, Serialize)]
struct TwoSided {
    #[serde(flatten)]
    outer: Ends,
    inner: Option<Ends>,
    tightness: Number,
}

/// Bounds of one parameter.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct IdentifiedParameter {
    #[serde(flatten)]
    bounds: TwoSided,
    /// What limits the bounds: `record`, `sets` or `enclosure`.
    #[serde(skip_serializing_if = "Option::is_none")]
    limited_by: Option<&'static str>,
    unit: String,
    prior: Ends,
}

/// Bounds of one state at the first sample of a record.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct IdentifiedState {
    #[serde(flatten)]
    bounds: TwoSided,
    unit: String,
}

/// The states at the first sample of one record.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct IdentifiedStart {
    /// Path of the record as the user gave it.
    pub record: String,
    /// Every state under its name, in the order of the model.
    #[serde(serialize_with = "by_name")]
    pub states: Vec<(String, IdentifiedState)>,
}

/// The value of one parameter between two resets that there may have been.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct IdentifiedReset {
    record: String,
    parameter: String,
    from: Time,
    until: Time,
    #[serde(flatten)]
    bounds: TwoSided,
    unit: String,
}

/// How large some errors must be at least for the model and the records to agree, as multiple of the declared ones.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct LeastErrors {
    /// With less nothing agrees.
    at_least: Number,
    /// With this something does; `null` where none is known.
    enough: Number,
    /// Parameters with which it does.
    #[serde(serialize_with = "by_name", skip_serializing_if = "Vec::is_empty")]
    parameters: Vec<(String, Ends)>,
}

/// Samples that refute the model together.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct RefutedTogether {
    /// Path of their record as the user gave it.
    pub record: String,
    /// Their positions among the samples that were read, from 0 on.
    pub samples: Vec<usize>,
    /// Their lines in the file.
    pub lines: Vec<usize>,
    time: Time,
    line: usize,
}

/// What a paving covers. Shares are of the volume of the outer box, of its tiles together; the volume is of what agrees,
/// in undecided tiles by the part that samples leave.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Serialize)]
pub struct Paving {
    /// Number of tiles.
    pub tiles: usize,
    inside: Number,
    undecided: Number,
    volume: Ends,
}

/// What an identification cost.
///
/// Example: [`IdentifiedSummary`].
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct IdentifiedWork {
    /// Time in seconds.
    pub wall_s: f64,
    /// Number of sets that were looked at.
    pub sets: usize,
    /// Number of times that a set was moved through a record.
    pub passes: usize,
}

impl TwoSided {
    fn new(outer: Ends, inner: Option<Interval>, tightness: f64) -> Self {
        TwoSided {
            outer,
            inner: inner.and_then(Ends::inward),
            tightness: Number::new(text::upper(tightness, 6)),
        }
    }
}

impl IdentifiedParameter {
    /// What is proved of a parameter: all its values lie in `outer` (the empty set when it is refuted),
    /// both ends of `inner` are reached, and `outer` is `tightness` times as wide at most.
    pub fn new(
        param: &Param,
        (outer, inner): (Interval, Option<Interval>),
        tightness: f64,
        limited_by: Option<&'static str>,
    ) -> Self {
        let outer = Ends::inside_prior(outer, param.bounds);
        IdentifiedParameter {
            bounds: TwoSided::new(outer, inner, tightness),
            limited_by,
            unit: param.unit.clone(),
            prior: Ends::prior(param.bounds),
        }
    }
}

impl IdentifiedState {
    /// What is proved of a state at the start, as [`IdentifiedParameter::new`] says.
    pub fn new(
        state: &State,
        (outer, inner): (Interval, Option<Interval>),
        tightness: f64,
    ) -> Self {
        let outer = Ends::inside_prior(outer, state.init);
        IdentifiedState {
            bounds: TwoSided::new(outer, inner, tightness),
            unit: state.unit.clone(),
        }
    }
}

impl IdentifiedReset {
    /// What is proved of a parameter of the record `record` between two time stamps, as
    /// [`IdentifiedParameter::new`] says.
    pub fn new(
        record: String,
        param: &Param,
        (from, until): (&Decimal, &Decimal),
        (outer, inner): (Interval, Option<Interval>),
        tightness: f64,
    ) -> Self {
        let outer = Ends::inside_prior(outer, param.bounds);
        IdentifiedReset {
            record,
            parameter: param.name.clone(),
            from: Time::new(from),
            until: Time::new(until),
            bounds: TwoSided::new(outer, inner, tightness),
            unit: param.unit.clone(),
        }
    }
}

impl LeastErrors {
    /// Nothing agrees below the lower end of `factor`, something does at its upper end, with these parameters.
    pub fn new(factor: Interval, params: &[Param], point: Option<&[Interval]>) -> Self {
        let point = point.unwrap_or_default();
        let both = params.iter().zip(point);
        LeastErrors {
            at_least: Number::new(text::lower(factor.lo(), DIGITS)),
            enough: Number::new(text::upper(factor.hi(), DIGITS)),
            parameters: both
                .map(|(param, x)| (param.name.clone(), Ends::inside_prior(*x, param.bounds)))
                .collect(),
        }
    }
}

impl RefutedTogether {
    /// The samples at these positions, on these lines; the last of them is read at `time` on `line`.
    pub fn new(
        record: String,
        (samples, lines): (Vec<usize>, Vec<usize>),
        (time, line): (&Decimal, usize),
    ) -> Self {
        RefutedTogether {
            record,
            samples,
            lines,
            time: Time::new(time),
            line,
        }
    }
}

impl Paving {
    /// So many tiles, of which those inside and those undecided have these shares of the outer box.
    /// What agrees has this volume.
    pub fn new(tiles: usize, [inside, undecided]: [Interval; 2], volume: Interval) -> Self {
        Paving {
            tiles,
            volume: Ends::outward(volume),
            inside: Number::new(text::lower(inside.lo(), DIGITS)),
            undecided: Number::new(text::upper(undecided.hi(), DIGITS)),
        }
    }
}

impl IdentifiedSummary {
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
    use veribound_model::model::Model;

    #[test]
    fn the_file_has_its_fixed_shape() {
        let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = [-1, 1]\n\
            params.k = { unit = \"1/s\", bounds = [-6, -0.05] }\nparams.c = [0, 1]\n\
            der.x = \"k*x + c\"\noutputs.y = \"x +- 0.1\"\n";
        let model = Model::from_text("m.toml", text).unwrap();
        let [k, c] = model.params.as_slice() else {
            panic!()
        };
        let interval = |lo: f64, hi: f64| Interval::new(lo, hi).unwrap();
        let third = 1.0 / 3.0;
        let cut = interval(-2.0 * third, k.bounds.hi());
        let start = IdentifiedState::new(
            &model.states[0],
            (interval(-third, third), Some(interval(-0.3, 0.3))),
            1.1112,
        );
        let time = Decimal::parse("41.250").unwrap();
        let summary = IdentifiedSummary {
            verdict: Verdict::Inconsistent,
            reason: Some("no parameter in the prior explains the data".to_owned()),
            refutation: Some(RefutedTogether::new(
                "r.csv".to_owned(),
                (vec![3, 7], vec![5, 9]),
                (&time, 9),
            )),
            samples: 20,
            parameters: vec![
                (
                    "k".to_owned(),
                    IdentifiedParameter::new(
                        k,
                        (cut, Some(interval(-third, -0.1))),
                        2.642_857_19,
                        Some("record"),
                    ),
                ),
                (
                    "c".to_owned(),
                    IdentifiedParameter::new(c, (Interval::EMPTY, None), f64::INFINITY, None),
                ),
            ],
            starts: vec![IdentifiedStart {
                record: "r.csv".to_owned(),
                states: vec![("x".to_owned(), start)],
            }],
            resets: Vec::new(),
            least_error: None,
            least_disturbance: None,
            paving: Some(Paving::new(
                12,
                [interval(third, third), interval(third, third)],
                interval(third, third),
            )),
            points: 4,
            work: IdentifiedWork {
                wall_s: 0.5,
                sets: 12,
                passes: 30,
            },
            interrupted: false,
            assumptions: Vec::new(),
            missing: Vec::new(),
        };
        let expected = r#"{
  "verdict": "inconsistent",
  "reason": "no parameter in the prior explains the data",
  "refutation": {
    "record": "r.csv",
    "samples": [
      3,
      7
    ],
    "lines": [
      5,
      9
    ],
    "time": 41.25,
    "line": 9
  },
  "samples": 20,
  "parameters": {
    "k": {
      "lo": -0.666666666667,
      "hi": -0.05,
      "inner": {
        "lo": -0.333333333333,
        "hi": -0.100000000001
      },
      "tightness": 2.64286,
      "limited_by": "record",
      "unit": "1/s",
      "prior": {
        "lo": -6,
        "hi": -0.05
      }
    },
    "c": {
      "empty": true,
      "inner": null,
      "tightness": null,
      "unit": "",
      "prior": {
        "lo": 0,
        "hi": 1
      }
    }
  },
  "starts": [
    {
      "record": "r.csv",
      "states": {
        "x": {
          "lo": -0.333333333334,
          "hi": 0.333333333334,
          "inner": {
            "lo": -0.299999999999,
            "hi": 0.299999999999
          },
          "tightness": 1.1112,
          "unit": "m"
        }
      }
    }
  ],
  "paving": {
    "tiles": 12,
    "inside": 0.333333333333,
    "undecided": 0.333333333334,
    "volume": {
      "lo": 0.333333333333,
      "hi": 0.333333333334
    }
  },
  "points": 4,
  "work": {
    "wall_s": 0.5,
    "sets": 12,
    "passes": 30
  },
  "interrupted": false,
  "assumptions": []
}
"#;
        assert_eq!(summary.to_json().unwrap(), expected);
    }
}
