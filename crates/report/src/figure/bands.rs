//! Figures of parameters and states: a panel with a band for each.

use veribound_interval::{Interval, text};

use super::{Frame, Row, mark_empty, mark_refuted, refuted_entry, right_edge, stack, why_empty};
use crate::history::{History, RESET};
use crate::legend::{self, Entry, Swatch};
use crate::panel::{Panel, value_axis};
use crate::ribbon::{Between, outline};
use crate::svg::Canvas;
use crate::theme;
use crate::track::Band;

/// One panel per parameter: proved band, prior, resets, nominal value, and the other run's band.
pub(super) fn draw_params(history: &History, other: Option<&History>) -> String {
    let mut canvas = Canvas::new("params", theme::WIDTH);
    let right = right_edge(history);
    let params = &history.meta.params;
    let hatch = canvas.hatch("#8A8A8A", "#fff");
    let twin = |i: usize| {
        let name = &params.get(i)?.quantity.name;
        let other = other?;
        let place = other
            .meta
            .params
            .iter()
            .position(|p| p.quantity.name == *name)?;
        Some((other, other.param_series(place)))
    };

    let mut rows = Vec::new();
    let height = panel_height(params.len());
    for (i, param) in params.iter().enumerate() {
        let series = history.param_series(i);
        let mut bands = bands(history, series);
        if let Some((other, series)) = twin(i) {
            bands.extend(self::bands(other, series));
        }
        let mut extra = vec![param.prior.0, param.prior.1];
        extra.extend(param.nominal);
        rows.push(Row {
            name: param.quantity.label(),
            remark: final_bounds(history, series, param.prior),
            value: value_axis(&bands, &extra, height, theme::SMALL),
            height,
        });
    }

    let entries = params_legend(history, other, &hatch);
    let top = 4.0 + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);
    let stack = stack(
        &mut canvas,
        history,
        rows,
        Frame {
            top,
            right,
            gap: 0.0,
        },
    );
    for (i, (param, panel)) in params.iter().zip(&stack.panels).enumerate() {
        panel.grid(&mut canvas);
        canvas.open_clip(panel.area);
        // The other run's hatching shows where its bounds are wider, its edge everywhere.
        let behind = twin(i).map_or_else(String::new, |(other, series)| {
            outline(
                panel,
                other.cells(),
                |cell| cell.band(series),
                Between::Holds,
            )
        });
        canvas.path(&behind, &theme::compared(&hatch));
        let series = history.param_series(i);
        let data = outline(
            panel,
            history.cells(),
            |cell| cell.band(series),
            Between::Holds,
        );
        if !behind.is_empty() {
            canvas.path(&data, "fill=\"#fff\"");
        }
        canvas.path(&data, &theme::band(theme::parameter(i)));
        canvas.path(&behind, &theme::compared("none"));
        canvas.close();
        for value in [param.prior.0, param.prior.1] {
            level(&mut canvas, panel, value, &theme::prior());
        }
        if let Some(nominal) = param.nominal {
            level(&mut canvas, panel, nominal, &theme::dashed());
        }
        mark_resets(&mut canvas, history, panel, i);
        finish(&mut canvas, history, panel, data.is_empty());
    }
    canvas.finish(
        stack.bottom,
        &history.title("proved bounds of the parameters over time"),
    )
}

/// One panel per state with its proved band.
pub(super) fn draw_states(history: &History) -> String {
    let mut canvas = Canvas::new("states", theme::WIDTH);
    let right = right_edge(history);
    let states = &history.meta.states;
    let height = panel_height(states.len());
    let rows = (states.iter().enumerate())
        .map(|(i, state)| {
            let series = history.state_series(i);
            Row {
                name: state.label(),
                remark: final_bounds(history, series, NO_PRIOR),
                value: value_axis(&bands(history, series), &[], height, theme::SMALL),
                height,
            }
        })
        .collect();
    let mut entries = vec![Entry::area(
        theme::band(theme::BLUE),
        "proved at the samples",
    )];
    entries.extend(refuted_entry(history));
    let top = 4.0 + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);
    let stack = stack(
        &mut canvas,
        history,
        rows,
        Frame {
            top,
            right,
            gap: 0.0,
        },
    );
    for (i, panel) in stack.panels.iter().enumerate() {
        panel.grid(&mut canvas);
        let series = history.state_series(i);
        let data = outline(
            panel,
            history.cells(),
            |cell| cell.band(series),
            Between::Moves,
        );
        canvas.open_clip(panel.area);
        canvas.path(&data, &theme::band(theme::BLUE));
        canvas.close();
        finish(&mut canvas, history, panel, data.is_empty());
    }
    canvas.finish(
        stack.bottom,
        &history.title("proved bounds of the states over time"),
    )
}

fn params_legend(history: &History, other: Option<&History>, hatch: &str) -> Vec<Entry> {
    let params = &history.meta.params;
    let colors = (0..params.len().min(3))
        .map(|i| theme::band(theme::parameter(i)))
        .collect();
    let text = if other.is_some() {
        history.meta.label.clone()
    } else {
        "proved bounds".to_owned()
    };
    let mut entries = vec![Entry {
        swatch: Swatch::Area(colors),
        text,
    }];
    if let Some(other) = other {
        entries.push(Entry::area(
            theme::compared(hatch),
            other.meta.label.clone(),
        ));
    }
    if params
        .iter()
        .any(|p| p.prior.0.is_finite() || p.prior.1.is_finite())
    {
        entries.push(Entry::line(theme::prior(), "prior"));
    }
    if params.iter().any(|p| p.nominal.is_some_and(f64::is_finite)) {
        entries.push(Entry::line(theme::dashed(), "nominal"));
    }
    let is_reset = |i: usize| {
        history
            .cells()
            .iter()
            .any(|c| c.mark(history.reset_marks(i)) & RESET != 0)
    };
    if (0..params.len()).any(is_reset) {
        entries.push(Entry {
            swatch: Swatch::Tick(theme::reset()),
            text: "reset".to_owned(),
        });
    }
    entries.extend(refuted_entry(history));
    entries
}

/// Ticks at the upper edge where the parameter was reset.
fn mark_resets(canvas: &mut Canvas, history: &History, panel: &Panel, i: usize) {
    let mark = history.reset_marks(i);
    for cell in history
        .cells()
        .iter()
        .filter(|cell| cell.mark(mark) & RESET != 0)
    {
        let x = panel.px(cell.t0);
        canvas.line(
            (x, panel.area.y - 4.0),
            (x, panel.area.y + 5.0),
            &theme::reset(),
        );
    }
}

fn level(canvas: &mut Canvas, panel: &Panel, value: f64, style: &str) {
    let (lo, hi) = panel.value.range();
    if (lo..=hi).contains(&value) {
        let y = panel.py(value);
        canvas.line((panel.area.x, y), (panel.area.right(), y), style);
    }
}

fn finish(canvas: &mut Canvas, history: &History, panel: &Panel, is_empty: bool) {
    mark_refuted(canvas, history, panel);
    if is_empty {
        mark_empty(canvas, panel, why_empty(history));
    }
    panel.axes(canvas, theme::SMALL);
}

fn bands(history: &History, series: usize) -> Vec<Band> {
    history
        .cells()
        .iter()
        .filter_map(|cell| cell.band(series))
        .collect()
}

/// Few panels are drawn high, many lower.
pub(super) fn panel_height(count: usize) -> f64 {
    match count {
        0 | 1 => 200.0,
        2 => 140.0,
        3 => 112.0,
        _ => 92.0,
    }
}

pub(super) const NO_PRIOR: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

/// The bounds after the last sample, with the digits of the tables for people; an end at which nothing
/// was cut off the prior is the prior's own.
pub(super) fn final_bounds(history: &History, series: usize, prior: (f64, f64)) -> String {
    let last = history.last_band(series);
    let Some(bounds) = last.and_then(|band| Interval::new(band.lo, band.hi)) else {
        return String::new();
    };
    let prior = Interval::new(prior.0, prior.1).unwrap_or(Interval::ENTIRE);
    let (lo, hi) = text::inside_prior(text::readable(bounds), bounds, prior);
    let bounds = if lo == hi {
        format!("final {lo}")
    } else {
        format!("final [{lo}, {hi}]")
    };
    bounds.replace('-', "\u{2212}")
}
