//! Conditions under construction.

use super::symbol::Symbol;
use super::tree::Tree;
use crate::syntax::ast::{Function, Kind};
use std::fmt;
use std::ops::Not;

/// A condition: a comparison of [`Symbol`]s, or a combination of such.
///
/// ```
/// use veribound_model::build::ModelBuilder;
///
/// let mut model = ModelBuilder::new("rig");
/// let omega = model.state("omega").init(0, 0).symbol();
/// let (u, level) = (model.input("u").symbol(), model.param("T", 0, "0.3").symbol());
/// let breaks_away = omega.equals(0).and(u.above(&level));
/// let forward = omega.above(0).or(&breaks_away);
/// assert_eq!(forward.to_string(), "omega > 0 or omega == 0 and u > T");
/// assert_eq!((!forward).to_string(), "not (omega > 0 or omega == 0 and u > T)");
/// ```
#[derive(Debug, Clone)]
pub struct Condition(pub(super) Tree);

impl Condition {
    /// The condition that always holds.
    pub fn always() -> Condition {
        Condition(Tree::leaf(Kind::Always))
    }

    /// Both hold.
    pub fn and(&self, other: impl Into<Condition>) -> Condition {
        Condition(Tree::join([&self.0, &other.into().0], |[a, b]| {
            Kind::And(a, b)
        }))
    }

    /// At least one holds.
    pub fn or(&self, other: impl Into<Condition>) -> Condition {
        Condition(Tree::join([&self.0, &other.into().0], |[a, b]| {
            Kind::Or(a, b)
        }))
    }
}

impl From<&Condition> for Condition {
    fn from(condition: &Condition) -> Condition {
        condition.clone()
    }
}

impl Not for Condition {
    type Output = Condition;

    fn not(self) -> Condition {
        Condition(Tree::join([&self.0], |[a]| Kind::Not(a)))
    }
}

impl Not for &Condition {
    type Output = Condition;

    fn not(self) -> Condition {
        !self.clone()
    }
}

impl fmt::Display for Condition {
    /// The text of the condition.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Symbol(self.0.clone()).fmt(f)
    }
}

/// `if condition then yes else no`: two modes; on the border of the condition both are possible.
///
/// ```
/// # use veribound_model::build::{ModelBuilder, if_else};
/// # let mut model = ModelBuilder::new("tank");
/// # let h = model.state("h").init(1, 1).symbol();
/// let overflow = if_else(h.above(2), 3 * (&h - 2), 0);
/// assert_eq!(overflow.to_string(), "if h > 2 then 3*(h - 2) else 0");
/// ```
pub fn if_else(
    condition: impl Into<Condition>,
    yes: impl Into<Symbol>,
    no: impl Into<Symbol>,
) -> Symbol {
    let parts = [&condition.into().0, &yes.into().0, &no.into().0];
    Symbol(Tree::join(parts, |[condition, yes, no]| {
        Kind::If(condition, yes, no)
    }))
}

/// Dry friction of level `level` at `velocity` under the drive `drive`: a force to subtract from the
/// drive. Three modes.
///
/// ```
/// # use veribound_model::build::{ModelBuilder, friction};
/// # let mut model = ModelBuilder::new("sled");
/// # let v = model.state("v").init(0, 0).symbol();
/// # let (force, level) = (model.input("F").symbol(), model.param("T", 0, 3).symbol());
/// let drive = &force - 2 * &v;
/// model.der(&v, &drive - friction(&v, &drive, &level));
/// ```
pub fn friction(
    velocity: impl Into<Symbol>,
    drive: impl Into<Symbol>,
    level: impl Into<Symbol>,
) -> Symbol {
    let arguments = [&velocity.into(), &drive.into(), &level.into()];
    Symbol::call(Function::Friction, &arguments)
}

/// Dry friction that sticks up to `holding`, at or above the `sliding` level.
///
/// ```
/// # use veribound_model::build::{ModelBuilder, sticking_friction};
/// # let mut model = ModelBuilder::new("sled");
/// # let v = model.state("v").init(0, 0).symbol();
/// # let force = model.input("F").symbol();
/// let sliding = 1 + (-v.abs()).exp();
/// model.der(&v, &force - sticking_friction(&v, &force, sliding, 2));
/// ```
pub fn sticking_friction(
    velocity: impl Into<Symbol>,
    drive: impl Into<Symbol>,
    sliding: impl Into<Symbol>,
    holding: impl Into<Symbol>,
) -> Symbol {
    let arguments = [
        &velocity.into(),
        &drive.into(),
        &sliding.into(),
        &holding.into(),
    ];
    Symbol::call(Function::Friction, &arguments)
}

/// The circle constant.
///
/// ```
/// # let mut model = veribound_model::build::ModelBuilder::new("pendulum");
/// let angle = model.state("angle").init(-veribound_model::build::pi() / 2, 0).symbol();
/// assert!(model.to_toml().contains(r#"angle = { init = ["-pi/2", 0] }"#));
/// ```
pub fn pi() -> Symbol {
    Symbol::name("pi")
}
