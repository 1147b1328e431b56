//! What a model's expressions tell about splitting: guards, switching states, terms of velocities.
use veribound_interval::Interval;
use veribound_model::{Binary, ExprId, Graph, Guard, Layout, Model, Node, Tape, Unary, Var};

/// An expression with registers of its own, so that its range costs no allocation.
#[derive(Debug, Clone)]
pub(super) struct Ranged {
    tape: Tape,
    registers: Vec<Interval>,
}

impl Ranged {
    fn compile(graph: &Graph, layout: Layout, expr: ExprId) -> Ranged {
        let tape = Tape::compile(graph, layout, &[expr]);
        let registers = tape.registers();
        Ranged { tape, registers }
    }

    /// Encloses the expression on the box `q`, in the order of the layout.
    pub(super) fn range(&mut self, q: &[Interval]) -> Interval {
        self.tape.eval(q, &mut self.registers);
        self.tape.output(0, &self.registers)
    }

    /// Removes from `q` what cannot give a value in `target`; false when nothing is left.
    pub(super) fn contract(&mut self, q: &mut [Interval], target: Interval) -> bool {
        self.tape.contract(q, target, &mut self.registers)
    }
}

/// A comparison in a guard that depends on parameters.
#[derive(Debug, Clone)]
pub(super) struct ParameterGuard {
    pub(super) difference: Ranged,
    pub(super) params: Vec<usize>,
}

/// A state whose guards compare it with a constant.
#[derive(Debug, Clone)]
pub(super) struct SwitchingState {
    pub(super) state: usize,
    pub(super) levels: Vec<Interval>,
}

/// One summand of a velocity, with the parameters in it that no guard compares (with all of them
/// when guards compare each).
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub(super) value: Ranged,
    pub(super) params: Vec<usize>,
}

/// The derivative of a velocity with respect to a parameter.
#[derive(Debug, Clone)]
pub(super) struct Slope {
    pub(super) value: Ranged,
    pub(super) param: usize,
}

/// The comparisons of all guards, sorted by what they depend on.
pub(super) fn comparisons(
    model: &Model,
    graph: &mut Graph,
    layout: Layout,
) -> (Vec<ParameterGuard>, Vec<SwitchingState>) {
    let mut atoms = Vec::new();
    for mode in &model.modes {
        collect_atoms(&mode.guard, &mut atoms);
    }
    atoms.sort();
    atoms.dedup();
    let mut guards = Vec::new();
    let mut switching: Vec<SwitchingState> = Vec::new();
    for expr in atoms {
        let params = params_of(graph, expr);
        if !params.is_empty() {
            let difference = Ranged::compile(graph, layout, expr);
            guards.push(ParameterGuard { difference, params });
        } else if let Some(level) = graph.level(expr) {
            match switching
                .iter_mut()
                .find(|known| known.state == level.state)
            {
                Some(known) => known.levels.push(level.value),
                None => switching.push(SwitchingState {
                    state: level.state,
                    levels: vec![level.value],
                }),
            }
        }
    }
    (guards, switching)
}

/// States that an output measures, alone.
pub(super) fn measured_states(model: &Model) -> Vec<usize> {
    let only_state = |expr| match model.graph.variables(expr)[..] {
        [Var::State(state)] => Some(state),
        _ => None,
    };
    let outputs = model.outputs.iter();
    outputs.filter_map(|y| only_state(y.expr)).collect()
}

/// Per mode, how the velocities of the states in `moved`, and their values after jumps, depend on the
/// parameters.
pub(super) fn slopes(
    model: &Model,
    graph: &mut Graph,
    layout: Layout,
    moved: &[usize],
) -> Vec<Vec<Slope>> {
    let mut slopes = Vec::new();
    for mode in 0..model.modes.len() {
        let mut list = Vec::new();
        let jumps = model.jumps.iter().flat_map(|jump| jump.set.iter().copied());
        let all = model.governed(mode).chain(jumps);
        for (_, rhs) in all.filter(|(state, _)| moved.contains(state)) {
            for param in params_of(graph, rhs) {
                let slope = graph.derivative(rhs, Var::Param(param));
                let value = Ranged::compile(graph, layout, slope);
                list.push(Slope { value, param });
            }
        }
        slopes.push(list);
    }
    slopes
}

/// Per mode, the summands with parameters of the velocities of the states in `moved`, in the order
/// of the equations.
pub(super) fn terms(
    model: &Model,
    layout: Layout,
    moved: &[usize],
    guards: &[ParameterGuard],
) -> Vec<Vec<Term>> {
    let graph = &model.graph;
    let is_guarded = |param: &usize| guards.iter().any(|guard| guard.params.contains(param));
    let term = |expr| {
        let mut params = params_of(graph, expr);
        if params.iter().any(|param| !is_guarded(param)) {
            params.retain(|param| !is_guarded(param));
        }
        (!params.is_empty()).then(|| Term {
            value: Ranged::compile(graph, layout, expr),
            params,
        })
    };
    (0..model.modes.len())
        .map(|mode| {
            let mut summands = Vec::new();
            for (_, rhs) in model
                .governed(mode)
                .filter(|(state, _)| moved.contains(state))
            {
                additive_terms(graph, rhs, &mut summands);
            }
            summands.into_iter().filter_map(term).collect()
        })
        .collect()
}

fn collect_atoms(guard: &Guard, atoms: &mut Vec<ExprId>) {
    match guard {
        Guard::Always => {}
        Guard::Atom { expr, .. } => atoms.push(*expr),
        Guard::All(parts) | Guard::Any(parts) => {
            for part in parts {
                collect_atoms(part, atoms);
            }
        }
    }
}

fn params_of(graph: &Graph, expr: ExprId) -> Vec<usize> {
    graph
        .variables(expr)
        .iter()
        .filter_map(|var| match var {
            Var::Param(param) => Some(*param),
            _ => None,
        })
        .collect()
}

fn additive_terms(graph: &Graph, e: ExprId, terms: &mut Vec<ExprId>) {
    match *graph.node(e) {
        Node::Binary(Binary::Add | Binary::Sub, a, b) => {
            additive_terms(graph, a, terms);
            additive_terms(graph, b, terms);
        }
        Node::Unary(Unary::Neg, a) => additive_terms(graph, a, terms),
        _ => terms.push(e),
    }
}
