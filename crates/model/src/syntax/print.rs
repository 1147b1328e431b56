//! Writes an equation or condition: the text that the reader makes the same tree of, with no more
//! brackets than it needs.

use crate::model::Relation;
use crate::syntax::ast::{Arithmetic, Ast, Kind};
use crate::syntax::strength;
use std::fmt;

impl fmt::Display for Ast {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write(self, strength::ANY, f)
    }
}

/// Writes `ast` where the reader goes on over operators that bind as tightly as `loosest` or more.
fn write(ast: &Ast, loosest: u8, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let in_brackets = binds(&ast.kind) < loosest;
    if in_brackets {
        f.write_str("(")?;
    }
    match &ast.kind {
        Kind::Number(number) => write!(f, "{number}")?,
        Kind::Name(name) => f.write_str(name)?,
        Kind::Always => f.write_str("true")?,
        Kind::Negate(a) => {
            f.write_str("-")?;
            write(a, strength::SIGN, f)?;
        }
        Kind::Arithmetic(operation, a, b) => {
            let (symbol, left, right) = match operation {
                Arithmetic::Add => (" + ", strength::SUM, strength::PRODUCT),
                Arithmetic::Subtract => (" - ", strength::SUM, strength::PRODUCT),
                Arithmetic::Multiply => ("*", strength::PRODUCT, strength::SIGN),
                Arithmetic::Divide => ("/", strength::PRODUCT, strength::SIGN),
            };
            write(a, left, f)?;
            f.write_str(symbol)?;
            write(b, right, f)?;
        }
        Kind::Power(a, b) => {
            write(a, strength::ALONE, f)?;
            f.write_str("^")?;
            write(b, strength::SIGN, f)?;
        }
        Kind::Call(function, arguments) => {
            write!(f, "{}(", function.name())?;
            for (position, argument) in arguments.iter().enumerate() {
                if position > 0 {
                    f.write_str(", ")?;
                }
                write(argument, strength::ANY, f)?;
            }
            f.write_str(")")?;
        }
        Kind::Compare(relation, a, b) => {
            write(a, strength::SUM, f)?;
            f.write_str(match relation {
                Relation::Less => " < ",
                Relation::LessEqual => " <= ",
                Relation::Greater => " > ",
                Relation::GreaterEqual => " >= ",
                Relation::Equal => " == ",
                Relation::NotEqual => " != ",
            })?;
            write(b, strength::SUM, f)?;
        }
        Kind::And(a, b) => {
            write(a, strength::AND, f)?;
            f.write_str(" and ")?;
            write(b, strength::NOT, f)?;
        }
        Kind::Or(a, b) => {
            write(a, strength::OR, f)?;
            f.write_str(" or ")?;
            write(b, strength::AND, f)?;
        }
        Kind::Not(a) => {
            f.write_str("not ")?;
            write(a, strength::NOT, f)?;
        }
        Kind::If(condition, yes, no) => {
            f.write_str("if ")?;
            write(condition, strength::ANY, f)?;
            f.write_str(" then ")?;
            write(yes, strength::ANY, f)?;
            f.write_str(" else ")?;
            write(no, strength::ANY, f)?;
        }
    }
    if in_brackets {
        f.write_str(")")?;
    }
    Ok(())
}

/// How tightly the outermost operator binds.
fn binds(kind: &Kind) -> u8 {
    match kind {
        Kind::Number(_) | Kind::Name(_) | Kind::Always | Kind::Call(..) => strength::ALONE,
        Kind::Negate(_) => strength::SIGN,
        Kind::Arithmetic(Arithmetic::Add | Arithmetic::Subtract, _, _) => strength::SUM,
        Kind::Arithmetic(Arithmetic::Multiply | Arithmetic::Divide, _, _) => strength::PRODUCT,
        Kind::Power(..) => strength::POWER,
        Kind::Compare(..) => strength::COMPARE,
        Kind::And(..) => strength::AND,
        Kind::Or(..) => strength::OR,
        Kind::Not(_) => strength::NOT,
        // It reaches as far to the right as it can.
        Kind::If(..) => strength::ANY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::syntax::ast::Function;
    use crate::syntax::parse;
    use std::path::Path;
    use std::sync::Arc;
    use toml::Value;
    use veribound_interval::Decimal;

    /// Equal but for the places.
    fn same(a: &Ast, b: &Ast) -> bool {
        let heads = match (&a.kind, &b.kind) {
            (Kind::Number(a), Kind::Number(b)) => a == b,
            (Kind::Name(a), Kind::Name(b)) => a == b,
            (Kind::Arithmetic(a, _, _), Kind::Arithmetic(b, _, _)) => a == b,
            (Kind::Call(a, _), Kind::Call(b, _)) => a == b,
            (Kind::Compare(a, _, _), Kind::Compare(b, _, _)) => a == b,
            (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
        };
        let (a, b) = (a.kind.children(), b.kind.children());
        heads && a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
    }

    /// Written and read again.
    fn comes_back(ast: &Ast) {
        let text = ast.to_string();
        match parse::expression(&text) {
            Ok(again) => assert!(same(ast, &again), "{text} is read as {again}"),
            Err(problems) => panic!("{text}: {problems:?}"),
        }
    }

    struct Dice(u64);

    impl Dice {
        fn below(&mut self, limit: usize) -> usize {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((self.0 >> 33) as usize) % limit
        }
    }

    fn node(kind: Kind) -> Ast {
        Ast::new(kind, 0..0)
    }

    fn value(dice: &mut Dice, levels: usize) -> Ast {
        let inner = |dice: &mut Dice| Arc::new(value(dice, levels.saturating_sub(1)));
        if levels == 0 {
            let numbers = [
                "0",
                "7",
                "0.1",
                "2.50",
                "1e-3",
                "123456789012345678901",
                "6.02e23",
            ];
            return node(match dice.below(3) {
                0 => Kind::Number(Decimal::parse(numbers[dice.below(numbers.len())]).unwrap()),
                _ => Kind::Name(["x", "omega_2", "φ", "pi"][dice.below(4)].to_string()),
            });
        }
        node(match dice.below(9) {
            0 => Kind::Negate(inner(dice)),
            1..=4 => {
                let operations = [
                    Arithmetic::Add,
                    Arithmetic::Subtract,
                    Arithmetic::Multiply,
                    Arithmetic::Divide,
                ];
                Kind::Arithmetic(operations[dice.below(4)], inner(dice), inner(dice))
            }
            5 => Kind::Power(inner(dice), inner(dice)),
            6 => {
                let yes = inner(dice);
                Kind::If(Arc::new(condition(dice, levels - 1)), yes, inner(dice))
            }
            _ => {
                let (_, function) = Function::NAMES[dice.below(Function::NAMES.len())];
                let (fewest, most, _) = function.arguments();
                let count = fewest + dice.below(most.min(fewest + 2) - fewest + 1);
                let arguments = (0..count).map(|_| value(dice, levels / 2)).collect();
                Kind::Call(function, arguments)
            }
        })
    }

    fn condition(dice: &mut Dice, levels: usize) -> Ast {
        let inner = |dice: &mut Dice| Arc::new(condition(dice, levels.saturating_sub(1)));
        let relations = [
            Relation::Less,
            Relation::LessEqual,
            Relation::Greater,
            Relation::GreaterEqual,
            Relation::Equal,
            Relation::NotEqual,
        ];
        node(match dice.below(if levels == 0 { 2 } else { 6 }) {
            0 if levels == 0 => Kind::Always,
            0 | 1 => Kind::Compare(
                relations[dice.below(6)],
                Arc::new(value(dice, levels)),
                Arc::new(value(dice, levels)),
            ),
            2 => Kind::Not(inner(dice)),
            3 | 4 => Kind::And(inner(dice), inner(dice)),
            _ => Kind::Or(inner(dice), inner(dice)),
        })
    }

    #[test]
    fn random_equations_come_back() {
        let mut dice = Dice(3);
        for round in 0..20_000 {
            let levels = round % 6;
            comes_back(&value(&mut dice, levels));
            comes_back(&condition(&mut dice, levels));
        }
    }

    #[test]
    fn brackets_only_where_they_are_needed() {
        for text in [
            "-x^2*y - (a - b)/(c*d)",
            "(-x)^2^-3 + a*-b",
            "not (a < b or c == 0) and d > 1 or not e != f and true",
            "2*(if a > 0 then x else if b > 0 then y else -z) + (x + y) - (x + y)",
            "a - (b - c) - d*(e/f)/g",
            "table(x, 0, if a > b then 1 else 2, 1, -0.5)",
        ] {
            let read = |text| parse::expression(text).map(|ast| ast.to_string());
            assert_eq!(read(text), Ok(text.to_string()));
        }
    }

    /// Every string in a model file that is an equation.
    fn equations(value: &Value, found: &mut Vec<Ast>) {
        match value {
            Value::String(text) => found.extend(parse::expression(text)),
            Value::Array(items) => items.iter().for_each(|item| equations(item, found)),
            Value::Table(table) => table.values().for_each(|item| equations(item, found)),
            _ => {}
        }
    }

    #[test]
    fn equations_of_the_examples_come_back() {
        let mut found = Vec::new();
        let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
        for folder in std::fs::read_dir(examples).unwrap() {
            for file in std::fs::read_dir(folder.unwrap().path()).unwrap() {
                let path = file.unwrap().path();
                if path.extension().is_some_and(|end| end == "toml") {
                    let text = std::fs::read_to_string(path).unwrap();
                    equations(&toml::from_str(&text).unwrap(), &mut found);
                }
            }
        }
        assert!(found.len() > 100, "{}", found.len());
        found.iter().for_each(comes_back);
    }
}
