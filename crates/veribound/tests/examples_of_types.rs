//! Every public type has an example that is tested: in its own documentation, or in that of a type whose example uses it
//! and to which it leads, as ``Example: [`Model`].``

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

use std::fs;
use std::path::{Path, PathBuf};

/// A public type: where it stands, its name, and its documentation line by line.
#[derive(Debug)]
struct Type {
    file: PathBuf,
    name: String,
    lines: Vec<String>,
}

impl Type {
    /// The code of its examples that is compiled and run.
    fn example(&self) -> String {
        let (mut code, mut is_code, mut is_run) = (String::new(), false, false);
        for line in &self.lines {
            if let Some(kind) = line.strip_prefix("```") {
                (is_code, is_run) = (!is_code, kind.is_empty());
            } else if is_code && is_run {
                code.push_str(line);
                code.push('\n');
            }
        }
        code
    }

    /// The type whose example it leads to.
    fn host(&self) -> Option<&str> {
        let mut lines = self.lines.iter();
        let (name, _) = lines.find_map(|line| line.strip_prefix("Example: [`")?.split_once('`'))?;
        Some(name)
    }
}

/// Whether a word stands in a text, with nothing of a name before or behind it.
fn has_word(text: &str, word: &str) -> bool {
    let mut words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.any(|found| found == word)
}

/// The public types that a source file declares.
fn types(file: &Path) -> Vec<Type> {
    let text = fs::read_to_string(file).unwrap();
    let (mut found, mut doc) = (Vec::new(), Vec::new());
    let mut is_attribute = false;
    for line in text.lines() {
        if let Some(said) = line.strip_prefix("///") {
            doc.push(said.strip_prefix(' ').unwrap_or(said).to_owned());
            continue;
        }
        // Attributes stand between a documentation and what it is about.
        if is_attribute || line.starts_with("#[") {
            is_attribute = !line.ends_with(']');
            continue;
        }
        let declared = line
            .strip_prefix("pub ")
            .and_then(|rest| rest.split_once(' '));
        if let Some(("struct" | "enum" | "trait" | "type", rest)) = declared {
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
            found.push(Type {
                file: file.to_owned(),
                name: rest[..end.unwrap_or(rest.len())].to_owned(),
                lines: std::mem::take(&mut doc),
            });
        }
        doc.clear();
    }
    found
}

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_public_type_has_an_example() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let (mut lacking, mut count) = (Vec::new(), 0);
    for name in [
        "interval",
        "model",
        "flow",
        "estimate",
        "data",
        "report",
        "veribound",
    ] {
        let mut files = Vec::new();
        sources(&crates.join(name).join("src"), &mut files);
        // The parts of the program are hidden: they are for the program and the Python package.
        files.retain(|file| !file.iter().any(|part| part == "program"));
        let all: Vec<Type> = files.iter().flat_map(|file| types(file)).collect();
        count += all.len();
        for one in &all {
            let led = |host: &str| all.iter().find(|other| other.name == host);
            let led = one.host().and_then(led);
            let is_used = led.is_some_and(|host| has_word(&host.example(), &one.name));
            if one.example().is_empty() && !is_used {
                lacking.push(format!("{}: {}", one.file.display(), one.name));
            }
        }
    }
    assert!(count > 150, "only {count} types found");
    assert!(lacking.is_empty(), "no example of\n{}", lacking.join("\n"));
}
