//! The spelling of units.

use super::{Exponent, LARGEST_DENOMINATOR, LARGEST_POWER};
use crate::syntax::Problem;
use num_traits::{One, Signed};
use std::ops::Range;

/// Brackets inside each other; no real unit needs more.
const DEEPEST_NESTING: usize = 8;

/// Symbols with their powers.
type Factors = Vec<(String, Exponent)>;

/// The symbols of a unit with their powers, in the order of the text. The empty text and `1` stand
/// for a plain number.
///
/// # Errors
/// The first place that cannot be read as a unit.
pub(super) fn factors(text: &str) -> Result<Factors, Problem> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    let mut reader = Reader {
        symbols: text.char_indices().collect(),
        at: 0,
        length: text.len(),
    };
    let factors = reader.product(0)?;
    match reader.peek() {
        None => Ok(factors),
        Some((start, ')')) => Err(wrong(
            start..start + 1,
            "no `(` belongs to this",
            "remove it or add the missing `(`",
        )),
        Some((start, symbol)) => Err(unknown(start, symbol)),
    }
}

/// The problem of a unit with powers that no unit has.
pub(super) fn too_large(text: &str) -> Problem {
    wrong(
        0..text.len(),
        "its powers are too large",
        "write small integers as powers: m^2, s^-1",
    )
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

    fn take_while(&mut self, wanted: impl Fn(char) -> bool) -> String {
        let mut taken = String::new();
        while let Some((_, c)) = self.symbols.get(self.at).filter(|(_, c)| wanted(*c)) {
            taken.push(*c);
            self.at += 1;
        }
        taken
    }

    fn product(&mut self, nesting: usize) -> Result<Factors, Problem> {
        let mut product = self.factor(nesting)?;
        loop {
            match self.peek() {
                Some((_, operator @ ('*' | '/' | '.' | '·'))) => {
                    self.at += 1;
                    // `**` between factors is a power without a base only if nothing was read.
                    let factor = self.factor(nesting)?;
                    let divides = operator == '/';
                    let signed = |power: Exponent| if divides { -power } else { power };
                    product.extend(factor.into_iter().map(|(s, power)| (s, signed(power))));
                }
                // Two symbols with a blank between them: a product.
                Some((_, c)) if is_letter(c) || c == '(' => product.extend(self.factor(nesting)?),
                _ => return Ok(product),
            }
        }
    }

    fn factor(&mut self, nesting: usize) -> Result<Factors, Problem> {
        let base = self.base(nesting)?;
        let start = self.at;
        let power = self.power()?;
        let raised = base.into_iter().map(|(symbol, own)| {
            let power = own * power?;
            let is_small = power.abs() <= Exponent::from_integer(LARGEST_POWER)
                && *power.denom() <= LARGEST_DENOMINATOR;
            is_small.then_some((symbol, power))
        });
        raised.collect::<Option<_>>().ok_or_else(|| {
            let range = self.offset(start)..self.offset(self.at);
            wrong(
                range,
                "too large",
                "write a small integer as the power: m^2, s^-1",
            )
        })
    }

    /// A symbol, `1`, or a product in brackets.
    fn base(&mut self, nesting: usize) -> Result<Factors, Problem> {
        match self.peek() {
            None => Err(wrong(
                self.length..self.length,
                "expected a unit",
                "write a unit after the operator or remove the operator",
            )),
            Some((start, '(')) => self.brackets(start, nesting),
            Some((_, c)) if is_letter(c) => Ok(vec![(self.take_while(is_letter), Exponent::one())]),
            Some((start, '1')) => {
                self.at += 1;
                let more = self.take_while(|c| c.is_ascii_digit() || c == '.');
                if more.is_empty() {
                    Ok(Vec::new())
                } else {
                    Err(factor_in_unit(start))
                }
            }
            Some((start, c)) if c.is_ascii_digit() => Err(factor_in_unit(start)),
            Some((start, symbol)) => Err(unknown(start, symbol)),
        }
    }

    fn brackets(&mut self, start: usize, nesting: usize) -> Result<Factors, Problem> {
        if nesting >= DEEPEST_NESTING {
            return Err(wrong(
                start..start + 1,
                "too many brackets",
                "remove brackets",
            ));
        }
        self.at += 1;
        let product = self.product(nesting + 1)?;
        match self.peek() {
            Some((_, ')')) => {
                self.at += 1;
                Ok(product)
            }
            None => Err(wrong(
                start..start + 1,
                "opened here",
                "add the missing `)`",
            )),
            Some((start, symbol)) => Err(unknown(start, symbol)),
        }
    }

    /// The power behind a factor; 1 where there is none, `None` where it is out of all proportion.
    fn power(&mut self) -> Result<Option<Exponent>, Problem> {
        let raised = self.take_while(|c| matches!(c, '²' | '³'));
        if !raised.is_empty() {
            let digits = raised.replace('²', "2").replace('³', "3");
            return Ok(exponent(&digits, 1));
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
            return Ok(Some(Exponent::one()));
        }
        let bracket = matches!(self.peek(), Some((_, '(')));
        self.at += usize::from(bracket);
        let mut sign = 1;
        if let Some((_, c @ ('-' | '+'))) = self.peek() {
            self.at += 1;
            sign = if c == '-' { -1 } else { 1 };
        }
        let digits = self.take_while(|c| c.is_ascii_digit());
        let mut power = exponent(&digits, sign);
        if !digits.is_empty() && !bracket {
            return Ok(power);
        }
        if !digits.is_empty() && matches!(self.peek(), Some((_, '/'))) {
            self.at += 1;
            self.skip_blanks();
            let below = self.take_while(|c| c.is_ascii_digit());
            let below = exponent(&below, 1).filter(|below| below.is_positive());
            power = power.zip(below).map(|(power, below)| power / below);
        }
        if !digits.is_empty() && matches!(self.peek(), Some((_, ')'))) {
            self.at += 1;
            return Ok(power);
        }
        Err(wrong(
            self.offset(self.at)..self.offset(self.at + 1),
            "expected an integer",
            "write the power as an integer or a fraction: m^2, s^-1, m^(1/2)",
        ))
    }

    /// Where symbol `at` begins in the text.
    fn offset(&self, at: usize) -> usize {
        let symbol = self.symbols.get(at);
        symbol.map_or(self.length, |(start, _)| *start)
    }
}

/// A whole power; `None` where it is out of all proportion.
fn exponent(digits: &str, sign: i64) -> Option<Exponent> {
    let number: i64 = digits.parse().ok()?;
    (number <= LARGEST_POWER).then(|| Exponent::from_integer(sign * number))
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
            "m^(1/2)",
            "N/m^( -3 / 2 )",
            "m^(2)*s",
        ] {
            assert!(factors(unit).is_ok(), "{unit}");
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
            ("m^1001", 1..6),
            ("m^99999999999999999999", 1..22),
            ("(m^100)^11", 7..10),
            ("m^(1/0)", 1..7),
            ("m^(1/65)", 1..8),
            ("m^(1/", 5..5),
            ("m^(1 2)", 5..6),
            ("m^(/2)", 3..4),
        ] {
            assert_eq!(factors(unit).unwrap_err().range, place, "{unit}");
        }
        assert!(factors(&"(".repeat(100_000)).is_err());
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
