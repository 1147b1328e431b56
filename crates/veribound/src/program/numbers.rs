//! Bounds as text for people: rounded outward, and no more digits than tell something.

use veribound_interval::{
    Decimal, Interval, round,
    text::{inside_prior, lower, readable, readable_inside, spelled, upper},
};

/// The interval as text: `[lo, hi]`, rounded outward.
pub fn show(bounds: Interval) -> String {
    if bounds.is_empty() {
        return "none".to_owned();
    }
    in_brackets(readable(bounds))
}

/// A prior as the user spelled it.
pub fn show_prior(prior: Interval) -> String {
    in_brackets(spelled(prior))
}

/// What is proved to lie in `bounds` and, by the user's word, in `prior`: an end at which nothing was
/// cut off is the prior's own.
pub fn show_inside(bounds: Interval, prior: Interval) -> String {
    if bounds.is_empty() {
        return "none".to_owned();
    }
    in_brackets(inside_prior(readable(bounds), bounds, prior))
}

/// From so many times on, what is reached is a point beside what may be.
const POINT: f64 = 1e6;

/// What is proved to be reached, rounded inward, where the outer bounds are `tightness` times as wide at most;
/// nothing where nothing is.
pub fn show_reached(inner: Option<Interval>, tightness: f64) -> String {
    let Some(inner) = inner.filter(|inner| !inner.is_empty()) else {
        return String::new();
    };
    match readable_inside(inner) {
        Some(ends) if inner.is_point() || tightness < POINT => in_brackets(ends),
        // One point, or two so near that no short decimal lies between them.
        _ => format!("about {}", lower(inner.mid(), 6)),
    }
}

/// A time as text for people. One with very many digits is the float of a binary record as a rule: it is shown by the
/// shortest decimal that reads as it. Tables and summaries have all digits.
pub fn show_time(time: &Decimal) -> String {
    let text = time.to_string();
    let near = time.to_interval();
    match text.len() {
        0..=20 => text,
        _ if near.is_point() => near.lo().to_string(),
        _ => format!("about {}", lower(near.mid(), 12)),
    }
}

/// `1 sample`, `2 samples`.
pub fn counted(number: usize, one: &str, many: &str) -> String {
    let what = if number == 1 { one } else { many };
    format!("{number} {what}")
}

/// How many times wider than possible bounds are at most; nothing where that is not known, or one point alone is reached.
pub fn show_times(tightness: f64) -> String {
    if tightness < POINT {
        format!("{} x", upper(tightness, 4))
    } else {
        String::new()
    }
}

fn in_brackets((lo, hi): (String, String)) -> String {
    if lo == hi {
        lo
    } else {
        format!("[{lo}, {hi}]")
    }
}

/// By how much `bounds` are narrower than `prior`, as a percentage rounded down; none where the prior
/// is a point or unbounded.
pub fn shrink(bounds: Interval, prior: Interval) -> Option<String> {
    let whole = round::sub_down(prior.hi(), prior.lo());
    if bounds.is_empty() || !prior.is_bounded() || whole <= 0.0 {
        return None;
    }
    let share = round::sub_down(1.0, round::div_up(bounds.width(), whole));
    // Not `max`: it may keep the sign of a zero.
    let percent = if share > 0.0 {
        round::mul_down(share, 100.0)
    } else {
        0.0
    };
    let decimals = match percent {
        p if p < 99.0 => 0,
        p if p < 99.9 => 1,
        _ => 3,
    };
    let scale = 10_f64.powi(decimals);
    let shown = (percent * scale).floor() / scale;
    Some(format!("{shown:.*} %", decimals as usize))
}

#[cfg(test)]
mod tests {
    use super::*;
    use veribound_interval::Decimal;

    fn enclosed(text: &str) -> Option<Interval> {
        Decimal::parse(text)
            .ok()
            .map(|decimal| decimal.to_interval())
    }

    fn between(lo: &str, hi: &str) -> Interval {
        enclosed(lo).unwrap().hull(enclosed(hi).unwrap())
    }

    #[test]
    fn times_of_binary_records_are_short() {
        let time = |text: &str| show_time(&Decimal::parse(text).unwrap());
        assert_eq!(time("14.990"), "14.99");
        let float = "14.9900000000000002131628207280300557613372802734375";
        assert_eq!(time(float), "14.99");
        assert_eq!(time("0.3333333333333333333333333"), "about 0.333333333333");
    }

    #[test]
    fn few_digits_and_still_outward() {
        assert_eq!(
            show(Interval::new(-2.652_81, -1.537_49).unwrap()),
            "[-2.66, -1.53]"
        );
        assert_eq!(
            show(Interval::new(199.991_21, 200.015_09).unwrap()),
            "[199.9912, 200.0151]"
        );
        assert_eq!(show(Interval::EMPTY), "none");
        assert_eq!(show(Interval::ENTIRE), "[-inf, inf]");
        assert_eq!(show(Interval::ZERO), "0");
    }

    #[test]
    fn what_is_reached_is_not_shown_wider() {
        let of = |lo, hi| show_reached(Interval::new(lo, hi), 1.5);
        assert_eq!(of(-2.652_81, -1.537_49), "[-2.65, -1.54]");
        assert_eq!(of(199.991_21, 200.015_09), "[199.9913, 200.015]");
        assert_eq!(of(0.5, 0.5), "0.5");
        assert_eq!(of(0.1, 0.1), "about 0.1");
        assert_eq!(show_reached(None, 1.5), "");
        let two = Interval::new(-0.000_599_999_2, -0.000_599_997_4);
        assert_eq!(show_reached(two, 1.1e8), "about -0.000599999");
        assert_eq!(show_times(1.1e8), "");
        assert_eq!(show_times(1.041_23), "1.042 x");
        assert_eq!(show_times(f64::INFINITY), "");
    }

    #[test]
    fn priors_are_shown_as_they_were_written() {
        let prior = between("-6", "-0.05");
        assert_eq!(show_prior(prior), "[-6, -0.05]");
        let cut = Interval::new(-2.5, prior.hi()).unwrap();
        assert_eq!(show_inside(cut, prior), "[-2.5, -0.05]");
    }

    #[test]
    fn a_shrink_is_never_too_large() {
        let prior = between("0", "0.3");
        assert_eq!(
            shrink(between("0.14", "0.16"), prior).as_deref(),
            Some("93 %")
        );
        assert_eq!(shrink(prior, prior).as_deref(), Some("0 %"));
        let prior = Interval::new(0.0, 1000.0).unwrap();
        let narrow = Interval::new(1.0, 1.0006).unwrap();
        assert_eq!(shrink(narrow, prior).as_deref(), Some("99.999 %"));
        assert_eq!(shrink(narrow, Interval::ONE), None);
        assert_eq!(shrink(Interval::EMPTY, prior), None);
    }
}
