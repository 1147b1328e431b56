//! From written equations to the expression graph.
//!
//! Set-valued functions of states (`sign`, `friction`) become placeholders here; the modes they
//! stand for are made in [`crate::file::modes`].

use crate::file::scope::{Equation, Meaning, Scope};
use crate::graph::{ExprId, Graph, Unary, Var};
use crate::model::{Guard, Relation};
use crate::syntax::Problem;
use crate::syntax::ast::{Arithmetic, Ast, Function, Kind};
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};

/// Integer powers beyond this are a mistake.
const LARGEST_POWER: i32 = 1000;
/// Exact constants beyond this many bits are a mistake, and would fill the memory.
const MOST_BITS: u64 = 16_384;

/// A set-valued function call that depends on the state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Switch {
    Sign(ExprId),
    Friction {
        velocity: ExprId,
        drive: ExprId,
        sliding: ExprId,
        breakaway: ExprId,
    },
    /// `if condition then yes else no`; the condition by its position in [`Lowering::conditions`].
    Choice {
        condition: usize,
        yes: ExprId,
        no: ExprId,
    },
}

impl Switch {
    /// What the user wrote.
    pub fn word(self) -> &'static str {
        match self {
            Switch::Sign(_) => "sign",
            Switch::Friction { .. } => "friction",
            Switch::Choice { .. } => "if",
        }
    }

    fn operands(self) -> Vec<ExprId> {
        match self {
            Switch::Sign(a) => vec![a],
            Switch::Friction {
                velocity,
                drive,
                sliding,
                breakaway,
            } => vec![velocity, drive, sliding, breakaway],
            Switch::Choice { yes, no, .. } => vec![yes, no],
        }
    }
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

    /// The placeholder of switch `index`.
    pub fn placeholder(&self, index: usize) -> Var {
        Var::Param(self.params + index)
    }

    /// The switches that `e` contains, directly or inside the arguments of others.
    pub fn switches_in(&self, e: ExprId) -> Vec<usize> {
        let mut found = vec![false; self.switches.len()];
        let mut open = vec![e];
        while let Some(e) = open.pop() {
            for var in self.graph.variables(e) {
                let Var::Param(p) = var else { continue };
                let Some(index) = p.checked_sub(self.params) else {
                    continue;
                };
                let (Some(seen), Some(switch)) = (found.get_mut(index), self.switches.get(index))
                else {
                    continue;
                };
                if !std::mem::replace(seen, true) {
                    open.extend(switch.operands());
                }
            }
        }
        (0..found.len())
            .filter(|i| found.get(*i) == Some(&true))
            .collect()
    }

    /// `e` with `sign` placeholders as the plain set-valued function, for places that are no
    /// right-hand side.
    ///
    /// # Errors
    /// `friction` and `if`, which mean something only in a right-hand side.
    fn without_switches(
        &mut self,
        e: ExprId,
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        let used = self.switches_in(e);
        if used.is_empty() {
            return Some(e);
        }
        let mut values: Vec<(Var, ExprId)> = Vec::new();
        for index in used {
            let switch = self.switches.get(index).copied();
            let Some(Switch::Sign(argument)) = switch else {
                let word = switch.map_or("friction", Switch::word);
                problems.push(Problem::new(
                    "E0219",
                    format!("`{word}` can stand only in a right-hand side"),
                    ast.range.clone(),
                    format!("contains `{word}`"),
                    format!("use `{word}` in [der] or in `der` of a mode only"),
                ));
                return None;
            };
            // Arguments were built before their switch, so their placeholders are replaced already.
            let argument = self.replaced(argument, &values);
            let value = self.graph.unary(Unary::Sign, argument);
            values.push((self.placeholder(index), value));
        }
        Some(self.replaced(e, &values))
    }

    /// `e` if it holds no set-valued function: whether a guard holds must be one clear question.
    fn refuse_switches(&self, e: ExprId, ast: &Ast, problems: &mut Vec<Problem>) -> Option<ExprId> {
        if self.switches_in(e).is_empty() {
            return Some(e);
        }
        problems.push(Problem::new(
            "E0219",
            "a condition contains a set-valued function of the state",
            ast.range.clone(),
            "contains `sign`, `friction` or `if`",
            "compare its argument instead, as in \"omega > 0\"",
        ));
        None
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
            Kind::Number(number) => self.graph.constant(number.clone()),
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
                let base = self.value(base, problems)?;
                let exponent = self.exponent(exponent, problems)?;
                self.power(base, exponent, ast, problems)?
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

    fn exponent(&mut self, ast: &Ast, problems: &mut Vec<Problem>) -> Option<i32> {
        let exponent = self.value(ast, problems)?;
        let constant = self.graph.as_constant(exponent);
        let integer = constant
            .filter(|c| c.is_integer())
            .and_then(|c| c.to_integer().to_i32());
        match integer.filter(|n| n.abs() <= LARGEST_POWER) {
            Some(n) => Some(n),
            None => {
                problems.push(Problem::new(
                    "E0112",
                    "the exponent is not an integer",
                    ast.range.clone(),
                    format!("expected an integer from -{LARGEST_POWER} to {LARGEST_POWER}"),
                    "write sqrt(x) for x^0.5, and exp(a*log(x)) for other powers of a positive x",
                ));
                None
            }
        }
    }

    fn power(
        &mut self,
        base: ExprId,
        exponent: i32,
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        if let Some(constant) = self.graph.as_constant(base) {
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

    fn call(
        &mut self,
        function: Function,
        arguments: &[Ast],
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        let values: Vec<Option<ExprId>> = arguments
            .iter()
            .map(|argument| self.value(argument, problems))
            .collect();
        let values: Vec<ExprId> = values.into_iter().collect::<Option<_>>()?;
        match (function, values.as_slice()) {
            (Function::Plain(Unary::Sign), [a]) if self.depends_on_state(*a) => {
                Some(self.switch(Switch::Sign(*a)))
            }
            (Function::Plain(plain), [a]) => {
                let constant = self.graph.as_constant(*a);
                let outside = constant.is_some_and(|c| is_outside(plain, c));
                if outside {
                    let what = format!("`{}` of a number outside of its domain", plain.name());
                    problems.push(undefined(&what, ast, "undefined"));
                    return None;
                }
                Some(self.graph.unary(plain, *a))
            }
            (Function::Min | Function::Max, [first, rest @ ..]) => {
                let mut result = *first;
                for value in rest {
                    result = match function {
                        Function::Min => self.graph.min(result, *value),
                        _ => self.graph.max(result, *value),
                    };
                }
                Some(result)
            }
            (Function::LogTo(base), [a]) => {
                let base = self.graph.integer(base);
                let (above, below) = (
                    self.graph.unary(Unary::Ln, *a),
                    self.graph.unary(Unary::Ln, base),
                );
                Some(self.graph.div(above, below))
            }
            (Function::Saturation | Function::DeadZone, [x, limits @ ..]) => {
                let (lower, upper) = match limits {
                    [limit] => (self.graph.neg(*limit), *limit),
                    [lower, upper] => (*lower, *upper),
                    _ => return None,
                };
                if self.are_reversed(lower, upper) {
                    problems.push(Problem::new(
                        "E0231",
                        "the lower limit is above the upper one",
                        ast.range.clone(),
                        "limits in the wrong order",
                        "write the lower limit first",
                    ));
                    return None;
                }
                Some(match function {
                    Function::Saturation => self.saturation(*x, lower, upper),
                    _ => self.dead_zone(*x, lower, upper),
                })
            }
            (Function::Table, [x, points @ ..]) => self.table(*x, points, arguments, ast, problems),
            (Function::Friction, [velocity, drive, sliding, rest @ ..]) => {
                let (velocity, drive, sliding) = (*velocity, *drive, *sliding);
                let breakaway = rest.first().copied().unwrap_or(sliding);
                if !self.depends_on_state(velocity) {
                    problems.push(Problem::new(
                        "E0219",
                        "the velocity of `friction` depends on no state",
                        arguments.first().unwrap_or(ast).range.clone(),
                        "expected a velocity",
                        "write friction(velocity, drive, level)",
                    ));
                    return None;
                }
                Some(self.switch(Switch::Friction {
                    velocity,
                    drive,
                    sliding,
                    breakaway,
                }))
            }
            // A wrong number of arguments was reported by the parser.
            _ => None,
        }
    }

    fn choice(&mut self, condition: Guard, yes: ExprId, no: ExprId) -> ExprId {
        if condition == Guard::Always || yes == no {
            return yes;
        }
        let known = self.conditions.iter().position(|c| *c == condition);
        let condition = known.unwrap_or_else(|| {
            self.conditions.push(condition);
            self.conditions.len() - 1
        });
        self.switch(Switch::Choice { condition, yes, no })
    }

    fn are_reversed(&self, lower: ExprId, upper: ExprId) -> bool {
        let ends = (self.graph.as_constant(lower), self.graph.as_constant(upper));
        matches!(ends, (Some(lower), Some(upper)) if lower > upper)
    }

    fn saturation(&mut self, x: ExprId, lower: ExprId, upper: ExprId) -> ExprId {
        let above = self.graph.max(x, lower);
        self.graph.min(above, upper)
    }

    /// Zero between the limits, beyond them the distance to them.
    fn dead_zone(&mut self, x: ExprId, lower: ExprId, upper: ExprId) -> ExprId {
        let zero = self.graph.integer(0);
        let (above, below) = (self.graph.sub(x, upper), self.graph.sub(x, lower));
        let (above, below) = (self.graph.max(above, zero), self.graph.min(below, zero));
        self.graph.add(above, below)
    }

    /// Straight lines between points, constant beyond the first and the last; two points above each
    /// other are a jump.
    ///
    /// As a sum of saturated pieces, one per line: where the table is monotone so is each piece, and
    /// ranges stay tight.
    fn table(
        &mut self,
        x: ExprId,
        points: &[ExprId],
        arguments: &[Ast],
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        let (pairs, []) = points.as_chunks::<2>() else {
            problems.push(Problem::new(
                "E0114",
                "the last point of the table has no value",
                arguments.last().unwrap_or(ast).range.clone(),
                "no value for this",
                "write points in pairs: table(x, x0, y0, x1, y1, ...)",
            ));
            return None;
        };
        let mut sum = pairs.first()?[1];
        let (mut jumped, mut fine) = (false, true);
        for (pair, position) in pairs.windows(2).zip((3..).step_by(2)) {
            let [[from, before], [to, after]] = *pair else {
                continue;
            };
            let width = self.graph.sub(to, from);
            let width = self.graph.as_constant(width).cloned();
            let rise = self.graph.sub(after, before);
            let piece = match width {
                Some(width) if width.is_positive() => {
                    let run = self.graph.constant(width);
                    let slope = self.graph.div(rise, run);
                    let along = self.saturation(x, from, to);
                    let along = self.graph.sub(along, from);
                    jumped = false;
                    self.graph.mul(slope, along)
                }
                Some(width) if width.is_zero() && !jumped => {
                    jumped = true;
                    self.step_at(x, from, rise)
                }
                _ => {
                    problems.push(Problem::new(
                        "E0230",
                        "the points of the table are not in order",
                        arguments.get(position).unwrap_or(ast).range.clone(),
                        "not a number above the one before",
                        "write numbers that grow; a number may stand twice for a jump",
                    ));
                    fine = false;
                    continue;
                }
            };
            sum = self.graph.add(sum, piece);
        }
        fine.then_some(sum)
    }

    /// 0 below `at`, `rise` above it, everything between at it.
    fn step_at(&mut self, x: ExprId, at: ExprId, rise: ExprId) -> ExprId {
        let gap = self.graph.sub(x, at);
        let side = if self.depends_on_state(gap) {
            self.switch(Switch::Sign(gap))
        } else {
            self.graph.unary(Unary::Sign, gap)
        };
        let (one, two) = (self.graph.integer(1), self.graph.integer(2));
        let double = self.graph.add(one, side);
        let share = self.graph.div(double, two);
        self.graph.mul(rise, share)
    }

    fn depends_on_state(&self, e: ExprId) -> bool {
        self.graph.variables(e).into_iter().any(|var| match var {
            Var::State(_) => true,
            Var::Param(p) => p >= self.params,
            Var::Input(_) => false,
        })
    }

    fn switch(&mut self, switch: Switch) -> ExprId {
        let index = self
            .switches
            .iter()
            .position(|known| *known == switch)
            .unwrap_or_else(|| {
                self.switches.push(switch);
                self.switches.len() - 1
            });
        let placeholder = self.placeholder(index);
        self.graph.var(placeholder)
    }

    fn condition(&mut self, ast: &Ast, negate: bool, problems: &mut Vec<Problem>) -> Option<Guard> {
        match &ast.kind {
            Kind::Always if !negate => Some(Guard::Always),
            Kind::Always => {
                problems.push(Problem::new(
                    "E0116",
                    "a condition is never true",
                    ast.range.clone(),
                    "negated",
                    "remove it",
                ));
                None
            }
            Kind::Not(a) => self.condition(a, !negate, problems),
            Kind::And(a, b) | Kind::Or(a, b) => {
                let conjunction = matches!(ast.kind, Kind::And(..)) != negate;
                let (a, b) = (
                    self.condition(a, negate, problems),
                    self.condition(b, negate, problems),
                );
                Some(if conjunction {
                    both(a?, b?)
                } else {
                    either(a?, b?)
                })
            }
            Kind::Compare(relation, a, b) => {
                let (left, right) = (self.value(a, problems), self.value(b, problems));
                let left = self.refuse_switches(left?, a, problems)?;
                let right = self.refuse_switches(right?, b, problems)?;
                let relation = if negate {
                    opposite(*relation)
                } else {
                    *relation
                };
                Some(Guard::Atom {
                    expr: self.graph.sub(left, right),
                    relation,
                })
            }
            _ => {
                problems.push(Problem::new(
                    "E0116",
                    "expected a condition, found a value",
                    ast.range.clone(),
                    "a value",
                    "compare it with something, as in \"omega > 0\"",
                ));
                None
            }
        }
    }
}

/// Both hold.
pub(crate) fn both(a: Guard, b: Guard) -> Guard {
    match (a, b) {
        (Guard::Always, other) | (other, Guard::Always) => other,
        (Guard::All(mut list), Guard::All(more)) => {
            list.extend(more);
            Guard::All(list)
        }
        (Guard::All(mut list), other) => {
            list.push(other);
            Guard::All(list)
        }
        (first, Guard::All(mut list)) => {
            list.insert(0, first);
            Guard::All(list)
        }
        (a, b) => Guard::All(vec![a, b]),
    }
}

/// At least one holds.
pub(crate) fn either(a: Guard, b: Guard) -> Guard {
    match (a, b) {
        (Guard::Always, _) | (_, Guard::Always) => Guard::Always,
        (Guard::Any(mut list), Guard::Any(more)) => {
            list.extend(more);
            Guard::Any(list)
        }
        (Guard::Any(mut list), other) => {
            list.push(other);
            Guard::Any(list)
        }
        (first, Guard::Any(mut list)) => {
            list.insert(0, first);
            Guard::Any(list)
        }
        (a, b) => Guard::Any(vec![a, b]),
    }
}

/// True where `guard` is not; nothing is true where `guard` always is.
pub(crate) fn negated(guard: &Guard) -> Guard {
    match guard {
        Guard::Always => Guard::Any(Vec::new()),
        Guard::Atom { expr, relation } => Guard::Atom {
            expr: *expr,
            relation: opposite(*relation),
        },
        Guard::All(parts) => Guard::Any(parts.iter().map(negated).collect()),
        Guard::Any(parts) => Guard::All(parts.iter().map(negated).collect()),
    }
}

/// Whether a function has no value at a number.
fn is_outside(function: Unary, x: &BigRational) -> bool {
    let one = BigRational::one();
    match function {
        Unary::Sqrt => x.is_negative(),
        Unary::Ln => !x.is_positive(),
        Unary::Asin | Unary::Acos => x.abs() > one,
        Unary::Acosh => *x < one,
        Unary::Atanh => x.abs() >= one,
        _ => false,
    }
}

fn opposite(relation: Relation) -> Relation {
    match relation {
        Relation::Less => Relation::GreaterEqual,
        Relation::LessEqual => Relation::Greater,
        Relation::Greater => Relation::LessEqual,
        Relation::GreaterEqual => Relation::Less,
        Relation::Equal => Relation::NotEqual,
        Relation::NotEqual => Relation::Equal,
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
