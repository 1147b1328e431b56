use super::*;
use veribound_interval::{Decimal, Interval};

fn unit(text: &str) -> Unit {
    Unit::read(text).unwrap()
}

/// The factor from one unit to another, as it is shown.
fn factor(from: &str, to: &str) -> String {
    let conversion = unit(from).conversion_to(&unit(to));
    conversion.map_or("none".to_owned(), |conversion| {
        conversion.factor().to_string()
    })
}

#[test]
fn known_units_have_their_exact_factors() {
    for (from, to, expected) in [
        ("N", "kg*m/s^2", "1"),
        ("J", "N*m", "1"),
        ("W", "J/s", "1"),
        ("Pa", "N/m^2", "1"),
        ("Hz", "1/s", "1"),
        ("V", "W/A", "1"),
        ("Ohm", "V/A", "1"),
        ("Ω", "ohm", "1"),
        ("C", "A*s", "1"),
        ("F", "C/V", "1"),
        ("S", "1/Ohm", "1"),
        ("Wb", "V*s", "1"),
        ("T", "Wb/m^2", "1"),
        ("H", "Wb/A", "1"),
        ("g", "kg", "1/1000"),
        ("mg", "g", "1/1000"),
        ("t", "kg", "1000"),
        ("L", "m^3", "1/1000"),
        ("ml", "cm^3", "1"),
        ("bar", "kPa", "100"),
        ("mbar", "hPa", "1"),
        ("min", "s", "60"),
        ("h", "min", "60"),
        ("d", "h", "24"),
        ("ms", "µs", "1000"),
        ("um", "μm", "1"),
        ("nm", "m", "1/1e9"),
        ("GHz", "1/ns", "1"),
        ("TW", "fW", "1e27"),
        ("km/h", "m/s", "5/18"),
        ("deg", "rad", "pi/180"),
        ("°", "deg", "1"),
        ("rad", "deg", "180/pi"),
        ("rad^2", "deg^2", "32400/pi^2"),
        ("mrad", "deg", "9/(50*pi)"),
        ("rev", "rad", "2*pi"),
        ("rpm", "rad/s", "pi/30"),
        ("rpm", "deg/s", "6"),
        ("rev/min", "rpm", "1"),
        ("Nm", "N*m", "1"),
        ("mNm", "Nmm", "1"),
        ("kWh", "MJ", "18/5"),
        ("Ah", "C", "3600"),
        ("1/kg*m", "m/kg", "1"),
        ("W/(m^2*°C)", "W/(m^2*K)", "1"),
        ("°F/s", "K/s", "5/9"),
        ("cells/ml", "cells/L", "1000"),
        ("degC", "°C", "1"),
        // No conversion: other dimensions, other zeros.
        ("°C", "K", "none"),
        ("°C", "°F", "none"),
        ("rad/s", "Hz", "none"),
        ("cells", "counts", "none"),
        ("pH", "H", "none"),
        ("m/s", "m*s", "none"),
    ] {
        assert_eq!(factor(from, to), expected, "{from} to {to}");
    }
}

#[test]
fn the_radian_is_told_apart_only_where_it_is_asked_for() {
    let (torque, stiffness) = (unit("N*m"), unit("N*m/rad"));
    assert!(torque.agrees_with(&stiffness) && !torque.has_dimension_of(&stiffness));
    assert!(!unit("m").agrees_with(&unit("rad")));
}

#[test]
fn units_are_spelled_with_the_symbols_they_were_written_with() {
    assert_eq!(unit("1/(kg*m^2)").spell(), "1/(kg*m^2)");
    assert_eq!(unit("rad/s/s").spell(), "rad/s^2");
    assert_eq!(unit("m*s/m").spell(), "s");
    assert_eq!(unit("(N*m)^2").spell_dimension(), "kg^2*m^4/s^4");
    let root = unit("m").power(Ratio::new(1, 2)).unwrap();
    assert_eq!(root.spell(), "m^(1/2)");
    assert_eq!(unit("cm^2").power(Ratio::new(1, 2)).unwrap(), unit("cm"));
    assert_eq!(unit("km").power(Ratio::new(1, 2)).unwrap().scale(), None);
}

#[test]
fn powers_out_of_all_proportion_are_refused() {
    for text in ["m^1001", "m^500*m^501", "m^600*s^600", "((km^10)^10)^11"] {
        assert_eq!(Unit::parse(text), None, "{text}");
    }
    assert!(Unit::parse("Gm^1000").is_some());
    assert_eq!(unit("m").power(Ratio::new(1, 65)), None);
    assert_eq!(unit("m^600").times(&unit("m^600")), None);
}

/// 60 digits of pi, rounded down and up.
const PI: (&str, &str) = (
    "3.14159265358979323846264338327950288419716939937510582097494",
    "3.14159265358979323846264338327950288419716939937510582097495",
);

fn pseudo_random_decimals() -> impl Iterator<Item = Decimal> {
    let mut state = 7_u64;
    (0..2000).map(move |_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let (digits, sign) = (state >> 20, if state & 1 == 0 { "" } else { "-" });
        let exponent = (state >> 5) % 60;
        Decimal::parse(&format!("{sign}{digits}e-{exponent}")).unwrap()
    })
}

/// Whether `wide` contains every number between two exact ones.
fn contains(wide: Interval, ends: &[num_rational::BigRational; 2]) -> bool {
    let exact = |x: f64| num_rational::BigRational::from_float(x).unwrap();
    ends.iter()
        .all(|end| exact(wide.lo()) <= *end && *end <= exact(wide.hi()))
}

#[test]
fn converted_numbers_are_enclosed() {
    let (below, above) = (Decimal::parse(PI.0).unwrap(), Decimal::parse(PI.1).unwrap());
    for (from, to, numerator, denominator, pi) in [
        ("deg", "rad", 1, 180, 1),
        ("rad", "deg", 180, 1, -1),
        ("rpm", "rad/s", 1, 30, 1),
        ("rad^2", "deg^2", 32400, 1, -2),
        ("km/h", "m/s", 5, 18, 0),
        ("mm", "m", 1, 1000, 0),
    ] {
        let conversion = unit(from).conversion_to(&unit(to)).unwrap();
        let rational = num_rational::BigRational::new(numerator.into(), denominator.into());
        for number in pseudo_random_decimals() {
            let ends = [&below, &above]
                .map(|bound| number.to_rational() * &rational * bound.to_rational().pow(pi));
            let enclosure = conversion.apply(&number);
            assert!(contains(enclosure, &ends), "{number} {from}: {enclosure}");
            let steps = 2 + 6 * pi.unsigned_abs() as usize;
            let narrow = (0..steps).fold(enclosure.lo(), |x, _| x.next_up());
            assert!(enclosure.hi() <= narrow, "{number} {from}: {enclosure}");
        }
    }
}

#[test]
fn a_conversion_by_a_rational_factor_is_the_decimal_it_gives() {
    let conversion = unit("mm").conversion_to(&unit("m")).unwrap();
    let (written, meant) = (
        Decimal::parse("12.34").unwrap(),
        Decimal::parse("0.01234").unwrap(),
    );
    assert_eq!(conversion.apply(&written), meant.to_interval());
}
