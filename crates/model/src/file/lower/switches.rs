//! Set-valued functions as placeholders.

use super::Lowering;
use crate::graph::{ExprId, Unary, Var};
use crate::model::{Guard, Relation};
use crate::syntax::Problem;
use crate::syntax::ast::Ast;

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

impl Lowering<'_> {
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

    /// `e` with `sign` and `if` placeholders as plain set-valued functions, for places that are no
    /// right-hand side.
    ///
    /// # Errors
    /// `friction`, which means something only in a right-hand side.
    pub(super) fn without_switches(
        &mut self,
        e: ExprId,
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
        let plain = self.unswitched(e, false);
        if plain.is_none() {
            problems.push(Problem::new(
                "E0219",
                "`friction` can stand only in a right-hand side",
                ast.range.clone(),
                "contains `friction`",
                "use `friction` in [der] or in `der` of a mode only",
            ));
        }
        plain
    }

    /// `e` with placeholders as plain set-valued functions; `None` where it holds `friction`, unless that may
    /// be all that it spans.
    pub(super) fn unswitched(&mut self, e: ExprId, spans_friction: bool) -> Option<ExprId> {
        let used = self.switches_in(e);
        if used.is_empty() {
            return Some(e);
        }
        let mut values: Vec<(Var, ExprId)> = Vec::new();
        for index in used {
            let switch = self.switches.get(index).copied();
            // Arguments were built before their switch, so their placeholders are replaced already.
            let value = match switch {
                Some(Switch::Sign(argument)) => {
                    let argument = self.replaced(argument, &values);
                    self.graph.unary(Unary::Sign, argument)
                }
                Some(Switch::Choice { condition, yes, no }) => {
                    let (yes, no) = (self.replaced(yes, &values), self.replaced(no, &values));
                    let condition = self.conditions.get(condition).cloned();
                    let test = self.test(&condition.unwrap_or(Guard::Always));
                    self.graph.choose(test, yes, no)
                }
                Some(Switch::Friction {
                    velocity,
                    sliding,
                    breakaway,
                    ..
                }) if spans_friction => {
                    let [velocity, sliding, breakaway] =
                        [velocity, sliding, breakaway].map(|e| self.replaced(e, &values));
                    let (side, level) = (
                        self.graph.unary(Unary::Sign, velocity),
                        self.graph.max(sliding, breakaway),
                    );
                    self.graph.mul(level, side)
                }
                Some(Switch::Friction { .. }) | None => return None,
            };
            values.push((self.placeholder(index), value));
        }
        Some(self.replaced(e, &values))
    }

    /// An expression that is positive inside of where `guard` holds, negative inside of where it does not, and
    /// zero on the border; an equality is zero where it holds.
    fn test(&mut self, guard: &Guard) -> ExprId {
        match guard {
            Guard::Always => self.graph.integer(1),
            Guard::Atom { expr, relation } => match relation {
                Relation::Greater | Relation::GreaterEqual => *expr,
                Relation::Less | Relation::LessEqual => self.graph.neg(*expr),
                Relation::NotEqual => self.graph.unary(Unary::Abs, *expr),
                Relation::Equal => {
                    let size = self.graph.unary(Unary::Abs, *expr);
                    self.graph.neg(size)
                }
            },
            Guard::All(parts) => {
                let tests: Vec<ExprId> = parts.iter().map(|part| self.test(part)).collect();
                let least = tests.into_iter().reduce(|a, b| self.graph.min(a, b));
                least.unwrap_or_else(|| self.graph.integer(1))
            }
            Guard::Any(parts) => {
                let tests: Vec<ExprId> = parts.iter().map(|part| self.test(part)).collect();
                let largest = tests.into_iter().reduce(|a, b| self.graph.max(a, b));
                largest.unwrap_or_else(|| self.graph.integer(-1))
            }
        }
    }

    /// `e` if it holds no set-valued function: whether a guard holds must be one clear question.
    pub(super) fn refuse_switches(
        &self,
        e: ExprId,
        ast: &Ast,
        problems: &mut Vec<Problem>,
    ) -> Option<ExprId> {
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

    pub(super) fn choice(&mut self, condition: Guard, yes: ExprId, no: ExprId) -> ExprId {
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

    pub(super) fn switch(&mut self, switch: Switch) -> ExprId {
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

    pub(super) fn depends_on_state(&self, e: ExprId) -> bool {
        self.graph.variables(e).into_iter().any(|var| match var {
            Var::State(_) => true,
            Var::Param(p) => p >= self.params,
            Var::Input(_) => false,
        })
    }
}
