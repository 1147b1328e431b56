//! Names of the file and what they stand for.

use crate::diagnostic::nearest;
use crate::file::reader::Reader;
use crate::file::text::Text;
use crate::syntax::Problem;
use crate::syntax::ast::{Ast, is_reserved};
use std::collections::BTreeMap;
use std::ops::Range;

/// An equation or condition with the string it was written in.
pub(crate) struct Equation {
    pub text: Text,
    pub ast: Ast,
}

/// What a name stands for in an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meaning {
    State(usize),
    Input(usize),
    Param(usize),
    Let(usize),
    /// A number of [sizes], which belongs in braces.
    Size,
    /// An output or a signal: taken, but no quantity of the equations.
    Measured(&'static str),
}

impl Meaning {
    fn section(self) -> &'static str {
        match self {
            Meaning::State(_) => "a state",
            Meaning::Input(_) => "an input",
            Meaning::Param(_) => "a parameter",
            Meaning::Let(_) => "a [let]",
            Meaning::Size => "a size",
            Meaning::Measured(what) => what,
        }
    }
}

/// All declared names.
#[derive(Default)]
pub(crate) struct Scope {
    names: BTreeMap<String, Meaning>,
    /// A whole section could not be read, so a missing name says nothing.
    pub is_incomplete: bool,
}

impl Scope {
    /// Declares `name`; reports a name that cannot be used or is taken.
    pub fn declare(
        &mut self,
        reader: &mut Reader,
        name: &str,
        place: Range<usize>,
        meaning: Meaning,
    ) {
        if !is_identifier(name) {
            reader.report(
                "E0203",
                format!("`{}` is no name", name.escape_debug()),
                place,
                "cannot be used in an expression",
                "begin with a letter and go on with letters, digits and `_`",
            );
            return;
        }
        if is_reserved(name) {
            reader.report(
                "E0203",
                format!("`{name}` has a fixed meaning in expressions"),
                place,
                "cannot be a name here",
                "take another name",
            );
            return;
        }
        if let Some(taken) = self.names.get(name) {
            let measured = matches!(meaning, Meaning::Measured(_));
            let help = if measured {
                format!("take another name and write column = \"{name}\" for the record's column")
            } else {
                "take another name".to_string()
            };
            let message = format!(
                "the name `{name}` is used twice: it is already {}",
                taken.section()
            );
            reader.report("E0202", message, place, "second use", help);
            return;
        }
        self.names.insert(name.to_string(), meaning);
    }

    pub fn find(&self, name: &str) -> Option<Meaning> {
        self.names.get(name).copied()
    }

    /// Names that can stand in an expression.
    fn quantities(&self) -> impl Iterator<Item = &str> {
        self.names
            .iter()
            .filter(|(_, meaning)| !matches!(meaning, Meaning::Measured(_) | Meaning::Size))
            .map(|(name, _)| name.as_str())
    }

    /// The problem that `name` is not declared; none if it may have been in an unreadable section.
    pub fn unknown(&self, name: &str, range: Range<usize>) -> Option<Problem> {
        if self.is_incomplete {
            return None;
        }
        let help = match nearest(name, self.quantities().chain(["pi"])) {
            Some(near) => format!("did you mean `{near}`?"),
            None if matches!(name, "t" | "time") => {
                "equations cannot depend on time; declare an input with a column of the record"
                    .into()
            }
            None if name == "e" => "write exp(1)".into(),
            None => format!("declare `{name}` in [params], [inputs] or [let]"),
        };
        Some(Problem::new(
            "E0201",
            format!("`{name}` is not declared"),
            range,
            "not a state, input, parameter or [let]",
            help,
        ))
    }
}

fn is_identifier(name: &str) -> bool {
    let mut symbols = name.chars();
    symbols
        .next()
        .is_some_and(|c| c.is_alphabetic() || c == '_')
        && symbols.all(|c| c.is_alphanumeric() || c == '_')
        && crate::syntax::token::tokens(name).is_ok_and(|tokens| tokens.len() == 1)
}
