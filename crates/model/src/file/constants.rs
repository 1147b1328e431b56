//! Numbers and ranges of the file: exact decimals, or constant expressions enclosed outward.

use crate::file::lower::Lowering;
use crate::file::reader::{Reader, Value};
use crate::file::scope::Scope;
use crate::file::text::Text;
use num_rational::BigRational;
use std::ops::Range;
use toml::de::DeValue;
use veribound_interval::{Decimal, Interval, text};

/// Decimals with more significant digits are widened to as many as can be found again when they are
/// printed.
const PRINTABLE_DIGITS: usize = text::MOST_DIGITS;

fn significant_digits(decimal: &Decimal) -> usize {
    let spelling = decimal.to_string();
    let mantissa = spelling.split(['e', 'E']).next().unwrap_or_default();
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let digits = digits.trim_start_matches('0');
    if mantissa.contains('.') {
        digits.len()
    } else {
        digits.trim_end_matches('0').len()
    }
}

/// The decimal of at most [`PRINTABLE_DIGITS`] that is `exact`, which lies in `enclosure`.
fn short_decimal(exact: &BigRational, enclosure: Interval) -> Option<Decimal> {
    Decimal::parse(&text::upper(enclosure.lo(), PRINTABLE_DIGITS))
        .ok()
        .filter(|decimal| decimal.to_rational() == *exact)
}

/// One end of a range.
enum Constant {
    /// A number as it is spelled.
    Exact(Decimal),
    /// The value of a constant expression lies in here.
    Enclosed(Interval),
}

impl Constant {
    fn enclosure(&self) -> Interval {
        match self {
            Constant::Exact(decimal) => decimal.to_interval(),
            Constant::Enclosed(interval) => *interval,
        }
    }

    /// The number itself where 15 significant digits spell it, else a range that such numbers end.
    ///
    /// Decimals of at most 15 digits are farther apart than floats, so each float is the end of at
    /// most one of them: an end that nothing was cut off can be printed as it was spelled, and the
    /// print is exact. Longer numbers widen the range by less than its last digits show.
    fn printable(&self) -> Interval {
        let enclosure = self.enclosure();
        if let Constant::Exact(decimal) = self
            && significant_digits(decimal) <= PRINTABLE_DIGITS
        {
            return enclosure;
        }
        let lo = text::lower(enclosure.lo(), PRINTABLE_DIGITS);
        let hi = text::upper(enclosure.hi(), PRINTABLE_DIGITS);
        match (Decimal::parse(&lo), Decimal::parse(&hi)) {
            (Ok(lo), Ok(hi)) => lo.to_interval().hull(hi.to_interval()),
            _ => enclosure,
        }
    }

    /// True when `self > other` is certain.
    fn is_above(&self, other: &Constant) -> bool {
        match (self, other) {
            (Constant::Exact(a), Constant::Exact(b)) => a > b,
            _ => self.enclosure().lo() > other.enclosure().hi(),
        }
    }
}

/// A range `[lo, hi]` of `what`, outward to floating-point numbers.
pub(crate) fn range(reader: &mut Reader, value: Value, what: &str) -> Option<Interval> {
    let help = format!("write {what} as [lower, upper]");
    let Some(ends) = value.array() else {
        reader.expected("a list of two numbers", value, help);
        return None;
    };
    let [lower, upper] = ends.as_slice() else {
        let (code, message, label) = if ends.is_empty() {
            (
                "E0204",
                format!("{what} is empty"),
                "no value lies in here".to_string(),
            )
        } else {
            (
                "E0107",
                format!("{what} has {} entries", ends.len()),
                "expected two numbers".to_string(),
            )
        };
        let help = if ends.len() > 2 {
            format!("{help}; the decimal sign is a point: 0.5")
        } else {
            help
        };
        reader.report(code, message, value.place(), label, help);
        return None;
    };
    let (lo, hi) = (
        constant(reader, *lower, &help),
        constant(reader, *upper, &help),
    );
    let (lo, hi) = (lo?, hi?);
    if lo.is_above(&hi) {
        let source = reader.source.clone();
        let spelled = |place: Range<usize>| source.text.get(place).unwrap_or("").to_string();
        reader.report(
            "E0204",
            format!("{what} is reversed: its lower end is above its upper end"),
            value.place(),
            "no value lies in here",
            format!(
                "write [{}, {}]",
                spelled(upper.place()),
                spelled(lower.place())
            ),
        );
        return None;
    }
    bounded(reader, value, lo.printable().hull(hi.printable()))
}

/// A range `[lo, hi]` or a single value of `what`.
pub(crate) fn range_or_point(reader: &mut Reader, value: Value, what: &str) -> Option<Interval> {
    if value.array().is_some() {
        return range(reader, value, what);
    }
    point(
        reader,
        value,
        &format!("write {what} as a number or as [lower, upper]"),
    )
}

/// A single value, enclosed outward.
pub(crate) fn point(reader: &mut Reader, value: Value, help: &str) -> Option<Interval> {
    let value_enclosure = constant(reader, value, help)?.printable();
    bounded(reader, value, value_enclosure)
}

fn bounded(reader: &mut Reader, value: Value, interval: Interval) -> Option<Interval> {
    if interval.is_bounded() && !interval.is_empty() {
        return Some(interval);
    }
    reader.report(
        "E0205",
        "a value is beyond the largest number in double precision",
        value.place(),
        "too large",
        "stay below 1e308, or choose another unit",
    );
    None
}

fn constant(reader: &mut Reader, value: Value, help: &str) -> Option<Constant> {
    let DeValue::String(text) = value.value else {
        return reader.decimal(value, help).map(Constant::Exact);
    };
    let text = Text::new(&reader.source.text, value.place(), text);
    let ast = reader.expression(&text)?;
    if let Some((name, range)) = ast.names().into_iter().find(|(name, _)| *name != "pi") {
        reader.report(
            "E0205",
            format!("a range cannot depend on `{name}`"),
            text.place(range),
            "not a constant",
            "use numbers, pi and functions of them",
        );
        return None;
    }
    let scope = Scope::default();
    let mut lowering = Lowering::new(&scope, 0, 0);
    match lowering.plain(&ast) {
        Ok(e) => {
            // PROOF of "no variable": the expression holds no name but pi.
            let enclosure = lowering.graph.eval_interval(e, &|_| Interval::ENTIRE);
            if enclosure.is_empty() {
                reader.report(
                    "E0218",
                    "an expression has no value",
                    text.place(ast.range),
                    "undefined",
                    "change the expression so that it has a value",
                );
                return None;
            }
            let exact = lowering.graph.as_constant(e);
            let short = exact.and_then(|exact| short_decimal(exact, enclosure));
            Some(short.map_or(Constant::Enclosed(enclosure), Constant::Exact))
        }
        Err(problems) => {
            for problem in problems {
                reader.report_in(&text, problem);
            }
            None
        }
    }
}
