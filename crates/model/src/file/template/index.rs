//! Whole numbers in braces: `{i+1}`, `{2*i-1}`, `{n}`.

use crate::syntax::Problem;
use std::ops::Range;

/// Numbers beyond this are a mistake in a name or a range.
pub(super) const LARGEST: i64 = 1_000_000;
/// Brackets and signs inside each other.
const DEEPEST: usize = 32;

/// Whole-number arithmetic over indices and sizes.
#[derive(Debug, Clone)]
pub(super) enum Index {
    Number(i64),
    Name(String, Range<usize>),
    Negative(Box<Index>),
    Two(char, Box<(Index, Index)>, Range<usize>),
}

/// Indices and sizes with their values, the innermost last.
pub(super) type Bindings = Vec<(String, i64)>;

/// `i = 7, j = 2`: what tells one instance from the others.
pub(super) fn spelled(bindings: &Bindings) -> String {
    let each = bindings
        .iter()
        .map(|(name, value)| format!("{name} = {value}"));
    each.collect::<Vec<_>>().join(", ")
}

impl Index {
    /// Reads the arithmetic at `range` of `text`.
    pub fn read(text: &str, range: Range<usize>) -> Result<Index, Problem> {
        let mut parser = Parser {
            text: text.get(..range.end).unwrap_or(""),
            at: range.start,
            whole: range,
        };
        let index = parser.sum(0)?;
        match parser.peek() {
            None => Ok(index),
            Some(symbol) => Err(parser.odd(symbol)),
        }
    }

    /// Its value, where every name in it has one in `values` or `sizes`.
    pub fn value(&self, values: &Bindings, sizes: &Bindings) -> Result<i64, Problem> {
        let value = match self {
            Index::Number(number) => Some(*number),
            Index::Name(name, range) => {
                let known = values.iter().rev().chain(sizes);
                let mut found = known.filter(|(known, _)| known == name);
                match found.next() {
                    Some((_, value)) => Some(*value),
                    None => return Err(unknown(name, range, values, sizes)),
                }
            }
            Index::Negative(a) => a.value(values, sizes)?.checked_neg(),
            Index::Two(operator, pair, _) => {
                let (a, b) = (pair.0.value(values, sizes)?, pair.1.value(values, sizes)?);
                match operator {
                    '+' => a.checked_add(b),
                    '-' => a.checked_sub(b),
                    _ => a.checked_mul(b),
                }
            }
        };
        match value.filter(|value| value.abs() <= LARGEST) {
            Some(value) => Ok(value),
            None => Err(Problem::new(
                "E0244",
                "a number in braces is too large",
                self.place().unwrap_or(0..0),
                "this value",
                format!("stay between -{LARGEST} and {LARGEST}"),
            )),
        }
    }

    fn place(&self) -> Option<Range<usize>> {
        match self {
            Index::Number(_) => None,
            Index::Name(_, range) | Index::Two(_, _, range) => Some(range.clone()),
            Index::Negative(a) => a.place(),
        }
    }
}

fn unknown(name: &str, range: &Range<usize>, values: &Bindings, sizes: &Bindings) -> Problem {
    let known = || values.iter().chain(sizes).map(|(known, _)| known.as_str());
    let help = match crate::diagnostic::nearest(name, known()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!(
            "an index needs a range in the name or before a sum, as in {{{name}=1..10}}; \
             a number has its name in [sizes]"
        ),
    };
    Problem::new(
        "E0241",
        format!("`{name}` is no index here"),
        range.clone(),
        "neither an index nor a size",
        help,
    )
}

struct Parser<'t> {
    text: &'t str,
    at: usize,
    whole: Range<usize>,
}

impl Parser<'_> {
    /// The next character that is no blank.
    fn peek(&mut self) -> Option<char> {
        let rest = self.text.get(self.at..)?;
        self.at += rest.len() - rest.trim_start().len();
        self.text.get(self.at..)?.chars().next()
    }

    fn sum(&mut self, depth: usize) -> Result<Index, Problem> {
        let start = self.at;
        let mut left = self.product(depth)?;
        while let Some(operator @ ('+' | '-')) = self.peek() {
            self.at += 1;
            let right = self.product(depth)?;
            left = Index::Two(operator, Box::new((left, right)), start..self.at);
        }
        Ok(left)
    }

    fn product(&mut self, depth: usize) -> Result<Index, Problem> {
        let start = self.at;
        let mut left = self.operand(depth)?;
        while let Some('*') = self.peek() {
            self.at += 1;
            let right = self.operand(depth)?;
            left = Index::Two('*', Box::new((left, right)), start..self.at);
        }
        Ok(left)
    }

    fn operand(&mut self, depth: usize) -> Result<Index, Problem> {
        if depth > DEEPEST {
            return Err(self.problem("too many brackets in braces", self.at..self.at));
        }
        match self.peek() {
            Some('-') => {
                self.at += 1;
                Ok(Index::Negative(Box::new(self.operand(depth + 1)?)))
            }
            Some('(') => {
                self.at += 1;
                let inner = self.sum(depth + 1)?;
                match self.peek() {
                    Some(')') => {
                        self.at += 1;
                        Ok(inner)
                    }
                    Some(symbol) => Err(self.odd(symbol)),
                    None => Err(self.problem("a bracket is never closed", self.whole.clone())),
                }
            }
            Some(symbol) if symbol.is_ascii_digit() => {
                let word = self.word(|c| c.is_ascii_digit());
                match word.parse() {
                    Ok(number) => Ok(Index::Number(number)),
                    Err(_) => Err(self.problem("a number is too large", self.whole.clone())),
                }
            }
            Some(symbol) if symbol.is_alphabetic() || symbol == '_' => {
                let start = self.at;
                let word = self.word(|c| c.is_alphanumeric() || c == '_');
                Ok(Index::Name(word, start..self.at))
            }
            Some(symbol) => Err(self.odd(symbol)),
            None => Err(self.problem("a number or an index is missing", self.whole.clone())),
        }
    }

    fn word(&mut self, belongs: impl Fn(char) -> bool) -> String {
        let rest = self.text.get(self.at..).unwrap_or("");
        let end = rest.find(|c| !belongs(c)).unwrap_or(rest.len());
        self.at += end;
        rest.get(..end).unwrap_or("").to_string()
    }

    fn odd(&self, symbol: char) -> Problem {
        let message = format!("`{}` has no meaning in braces", symbol.escape_debug());
        self.problem(message, self.at..self.at + symbol.len_utf8())
    }

    fn problem(&self, message: impl Into<String>, range: Range<usize>) -> Problem {
        Problem::new(
            "E0244",
            message,
            range,
            "braces hold an index",
            "write whole numbers, indices and sizes with + - * ( ), as in {i+1}; \
             group values with round brackets",
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<i64, String> {
        let values = vec![("i".to_string(), 7), ("j".to_string(), -2)];
        let sizes = vec![("n".to_string(), 50)];
        Index::read(text, 0..text.len())
            .and_then(|index| index.value(&values, &sizes))
            .map_err(|problem| problem.message)
    }

    #[test]
    fn whole_numbers_are_computed() {
        for (text, wanted) in [
            ("i", 7),
            (" i + 1 ", 8),
            ("2*i-1", 13),
            ("n-i-j", 45),
            ("-(i - n)*2", 86),
            ("3 - -j", 1),
            ("007", 7),
        ] {
            assert_eq!(value(text), Ok(wanted), "{text}");
        }
    }

    #[test]
    fn what_is_none_is_refused() {
        for (text, wanted) in [
            ("", "a number or an index is missing"),
            ("i+", "a number or an index is missing"),
            ("i/2", "`/` has no meaning in braces"),
            ("1.5", "`.` has no meaning in braces"),
            ("k", "`k` is no index here"),
            ("(i", "a bracket is never closed"),
            ("i j", "`j` has no meaning in braces"),
            ("99999999999999999999", "a number is too large"),
            ("n*n*n*n", "a number in braces is too large"),
        ] {
            assert_eq!(value(text), Err(wanted.to_string()), "{text}");
        }
        let deep = format!("{}1", "(".repeat(100_000));
        assert_eq!(value(&deep), Err("too many brackets in braces".to_string()));
    }
}
