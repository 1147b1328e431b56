//! Decimal text as a number in JSON, without a detour through a float.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;
use veribound_interval::Decimal;

/// One end of an interval as it is printed; `None` is an infinite end and becomes `null`.
///
/// Readers that hold numbers as floats round to the nearest float; the text itself is the bound.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Number(pub Option<String>);

impl Number {
    /// A bound printed by [`crate::outward`], or a time stamp.
    pub(crate) fn new(text: String) -> Self {
        let is_finite = text.bytes().any(|byte| byte.is_ascii_digit());
        Number(is_finite.then_some(text))
    }

    /// The exact decimal that is printed.
    pub(crate) fn decimal(&self) -> Option<Decimal> {
        self.0.as_deref().and_then(|text| Decimal::parse(text).ok())
    }
}

/// A time as the exact decimal.
///
/// Example: [`EnclosureSummary`](crate::EnclosureSummary).
#[derive(Debug, Clone, Serialize)]
#[serde(transparent)]
pub struct Time(Number);

impl Time {
    /// A time in seconds.
    pub fn new(time: &Decimal) -> Self {
        Time(Number::new(time.to_string()))
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let raw = self.0.clone().map(RawValue::from_string);
        let raw = raw.transpose().map_err(serde::ser::Error::custom)?;
        raw.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let raw: Box<RawValue> = Deserialize::deserialize(deserializer)?;
        let text = raw.get();
        if text == "null" {
            return Ok(Number(None));
        }
        match Decimal::parse(text) {
            Ok(_) => Ok(Number(Some(text.to_owned()))),
            Err(_) => Err(serde::de::Error::custom(format!(
                "`{text}` is no decimal number"
            ))),
        }
    }
}
