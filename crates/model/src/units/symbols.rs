//! The symbols that are known.

use super::scale::Scale;
use num_bigint::BigInt;
use num_rational::BigRational;

/// What a symbol stands for.
pub(super) struct Meaning {
    /// Powers of base units.
    pub dimension: Vec<(String, i64)>,
    pub scale: Scale,
    /// The temperature scale it belongs to.
    pub temperature: Option<&'static str>,
}

struct Symbol {
    names: &'static [&'static str],
    /// Whether `m`, `k` and so on may stand before its names.
    has_prefixes: bool,
    dimension: &'static [(&'static str, i64)],
    /// Numerator, denominator and power of pi.
    scale: (i64, i64, i64),
}

const fn si(names: &'static [&'static str], dimension: &'static [(&'static str, i64)]) -> Symbol {
    scaled(names, dimension, (1, 1, 0))
}

const fn scaled(
    names: &'static [&'static str],
    dimension: &'static [(&'static str, i64)],
    scale: (i64, i64, i64),
) -> Symbol {
    Symbol {
        names,
        has_prefixes: true,
        dimension,
        scale,
    }
}

/// A symbol that is never read with a prefix: `min` is no milli-inch and `dd` no tenth of a day.
const fn alone(
    names: &'static [&'static str],
    dimension: &'static [(&'static str, i64)],
    scale: (i64, i64, i64),
) -> Symbol {
    Symbol {
        names,
        has_prefixes: false,
        dimension,
        scale,
    }
}

const PREFIXES: [(&str, i32); 14] = [
    ("f", -15),
    ("p", -12),
    ("n", -9),
    // Micro sign, Greek mu, and the letter of keyboards that have neither.
    ("\u{b5}", -6),
    ("\u{3bc}", -6),
    ("u", -6),
    ("m", -3),
    ("c", -2),
    ("d", -1),
    ("h", 2),
    ("k", 3),
    ("M", 6),
    ("G", 9),
    ("T", 12),
];

const KELVIN: &[&str] = &["K"];
const CELSIUS: &[&str] = &["°C", "degC", "\u{2103}"];
const FAHRENHEIT: &[&str] = &["°F", "degF", "\u{2109}"];
/// Would be read as a prefix and a symbol, and is never meant so.
const NOT_PREFIXED: [&str; 1] = ["pH"];

const SYMBOLS: [Symbol; 39] = [
    si(&["m"], &[("m", 1)]),
    scaled(&["g"], &[("kg", 1)], (1, 1000, 0)),
    si(&["s"], &[("s", 1)]),
    si(&["A"], &[("A", 1)]),
    si(KELVIN, &[("K", 1)]),
    si(&["mol"], &[("mol", 1)]),
    si(&["cd"], &[("cd", 1)]),
    si(&["rad"], &[("rad", 1)]),
    si(&["Hz"], &[("s", -1)]),
    si(&["N"], &[("kg", 1), ("m", 1), ("s", -2)]),
    si(&["Pa"], &[("kg", 1), ("m", -1), ("s", -2)]),
    si(&["J"], &[("kg", 1), ("m", 2), ("s", -2)]),
    si(&["W"], &[("kg", 1), ("m", 2), ("s", -3)]),
    si(&["C"], &[("A", 1), ("s", 1)]),
    si(&["V"], &[("kg", 1), ("m", 2), ("s", -3), ("A", -1)]),
    si(&["F"], &[("kg", -1), ("m", -2), ("s", 4), ("A", 2)]),
    si(
        &["Ohm", "ohm", "\u{3a9}", "\u{2126}"],
        &[("kg", 1), ("m", 2), ("s", -3), ("A", -2)],
    ),
    si(&["S"], &[("kg", -1), ("m", -2), ("s", 3), ("A", 2)]),
    si(&["Wb"], &[("kg", 1), ("m", 2), ("s", -2), ("A", -1)]),
    si(&["T"], &[("kg", 1), ("s", -2), ("A", -1)]),
    si(&["H"], &[("kg", 1), ("m", 2), ("s", -2), ("A", -2)]),
    scaled(&["L", "l"], &[("m", 3)], (1, 1000, 0)),
    scaled(
        &["bar"],
        &[("kg", 1), ("m", -1), ("s", -2)],
        (100_000, 1, 0),
    ),
    scaled(&["deg"], &[("rad", 1)], (1, 180, 1)),
    // Products that are written as one word.
    si(&["Nm", "Ws"], &[("kg", 1), ("m", 2), ("s", -2)]),
    si(&["As"], &[("A", 1), ("s", 1)]),
    scaled(&["Wh"], &[("kg", 1), ("m", 2), ("s", -2)], (3600, 1, 0)),
    scaled(&["Ah"], &[("A", 1), ("s", 1)], (3600, 1, 0)),
    alone(&["Nmm"], &[("kg", 1), ("m", 2), ("s", -2)], (1, 1000, 0)),
    alone(&["t"], &[("kg", 1)], (1000, 1, 0)),
    alone(&["sec"], &[("s", 1)], (1, 1, 0)),
    alone(&["min"], &[("s", 1)], (60, 1, 0)),
    alone(&["h", "hr", "hour", "hours"], &[("s", 1)], (3600, 1, 0)),
    alone(&["d", "day", "days"], &[("s", 1)], (86_400, 1, 0)),
    alone(&["°", "degree", "degrees"], &[("rad", 1)], (1, 180, 1)),
    alone(&["rev"], &[("rad", 1)], (2, 1, 1)),
    alone(&["rpm"], &[("rad", 1), ("s", -1)], (1, 30, 1)),
    alone(CELSIUS, &[("K", 1)], (1, 1, 0)),
    alone(FAHRENHEIT, &[("K", 1)], (5, 9, 0)),
];

/// The meaning of a symbol: as it stands, or else as a prefix and a symbol.
pub(super) fn find(text: &str) -> Option<Meaning> {
    if let Some(symbol) = SYMBOLS.iter().find(|symbol| symbol.names.contains(&text)) {
        return Some(symbol.meaning(0));
    }
    if NOT_PREFIXED.contains(&text) {
        return None;
    }
    PREFIXES.iter().find_map(|(prefix, power)| {
        let name = text.strip_prefix(prefix)?;
        let mut prefixed = SYMBOLS.iter().filter(|symbol| symbol.has_prefixes);
        let symbol = prefixed.find(|symbol| symbol.names.contains(&name))?;
        Some(symbol.meaning(*power))
    })
}

impl Symbol {
    fn meaning(&self, tens: i32) -> Meaning {
        let (numerator, denominator, pi) = self.scale;
        let own = BigRational::new(BigInt::from(numerator), BigInt::from(denominator));
        let tens = BigRational::from_integer(BigInt::from(10)).pow(tens);
        let dimension = self.dimension.iter();
        let scales = [KELVIN, CELSIUS, FAHRENHEIT].into_iter();
        Meaning {
            dimension: dimension.map(|(b, p)| ((*b).to_owned(), *p)).collect(),
            scale: Scale::new(own * tens, pi),
            temperature: scales
                .into_iter()
                .find(|names| *names == self.names)
                .and_then(|names| names.first().copied()),
        }
    }
}
