//! Every message about a wrong model file, word for word.
//!
//! Each `testdata/bad/NAME.toml` has a `NAME.txt` with what the user sees. After a wanted change,
//! `BLESS=1 cargo test -p veribound-model` writes the texts anew; read them before committing.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test fails by panicking"
)]

use std::fs;
use std::path::{Path, PathBuf};
use veribound_model::Model;

fn files(folder: &str) -> Vec<PathBuf> {
    let mut found: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            path.extension()
                .is_some_and(|extension| extension == "toml")
        })
        .collect();
    found.sort();
    found
}

fn compare(path: &Path, seen: &str) -> Result<(), String> {
    if std::env::var_os("BLESS").is_some() {
        fs::write(path, seen).unwrap();
        return Ok(());
    }
    let wanted = fs::read_to_string(path).unwrap_or_default();
    if wanted == seen {
        Ok(())
    } else {
        Err(format!("{}:\n{seen}", path.display()))
    }
}

#[test]
fn every_message_is_as_expected() {
    let files = files("testdata/bad");
    assert!(files.len() >= 25, "test data are missing");
    let mut failures = Vec::new();
    for path in files {
        let problems = match Model::from_file(&path) {
            Ok(_) => panic!("{} was read without a problem", path.display()),
            Err(problems) => problems,
        };
        let text = problems.render(false);
        assert!(!text.contains('\u{1b}'), "terminal codes without colour");
        for problem in &problems.0 {
            assert!(
                !problem.help.is_empty(),
                "{}: no help for {}",
                path.display(),
                problem.message
            );
            assert!(problems.render(true).contains(problem.code));
        }
        failures.extend(compare(&path.with_extension("txt"), &text).err());
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn unreadable_paths() {
    let seen = |path: &str| Model::from_file(path).unwrap_err().render(false);
    assert_eq!(
        seen("testdata/nowhere.toml"),
        "error[E0101]: cannot read `testdata/nowhere.toml`: there is no such file\n |\n = help: check the path of the model file\n"
    );
    assert!(seen("testdata").contains("it is a folder"));
    let record = Model::from_text("run.csv", "t,F,x_m\n0,0.5,0\n").unwrap_err();
    assert_eq!(
        record.render(false),
        "error[E0103]: the file is not valid TOML: key with no value, expected `=`\n --> run.csv:1:2\n  |\n\
         1 | t,F,x_m\n  |  ^ here\n  |\n  = help: this looks like a record; give the model first, then \
         the record\n"
    );
}

#[test]
fn good_models_are_described() {
    let mut failures = Vec::new();
    for path in files("testdata/good") {
        match Model::from_file(&path) {
            Ok(model) => {
                failures.extend(compare(&path.with_extension("txt"), &model.describe()).err());
            }
            Err(problems) => failures.push(problems.render(false)),
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}
