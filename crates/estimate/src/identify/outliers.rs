//! Samples of which some may be outliers: of any so many in a row at most `k` are off by more than the error bound.
//!
//! *Lemma.* Let `v_1 .. v_m` be samples in a row, no more than the declaration counts in, each of a quantity
//! `g_i·δ + r_i`. For any `g`, sample `i`, if it is no outlier, puts `g·δ` into `B_i = told_i - r_i - (g_i - g)·[δ]`. At most
//! `k` are none, so at least one of the `k + 1` samples with the largest lower ends of `B_i` is no outlier: `g·δ` is at or
//! above the least of these, that is the `(k+1)`-th largest of all. The same from above.
//!
//! A sample that no solution of the set can meet is an outlier; each that is known leaves one less to the others of
//! its window, and one more than allowed contradicts.
//!
//! For a point that is proved to agree the outliers may be chosen: it must meet all other samples.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: positions of entries of the same list"
)]

use super::rows::{Affine, Rows, shrunk};
use veribound_interval::Interval;
use veribound_model::Outliers;

/// So many times as many samples as may be outliers are taken together, where that many may be in a row.
const TOGETHER: usize = 8;

/// A sample that may be an outlier, as rows in the unknowns.
#[derive(Debug, Clone)]
struct Told {
    /// Its number among all samples that tell this output.
    number: usize,
    sample: usize,
    /// Quantities, and what they must be if it is none.
    rows: Vec<(Affine, Interval)>,
}

impl Told {
    /// How far from what was told the middle of the set is, as share of what was told.
    fn violation(&self) -> f64 {
        let of = |(affine, told): &(Affine, Interval)| {
            let inner = shrunk(*told, affine.rest);
            let size = if told.is_bounded() { told.width() } else { 1.0 };
            if inner.is_empty() {
                return affine.rest.width() / size.max(1e-300);
            }
            inner.lo().max(-inner.hi()) / size.max(1e-300)
        };
        self.rows.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Whether all unknowns meet it.
    fn is_met(&self) -> bool {
        self.rows
            .iter()
            .all(|(affine, told)| reach(&affine.slopes).is_subset_of(shrunk(*told, affine.rest)))
    }
}

fn reach(slopes: &[f64]) -> Interval {
    let sum: f64 = slopes.iter().map(|g| g.abs()).sum();
    Interval::symmetric(sum * (1.0 + 1e-12))
}

/// What the samples of an output on the way of a pass tell.
#[derive(Debug)]
pub(crate) struct Doubtful {
    allowed: Outliers,
    /// Those that are not yet taken together.
    open: Vec<Told>,
    /// Those that a point must meet, or that are outliers for it.
    all: Vec<Told>,
    /// Numbers of those that are outliers for the whole set, with their samples.
    known: Vec<(usize, usize)>,
}

impl Doubtful {
    pub(crate) fn new(allowed: Outliers) -> Doubtful {
        Doubtful {
            allowed,
            open: Vec::new(),
            all: Vec::new(),
            known: Vec::new(),
        }
    }

    /// A sample that no solution of the set meets: the samples that contradict, if they are too many.
    pub(crate) fn exclude(&mut self, number: usize, sample: usize) -> Option<Vec<usize>> {
        self.known.push((number, sample));
        let window = self.known.iter();
        let window = window.filter(|(own, _)| own + self.allowed.of > number);
        let samples: Vec<usize> = window.map(|(_, sample)| *sample).collect();
        (samples.len() > self.allowed.most).then_some(samples)
    }

    /// A sample that may be met; what it tells together with others goes to `rows` once they are enough.
    pub(crate) fn push(
        &mut self,
        (number, sample): (usize, usize),
        told: Vec<(Affine, Interval)>,
        rows: &mut Rows,
    ) {
        let together = TOGETHER * (self.allowed.most + 1);
        let first = self.open.first().map_or(number, |told| told.number);
        if self.open.len() >= together || number >= first + self.allowed.of {
            self.flush(rows);
        }
        let told = Told {
            number,
            sample,
            rows: told,
        };
        self.open.push(told.clone());
        self.all.push(told);
    }

    /// Takes together those that are open.
    pub(crate) fn flush(&mut self, rows: &mut Rows) {
        let open = std::mem::take(&mut self.open);
        let Some(last) = open.last().map(|told| told.number) else {
            return;
        };
        let known = self.known.iter();
        let known = known.filter(|(own, _)| *own <= last && own + self.allowed.of > last);
        let most = self.allowed.most.saturating_sub(known.count());
        if open.len() <= most {
            return;
        }
        let middle = &open[open.len() / 2];
        for (position, (affine, _)) in middle.rows.iter().enumerate() {
            let slopes = &affine.slopes;
            let bounds = open.iter().map(|told| {
                // A sample that has fewer rows than others, as exact ones have, tells nothing more.
                let Some((own, told)) = told.rows.get(position) else {
                    return Interval::ENTIRE;
                };
                let pairs = own.slopes.iter().zip(slopes);
                let unit = Interval::symmetric(1.0);
                let off = pairs.fold(Interval::ZERO, |sum, (a, b)| {
                    sum + (Interval::point(*a) - Interval::point(*b)) * unit
                });
                *told - own.rest - off
            });
            let (mut lows, mut highs): (Vec<f64>, Vec<f64>) =
                bounds.map(|bounds| (bounds.lo(), bounds.hi())).unzip();
            lows.sort_by(|a, b| b.total_cmp(a));
            highs.sort_by(f64::total_cmp);
            let above = Interval::new(lows[most], f64::INFINITY);
            let below = Interval::new(f64::NEG_INFINITY, highs[most]);
            let sides = [above, below].map(|side| side.unwrap_or(Interval::ENTIRE));
            let both = sides[0].intersect(sides[1]);
            if both.is_empty() {
                // Together they contradict.
                rows.push_outer(slopes, sides[0]);
                rows.push_outer(slopes, sides[1]);
            } else {
                rows.push_outer(slopes, both);
            }
        }
    }

    /// In other unknowns, as [`Rows::rescale`].
    pub(crate) fn rescale(&mut self, scales: &[(Interval, Interval)]) {
        self.all.retain(|told| !told.is_met());
        for told in self.open.iter_mut().chain(&mut self.all) {
            told.rows
                .iter_mut()
                .for_each(|(affine, _)| affine.rescale(&[], scales));
        }
    }

    /// What a point must meet: all samples but the outliers, which are those that the middle of the set is farthest
    /// from.
    pub(crate) fn finish(mut self, rows: &mut Rows) {
        self.flush(rows);
        let mut order: Vec<usize> = (0..self.all.len()).collect();
        let violations: Vec<f64> = self.all.iter().map(Told::violation).collect();
        order.sort_by(|a, b| violations[*b].total_cmp(&violations[*a]));
        let mut chosen: Vec<usize> = self.known.iter().map(|(number, _)| *number).collect();
        for position in order {
            let told = &self.all[position];
            if violations[position] > 0.0 && self.may_be(told.number, &chosen) {
                chosen.push(told.number);
                continue;
            }
            for (affine, what) in &told.rows {
                rows.push_inner(&affine.slopes, affine.rest, *what, told.sample);
            }
        }
    }

    /// Whether one more outlier is allowed beside others.
    fn may_be(&self, number: usize, others: &[usize]) -> bool {
        let Outliers { most, of } = self.allowed;
        let mut near: Vec<usize> = others
            .iter()
            .copied()
            .filter(|other| *other + of > number && *other < number + of)
            .chain([number])
            .collect();
        near.sort_unstable();
        // So many in a row and one more are in no window.
        near.windows(most + 1).all(|few| few[most] - few[0] >= of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn doubtful(most: usize, of: usize) -> Doubtful {
        Doubtful::new(Outliers { most, of })
    }

    fn told(at: f64) -> Vec<(Affine, Interval)> {
        let affine = Affine {
            slopes: vec![1.0],
            rest: Interval::ZERO,
        };
        vec![(affine, Interval::point(at).inflate(0.1))]
    }

    /// One of eight samples is far off: the others bound together what any of them but one says.
    #[test]
    fn the_second_best_bounds_hold() {
        let mut rows = Rows::new(1);
        let mut samples = doubtful(1, 100);
        for (number, at) in [0.01, 0.02, -0.03, 50.0, 0.0, 0.04, -0.01, 0.03]
            .iter()
            .enumerate()
        {
            samples.push((number, number), told(*at), &mut rows);
        }
        samples.flush(&mut rows);
        assert_eq!(rows.len(), 1);
        // The largest lower end belongs to the outlier, the second largest to 0.04; the least upper to -0.03.
        let bounds = rows.outer(0);
        assert!(
            bounds.contains(-0.06) && bounds.contains(0.09) && bounds.width() < 0.1501,
            "{bounds}"
        );
    }

    #[test]
    fn more_than_allowed_contradict() {
        let mut samples = doubtful(1, 10);
        assert_eq!(samples.exclude(3, 3), None);
        assert_eq!(samples.exclude(13, 13), None);
        assert_eq!(samples.exclude(22, 22), Some(vec![13, 22]));
    }

    #[test]
    fn known_outliers_leave_fewer_to_the_others() {
        let mut rows = Rows::new(1);
        let mut samples = doubtful(1, 10);
        assert_eq!(samples.exclude(0, 0), None);
        for number in 1..5 {
            samples.push((number, number), told(0.01 * number as f64), &mut rows);
        }
        samples.flush(&mut rows);
        // None of these may be an outlier: -0.06 to 0.11.
        assert!(rows.outer(0).width() < 0.1701, "{}", rows.outer(0));
    }

    /// A point may miss as many as are allowed, and no more.
    #[test]
    fn outliers_of_a_point_are_counted_in_every_window() {
        let samples = doubtful(2, 5);
        assert!(samples.may_be(3, &[0]) && samples.may_be(4, &[0, 5]));
        assert!(!samples.may_be(2, &[0, 4]) && !samples.may_be(4, &[0, 3]));
        assert!(!samples.may_be(7, &[4, 8, 12]) && samples.may_be(8, &[0, 4, 13]));
        assert!(!doubtful(0, 5).may_be(1, &[]));
    }
}
