//! Bounds as the user wrote them.

use veribound_interval::{Decimal, Interval, text};

/// Bounds in the shortest decimals whose enclosure they are: what a user wrote as `[-6.0, -0.05]`
/// and was enclosed outward is `[-6, -0.05]` again. Other bounds are rounded outward.
pub(crate) fn spell(interval: Interval) -> String {
    if interval.is_empty() {
        return "[empty]".to_string();
    }
    let lo = shortest(interval.lo(), interval.lo().next_up(), |d| {
        d.to_interval().lo()
    })
    .unwrap_or_else(|| text::lower(interval.lo(), 17));
    let hi = shortest(interval.hi(), interval.hi().next_down(), |d| {
        d.to_interval().hi()
    })
    .unwrap_or_else(|| text::upper(interval.hi(), 17));
    if lo == hi {
        lo
    } else {
        format!("[{lo}, {hi}]")
    }
}

/// The shortest decimal near `end` whose enclosure ends at `end`; `inside` is the next float inward.
fn shortest(end: f64, inside: f64, enclosure_end: impl Fn(&Decimal) -> f64) -> Option<String> {
    // Minus zero is written as zero.
    [end, inside]
        .into_iter()
        .filter(|x| x.is_finite())
        .filter_map(|x| {
            // The shortest text of a float is only a guess here; the check below is exact.
            let x = if x == 0.0 { 0.0 } else { x };
            let plain = if x == 0.0 || (1e-4..1e9).contains(&x.abs()) {
                format!("{x}")
            } else {
                format!("{x:e}")
            };
            let decimal = Decimal::parse(&plain).ok()?;
            (enclosure_end(&decimal) == end).then_some(plain)
        })
        .min_by_key(String::len)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_spelled_as_written() {
        for (lo, hi) in [
            ("-6", "-0.05"),
            ("0.08", "0.35"),
            ("1e-9", "0.1"),
            ("-0.2", "0.7"),
        ] {
            let (a, b) = (Decimal::parse(lo).unwrap(), Decimal::parse(hi).unwrap());
            let spelled = spell(a.to_interval().hull(b.to_interval()));
            assert_eq!(spelled, format!("[{lo}, {hi}]"));
        }
        assert_eq!(spell(Interval::ZERO), "0");
        assert_eq!(spell(Interval::new(-0.0, 2.0).unwrap()), "[0, 2]");
        assert_eq!(spell(Decimal::parse("0.1").unwrap().to_interval()), "0.1");
    }
}
