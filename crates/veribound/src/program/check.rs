//! `veribound check`: what a model file was understood to say.

use super::arguments::Check;
use super::ending::Ending;
use super::engine::{outlook, plan};
use super::{Outcome, message};
use veribound_data::ModelSummary;
use veribound_flow::comparison::Comparison;
use veribound_model::Model;

/// Reads the model and describes it.
pub fn run(arguments: &Check) -> Outcome {
    let model = Model::from_file(&arguments.model)?;
    let text = told(&model);
    if arguments.json {
        let outlook = outlook(&model, &Comparison::new(&model));
        let plan = plan(&model, &outlook);
        message::say(&ModelSummary::new(&model, plan, text).to_json()?);
    } else {
        message::say(&text);
    }
    Ok(Ending::Done)
}

/// What was understood, and how its solutions will be enclosed.
pub fn told(model: &Model) -> String {
    let description = model.describe();
    let outlook = outlook(model, &Comparison::new(model));
    let plan = plan(model, &outlook);
    format!("{}\n\n{plan}\n", description.trim_end())
}
