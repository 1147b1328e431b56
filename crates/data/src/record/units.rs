//! Units as headers spell them: only texts are compared here, numbers are taken as they are.

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
    fn times_other_than_seconds_are_known() {
        assert!(is_second("s") && is_second("Sec") && !is_second("ms"));
        assert_eq!(in_seconds("ms"), Some("0.001"));
        assert_eq!(in_seconds("s"), None);
    }
}
