//! Units: what they measure, exactly.
//!
//! A unit is a product of symbols with integer powers: `rad/s`, `N*m`, `N.m`, `1/(kg*m^2)`, `s^-1`,
//! `kg m^2`, with `·`, `²` and `³` allowed, read from left to right (`1/kg*m` is `m/kg`). It has a
//! *dimension*, powers of the base units m, kg, s, A, K, mol, cd and rad, and a *scale*: how much
//! of the base units it is, a rational number times a power of pi.
//!
//! - A symbol that is not known (`cells`, `counts`) is a base unit of its own with scale 1.
//! - `rad` is a base unit here, though it is 1 in the SI: two units whose dimensions differ only
//!   by a power of rad are told apart by [`Unit::has_dimension_of`] and not by [`Unit::agrees_with`].
//! - `°C` (`degC`) and `°F` (`degF`) are K and 5/9 K, as for differences of temperatures and in
//!   `W/(m^2*°C)`. Their zeros are elsewhere: a temperature itself is never converted to another
//!   scale ([`Unit::conversion_to`]).

mod parse;
mod scale;
mod symbols;

pub(crate) use parse::split_unit;
pub use scale::{Conversion, Scale};

use crate::syntax::Problem;
use num_rational::Ratio;
use num_traits::{One, Signed, Zero};
use std::collections::BTreeMap;
use symbols::Meaning;

/// Powers beyond this, and sums of powers in one unit, are no unit any more.
const LARGEST_POWER: i64 = 1000;
/// Powers of units in expressions are fractions with denominators up to this.
const LARGEST_DENOMINATOR: i64 = 64;

type Exponent = Ratio<i64>;

/// A unit: its symbols as the user wrote them, its dimension and its scale.
///
/// ```
/// use veribound_interval::{Decimal, Interval};
/// use veribound_model::Unit;
/// use veribound_model::units::{Conversion, Scale};
///
/// let (degree, radian) = (Unit::parse("deg").unwrap(), Unit::parse("rad").unwrap());
/// assert!(degree.has_dimension_of(&radian) && !degree.is_scaled_like(&radian));
/// let exact: Conversion = degree.conversion_to(&radian).unwrap();
/// let scale: &Scale = exact.factor();
/// assert!(!scale.is_one());
/// let half_turn = exact.apply(&Decimal::from_i64(180));
/// assert!(half_turn.intersects(Interval::PI) && half_turn.width() < 1e-14);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    symbols: Vec<(String, Exponent)>,
    /// Powers of base units, none of them zero.
    dimension: BTreeMap<String, Exponent>,
    /// `None` where a number of unknown meaning was multiplied in.
    scale: Option<Scale>,
}

impl Unit {
    /// Reads a unit; the empty text and `1` are the unit of plain numbers. `None` for what is no unit.
    pub fn parse(text: &str) -> Option<Unit> {
        Unit::read(text).ok()
    }

    /// Reads a unit.
    ///
    /// # Errors
    /// The first place that cannot be read as a unit.
    pub(crate) fn read(text: &str) -> Result<Unit, Problem> {
        let factors = parse::factors(text)?;
        let mut unit = Unit::plain();
        for (symbol, power) in factors {
            unit = Unit::of_symbol(&symbol)
                .power(power)
                .and_then(|factor| unit.times(&factor))
                .ok_or_else(|| parse::too_large(text))?;
        }
        Ok(unit)
    }

    /// The unit of plain numbers.
    pub fn plain() -> Unit {
        Unit {
            symbols: Vec::new(),
            dimension: BTreeMap::new(),
            scale: Some(Scale::one()),
        }
    }

    /// Whether it is the unit of plain numbers.
    pub(crate) fn is_plain(&self) -> bool {
        self.symbols.is_empty()
    }

    fn of_symbol(symbol: &str) -> Unit {
        let (dimension, scale) = match symbols::find(symbol) {
            Some(Meaning {
                dimension, scale, ..
            }) => (dimension, scale),
            None => (vec![(symbol.to_owned(), 1)], Scale::one()),
        };
        let dimension = dimension.into_iter();
        Unit {
            symbols: vec![(symbol.to_owned(), Exponent::one())],
            dimension: dimension
                .map(|(base, power)| (base, Exponent::from_integer(power)))
                .collect(),
            scale: Some(scale),
        }
    }

    /// The product; `None` when its powers are out of all proportion.
    pub(crate) fn times(&self, other: &Unit) -> Option<Unit> {
        let mut product = self.clone();
        for (symbol, power) in &other.symbols {
            match product.symbols.iter_mut().find(|(own, _)| own == symbol) {
                Some((_, own)) => *own += power,
                None => product.symbols.push((symbol.clone(), *power)),
            }
        }
        for (base, power) in &other.dimension {
            *product.dimension.entry(base.clone()).or_default() += power;
        }
        product.scale = match (&self.scale, &other.scale) {
            (Some(one), Some(other)) => Some(one.times(other)),
            _ => None,
        };
        product.tidied()
    }

    /// The quotient; `None` when its powers are out of all proportion.
    pub(crate) fn over(&self, other: &Unit) -> Option<Unit> {
        self.times(&other.power(-Exponent::one())?)
    }

    /// A power; `None` when it is out of all proportion.
    pub(crate) fn power(&self, power: Exponent) -> Option<Unit> {
        // The bound keeps the products of exponents far from the ends of i64.
        let is_small = |x: Exponent| {
            x.numer().abs() <= LARGEST_POWER * LARGEST_DENOMINATOR
                && *x.denom() <= LARGEST_DENOMINATOR
        };
        if !is_small(power) {
            return None;
        }
        let raised = |own: &Exponent| *own * power;
        let symbols = self.symbols.iter();
        let dimension = self.dimension.iter();
        Unit {
            symbols: symbols.map(|(s, own)| (s.clone(), raised(own))).collect(),
            dimension: dimension.map(|(b, own)| (b.clone(), raised(own))).collect(),
            scale: self.scale.as_ref().and_then(|scale| scale.power(power)),
        }
        .tidied()
    }

    fn tidied(mut self) -> Option<Unit> {
        self.symbols.retain(|(_, power)| !power.is_zero());
        self.dimension.retain(|_, power| !power.is_zero());
        let powers = || self.symbols.iter().map(|(_, power)| power);
        let is_small = powers().all(|power| {
            power.abs() <= Exponent::from_integer(LARGEST_POWER)
                && *power.denom() <= LARGEST_DENOMINATOR
        });
        let sum: i64 = powers().map(|power| power.abs().ceil().to_integer()).sum();
        (is_small && sum <= LARGEST_POWER).then_some(self)
    }

    /// The unit with an unknown scale: multiplied by a number that may be a conversion.
    pub(crate) fn without_scale(mut self) -> Unit {
        self.scale = None;
        self
    }

    /// The scale to the base units; `None` where it is not known.
    pub(crate) fn scale(&self) -> Option<&Scale> {
        self.scale.as_ref()
    }

    /// Symbols that are base units of their own because nothing is known about them.
    pub fn unknown_symbols(&self) -> Vec<&str> {
        let symbols = self.symbols.iter().map(|(symbol, _)| symbol.as_str());
        symbols
            .filter(|symbol| symbols::find(symbol).is_none())
            .collect()
    }

    /// Whether both have the same powers of all base units.
    pub fn has_dimension_of(&self, other: &Unit) -> bool {
        self.dimension == other.dimension
    }

    /// Whether both have the same powers of all base units but the radian, which is 1.
    pub fn agrees_with(&self, other: &Unit) -> bool {
        let without_angle = |unit: &Unit| {
            let mut dimension = unit.dimension.clone();
            dimension.remove("rad");
            dimension
        };
        without_angle(self) == without_angle(other)
    }

    /// Whether one of both is the same in base units.
    pub fn is_scaled_like(&self, other: &Unit) -> bool {
        self.scale.is_some() && self.scale == other.scale
    }

    /// How numbers in this unit become numbers in the unit `wanted`; `None` where they cannot:
    /// another dimension, or temperatures on scales with different zeros.
    pub fn conversion_to(&self, wanted: &Unit) -> Option<Conversion> {
        let is_offset = match (self.temperature(), wanted.temperature()) {
            (Some(own), Some(wanted)) => own != wanted,
            _ => false,
        };
        if is_offset || !self.has_dimension_of(wanted) {
            return None;
        }
        let factor = self.scale.as_ref()?.over(wanted.scale.as_ref()?);
        Some(Conversion::new(factor))
    }

    /// Whether both are temperatures, though on different scales.
    pub fn is_other_temperature_than(&self, other: &Unit) -> bool {
        matches!((self.temperature(), other.temperature()), (Some(a), Some(b)) if a != b)
    }

    /// The temperature scale whose temperatures are measured, not differences or rates.
    fn temperature(&self) -> Option<&'static str> {
        match self.symbols.as_slice() {
            [(symbol, power)] if power.is_one() => symbols::find(symbol)?.temperature,
            _ => None,
        }
    }

    /// The unit in the symbols it was written with.
    pub fn spell(&self) -> String {
        let symbols = self.symbols.iter();
        spell(symbols.map(|(symbol, power)| (symbol.as_str(), *power)))
    }

    /// The dimension in base units.
    pub(crate) fn spell_dimension(&self) -> String {
        let dimension = self.dimension.iter();
        spell(dimension.map(|(base, power)| (base.as_str(), *power)))
    }
}

fn spell<'s>(powers: impl Iterator<Item = (&'s str, Exponent)>) -> String {
    let factor = |symbol: &str, power: Exponent| match power {
        one if one.is_one() => symbol.to_owned(),
        whole if whole.is_integer() => format!("{symbol}^{whole}"),
        part => format!("{symbol}^({part})"),
    };
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for (symbol, power) in powers {
        if power.is_positive() {
            above.push(factor(symbol, power));
        } else {
            below.push(factor(symbol, -power));
        }
    }
    let above = match above.is_empty() {
        true => "1".to_owned(),
        false => above.join("*"),
    };
    match below.as_slice() {
        [] => above,
        [one] => format!("{above}/{one}"),
        many => format!("{above}/({})", many.join("*")),
    }
}

#[cfg(test)]
mod tests;
