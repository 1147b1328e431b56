//! Collects what is wrong with a record: the first problems in full, the rest counted.

use std::collections::BTreeMap;
use veribound_model::diagnostic::{Diagnostic, Diagnostics};

/// So many problems of one file are shown.
const SHOWN: usize = 20;

/// So many problems of one kind in one column are shown: a whole column of decimal commas must not
/// hide a second mistake.
const SHOWN_OF_KIND: usize = 3;

/// The problems found so far in one file.
#[derive(Debug, Default)]
pub(crate) struct Problems {
    shown: Vec<Diagnostic>,
    kinds: BTreeMap<(&'static str, usize), usize>,
    hidden: usize,
}

impl Problems {
    /// Adds a problem of `column` (any number will do where there is none).
    pub(crate) fn add(
        &mut self,
        code: &'static str,
        column: usize,
        problem: impl FnOnce() -> Diagnostic,
    ) {
        let seen = self.kinds.entry((code, column)).or_default();
        *seen += 1;
        if *seen > SHOWN_OF_KIND || self.shown.len() >= SHOWN {
            self.hidden += 1;
        } else {
            self.shown.push(problem());
        }
    }

    /// Adds the problem that ended the reading.
    pub(crate) fn end(&mut self, problem: Diagnostic) {
        self.shown.push(problem);
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.shown.is_empty()
    }

    /// All problems as one error; `name` is the file.
    pub(crate) fn into_error(mut self, name: &str) -> Diagnostics {
        if self.hidden > 0 {
            let problems = if self.hidden == 1 {
                "problem"
            } else {
                "problems"
            };
            self.shown.push(Diagnostic::new(
                "E0400",
                format!("and {} more {problems} in `{name}`", self.hidden),
            ));
        }
        Diagnostics(self.shown)
    }
}
