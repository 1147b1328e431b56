//! Signs that a box leaves open, told by the form in it.
//!
//! On the box around a form, a pull and the friction that it has to overcome are any of their values; on the form both
//! are functions of the same unknowns. So what the box leaves open is asked for on the form, and where that
//! leaves it open, too, it is known how the answer depends on the unknowns: there a set may be divided
//! (`parting.rs`).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one sign per surface, surfaces by their positions in the list"
)]

use super::journey::Journey;
use super::regime::{Field, Regime};
use super::set::Form;
use super::surfaces::Signs;
use veribound_interval::Interval;
use veribound_model::ExprId;

/// The rate of change of a surface in one mode, of which not even the form tells the sign.
#[derive(Debug, Clone)]
pub(super) struct Open {
    pub(super) surface: usize,
    pub(super) mode: usize,
    pub(super) expr: ExprId,
    /// A polynomial in the unknowns, and how far the rate can be from it.
    pub(super) polynomial: Vec<f64>,
    pub(super) off: f64,
}

impl Journey<'_> {
    /// The regime where surfaces have `signs` on the box of `field`, with what `form`, which is in it, tells besides.
    ///
    /// Errors: the rates of change whose signs stay open, if no regime is certain.
    pub(super) fn resolve_on(
        &self,
        (field, signs): (&mut Field, &[Signs]),
        form: &dyn Fn() -> Form,
        inputs: &[Interval],
    ) -> Result<Regime, Vec<Open>> {
        let flow = self.flow;
        if let Some(regime) = flow.resolve(Some(field), signs) {
            return Ok(regime);
        }
        let switching = &flow.switching;
        let mut signs = signs.to_vec();
        let form = form();
        let value = |expr: ExprId| form.evaluate(&flow.quantity(expr), inputs).ok();
        let mut progress = false;
        for (surface, known) in switching.surfaces.list.iter().enumerate() {
            let is_open =
                ![Signs::NEGATIVE, Signs::ZERO, Signs::POSITIVE].contains(&signs[surface]);
            if is_open
                && known.level.is_none()
                && let Some((polynomial, off)) = value(known.expr)
                && let Some(sign) = form.sign(&polynomial, off)
            {
                signs[surface] = signs[surface].and(sign);
                progress = true;
            }
        }
        let mut open = Vec::new();
        for (surface, mode) in switching.open_drifts(field, &signs) {
            let Some(expr) = flow.drift_in(surface, mode) else {
                continue;
            };
            let Some((polynomial, off)) = value(expr) else {
                continue;
            };
            match form.sign(&polynomial, off) {
                Some(sign) => {
                    field.drifts.push((surface, mode, sign));
                    progress = true;
                }
                // A mode that acts on the surface alone does not leave it.
                None if off == 0.0 && polynomial.iter().all(|x| *x == 0.0) => {}
                None => open.push(Open {
                    surface,
                    mode,
                    expr,
                    polynomial,
                    off,
                }),
            }
        }
        let regime = progress.then(|| flow.resolve(Some(field), &signs));
        regime.flatten().ok_or(open)
    }
}
