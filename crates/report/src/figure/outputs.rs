//! The figure of the outputs: what was measured, what is proved, and a stretch of it enlarged.

use super::{
    FOOT, Frame, Row, mark_empty, mark_refuted, refuted_entry, right_edge, stack, why_empty,
};
use crate::history::History;
use crate::legend::{self, Entry};
use crate::panel::{Panel, time_axis, value_axis};
use crate::place::Shadow;
use crate::ribbon::{Between, outline};
use crate::svg::{Anchor, Canvas, Rect};
use crate::theme;
use crate::track::{Band, Cell};

/// Inset sizes tried, largest first, as parts of the panel's width and height.
const INSETS: [(f64, f64); 5] = [
    (0.46, 0.56),
    (0.42, 0.5),
    (0.38, 0.46),
    (0.34, 0.42),
    (0.3, 0.38),
];
/// Room kept free around an inset, for its tick labels too: left, right, top, bottom.
const LABELS: (f64, f64, f64, f64) = (40.0, 14.0, 8.0, 22.0);
/// The same around an enlargement that stands beside its panel: left, right.
const BESIDE: (f64, f64) = (52.0, 8.0);
/// Width of a bucket of time in an enlarged panel, in hundredths of a unit.
const FINE: i64 = 5;

/// One panel per output, each with an inset where the panel has room for it; where one has not,
/// all enlargements stand beside their panels.
pub(super) fn draw(history: &History) -> String {
    let mut canvas = Canvas::new("outputs", theme::WIDTH);
    let right = right_edge(history);
    let count = history.meta.outputs.len();
    let mut entries = vec![
        Entry::area(theme::measured(), "measured"),
        Entry::area(theme::band(theme::BLUE), "proved at the samples"),
    ];
    entries.extend(refuted_entry(history));
    let top = 4.0 + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);

    let inside = layout(
        &mut Canvas::new("outputs", theme::WIDTH),
        history,
        Frame {
            top,
            right,
            gap: 0.0,
        },
    );
    let places: Option<Vec<Rect>> = history.zoom_cells().and_then(|zoom| {
        (0..count)
            .zip(&inside.panels)
            .map(|(j, panel)| room_for_inset(history, panel, j, zoom))
            .collect()
    });
    let beside = history.zoom_cells().is_some() && places.is_none();
    let edge = if beside { 0.64 * right } else { right };
    // Enlargements beside the panels have time labels of their own, which need room below.
    let gap = if beside { 20.0 } else { 0.0 };
    let stack = layout(
        &mut canvas,
        history,
        Frame {
            top,
            right: edge,
            gap,
        },
    );
    for (j, panel) in stack.panels.iter().enumerate() {
        panel.grid(&mut canvas);
        let area = places.as_ref().and_then(|places| places.get(j)).copied();
        let area = area.unwrap_or(Rect {
            x: edge + BESIDE.0,
            y: panel.area.y,
            w: right - edge - BESIDE.0 - BESIDE.1,
            h: panel.area.h,
        });
        let zoom = history
            .zoom_cells()
            .map(|zoom| (zoom, enlarged(history, j, zoom, area)));
        if let Some((_, zoomed)) = &zoom {
            connect(&mut canvas, panel, zoomed, !beside);
        }
        canvas.open_clip(panel.area);
        let has_data = draw_bands(&mut canvas, history, panel, j, history.cells());
        canvas.close();
        mark_refuted(&mut canvas, history, panel);
        if !has_data {
            mark_empty(&mut canvas, panel, why_empty(history));
        }
        panel.axes(&mut canvas, theme::SMALL);
        if let Some((cells, zoomed)) = &zoom {
            draw_enlarged(&mut canvas, history, (zoomed, j, cells), beside);
        }
    }
    if beside {
        let at = (
            (edge + BESIDE.0 + right - BESIDE.1) / 2.0,
            stack.bottom - FOOT + 34.0,
        );
        canvas.text(at, &history.time_label(), Anchor::Middle, theme::LABEL);
    }
    canvas.finish(
        stack.bottom,
        &history.title("measured and proved outputs over time"),
    )
}

fn layout(canvas: &mut Canvas, history: &History, frame: Frame) -> super::Stack {
    let outputs = &history.meta.outputs;
    let height = match outputs.len() {
        0 | 1 => 280.0,
        2 => 200.0,
        _ => 150.0,
    };
    let rows = (outputs.iter().enumerate())
        .map(|(j, output)| {
            let bands = both(history, j, history.cells());
            let value = value_axis(&bands, &[], height, theme::SMALL);
            Row {
                name: output.label(),
                remark: String::new(),
                value,
                height,
            }
        })
        .collect();
    stack(canvas, history, rows, frame)
}

/// Measured and proved bands of an output.
fn both(history: &History, j: usize, cells: &[Cell]) -> Vec<Band> {
    let series = [history.measured_series(j), history.output_series(j)];
    series
        .into_iter()
        .flat_map(|s| cells.iter().filter_map(move |c| c.band(s)))
        .collect()
}

fn draw_bands(
    canvas: &mut Canvas,
    history: &History,
    panel: &Panel,
    j: usize,
    cells: &[Cell],
) -> bool {
    let (measured, proved) = (history.measured_series(j), history.output_series(j));
    let grey = outline(panel, cells, |cell| cell.band(measured), Between::Rare);
    canvas.path(&grey, &theme::measured());
    let blue = outline(panel, cells, |cell| cell.band(proved), Between::Moves);
    canvas.path(&blue, &theme::band(theme::BLUE));
    !(grey.is_empty() && blue.is_empty())
}

/// The place of the inset's axes, with its labels clear of the data, near what it enlarges.
fn room_for_inset(history: &History, panel: &Panel, j: usize, zoom: &[Cell]) -> Option<Rect> {
    let series = [history.measured_series(j), history.output_series(j)];
    let shadow = Shadow::of(panel, history.cells(), &series);
    let frame = source(panel, zoom, &both(history, j, zoom));
    let target = (frame.x + frame.w / 2.0, frame.y + frame.h / 2.0);
    let (left, right, above, below) = LABELS;
    INSETS.iter().find_map(|(w, h)| {
        let (w, h) = (w * panel.area.w, h * panel.area.h);
        if w < 110.0 || h < 60.0 {
            return None;
        }
        let outer = shadow.place((w + left + right, h + above + below), target)?;
        Some(Rect {
            x: outer.x + left,
            y: outer.y + above,
            w,
            h,
        })
    })
}

/// The frame around what is enlarged, large enough to be seen.
fn source(panel: &Panel, zoom: &[Cell], bands: &[Band]) -> Rect {
    let t = (
        zoom.first().map_or(0.0, |c| c.t0),
        zoom.last().map_or(0.0, |c| c.t1),
    );
    let hull = bands
        .iter()
        .copied()
        .reduce(Band::hull)
        .unwrap_or(Band { lo: 0.0, hi: 0.0 });
    let (x0, x1) = (panel.px(t.0), panel.px(t.1));
    let (y0, y1) = (panel.py(hull.hi), panel.py(hull.lo));
    let (w, h) = ((x1 - x0).max(7.0), (y1 - y0).max(7.0));
    Rect {
        x: (x0 + x1 - w) / 2.0,
        y: (y0 + y1 - h) / 2.0,
        w,
        h,
    }
}

/// The panel that enlarges the window, in the given place.
fn enlarged(history: &History, j: usize, zoom: &[Cell], area: Rect) -> Panel {
    let span = zoom
        .first()
        .zip(zoom.last())
        .map(|(first, last)| (first.t0, last.t1));
    let time = time_axis(span, area.w, theme::TINY);
    let value = value_axis(&both(history, j, zoom), &[], area.h, theme::TINY);
    Panel {
        area,
        time,
        value,
        bucket: FINE,
    }
}

const GUIDE: &str = "stroke=\"#6E6E6E\" stroke-width=\"0.7\"";

/// The frame around what is enlarged, and lines from it to the enlargement.
fn connect(canvas: &mut Canvas, panel: &Panel, zoomed: &Panel, is_inset: bool) {
    let (from, to) = zoomed.time.range();
    let (lo, hi) = zoomed.value.range();
    let bands = [Band { lo, hi }];
    let moment = |t: f64| Cell {
        t0: t,
        t1: t,
        bands: Box::default(),
        marks: Box::default(),
    };
    let frame = source(panel, &[moment(from), moment(to)], &bands);
    canvas.rect(frame, &format!("fill=\"none\" {GUIDE}"));
    let area = zoomed.area;
    if !is_inset {
        return;
    }
    let (left, right, above, below) = LABELS;
    let outer = Rect {
        x: area.x - left,
        y: area.y - above,
        w: area.w + left + right,
        h: area.h + above + below,
    };
    let (ends, starts) = if outer.right() <= frame.x {
        (
            [(area.right(), area.y), (area.right(), area.bottom())],
            [(frame.x, frame.y), (frame.x, frame.bottom())],
        )
    } else if outer.x >= frame.right() {
        (
            [(area.x, area.y), (area.x, area.bottom())],
            [(frame.right(), frame.y), (frame.right(), frame.bottom())],
        )
    } else if outer.bottom() <= frame.y {
        (
            [(area.x, area.bottom()), (area.right(), area.bottom())],
            [(frame.x, frame.y), (frame.right(), frame.y)],
        )
    } else {
        (
            [(area.x, area.y), (area.right(), area.y)],
            [(frame.x, frame.bottom()), (frame.right(), frame.bottom())],
        )
    };
    for (start, end) in starts.into_iter().zip(ends) {
        canvas.line(start, end, GUIDE);
    }
}

fn draw_enlarged(
    canvas: &mut Canvas,
    history: &History,
    what: (&Panel, usize, &[Cell]),
    beside: bool,
) {
    let (panel, j, cells) = what;
    let font = if beside { theme::SMALL } else { theme::TINY };
    if !beside {
        // White below the inset and its labels, so that grid lines do not run through the text.
        let a = panel.area;
        let side = panel.value.label_width(font.size) + 9.0;
        let end = panel.time.label_width(font.size) / 2.0 + 3.0;
        let white = "fill=\"#fff\"";
        canvas.rect(
            Rect {
                x: a.x - side,
                y: a.y - 5.0,
                w: a.w + side,
                h: a.h + 5.0,
            },
            white,
        );
        let feet = Rect {
            x: a.x - side,
            y: a.bottom(),
            w: a.w + side + end,
            h: font.size + 9.0,
        };
        canvas.rect(feet, white);
    }
    panel.grid(canvas);
    canvas.open_clip(panel.area);
    draw_bands(canvas, history, panel, j, cells);
    canvas.close();
    panel.axes(canvas, font);
    canvas.rect(panel.area, &format!("fill=\"none\" {GUIDE}"));
}
