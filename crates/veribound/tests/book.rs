//! The book (`docs/`) says what the program does: its console frames are run, its pages all exist and are all reached.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test may panic"
)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// All pages, by their path inside of the book.
fn pages() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for folder in ["", "methods"] {
        for entry in fs::read_dir(docs().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            if name.ends_with(".md") && name != "SUMMARY.md" {
                found.insert(Path::new(folder).join(name).display().to_string());
            }
        }
    }
    found
}

#[test]
fn the_summary_has_every_page_once() {
    let summary = fs::read_to_string(docs().join("SUMMARY.md")).unwrap();
    let links = summary.lines().filter_map(|line| {
        let (_, rest) = line.split_once("](")?;
        Some(rest.trim_end().trim_end_matches(')').to_owned())
    });
    let links: Vec<String> = links.collect();
    let once: BTreeSet<String> = links.iter().cloned().collect();
    assert_eq!(links.len(), once.len(), "a page is there twice");
    assert_eq!(once, pages());
}

#[test]
fn what_is_included_exists() {
    let mut seen = 0;
    for page in pages() {
        let path = docs().join(&page);
        let text = fs::read_to_string(&path).unwrap();
        for part in text.split("{{#include ").skip(1) {
            let name = part.split("}}").next().unwrap().trim();
            let file = path.parent().unwrap().join(name);
            assert!(file.is_file(), "{page} includes {name}");
            seen += 1;
        }
    }
    assert!(seen >= 3);
}

/// The frames of a page with the comment that stands above each: `(language, comment, text)`.
fn frames(text: &str) -> Vec<(String, String, String)> {
    let mut frames = Vec::new();
    let mut above = String::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        match line.strip_prefix("```") {
            Some(language) => {
                let inside: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
                let comment = std::mem::take(&mut above);
                frames.push((language.to_owned(), comment, inside.join("\n") + "\n"));
            }
            None if line.starts_with("<!-- ") => above = line.to_owned(),
            None if !line.is_empty() => above.clear(),
            None => {}
        }
    }
    frames
}

/// Times differ from run to run.
fn without_times(line: &str) -> String {
    let mut words: Vec<String> = line.split(' ').map(str::to_owned).collect();
    for at in 1..words.len() {
        let is_unit = ["s", "ms"].contains(&words[at].as_str());
        let before = at.checked_sub(2).map(|at| words[at].as_str());
        if is_unit && matches!(before, Some("in" | "sample")) {
            words[at - 1] = "TIME".to_owned();
        }
    }
    words.join(" ").trim_end().to_owned()
}

/// Whether `told` has the lines of `wanted` in their order; `...` stands for any lines.
fn tells(wanted: &str, told: &str) -> Result<(), String> {
    let told: Vec<String> = told.lines().map(without_times).collect();
    let mut at = 0;
    let mut may_skip = false;
    for line in wanted.lines() {
        if line == "..." {
            may_skip = true;
            continue;
        }
        let line = without_times(line);
        let found = match may_skip {
            true => told.iter().skip(at).position(|told| *told == line),
            false => (told.get(at) == Some(&line)).then_some(0),
        };
        at += found.ok_or(format!("not told: {line}"))? + 1;
        may_skip = false;
    }
    match may_skip || at == told.len() {
        true => Ok(()),
        false => Err(format!("more is told: {}", told[at])),
    }
}

/// A file that a page shows, or makes of another one: `<!-- file: NAME -->`,
/// `<!-- file: NAME from PATH with "OLD" as "NEW" -->`.
fn make_file(place: &Path, comment: &str, text: &str) {
    let Some(said) = comment.strip_prefix("<!-- file: ") else {
        return;
    };
    let said = said.trim_end_matches("-->").trim();
    let Some((name, rest)) = said.split_once(" from ") else {
        fs::write(place.join(said), text).unwrap();
        return;
    };
    let parts: Vec<&str> = rest.split('"').collect();
    let [path, old, _, new, _] = parts[..] else {
        panic!("not understood: {comment}")
    };
    let path = place.join(path.trim().trim_end_matches(" with"));
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(old), "{comment}");
    fs::write(place.join(name), text.replace(old, new)).unwrap();
}

/// Runs the commands of a console frame in `place`, and compares what they tell.
fn run(page: &str, place: &Path, frame: &str) {
    for part in frame.split("$ veribound ").skip(1) {
        let (command, wanted) = part.split_once('\n').unwrap();
        let mut words: Vec<&str> = command.split_whitespace().collect();
        // Figures take time, and no frame tells of them.
        if matches!(words[0], "observe" | "identify" | "enclose") {
            words.extend(["--figures", "none"]);
        }
        let done = Command::new(env!("CARGO_BIN_EXE_veribound"))
            .args(&words)
            .current_dir(place)
            .output()
            .unwrap();
        let told = [done.stderr, done.stdout].concat();
        let told = String::from_utf8(told).unwrap();
        if let Err(why) = tells(wanted, &told) {
            panic!("{page}: veribound {command}\n{why}\n--- it tells:\n{told}");
        }
    }
}

#[cfg(unix)]
#[test]
fn console_frames_are_what_the_program_tells() {
    let mut seen = 0;
    for page in pages() {
        let text = fs::read_to_string(docs().join(&page)).unwrap();
        let place = tempfile::tempdir().unwrap();
        let examples = docs().join("../examples").canonicalize().unwrap();
        std::os::unix::fs::symlink(examples, place.path().join("examples")).unwrap();
        for (language, above, inside) in frames(&text) {
            make_file(place.path(), &above, &inside);
            if language == "console" {
                run(&page, place.path(), &inside);
                seen += 1;
            }
        }
    }
    assert!(seen >= 9, "only {seen} frames");
}

#[test]
fn a_wrong_line_is_found() {
    let told = "  proved to 5 s   101 times in 0.69 s\n  a\n  b\n  c\n";
    assert!(
        tells(
            "  proved to 5 s   101 times in 1.2 s\n  a\n  b\n  c\n",
            told
        )
        .is_ok()
    );
    assert!(tells("...\n  b\n...\n", told).is_ok());
    assert!(tells("...\n  b\n", told).is_err());
    assert!(tells("  a\n...\n", told).is_err());
    assert!(tells("...\n  c\n  b\n...\n", told).is_err());
    assert!(tells("  proved to 4 s   101 times in 1.2 s\n...\n", told).is_err());
}
