//! Functions of time that refute values of parameters: hints in plain floating point, of which nothing is believed.
//!
//! At known parameters, `x' = w`, `w' = a w + r` with `r` between two numbers on every stretch takes a convex polygon of `(x, w)` to another
//! one, of which samples cut off what is not in their boxes. Where nothing is left, no course of `r` agrees with the record. The reason is
//! found backwards: the direction that parts what was reached from what is known at that sample, moved by the adjoint equation, and
//! at every sample parted into what the box of that sample holds, and what goes on to the stretch before. The second entry of this
//! direction is a function `ψ` whose balance these parameters do not meet.
#![allow(
    clippy::indexing_slicing,
    reason = "PROOF: polygons of so many corners, nodes at both ends of every stretch"
)]

/// A polygon of more corners loses every other one that is no sample's.
const CORNERS: usize = 64;

/// Corners are the same where they differ by less than this share of the polygon, or of what floats tell apart.
const SAME: f64 = 1e-7;
const ROUNDED: f64 = 1e-13;

/// A direction of which a share below this is left came to its end.
const GONE: f64 = 1e-9;

/// What is known of the state and its rate at a sample: the least and the largest of each.
pub(super) type Known = [[f64; 2]; 2];

/// A stretch of this length, with `r` between two numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push {
    pub(super) dt: f64,
    pub(super) least: f64,
    pub(super) most: f64,
}

/// A function that is zero outside of some stretches, by its values at the begin and at the end of each.
#[derive(Debug, Clone)]
pub(super) struct Function {
    pub(super) from: usize,
    pub(super) values: Vec<[f64; 2]>,
}

impl Function {
    /// The same for every stretch, where its own are groups of these in a row, each with the first of its positions.
    pub(super) fn apart(&self, a: f64, groups: &[(usize, Vec<Push>)]) -> Function {
        let groups = &groups[self.from..][..self.values.len()];
        let mut values = Vec::new();
        for ((_, group), [begin, end]) in groups.iter().zip(&self.values) {
            let whole: f64 = group.iter().map(|push| push.dt).sum();
            // `ψ' + a ψ` is constant.
            let value = |time: f64| {
                let z = -a * whole;
                let share = if z.abs() < 1e-9 {
                    time / whole
                } else {
                    (-a * time).exp_m1() / z.exp_m1()
                };
                begin + (end - begin) * share
            };
            let mut time = 0.0;
            let mut before = *begin;
            for (position, push) in group.iter().enumerate() {
                time += push.dt;
                let is_last = position + 1 == group.len();
                let after = if is_last { *end } else { value(time) };
                values.push([before, after]);
                before = after;
            }
        }
        Function {
            from: groups.first().map_or(0, |group| group.0),
            values,
        }
    }
}

/// A corner of a polygon, and where the edge to the next one is the side of a sample's box, what is normal to that.
#[derive(Debug, Clone, Copy)]
struct Corner {
    at: [f64; 2],
    cut: Option<[f64; 2]>,
}

/// Polygons, one after the other, each with corners against the clock.
#[derive(Default)]
struct History {
    corners: Vec<Corner>,
    begins: Vec<usize>,
}

impl History {
    fn push(&mut self, polygon: &[Corner]) {
        self.begins.push(self.corners.len());
        self.corners.extend_from_slice(polygon);
    }

    fn polygon(&self, k: usize) -> &[Corner] {
        let end = self.begins.get(k + 1);
        &self.corners[self.begins[k]..end.map_or(self.corners.len(), |end| *end)]
    }
}

/// What a stretch does without a push, and with one.
#[derive(Clone, Copy)]
struct Flow {
    dt: f64,
    grow: f64,
    carry: f64,
    push: [f64; 2],
}

impl Flow {
    fn of(a: f64, dt: f64) -> Flow {
        let z = a * dt;
        // (e^z - 1)/z and (e^z - 1 - z)/z².
        let (first, second) = if z.abs() < 1e-3 {
            (1.0 + z / 2.0 + z * z / 6.0, 0.5 + z / 6.0 + z * z / 24.0)
        } else {
            let first = z.exp_m1() / z;
            (first, (first - 1.0) / z)
        };
        Flow {
            dt,
            grow: z.exp(),
            carry: dt * first,
            push: [dt * dt * second, dt * first],
        }
    }
}

/// Functions that refute the parameters which `a` and the pushes are of, each at the first sample at which nothing is left; then
/// it begins anew with what is known there.
pub(super) fn refuting(a: f64, known: &[Known], pushes: &[Push]) -> Vec<Function> {
    let mut functions = Vec::new();
    let Some(first) = known.first() else {
        return functions;
    };
    let mut begin = 0;
    let mut history = History::default();
    history.push(&rectangle(first));
    let mut flow = Flow::of(a, pushes.first().map_or(1.0, |push| push.dt));
    let (mut polygon, mut spare) = (Vec::new(), Vec::new());
    for (k, (push, next)) in pushes.iter().zip(&known[1..]).enumerate() {
        if flow.dt != push.dt {
            flow = Flow::of(a, push.dt);
        }
        push.moved(history.polygon(k), &flow, &mut polygon);
        match cut(&mut polygon, next, &mut spare) {
            None => {
                tidy(&mut polygon, &mut spare);
                history.push(&polygon);
            }
            Some(direction) => {
                let found = back(
                    a,
                    (&history, &polygon),
                    (begin, &pushes[begin..=k]),
                    direction,
                );
                functions.extend(found);
                begin = k + 1;
                history.push(&rectangle(next));
            }
        }
    }
    functions
}

/// All that is known, of which neither side is quite without length.
fn rectangle(known: &Known) -> [Corner; 4] {
    let [[left, right], [low, high]] = widened(known);
    let corner = |x, w, normal| Corner {
        at: [x, w],
        cut: Some(normal),
    };
    [
        corner(left, low, [0.0, -1.0]),
        corner(right, low, [1.0, 0.0]),
        corner(right, high, [0.0, 1.0]),
        corner(left, high, [-1.0, 0.0]),
    ]
}

fn widened(known: &Known) -> Known {
    known.map(|[lo, hi]| {
        let by = (SAME - (hi - lo)).max(0.0) / 2.0;
        [lo - by, hi + by]
    })
}

impl Push {
    /// Some in a row as one; nothing where there are none.
    pub(super) fn together(pushes: &[Push]) -> Option<Push> {
        let (first, more) = pushes.split_first()?;
        Some(more.iter().fold(*first, |all, push| {
            let dt = all.dt + push.dt;
            let mean = |own: f64, other: f64| (all.dt * own + push.dt * other) / dt;
            Push {
                dt,
                least: mean(all.least, push.least),
                most: mean(all.most, push.most),
            }
        }))
    }

    /// Moves a polygon along a stretch: by the flow, and by all pushes.
    fn moved(&self, polygon: &[Corner], flow: &Flow, moved: &mut Vec<Corner>) {
        let n = polygon.len();
        let point = |k: usize| {
            let [x, w] = polygon[k % n].at;
            [x + flow.carry * w, flow.grow * w]
        };
        // An edge that looks in the direction of the push is moved by the most of it, another one by the least.
        let looks = |p: [f64; 2], q: [f64; 2]| {
            (q[1] - p[1]) * flow.push[0] - (q[0] - p[0]) * flow.push[1] > 0.0
        };
        let pushed = |[x, w]: [f64; 2], looks: bool| {
            let by = if looks { self.most } else { self.least };
            Corner {
                at: [x + by * flow.push[0], w + by * flow.push[1]],
                cut: None,
            }
        };
        moved.clear();
        let mut here = point(0);
        let mut before = looks(point(n - 1), here);
        for k in 0..n {
            let next = point(k + 1);
            let after = looks(here, next);
            moved.push(pushed(here, before));
            if before != after {
                moved.push(pushed(here, after));
            }
            (here, before) = (next, after);
        }
    }
}

/// Leaves of a polygon what is in a box; or what was left before one side of it took all, and then tells the direction to that side.
fn cut(polygon: &mut Vec<Corner>, known: &Known, left: &mut Vec<Corner>) -> Option<[f64; 2]> {
    let [[least, most], [low, high]] = widened(known);
    let sides = [
        ([1.0, 0.0], most),
        ([-1.0, 0.0], -least),
        ([0.0, 1.0], high),
        ([0.0, -1.0], -low),
    ];
    for (normal, end) in sides {
        let over = |corner: &Corner| normal[0] * corner.at[0] + normal[1] * corner.at[1] - end;
        if polygon.iter().all(|corner| over(corner) <= 0.0) {
            continue;
        }
        left.clear();
        let n = polygon.len();
        for (k, p) in polygon.iter().enumerate() {
            let q = &polygon[(k + 1) % n];
            let (here, there) = (over(p), over(q));
            let between = |cut| {
                let share = here / (here - there);
                let along = |axis: usize| p.at[axis] + share * (q.at[axis] - p.at[axis]);
                Corner {
                    at: [along(0), along(1)],
                    cut,
                }
            };
            if here <= 0.0 {
                left.push(*p);
                if there > 0.0 {
                    left.push(between(Some(normal)));
                }
            } else if there <= 0.0 {
                left.push(between(p.cut));
            }
        }
        if left.is_empty() {
            return Some([-normal[0], -normal[1]]);
        }
        std::mem::swap(polygon, left);
    }
    None
}

/// Leaves out corners that are as good as others, and some where there are many.
fn tidy(polygon: &mut Vec<Corner>, left: &mut Vec<Corner>) {
    let reach = |axis: usize| {
        let values = polygon.iter().map(|corner| corner.at[axis]);
        let (lo, hi) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| {
            (lo.min(x), hi.max(x))
        });
        SAME * (hi - lo) + ROUNDED * lo.abs().max(hi.abs())
    };
    let near = [reach(0), reach(1)];
    let are_same =
        |p: &Corner, q: &Corner| (0..2).all(|axis| (p.at[axis] - q.at[axis]).abs() <= near[axis]);
    left.clear();
    for corner in polygon.iter() {
        match left.last_mut() {
            // The edge between the two is gone.
            Some(last) if are_same(last, corner) => last.cut = corner.cut,
            _ => left.push(*corner),
        }
    }
    while left.len() > 1 && are_same(&left[0], &left[left.len() - 1]) {
        left.pop();
    }
    if left.len() > CORNERS {
        let mut position = 0;
        left.retain(|corner| {
            position += 1;
            corner.cut.is_some() || position % 2 == 0
        });
    }
    std::mem::swap(polygon, left);
}

/// The function to a direction in which the last polygon does not reach as far as what is known at the end of the last stretch.
fn back(
    a: f64,
    (history, last): (&History, &[Corner]),
    (begin, pushes): (usize, &[Push]),
    direction: [f64; 2],
) -> Option<Function> {
    let mut values = Vec::new();
    let mut costate = held(last, direction);
    for (k, push) in pushes.iter().enumerate().rev() {
        let size = costate[0].abs() + costate[1].abs();
        if size < GONE {
            break;
        }
        let flow = Flow::of(a, push.dt);
        let end = costate[1];
        let at_begin = [costate[0], flow.carry * costate[0] + flow.grow * costate[1]];
        values.push([at_begin[1], end]);
        costate = held(history.polygon(begin + k), at_begin);
    }
    values.reverse();
    let is_finite = values.iter().flatten().all(|value| value.is_finite());
    (is_finite && !values.is_empty()).then(|| Function {
        from: begin + pushes.len() - values.len(),
        values,
    })
}

/// Which part of a direction is held by what was reached, where a polygon is farthest in it; the rest is held by what is known.
fn held(polygon: &[Corner], direction: [f64; 2]) -> [f64; 2] {
    let n = polygon.len();
    if n < 3 {
        return [0.0, 0.0];
    }
    let height = |k: &usize| {
        let [x, w] = polygon[*k].at;
        direction[0] * x + direction[1] * w
    };
    let Some(top) = (0..n).max_by(|p, q| height(p).total_cmp(&height(q))) else {
        return [0.0, 0.0];
    };
    let edge = |from: usize| {
        let (p, q) = (polygon[from].at, polygon[(from + 1) % n].at);
        let cut = polygon[from].cut;
        (cut.unwrap_or([q[1] - p[1], p[0] - q[0]]), cut.is_some())
    };
    let ((left, left_is_cut), (right, right_is_cut)) = (edge((top + n - 1) % n), edge(top));
    if !left_is_cut && !right_is_cut {
        return direction;
    }
    let det = left[0] * right[1] - left[1] * right[0];
    if left_is_cut && right_is_cut || det <= 0.0 {
        return [0.0, 0.0];
    }
    let on_left = (direction[0] * right[1] - direction[1] * right[0]) / det;
    let on_right = (left[0] * direction[1] - left[1] * direction[0]) / det;
    // The side of a box is as long as is needed; what is not along it is left.
    let (share, normal) = if left_is_cut {
        (on_left, left)
    } else {
        (on_right, right)
    };
    [0, 1].map(|axis| direction[axis] - share.max(0.0) * normal[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On all stretches that were taken together `ψ' + a ψ` is the same number, and ends are what they were.
    #[test]
    fn functions_of_groups_are_functions_of_stretches() {
        let push = |dt: f64, least: f64, most: f64| Push { dt, least, most };
        let groups = [
            (3, vec![push(0.1, 0.0, 1.0)]),
            (
                4,
                vec![
                    push(0.1, 0.0, 1.0),
                    push(0.3, -4.0, 5.0),
                    push(0.2, 1.0, 1.0),
                ],
            ),
            (7, vec![push(0.25, 0.0, 0.0), push(0.05, 2.0, 2.0)]),
        ];
        let whole = Push::together(&groups[1].1).unwrap_or(groups[0].1[0]);
        let told = [whole.dt, whole.least, whole.most];
        let wanted = [0.6, -1.0 / 0.6, 1.8 / 0.6];
        assert!(
            told.iter().zip(wanted).all(|(x, y)| (x - y).abs() < 1e-12),
            "{told:?}"
        );
        let own = Function {
            from: 1,
            values: vec![[0.5, -2.0], [3.0, 1.0]],
        };
        for a in [-2.5, 0.0, 4.0] {
            let apart = own.apart(a, &groups);
            assert_eq!((apart.from, apart.values.len()), (4, 5));
            let mut stretches = apart.values.iter();
            for ((_, group), [begin, end]) in groups[1..].iter().zip(&own.values) {
                let mut before = *begin;
                let mut constants = Vec::new();
                for (push, [from, to]) in group.iter().zip(&mut stretches) {
                    assert_eq!(*from, before);
                    before = *to;
                    let weight = if a == 0.0 {
                        push.dt
                    } else {
                        -(-a * push.dt).exp_m1() / a
                    };
                    constants.push((to - from * (-a * push.dt).exp()) / weight);
                }
                assert_eq!(before, *end);
                assert!(
                    constants.iter().all(|c| (c - constants[0]).abs() < 1e-9),
                    "{a}: {constants:?}"
                );
            }
        }
    }
}
