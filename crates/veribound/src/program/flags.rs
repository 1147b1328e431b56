//! Values of flags: one type for each, with its grammar.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;
use veribound_interval::Decimal;
use veribound_model::Hold;

/// A number on the command line, taken as the decimal it spells.
pub fn decimal(text: &str) -> Result<Decimal, String> {
    Decimal::parse(text).map_err(|error| format!("expected a number, as in 0.1: {error}"))
}

/// A whole number in a range.
pub fn whole<N: FromStr + PartialOrd + fmt::Display>(
    text: &str,
    least: N,
    most: N,
) -> Result<N, String> {
    match text.parse::<N>() {
        Ok(count) if (&least..=&most).contains(&&count) => Ok(count),
        _ => Err(format!("expected a whole number from {least} to {most}")),
    }
}

/// A whole number.
pub fn any_count(text: &str) -> Result<u64, String> {
    whole(text, 0, u64::MAX)
}

/// A setting that is a number above zero.
pub fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number above 0".to_owned()),
    }
}

/// A setting that is a number from zero on.
pub fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number from 0 on".to_owned()),
    }
}

/// How many times wider than the best something may be: a number above 1.
pub fn times(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 1.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number above 1, as in 1.05".to_owned()),
    }
}

/// `VARIABLE=COLUMN`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ColumnFlag {
    /// Variable of the model.
    pub variable: String,
    /// Column of the record.
    pub column: String,
}

impl FromStr for ColumnFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((variable, column))
                if !variable.trim().is_empty() && !column.trim().is_empty() =>
            {
                Ok(ColumnFlag {
                    variable: variable.trim().to_owned(),
                    column: column.trim().to_owned(),
                })
            }
            _ => Err("expected VARIABLE=COLUMN, as in phi_m=angle_rad".to_owned()),
        }
    }
}

/// `PARAM@SIGNAL`, `PARAM@SIGNAL:SECONDS` or `PARAM@EVENT`.
#[derive(Debug, Clone, PartialEq)]
pub struct ResetFlag {
    /// As typed.
    pub text: String,
    /// Where the parameter's name is in it.
    pub param: Range<usize>,
    /// Where the name of the signal or event is in it.
    pub trigger: Range<usize>,
    /// How long the signal must have been true.
    pub lasts: Option<Decimal>,
}

impl FromStr for ResetFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "expected PARAM@SIGNAL:SECONDS, as in T_Fs@still:0.2";
        let at = text.find('@').ok_or(wanted)?;
        let end = text
            .rfind(':')
            .filter(|colon| *colon > at)
            .unwrap_or(text.len());
        let lasts = match text.get(end + 1..) {
            None => None,
            Some(seconds) => {
                let seconds = decimal(seconds)?;
                if seconds.is_negative() {
                    return Err("a signal cannot last for less than 0 s".to_owned());
                }
                Some(seconds)
            }
        };
        if at == 0 || end == at + 1 {
            return Err(wanted.to_owned());
        }
        Ok(ResetFlag {
            text: text.to_owned(),
            param: 0..at,
            trigger: at + 1..end,
            lasts,
        })
    }
}

/// `NAME=10%` or `NAME=0.02`.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBoundFlag {
    /// As typed.
    pub text: String,
    /// Name of the input or output.
    pub name: String,
    /// The bound, a share for a relative one.
    pub bound: Decimal,
    /// Whether the bound is a share of the recorded value.
    pub is_relative: bool,
}

impl FromStr for ErrorBoundFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "expected NAME=BOUND, as in u=10% or u=0.02";
        let (name, bound) = text.split_once('=').ok_or(wanted)?;
        let name = name.trim();
        if name.is_empty() {
            return Err(wanted.to_owned());
        }
        let (bound, is_relative) = percent_or_number(bound.trim())?;
        if bound.is_negative() {
            return Err("an error bound cannot be negative".to_owned());
        }
        Ok(ErrorBoundFlag {
            text: text.to_owned(),
            name: name.to_owned(),
            bound,
            is_relative,
        })
    }
}

/// `NAME=10%`, or `NAME=10%@level` where the error is constant as long as the recorded value stays the same;
/// `@sample` where it is from each sample to the next.
#[derive(Debug, Clone, PartialEq)]
pub struct InputErrorFlag {
    /// As typed.
    pub text: String,
    /// Name and bound.
    pub error: ErrorBoundFlag,
    /// How long the error stays the same.
    pub hold: Hold,
}

impl FromStr for InputErrorFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (error, hold) = match text.split_once('@') {
            None => (text, Hold::Free),
            Some((error, "sample")) => (error, Hold::Sample),
            Some((error, "level")) => (error, Hold::Level),
            Some(_) => {
                return Err(
                    "expected @level or @sample behind the bound, as in u=10%@level".to_owned(),
                );
            }
        };
        Ok(InputErrorFlag {
            text: text.to_owned(),
            error: error.parse()?,
            hold,
        })
    }
}

/// `10%` as 0.1, exactly, or `0.02`; and whether it was a percentage.
fn percent_or_number(text: &str) -> Result<(Decimal, bool), String> {
    let Some(number) = text.strip_suffix('%').map(str::trim_end) else {
        return Ok((decimal(text)?, false));
    };
    decimal(number)?;
    // A percent sign is two decimal places.
    match number.split_once(['e', 'E']) {
        None => Ok((decimal(&format!("{number}e-2"))?, true)),
        Some(_) => Err("write percent without an exponent, as in 10%".to_owned()),
    }
}

/// A part of a whole, as `1%` or `0.01`.
#[derive(Debug, Clone, PartialEq)]
pub struct ShareFlag(pub Decimal);

impl fmt::Display for ShareFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl FromStr for ShareFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (share, _) = percent_or_number(text.trim())?;
        let one = decimal("1")?;
        if share <= Decimal::zero() || share > one {
            return Err("expected a share above 0 and up to 100%, as in 1% or 0.01".to_owned());
        }
        Ok(ShareFlag(share))
    }
}

/// `T0..T1`, `auto` or `off`.
#[derive(Debug, Clone, PartialEq)]
pub enum ZoomFlag {
    /// The program chooses.
    Auto,
    /// No enlargement.
    Off,
    /// From the first to the second time.
    Window(Decimal, Decimal),
}

impl fmt::Display for ZoomFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ZoomFlag::Auto => f.write_str("auto"),
            ZoomFlag::Off => f.write_str("off"),
            ZoomFlag::Window(from, to) => write!(f, "{from}..{to}"),
        }
    }
}

impl FromStr for ZoomFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => return Ok(ZoomFlag::Auto),
            "off" => return Ok(ZoomFlag::Off),
            _ => {}
        }
        let wanted = "expected FROM..TO in seconds, as in 32.6..32.9, or auto, or off";
        let (from, to) = text.split_once("..").ok_or(wanted)?;
        let (from, to) = (decimal(from)?, decimal(to)?);
        if from >= to {
            return Err("the first time must be before the second".to_owned());
        }
        Ok(ZoomFlag::Window(from, to))
    }
}

/// `X,Y`, `auto` or `off`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PlaneFlag {
    /// The program chooses.
    Auto,
    /// No phase plane.
    Off,
    /// Two states by their names.
    States(String, String),
}

impl fmt::Display for PlaneFlag {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PlaneFlag::Auto => f.write_str("auto"),
            PlaneFlag::Off => f.write_str("off"),
            PlaneFlag::States(x, y) => write!(f, "{x},{y}"),
        }
    }
}

impl FromStr for PlaneFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => return Ok(PlaneFlag::Auto),
            "off" => return Ok(PlaneFlag::Off),
            _ => {}
        }
        match text.split_once(',') {
            Some((x, y)) if !x.trim().is_empty() && !y.trim().is_empty() => {
                Ok(PlaneFlag::States(x.trim().to_owned(), y.trim().to_owned()))
            }
            _ => Err("expected two states, as in x,v, or auto, or off".to_owned()),
        }
    }
}

/// `NAME=VALUE,NAME=VALUE`: one entry of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// Name of the quantity.
    pub name: String,
    /// Its value.
    pub value: Decimal,
}

impl FromStr for Assignment {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "expected NAME=VALUE, as in alpha=-2";
        let (name, value) = text.split_once('=').ok_or(wanted)?;
        if name.trim().is_empty() {
            return Err(wanted.to_owned());
        }
        Ok(Assignment {
            name: name.trim().to_owned(),
            value: decimal(value.trim())?,
        })
    }
}

/// `BOUND` or `worst`.
#[derive(Debug, Clone, PartialEq)]
pub enum ErrorFlag {
    /// Errors anywhere inside this bound.
    Within(Decimal),
    /// Errors at the end of the model's bound, with random signs.
    Worst,
}

impl FromStr for ErrorFlag {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "worst" {
            return Ok(ErrorFlag::Worst);
        }
        let bound = decimal(text)?;
        if bound.is_negative() {
            return Err("an error bound cannot be negative".to_owned());
        }
        Ok(ErrorFlag::Within(bound))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(text: &str) -> Decimal {
        Decimal::parse(text).unwrap()
    }

    #[test]
    fn a_reset_names_parameter_trigger_and_time() {
        let flag: ResetFlag = "T_Fs@still:0.2".parse().unwrap();
        assert_eq!(&flag.text[flag.param.clone()], "T_Fs");
        assert_eq!(&flag.text[flag.trigger.clone()], "still");
        assert_eq!(flag.lasts, Some(number("0.2")));
        let flag: ResetFlag = "T_Fs@standstill".parse().unwrap();
        assert_eq!(&flag.text[flag.trigger.clone()], "standstill");
        assert_eq!(flag.lasts, None);
        for wrong in [
            "T_Fs",
            "@still",
            "T_Fs@",
            "T_Fs@:1",
            "T_Fs@still:",
            "T_Fs@still:-1",
        ] {
            assert!(wrong.parse::<ResetFlag>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn percent_is_exact() {
        let flag: ErrorBoundFlag = "u=10%".parse().unwrap();
        assert!(flag.is_relative);
        assert_eq!(flag.bound, number("0.1"));
        let held: InputErrorFlag = "u=10%@level".parse().unwrap();
        assert_eq!((&held.error, held.hold), (&flag, Hold::Level));
        assert!("u=10%@".parse::<InputErrorFlag>().is_err());
        let flag: ErrorBoundFlag = "u = 0.02".parse().unwrap();
        assert!(!flag.is_relative);
        assert_eq!(flag.bound, number("0.02"));
        for wrong in ["u", "=1", "u=x", "u=-1%", "u=1e1%", "u=nan", "u=%"] {
            assert!(wrong.parse::<ErrorBoundFlag>().is_err(), "{wrong}");
        }
        let share = |text: &str| text.parse::<ShareFlag>().map(|share| share.0);
        assert_eq!(share("1%"), Ok(number("0.01")));
        assert_eq!(share("0.5 %"), Ok(number("0.005")));
        assert_eq!(share("1"), Ok(number("1")));
        for wrong in ["0", "-1%", "101%", "1e1%", "x", "%", ""] {
            assert!(share(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn nothing_is_tighter_than_the_best() {
        assert_eq!(times("1.05"), Ok(1.05));
        for wrong in ["1", "0.9", "-2", "inf", "nan", "x", ""] {
            assert!(times(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_window_runs_forward() {
        let window = ZoomFlag::Window(number("32.6"), number("32.9"));
        assert_eq!(window.to_string(), "32.6..32.9");
        assert_eq!("32.6..32.9".parse::<ZoomFlag>(), Ok(window));
        assert_eq!("auto".parse::<ZoomFlag>(), Ok(ZoomFlag::Auto));
        assert!("2..1".parse::<ZoomFlag>().is_err());
        assert!("2-3".parse::<ZoomFlag>().is_err());
    }

    #[test]
    fn values_and_errors_are_decimals() {
        let one: Assignment = "alpha=-2".parse().unwrap();
        assert_eq!((one.name.as_str(), one.value), ("alpha", number("-2")));
        assert!("alpha=two".parse::<Assignment>().is_err());
        assert_eq!("worst".parse::<ErrorFlag>(), Ok(ErrorFlag::Worst));
        assert!("-0.1".parse::<ErrorFlag>().is_err());
        assert_eq!(
            "phi_m=angle".parse::<ColumnFlag>().unwrap(),
            ColumnFlag {
                variable: "phi_m".into(),
                column: "angle".into()
            }
        );
        assert!("phi_m".parse::<ColumnFlag>().is_err());
    }
}
