//! Reading files of test vectors (`*.itl`): statements `operation arguments = results;`.

use std::path::PathBuf;

use veribound_interval::Interval;

/// One argument or result.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// An interval, with its decoration where it has one.
    Set(Interval, Option<Decoration>),
    Number(f64),
    Claim(bool),
    /// Text in quotes.
    Text(String),
    /// Anything else: the state of an overlap, a decoration by itself.
    Word(String),
    /// No result: the constructor refuses its argument.
    Refused,
}

impl Item {
    pub fn set(x: Interval) -> Item {
        Item::Set(x, None)
    }
}

/// What IEEE 1788 knows about how a result came about; later is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Decoration {
    /// Undefined somewhere.
    Trv,
    /// Defined.
    Def,
    /// Defined and continuous.
    Dac,
    /// Defined, continuous and bounded.
    Com,
}

/// A test vector.
#[derive(Debug)]
pub struct Vector {
    pub file: String,
    /// The statement as written.
    pub text: String,
    pub operation: String,
    pub arguments: Vec<Item>,
    pub results: Vec<Item>,
}

/// Why a vector is not applied, whatever the operation.
pub const LEFT_OUT: [(&str, &str); 4] = [
    ("[nai]", "there is no ill-formed interval"),
    (
        "NaN",
        "numbers describing the empty set are 0 instead of NaN",
    ),
    (
        "possibly undefined",
        "ends of literals are compared exactly, so nothing is only possibly undefined",
    ),
    ("decorated text", "there are no decorated intervals"),
];

/// The folder of the vectors, which lie outside the repository.
pub fn folder() -> PathBuf {
    match std::env::var_os("VERIBOUND_SHARED") {
        Some(shared) => PathBuf::from(shared).join("data/itf1788"),
        None => PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/itf1788"),
    }
}

/// All vectors in order of the files' names, or the reason ([`LEFT_OUT`]) and text of one that is left
/// out; `None` where the folder is absent.
pub fn vectors() -> Option<Vec<Result<Vector, (&'static str, String)>>> {
    let files = std::fs::read_dir(folder()).ok()?;
    let mut paths: Vec<PathBuf> = files
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "itl"))
        .collect();
    paths.sort();
    let mut vectors = Vec::new();
    for path in &paths {
        let file = path.file_name().unwrap().to_string_lossy();
        let text = std::fs::read_to_string(path).unwrap();
        for statement in statements(&text) {
            vectors.push(read(&file, &statement));
        }
    }
    Some(vectors)
}

fn read(file: &str, statement: &str) -> Result<Vector, (&'static str, String)> {
    let (call, expected) = statement.split_once('=').unwrap();
    let mut call = words(call);
    let operation = call.remove(0);
    let decorated = |word: &String| word.starts_with('"') && word.contains('_');
    let reason = if statement.contains("signal Possibly") {
        Some("possibly undefined")
    } else if statement.contains("_ill")
        || (statement.contains("[nai]") && !is_constructor(&operation))
    {
        Some("[nai]")
    } else if expected.contains("NaN") {
        Some("NaN")
    } else if operation == "d-textToInterval" && call.iter().any(decorated) {
        Some("decorated text")
    } else {
        None
    };
    if let Some(reason) = reason {
        return Err((reason, statement.to_string()));
    }
    // A constructor that signals has no result here, where the standard has the empty set or NaI.
    let results = if expected.contains("signal Undefined") || expected.trim() == "[nai]" {
        vec![Item::Refused]
    } else {
        let tight = expected.split("<=").next().unwrap();
        words(tight).iter().map(|word| item(word)).collect()
    };
    Ok(Vector {
        file: file.to_string(),
        text: statement.to_string(),
        operation,
        arguments: call.iter().map(|word| item(word)).collect(),
        results,
    })
}

fn is_constructor(operation: &str) -> bool {
    operation.ends_with("textToInterval") || operation.ends_with("numsToInterval")
}

/// Statements without comments and the frames of test cases, in one line each.
fn statements(text: &str) -> Vec<String> {
    let mut plain = String::new();
    let mut rest = text;
    while let Some(start) = rest.find("/*") {
        plain.push_str(&rest[..start]);
        rest = rest[start..]
            .find("*/")
            .map_or("", |end| &rest[start + end + 2..]);
    }
    plain.push_str(rest);
    let lines = plain
        .lines()
        .map(|line| line.split("//").next().unwrap_or("").trim());
    lines
        .collect::<Vec<_>>()
        .join(" ")
        .split(';')
        .map(|chunk| match chunk.find("testcase") {
            Some(frame) => chunk[frame..].split_once('{').unwrap().1.trim().to_string(),
            None => chunk.trim().to_string(),
        })
        .filter(|statement| statement.contains('='))
        .collect()
}

/// Splits at blanks outside brackets and quotes.
fn words(text: &str) -> Vec<String> {
    let (mut words, mut word, mut depth, mut quoted) = (Vec::new(), String::new(), 0, false);
    for c in text.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            _ => {}
        }
        if c.is_whitespace() && depth == 0 && !quoted {
            if !word.is_empty() {
                words.push(std::mem::take(&mut word));
            }
        } else {
            word.push(c);
        }
    }
    if !word.is_empty() {
        words.push(word);
    }
    words
}

fn item(word: &str) -> Item {
    if let Some(text) = word.strip_prefix('"') {
        return Item::Text(text.trim_end_matches('"').to_string());
    }
    match word {
        "true" => Item::Claim(true),
        "false" => Item::Claim(false),
        "NaN" => Item::Number(f64::NAN),
        _ => set(word)
            .or_else(|| number(word).map(Item::Number))
            .unwrap_or_else(|| Item::Word(word.to_string())),
    }
}

fn set(word: &str) -> Option<Item> {
    let (bare, decoration) = match word.rsplit_once("]_") {
        Some((bare, decoration)) => {
            let decoration = match decoration {
                "trv" => Decoration::Trv,
                "def" => Decoration::Def,
                "dac" => Decoration::Dac,
                "com" => Decoration::Com,
                _ => return None,
            };
            (bare, Some(decoration))
        }
        None => (word.strip_suffix(']')?, None),
    };
    let inner = bare.strip_prefix('[')?.trim();
    let set = match inner.to_ascii_lowercase().as_str() {
        "empty" => Interval::EMPTY,
        "entire" => Interval::ENTIRE,
        _ => {
            let (lo, hi) = inner.split_once(',').unwrap_or((inner, inner));
            Interval::new(number(lo.trim())?, number(hi.trim())?)?
        }
    };
    Some(Item::Set(set, decoration))
}

/// A number literal: decimal or hexadecimal, read as the nearest float.
fn number(text: &str) -> Option<f64> {
    let lower = text.to_ascii_lowercase();
    let (negative, size) = match lower.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, lower.strip_prefix('+').unwrap_or(&lower)),
    };
    let value = match size {
        "inf" | "infinity" => f64::INFINITY,
        _ => match size.strip_prefix("0x") {
            Some(hex) => hexadecimal(hex)?,
            None => size.parse().ok().filter(|x: &f64| x.is_finite())?,
        },
    };
    Some(if negative { -value } else { value })
}

/// `h.hhhp±d`, exact for the literals of the vectors (at most 64 significant bits that fit a float).
fn hexadecimal(text: &str) -> Option<f64> {
    let (mantissa, exponent) = text.split_once('p')?;
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).ok()?;
    let mut exponent: i32 = exponent.trim_start_matches('+').parse().ok()?;
    exponent -= 4 * fraction.len() as i32;
    let mut value = digits as f64;
    // Two steps, so that neither the factor nor the intermediate leaves the range of floats.
    while exponent < -1000 {
        value *= 2_f64.powi(-200);
        exponent += 200;
    }
    while exponent > 900 {
        value *= 2_f64.powi(100);
        exponent -= 100;
    }
    Some(value * 2_f64.powi(exponent))
}
