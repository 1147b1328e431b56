//! Axes: the range they show, and ticks at steps of 1, 2 or 5 with exact decimal labels.

use crate::svg::text_width;

/// A tick: its value in the units of the axis, and its label.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    pub value: f64,
    pub label: Label,
}

/// How a tick is labelled.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Label {
    Text(String),
    PowerOfTen(i32),
    None,
}

impl Label {
    pub fn width(&self, size: f64) -> f64 {
        match self {
            Self::Text(text) => text_width(text, size),
            Self::PowerOfTen(e) => text_width("10", size) + text_width(&e.to_string(), 0.72 * size),
            Self::None => 0.0,
        }
    }
}

/// A finite range of values mapped onto [0, 1], linearly or by the logarithm.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    lo: f64,
    hi: f64,
    logarithmic: bool,
    pub ticks: Vec<Tick>,
    /// All labels are to be multiplied by ten to this power.
    pub exponent: i32,
}

/// Room for tick labels along an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// Length of the axis in SVG units.
    pub length: f64,
    /// Least distance between two ticks in SVG units.
    pub spacing: f64,
    /// Size of the labels, where they stand side by side and need their own width; 0 otherwise.
    pub font: f64,
}

/// Values beyond this are drawn at the edge, so that differences cannot overflow.
const FAR: f64 = 1e300;

impl Axis {
    /// A linear axis from lo to hi; a range too short to be labelled is made longer.
    pub fn linear(lo: f64, hi: f64, room: Room) -> Self {
        let (lo, hi) = widen(lo.clamp(-FAR, FAR), hi.clamp(-FAR, FAR));
        let exponent = common_exponent(lo, hi);
        let mut step = Step::at_least((hi - lo) * room.spacing / room.length.max(1.0));
        let mut ticks = step.ticks(lo, hi, exponent);
        // Labels side by side may not touch: go to longer steps until the widest one fits.
        let between = |step: Step| step.value() / (hi - lo) * room.length;
        while ticks.len() > 1 && between(step) < widest(&ticks, room.font) + room.font {
            step = step.next();
            ticks = step.ticks(lo, hi, exponent);
        }
        Self {
            lo,
            hi,
            logarithmic: false,
            ticks,
            exponent,
        }
    }

    /// A logarithmic axis over 0 < lo <= hi, from the full decade below to a little above.
    pub fn logarithmic(lo: f64, hi: f64, room: Room) -> Self {
        let lo = lo.clamp(1e-300, FAR);
        let hi = hi.clamp(lo, FAR);
        let first = lo.log10().floor() as i32;
        let hi = (1.5 * hi).max(2.0 * power(first));
        let last = hi.log10().floor() as i32;
        let most = ((room.length / room.spacing) as i32).max(1);
        let every = (last - first) / most + 1;
        let plain = first >= -3 && last <= 4;
        let ticks = (first..=last)
            .map(|e| Tick {
                value: power(e),
                label: match ((e - first) % every, plain) {
                    (0, true) => Label::Text(decimal(1, e)),
                    (0, false) => Label::PowerOfTen(e),
                    _ => Label::None,
                },
            })
            .collect();
        Self {
            lo: power(first),
            hi,
            logarithmic: true,
            ticks,
            exponent: 0,
        }
    }

    /// Where a value lies: 0 at the axis' beginning, 1 at its end; a little beyond for values
    /// outside, however far they are. Monotone.
    pub fn position(&self, value: f64) -> f64 {
        let part = if self.logarithmic {
            let value = if value > 0.0 {
                value
            } else {
                f64::MIN_POSITIVE
            };
            (value.log10() - self.lo.log10()) / (self.hi.log10() - self.lo.log10())
        } else {
            (value.clamp(-FAR, FAR) - self.lo) / (self.hi - self.lo)
        };
        part.clamp(-0.1, 1.1)
    }

    /// The finite range shown.
    pub fn range(&self) -> (f64, f64) {
        (self.lo, self.hi)
    }

    /// The width of the widest label.
    pub fn label_width(&self, size: f64) -> f64 {
        widest(&self.ticks, size)
    }

    /// The same axis, without labels.
    pub fn unlabelled(mut self) -> Self {
        for tick in &mut self.ticks {
            tick.label = Label::None;
        }
        self.exponent = 0;
        self
    }
}

fn widest(ticks: &[Tick], size: f64) -> f64 {
    ticks
        .iter()
        .map(|tick| tick.label.width(size))
        .fold(0.0, f64::max)
}

/// The range, at least 10^-9 of its own distance from zero long.
fn widen(lo: f64, hi: f64) -> (f64, f64) {
    let (lo, hi) = if lo <= hi { (lo, hi) } else { (0.0, 1.0) };
    let size = lo.abs().max(hi.abs());
    let least = if size == 0.0 {
        1.0
    } else {
        (size * 1e-9).max(1e-290)
    };
    if hi - lo >= least {
        return (lo, hi);
    }
    let more = if hi == lo {
        (0.1 * size).max(least)
    } else {
        least
    };
    (lo - more / 2.0, hi + more / 2.0)
}

/// The power of ten to take out of the labels: none for numbers that read well as they are, or
/// whose leading digits are the same all along the axis.
fn common_exponent(lo: f64, hi: f64) -> i32 {
    let size = lo.abs().max(hi.abs());
    if hi - lo < size / 100.0 || (1e-3..1e5).contains(&size) || size == 0.0 {
        return 0;
    }
    (size.log10().floor() as i32).div_euclid(3) * 3
}

/// A tick distance: 1, 2 or 5 times a power of ten.
#[derive(Clone, Copy, Debug)]
struct Step {
    digit: i64,
    exponent: i32,
}

impl Step {
    /// The smallest step not below the wish.
    fn at_least(wish: f64) -> Self {
        let wish = wish.max(1e-300);
        let mut step = Self {
            digit: 1,
            exponent: wish.log10().floor() as i32,
        };
        while step.value() < wish {
            step = step.next();
        }
        step
    }

    fn next(self) -> Self {
        match self.digit {
            1 => Self { digit: 2, ..self },
            2 => Self { digit: 5, ..self },
            _ => Self {
                digit: 1,
                exponent: self.exponent + 1,
            },
        }
    }

    fn value(self) -> f64 {
        self.digit as f64 * power(self.exponent)
    }

    /// All multiples of the step in [lo, hi], labelled as decimals times 10^-exponent.
    fn ticks(self, lo: f64, hi: f64, exponent: i32) -> Vec<Tick> {
        let value = self.value();
        let first = (lo / value - 1e-6).ceil() as i64;
        let last = (hi / value + 1e-6).floor() as i64;
        (first..=last.min(first.saturating_add(100)))
            .map(|k| Tick {
                value: k as f64 * value,
                label: Label::Text(decimal(
                    k.saturating_mul(self.digit),
                    self.exponent - exponent,
                )),
            })
            .collect()
    }
}

/// Ten to a power, as near as the decimal spelling is read.
fn power(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(f64::MAX)
}

/// The exact decimal `number * 10^exponent`, with a true minus sign.
fn decimal(number: i64, exponent: i32) -> String {
    let digits = number.unsigned_abs().to_string();
    let sign = if number < 0 { "\u{2212}" } else { "" };
    if number == 0 {
        return "0".to_owned();
    }
    if exponent >= 0 {
        return format!("{sign}{digits}{}", "0".repeat(exponent as usize));
    }
    let places = exponent.unsigned_abs() as usize;
    let digits = format!("{digits:0>width$}", width = places + 1);
    let (whole, rest) = digits.split_at(digits.len() - places);
    format!("{sign}{whole}.{rest}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Room = Room {
        length: 500.0,
        spacing: 60.0,
        font: 11.0,
    };

    fn labels(axis: &Axis) -> Vec<String> {
        let text = |tick: &Tick| match &tick.label {
            Label::Text(text) => text.clone(),
            Label::PowerOfTen(e) => format!("10^{e}"),
            Label::None => String::new(),
        };
        axis.ticks.iter().map(text).collect()
    }

    #[test]
    fn steps_are_one_two_or_five() {
        assert_eq!(
            labels(&Axis::linear(0.0, 80.0, ROOM)),
            ["0", "10", "20", "30", "40", "50", "60", "70", "80"]
        );
        let axis = Axis::linear(32.6, 32.9, ROOM);
        assert_eq!(
            labels(&axis),
            [
                "32.60", "32.65", "32.70", "32.75", "32.80", "32.85", "32.90"
            ]
        );
        assert_eq!(
            labels(&Axis::linear(-6.0, -0.05, ROOM)),
            [
                "\u{2212}6",
                "\u{2212}5",
                "\u{2212}4",
                "\u{2212}3",
                "\u{2212}2",
                "\u{2212}1"
            ]
        );
    }

    #[test]
    fn long_labels_do_not_touch() {
        let axis = Axis::linear(1_700_000_000.0, 1_700_000_080.0, ROOM);
        assert_eq!(axis.exponent, 0);
        let gap = 500.0 * (axis.ticks[1].value - axis.ticks[0].value) / 80.0;
        assert!(gap >= axis.label_width(11.0) + 11.0);
    }

    #[test]
    fn large_and_small_numbers_share_a_power_of_ten() {
        let axis = Axis::linear(0.0, 4e-5, ROOM);
        assert_eq!(
            (axis.exponent, labels(&axis).pop().unwrap().as_str()),
            (-6, "40")
        );
        assert_eq!(Axis::linear(-2e6, 2e6, ROOM).exponent, 6);
    }

    #[test]
    fn every_range_has_an_axis() {
        let big = f64::MAX;
        for (lo, hi) in [
            (0.0, 0.0),
            (5.0, 5.0),
            (-big, big),
            (1.0, 1.0 + 1e-16),
            (0.0, 5e-324),
            (3.0, 2.0),
        ] {
            let axis = Axis::linear(lo, hi, ROOM);
            let (from, to) = axis.range();
            assert!(from < to && from.is_finite() && to.is_finite());
            assert!((-0.1..=1.1).contains(&axis.position(lo)));
            assert!(
                axis.ticks.len() < 20,
                "{lo} {hi}: {} ticks",
                axis.ticks.len()
            );
        }
    }

    #[test]
    fn infinite_values_lie_at_the_ends() {
        let axis = Axis::linear(0.0, 1.0, ROOM);
        assert_eq!(axis.position(f64::NEG_INFINITY), -0.1);
        assert_eq!(axis.position(f64::INFINITY), 1.1);
        let axis = Axis::logarithmic(0.02, 30.0, ROOM);
        assert_eq!(labels(&axis), ["0.01", "0.1", "1", "10"]);
        assert_eq!(axis.position(0.0), -0.1);
    }
}
