//! Reads equations and conditions: a hand-written operator-precedence parser.
//!
//! From loose to tight: `or`, `and`, `not`, one comparison, `+ -`, `* /`, unary minus, `^`.
//! So `-x^2` is `-(x^2)` and `2^-3` is allowed.

use crate::diagnostic::nearest;
use crate::model::Relation;
use crate::syntax::Problem;
use crate::syntax::ast::{Arithmetic, Ast, Function, Kind};
use crate::syntax::token::{Token, tokens};
use crate::syntax::{number, strength};
use std::ops::Range;
use std::sync::Arc;

/// Brackets, calls and signs inside each other.
const DEEPEST_NESTING: usize = 64;
/// Levels of the finished tree, to which also a long sum adds one for each term.
pub(crate) const DEEPEST_TREE: usize = 400;

/// Reads one expression or condition that fills `text`.
///
/// # Errors
/// Everything wrong up to the first place after which nothing can be said.
pub(crate) fn expression(text: &str) -> Result<Ast, Vec<Problem>> {
    let mut parser = Parser::new(text, false)?;
    let ast = parser.whole();
    parser.finish(ast)
}

/// Reads `expression +- number` and gives the expression and the place of the number; no place
/// when there is no `+-`.
///
/// # Errors
/// As [`expression`].
pub(crate) fn measurement(text: &str) -> Result<(Ast, Option<Range<usize>>), Vec<Problem>> {
    let mut parser = Parser::new(text, true)?;
    let ast = parser.measurement();
    parser.finish(ast)
}

/// A problem was recorded and nothing sensible can be read after it.
struct Stop;

struct Parser<'t> {
    text: &'t str,
    tokens: Vec<(Token, Range<usize>)>,
    at: usize,
    nesting: usize,
    /// Open round brackets.
    brackets: usize,
    /// Whether `+-` outside of brackets ends the expression.
    measurement: bool,
    problems: Vec<Problem>,
}

impl<'t> Parser<'t> {
    fn new(text: &'t str, measurement: bool) -> Result<Self, Vec<Problem>> {
        let tokens = tokens(text).map_err(|problem| vec![problem])?;
        Ok(Parser {
            text,
            tokens,
            at: 0,
            nesting: 0,
            brackets: 0,
            measurement,
            problems: Vec::new(),
        })
    }

    fn finish<T>(self, result: Result<T, Stop>) -> Result<T, Vec<Problem>> {
        match result {
            Ok(value) if self.problems.is_empty() => Ok(value),
            _ => Err(self.problems),
        }
    }

    fn stop<T>(&mut self, problem: Problem) -> Result<T, Stop> {
        self.problems.push(problem);
        Err(Stop)
    }

    fn peek(&self) -> Option<(Token, Range<usize>)> {
        self.tokens.get(self.at).cloned()
    }

    fn next(&mut self) -> Option<(Token, Range<usize>)> {
        let found = self.peek();
        self.at += 1;
        found
    }

    /// The word at `range`.
    fn word(&self, range: &Range<usize>) -> &'t str {
        self.text.get(range.clone()).unwrap_or("")
    }

    /// Where a word is missing at the end: the last word's end.
    fn end(&self) -> Range<usize> {
        let end = self.tokens.last().map_or(0, |(_, range)| range.end);
        end..end
    }

    /// Whether a `+-` here stands before an error bound.
    fn ends_measurement(&self) -> bool {
        self.measurement && self.brackets == 0
    }

    fn whole(&mut self) -> Result<Ast, Stop> {
        let ast = self.parse(strength::ANY)?;
        match self.peek() {
            None => Ok(ast),
            Some((token, range)) => self.unexpected(token, range),
        }
    }

    fn measurement(&mut self) -> Result<(Ast, Option<Range<usize>>), Stop> {
        let ast = self.parse(strength::ANY)?;
        match self.next() {
            None => return Ok((ast, None)),
            Some((Token::PlusMinus, _)) => {}
            Some((token, range)) => return self.unexpected(token, range),
        }
        let bound = match self.next() {
            Some((Token::Number, range)) => range,
            other => {
                let range = other.map_or(self.end(), |(_, range)| range);
                return self.stop(Problem::new(
                    "E0110",
                    "the error bound behind `+-` is not a number",
                    range,
                    "expected a number",
                    "write the largest error as a number, as in \"phi +- 0.1\"",
                ));
            }
        };
        match self.next() {
            None => Ok((ast, Some(bound))),
            Some((_, range)) => self.stop(Problem::new(
                "E0110",
                "nothing can follow the error bound but a unit",
                range,
                "unexpected",
                "write the unit in square brackets, as in \"phi +- 0.1 [rad]\"",
            )),
        }
    }

    fn parse(&mut self, loosest: u8) -> Result<Ast, Stop> {
        self.nesting += 1;
        if self.nesting > DEEPEST_NESTING {
            let range = self.peek().map_or(self.end(), |(_, range)| range);
            return self.stop(Problem::new(
                "E0113",
                "the expression is nested too deeply",
                range,
                format!("level {}", DEEPEST_NESTING + 1),
                "give parts of it a name in [let]",
            ));
        }
        let mut left = self.operand()?;
        while let Some((token, range)) = self.peek() {
            let Some((binds, right)) = self.strengths(token, &range) else {
                break;
            };
            if binds < loosest {
                break;
            }
            if binds == strength::COMPARE && matches!(left.kind, Kind::Compare(..)) {
                return self.stop(Problem::new(
                    "E0110",
                    "two comparisons follow each other",
                    range,
                    "second comparison",
                    "write them one by one: a < b and b < c",
                ));
            }
            self.at += 1;
            let right = self.parse(right)?;
            left = self.join(token, &range, left, right)?;
        }
        self.nesting -= 1;
        Ok(left)
    }

    /// How tightly the operator binds to its left, and the loosest operator its right side may hold.
    fn strengths(&self, token: Token, range: &Range<usize>) -> Option<(u8, u8)> {
        Some(match token {
            Token::Name if self.word(range) == "or" => (strength::OR, strength::AND),
            Token::Name if self.word(range) == "and" => (strength::AND, strength::NOT),
            Token::Less
            | Token::LessEqual
            | Token::Greater
            | Token::GreaterEqual
            | Token::Equal
            | Token::NotEqual => (strength::COMPARE, strength::SUM),
            Token::PlusMinus if self.ends_measurement() => return None,
            Token::Plus | Token::Minus | Token::PlusMinus => (strength::SUM, strength::PRODUCT),
            Token::Times | Token::Over => (strength::PRODUCT, strength::SIGN),
            Token::Power => (strength::POWER, strength::SIGN),
            _ => return None,
        })
    }

    fn join(
        &mut self,
        token: Token,
        operator: &Range<usize>,
        left: Ast,
        right: Ast,
    ) -> Result<Ast, Stop> {
        let range = left.range.start..right.range.end;
        let (left, right) = (Arc::new(left), Arc::new(right));
        let kind = match token {
            Token::Name if self.word(operator) == "or" => Kind::Or(left, right),
            Token::Name => Kind::And(left, right),
            Token::Less => Kind::Compare(Relation::Less, left, right),
            Token::LessEqual => Kind::Compare(Relation::LessEqual, left, right),
            Token::Greater => Kind::Compare(Relation::Greater, left, right),
            Token::GreaterEqual => Kind::Compare(Relation::GreaterEqual, left, right),
            Token::Equal => Kind::Compare(Relation::Equal, left, right),
            Token::NotEqual => Kind::Compare(Relation::NotEqual, left, right),
            Token::Plus => Kind::Arithmetic(Arithmetic::Add, left, right),
            // `a +-b` is `a + -b`.
            Token::Minus | Token::PlusMinus => Kind::Arithmetic(Arithmetic::Subtract, left, right),
            Token::Times => Kind::Arithmetic(Arithmetic::Multiply, left, right),
            Token::Over => Kind::Arithmetic(Arithmetic::Divide, left, right),
            _ => Kind::Power(left, right),
        };
        self.grown(kind, range)
    }

    /// The node, if the tree is not too deep with it.
    fn grown(&mut self, kind: Kind, range: Range<usize>) -> Result<Ast, Stop> {
        let ast = Ast::new(kind, range);
        if ast.depth > DEEPEST_TREE {
            let end = ast.range.end;
            let range = self
                .tokens
                .iter()
                .rev()
                .find(|(_, r)| r.end <= end)
                .map(|(_, r)| r.clone());
            return self.stop(Problem::new(
                "E0113",
                "the expression is too long",
                range.unwrap_or(end..end),
                format!("more than {DEEPEST_TREE} operations in a row"),
                "give parts of it a name in [let]",
            ));
        }
        Ok(ast)
    }

    fn operand(&mut self) -> Result<Ast, Stop> {
        let Some((token, range)) = self.next() else {
            let empty = self.tokens.is_empty();
            let end = self.end();
            return self.stop(Problem::new(
                "E0110",
                if empty {
                    "the expression is empty"
                } else {
                    "the expression ends too early"
                },
                if empty { 0..self.text.len() } else { end },
                "expected a value",
                "write a name, a number or a bracket here",
            ));
        };
        match token {
            Token::Number => match number::decimal(self.word(&range), range.clone()) {
                Ok(decimal) => Ok(Ast::new(Kind::Number(decimal), range)),
                Err(problem) => self.stop(problem),
            },
            Token::Name => self.named(range),
            Token::Open => self.bracket(range),
            Token::Plus => self.parse(strength::SIGN),
            Token::PlusMinus if self.ends_measurement() => self.unexpected_operand(token, range),
            Token::Minus | Token::PlusMinus => {
                let inner = self.parse(strength::SIGN)?;
                let whole = range.start..inner.range.end;
                self.grown(Kind::Negate(Arc::new(inner)), whole)
            }
            _ => self.unexpected_operand(token, range),
        }
    }

    fn named(&mut self, range: Range<usize>) -> Result<Ast, Stop> {
        let name = self.word(&range);
        match name {
            "not" => {
                let inner = self.parse(strength::NOT)?;
                let whole = range.start..inner.range.end;
                return self.grown(Kind::Not(Arc::new(inner)), whole);
            }
            "true" => return Ok(Ast::new(Kind::Always, range)),
            "if" => return self.choice(range),
            "and" | "or" | "then" | "else" => return self.unexpected_operand(Token::Name, range),
            _ => {}
        }
        if let Some((Token::Open, open)) = self.peek() {
            self.at += 1;
            return self.call(range, open);
        }
        if Function::named(name).is_some() {
            return self.stop(Problem::new(
                "E0114",
                format!("the function `{name}` has no arguments"),
                range,
                "a function",
                format!("write {name}(...)"),
            ));
        }
        Ok(Ast::new(Kind::Name(name.to_string()), range))
    }

    /// `if condition then value else value`; the last value reaches as far as it can.
    fn choice(&mut self, start: Range<usize>) -> Result<Ast, Stop> {
        let condition = self.parse(strength::ANY)?;
        self.word_of_choice("then", &start)?;
        let yes = self.parse(strength::ANY)?;
        self.word_of_choice("else", &start)?;
        let no = self.parse(strength::ANY)?;
        let whole = start.start..no.range.end;
        let kind = Kind::If(Arc::new(condition), Arc::new(yes), Arc::new(no));
        self.grown(kind, whole)
    }

    fn word_of_choice(&mut self, wanted: &str, start: &Range<usize>) -> Result<(), Stop> {
        match self.next() {
            Some((Token::Name, range)) if self.word(&range) == wanted => Ok(()),
            other => {
                let range = other.map_or(start.clone(), |(_, range)| range);
                self.stop(Problem::new(
                    "E0110",
                    format!("the `if` has no `{wanted}`"),
                    range,
                    format!("expected `{wanted}`"),
                    "write if condition then value else value",
                ))
            }
        }
    }

    fn bracket(&mut self, open: Range<usize>) -> Result<Ast, Stop> {
        self.brackets += 1;
        let mut inner = self.parse(strength::ANY)?;
        let close = self.close(&open)?;
        self.brackets -= 1;
        inner.range = open.start..close.end;
        Ok(inner)
    }

    fn call(&mut self, name: Range<usize>, open: Range<usize>) -> Result<Ast, Stop> {
        self.brackets += 1;
        let mut arguments = Vec::new();
        if !matches!(self.peek(), Some((Token::Close, _))) {
            arguments.push(self.parse(strength::ANY)?);
            while matches!(self.peek(), Some((Token::Comma, _))) {
                self.at += 1;
                arguments.push(self.parse(strength::ANY)?);
            }
        }
        let close = self.close(&open)?;
        self.brackets -= 1;
        let whole = name.start..close.end;
        let word = self.word(&name);
        let Some(function) = Function::named(word) else {
            let known = Function::NAMES.iter().map(|(name, _)| *name);
            let help = match nearest(word, known) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!(
                    "known functions are {}; a product needs `*`",
                    Function::NAMES.map(|(name, _)| name).join(", ")
                ),
            };
            let message = format!("there is no function `{word}`");
            self.problems
                .push(Problem::new("E0115", message, name, "not a function", help));
            // The value stands for the call so that the rest can still be read.
            return Ok(Ast::new(Kind::Always, whole));
        };
        let (fewest, most, needs) = function.arguments();
        if arguments.len() < fewest || arguments.len() > most {
            self.problems.push(Problem::new(
                "E0114",
                format!("`{word}` needs {needs}, here are {}", arguments.len()),
                whole.clone(),
                "wrong number of arguments",
                format!("give `{word}` {needs}"),
            ));
        }
        self.grown(Kind::Call(function, arguments), whole)
    }

    fn close(&mut self, open: &Range<usize>) -> Result<Range<usize>, Stop> {
        match self.next() {
            Some((Token::Close, range)) => Ok(range),
            None => self.stop(Problem::new(
                "E0111",
                "a bracket is never closed",
                open.clone(),
                "opened here",
                "add the missing `)`",
            )),
            Some((token, range)) => self.unexpected(token, range),
        }
    }

    /// A word where an operator or the end should be.
    fn unexpected<T>(&mut self, token: Token, range: Range<usize>) -> Result<T, Stop> {
        let word = self.word(&range);
        let (code, message, label, help) = match token {
            Token::Close => (
                "E0111",
                "a bracket is closed that was never opened".to_string(),
                "no `(` belongs to this",
                "remove it or add the missing `(`".to_string(),
            ),
            Token::Assign => (
                "E0110",
                "`=` has no meaning here".to_string(),
                "unexpected",
                "compare with `==`".to_string(),
            ),
            Token::Comma => (
                "E0110",
                "a comma has no meaning here".to_string(),
                "unexpected",
                "write the decimal point: 0.5; commas separate arguments".to_string(),
            ),
            Token::Name | Token::Number | Token::Open => (
                "E0110",
                format!("an operator is missing before `{word}`"),
                "expected an operator",
                "write `*` for a product".to_string(),
            ),
            _ => (
                "E0110",
                format!("`{word}` has no meaning here"),
                "unexpected",
                "write an operator between two values".to_string(),
            ),
        };
        self.stop(Problem::new(code, message, range, label, help))
    }

    /// A word where a value should be.
    fn unexpected_operand<T>(&mut self, token: Token, range: Range<usize>) -> Result<T, Stop> {
        let word = self.word(&range);
        if token == Token::Close && self.brackets == 0 {
            return self.unexpected(token, range);
        }
        let help = match token {
            Token::Assign => "write `==`, `<=` or `>=` to compare",
            Token::Greater => "write `>=`, not `=>`",
            Token::Times | Token::Over => "remove it or add the missing value before it",
            _ => "write a name, a number or a bracket here",
        };
        self.stop(Problem::new(
            "E0110",
            format!("a value is missing before `{word}`"),
            range,
            "expected a value",
            help,
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tree in fully bracketed form.
    fn shape(text: &str) -> String {
        fn write(ast: &Ast) -> String {
            match &ast.kind {
                Kind::Number(value) => value.to_rational().to_string(),
                Kind::Name(name) => name.clone(),
                Kind::Always => "true".into(),
                Kind::Negate(a) => format!("(-{})", write(a)),
                Kind::Not(a) => format!("(not {})", write(a)),
                Kind::Arithmetic(op, a, b) => format!("({} {op:?} {})", write(a), write(b)),
                Kind::Power(a, b) => format!("({}^{})", write(a), write(b)),
                Kind::Call(f, list) => {
                    format!(
                        "{f:?}({})",
                        list.iter().map(write).collect::<Vec<_>>().join(",")
                    )
                }
                Kind::Compare(r, a, b) => format!("({} {r:?} {})", write(a), write(b)),
                Kind::And(a, b) => format!("({} and {})", write(a), write(b)),
                Kind::Or(a, b) => format!("({} or {})", write(a), write(b)),
                Kind::If(c, a, b) => {
                    format!("(if {} then {} else {})", write(c), write(a), write(b))
                }
            }
        }
        match expression(text) {
            Ok(ast) => write(&ast),
            Err(problems) => problems
                .iter()
                .map(|p| p.message.clone())
                .collect::<Vec<_>>()
                .join("; "),
        }
    }

    #[test]
    fn precedence() {
        assert_eq!(
            shape("1 + if a > 0 or b then x else y + 2*if c then 1 else 2"),
            "(1 Add (if ((a Greater 0) or b) then x else (y Add (2 Multiply (if c then 1 else 2)))))"
        );
        assert_eq!(shape("-x^2"), "(-(x^2))");
        assert_eq!(shape("2^-3"), "(2^(-3))");
        assert_eq!(shape("x**2**3"), "(x^(2^3))");
        assert_eq!(shape("a-b-c"), "((a Subtract b) Subtract c)");
        assert_eq!(shape("a/b*c"), "((a Divide b) Multiply c)");
        assert_eq!(shape("a + -b*c"), "(a Add ((-b) Multiply c))");
        assert_eq!(shape("a +-b*c"), "(a Subtract (b Multiply c))");
        assert_eq!(
            shape("not a < b and c == 0 or d > 1"),
            "(((not (a Less b)) and (c Equal 0)) or (d Greater 1))"
        );
    }

    #[test]
    fn numbers_are_exact() {
        assert_eq!(shape("0.1"), "1/10");
        assert_eq!(shape("2.50e1"), "25");
    }

    #[test]
    fn measured_quantity() {
        let (ast, bound) = measurement("theta + pi +- 0.0032").unwrap();
        assert_eq!(ast.names().len(), 2);
        assert_eq!(bound, Some(14..20));
        let (_, bound) = measurement("(a +- b)").unwrap();
        assert_eq!(bound, None);
    }

    #[test]
    fn deep_and_long_expressions_are_refused() {
        let deep = format!("{}x{}", "(".repeat(100_000), ")".repeat(100_000));
        assert_eq!(shape(&deep), "the expression is nested too deeply");
        let signs = format!("{}x", "-".repeat(100_000));
        assert_eq!(shape(&signs), "the expression is nested too deeply");
        let long = "x+".repeat(100_000) + "x";
        assert_eq!(shape(&long), "the expression is too long");
    }
}
