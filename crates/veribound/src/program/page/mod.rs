//! The page of a run: what all tasks put on it.

mod observation;

pub use observation::observation;

use super::arguments::{PageFormat, Shown};
use super::numbers::show_time;
use veribound_data::{FileInfo, Printed, RecordInfo, RunInfo};
use veribound_interval::Decimal;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;
use veribound_report::{Block, Entry, Page, Section, Value};

/// What the pages of all tasks are made of.
#[derive(Clone, Copy)]
pub struct Material<'r> {
    /// The model as it was used.
    pub model: &'r Model,
    /// All that repeats the run.
    pub info: &'r RunInfo,
    /// The numbers of the summary.
    pub printed: &'r Printed<'r>,
    /// What was assumed beside the model file, in sentences.
    pub assumed: &'r [String],
}

/// Whether a page was asked for.
pub fn is_wanted(showing: &Shown) -> bool {
    showing.report == PageFormat::Html
}

impl<'r> Material<'r> {
    /// The page that `make` makes of the run, if one was asked for; `json` is the summary.
    pub fn page_if_wanted(
        showing: &Shown,
        (model, info): (&'r Model, &'r RunInfo),
        (json, assumed): (&str, &'r [String]),
        make: impl FnOnce(&Material<'_>) -> Result<Page, Diagnostic>,
    ) -> Result<Option<Page>, Diagnostic> {
        if !is_wanted(showing) {
            return Ok(None);
        }
        let printed = &Printed::of(json)?;
        make(&Material {
            model,
            info,
            printed,
            assumed,
        })
        .map(Some)
    }

    /// A page with what all pages have; verdict and tables are still to come.
    ///
    /// *Errors*: `E0503` when an option has no form in TOML.
    pub fn page(&self, task: &str, limits: Vec<String>) -> Result<Page, Diagnostic> {
        let limits = Section {
            title: "What limits these bounds".to_owned(),
            blocks: vec![Block::List(limits)],
        };
        Ok(Page {
            title: self.model.name.clone(),
            task: task.to_owned(),
            after: vec![limits, self.assumed(), self.repeat()?],
            program: format!("veribound {}", self.info.program.version),
            ..Page::default()
        })
    }

    /// A number of the summary; what is not finite is shown as it is meant by `infinite`.
    fn number(&self, path: &[&str], infinite: &str) -> Value {
        Value {
            text: self.printed.at(path).unwrap_or(infinite).to_owned(),
            at: Printed::pointer(path),
        }
    }

    /// A number of the summary and its unit.
    pub fn value(&self, path: &[&str]) -> Entry {
        Entry::Value(self.number(path, "∞"))
    }

    /// A text of the summary; empty where there is none.
    pub fn word(&self, path: &[&str]) -> String {
        self.printed.text(path).unwrap_or_default()
    }

    /// The bounds at a place of the summary; nothing where there are none.
    pub fn bounds(&self, path: &[&str]) -> Entry {
        let end = |name| [path, &[name]].concat();
        if self.printed.at(&end("empty")).is_some() {
            return Entry::Text("none is left".to_owned());
        }
        if !path.is_empty() && self.printed.at(path).is_none() {
            return Entry::Text(String::new());
        }
        Entry::Bounds(self.number(&end("lo"), "−∞"), self.number(&end("hi"), "∞"))
    }

    /// What a run cost, as the summary has it.
    pub fn cost(&self, facts: &[(&str, &[&str])]) -> Section {
        let facts = facts
            .iter()
            .map(|(name, path)| ((*name).to_owned(), self.value(path)));
        Section {
            title: "What it cost".to_owned(),
            blocks: vec![Block::Facts(facts.collect())],
        }
    }

    /// What the bounds rest on.
    fn assumed(&self) -> Section {
        let mut blocks = vec![Block::Text(
            "The bounds hold if the equations, priors, start intervals and error bounds of the model file hold, \
             and what follows. Rounding errors are inside the bounds."
                .to_owned(),
        )];
        if !self.assumed.is_empty() {
            blocks.push(Block::List(self.assumed.to_vec()));
        }
        let mut facts: Vec<(String, Entry)> = Vec::new();
        let mut file = |what: &str, file: &FileInfo| {
            facts.push((what.to_owned(), Entry::Text(file.path.clone())));
            facts.push(("SHA-256".to_owned(), Entry::Text(file.sha256.clone())));
        };
        file("model", &self.info.model);
        for start in &self.info.start {
            file("started from", start);
        }
        let mut record = |what: &str, record: &RecordInfo| {
            let mut push =
                |name: &str, text: String| facts.push((name.to_owned(), Entry::Text(text)));
            push(what, record.path.clone());
            push("SHA-256", record.sha256.clone());
            let (count, first, last) = (record.samples, near(&record.first), near(&record.last));
            push("samples", format!("{count}, from {first} s to {last} s"));
            let columns = { record.columns.iter() }.map(|[variable, column]| {
                if variable == column {
                    variable.clone()
                } else {
                    format!("{variable} from {column}")
                }
            });
            push("columns", columns.collect::<Vec<_>>().join(", "));
        };
        for one in self.info.record.iter().chain(&self.info.records) {
            record("record", one);
        }
        if let Some(profile) = &self.info.profile {
            record("profile", profile);
        }
        blocks.push(Block::Facts(facts));
        blocks.push(Block::Listing {
            title: Some(format!("The model file, {}", self.model.source.name)),
            text: self.model.source.text.clone(),
        });
        Section {
            title: "What was assumed".to_owned(),
            blocks,
        }
    }

    /// How the run is repeated.
    fn repeat(&self) -> Result<Section, Diagnostic> {
        let command: Vec<String> = self
            .info
            .program
            .command
            .iter()
            .map(|word| quoted(word))
            .collect();
        let platform = &self.info.platform;
        let facts = [
            (
                "program",
                format!("veribound {}", self.info.program.version),
            ),
            (
                "machine",
                format!("{}, {}", platform.system, platform.processor),
            ),
            ("rounding", platform.rounding.clone()),
        ];
        Ok(Section {
            title: "How to repeat it".to_owned(),
            blocks: vec![
                Block::Text("In the folder in which the command was run:".to_owned()),
                Block::Listing {
                    title: None,
                    text: command.join(" "),
                },
                Block::Facts(
                    facts
                        .map(|(name, text)| (name.to_owned(), Entry::Text(text)))
                        .to_vec(),
                ),
                Block::Listing {
                    title: Some("All options: run.toml".to_owned()),
                    text: self.info.to_toml()?,
                },
            ],
        })
    }
}

/// Titles of columns.
pub fn head(titles: &[&str]) -> Vec<String> {
    titles.iter().map(|title| (*title).to_owned()).collect()
}

/// A time of a record as text for people.
fn near(time: &str) -> String {
    Decimal::parse(time).map_or_else(|_| time.to_owned(), |time| show_time(&time))
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,@%+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("--from=1.5"), "--from=1.5");
        assert_eq!(quoted("my run"), "'my run'");
        assert_eq!(quoted("it's"), r"'it'\''s'");
        assert_eq!(quoted(""), "''");
    }
}
