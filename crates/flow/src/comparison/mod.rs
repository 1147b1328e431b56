//! Comparison bounds: where the right-hand side is monotone, two corners bound all solutions.
//!
//! States, parameters and inputs are put in an order `σ`, growing (`+1`) or falling (`-1`), or they are
//! *kept*: those have no place in it. `a ⪯ b` means `σ_q a_q <= σ_q b_q` for every quantity `q` in the order.
//! The *upper corner* has the largest start value, parameter and input of every quantity in the order, and the
//! whole interval of every one that is kept; the lower corner the smallest. Kept states depend on nothing in the order
//! (`Influences`), so they go through the same motion in the solution and in both corners; for what follows take
//! `σ = +1` for all, and one motion of what is kept as given. `f_i` is the rate of state `i`.
//!
//! # Theorem
//!
//! Let `lo` and `up` be solutions from the corners up to time `t`, and `T` a box that contains the box
//! between `lo` and `up` at all these times. Let `T'` contain `T` in its inside. Let every state `i` in the order be of
//! one of two kinds:
//!
//! - *plain*: on `T'` one rate acts, `f_i`, defined, continuous and with finite slopes in the states in the order
//!   (in its own only: with a finite upper bound);
//! - *switching*: on `T'` the modes give different rates, but one, `a`, wherever `x_i > c`, and one, `b`, wherever `x_i < c`,
//!   both as regular as that; where `x_i = c`, `a <= b`, and every rate that a mode possible there gives lies between them.
//!
//! And let the slopes of each of these rates in all other quantities in the order not be negative on `T`, enlarged to `T'`
//! in the switching states. Then every solution `x` that starts between the corners, with parameters and inputs
//! between theirs, exists up to time `t` and satisfies `lo ⪯ x ⪯ up`.
//!
//! *Proof.* (1) *Slope.* Let `x` and `z` lie in `T'` and be solutions at some time, with `x_i > z_i`, where `z` has the larger
//! parameters and inputs, `i` is switching and the slopes have their signs between them. Then `x_i' - z_i' <= L Σ_j (x_j - z_j)^+` for
//! almost every such time. Let `m_j = max(x_j, z_j)` for `j != i`, `m_i = x_i`, with the parameters and inputs of `z`. If both are above
//! `c`, or both below, the rate is the same expression `g`, `g(x) <= g(m)` by the signs of its slopes, and
//! `g(m) - g(z) <= L Σ_j (m_j - z_j)`, where `m - z = (x - z)^+`. If `z_i < c < x_i`, go from `x` to `m`, down to `x_i = c` along `a`, from `a` to
//! `b >= a`, and down to `z` along `b`. Almost everywhere on the times at which `x_i = c` it is `x_i' = 0`; so `0` is in the hull of
//! the rates possible there, hence `a(x) <= 0 <= b(x)`, and with `z_i < c` it is `x_i' - z_i' <= b(x) - b(z)`, which goes as before; likewise
//! `z_i = c`. For a plain state the same holds with one `g`.
//!
//! (2) *One solution.* With the same parameters and inputs, and without asking for signs, `|x_i - z_i|' <= L Σ_j |x_j - z_j|` in the same
//! way. So on `T'` there is but one solution for each start, parameter and input.
//!
//! (3) *Truncation.* Let `y` solve the equation in which `f` is taken not at `y` but at the nearest point `ŷ` of the box between
//! `lo` and `up`, enlarged by some `ε` in the switching states, so that it lies in `T` as enlarged. The right-hand side is bounded and upper
//! semicontinuous with convex values, so there is such a `y` for the whole time. Let `e_i = (y_i - up_i)^+`. For a plain state
//! with `y_i > up_i` it is `ŷ_i = up_i` and `ŷ_j <= up_j` for all plain `j`, so by the signs
//! `y_i' = f_i(ŷ) <= f_i(up) + L Σ_S e_j`, where `S` are the switching states. For those (1) applies while `e_i < ε`, with `ŷ` for
//! `x`. So `Σ e_i` starts at zero and grows at most as fast as a multiple of itself: it is zero, `e_i` never reaches `ε`, and
//! `y ⪯ up`. Likewise `lo ⪯ y`. Hence `ŷ = y`, and `y` is a solution of the equation itself. By (2) `x` is `y` for as long as it is in
//! `T'`, which it cannot leave since `y` stays in `T`. ∎
//!
//! Nothing was asked outside of `T`: a slope that is `-x_j` has its sign where `x_j` starts at zero and grows. A kink is
//! no obstacle, since slopes are the generalised ones, with which the mean value theorem holds. A `sign` that a friction
//! switches by its own velocity is a jump downwards in its own state. Where a rate jumps with another state, solutions need not be
//! unique, and nothing is claimed.
//!
//! The corners are enclosed by forms, with unknowns for what is kept, as all quantities are whose slopes have no sign or
//! contradict one another; so bounds are exact hulls, up to these. `T` is the hull of what the corners pass
//! through during a short time. Kept switching is allowed by a level of a kept state that moves through it with a speed
//! of one sign, such as a time: almost always one side of it is certain, the same one for all solutions compared.
//!
//! Source: Kamke 1932, Müller 1927; monotone systems, Smith 1995. Truncation instead of a perturbed right-hand side, so that signs
//! are needed between the corners only, and the switching states are own.

mod implied;
mod levels;
mod order;
mod rates;
mod run;
mod walk;

pub use run::{Cause, Compared, Disorder, Outlook};

use crate::form::surfaces::Surfaces;
use rates::{Group, Influences, Rates};
use std::sync::Mutex;
use veribound_interval::Interval;
use veribound_model::{Coverage, Graph, Guard, Layout, Model, Tape};

/// A model compiled for comparison bounds.
///
/// ```
/// use veribound_flow::comparison::{Cause, Comparison, Compared, Disorder, Outlook};
/// use veribound_flow::form::{Effort, Flow, FormOptions, Stretch};
/// use veribound_interval::Interval;
/// use veribound_model::Var;
///
/// # let text = "format = 1\nstates = [\"x\"]\ninit.x = [0.9, 1.1]\nparams.k = [0.5, 1]\nder.x = \"-k*x\"\noutputs.y = \"x +- 0.01\"";
/// # let model = veribound_model::Model::from_text("decay.toml", text)?;
/// let (start, params) = ([model.states[0].init], [model.params[0].bounds]);
/// let second = [Stretch { inputs: vec![], dt: Interval::ONE }];
/// let comparison = Comparison::new(&model);
/// // x grows with its start and falls with k: two corners enclose all.
/// let outlook: Outlook = comparison.outlook(&start, &params, &second);
/// assert_eq!(outlook.corners, [Var::State(0), Var::Param(0)]);
/// let all = (FormOptions::default(), Effort::default(), f64::INFINITY);
/// let flow = Flow::new(&model);
/// let found = comparison.enclose(&flow, (&start, &params), &second, all, &|_| true);
/// let compared: Compared = found.map_err(|in_the_way| format!("{in_the_way:?}"))?;
/// assert!(compared.enclosure.ends[0][0].width() < 0.35);
/// let disorders: &[Disorder] = &compared.disorders;
/// assert!(!disorders.iter().any(|disorder| matches!(disorder.cause, Cause::Jump)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Comparison {
    layout: Layout,
    rates: Rates,
    influences: Influences,
    surfaces: Surfaces,
    /// The value of every surface.
    tape: Vec<Tape>,
    guards: Vec<Guard>,
    groups: Vec<Group>,
    /// Of states and inputs, where the guards are proved to leave no gap.
    domain: Option<(Vec<Interval>, Vec<Interval>)>,
    graph: Mutex<Graph>,
}

impl Comparison {
    /// Compiles `model`.
    ///
    /// Cost: one symbolic derivative per right-hand side and quantity it depends on.
    pub fn new(model: &Model) -> Comparison {
        let layout = model.layout();
        let mut graph = model.graph.clone();
        let rates = Rates::compile(&mut graph, model);
        let surfaces = Surfaces::of(&mut graph, model);
        let tape = surfaces
            .list
            .iter()
            .map(|surface| Tape::compile(&graph, layout, &[surface.expr]))
            .collect();
        let groups = Group::all(model, &surfaces);
        let influences = Influences::of(&graph, layout, &rates, &surfaces, &groups);
        let domain = match &model.coverage {
            Coverage::InDomain { states, inputs } => Some((states.clone(), inputs.clone())),
            _ => None,
        };
        Comparison {
            layout,
            rates,
            influences,
            tape,
            guards: model.modes.iter().map(|mode| mode.guard.clone()).collect(),
            groups,
            surfaces,
            domain,
            graph: Mutex::new(graph),
        }
    }
}
