//! What a model was understood to be, as JSON.

use super::summary::{Ends, by_name, to_json};
use crate::digest::sha256_of_text;
use serde::Serialize;
use veribound_interval::Interval;
use veribound_model::diagnostic::Diagnostic;
use veribound_model::model::{Coverage, Model};

/// A model in the form of the summaries: what `veribound check --json` prints.
///
/// *Guarantee*: bounds are spelled as in the model file.
///
/// ```
/// use veribound_data::ModelSummary;
/// use veribound_model::Model;
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [0, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// let model = Model::from_text("decay.toml", text)?;
/// let told = ModelSummary::new(&model, "boxes".to_owned(), String::new()).to_json()?;
/// assert!(told.contains("\"file\": \"decay.toml\""));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Serialize)]
pub struct ModelSummary {
    name: String,
    file: String,
    sha256: String,
    #[serde(serialize_with = "by_name")]
    states: Vec<(String, Described)>,
    #[serde(serialize_with = "by_name")]
    inputs: Vec<(String, Described)>,
    #[serde(serialize_with = "by_name")]
    parameters: Vec<(String, Described)>,
    #[serde(serialize_with = "by_name")]
    outputs: Vec<(String, Described)>,
    signals: Vec<String>,
    modes: Vec<String>,
    jumps: usize,
    /// Whether it is proved that the modes leave no gap: `everywhere`, `in the domain`, or where not.
    covered: String,
    notes: Vec<String>,
    /// How solutions are enclosed, in words.
    engine: String,
    /// The text that is printed without `--json`.
    description: String,
}

#[derive(Debug, Clone, Serialize)]
struct Described {
    unit: String,
    /// Start interval of a state, bounds of a disturbance, prior of a parameter.
    #[serde(skip_serializing_if = "Option::is_none")]
    bounds: Option<Ends>,
}

impl ModelSummary {
    /// What is known of a model; `engine` tells how it is enclosed, `description` all of it as text.
    pub fn new(model: &Model, engine: String, description: String) -> Self {
        let entry = |name: &str, unit: &str, bounds: Option<Interval>| {
            let described = Described {
                unit: unit.to_owned(),
                bounds: bounds.map(Ends::prior),
            };
            (name.to_owned(), described)
        };
        let states = model.states.iter();
        let inputs = model.inputs.iter();
        let params = model.params.iter();
        let outputs = model.outputs.iter();
        ModelSummary {
            name: model.name.clone(),
            file: model.source.name.clone(),
            sha256: sha256_of_text(&model.source.text),
            states: states
                .map(|x| entry(&x.name, &x.unit, Some(x.init)))
                .collect(),
            inputs: inputs.map(|u| entry(&u.name, &u.unit, u.within)).collect(),
            parameters: params
                .map(|p| entry(&p.name, &p.unit, Some(p.bounds)))
                .collect(),
            outputs: outputs.map(|y| entry(&y.name, &y.unit, None)).collect(),
            signals: model
                .signals
                .iter()
                .map(|signal| signal.name.clone())
                .collect(),
            modes: model.modes.iter().map(|mode| mode.name.clone()).collect(),
            jumps: model.jumps.len(),
            covered: match &model.coverage {
                Coverage::Everywhere => "everywhere".to_owned(),
                Coverage::InDomain { .. } => "in the domain".to_owned(),
                Coverage::Unproved(place) => format!("not proved: {place}"),
            },
            notes: model.notes.clone(),
            engine,
            description,
        }
    }

    /// The text of the document.
    ///
    /// *Errors*: `E0503` when it has no form in JSON.
    pub fn to_json(&self) -> Result<String, Diagnostic> {
        to_json(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_spelled_as_in_the_file() {
        let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = [-1, 0.3]\ninputs = [\"u\"]\nparams.k = [-6, -0.05]\n\
            der.x = \"k*x + u\"\noutputs.y = \"x +- 0.1\"\n";
        let model = Model::from_text("m.toml", text).unwrap();
        let json = ModelSummary::new(&model, "forms".to_owned(), "all".to_owned());
        let json = json.to_json().unwrap();
        for part in [
            "\"lo\": -1,",
            "\"hi\": 0.3",
            "\"hi\": -0.05",
            "\"unit\": \"m\"",
            "\"modes\": [\n    \"smooth\"\n  ]",
        ] {
            assert!(json.contains(part), "no {part} in {json}");
        }
    }
}
