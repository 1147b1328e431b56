//! The order: which quantities grow together.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: one entry per quantity, states first"
)]

use super::rates::Influences;
use veribound_interval::Interval;

/// What is known of slopes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Slopes {
    /// `of[state][quantity]` is the hull of those met, empty where there is none.
    pub(super) of: Vec<Vec<Interval>>,
    /// Time at which they were first known to have no sign.
    pub(super) since: Vec<Vec<f64>>,
}

impl Slopes {
    pub(super) fn new(states: usize, quantities: usize) -> Slopes {
        Slopes {
            of: vec![vec![Interval::EMPTY; quantities]; states],
            since: vec![vec![f64::INFINITY; quantities]; states],
        }
    }

    pub(super) fn add(&mut self, (state, quantity): (usize, usize), slope: Interval, time: f64) {
        let known = &mut self.of[state][quantity];
        *known = known.hull(slope);
        if direction(*known).is_err() {
            let since = &mut self.since[state][quantity];
            *since = since.min(time);
        }
    }

    /// Adds a slope unless there were no sign any more.
    pub(super) fn add_if_signed(&mut self, (state, quantity): (usize, usize), slope: Interval) {
        let known = &mut self.of[state][quantity];
        if direction(known.hull(slope)).is_ok() {
            *known = known.hull(slope);
        }
    }

    /// All that were met.
    pub(super) fn iter(&self) -> impl Iterator<Item = ((usize, usize), Interval)> {
        let rows = self.of.iter().enumerate();
        rows.flat_map(|(i, row)| row.iter().enumerate().map(move |(q, x)| ((i, q), *x)))
            .filter(|(_, slope)| !slope.is_empty())
    }
}

/// For every quantity 1 where it grows along the order, -1 where it falls, 0 where it is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Order {
    pub(super) sign: Vec<i8>,
}

/// States that cannot be ordered: the first depends on the second without a sign that fits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Conflict {
    pub(super) of: usize,
    pub(super) by: usize,
}

/// Quantities in classes whose members grow together or against one another.
struct Classes {
    /// Parent, and whether it grows against it.
    parent: Vec<(usize, bool)>,
}

impl Classes {
    fn root(&self, mut q: usize) -> (usize, bool) {
        let mut against = false;
        while self.parent[q].0 != q {
            against ^= self.parent[q].1;
            q = self.parent[q].0;
        }
        (q, against)
    }

    /// Puts two together; false where they are already, otherwise.
    fn join(&mut self, a: usize, b: usize, against: bool) -> bool {
        let ((a, a_against), (b, b_against)) = (self.root(a), self.root(b));
        let against = against ^ a_against ^ b_against;
        if a == b {
            return !against;
        }
        // States stay roots, so that a quantity that is tried and not taken can be put back.
        let (child, root) = if a < b { (b, a) } else { (a, b) };
        self.parent[child] = (root, against);
        true
    }
}

/// Whether a quantity grows against a state whose rate has this slope: nothing to say where it is zero,
/// and no answer where it has both signs.
pub(super) fn direction(slope: Interval) -> Result<Option<bool>, ()> {
    match slope {
        slope if slope.is_empty() || slope == Interval::ZERO => Ok(None),
        slope if slope.lo() >= 0.0 => Ok(Some(false)),
        slope if slope.hi() <= 0.0 => Ok(Some(true)),
        _ => Err(()),
    }
}

impl Order {
    /// An order that all slopes fit to, with as few quantities kept as is found: the states of `kept`, what
    /// they depend on, and parameters and inputs whose slopes contradict each other.
    ///
    /// Errors: two states whose slopes do.
    pub(super) fn choose(
        slopes: &Slopes,
        kept: &[bool],
        wide: &[bool],
        influences: &Influences,
    ) -> Result<Order, Conflict> {
        let (states, quantities) = (kept.len(), wide.len());
        let mut classes = Classes {
            parent: (0..quantities).map(|q| (q, false)).collect(),
        };
        let ordered = || (0..states).filter(|state| !kept[*state]);
        for i in ordered() {
            for j in ordered().filter(|j| *j != i) {
                let conflict = Conflict { of: i, by: j };
                if let Some(against) = direction(slopes.of[i][j]).map_err(|()| conflict)?
                    && !classes.join(i, j, against)
                {
                    return Err(conflict);
                }
            }
        }
        let mut sign = vec![0; quantities];
        for q in (states..quantities).filter(|q| wide[*q]) {
            let moves_kept = (0..states).any(|i| kept[i] && influences.on[i].contains(&q));
            let before = classes.parent.clone();
            let fits = !moves_kept
                && ordered().all(|i| match direction(slopes.of[i][q]) {
                    Ok(None) => true,
                    Ok(Some(against)) => classes.join(i, q, against),
                    Err(()) => false,
                });
            if fits {
                sign[q] = 1;
            } else {
                classes.parent = before;
            }
        }
        for state in ordered() {
            sign[state] = 1;
        }
        for (q, sign) in sign.iter_mut().enumerate() {
            if *sign != 0 && classes.root(q).1 {
                *sign = -1;
            }
        }
        Ok(Order { sign })
    }

    /// Whether a slope fits.
    pub(super) fn fits(&self, (state, quantity): (usize, usize), slope: Interval) -> bool {
        match self.sign[state] * self.sign[quantity] {
            0 => true,
            1 => slope.lo() >= 0.0,
            _ => slope.hi() <= 0.0,
        }
    }

    /// The upper (`1`) or lower (`-1`) corner of a box of all quantities, or of those from `first` on.
    pub(super) fn corner(&self, first: usize, bounds: &[Interval], which: i8) -> Vec<Interval> {
        let corner = |(x, sign): (&Interval, &i8)| match sign * which {
            0 => *x,
            1 => Interval::point(x.hi()),
            _ => Interval::point(x.lo()),
        };
        bounds.iter().zip(&self.sign[first..]).map(corner).collect()
    }
}
