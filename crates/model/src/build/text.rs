//! The text of a model file, from its values.

use super::condition::Condition;
use super::entries::Entry;
use super::number::Number;
use super::symbol::Symbol;
use super::tree::{Flaw, Tree};
use crate::syntax::ast::Kind;
use std::ops::Range;

/// A value behind a key.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Text(String),
    Number(Number),
    /// A number, or a constant expression in quotes.
    Constant(Symbol),
    Equation(Tree),
    List(Vec<Value>),
    Table(Vec<(String, Value)>),
}

impl Value {
    pub fn equation(symbol: impl Into<Symbol>) -> Value {
        Value::Equation(symbol.into().0)
    }

    pub fn condition(condition: impl Into<Condition>) -> Value {
        Value::Equation(condition.into().0)
    }

    pub fn range(lower: impl Into<Symbol>, upper: impl Into<Symbol>) -> Value {
        Value::List(vec![
            Value::Constant(lower.into()),
            Value::Constant(upper.into()),
        ])
    }
}

/// A text as it is written, with the places of what is wrong in it.
#[derive(Debug, Default)]
pub(super) struct Text {
    pub text: String,
    pub flaws: Vec<(Range<usize>, Flaw)>,
}

impl Text {
    /// `[name]` with a line for each entry; nothing for no entries.
    pub fn section(&mut self, name: &str, entries: &[(String, Value)]) {
        if !entries.is_empty() {
            self.text.push_str(&format!("\n[{name}]\n"));
        }
        for (key, value) in entries {
            self.line(key, value);
        }
    }

    /// The same for entries that are tables.
    pub fn entries<'e>(&mut self, name: &str, entries: impl Iterator<Item = &'e Entry>) {
        let table = |entry: &Entry| (entry.name.clone(), Value::Table(entry.fields.clone()));
        self.section(name, &entries.map(table).collect::<Vec<_>>());
    }

    /// `key = value`
    pub fn line(&mut self, key: &str, value: &Value) {
        self.pair(key, value);
        self.text.push('\n');
    }

    fn pair(&mut self, key: &str, value: &Value) {
        self.key(key);
        self.text.push_str(" = ");
        self.value(value);
    }

    /// A key, in quotes if it needs them.
    pub fn key(&mut self, key: &str) {
        let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if !key.is_empty() && key.chars().all(is_bare) {
            self.text.push_str(key);
        } else {
            self.quoted(key);
        }
    }

    fn quoted(&mut self, text: &str) {
        self.text.push('"');
        for c in text.chars() {
            match c {
                '"' | '\\' => self.text.extend(['\\', c]),
                c if c.is_control() => self.text.push_str(&format!("\\u{:04x}", u32::from(c))),
                c => self.text.push(c),
            }
        }
        self.text.push('"');
    }

    fn value(&mut self, value: &Value) {
        let start = self.text.len();
        let flaw = match value {
            Value::Text(text) => {
                self.quoted(text);
                None
            }
            Value::Number(number) => self.number(number),
            Value::Constant(symbol) => self.constant(symbol),
            Value::Equation(tree) => {
                self.quoted(&Symbol(tree.clone()).to_string());
                tree.ast.as_ref().err()
            }
            Value::List(items) => {
                self.text.push('[');
                for (position, item) in items.iter().enumerate() {
                    if position > 0 {
                        self.text.push_str(", ");
                    }
                    self.value(item);
                }
                self.text.push(']');
                None
            }
            Value::Table(entries) => {
                self.text.push('{');
                for (position, (key, value)) in entries.iter().enumerate() {
                    self.text.push_str(if position > 0 { ", " } else { " " });
                    self.pair(key, value);
                }
                self.text
                    .push_str(if entries.is_empty() { "}" } else { " }" });
                None
            }
        };
        if let Some(flaw) = flaw {
            self.flaws.push((start..self.text.len(), flaw.clone()));
        }
    }

    fn number<'v>(&mut self, number: &'v Number) -> Option<&'v Flaw> {
        let symbol = Symbol::from(number.clone());
        self.text.push_str(&symbol.to_string());
        number.0.as_ref().err()
    }

    fn constant<'v>(&mut self, symbol: &'v Symbol) -> Option<&'v Flaw> {
        let is_number = |kind: &Kind| match kind {
            Kind::Number(_) => true,
            Kind::Negate(a) => matches!(a.kind, Kind::Number(_)),
            _ => false,
        };
        let text = symbol.to_string();
        match &symbol.0.ast {
            Ok(ast) if !is_number(&ast.kind) => self.quoted(&text),
            _ => self.text.push_str(&text),
        }
        symbol.0.ast.as_ref().err()
    }
}
