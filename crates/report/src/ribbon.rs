//! The outline of a band: cells of time and value, rounded outward to the picture's grid.
//!
//! The time axis of the picture is cut into buckets a fraction of a unit wide, and every cell is
//! drawn over whole buckets: first and last bucket hold its first and last moment. Heights are
//! rounded away from the band. At each moment of a cell the outline so encloses the cell's bounds:
//!
//! - A bucket that two cells share is drawn with the hull of both.
//! - Between separate cells the outline is straight, as between two measured points.

use crate::panel::Panel;
use crate::svg::{Px, push};
use crate::track::{Band, Cell};

/// How a series goes on between two samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Between {
    /// It moves from one to the next: outputs and states.
    Moves,
    /// It moves, and where neighbours are missing, a sample is a bar wide enough to be seen.
    Rare,
    /// It holds until the next sample: parameters, counts.
    Holds,
}

/// Least width of a lone bar, in hundredths of a unit.
const BAR: i64 = 260;

/// A part of the band over whole buckets: y downwards, so `top < bottom`.
/// Neighbours in a run do not overlap.
#[derive(Clone, Copy, Debug)]
struct Slab {
    left: i64,
    right: i64,
    top: Px,
    bottom: Px,
}

/// SVG path data of the outline of one series in a panel, one closed loop for each stretch without
/// a gap.
pub(crate) fn outline(
    panel: &Panel,
    cells: &[Cell],
    series: impl Fn(&Cell) -> Option<Band>,
    between: Between,
) -> String {
    let mut data = String::new();
    let mut run: Vec<Slab> = Vec::new();
    let finish = |data: &mut String, run: &mut Vec<Slab>| {
        if let (Between::Rare, [lone]) = (between, run.as_mut_slice()) {
            let missing = (BAR / panel.bucket - (lone.right - lone.left)).max(0);
            lone.left -= missing / 2;
            lone.right += missing / 2;
        }
        close(data, run, panel.bucket);
    };
    for (k, cell) in cells.iter().enumerate() {
        let Some(band) = series(cell) else {
            finish(&mut data, &mut run);
            continue;
        };
        let end = match (between, cells.get(k + 1)) {
            (Between::Holds, Some(next)) => next.t0,
            _ => cell.t1,
        };
        let slab = Slab {
            left: bucket(panel, cell.t0),
            right: bucket(panel, end) + 1,
            top: Px::below(panel.py(band.hi)),
            bottom: Px::above(panel.py(band.lo)),
        };
        append(&mut run, slab);
    }
    finish(&mut data, &mut run);
    data
}

fn bucket(panel: &Panel, t: f64) -> i64 {
    (panel.px(t) * 100.0 / panel.bucket as f64).floor() as i64
}

/// Adds a slab to the run. The bucket it may share with the slab before becomes one of its own.
fn append(run: &mut Vec<Slab>, mut slab: Slab) {
    if let Some(last) = run.last_mut()
        && slab.left < last.right
    {
        let shared = Slab {
            left: slab.left,
            right: last.right,
            top: last.top.min(slab.top),
            bottom: last.bottom.max(slab.bottom),
        };
        if last.left < shared.left {
            last.right = shared.left;
            run.push(shared);
        } else {
            *last = shared;
        }
        slab.left = shared.right;
    }
    if slab.left < slab.right {
        run.push(slab);
    }
}

/// Writes the loop around the slabs, and empties the run.
fn close(data: &mut String, run: &mut Vec<Slab>, grid: i64) {
    let upper = run.iter().flat_map(|s| [(s.left, s.top), (s.right, s.top)]);
    let lower = run
        .iter()
        .rev()
        .flat_map(|s| [(s.right, s.bottom), (s.left, s.bottom)]);
    let mut corners: Vec<(i64, Px)> = Vec::with_capacity(4 * run.len());
    for corner in upper.chain(lower) {
        if let [.., before, last] = corners.as_slice()
            && is_on_the_way(*before, *last, corner)
        {
            corners.pop();
        }
        corners.push(corner);
    }
    let mut pen: Option<(i64, Px)> = None;
    for (x, y) in corners {
        let at = Px(x * grid);
        match pen {
            None => push(data, format_args!("M{at} {y}")),
            Some((px, py)) if px == x && py == y => {}
            Some((px, _)) if px == x => push(data, format_args!("V{y}")),
            Some((_, py)) if py == y => push(data, format_args!("H{at}")),
            Some(_) => push(data, format_args!("L{at} {y}")),
        }
        pen = Some((x, y));
    }
    if pen.is_some() {
        data.push('Z');
    }
    run.clear();
}

/// Whether a corner lies between two others on a horizontal or vertical line, and so draws nothing.
fn is_on_the_way(from: (i64, Px), via: (i64, Px), to: (i64, Px)) -> bool {
    let between = |a: i64, b: i64, c: i64| (a <= b && b <= c) || (a >= b && b >= c);
    (from.1 == via.1 && via.1 == to.1 && between(from.0, via.0, to.0))
        || (from.0 == via.0 && via.0 == to.0 && between(from.1.0, via.1.0, to.1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::axis::{Axis, Room};
    use crate::svg::Rect;
    use crate::track::Track;

    const ROOM: Room = Room {
        length: 500.0,
        spacing: 60.0,
        font: 11.0,
    };

    fn panel(t: (f64, f64), v: (f64, f64)) -> Panel {
        Panel {
            area: Rect {
                x: 41.3,
                y: 17.7,
                w: 571.9,
                h: 133.1,
            },
            time: Axis::linear(t.0, t.1, ROOM),
            value: Axis::linear(v.0, v.1, ROOM),
            bucket: 20,
        }
    }

    /// The loops of path data, as lists of corners.
    fn loops(data: &str) -> Vec<Vec<(f64, f64)>> {
        data.split_terminator('Z')
            .map(|text| {
                let mut corners: Vec<(f64, f64)> = Vec::new();
                let starts: Vec<usize> = text
                    .char_indices()
                    .filter(|(_, c)| c.is_alphabetic())
                    .map(|(i, _)| i)
                    .collect();
                for (k, start) in starts.iter().enumerate() {
                    let end = starts.get(k + 1).copied().unwrap_or(text.len());
                    let (command, numbers) = text[*start..end].split_at(1);
                    let numbers: Vec<f64> = numbers
                        .split(' ')
                        .map(|n| n.parse().expect("a number"))
                        .collect();
                    corners.push(match command {
                        "H" => (numbers[0], corners[corners.len() - 1].1),
                        "V" => (corners[corners.len() - 1].0, numbers[0]),
                        _ => (numbers[0], numbers[1]),
                    });
                }
                corners
            })
            .collect()
    }

    /// The extent of a loop at a place, edges included.
    fn extent(corners: &[(f64, f64)], x: f64) -> Option<(f64, f64)> {
        let mut extent: Option<(f64, f64)> = None;
        for (k, a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            let (left, right) = if a.0 <= b.0 { (*a, b) } else { (b, *a) };
            if left.0 <= x && x <= right.0 {
                let part = if right.0 > left.0 {
                    (x - left.0) / (right.0 - left.0)
                } else {
                    0.0
                };
                let ys = [
                    left.1 + part * (right.1 - left.1),
                    if left.0 == right.0 {
                        right.1
                    } else {
                        left.1 + part * (right.1 - left.1)
                    },
                ];
                for y in ys {
                    let (top, bottom) = extent.unwrap_or((y, y));
                    extent = Some((top.min(y), bottom.max(y)));
                }
            }
        }
        extent
    }

    fn stream(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64
        }
    }

    #[test]
    fn no_sample_sticks_out_of_the_drawn_band() {
        for seed in 1..60 {
            let mut next = stream(seed);
            let mut samples = Vec::new();
            let mut track = Track::new(if seed % 2 == 0 { 64 } else { 4000 });
            let (mut t, mut mid) = (0.0, 0.0);
            let crowding = [1e-4, 1e-2, 1.0][seed as usize % 3];
            for _ in 0..600 {
                t += crowding * (0.01 + next()) + if next() < 0.01 { 3.0 } else { 0.0 };
                mid += next() - 0.5;
                let bounds = match (next() * 20.0) as u32 {
                    0 => (f64::NEG_INFINITY, mid),
                    1 => (1.0, -1.0),
                    2 => (mid, mid),
                    _ => (mid - next(), mid + next()),
                };
                let bands = vec![Band::of(bounds)].into();
                let cell = Cell {
                    t0: t,
                    t1: t,
                    bands,
                    marks: Box::default(),
                };
                samples.push(cell.clone());
                track.push(cell);
            }
            let panel = panel((samples[0].t0, t), (-12.0, 12.0));
            for between in [Between::Moves, Between::Holds, Between::Rare] {
                let data = outline(&panel, track.cells(), |cell| cell.band(0), between);
                let drawn = loops(&data);
                for (k, cell) in samples.iter().enumerate() {
                    let Some(band) = cell.band(0) else { continue };
                    let (top, bottom) = (panel.py(band.hi), panel.py(band.lo));
                    // Parameters hold until just before the next sample: look there, too.
                    let held = samples
                        .get(k + 1)
                        .map_or(cell.t1, |n| cell.t1 + 0.999 * (n.t0 - cell.t1));
                    let times = if between == Between::Holds {
                        vec![cell.t0, held]
                    } else {
                        vec![cell.t0]
                    };
                    for x in times.into_iter().map(|t| panel.px(t)) {
                        let covers = |corners: &Vec<(f64, f64)>| {
                            extent(corners, x).is_some_and(|(a, b)| a <= top && bottom <= b)
                        };
                        assert!(
                            drawn.iter().any(covers),
                            "seed {seed}, {between:?}, sample {k}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_band_is_not_drawn_much_wider_either() {
        let cell = |t: f64, hi: f64| Cell {
            t0: t,
            t1: t,
            bands: vec![Band::of((0.0, hi))].into(),
            marks: Box::default(),
        };
        // A long hold, then a jump in the same bucket as a further sample.
        let cells = [
            cell(0.0, 1.0),
            cell(50.0, 1.0),
            cell(50.001, 9.0),
            cell(100.0, 9.0),
        ];
        let panel = panel((0.0, 100.0), (0.0, 10.0));
        let data = outline(&panel, &cells, |cell| cell.band(0), Between::Holds);
        let drawn = loops(&data);
        let (top, _) = extent(&drawn[0], panel.px(49.9)).expect("a band at 49.9");
        assert!(panel.py(1.0) - top <= 0.02);
    }

    #[test]
    fn corners_on_a_line_are_left_out() {
        let cell = |t: f64| Cell {
            t0: t,
            t1: t,
            bands: vec![Band::of((1.0, 2.0))].into(),
            marks: Box::default(),
        };
        let cells: Vec<Cell> = (0..100).map(|k| cell(f64::from(k))).collect();
        let panel = panel((0.0, 99.0), (0.0, 3.0));
        let data = outline(&panel, &cells, |cell| cell.band(0), Between::Holds);
        assert_eq!(loops(&data)[0].len(), 4, "{data}");
    }

    #[test]
    fn nothing_is_drawn_of_nothing() {
        let panel = panel((0.0, 1.0), (0.0, 1.0));
        assert_eq!(
            outline(&panel, &[], |cell| cell.band(0), Between::Moves),
            ""
        );
    }
}
