//! Two parameters of a paving: which of their values are inside, outside, undecided.

use super::pair::{self, HEIGHT};
use super::{Figure, titled};
use crate::axis::{Axis, Room};
use crate::identification::{Identification, ProvedParameter, TileStatus};
use crate::legend::Entry;
use crate::panel::Panel;
use crate::svg::Canvas;
use crate::theme;

/// So many parameters are shown in pairs; fifteen figures.
const MOST: usize = 6;

/// Up to so many tiles are shown with their edges.
const EDGED: usize = 4000;

/// A rectangle of two parameters: lo and hi of each.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Flat {
    x: (f64, f64),
    y: (f64, f64),
}

/// The styles of the three kinds: colours that colour-blind people tell apart, and hatches that stay apart in
/// grey print.
struct Styles {
    inside: [String; 2],
    outside: [String; 2],
    undecided: [String; 2],
}

impl Identification {
    /// One figure for every two parameters that the paving divides.
    pub(crate) fn draw_pavings(&self) -> Vec<Figure> {
        let mut figures: Vec<Figure> = Vec::new();
        if self.tiles.is_empty() {
            return figures;
        }
        let is_open = |param: &(usize, &ProvedParameter)| param.1.prior.0 < param.1.prior.1;
        let params: Vec<_> = { self.params.iter().enumerate() }.filter(is_open).collect();
        for (k, (i, x)) in params.iter().enumerate().take(MOST) {
            for (j, y) in params.iter().take(MOST).skip(k + 1) {
                let mut name = format!("paving_{}_{}", x.quantity.name, y.quantity.name);
                // `a` with `b_c` and `a_b` with `c`.
                while figures.iter().any(|figure| figure.name == name) {
                    name.push('_');
                }
                let svg = self.draw_pair(&name, (*i, *j), params.len() == 2);
                figures.push(Figure { name, svg });
            }
        }
        figures
    }

    fn draw_pair(&self, name: &str, (i, j): (usize, usize), whole: bool) -> String {
        let mut canvas = Canvas::new(name, theme::WIDTH);
        let [Some(first), Some(second)] = [i, j].map(|at| self.params.get(at)) else {
            return canvas.finish(0.0, "");
        };
        let shadows = |status: TileStatus| -> Vec<Flat> {
            let tiles = self.tiles.iter().filter(|tile| tile.status == status);
            let flat = tiles.filter_map(|tile| {
                let (x, y) = (*tile.params.get(i)?, *tile.params.get(j)?);
                Some(Flat { x, y })
            });
            flat.collect()
        };
        let [inside, undecided] = [TileStatus::Inside, TileStatus::Undecided].map(shadows);

        let styles = Styles {
            inside: theme::inside(&mut canvas),
            outside: theme::outside(&mut canvas),
            undecided: theme::undecided(&mut canvas),
        };
        let prior = Flat {
            x: first.prior,
            y: second.prior,
        };
        let left_over = || inside.iter().chain(&undecided);
        let shown = Flat {
            x: view(left_over().map(|flat| flat.x), prior.x),
            y: view(left_over().map(|flat| flat.y), prior.y),
        };
        let mut entries = styles.entries(whole);
        if prior.has_edge_in(shown) {
            entries.push(Entry::line(theme::prior(), "prior"));
        }
        let size = theme::SMALL.size;
        let value = Room {
            length: HEIGHT,
            spacing: 2.5 * size,
            font: 0.0,
        };
        let value = Axis::linear(shown.y.0, shown.y.1, value);
        let panel = pair::panel(&mut canvas, &entries, value, |width| {
            let room = Room {
                length: width,
                spacing: 5.0 * size,
                font: size,
            };
            Axis::linear(shown.x.0, shown.x.1, room)
        });
        panel.grid(&mut canvas);
        canvas.open_clip(panel.area);
        canvas.layers(&rectangles(&panel, [prior]), &styles.outside);
        canvas.layers(&rectangles(&panel, inside.iter().copied()), &styles.inside);
        let open = without(&undecided, &inside);
        canvas.layers(&rectangles(&panel, open), &styles.undecided);
        if whole && self.tiles.len() <= EDGED {
            let all = [inside, undecided, shadows(TileStatus::Outside)].concat();
            canvas.path(&rectangles(&panel, all), &theme::edges());
        }
        canvas.close();
        dotted(&mut canvas, &panel, prior);
        let what = format!("{} and {}", first.quantity.name, second.quantity.name);
        let what = titled(&self.title, &format!("what the record leaves of {what}"));
        let labels = (&*first.quantity.label(), &*second.quantity.label());
        pair::finish(canvas, &panel, labels, &what)
    }
}

impl Styles {
    fn entries(&self, whole: bool) -> Vec<Entry> {
        let inside = if whole {
            "inside: all agree with the record"
        } else {
            "inside: agree, with some values of the others"
        };
        vec![
            Entry::layers(&self.inside, inside),
            Entry::layers(&self.undecided, "undecided"),
            Entry::layers(&self.outside, "outside: none agrees"),
        ]
    }
}

impl Flat {
    /// Whether an end of one of the ranges lies in that of the other rectangle.
    fn has_edge_in(self, shown: Flat) -> bool {
        let seen = |of: (f64, f64), (lo, hi): (f64, f64)| {
            [of.0, of.1].iter().any(|end| (lo..=hi).contains(end))
        };
        seen(self.x, shown.x) || seen(self.y, shown.y)
    }
}

/// The range of an axis: what is left with some room around it, or the prior where that is not much more.
fn view(left: impl Iterator<Item = (f64, f64)>, prior: (f64, f64)) -> (f64, f64) {
    let finite = |x: f64, other: f64| if x.is_finite() { x } else { other };
    let hull = left.fold((f64::INFINITY, f64::NEG_INFINITY), |hull, x| {
        (hull.0.min(x.0), hull.1.max(x.1))
    });
    let prior = (finite(prior.0, hull.0), finite(prior.1, hull.1));
    let shown = if hull.1 - hull.0 >= 0.3 * (prior.1 - prior.0) || hull.0 > hull.1 {
        prior
    } else {
        hull
    };
    let lo = finite(shown.0, -1.0);
    let hi = finite(shown.1, 1.0).max(lo);
    let margin = 0.06 * (hi - lo);
    (lo - margin, hi + margin)
}

/// The edge of the prior where it is in view.
fn dotted(canvas: &mut Canvas, panel: &Panel, prior: Flat) {
    let area = panel.area;
    let (x, y) = (panel.time.range(), panel.value.range());
    let seen = |value: &f64, (lo, hi): (f64, f64)| (lo..=hi).contains(value);
    let ends = |(from, to): (f64, f64), (lo, hi): (f64, f64)| (from.max(lo), to.min(hi));
    let (from, to) = ends(prior.x, x);
    for value in [prior.y.0, prior.y.1].iter().filter(|v| seen(v, y)) {
        let at = panel.py(*value);
        let (from, to) = (panel.px(from).max(area.x), panel.px(to).min(area.right()));
        canvas.line((from, at), (to, at), &theme::prior());
    }
    let (from, to) = ends(prior.y, y);
    for value in [prior.x.0, prior.x.1].iter().filter(|v| seen(v, x)) {
        let at = panel.px(*value);
        let (from, to) = (panel.py(from).min(area.bottom()), panel.py(to).max(area.y));
        canvas.line((at, from), (at, to), &theme::prior());
    }
}

/// The rectangles as path data, rounded outward.
fn rectangles(panel: &Panel, list: impl IntoIterator<Item = Flat>) -> String {
    let mut data = String::new();
    for Flat { x, y } in list {
        pair::rectangle(&mut data, panel, x, y);
    }
    data
}

/// Rectangles that cover what the first cover and the others do not, and nothing that both cover but edges.
///
/// The plane is cut into strips at every end of a rectangle, so that a strip lies in a rectangle or beside it;
/// in a strip the covered stretches are intervals. All comparisons are of the given floats: no edge moves.
fn without(first: &[Flat], others: &[Flat]) -> Vec<Flat> {
    let all = first.iter().chain(others);
    let mut cuts: Vec<f64> = all.flat_map(|flat| [flat.y.0, flat.y.1]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let by_begin = |list: &[Flat]| {
        let mut list = list.to_vec();
        list.sort_by(|a, b| a.y.0.total_cmp(&b.y.0));
        list.into_iter().peekable()
    };
    let mut waiting = [by_begin(first), by_begin(others)];
    let mut active: [Vec<Flat>; 2] = [Vec::new(), Vec::new()];
    // Of the strip before, to be continued where the next one has the same stretch.
    let (mut done, mut last): (Vec<Flat>, Vec<Flat>) = (Vec::new(), Vec::new());
    for strip in cuts.windows(2) {
        let [from, to] = strip else { continue };
        for (active, waiting) in active.iter_mut().zip(&mut waiting) {
            active.retain(|flat| flat.y.1 >= *to);
            active.extend(std::iter::from_fn(|| {
                waiting.next_if(|flat| flat.y.0 <= *from)
            }));
        }
        let [stretches, covered] = active.each_ref().map(|list| union(list));
        let mut next = Vec::new();
        for x in difference(&stretches, &covered) {
            let same = last.iter().position(|flat: &Flat| flat.x == x);
            let begin = same.map_or(*from, |at| last.swap_remove(at).y.0);
            next.push(Flat { x, y: (begin, *to) });
        }
        done.append(&mut last);
        last = next;
    }
    done.append(&mut last);
    done
}

/// The stretches that the rectangles cover, apart and in order.
fn union(list: &[Flat]) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = list.iter().map(|flat| flat.x).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut apart: Vec<(f64, f64)> = Vec::new();
    for (lo, hi) in all {
        match apart.last_mut() {
            Some(last) if lo <= last.1 => last.1 = last.1.max(hi),
            _ => apart.push((lo, hi)),
        }
    }
    apart
}

/// What of the first stretches the others leave; both are apart and in order.
fn difference(first: &[(f64, f64)], others: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut left = Vec::new();
    for (lo, hi) in first {
        let mut from = *lo;
        for (begin, end) in others.iter().filter(|(b, e)| e > lo && b < hi) {
            if *begin > from {
                left.push((from, *begin));
            }
            from = from.max(*end);
        }
        if from < *hi {
            left.push((from, *hi));
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::svg::Rect;

    fn stream(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    fn holds(list: &[Flat], x: f64, y: f64) -> bool {
        let within = |(lo, hi): (f64, f64), v: f64| lo <= v && v <= hi;
        list.iter()
            .any(|flat| within(flat.x, x) && within(flat.y, y))
    }

    /// At random points, what is left is what the first cover and the others do not.
    #[test]
    fn what_is_undecided_is_all_that_is_not_proved_inside() {
        for seed in 1..60 {
            let mut next = stream(seed);
            // Ends on a coarse grid, so that many are shared.
            let mut range = || {
                let (a, b) = ((next() * 12.0).floor(), 1.0 + (next() * 4.0).floor());
                (a / 7.0, (a + b) / 7.0)
            };
            let mut list = |count: usize| -> Vec<Flat> {
                { 0..count }
                    .map(|_| Flat {
                        x: range(),
                        y: range(),
                    })
                    .collect()
            };
            let (first, others) = (list(14), list(seed as usize % 14));
            let left = without(&first, &others);
            for _ in 0..500 {
                let (x, y) = (next() * 2.3, next() * 2.3);
                let wanted = holds(&first, x, y) && !holds(&others, x, y);
                assert_eq!(holds(&left, x, y), wanted, "seed {seed}: {x} {y}");
            }
        }
    }

    #[test]
    fn neighbours_are_drawn_as_one() {
        let tile = |x: f64, y: f64| Flat {
            x: (x, x + 1.0),
            y: (y, y + 1.0),
        };
        let four = [
            tile(0.0, 0.0),
            tile(1.0, 0.0),
            tile(0.0, 1.0),
            tile(1.0, 1.0),
        ];
        let whole = Flat {
            x: (0.0, 2.0),
            y: (0.0, 2.0),
        };
        assert_eq!(without(&four, &[]), [whole]);
        assert_eq!(without(&four, &[whole]), []);
    }

    /// A sliver of a tile between two that are inside stays, and is drawn outward.
    #[test]
    fn nothing_undecided_is_too_thin_to_be_drawn() {
        let edge = 1.0 + 1e-9;
        let flat = |x: (f64, f64)| Flat { x, y: (0.0, 2.0) };
        let inside = [flat((0.0, 1.0)), flat((edge, 2.0))];
        let left = without(&[flat((1.0, edge))], &inside);
        assert_eq!(left, [flat((1.0, edge))]);
        let room = Room {
            length: 500.0,
            spacing: 50.0,
            font: 0.0,
        };
        let panel = Panel {
            area: Rect {
                x: 33.3,
                y: 11.1,
                w: 555.5,
                h: 222.2,
            },
            time: Axis::linear(0.0, 2.0, room),
            value: Axis::linear(0.0, 2.0, room),
            bucket: 20,
        };
        let data = rectangles(&panel, left);
        let numbers: Vec<f64> = data
            .split(|c: char| !c.is_ascii_digit() && c != '.')
            .filter_map(|text| text.parse().ok())
            .collect();
        let [left, top, right, bottom, ..] = numbers[..] else {
            panic!("{data}")
        };
        assert!(left <= panel.px(1.0) && panel.px(edge) <= right && left < right);
        assert!(top <= panel.py(2.0) && panel.py(0.0) <= bottom);
    }

    #[test]
    fn the_view_is_of_what_is_left() {
        assert_eq!(view([(2.0, 3.0)].into_iter(), (0.0, 100.0)), (1.94, 3.06));
        assert_eq!(view([(2.0, 3.0)].into_iter(), (0.0, 2.5)), (-0.15, 2.65));
        assert_eq!(view([].into_iter(), (0.0, 100.0)), (-6.0, 106.0));
        let all = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(view([all].into_iter(), all), (-1.12, 1.12));
    }
}
