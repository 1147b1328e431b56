//! Which instructions serve one branch of a choice alone.
//!
//! A branch that is not taken on a box need not be defined there: `if x > 0 then sqrt(x) else 0` has a value at
//! `x = -1`. So what its instructions say of themselves must not count, neither how regular they are nor, on the
//! way back, that a result is impossible. Every choice has two scopes, its yes and its no. An instruction
//! belongs to the innermost scope that all uses of its result lie in; scope 0 is outside of all choices.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: registers and scopes as the compiler numbered them"
)]

use super::{NO_REGISTER, Op, Tape};

impl Tape {
    /// Number of scopes, beside 0.
    pub(super) fn scopes(&self) -> usize {
        2 * self.branches.len()
    }

    /// Sets the scope of every instruction.
    pub(super) fn set_scopes(&mut self) {
        if self.branches.is_empty() {
            return;
        }
        // The scope around each scope.
        let mut around = vec![0_u32; self.scopes() + 1];
        let mut of_register: Vec<Option<u32>> = vec![None; self.register_count];
        for output in &self.outputs {
            of_register[*output as usize] = Some(0);
        }
        // Uses come after what they use.
        for step in self.instructions.iter_mut().rev() {
            step.scope = of_register[step.out as usize].unwrap_or(0);
            let mut uses = vec![(step.a, step.scope)];
            if let Op::Choose(number) = step.op {
                let Some(branches) = self.branches.get(number as usize) else {
                    continue;
                };
                let (yes, no) = branches.scopes;
                around[yes as usize] = step.scope;
                around[no as usize] = step.scope;
                uses.extend([(step.b, yes), (branches.no.0, no)]);
            } else {
                uses.push((step.b, step.scope));
            }
            for (register, scope) in uses {
                if register != NO_REGISTER {
                    let known = &mut of_register[register as usize];
                    *known = Some(known.map_or(scope, |known| common(&around, known, scope)));
                }
            }
        }
    }
}

/// The innermost scope around both.
fn common(around: &[u32], one: u32, other: u32) -> u32 {
    let way_in = |mut scope: u32| {
        let mut path = vec![scope];
        while scope != 0 {
            scope = around[scope as usize];
            path.push(scope);
        }
        path.into_iter().rev()
    };
    let mut shared = way_in(one).zip(way_in(other)).take_while(|(a, b)| a == b);
    shared.by_ref().last().map_or(0, |(scope, _)| scope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::{Graph, Unary, Var};
    use crate::tape::Layout;

    #[test]
    fn instructions_belong_to_the_innermost_scope_of_their_uses() {
        let mut graph = Graph::default();
        let x = graph.var(Var::State(0));
        let call = |graph: &mut Graph, function, e| graph.unary(function, e);
        let (only_yes, both, outside) = (
            call(&mut graph, Unary::Exp, x),
            call(&mut graph, Unary::Sin, x),
            call(&mut graph, Unary::Cos, x),
        );
        let deep = call(&mut graph, Unary::Atan, x);
        let (test, other) = (graph.var(Var::State(1)), graph.var(Var::State(2)));
        let sum = graph.add(deep, both);
        let inner = graph.choose(other, sum, outside);
        let yes = graph.add(only_yes, inner);
        let choice = graph.choose(test, yes, both);
        let root = graph.add(choice, outside);
        let layout = Layout {
            states: 3,
            params: 0,
            inputs: 0,
        };
        let tape = Tape::compile(&graph, layout, &[root]);
        let scope = |function: Unary| {
            let mut steps = tape.instructions.iter();
            let found = steps.find(|step| matches!(step.op, Op::Unary(f) if f == function));
            found.unwrap().scope
        };
        // The inner choice is compiled first.
        assert_eq!(scope(Unary::Atan), 1);
        assert_eq!(scope(Unary::Exp), 3);
        assert_eq!(scope(Unary::Sin), 0);
        assert_eq!(scope(Unary::Cos), 0);
    }
}
