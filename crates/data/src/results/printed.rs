//! The numbers of a `summary.json` as the texts they are printed as.

use serde_json::value::RawValue;
use std::collections::BTreeMap;
use veribound_model::diagnostic::Diagnostic;

/// A `summary.json`, to be asked for the digits at a place.
///
/// *Guarantee*: a number is given as it is printed in the file, digit for digit.
///
/// ```
/// use veribound_data::Printed;
///
/// let summary = r#"{"parameters": {"k": {"lo": 0.10, "hi": null}}}"#;
/// let printed = Printed::of(summary)?;
/// assert_eq!(printed.at(&["parameters", "k", "lo"]), Some("0.10"));
/// assert_eq!(Printed::pointer(&["parameters", "k", "lo"]), "/parameters/k/lo");
/// # Ok::<(), veribound_model::diagnostic::Diagnostic>(())
/// ```
#[derive(Debug, Clone)]
pub struct Printed<'j>(&'j RawValue);

impl<'j> Printed<'j> {
    /// Takes the text of a summary.
    ///
    /// *Errors*: `E0503` when it is not JSON.
    pub fn of(json: &'j str) -> Result<Printed<'j>, Diagnostic> {
        let raw = serde_json::from_str(json);
        raw.map(Printed).map_err(|error| {
            Diagnostic::new(
                "E0503",
                format!("the summary cannot be read again: {error}"),
            )
        })
    }

    /// The text at a place, given by the names and positions on the way to it; none where there is nothing, or
    /// `null`.
    pub fn at(&self, path: &[&str]) -> Option<&'j str> {
        let mut place = self.0;
        for name in path {
            place = if place.get().starts_with('[') {
                let list: Vec<&'j RawValue> = serde_json::from_str(place.get()).ok()?;
                list.get(name.parse::<usize>().ok()?).copied()?
            } else {
                let mut map: BTreeMap<String, &'j RawValue> =
                    serde_json::from_str(place.get()).ok()?;
                map.remove(*name)?
            };
        }
        Some(place.get()).filter(|text| *text != "null")
    }

    /// The text at a place, where it is one.
    pub fn text(&self, path: &[&str]) -> Option<String> {
        serde_json::from_str(self.at(path)?).ok()
    }

    /// The JSON pointer (RFC 6901) to a place.
    pub fn pointer(path: &[&str]) -> String {
        let escaped = path
            .iter()
            .map(|name| name.replace('~', "~0").replace('/', "~1"));
        escaped.map(|name| format!("/{name}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_the_file() {
        let json = r#"{"a/b": {"lo": -2.60000000001, "hi": null}, "list": [{"x": 1e-12}, 0.10]}"#;
        let printed = Printed::of(json).unwrap();
        assert_eq!(printed.at(&["a/b", "lo"]), Some("-2.60000000001"));
        assert_eq!(printed.at(&["a/b", "hi"]), None);
        assert_eq!(printed.at(&["list", "0", "x"]), Some("1e-12"));
        assert_eq!(printed.at(&["list", "1"]), Some("0.10"));
        assert_eq!(printed.at(&["list", "2"]), None);
        assert_eq!(printed.text(&["list", "1"]), None);
        let word = Printed::of(r#"{"why": "a \"b\""}"#).unwrap();
        assert_eq!(word.text(&["why"]).as_deref(), Some("a \"b\""));
        assert_eq!(printed.at(&["list", "1", "x"]), None);
        assert_eq!(Printed::pointer(&["a/b", "lo"]), "/a~1b/lo");
        assert_eq!(Printed::of("{").unwrap_err().code, "E0503");
    }
}
