//! Contract of the public interface, by example.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use veribound_interval::{Decimal, Interval, Regularity, Truth, domain, self_test, text};

fn interval(lo: f64, hi: f64) -> Interval {
    Interval::new(lo, hi).unwrap()
}

#[test]
fn this_machine_passes_the_self_test() {
    self_test().unwrap();
}

#[test]
fn ends_that_are_no_interval_are_refused() {
    for (lo, hi) in [
        (f64::NAN, 1.0),
        (1.0, f64::NAN),
        (2.0, 1.0),
        (f64::INFINITY, f64::INFINITY),
        (f64::NEG_INFINITY, f64::NEG_INFINITY),
    ] {
        assert_eq!(Interval::new(lo, hi), None);
    }
    assert_eq!(Interval::point(f64::NAN), Interval::ENTIRE);
    assert_eq!(Interval::point(f64::INFINITY).lo(), f64::MAX);
}

#[test]
fn one_tenth_is_enclosed_by_two_neighbours() {
    let tenth = Decimal::parse("0.1").unwrap().to_interval();
    assert_eq!(tenth, interval(0.1_f64.next_down(), 0.1));
    assert_eq!(tenth, interval(tenth.lo(), tenth.lo().next_up()));
}

#[test]
fn text_is_rounded_outward() {
    assert_eq!(text::lower(0.1, 3), "0.1");
    assert_eq!(text::upper(0.1, 3), "0.101");
    assert_eq!(text::lower(-0.1, 3), "-0.101");
    assert_eq!(text::upper(-0.1, 3), "-0.1");
    assert_eq!(text::upper(9.999, 2), "10");
    assert_eq!(text::upper(f64::MAX, 2), "1.8e308");
    assert_eq!(text::lower(f64::from_bits(1), 3), "4.94e-324");
    assert_eq!(
        format!("{:.3}", interval(-1.0 / 3.0, 250.0)),
        "[-0.334, 250]"
    );
    assert_eq!(format!("{}", Interval::EMPTY), "[empty]");
    assert_eq!(format!("{}", Interval::ENTIRE), "[-inf, inf]");
}

#[test]
fn wide_and_special_arguments() {
    let x = interval(-1.0, 2.0);
    assert_eq!(x.sqr(), interval(0.0, 4.0));
    assert_eq!(x.powi(3), interval(-1.0, 8.0));
    assert_eq!(interval(-2.0, 1.0).powi(3), interval(-8.0, 1.0));
    assert_eq!(x / Interval::ZERO, Interval::EMPTY);
    assert_eq!(Interval::ONE / interval(-1.0, 1.0), Interval::ENTIRE);
    assert_eq!(
        Interval::ONE / interval(0.0, 2.0),
        interval(0.5, f64::INFINITY)
    );
    assert_eq!(interval(0.0, 4.0).sign(), interval(-1.0, 1.0));
    assert_eq!(interval(-4.0, -1.0).sqrt(), Interval::EMPTY);
    assert_eq!(interval(0.0, 7.0).sin(), interval(-1.0, 1.0));
    assert_eq!(interval(1.0, 2.0).tan(), Interval::ENTIRE);
    assert_eq!(domain::tan(interval(1.0, 2.0)), Regularity::Undefined);
    assert_eq!(interval(0.0, 0.0).cos(), Interval::ONE);
    assert_eq!(interval(-0.5, 0.25).cos().hi(), 1.0);
}

#[test]
fn reverse_product_with_zero_inside_the_factor() {
    let b = interval(-1.0, 2.0);
    let c = interval(4.0, 8.0);
    assert_eq!(
        Interval::mul_rev(b, c, interval(-3.0, 100.0)),
        interval(2.0, 100.0)
    );
    assert_eq!(
        Interval::mul_rev(b, c, interval(-3.0, 1.0)),
        Interval::EMPTY
    );
    assert_eq!(Interval::mul_rev(b, Interval::ZERO, c), c);
}

#[test]
fn comparisons_claim_only_what_is_proved() {
    let (a, b) = (interval(0.0, 1.0), interval(1.0, 2.0));
    assert_eq!(a.less(b), Truth::Unknown);
    assert_eq!(a.less_equal(b), Truth::True);
    assert_eq!(b.less(a), Truth::False);
    assert_eq!(a.equal(b), Truth::Unknown);
    assert_eq!(Interval::ONE.equal(Interval::ONE), Truth::True);
    assert_eq!(Interval::EMPTY.less(a), Truth::Unknown);
    assert_eq!(Interval::EMPTY.less_equal(a), Truth::Unknown);
}
