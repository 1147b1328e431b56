//! One field: the exact number it spells, or why it spells none.

use veribound_interval::{Decimal, DecimalError};

/// Why a field is no number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    DecimalComma,
    Infinite,
    Hexadecimal,
    TooLarge,
    Text,
}

impl Fault {
    /// The code of the message about it.
    pub(crate) fn code(self) -> &'static str {
        match self {
            Fault::DecimalComma => "E0413",
            _ => "E0412",
        }
    }
}

/// What a field of numbers says; `None` is a missing value (empty or `NaN`).
pub(crate) fn number(text: &str) -> Result<Option<Decimal>, Fault> {
    if text.is_empty() || text.eq_ignore_ascii_case("nan") {
        return Ok(None);
    }
    Decimal::parse(text).map(Some).map_err(|error| match error {
        DecimalError::TooLarge => Fault::TooLarge,
        _ => fault(text),
    })
}

fn fault(text: &str) -> Fault {
    let size = text.strip_prefix(['+', '-']).unwrap_or(text);
    let lower = size.to_ascii_lowercase();
    if matches!(lower.as_str(), "inf" | "infinity" | "∞") {
        Fault::Infinite
    } else if lower.starts_with("0x") {
        Fault::Hexadecimal
    } else if is_decimal_comma(size) {
        Fault::DecimalComma
    } else {
        Fault::Text
    }
}

/// `0,5`, `1.234,5`, `,5` and `1,5e-3`: digits around a comma.
fn is_decimal_comma(size: &str) -> bool {
    size.contains(',')
        && size.bytes().any(|byte| byte.is_ascii_digit())
        && size
            .bytes()
            .all(|byte| byte.is_ascii_digit() || b",.eE+-".contains(&byte))
}

/// A binary value; `None` in the outer `Option` when `text` is neither, in the inner one when the
/// value is missing.
pub(crate) fn signal(text: &str) -> Option<Option<bool>> {
    match text {
        "1" | "1.0" => Some(Some(true)),
        "0" | "0.0" => Some(Some(false)),
        "" => Some(None),
        _ if text.eq_ignore_ascii_case("true") => Some(Some(true)),
        _ if text.eq_ignore_ascii_case("false") => Some(Some(false)),
        _ if text.eq_ignore_ascii_case("nan") => Some(None),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_the_decimals_they_are() {
        for text in [
            "0", "-0.0528", "+1", "1e3", "2.5E-3", "007.50", "1e-0400", "1e400",
        ] {
            let expected = Decimal::parse(text).unwrap();
            assert_eq!(number(text).unwrap().unwrap(), expected, "{text}");
        }
        assert_eq!(number(""), Ok(None));
        assert_eq!(number("NaN"), Ok(None));
    }

    #[test]
    fn everything_else_is_a_fault_of_its_kind() {
        let faults = [
            ("0,5", Fault::DecimalComma),
            ("-1.234,5", Fault::DecimalComma),
            ("inf", Fault::Infinite),
            ("-Infinity", Fault::Infinite),
            ("0x1.8p3", Fault::Hexadecimal),
            ("1e10001", Fault::TooLarge),
            ("1e99999999999999999999", Fault::TooLarge),
            ("abc", Fault::Text),
            ("1_000", Fault::Text),
            ("1 000", Fault::Text),
            ("--1", Fault::Text),
            ("1e", Fault::Text),
            ("e5", Fault::Text),
            ("-", Fault::Text),
            ("NaN(1)", Fault::Text),
            ("٣", Fault::Text),
        ];
        for (text, expected) in faults {
            assert_eq!(number(text), Err(expected), "{text}");
        }
        assert_eq!(number(&"1".repeat(10_001)), Err(Fault::TooLarge));
    }

    #[test]
    fn signals_are_zero_or_one() {
        assert_eq!(signal("1"), Some(Some(true)));
        assert_eq!(signal("FALSE"), Some(Some(false)));
        assert_eq!(signal(""), Some(None));
        assert_eq!(signal("2"), None);
    }
}
