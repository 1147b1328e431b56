//! Units as headers spell them, and whether they are the model's.

use veribound_model::units::{Conversion, Unit};

/// Suffixes that are read as a unit when the model gives none (`phi_rad` for `phi`).
const USUAL: [&str; 44] = [
    "rad", "deg", "m", "mm", "um", "cm", "km", "s", "ms", "us", "min", "h", "V", "mV", "A", "mA",
    "N", "kN", "Nm", "Nmm", "kg", "g", "K", "C", "degC", "Hz", "kHz", "rpm", "W", "kW", "J", "Pa",
    "kPa", "bar", "rads", "degs", "ms2", "rads2", "mps", "radps", "mols", "pct", "percent",
    "ratio",
];

/// Spellings of the second.
const SECONDS: [&str; 5] = ["s", "sec", "secs", "second", "seconds"];

/// Other units of time, and how many seconds one is.
const TIMES: [(&str, &str); 15] = [
    ("ms", "0.001"),
    ("msec", "0.001"),
    ("millis", "0.001"),
    ("milliseconds", "0.001"),
    ("us", "0.000001"),
    ("µs", "0.000001"),
    ("usec", "0.000001"),
    ("microseconds", "0.000001"),
    ("ns", "0.000000001"),
    ("nsec", "0.000000001"),
    ("nanoseconds", "0.000000001"),
    ("min", "60"),
    ("minutes", "60"),
    ("h", "3600"),
    ("hours", "3600"),
];

/// Whether `unit` is a spelling of the second.
pub(crate) fn is_second(unit: &str) -> bool {
    SECONDS.contains(&unit.to_lowercase().as_str())
}

/// How many seconds one `unit` is, for units of time other than the second.
pub(crate) fn in_seconds(unit: &str) -> Option<&'static str> {
    let unit = unit.to_lowercase();
    let found = TIMES.iter().find(|(name, _)| *name == unit);
    found.map(|(_, seconds)| *seconds)
}

/// Whether two units have the same letters, whatever stands between them: `N*m`, `N.m` and `Nm`,
/// `rad/s` and `rad_per_s`.
pub(crate) fn is_same(one: &str, other: &str) -> bool {
    letters(one) == letters(other)
}

/// Whether `suffix` is a unit when a header ends in it.
pub(crate) fn is_usual(suffix: &str) -> bool {
    USUAL.contains(&letters(suffix).as_str())
}

/// A unit that a header names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Written<'h> {
    pub text: &'h str,
    /// Appended to the name (`phi_deg`) and not in brackets: it may be another word.
    pub is_appended: bool,
}

/// What has to be done with numbers of a column.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Relation {
    /// They are in the unit of the model.
    Same,
    /// They are in another unit of the same dimension.
    Converted(Conversion),
    /// Nothing is known for certain.
    Unclear,
    /// They are temperatures on a scale with another zero.
    OtherZero,
    /// They cannot be in the unit of the model.
    Other,
}

/// Units that are appended without their signs, where letters alone mean something else.
const SIGNLESS: [(&str, &str); 9] = [
    ("ms", "m/s"),
    ("mps", "m/s"),
    ("ms2", "m/s^2"),
    ("rads", "rad/s"),
    ("radps", "rad/s"),
    ("rads2", "rad/s^2"),
    ("degs", "deg/s"),
    ("mols", "mol/s"),
    ("C", "degC"),
];

/// Compares the unit of a column with the one the model says.
pub(crate) fn compare(written: Written<'_>, model: &str) -> Relation {
    let Some(wanted) = Unit::parse(model) else {
        return Relation::Unclear;
    };
    let readings = readings(written);
    let is_clear = |unit: &Unit| unit.unknown_symbols().is_empty();
    let all_clear = is_clear(&wanted) && readings.first().is_some_and(is_clear);
    if (written.is_appended || !all_clear) && is_same(written.text, model) {
        return Relation::Same;
    }
    let mut conversions = readings.iter().map(|unit| unit.conversion_to(&wanted));
    if let Some(conversion) = conversions.find_map(|conversion| conversion) {
        return match conversion.factor().is_one() {
            true => Relation::Same,
            false => Relation::Converted(conversion),
        };
    }
    if readings
        .iter()
        .any(|unit| unit.is_other_temperature_than(&wanted))
    {
        return Relation::OtherZero;
    }
    match readings.first() {
        // `1/s` for `rad/s` is usual; Hz may mean revolutions.
        Some(unit) if unit.agrees_with(&wanted) && unit.is_scaled_like(&wanted) => {
            Relation::Unclear
        }
        Some(_) if all_clear && !written.is_appended => Relation::Other,
        _ => Relation::Unclear,
    }
}

/// What the unit can mean, the likelier first.
fn readings(written: Written<'_>) -> Vec<Unit> {
    let (word, plain) = match written.is_appended {
        true => (letters(written.text), letters(written.text)),
        false => (written.text.to_owned(), written.text.replace("_per_", "/")),
    };
    let plain = Unit::parse(&plain);
    // What is known in brackets is taken by its word; only C may be any of two units there.
    let is_known = |unit: &Unit| unit.unknown_symbols().is_empty();
    let is_open = written.is_appended || word == "C" || !plain.as_ref().is_some_and(is_known);
    let signless = SIGNLESS
        .iter()
        .filter(|(known, _)| is_open && *known == word);
    let signless = signless.filter_map(|(_, unit)| Unit::parse(unit));
    plain.into_iter().chain(signless).collect()
}

fn letters(unit: &str) -> String {
    unit.replace("_per_", "")
        .chars()
        .filter(|c| c.is_alphanumeric() || *c == '%' || *c == '°')
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_one_unit_are_the_same() {
        assert!(is_same("N*m", "Nm") && is_same("rad/s", "rad_per_s") && is_same("m/s^2", "m_s2"));
        assert!(!is_same("rad", "deg") && !is_same("mm", "m") && !is_same("Nm", "nm"));
        assert!(is_usual("rad_per_s") && is_usual("Nm") && !is_usual("meas"));
    }

    #[test]
    fn units_are_converted_where_their_dimension_is_the_same() {
        let relation = |text, is_appended, model| compare(Written { text, is_appended }, model);
        let factor = |text, is_appended, model| match relation(text, is_appended, model) {
            Relation::Converted(conversion) => conversion.factor().to_string(),
            other => format!("{other:?}"),
        };
        assert_eq!(factor("deg", true, "rad"), "pi/180");
        assert_eq!(factor("deg", false, "rad"), "pi/180");
        assert_eq!(factor("degs", true, "rad/s"), "pi/180");
        assert_eq!(factor("rpm", false, "rad/s"), "pi/30");
        assert_eq!(factor("kN*m", false, "Nm"), "1000");
        assert_eq!(factor("ms", true, "mm/s"), "1000");
        assert_eq!(factor("cells/ml", false, "cells/L"), "1000");
        for (text, is_appended, model) in [
            ("Nm", false, "N*m"),
            ("J", false, "N*m"),
            ("rad_per_s", false, "rad/s"),
            ("rad_per_s", true, "rad/s"),
            ("ms", true, "m/s"),
            ("m_s2", true, "m/s^2"),
            ("C", true, "°C"),
            ("C", false, "degC"),
            ("cells", false, "cells"),
        ] {
            assert_eq!(relation(text, is_appended, model), Relation::Same, "{text}");
        }
    }

    #[test]
    fn units_of_another_dimension_are_refused_where_they_are_units_for_certain() {
        let relation = |text, is_appended, model| compare(Written { text, is_appended }, model);
        assert_eq!(relation("N", false, "N*m"), Relation::Other);
        assert_eq!(relation("m*s", false, "m/s"), Relation::Other);
        assert_eq!(relation("deg/s", false, "1/s"), Relation::Other);
        assert_eq!(relation("°C", false, "K"), Relation::OtherZero);
        assert_eq!(relation("C", true, "K"), Relation::OtherZero);
        for (text, is_appended, model) in [
            ("m", true, "N*m"),
            ("motor", false, "N*m"),
            ("%", false, "1"),
            ("Hz", false, "rad/s"),
            ("counts", false, "rad"),
        ] {
            assert_eq!(
                relation(text, is_appended, model),
                Relation::Unclear,
                "{text}"
            );
        }
    }

    #[test]
    fn times_other_than_seconds_are_known() {
        assert!(is_second("s") && is_second("Sec") && !is_second("ms"));
        assert_eq!(in_seconds("ms"), Some("0.001"));
        assert_eq!(in_seconds("s"), None);
    }
}
