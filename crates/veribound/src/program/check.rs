//! `veribound check`: what a model file was understood to say.

use super::arguments::Check;
use super::ending::Ending;
use super::engine::plan;
use super::{Outcome, message};
use veribound_data::ModelSummary;
use veribound_model::Model;

/// Reads the model and describes it.
pub fn run(arguments: &Check) -> Outcome {
    let model = Model::from_file(&arguments.model)?;
    if arguments.json {
        let text = told(&model);
        message::say(&ModelSummary::new(&model, plan(&model), text).to_json()?);
    } else {
        message::say(&told(&model));
    }
    Ok(Ending::Done)
}

/// What was understood, and how its solutions will be enclosed.
pub fn told(model: &Model) -> String {
    let description = model.describe();
    format!("{}\n\n{}\n", description.trim_end(), plan(model))
}
