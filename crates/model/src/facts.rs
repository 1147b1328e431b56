//! What is proved about the right-hand sides of a model: which structure an engine may rely on.

use crate::graph::{ExprId, Graph, Var};
use crate::model::Model;
use veribound_interval::Interval;

/// What is proved about a model for all states and inputs in their declared domains (everywhere, where
/// none is declared) and all parameters in their priors.
///
/// *Guarantee*: a property that is claimed holds; one that is not claimed may hold too. Derivatives are
/// the generalised ones at kinks.
///
/// ```
/// use veribound_model::{Facts, Model, ModeFacts};
///
/// let text = "format = 1\nstates = [\"x\"]\ninit.x = 1\nparams.k = [1, 2]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.1\"";
/// let facts: Facts = Model::from_text("m.toml", text)?.facts();
/// let only: &ModeFacts = &facts.modes[0];
/// assert!(only.affine_in_states && only.affine_in_params && only.is_cooperative());
/// assert!(only.jacobian[0][0].contains(-1.5) && facts.switching.is_empty());
/// # Ok::<(), veribound_model::Diagnostics>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// One for each mode.
    pub modes: Vec<ModeFacts>,
    /// The states whose derivative is not the same expression in all modes: where guards touch or
    /// overlap, its values there are the convex hull.
    pub switching: Vec<usize>,
}

/// What is proved about the right-hand side of one mode.
///
/// Example: [`Facts`].
#[derive(Debug, Clone, PartialEq)]
pub struct ModeFacts {
    /// Every derivative is an affine function of the states, for fixed parameters and inputs.
    pub affine_in_states: bool,
    /// Every derivative is an affine function of the parameters, for fixed states and inputs.
    pub affine_in_params: bool,
    /// The states the mode governs.
    pub states: Vec<usize>,
    /// `jacobian[i][j]` encloses the derivative of the right-hand side of state `states[i]` by state
    /// `j`.
    pub jacobian: Vec<Vec<Interval>>,
}

impl ModeFacts {
    /// Every derivative rises, or stays, with every *other* state (a cooperative or quasi-monotone
    /// system): then solutions that start in order stay in order.
    pub fn is_cooperative(&self) -> bool {
        let rises = |i: usize, row: &[Interval]| {
            let others = row.iter().enumerate().filter(|(j, _)| *j != i);
            others.into_iter().all(|(_, slope)| slope.lo() >= 0.0)
        };
        self.rows().all(|(i, row)| rises(i, row))
    }

    /// The governed states, each with its row of the Jacobian.
    pub fn rows(&self) -> impl Iterator<Item = (usize, &[Interval])> {
        let rows = self.jacobian.iter().map(Vec::as_slice);
        self.states.iter().copied().zip(rows)
    }

    /// A one-sided Lipschitz constant in the maximum norm, per second: two solutions in modes for
    /// which this is at most `constant`, in all groups, with equal parameters and inputs, part at most
    /// like `exp(constant * t)`. Infinite where none is proved. Source: the logarithmic norm, Dahlquist
    /// 1958.
    pub fn expansion(&self) -> f64 {
        let mut largest = f64::NEG_INFINITY;
        for (i, row) in self.rows() {
            let mut sum = Interval::ZERO;
            for (j, slope) in row.iter().enumerate() {
                let bound = if i == j { slope.hi() } else { slope.mag() };
                if !bound.is_finite() {
                    return f64::INFINITY;
                }
                sum += Interval::point(bound);
            }
            largest = largest.max(sum.hi());
        }
        largest
    }
}

impl Model {
    /// What is proved about the right-hand sides.
    ///
    /// Cost: two symbolic derivatives for every mode, state and quantity.
    pub fn facts(&self) -> Facts {
        let mut graph = self.graph.clone();
        let switching = (0..self.states.len()).filter(|state| {
            let mut all = self.governing(*state).map(|(_, rhs)| rhs);
            let first = all.next();
            all.any(|other| Some(other) != first)
        });
        let switching = switching.collect();
        let modes = 0..self.modes.len();
        Facts {
            modes: modes
                .map(|mode| self.mode_facts(&mut graph, mode))
                .collect(),
            switching,
        }
    }

    fn mode_facts(&self, graph: &mut Graph, mode: usize) -> ModeFacts {
        let (governed, der): (Vec<usize>, Vec<ExprId>) = self.governed(mode).unzip();
        let states: Vec<Var> = (0..self.states.len()).map(Var::State).collect();
        let params: Vec<Var> = (0..self.params.len()).map(Var::Param).collect();
        let mut affine_in = |list: &[Var]| {
            let affine = |e: &ExprId| is_affine(graph, *e, list);
            der.iter().all(affine)
        };
        let (affine_in_states, affine_in_params) = (affine_in(&states), affine_in(&params));
        let jacobian = der.iter().map(|e| {
            let slopes = states.iter().map(|state| {
                let slope = graph.derivative(*e, *state);
                let slope = graph.eval_interval(slope, &|var| self.everywhere(var));
                // Where a derivative exists nowhere, as that of a root at exactly zero, nothing is known.
                if slope.is_empty() {
                    Interval::ENTIRE
                } else {
                    slope
                }
            });
            slopes.collect()
        });
        ModeFacts {
            affine_in_states,
            affine_in_params,
            states: governed,
            jacobian: jacobian.collect(),
        }
    }

    /// All values of a quantity that the model's author thinks of.
    fn everywhere(&self, var: Var) -> Interval {
        let known = match var {
            Var::State(i) => self.states.get(i).and_then(|state| state.domain),
            Var::Input(i) => self.inputs.get(i).and_then(|input| input.domain),
            Var::Param(i) => self.params.get(i).map(|param| param.bounds),
        };
        known.unwrap_or(Interval::ENTIRE)
    }
}

/// Whether `e` is affine in all of `list` together.
fn is_affine(graph: &mut Graph, e: ExprId, list: &[Var]) -> bool {
    list.iter().all(|var| {
        let slope = graph.derivative(e, *var);
        let in_slope = graph.variables(slope);
        !in_slope.iter().any(|var| list.contains(var))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts(text: &str) -> Facts {
        let text = format!("format = 1\n{text}\noutputs.measured = \"x +- 1\"\n");
        let model = Model::from_text("model.toml", text);
        model
            .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
            .facts()
    }

    fn one(text: &str) -> ModeFacts {
        facts(text).modes.remove(0)
    }

    #[test]
    fn what_is_affine() {
        let frame = |velocity: &str| {
            let of = one(&format!(
                "states = [\"x\", \"v\"]\ninputs = [\"u\"]\ninit = {{ x = 0, v = 0 }}\n\
                 params = {{ a = [1, 2], b = [0, 1] }}\nder = {{ x = \"v\", v = \"{velocity}\" }}"
            ));
            (of.affine_in_states, of.affine_in_params)
        };
        for (velocity, states, params) in [
            ("a*x + b*v*u + u^2", true, true),
            ("a*b*x", true, false),
            ("x/a", true, false),
            ("a*x*v", false, true),
            ("abs(x)", false, true),
            ("abs(a)*abs(u)", true, false),
            ("max(x, v)", false, true),
            ("sin(x)*b", false, true),
            ("(x + a)*b - a*b", true, false),
            ("sign(u)*x", true, true),
            ("sign(a - 1.5)*x", true, false),
            ("sqrt(u)*a + 3", true, true),
            ("floor(x)", false, true),
            ("floor(u)*x + atan2(u, 1)*a", true, true),
        ] {
            assert_eq!(frame(velocity), (states, params), "{velocity}");
        }
    }

    #[test]
    fn slopes_are_enclosed_and_signs_seen() {
        let prey = one(
            "states.x = { init = 1, domain = [0, 10] }\nstates.y = { init = 1, domain = [0, 10] }\n\
             params.a = [1, 2]\nder = { x = \"x*(1 - a*y)\", y = \"y*(x - 1)\" }",
        );
        assert_eq!(prey.jacobian[0][1], Interval::new(-20.0, 0.0).unwrap());
        assert_eq!(prey.jacobian[1][0], Interval::new(0.0, 10.0).unwrap());
        assert!(!prey.is_cooperative());
        let tanks = one(
            "states.x = { init = 1, domain = [0, 2] }\nstates.z = { init = 1, domain = [0, 2] }\n\
             der = { x = \"-sqrt(x)\", z = \"sqrt(x) - sqrt(z)\" }",
        );
        assert!(tanks.is_cooperative());
        assert_eq!(tanks.expansion(), f64::INFINITY);
        let root = one("states.x = { init = 0, domain = [0, 0] }\nder.x = \"sqrt(x)\"");
        assert_eq!(root.jacobian[0][0], Interval::ENTIRE);
        let cart = one(
            "states = [\"x\", \"v\"]\ninit = { x = 0, v = 0 }\nparams.c = [2, 3]\n\
             der = { x = \"v\", v = \"-4*x - c*v\" }",
        );
        // Rows: 0 + 1, and -2 + 4.
        assert_eq!(cart.expansion(), 2.0);
    }

    #[test]
    fn what_switches() {
        let rig = facts(
            "states = [\"x\", \"v\"]\ninit = { x = 0, v = 0 }\n\
             der = { x = \"v\", v = \"1 - friction(v, 1, 0.5)\" }",
        );
        // In stick v is known to be zero, and so is x'.
        assert_eq!(rig.switching, [0, 1]);
        assert!(rig.modes.iter().all(|mode| mode.affine_in_states));
        assert_eq!(
            facts("states = [\"x\"]\ninit.x = 0\nder.x = \"-x\"").switching,
            []
        );
    }
}
