//! Words of the equation language.

use crate::syntax::Problem;
use logos::Logos;
use std::ops::Range;

/// One word of an equation or condition.
#[derive(Logos, Debug, Clone, Copy, PartialEq, Eq)]
#[logos(skip r"[ \t\r\n]+")]
pub(crate) enum Token {
    #[regex(r"[0-9]+(\.[0-9]+)?([eE][+-]?[0-9]+)?")]
    Number,
    #[regex(r"[\p{L}_][\p{L}\p{N}_]*")]
    Name,
    #[token("+-")]
    #[token("±")]
    PlusMinus,
    #[token("+")]
    Plus,
    #[token("-")]
    Minus,
    #[token("*")]
    Times,
    #[token("/")]
    Over,
    #[token("^")]
    #[token("**")]
    Power,
    #[token("(")]
    Open,
    #[token(")")]
    Close,
    #[token(",")]
    Comma,
    #[token("<")]
    Less,
    #[token("<=")]
    LessEqual,
    #[token(">")]
    Greater,
    #[token(">=")]
    GreaterEqual,
    #[token("==")]
    Equal,
    #[token("!=")]
    NotEqual,
    #[token("=")]
    Assign,
}

/// Cuts `text` into words.
///
/// # Errors
/// The first character that belongs to no word, with what to write instead.
pub(crate) fn tokens(text: &str) -> Result<Vec<(Token, Range<usize>)>, Problem> {
    let mut found = Vec::new();
    for (token, range) in Token::lexer(text).spanned() {
        match token {
            Ok(token) => found.push((token, range)),
            Err(()) => return Err(unknown_character(text, range.start)),
        }
    }
    Ok(found)
}

fn unknown_character(text: &str, start: usize) -> Problem {
    let symbol = text
        .get(start..)
        .and_then(|rest| rest.chars().next())
        .unwrap_or(' ');
    let help = match symbol {
        '.' => "write a digit before and after the decimal point: 0.5, 2.0",
        '%' => "write { expr = \"x\", error = { relative = 0.1 } } for an error of ten percent",
        ':' | '?' => "write if condition then value else value",
        '&' => "write `and`",
        '|' => "write `or`, or abs(x) for the absolute value",
        '!' => "write `not`, or `!=` between two values",
        '\'' => "write only the right-hand side; the key names the state whose derivative it is",
        '[' | ']' => "group with round brackets: ( )",
        '≤' => "write `<=`",
        '≥' => "write `>=`",
        '≠' => "write `!=`",
        '·' | '×' => "write `*`",
        '−' | '–' => "write the plain minus `-`",
        '²' | '³' => "write the power with `^`: x^2",
        '√' => "write sqrt(x)",
        _ => "use names, numbers, + - * / ^ ( ) and comparisons",
    };
    Problem::new(
        "E0110",
        format!(
            "`{}` has no meaning in an expression",
            symbol.escape_debug()
        ),
        start..start + symbol.len_utf8(),
        "unexpected character",
        help,
    )
}
