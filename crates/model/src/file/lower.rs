//! From written equations to the expression graph.
//!
//! Set-valued functions of states (`sign`, `friction`, `if`) become placeholders here; the modes they
//! stand for are made in [`crate::file::modes`].

mod calls;
mod guards;
mod switches;

pub(crate) use guards::{both, either, negated};
pub(crate) use switches::Switch;

use crate::file::scope::{Equation, Meaning, Scope};
use crate::graph::{Binary, ExprId, Graph, Unary, Var};
use crate::model::{Guard, Relation};
use crate::syntax::Problem;
use crate::syntax::ast::{Arithmetic, Ast, Kind};
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive, Zero};

/// Powers beyond this are a mistake.
const LARGEST_POWER: i32 = 1000;
/// Exact constants beyond this many bits are a mistake, and would fill the memory.
const MOST_BITS: u64 = 16_384;

/// An exponent.
enum Exponent {
    Whole(i32),
    /// A number that is not whole, or an expression.
    Real(ExprId),
}

/// The graph under construction.
pub(crate) struct Lowering<'s> {
    pub graph: Graph,
    scope: &'s Scope,
    /// One for each `[let]`, once it is known.
    pub lets: Vec<Option<ExprId>>,
    /// Switch `i` stands in the graph as parameter `params + i`, which no model has.
    pub switches: Vec<Switch>,
    /// Conditions of every `if`.
    pub conditions: Vec<Guard>,
    params: usize,
}

impl<'s> Lowering<'s> {
    pub fn new(scope: &'s Scope, params: usize, lets: usize) -> Self {
        Lowering {
            graph: Graph::default(),
            scope,
            lets: vec![None; lets],
            switches: Vec::new(),
            conditions: Vec::new(),
            params,
        }
    }

    /// `e` with quantities replaced.
    pub fn replaced(&mut self, e: ExprId, values: &[(Var, ExprId)]) -> ExprId {
        self.graph.substitute(e, &|var| {
            values
                .iter()
                .find(|(known, _)| *known == var)
                .map(|(_, value)| *value)
        })
    }

    /// A right-hand side: set-valued functions stay placeholders.
    pub fn right_hand_side(&mut self, equation: &Equation) -> Result<ExprId, Vec<Problem>> {
        let mut problems = Vec::new();
        self.value(&equation.ast, &mut problems).ok_or(problems)
    }

    /// An expression that is measured or proved; `friction` is refused.
    pub fn plain(&mut self, ast: &Ast) -> Result<ExprId, Vec<Problem>> {
        let mut problems = Vec::new();
        self.value(ast, &mut problems)
            .and_then(|e| self.without_switches(e, ast, &mut problems))
            .ok_or(problems)
    }

    /// An expression whose range holds all values that a term of a right-hand side can have.
    pub fn spanned(&mut self, ast: &Ast) -> Option<ExprId> {
        let mut problems = Vec::new();
        let e = self.value(ast, &mut problems)?;
        self.unswitched(e, true)
    }

    /// The guard of a mode.
    pub fn guard(&mut self, equation: &Equation) -> Result<Guard, Vec<Problem>> {
        let mut problems = Vec::new();
        self.condition(&equation.ast, false, &mut problems)
            .ok_or(problems)
    }

    /// The two sides of `a == b` as `a - b`.
    pub fn equality(&mut self, equation: &Equation) -> Result<ExprId, Vec<Problem>> {
        if let Kind::Compare(Relation::Equal, a, b) = &equation.ast.kind {
            let a = self.plain(a)?;
            let b = self.plain(b)?;
            return Ok(self.graph.sub(a, b));
        }
        Err(vec![Problem::new(
            "E0116",
            "a signal can prove only an equality",
            equation.ast.range.clone(),
            "not of the form a == b",
            "write an equality, as in \"omega == 0\"; several go into a list",
        )])
    }

    /// `None` when something was reported or depends on what was reported elsewhere.
    fn value(&mut self, ast: &Ast, problems: &mut Vec<Problem>) -> Option<ExprId> {
        let value = match &ast.kind {
            Kind::Number(number) => self.graph.constant(number.to_rational()),
            Kind::Name(name) => self.named(name, ast, problems)?,
            Kind::Negate(a) => {
                let a = self.value(a, problems)?;
                self.graph.neg(a)
            }
            Kind::Arithmetic(operation, a, b) => {
                let (left, right) = (self.value(a, problems), self.value(b, problems));
                self.arithmetic(*operation, left?, right?, b, problems)?
            }
            Kind::Power(base, exponent) => {
                let base = self.value(base, problems);
                let power = self.exponent(exponent, problems)?;
                self.power(base?, power, ast, problems)?
            }
            Kind::Call(function, arguments) => self.call(*function, arguments, ast, problems)?,
            Kind::If(condition, yes, no) => {
                let condition = self.condition(condition, false, problems);
                let (yes, no) = (self.value(yes, problems), self.value(no, problems));
                self.choice(condition?, yes?, no?)
            }
            _ => {
                problems.push(Problem::new(
                    "E0116",
                    "expected a value, found a condition",
                    ast.range.clone(),
                    "a condition",
                    "conditions belong into `when`, or write if condition then value else value",
                ));
                return None;
            }
        };
        let bits = self
            .graph
            .as_constant(value)
            .map_or(0, |c| c.numer().bits().max(c.denom().bits()));
        if bits > MOST_BITS {
            problems.push(too_large(ast));
            return None;
        }
        Some(value)
    }

    fn named(&mut self, name: &str, ast: &Ast, problems: &mut Vec<Problem>) -> Option<ExprId> {
        let var = match self.scope.find(name) {
            Some(Meaning::State(i)) => Var::State(i),
            Some(Meaning::Input(i)) => Var::Input(i),
            Some(Meaning::Param(i)) => Var::Param(i),
            Some(Meaning::Let(i)) => return self.lets.get(i).copied().flatten(),
            Some(Meaning::Size) => {
                problems.push(Problem::new(
                    "E0201",
                    format!("the size `{name}` stands without braces"),
                    ast.range.clone(),
                    "a number of [sizes]",
                    format!("write {{{name}}}"),
                ));
                return None;
            }
            Some(Meaning::Measured(what)) => {
                problems.push(Problem::new(
                    "E0201",
                    format!("`{name}` is {what} and cannot stand in an expression"),
                    ast.range.clone(),
                    "not a state, input, parameter or [let]",
                    "write what it measures instead",
                ));
                return None;
            }
            None if name == "pi" => return Some(self.graph.pi()),
            None => {
                problems.extend(self.scope.unknown(name, ast.range.clone()));
                return None;
            }
        };
        Some(self.graph.var(var))
    }

    fn arithmetic(
        &mut self,
        operation: Arithmetic,
        a: ExprId,
        b: ExprId,
        divisor: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        Some(match operation {
            Arithmetic::Add => self.graph.add(a, b),
            Arithmetic::Subtract => self.graph.sub(a, b),
            Arithmetic::Multiply => self.graph.mul(a, b),
            Arithmetic::Divide => {
                if self.graph.as_constant(b).is_some_and(Zero::is_zero) {
                    problems.push(undefined("a division by zero", divisor, "this is zero"));
                    return None;
                }
                self.graph.div(a, b)
            }
        })
    }

    fn exponent(&mut self, ast: &Ast, problems: &mut Vec<Problem>) -> Option<Exponent> {
        let exponent = self.value(ast, problems)?;
        let Some(constant) = self.graph.as_constant(exponent) else {
            return Some(Exponent::Real(exponent));
        };
        let largest = BigRational::from_integer(LARGEST_POWER.into());
        if constant.abs() > largest {
            problems.push(Problem::new(
                "E0112",
                "the exponent is too large",
                ast.range.clone(),
                format!("expected one from -{LARGEST_POWER} to {LARGEST_POWER}"),
                "write exp(a*log(x)) if such a power is meant",
            ));
            return None;
        }
        let whole = Some(constant).filter(|c| c.is_integer());
        let whole = whole.and_then(|c| c.to_integer().to_i32());
        Some(whole.map_or(Exponent::Real(exponent), Exponent::Whole))
    }

    fn power(
        &mut self,
        base: ExprId,
        exponent: Exponent,
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        let constant = self.graph.as_constant(base);
        let exponent = match exponent {
            Exponent::Whole(exponent) => exponent,
            Exponent::Real(_) if constant.is_some_and(|base| !base.is_positive()) => {
                let what = "a power of a number that is not positive";
                problems.push(undefined(what, ast, "undefined"));
                return None;
            }
            Exponent::Real(exponent) => return Some(self.real_power(base, exponent)),
        };
        if let Some(constant) = constant {
            if constant.is_zero() && exponent <= 0 {
                problems.push(undefined(
                    "a power of zero that is not positive",
                    ast,
                    "undefined",
                ));
                return None;
            }
            let bits = constant.numer().bits().max(constant.denom().bits());
            if bits.saturating_mul(u64::from(exponent.unsigned_abs())) > MOST_BITS {
                problems.push(too_large(ast));
                return None;
            }
        }
        Some(self.graph.powi(base, exponent))
    }

    /// A power whose exponent is no whole number, of a base that is not negative.
    fn real_power(&mut self, base: ExprId, exponent: ExprId) -> ExprId {
        let half = BigRational::new(1.into(), 2.into());
        match self.graph.as_constant(exponent) {
            Some(number) if *number == half => self.graph.unary(Unary::Sqrt, base),
            Some(_) => self.graph.binary(Binary::Pow, base, exponent),
            None => {
                let log = self.graph.unary(Unary::Ln, base);
                let product = self.graph.mul(exponent, log);
                self.graph.unary(Unary::Exp, product)
            }
        }
    }
}

fn undefined(what: &str, ast: &Ast, label: &str) -> Problem {
    Problem::new(
        "E0218",
        format!("{what} has no value"),
        ast.range.clone(),
        label,
        "change the expression so that it has a value",
    )
}

fn too_large(ast: &Ast) -> Problem {
    Problem::new(
        "E0113",
        "a constant has too many digits",
        ast.range.clone(),
        "this value",
        "write it as a decimal number",
    )
}
