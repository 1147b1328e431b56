//! Where expanded text comes from.

use crate::diagnostic::{Diagnostic, SourceText};
use std::ops::Range;
use std::sync::Arc;

/// Where one byte of expanded text comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Byte {
    /// Range in the file.
    pub start: u32,
    pub end: u32,
    /// Position in [`Origin::instances`].
    pub instance: u32,
}

/// Where every byte of the text that is read comes from: first the file itself, then what its
/// templates stand for.
#[derive(Debug, Clone, Default)]
pub(crate) struct Origin {
    /// Length of the file.
    pub(super) length: usize,
    pub(super) bytes: Vec<Byte>,
    /// `i = 7`; the first is empty.
    pub(super) instances: Vec<String>,
}

impl Origin {
    fn byte(&self, at: usize) -> Option<&Byte> {
        self.bytes.get(at.checked_sub(self.length)?)
    }

    /// What puts places into the order of the file; instances of one template stay in theirs.
    pub fn order(&self, at: usize) -> (usize, usize) {
        let own = self.byte(at).map_or(at, |byte| byte.start as usize);
        (own, at)
    }

    /// The place in the file, and what the instance is told by.
    fn place(&self, range: &Range<usize>) -> Option<(Range<usize>, &str)> {
        let first = self.byte(range.start)?;
        let last = self
            .byte(range.end.max(range.start + 1) - 1)
            .unwrap_or(first);
        let (start, end) = (first.start as usize, last.end as usize);
        let instance = self.instances.get(first.instance as usize);
        let start = if range.is_empty() { end } else { start };
        Some((start..end.max(start), instance.map_or("", String::as_str)))
    }

    /// Puts messages about the text that was read into the file, and says of which instance they
    /// speak; what is wrong with one place of a template is said once.
    pub fn restore(&self, problems: Vec<Diagnostic>, file: &Arc<SourceText>) -> Vec<Diagnostic> {
        struct Told {
            problem: Diagnostic,
            instance: String,
            more: usize,
        }
        let mut found: Vec<Told> = Vec::new();
        for mut problem in problems {
            let mut instance = String::new();
            if let Some((source, range)) = &mut problem.place {
                if let Some((own, of)) = self.place(range) {
                    *range = own;
                    instance = of.to_string();
                }
                *source = Arc::clone(file);
            }
            let same = |told: &&mut Told| {
                let place = |problem: &Diagnostic| problem.place.as_ref().map(|(_, at)| at.clone());
                !instance.is_empty()
                    && !told.instance.is_empty()
                    && told.problem.code == problem.code
                    && place(&told.problem) == place(&problem)
            };
            match found.iter_mut().find(same) {
                Some(told) => told.more += usize::from(told.instance != instance),
                None => found.push(Told {
                    problem,
                    instance,
                    more: 0,
                }),
            }
        }
        let said = |told: Told| {
            let mut problem = told.problem;
            if !told.instance.is_empty() {
                let more = match told.more {
                    0 => String::new(),
                    more => format!(", and {more} more"),
                };
                problem.message = format!("{} (with {}{more})", problem.message, told.instance);
            }
            problem
        };
        found.into_iter().map(said).collect()
    }
}
