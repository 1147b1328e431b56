//! Units: their spelling is checked, and they are kept and printed as written.
//!
//! A unit is a product of symbols with integer powers: `rad/s`, `N*m`, `N.m`, `1/(kg*m^2)`, `s^-1`,
//! `kg m^2`, with `·`, `²` and `³` allowed. Which symbols exist, and whether the dimensions of the
//! two sides of an equation agree, is not checked.

use crate::syntax::Problem;
use std::ops::Range;

/// Brackets inside each other; no real unit needs more.
const DEEPEST_NESTING: usize = 8;

/// Checks the spelling of `text`. The empty unit and `1` stand for a plain number.
///
/// # Errors
/// The first place that cannot be read as a unit.
pub(crate) fn check(text: &str) -> Result<(), Problem> {
    if text.trim().is_empty() {
        return Ok(());
    }
    let mut reader = Reader {
        symbols: text.char_indices().collect(),
        at: 0,
        length: text.len(),
    };
    reader.product(0)?;
    match reader.peek() {
        None => Ok(()),
        Some((start, ')')) => Err(wrong(
            start..start + 1,
            "no `(` belongs to this",
            "remove it or add the missing `(`",
        )),
        Some((start, symbol)) => Err(unknown(start, symbol)),
    }
}

/// Cuts `text` before a unit in square brackets at its end and gives the range of the unit inside
/// the brackets.
///
/// # Errors
/// A square bracket that is not closed or is followed by more.
pub(crate) fn split_unit(text: &str) -> Result<(&str, Option<Range<usize>>), Problem> {
    let Some((body, rest)) = text.split_once('[') else {
        return match text.find(']') {
            Some(at) => Err(bracket(at..at + 1, "add the missing `[` before the unit")),
            None => Ok((text, None)),
        };
    };
    let open = body.len();
    let Some((unit, tail)) = rest.split_once(']') else {
        return Err(bracket(open..open + 1, "close the unit with `]`"));
    };
    let end = open + 1 + unit.len();
    if !tail.trim().is_empty() {
        return Err(bracket(end + 1..text.len(), "put the unit last"));
    }
    Ok((body, Some(open + 1..end)))
}

fn bracket(range: Range<usize>, help: &str) -> Problem {
    Problem::new(
        "E0117",
        "the unit in square brackets cannot be read",
        range,
        "here",
        help,
    )
}

fn wrong(range: Range<usize>, label: &str, help: &str) -> Problem {
    Problem::new("E0117", "the unit cannot be read", range, label, help)
}

fn unknown(start: usize, symbol: char) -> Problem {
    let help = match symbol {
        '%' => "write the share as a plain number without unit: 0.1 for ten percent",
        '[' | ']' => "write the unit without square brackets here",
        _ => "write units like rad/s, N*m, 1/(kg*m^2) or s^-1",
    };
    wrong(start..start + symbol.len_utf8(), "unexpected", help)
}

struct Reader {
    symbols: Vec<(usize, char)>,
    at: usize,
    length: usize,
}

impl Reader {
    fn skip_blanks(&mut self) {
        while self
            .symbols
            .get(self.at)
            .is_some_and(|(_, c)| c.is_whitespace())
        {
            self.at += 1;
        }
    }

    /// The next symbol that is not blank.
    fn peek(&mut self) -> Option<(usize, char)> {
        self.skip_blanks();
        self.symbols.get(self.at).copied()
    }

    fn take_while(&mut self, wanted: impl Fn(char) -> bool) -> bool {
        let start = self.at;
        while self.symbols.get(self.at).is_some_and(|(_, c)| wanted(*c)) {
            self.at += 1;
        }
        self.at > start
    }

    fn product(&mut self, nesting: usize) -> Result<(), Problem> {
        self.factor(nesting)?;
        loop {
            match self.peek() {
                Some((_, '*')) => {
                    self.at += 1;
                    // `**` between factors is a power without a base only if nothing was read.
                    self.factor(nesting)?;
                }
                Some((_, '/' | '.' | '·')) => {
                    self.at += 1;
                    self.factor(nesting)?;
                }
                // Two symbols with a blank between them: a product.
                Some((_, c)) if is_letter(c) || c == '(' => self.factor(nesting)?,
                _ => return Ok(()),
            }
        }
    }

    fn factor(&mut self, nesting: usize) -> Result<(), Problem> {
        match self.peek() {
            None => {
                return Err(wrong(
                    self.length..self.length,
                    "expected a unit",
                    "write a unit after the operator or remove the operator",
                ));
            }
            Some((start, '(')) => {
                if nesting >= DEEPEST_NESTING {
                    return Err(wrong(
                        start..start + 1,
                        "too many brackets",
                        "remove brackets",
                    ));
                }
                self.at += 1;
                self.product(nesting + 1)?;
                match self.peek() {
                    Some((_, ')')) => self.at += 1,
                    None => {
                        return Err(wrong(
                            start..start + 1,
                            "opened here",
                            "add the missing `)`",
                        ));
                    }
                    Some((start, symbol)) => return Err(unknown(start, symbol)),
                }
            }
            Some((_, c)) if is_letter(c) => {
                self.take_while(is_letter);
            }
            Some((start, '1')) => {
                self.at += 1;
                if self.take_while(|c| c.is_ascii_digit() || c == '.') {
                    return Err(factor_in_unit(start));
                }
            }
            Some((start, c)) if c.is_ascii_digit() => return Err(factor_in_unit(start)),
            Some((start, symbol)) => return Err(unknown(start, symbol)),
        }
        self.power()
    }

    fn power(&mut self) -> Result<(), Problem> {
        if self.take_while(|c| matches!(c, '²' | '³')) {
            return Ok(());
        }
        let stars = matches!(
            (self.symbols.get(self.at), self.symbols.get(self.at + 1)),
            (Some((_, '*')), Some((_, '*')))
        );
        if stars {
            self.at += 2;
        } else if matches!(self.peek(), Some((_, '^'))) {
            self.at += 1;
        } else {
            return Ok(());
        }
        if matches!(self.peek(), Some((_, '-' | '+'))) {
            self.at += 1;
        }
        if self.take_while(|c| c.is_ascii_digit()) {
            return Ok(());
        }
        let start = self
            .symbols
            .get(self.at)
            .map_or(self.length, |(start, _)| *start);
        let end = self
            .symbols
            .get(self.at + 1)
            .map_or(self.length, |(start, _)| *start);
        Err(wrong(
            start..end,
            "expected an integer",
            "write the power as an integer: m^2, s^-1",
        ))
    }
}

fn factor_in_unit(start: usize) -> Problem {
    wrong(
        start..start + 1,
        "a number other than 1",
        "put factors into the values, not into the unit",
    )
}

fn is_letter(c: char) -> bool {
    c.is_alphabetic() || matches!(c, '°' | '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_units() {
        for unit in [
            "",
            "1",
            "rad",
            "rad/s",
            "N*m",
            "N.m",
            "N·m",
            "1/(kg*m^2)",
            "s^-1",
            "kg m^2",
            "m**2",
            "m²",
            "deg",
            "°",
            "µm",
            "Ω",
            "rad/s/s",
            "1/s",
            " N * m / rad ",
            "(N*m)^2",
        ] {
            assert_eq!(check(unit), Ok(()), "{unit}");
        }
    }

    #[test]
    fn wrong_units() {
        for (unit, place) in [
            ("rad//s", 4..5),
            ("%", 0..1),
            ("1/(kg*m^2", 2..3),
            ("m^", 2..2),
            ("m^x", 2..3),
            ("rad/", 4..4),
            ("2*m", 0..1),
            ("10", 0..1),
            ("m)", 1..2),
            ("m^^2", 2..3),
            ("[rad]", 0..1),
        ] {
            assert_eq!(check(unit).unwrap_err().range, place, "{unit}");
        }
        assert!(check(&"(".repeat(100_000)).is_err());
    }

    #[test]
    fn unit_in_square_brackets() {
        assert_eq!(split_unit("phi [rad]"), Ok(("phi ", Some(5..8))));
        assert_eq!(split_unit("phi"), Ok(("phi", None)));
        assert!(split_unit("phi [rad").is_err());
        assert!(split_unit("phi rad]").is_err());
        assert!(split_unit("phi [rad] x").is_err());
    }
}
