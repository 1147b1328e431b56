//! Intervals in files of other crates, with the feature `serde`.

use crate::Interval;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

/// As the pair of both ends; the empty set as a pair that is the wrong way round. Formats that keep every bit of a
/// number keep the interval.
impl Serialize for Interval {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let ends = if self.is_empty() {
            (f64::INFINITY, f64::NEG_INFINITY)
        } else {
            (self.lo(), self.hi())
        };
        ends.serialize(to)
    }
}

impl<'a> Deserialize<'a> for Interval {
    fn deserialize<D: Deserializer<'a>>(from: D) -> Result<Self, D::Error> {
        match <(f64, f64)>::deserialize(from)? {
            (f64::INFINITY, f64::NEG_INFINITY) => Ok(Interval::EMPTY),
            (lo, hi) => Interval::new(lo, hi)
                .ok_or_else(|| de::Error::custom(format_args!("[{lo}, {hi}] is no interval"))),
        }
    }
}
