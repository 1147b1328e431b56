//! `veribound check`: what a model file was understood to say.

use super::arguments::Check;
use super::ending::Ending;
use super::engine::plan;
use super::{Outcome, message};
use veribound_model::Model;

/// Reads the model and describes it.
pub fn run(arguments: &Check) -> Outcome {
    let model = Model::from_file(&arguments.model)?;
    let description = model.describe();
    let plan = plan(&model);
    message::say(&format!("{}\n\n{plan}\n", description.trim_end()));
    Ok(Ending::Done)
}
