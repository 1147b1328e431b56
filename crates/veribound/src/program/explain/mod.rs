//! `veribound explain`: what a code means, why it matters, how to repair it.
//!
//! The page `codes.md` is all there is to say: `#` begins a group, `##` a code with its title. Examples
//! that are whole models or records are marked `wrong` (they raise the code of their section) or
//! `right` behind the language of their fence; tests hold them to it.

use super::arguments::Explain;
use super::ending::Ending;
use super::message::flag_problem;
use super::{Outcome, message};
use serde::Serialize;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};

const PAGE: &str = include_str!("codes.md");

/// Explains the codes, or lists all there are.
pub fn run(arguments: &Explain) -> Outcome {
    let sections = sections(PAGE);
    if arguments.codes.is_empty() {
        if arguments.json {
            let all: Vec<&Section<'_>> = sections.iter().collect();
            message::say_json(&Explained::of(&all))?;
        } else {
            message::say(&list(&sections));
        }
        return Ok(Ending::Done);
    }
    let mut found = Vec::new();
    let mut problems = Vec::new();
    for typed in &arguments.codes {
        match number(typed).and_then(|wanted| find(&sections, wanted)) {
            Some(section) => found.push(section),
            None => problems.push(unknown(&sections, typed)),
        }
    }
    if !problems.is_empty() {
        return Err(Diagnostics(problems));
    }
    if arguments.json {
        message::say_json(&Explained::of(&found))?;
    } else {
        let texts: Vec<String> = found.iter().map(|section| section.in_full()).collect();
        message::say(&texts.join("\n\n"));
    }
    Ok(Ending::Done)
}

/// What is told as JSON.
#[derive(Serialize)]
struct Explained {
    codes: Vec<Code>,
}

#[derive(Serialize)]
struct Code {
    code: String,
    title: String,
    group: String,
    text: String,
}

impl Explained {
    fn of(sections: &[&Section<'_>]) -> Explained {
        let codes = sections.iter().map(|section| Code {
            code: section.code.to_owned(),
            title: section.title.to_owned(),
            group: section.group.to_owned(),
            text: section.in_full(),
        });
        Explained {
            codes: codes.collect(),
        }
    }
}

/// What the page says about one code.
#[derive(Debug)]
struct Section<'p> {
    group: &'p str,
    code: &'p str,
    title: &'p str,
    /// The lines below the heading, with their fences.
    lines: Vec<&'p str>,
}

impl Section<'_> {
    /// Title and text for a terminal: examples are indented instead of fenced.
    fn in_full(&self) -> String {
        let mut text = format!("{} {}\n", self.code, self.title);
        let mut in_example = false;
        for line in &self.lines {
            if is_fence(line) {
                in_example = !in_example;
                continue;
            }
            if in_example && !line.is_empty() {
                text.push_str("    ");
            }
            text.push_str(line);
            text.push('\n');
        }
        text.truncate(text.trim_end().len());
        text
    }
}

/// The sections of the page. A `#` inside an example is a comment, no heading.
fn sections(page: &str) -> Vec<Section<'_>> {
    let mut found: Vec<Section> = Vec::new();
    let mut group = "";
    let mut in_example = false;
    for line in page.lines() {
        in_example ^= is_fence(line);
        let heading = (!in_example).then(|| line.split_once(' ')).flatten();
        match heading {
            Some(("#", title)) => group = title,
            Some(("##", heading)) => {
                let (code, title) = heading.split_once(' ').unwrap_or((heading, ""));
                found.push(Section {
                    group,
                    code,
                    title,
                    lines: Vec::new(),
                });
            }
            _ => {
                // What stands between a group and its first code is for readers of the page.
                let section = found.last_mut().filter(|section| section.group == group);
                if let Some(section) = section {
                    section.lines.push(line);
                }
            }
        }
    }
    found
}

fn is_fence(line: &str) -> bool {
    line.starts_with("```")
}

/// All codes with their titles, by group.
fn list(sections: &[Section]) -> String {
    let mut text = String::new();
    let mut group = "";
    for section in sections {
        if section.group != group {
            group = section.group;
            let gap = if text.is_empty() { "" } else { "\n" };
            text.push_str(&format!("{gap}{group}\n"));
        }
        text.push_str(&format!("  {} {}\n", section.code, section.title));
    }
    text
}

/// The number in `E0213`, `e0213`, `0213` or `213`.
fn number(typed: &str) -> Option<u32> {
    let digits = typed.strip_prefix(['E', 'e']).unwrap_or(typed);
    let plain = digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|_| plain)
}

fn find<'s, 'p>(sections: &'s [Section<'p>], wanted: u32) -> Option<&'s Section<'p>> {
    sections
        .iter()
        .find(|section| number(section.code) == Some(wanted))
}

fn unknown(sections: &[Section], typed: &str) -> Diagnostic {
    let nearest = number(typed).and_then(|wanted| {
        let known = sections.iter().filter_map(|section| number(section.code));
        known.min_by_key(|known| known.abs_diff(wanted))
    });
    let help = match nearest {
        Some(code) => {
            format!("the nearest one is `E{code:04}`; `veribound explain` lists all")
        }
        None => {
            "write a code as in `veribound explain E0213`; `veribound explain` lists all".to_owned()
        }
    };
    flag_problem(
        "E0613",
        format!("there is no code `{typed}`"),
        ("explain", typed, 0..typed.len()),
        "unknown",
        help,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::{Path, PathBuf};
    use veribound_data::{Record, RecordOptions};
    use veribound_model::Model;

    /// The model that the examples of records belong to.
    const MODEL: &str = "format = 1\nstates = [\"x [m]\"]\ninputs = [\"u [m/s]\"]\ninit.x = 0\n\
        der.x = \"u\"\noutputs.y = \"x +- 0.1\"\n";

    /// A fenced example, and what stands behind its opening fence.
    struct Example<'p> {
        code: &'p str,
        kind: &'p str,
        text: String,
    }

    fn examples<'p>(sections: &[Section<'p>]) -> Vec<Example<'p>> {
        let mut found: Vec<Example> = Vec::new();
        for section in sections {
            let mut in_example = false;
            for line in &section.lines {
                if is_fence(line) {
                    in_example = !in_example;
                    if in_example {
                        found.push(Example {
                            code: section.code,
                            kind: line.trim_start_matches('`'),
                            text: String::new(),
                        });
                    }
                } else if in_example {
                    found.last_mut().unwrap().text += &format!("{line}\n");
                }
            }
            assert!(!in_example, "{}: a fence is never closed", section.code);
        }
        found
    }

    /// What is wrong with an example; nothing when it can be read.
    fn problems(example: &Example, model: &Model, place: &Path) -> Diagnostics {
        let problems = if example.kind.starts_with("toml") {
            Model::from_text("example.toml", example.text.as_str()).err()
        } else {
            let path = place.join("example.csv");
            fs::write(&path, &example.text).unwrap();
            Record::open(&path, model, RecordOptions::default()).err()
        };
        problems.unwrap_or(Diagnostics(Vec::new()))
    }

    /// The codes of that.
    fn raised(example: &Example, model: &Model, place: &Path) -> BTreeSet<&'static str> {
        let problems = problems(example, model, place);
        problems.0.iter().map(|problem| problem.code).collect()
    }

    /// The messages of all wrong records of the page, word for word. After a wanted change `BLESS=1` writes
    /// them anew.
    #[test]
    fn wrong_records_are_told_word_for_word() {
        let model = Model::from_text("m.toml", MODEL).unwrap();
        let place = tempfile::tempdir().unwrap();
        let sections = sections(PAGE);
        let examples = examples(&sections);
        let wrong = examples
            .iter()
            .filter(|example| example.kind == "csv wrong");
        let record = place.path().join("example.csv");
        let plain = |problems: Diagnostics| {
            let text = problems.render(false);
            text.replace(&record.display().to_string(), "example.csv")
        };
        let shown = wrong.map(|example| plain(problems(example, &model, place.path())));
        let mut shown: Vec<String> = shown.collect();
        // What cannot stand on a page.
        let many: String = (0..60).map(|i| format!("{i},fast,0\n")).collect();
        let long = format!("t,u,y\n0,0,{}\n", "0".repeat(2_000_000));
        for (bytes, from) in [
            (format!("t,u,y\n{many}").into_bytes(), None),
            (b"PK\x03\x04\x00\x00".to_vec(), None),
            (b"\xff\xfet\x00,\x00".to_vec(), None),
            (b"t,u,y\n0,\xe4,0\n".to_vec(), None),
            (b"t,u,y\n0,0,0\n1,0,0\n".to_vec(), Some("7")),
            (long.into_bytes(), None),
        ] {
            fs::write(&record, bytes).unwrap();
            let from = from.map(|from| veribound_interval::Decimal::parse(from).unwrap());
            let options = RecordOptions {
                from,
                ..RecordOptions::default()
            };
            let problems = Record::open(&record, &model, options).unwrap_err();
            shown.push(plain(problems));
        }
        let seen = shown.join("\n");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/records.txt");
        if std::env::var_os("BLESS").is_some() {
            fs::write(&path, &seen).unwrap();
        }
        let wanted = fs::read_to_string(&path).unwrap_or_default();
        assert_eq!(seen, wanted);
    }

    #[test]
    fn every_code_has_an_exact_text() {
        let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let (mut codes, mut files) = (Vec::new(), Vec::new());
        for entry in fs::read_dir(crates).unwrap() {
            let folder = entry.unwrap().path();
            found_in(&folder.join("src"), "rs", &mut codes);
            for ending in ["txt", "expected"] {
                found_in(&folder.join("testdata"), ending, &mut files);
            }
            found_in(&folder.join("tests"), "rs", &mut files);
        }
        let read = |path: &PathBuf| fs::read_to_string(path).unwrap();
        let mut texts: String = files.iter().map(read).collect();
        let sources: Vec<String> = codes.iter().map(read).collect();
        let tests = sources
            .iter()
            .filter_map(|text| text.split_once("#[cfg(test)]"));
        texts.extend(tests.map(|(_, tests)| tests));
        let all: BTreeSet<&str> = sources.iter().flat_map(|text| codes_in(text)).collect();
        let without = all
            .iter()
            .filter(|code| !texts.contains(&format!("error[{code}]: ")));
        assert_eq!(without.copied().collect::<Vec<_>>(), [""; 0]);
    }

    #[test]
    fn wrong_examples_raise_their_code_and_repaired_ones_can_be_read() {
        let model = Model::from_text("m.toml", MODEL).unwrap();
        let place = tempfile::tempdir().unwrap();
        let sections = sections(PAGE);
        let (mut wrong, mut right) = (0, 0);
        for example in examples(&sections) {
            let raised = raised(&example, &model, place.path());
            let Example { code, kind, text } = &example;
            match *kind {
                "toml wrong" | "csv wrong" => {
                    assert_eq!(raised, BTreeSet::from([*code]), "{code}:\n{text}");
                    wrong += 1;
                }
                "toml right" | "csv right" => {
                    assert_eq!(raised, BTreeSet::new(), "{code}:\n{text}");
                    right += 1;
                }
                "toml" | "csv" | "sh" => {}
                _ => panic!("{code}: a fence says `{kind}`"),
            }
        }
        assert!(wrong >= 40 && right >= wrong, "{wrong} {right}");
    }

    /// The files with an ending, in a folder that need not exist.
    fn found_in(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).into_iter().flatten() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                found_in(&path, ending, found);
            } else if path.extension().is_some_and(|own| own == ending) {
                found.push(path);
            }
        }
    }

    /// The codes that stand in quotes in a source, outside of its tests.
    fn codes_in(source: &str) -> impl Iterator<Item = &str> {
        let code = source.split("#[cfg(test)]").next().unwrap_or_default();
        let is_code = |text: &&str| {
            let digits = text.strip_prefix('E').unwrap_or_default();
            digits.len() == 4 && digits.bytes().all(|byte| byte.is_ascii_digit())
        };
        code.split('"').filter(is_code)
    }

    #[test]
    fn the_page_tells_of_every_code_and_of_no_other() {
        let crates = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let mut files = Vec::new();
        for entry in fs::read_dir(crates).unwrap() {
            found_in(&entry.unwrap().path().join("src"), "rs", &mut files);
        }
        let texts: Vec<String> = files
            .iter()
            .map(|path| fs::read_to_string(path).unwrap())
            .collect();
        let raised: BTreeSet<&str> = texts.iter().flat_map(|text| codes_in(text)).collect();
        assert!(raised.len() > 70, "{raised:?}");
        let sections = sections(PAGE);
        let told: BTreeSet<&str> = sections.iter().map(|section| section.code).collect();
        let missing: Vec<_> = raised.difference(&told).collect();
        assert!(missing.is_empty(), "codes.md has no section {missing:?}");
        let gone: Vec<_> = told.difference(&raised).collect();
        assert!(gone.is_empty(), "nothing raises {gone:?} of codes.md");
        let order: Vec<&str> = sections.iter().map(|section| section.code).collect();
        assert!(order.is_sorted_by(|a, b| a < b), "{order:?}");
    }

    #[test]
    fn every_section_can_be_read_on_a_terminal() {
        for section in sections(PAGE) {
            let text = section.in_full();
            assert!(!section.group.is_empty() && !section.title.is_empty());
            assert!(text.lines().count() >= 3, "{text}");
            assert!(!text.contains("```"), "{text}");
            let longest = text.lines().map(|line| line.chars().count()).max();
            assert!(longest <= Some(120), "{text}");
        }
    }

    #[test]
    fn a_comment_in_an_example_is_no_heading() {
        let page = "# G\n\nfor readers\n\n## E0001 one\n\nText:\n\n```csv wrong\n# t\nt\n\n0\n```\n\n\
            # H\n\n## E0002 two\n\nMore.\n";
        let sections = sections(page);
        let groups: Vec<&str> = sections.iter().map(|section| section.group).collect();
        assert_eq!(groups, ["G", "H"]);
        let text = sections[0].in_full();
        assert_eq!(text, "E0001 one\n\nText:\n\n    # t\n    t\n\n    0");
        assert_eq!(list(&sections), "G\n  E0001 one\n\nH\n  E0002 two\n");
    }

    #[test]
    fn codes_can_be_typed_in_many_ways() {
        for typed in ["E0213", "e0213", "0213", "213", "E213"] {
            assert_eq!(number(typed), Some(213), "{typed}");
        }
        for typed in [
            "",
            "E",
            "EE0213",
            "+213",
            "-213",
            "gap",
            "99999999999",
            "E0213 ",
        ] {
            assert_eq!(number(typed), None, "{typed}");
        }
    }
}
