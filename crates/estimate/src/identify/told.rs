//! What is told of sets: quantities of a region, and the user's parameters where those of the region are other ones.
//!
//! Regions are of the parameters in which a model bends least ([`veribound_model::Model::with_ratios`]). A parameter that
//! is a quotient `a / b` of these, with `b > 0`, is bounded by linear programs all the same: for any number `c`, `a - c b >=
//! m` gives `a / b >= c + m / b`; with `c` the quotient at the vertex of the last program, `m` is soon zero (Dinkelbach,
//! 1967).
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one row of axes per quantity, one entry per axis; one interval for all that is told, one parameter of the user per ratio"
)]

use super::cell::{BELIEVED, Cell};
use super::problem::Problem;
use super::region::Region;
use super::rows::Rows;
use super::simplex::{Program, Side, minimum};
use veribound_interval::Interval;
use veribound_model::Ratio;

/// Programs for one end of a quotient, at most,
const PROGRAMS: usize = 5;

/// fewer where the last one brought no more than this share.
const ARRIVED: f64 = 1e-7;

/// A quantity that bounds are told of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Told {
    /// A quantity of regions.
    Plain(usize),
    /// One divided by another, or the inverse of one; what is below is positive.
    Quotient { over: Option<usize>, under: usize },
}

impl Told {
    /// Encloses the quantity for unknowns in `part`.
    pub(crate) fn range(self, region: &Region, part: &[Interval]) -> Interval {
        match self {
            Told::Plain(quantity) => region.range(quantity, part),
            Told::Quotient { over, under } => {
                let over = over.map_or(Interval::ONE, |over| region.range(over, part));
                over / region.range(under, part)
            }
        }
    }

    /// About its value, less what is the same for all unknowns of the region if it is affine in them.
    pub(crate) fn height(self, region: &Region, at: &[f64]) -> f64 {
        let affine = |quantity: usize| -> f64 {
            let row = region.axes[quantity].iter();
            row.zip(at).map(|(slope, x)| slope * x).sum()
        };
        let value = |quantity: usize| region.centre[quantity] + affine(quantity);
        match self {
            Told::Plain(quantity) => affine(quantity),
            Told::Quotient { over, under } => over.map_or(1.0, value) / value(under),
        }
    }

    /// The direction of the unknowns in which it grows at some of them.
    pub(crate) fn direction(self, region: &Region, at: &[f64]) -> Vec<f64> {
        match self {
            Told::Plain(quantity) => region.axes[quantity].clone(),
            Told::Quotient { over, under } => {
                let value = self.height(region, at);
                (0..region.axes())
                    .map(|axis| {
                        let over = over.map_or(0.0, |over| region.axes[over][axis]);
                        over - value * region.axes[under][axis]
                    })
                    .collect()
            }
        }
    }
}

impl Told {
    /// So many linear programs in a row, each in the direction at the last vertex, find about where it is least.
    pub(crate) fn programs(self) -> usize {
        match self {
            Told::Plain(_) => 1,
            Told::Quotient { .. } => 2,
        }
    }
}

impl Problem {
    /// Everything that bounds are told of: the quantities of regions, then the parameters that are quotients.
    pub(crate) fn told_quantities(&self) -> Vec<Told> {
        let first = self.first_param();
        let plain = (0..self.params().end).map(Told::Plain);
        let quotients = self.ratios.iter().flatten();
        let quotients = quotients.map(|Ratio { over, under }| Told::Quotient {
            over: over.map(|over| first + over),
            under: first + under,
        });
        plain.chain(quotients).collect()
    }

    /// Whether parameters are the user's.
    pub(crate) fn is_upright(&self) -> bool {
        self.ratios.iter().all(Option::is_none)
    }

    /// The positions in [`Problem::told_quantities`] of the user's parameters.
    pub(crate) fn told_params(&self) -> Vec<usize> {
        let mut next = self.params().end;
        let positions = self.params().zip(&self.ratios);
        let positions = positions.map(|(quantity, ratio)| match ratio {
            Some(_) => {
                next += 1;
                next - 1
            }
            None => quantity,
        });
        positions.collect()
    }

    /// What is believed before any sample of everything that is told.
    pub(crate) fn told_before(&self) -> Vec<Interval> {
        let mut all = self.believed();
        let ratios = self.ratios.iter().zip(&self.user);
        all.extend(ratios.filter_map(|(ratio, bounds)| ratio.is_some().then_some(*bounds)));
        all
    }

    /// The quantities of a region around all that have these bounds of what is told.
    pub(crate) fn around(&self, told: &[Interval]) -> Vec<Interval> {
        let user: Vec<Interval> = self.told_params().iter().map(|at| told[*at]).collect();
        let mut box_ = told[..self.params().end].to_vec();
        for (param, ratio) in self.ratios.iter().enumerate() {
            if let Some(Ratio { over, under }) = ratio {
                let above = over.map_or(Interval::ONE, |over| user[over]);
                let own = &mut box_[self.first_param() + param];
                *own = own.intersect(above / user[*under]);
            }
        }
        box_
    }

    /// Adds what is believed of quantities before any sample; of those for which nothing depends on the unknowns, if
    /// `with_fixed`.
    ///
    /// `a / b` in `[l, h]` with `0 < b <= t` means that `a - l b` is in `[0, (h - l) t]`, and `a - h b` in `[(l - h) t, 0]`.
    pub(crate) fn believe(&self, region: &Region, with_fixed: bool, rows: &mut Rows) {
        for (i, believed) in self.believed().iter().enumerate() {
            // What does not depend on the unknowns may be any of its values, of which one that is believed is enough.
            let is_fixed = region.axes[i].iter().all(|x| *x == 0.0);
            if !with_fixed && is_fixed && region.offset(i).intersects(*believed) {
                continue;
            }
            rows.push(&region.axes[i], region.offset(i), *believed, BELIEVED, 0);
        }
        let first = self.first_param();
        for (ratio, believed) in self.ratios.iter().zip(&self.user) {
            let Some(Ratio {
                over: Some(over),
                under,
            }) = ratio
            else {
                continue;
            };
            let most = Interval::point(self.prior[*under].hi());
            let reach = (Interval::point(believed.hi()) - Interval::point(believed.lo())) * most;
            let sides = [
                (believed.lo(), Interval::new(0.0, reach.hi())),
                (believed.hi(), Interval::new(-reach.hi(), 0.0)),
            ];
            for (end, side) in sides {
                let Some(side) = side else { continue };
                let (slopes, rest) = difference(region, (first + over, first + under), end);
                rows.push(&slopes, rest, side, BELIEVED, 0);
            }
        }
    }
}

/// `z_a - c z_b` of a region as slopes, and what is added to them.
fn difference(region: &Region, (over, under): (usize, usize), value: f64) -> (Vec<f64>, Interval) {
    let value = Interval::point(value);
    let unit = Interval::symmetric(1.0);
    let mut rest = region.offset(over) - value * region.offset(under);
    let pairs = region.axes[over].iter().zip(&region.axes[under]);
    let slopes = pairs.map(|(over, under)| {
        let exact = Interval::point(*over) - value * Interval::point(*under);
        let rounded = exact.mid();
        rest += (exact - Interval::point(rounded)) * unit;
        rounded
    });
    let slopes = slopes.collect();
    (slopes, rest)
}

impl Cell {
    /// Proved bounds of what is told: those of the solutions that agree with all records.
    pub(crate) fn bounds(&self, told: Told) -> Interval {
        let around = told.range(&self.region, &self.part);
        match told {
            Told::Plain(quantity) => self.outer(quantity),
            Told::Quotient { over: None, under } => {
                (Interval::ONE / self.outer(under)).intersect(around)
            }
            Told::Quotient {
                over: Some(over),
                under,
            } => {
                let below = self.outer(under);
                if below.is_empty() || below.lo() <= 0.0 {
                    return around;
                }
                let lo = self.end_of_quotient((over, under), below, 1.0);
                let hi = -self.end_of_quotient((over, under), below, -1.0);
                let bounds = Interval::new(lo, hi).unwrap_or(Interval::EMPTY);
                bounds.intersect(around)
            }
        }
    }

    /// A proved lower bound of a quotient, or with the sign `-1` of its negative.
    fn end_of_quotient(&self, (over, under): (usize, usize), below: Interval, sign: f64) -> f64 {
        let mut program = Program::new(&self.rows, &self.part, Side::Outer);
        let told = Told::Quotient {
            over: Some(over),
            under,
        };
        let middle: Vec<f64> = self.part.iter().map(|x| x.mid()).collect();
        let mut value = told.height(&self.region, &middle);
        let mut best = f64::NEG_INFINITY;
        for _ in 0..PROGRAMS {
            let (slopes, rest) = difference(&self.region, (over, under), value);
            let direction: Vec<f64> = slopes.iter().map(|slope| sign * slope).collect();
            let vertex = program.minimize(&direction);
            let multipliers = if vertex.is_impossible {
                &[][..]
            } else {
                &vertex.multipliers
            };
            let least = minimum(&self.rows, &self.part, &direction, multipliers);
            if !least.is_finite() {
                return best;
            }
            let sign = Interval::point(sign);
            let least = Interval::point(least) + sign * rest;
            let end = sign * Interval::point(value) + Interval::point(least.lo()) / below;
            if !end.is_empty() && end.lo() <= best + ARRIVED * best.abs() {
                return best.max(end.lo());
            }
            best = best.max(end.lo());
            value = told.height(&self.region, &vertex.point);
        }
        best
    }
}
