//! The header line: what its columns are called, and how a name finds its column.

use super::units::{self, Written};
use crate::reader::fields::{QuoteError, content, split};
use std::ops::Range;
use std::sync::Arc;
use veribound_model::diagnostic::{Diagnostic, SourceText};

/// One column, as its header names it.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    /// The whole header, `phi [rad]` say.
    pub text: String,
    /// The header without a unit in brackets.
    pub name: String,
    /// The unit in brackets.
    pub unit: Option<String>,
    /// Where it stands in the header line.
    pub range: Range<usize>,
}

/// The header line of a record.
#[derive(Debug, Clone)]
pub(crate) struct Header {
    pub columns: Vec<Column>,
    pub separator: char,
    pub source: Arc<SourceText>,
}

/// The columns of one variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    /// Recorded values.
    Value(usize),
    /// Lower and upper bounds, `phi.lo` and `phi.hi`.
    Bounds(usize, usize),
}

/// Why a name has no column of its own.
pub(crate) enum NotFound {
    /// No column fits.
    Missing,
    /// Several columns fit.
    Ambiguous(Vec<Place>),
}

impl Header {
    /// Reads the header from its line.
    pub(crate) fn parse(
        line: &str,
        separator: char,
        source: &Arc<SourceText>,
    ) -> Result<Self, QuoteError> {
        let mut ranges = Vec::new();
        split(line, separator, &mut ranges)?;
        let columns = ranges
            .into_iter()
            .map(|range| Column::parse(&content(line, range.clone()), range))
            .collect();
        Ok(Header {
            columns,
            separator,
            source: Arc::clone(source),
        })
    }

    /// The one column that the user called `wanted`: by its whole header, or without its unit.
    pub(crate) fn find_named(&self, wanted: &str) -> Result<Place, NotFound> {
        let whole = self.singles(|column| column.text == wanted);
        if !whole.is_empty() {
            return only(whole);
        }
        let mut places = self.singles(|column| column.name == wanted);
        places.extend(self.pairs(wanted));
        only(places)
    }

    /// The one column of the variable `name` when the user did not say which: its name, or else
    /// its name with a unit appended (`phi_rad`), the model's own unit before others.
    pub(crate) fn find_variable(&self, name: &str, unit: &str) -> Result<Place, NotFound> {
        let mut places = self.singles(|column| column.name == name);
        places.extend(self.pairs(name));
        if !places.is_empty() {
            return only(places);
        }
        let appended = |column: &Column| column.appended_unit(name).map(str::to_owned);
        let same = self.singles(|column| {
            appended(column).is_some_and(|suffix| !unit.is_empty() && units::is_same(&suffix, unit))
        });
        if !same.is_empty() {
            return only(same);
        }
        only(self.singles(|column| appended(column).is_some_and(|s| units::is_usual(&s))))
    }

    /// The unit that a column is written in, as far as its header tells.
    pub(crate) fn unit_of(&self, at: usize, variable: &str) -> Option<Written<'_>> {
        let column = self.columns.get(at)?;
        let appended = column.appended_unit(variable);
        let appended = appended.filter(|suffix| units::is_usual(suffix));
        let (text, is_appended) = match &column.unit {
            Some(unit) => (unit.as_str(), false),
            None => (appended?, true),
        };
        Some(Written { text, is_appended })
    }

    /// The header of one column, as the user wrote it.
    pub(crate) fn text_of(&self, at: usize) -> &str {
        self.columns
            .get(at)
            .map_or("", |column| column.text.as_str())
    }

    /// The headers at `place`, as the user wrote them.
    pub(crate) fn spell(&self, place: Place) -> String {
        match place {
            Place::Value(at) => self.text_of(at).to_owned(),
            Place::Bounds(lo, hi) => format!("{}, {}", self.text_of(lo), self.text_of(hi)),
        }
    }

    /// All headers, for messages.
    pub(crate) fn list(&self) -> String {
        let texts: Vec<&str> = self
            .columns
            .iter()
            .map(|column| column.text.as_str())
            .collect();
        texts.join(", ")
    }

    /// Adds the place of the whole header line to a message.
    pub(crate) fn mark(&self, diagnostic: Diagnostic, label: impl Into<String>) -> Diagnostic {
        diagnostic.at(&self.source, 0..self.source.text.len(), label)
    }

    /// Adds the place of one column's header to a message.
    pub(crate) fn mark_column(
        &self,
        at: usize,
        diagnostic: Diagnostic,
        label: impl Into<String>,
    ) -> Diagnostic {
        match self.columns.get(at) {
            // A very long header line is quoted only in part.
            Some(column) if column.range.end <= self.source.text.len() => {
                diagnostic.at(&self.source, column.range.clone(), label)
            }
            _ => self.mark(diagnostic, label),
        }
    }

    fn singles(&self, fits: impl Fn(&Column) -> bool) -> Vec<Place> {
        let numbered = self.columns.iter().enumerate();
        numbered
            .filter(|(_, column)| fits(column))
            .map(|(at, _)| Place::Value(at))
            .collect()
    }

    fn pairs(&self, name: &str) -> Vec<Place> {
        let named = |end: &str| {
            let numbered = self.columns.iter().enumerate();
            let bounds = numbered.filter(|(_, column)| column.name.strip_prefix(name) == Some(end));
            bounds.map(|(at, _)| at).collect::<Vec<_>>()
        };
        let his = named(".hi");
        let lows = named(".lo").into_iter();
        lows.flat_map(|lo| his.iter().map(move |hi| Place::Bounds(lo, *hi)))
            .collect()
    }
}

impl Column {
    fn parse(text: &str, range: Range<usize>) -> Self {
        let brackets = |open: char, close: char| {
            let (name, unit) = text.strip_suffix(close)?.rsplit_once(open)?;
            Some((name.trim().to_owned(), unit.trim().to_owned()))
        };
        // `x(2)` is a name, `x (m)` has a unit.
        let parentheses = || text.contains(" (").then(|| brackets('(', ')')).flatten();
        let (name, unit) = match brackets('[', ']').or_else(parentheses) {
            Some((name, unit)) if !unit.is_empty() => (name, Some(unit)),
            Some((name, _)) => (name, None),
            None => (text.to_owned(), None),
        };
        Column {
            text: text.to_owned(),
            name,
            unit,
            range,
        }
    }

    fn appended_unit(&self, name: &str) -> Option<&str> {
        let suffix = self.name.strip_prefix(name)?.strip_prefix('_')?;
        (self.unit.is_none() && !suffix.is_empty()).then_some(suffix)
    }
}

fn only(places: Vec<Place>) -> Result<Place, NotFound> {
    match places.as_slice() {
        [] => Err(NotFound::Missing),
        [one] => Ok(*one),
        _ => Err(NotFound::Ambiguous(places)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(line: &str) -> Header {
        let source = Arc::new(SourceText::excerpt("x.csv", line, 1));
        Header::parse(line, ',', &source).unwrap()
    }

    fn found(result: Result<Place, NotFound>) -> Option<Place> {
        result.ok()
    }

    #[test]
    fn a_variable_is_found_by_name_and_by_name_with_unit() {
        let rig = header("t_s,u_Nm,phi_meas_rad,omega [rad/s],x (m),q(2)");
        assert_eq!(found(rig.find_variable("u", "N*m")), Some(Place::Value(1)));
        assert_eq!(found(rig.find_variable("u", "")), Some(Place::Value(1)));
        assert_eq!(
            found(rig.find_variable("phi_meas", "rad")),
            Some(Place::Value(2))
        );
        assert_eq!(found(rig.find_variable("phi", "rad")), None);
        assert_eq!(
            found(rig.find_variable("omega", "rad/s")),
            Some(Place::Value(3))
        );
        assert_eq!(found(rig.find_variable("x", "m")), Some(Place::Value(4)));
        assert_eq!(found(rig.find_variable("q(2)", "m")), Some(Place::Value(5)));
        assert_eq!(
            found(rig.find_named("omega [rad/s]")),
            Some(Place::Value(3))
        );
        assert_eq!(found(rig.find_named("omega")), Some(Place::Value(3)));
    }

    #[test]
    fn bounds_come_in_pairs() {
        let pair = header("t,phi.hi [rad],phi.lo [rad]");
        assert_eq!(
            found(pair.find_variable("phi", "rad")),
            Some(Place::Bounds(2, 1))
        );
        assert_eq!(found(header("t,phi.lo").find_variable("phi", "rad")), None);
    }

    #[test]
    fn two_columns_that_fit_are_ambiguous_unless_one_has_the_unit_of_the_model() {
        let two = header("t,phi_deg,phi_rad,x,x,y_mm,y_cm");
        assert_eq!(
            found(two.find_variable("phi", "rad")),
            Some(Place::Value(2))
        );
        let ambiguous = |name, unit| matches!(two.find_variable(name, unit), Err(NotFound::Ambiguous(p)) if p.len() == 2);
        assert!(ambiguous("phi", "") && ambiguous("x", "m") && ambiguous("y", "m"));
    }
}
