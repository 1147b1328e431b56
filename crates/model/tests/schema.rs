//! `schema/model.schema.json`, for editors, says what the reader does.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use boon::{Compiler, Schemas};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use veribound_model::Model;

fn schema() -> Value {
    serde_json::from_str(include_str!("../../../schema/model.schema.json")).unwrap()
}

/// The models in a folder and the folders in it.
fn models(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(models(&path));
        } else if path.extension().is_some_and(|end| end == "toml") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// What the schema says about a model file; `None` where it is not TOML.
struct Judge {
    schemas: Schemas,
    index: boon::SchemaIndex,
}

impl Judge {
    fn new() -> Judge {
        let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
        compiler.add_resource("model.json", schema()).unwrap();
        let index = compiler.compile("model.json", &mut schemas).unwrap();
        Judge { schemas, index }
    }

    fn refuses(&self, text: &str) -> Option<String> {
        let value: toml::Value = toml::from_str(text).ok()?;
        let value = serde_json::to_value(value).unwrap();
        let judged = self.schemas.validate(&value, self.index);
        judged.err().map(|error| error.to_string())
    }
}

#[test]
fn it_takes_every_model_that_can_be_read() {
    let judge = Judge::new();
    let mut list = models(Path::new("testdata/good"));
    list.extend(models(Path::new("../../examples")));
    assert!(list.len() >= 12);
    for path in list {
        let text = fs::read_to_string(&path).unwrap();
        if let Some(error) = judge.refuses(&text) {
            panic!("{}: {error}", path.display());
        }
    }
}

/// Wrong keys and shapes are found by an editor; what equations mean is not.
#[test]
fn it_refuses_what_has_a_wrong_shape() {
    let judge = Judge::new();
    let shapes = ["E0105", "E0106", "E0107", "E0109", "E0114"];
    let (mut shaped, mut refused) = (0, 0);
    for path in models(Path::new("testdata/bad")) {
        let Ok(text) = fs::read_to_string(&path) else {
            continue;
        };
        let problems = Model::from_file(&path).unwrap_err();
        let is_shape = |code: &str| shapes[..3].contains(&code);
        if toml::from_str::<toml::Value>(&text).is_ok()
            && problems.0.iter().any(|problem| is_shape(problem.code))
        {
            shaped += 1;
            refused += usize::from(judge.refuses(&text).is_some());
        }
    }
    assert!(shaped >= 5, "{shaped}");
    assert_eq!(refused, shaped);
}

/// The keys that the reader names when it meets one it does not know.
fn keys_of(text: &str) -> Vec<String> {
    let problems = Model::from_text("model.toml", text).unwrap_err();
    let problem = problems.0.iter().find(|problem| problem.code == "E0106");
    let help = &problem.unwrap_or_else(|| panic!("{problems:?}")).help;
    let list = help.strip_prefix("possible here: ");
    let list = list.unwrap_or_else(|| panic!("{help}"));
    let mut keys: Vec<String> = list.split(", ").map(str::to_string).collect();
    keys.sort();
    keys
}

#[test]
fn it_has_the_keys_of_the_reader() {
    let schema = schema();
    let names = |place: &Value| -> Vec<String> {
        let mut names: Vec<String> = place["properties"]
            .as_object()
            .unwrap()
            .keys()
            .cloned()
            .collect();
        names.sort();
        names
    };
    let odd = "qqqqqqqqqqqq = 1";
    assert_eq!(keys_of(odd), names(&schema));
    for (definition, text) in [
        ("state", format!("states.x = {{ {odd} }}")),
        ("input", format!("inputs.u = {{ {odd} }}")),
        ("disturbance", format!("disturbances.d = {{ {odd} }}")),
        ("parameter", format!("params.p = {{ {odd} }}")),
        (
            "mode",
            format!("states.x = {{ init = 0 }}\nmodes.m = {{ {odd} }}"),
        ),
        ("output", format!("outputs.y = {{ {odd} }}")),
        (
            "errorBound",
            format!("outputs.y = {{ expr = \"1\", error = {{ {odd} }} }}"),
        ),
        ("signal", format!("signals.s = {{ {odd} }}")),
        ("event", format!("events.e = {{ {odd} }}")),
    ] {
        let keys = keys_of(&format!("format = 1\n{text}\n"));
        assert_eq!(keys, names(&schema["$defs"][definition]), "{definition}");
    }
}
