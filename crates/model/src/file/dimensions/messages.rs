//! Whether a term is in the unit it has to be in, and what is said if not.

use super::value::Value;
use crate::syntax::Problem;
use crate::units::{Scale, Unit};
use std::ops::Range;

/// The unit that is needed.
pub(super) struct Demand {
    pub unit: Unit,
    /// Who needs it: the sentence ends with the unit (or with what a function takes).
    pub by: String,
}

/// A part of an equation.
pub(super) struct Term<'t> {
    pub text: &'t str,
    pub range: Range<usize>,
    pub is_sum: bool,
}

pub(super) enum Verdict {
    Fits,
    /// Fits if a number in the term, or the number that it is, has a unit.
    Note(String),
    Wrong(Problem),
}

/// Compares the unit of a term with the one it has to be in. `code` is the code of another
/// dimension; arguments of functions (E0222) have one code for everything.
pub(super) fn compare(term: &Term, value: &Value, demand: &Demand, code: &'static str) -> Verdict {
    let Value::Known { unit, has_number } = value else {
        return Verdict::Fits;
    };
    let wanted = &demand.unit;
    if !unit.agrees_with(wanted) {
        let Some(rest) = wanted.over(unit) else {
            return Verdict::Fits;
        };
        let text = term.text;
        return if *has_number {
            let rest = rest.spell_dimension();
            Verdict::Note(format!("the number in `{text}` is taken to be in {rest}"))
        } else if unit.is_plain() {
            let wanted = wanted.spell();
            Verdict::Note(format!(
                "`{text}` is a plain number and is taken to be in {wanted}"
            ))
        } else {
            Verdict::Wrong(other_dimension(term, unit, demand, (&rest, code)))
        };
    }
    match (unit.scale(), wanted.scale()) {
        (Some(own), Some(needed)) if own != needed => {
            Verdict::Wrong(other_scale(term, unit, demand, (&own.over(needed), code)))
        }
        _ => Verdict::Fits,
    }
}

fn other_dimension(
    term: &Term,
    unit: &Unit,
    demand: &Demand,
    (rest, code): (&Unit, &'static str),
) -> Problem {
    let Term { text, range, .. } = term;
    let needed = needs(demand, code, full);
    Problem::new(
        code,
        format!("`{text}` is in {}, but {needed}", full(unit)),
        range.clone(),
        format!("in {}", unit.spell()),
        format!(
            "multiply it by a quantity in {}, or correct a unit",
            rest.spell_dimension()
        ),
    )
}

fn other_scale(
    term: &Term,
    unit: &Unit,
    demand: &Demand,
    (factor, code): (&Scale, &'static str),
) -> Problem {
    let Term { text, range, .. } = term;
    let term = match term.is_sum {
        true => format!("({text})"),
        false => (*text).to_owned(),
    };
    let needed = needs(demand, code, Unit::spell);
    let code = if code == "E0220" { "E0221" } else { code };
    Problem::new(
        code,
        format!("`{text}` is in {}, but {needed}", unit.spell()),
        range.clone(),
        format!("differs by the factor {factor}"),
        format!(
            "write `{}`, or change one of the units",
            factor.multiply(&term)
        ),
    )
}

/// Who needs what.
fn needs(demand: &Demand, code: &str, spell: impl Fn(&Unit) -> String) -> String {
    match code {
        "E0222" => demand.by.clone(),
        _ => format!("{} {}", demand.by, spell(&demand.unit)),
    }
}

/// A unit as written and, if that says something else, in base units.
fn full(unit: &Unit) -> String {
    let (written, base) = (unit.spell(), unit.spell_dimension());
    let is_base = unit.scale().is_none_or(Scale::is_one) && sorted(&written) == sorted(&base);
    if is_base || unit.scale().is_some_and(|scale| !scale.is_one()) {
        written
    } else {
        format!("{written} = {base}")
    }
}

/// The symbols whatever their order.
fn sorted(unit: &str) -> Vec<char> {
    let mut symbols: Vec<char> = unit.chars().collect();
    symbols.sort_unstable();
    symbols
}
