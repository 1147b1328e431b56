//! A model with one variable of every kind, for tests of records.
#![allow(dead_code, reason = "every test file uses its own part of this one")]

use std::path::PathBuf;
use veribound_interval::{Decimal, Interval};
use veribound_model::model::Model;

pub fn decimal(text: &str) -> Decimal {
    Decimal::parse(text).unwrap()
}

/// The smallest interval around two decimals.
pub fn interval(lo: &str, hi: &str) -> Interval {
    decimal(lo).to_interval().hull(decimal(hi).to_interval())
}

/// A model from its inputs, outputs and signals; its equations do not matter.
pub fn model(inputs: &str, outputs: &str, signals: &str) -> Model {
    let text = format!(
        "format = 1\n\
         [states]\nx = {{ init = 0 }}\n\
         [inputs]\n{inputs}\n\
         [params]\nalpha = [-6, -0.05]\nbeta = {{ unit = \"1/s\", bounds = [100, 400] }}\n\
         [der]\nx = \"alpha + beta\"\n\
         [outputs]\n{outputs}\n\
         [signals]\n{signals}\n"
    );
    match Model::from_text("test.toml", text) {
        Ok(model) => model,
        Err(problems) => panic!("{}", problems.render(false)),
    }
}

/// The drive train: torque in, angle out, a signal of standstill.
pub fn rig() -> Model {
    model(
        "u = { unit = \"N*m\" }",
        "phi_m = { expr = \"x\", unit = \"rad\", error = { absolute = 0.1 } }",
        "still = { from = \"column\", type = \"bool\" }",
    )
}

/// The folder of measured records, where there is one.
pub fn shared() -> Option<PathBuf> {
    let beside = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
    let path =
        std::env::var_os("VERIBOUND_SHARED").map_or_else(|| PathBuf::from(beside), PathBuf::from);
    path.is_dir().then_some(path)
}
