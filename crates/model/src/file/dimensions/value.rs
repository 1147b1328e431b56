//! What is known of the unit of an expression.

use crate::units::Unit;
use num_rational::Ratio;

/// The unit of a part of an equation.
#[derive(Debug, Clone)]
pub(super) enum Value {
    /// Not known; fits everywhere.
    Free,
    /// A number as it is written: in a sum it takes the unit of its neighbours.
    Number,
    /// A unit that follows from units in the file.
    Known {
        unit: Unit,
        /// Numbers were multiplied in, which may have units that nobody wrote down.
        has_number: bool,
    },
}

impl Value {
    pub fn of(unit: Unit) -> Value {
        Value::Known {
            unit,
            has_number: false,
        }
    }

    /// As the value of a [let]: a number with a name is a quantity without a unit.
    pub fn named(self) -> Value {
        match self {
            Value::Number => Value::Free,
            other => other,
        }
    }

    pub fn times(&self, other: &Value) -> Value {
        match (self, other) {
            (Value::Free, _) | (_, Value::Free) => Value::Free,
            (Value::Number, Value::Number) => Value::Number,
            (Value::Number, Value::Known { unit, .. })
            | (Value::Known { unit, .. }, Value::Number) => Value::Known {
                unit: unit.clone().without_scale(),
                has_number: true,
            },
            (
                Value::Known { unit, has_number },
                Value::Known {
                    unit: second,
                    has_number: has_second,
                },
            ) => unit.times(second).map_or(Value::Free, |unit| Value::Known {
                unit,
                has_number: *has_number || *has_second,
            }),
        }
    }

    pub fn power(&self, power: Ratio<i64>) -> Value {
        let Value::Known { unit, has_number } = self else {
            return self.clone();
        };
        unit.power(power).map_or(Value::Free, |unit| Value::Known {
            unit,
            has_number: *has_number,
        })
    }

    /// Smaller is better known.
    pub fn rank(&self) -> u8 {
        match self {
            Value::Known { unit, has_number } => {
                let doubts = [unit.scale().is_none(), *has_number, unit.is_plain()];
                doubts
                    .iter()
                    .rev()
                    .fold(0, |rank, doubt| 2 * rank + u8::from(*doubt))
            }
            _ => u8::MAX,
        }
    }

    /// Whether it can be in `wanted` with numbers taken as plain numbers.
    pub fn may_be(&self, wanted: &Unit) -> bool {
        match self {
            Value::Known { unit, .. } => unit.agrees_with(wanted),
            _ => true,
        }
    }
}
