//! What is said about a row that cannot be used.

use super::cell::Fault;
use super::header::Header;
use crate::reader::Line;
use std::ops::Range;
use veribound_interval::Decimal;
use veribound_model::diagnostic::Diagnostic;

/// A row with more or fewer fields than the header.
pub(crate) fn ragged(line: Line<'_>, ranges: &[Range<usize>], header: &Header) -> Diagnostic {
    let (found, expected) = (ranges.len(), header.columns.len());
    let (range, label) = match ranges.get(expected) {
        Some(first) => (
            first.start..line.text.len(),
            "more than the header names".to_owned(),
        ),
        None => (
            line.text.len()..line.text.len(),
            format!("no field for `{}`", header.text_of(found)),
        ),
    };
    let help = if found > expected && header.separator == ',' {
        "write numbers with a decimal point, and quote texts that hold a comma"
    } else {
        "write one field for every column; an output that was not measured stays empty"
    };
    let fields = if found == 1 { "field" } else { "fields" };
    let message = format!("the row has {found} {fields}, the header has {expected}");
    line.mark(Diagnostic::new("E0407", message), range, label)
        .help(help)
}

/// A field of numbers that holds something else.
pub(crate) fn no_number(
    line: Line<'_>,
    range: Range<usize>,
    column: &str,
    (text, fault): (&str, Fault),
) -> Diagnostic {
    let (is, label, help) = match fault {
        Fault::DecimalComma => (
            "has a decimal comma",
            "a point is expected",
            "export the record with decimal points (0.5 instead of 0,5)",
        ),
        Fault::Infinite => (
            "is no measurement",
            "infinite",
            "write what was recorded; an output that was not measured stays empty",
        ),
        Fault::Hexadecimal => (
            "is a hexadecimal number",
            "a decimal number is expected",
            "write it as a decimal number",
        ),
        Fault::TooLarge => (
            "is out of all proportion",
            "too many digits or too large an exponent",
            "check the column; an output that was not measured stays empty",
        ),
        Fault::Text => (
            "is no number",
            "a decimal number is expected",
            "write a number like -0.25 or 1e-3; an output that was not measured stays empty",
        ),
    };
    let message = format!("`{}` in the column `{column}` {is}", shortened(text));
    line.mark(Diagnostic::new(fault.code(), message), range, label)
        .help(help)
}

/// What a number that must be there is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Need {
    Time,
    Input,
    InputBound,
    OutputBound,
}

/// A value that must be there and is not.
pub(crate) fn missing(line: Line<'_>, range: Range<usize>, need: Need, column: &str) -> Diagnostic {
    let (what, help) = match need {
        Need::Time => (
            "the time stamp",
            "fill in the time of the sample, or remove the line",
        ),
        Need::Input => (
            "the input",
            "fill in the value that held, or remove the line",
        ),
        Need::InputBound => (
            "a bound of the input",
            "fill in both bounds, or remove the line",
        ),
        Need::OutputBound => (
            "a bound of the output",
            "fill in both bounds, or leave both fields empty",
        ),
    };
    let message = format!("{what} is missing in the column `{column}`");
    line.mark(
        Diagnostic::new("E0414", message),
        range,
        "nothing was recorded here",
    )
    .help(help)
}

/// A stamp that is not later than the one before it.
pub(crate) fn not_later(
    line: Line<'_>,
    range: Range<usize>,
    time: &Decimal,
    (before, at): &(Decimal, usize),
) -> Diagnostic {
    let (message, help) = if time == before {
        (
            format!(
                "the lines {at} and {} have the same time {time}",
                line.number
            ),
            "keep one line for every time, or write the stamps with more digits",
        )
    } else {
        (
            format!(
                "time goes back from {before} in line {at} to {time} in line {}",
                line.number
            ),
            "sort the lines by time, or cut the record where its clock was set",
        )
    };
    line.mark(
        Diagnostic::new("E0415", message),
        range,
        format!("must be later than {before}"),
    )
    .help(help)
}

/// A signal that is neither 0 nor 1.
pub(crate) fn no_signal(line: Line<'_>, range: Range<usize>, name: &str, text: &str) -> Diagnostic {
    let message = format!("`{}` is no value of the signal `{name}`", shortened(text));
    line.mark(Diagnostic::new("E0417", message), range, "neither 0 nor 1")
        .help("write 0 or 1 (or false and true), and leave the field empty where nothing was recorded")
}

/// A lower bound above its upper bound.
pub(crate) fn reversed(
    line: Line<'_>,
    range: Range<usize>,
    name: &str,
    (lower, upper): (&Decimal, &Decimal),
) -> Diagnostic {
    let message = format!("the bounds of `{name}` are reversed: {lower} is above {upper}");
    line.mark(
        Diagnostic::new("E0418", message),
        range,
        "below the lower bound",
    )
    .help("write the smaller number into the `.lo` column")
}

/// The beginning of a field that may be very long.
fn shortened(text: &str) -> String {
    const LONGEST: usize = 40;
    let mut shown: String = text.chars().take(LONGEST).collect();
    if shown.len() < text.len() {
        shown.push_str("...");
    }
    shown
}
