//! Typed access to the TOML tree: everything that is not as it should be becomes a message with its
//! place, and reading goes on.

use crate::diagnostic::{Diagnostic, SourceText, nearest};
use crate::file::template::Origin;
use crate::file::text::Text;
use crate::syntax::ast::Ast;
use crate::syntax::{Problem, number, parse};
use std::ops::Range;
use std::sync::Arc;
use toml::de::{DeTable, DeValue};
use veribound_interval::Decimal;

/// The problems found so far and the text they are about.
pub(crate) struct Reader {
    /// The file, and behind it what its templates stand for.
    pub source: Arc<SourceText>,
    /// Where that comes from.
    pub origin: Origin,
    pub problems: Vec<Diagnostic>,
}

/// A value of the file with its place.
#[derive(Clone, Copy)]
pub(crate) struct Value<'t> {
    pub value: &'t DeValue<'t>,
    start: usize,
    end: usize,
}

/// A key with its value.
#[derive(Clone)]
pub(crate) struct Entry<'t> {
    pub key: &'t str,
    pub place: Range<usize>,
    pub value: Value<'t>,
}

/// A table, its entries in the order of the file.
pub(crate) struct Table<'t> {
    /// Where the table is named: what is missing in it is reported there.
    pub place: Range<usize>,
    pub entries: Vec<Entry<'t>>,
}

impl<'t> Table<'t> {
    pub fn new(origin: &Origin, table: &'t DeTable<'t>, place: Range<usize>) -> Self {
        let mut entries: Vec<Entry<'t>> = table
            .iter()
            .map(|(key, value)| Entry {
                key: key.get_ref(),
                place: key.span(),
                value: Value {
                    value: value.get_ref(),
                    start: value.span().start,
                    end: value.span().end,
                },
            })
            .collect();
        entries.sort_by_key(|entry| origin.order(entry.place.start));
        Table { place, entries }
    }

    pub fn find(&self, key: &str) -> Option<&Entry<'t>> {
        self.entries.iter().find(|entry| entry.key == key)
    }

    pub fn value(&self, key: &str) -> Option<Value<'t>> {
        self.find(key).map(|entry| entry.value)
    }
}

impl<'t> Value<'t> {
    pub fn place(&self) -> Range<usize> {
        self.start..self.end
    }

    /// The elements, if it is an array.
    pub fn array(&self) -> Option<Vec<Value<'t>>> {
        let DeValue::Array(array) = self.value else {
            return None;
        };
        Some(
            array
                .iter()
                .map(|item| Value {
                    value: item.get_ref(),
                    start: item.span().start,
                    end: item.span().end,
                })
                .collect(),
        )
    }

    /// What a message calls it.
    pub fn kind(&self) -> &'static str {
        match self.value {
            DeValue::String(_) => "a string",
            DeValue::Integer(_) | DeValue::Float(_) => "a number",
            DeValue::Boolean(_) => "true or false",
            DeValue::Datetime(_) => "a date",
            DeValue::Array(_) => "a list",
            DeValue::Table(_) => "a table",
        }
    }
}

impl Reader {
    pub fn new(source: Arc<SourceText>) -> Self {
        Reader {
            source,
            origin: Origin::default(),
            problems: Vec::new(),
        }
    }

    /// Records a problem at a place of the file.
    pub fn report(
        &mut self,
        code: &'static str,
        message: impl Into<String>,
        place: Range<usize>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.problems.push(
            Diagnostic::new(code, message)
                .at(&self.source, place, label)
                .help(help),
        );
    }

    /// Records a problem inside a string.
    pub fn report_in(&mut self, text: &Text, problem: Problem) {
        self.problems.push(text.diagnose(&self.source, problem));
    }

    /// Reports every key of `table` that is not in `known`.
    pub fn allow(&mut self, table: &Table, known: &[&str], what: &str) {
        for entry in &table.entries {
            if known.contains(&entry.key) {
                continue;
            }
            let help = match nearest(entry.key, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("possible here: {}", known.join(", ")),
            };
            self.report(
                "E0106",
                format!("{what} has no key `{}`", entry.key),
                entry.place.clone(),
                "unknown key",
                help,
            );
        }
    }

    /// Reports that `value` is not what it should be.
    pub fn expected(&mut self, what: &str, value: Value, help: impl Into<String>) {
        self.report(
            "E0107",
            format!("expected {what}, found {}", value.kind()),
            value.place(),
            format!("{} here", value.kind()),
            help,
        );
    }

    pub fn string(&mut self, value: Value, help: &str) -> Option<Text> {
        match value.value {
            DeValue::String(text) => Some(Text::new(&self.source.text, value.place(), text)),
            _ => {
                self.expected("a string", value, help);
                None
            }
        }
    }

    pub fn table<'t>(
        &mut self,
        value: Value<'t>,
        place: Range<usize>,
        help: &str,
    ) -> Option<Table<'t>> {
        match value.value {
            DeValue::Table(table) => Some(Table::new(&self.origin, table, place)),
            _ => {
                self.expected("a table", value, help);
                None
            }
        }
    }

    /// The exact number a value spells; the text in the file counts, not its nearest f64.
    pub fn decimal(&mut self, value: Value, help: &str) -> Option<Decimal> {
        if !matches!(value.value, DeValue::Integer(_) | DeValue::Float(_)) {
            self.expected("a number", value, help);
            return None;
        }
        let source = Arc::clone(&self.source);
        let raw = source.text.get(value.place()).unwrap_or("");
        match number::decimal(raw, value.place()) {
            Ok(decimal) => Some(decimal),
            Err(problem) => {
                self.report(
                    problem.code,
                    problem.message,
                    problem.range,
                    problem.label,
                    problem.help,
                );
                None
            }
        }
    }

    /// A number that is not negative.
    pub fn magnitude(&mut self, value: Value, what: &str, help: &str) -> Option<Decimal> {
        let decimal = self.decimal(value, help)?;
        if decimal < Decimal::zero() {
            self.report(
                "E0215",
                format!("{what} is negative"),
                value.place(),
                "must be zero or more",
                help,
            );
            return None;
        }
        Some(decimal)
    }

    /// Reads the expression or condition in a string.
    pub fn expression(&mut self, text: &Text) -> Option<Ast> {
        match parse::expression(&text.value) {
            Ok(ast) => Some(ast),
            Err(problems) => {
                for problem in problems {
                    self.report_in(text, problem);
                }
                None
            }
        }
    }
}
