//! Figures of an enclosure over time: what is proved at all times, at the times of the table, and true
//! trajectories.

use super::bands::{NO_PRIOR, final_bounds, panel_height};
use super::{Frame, Row, mark_empty, right_edge, stack, why_empty};
use crate::legend::{self, Entry, Swatch};
use crate::panel::{Panel, value_axis};
use crate::ribbon::{Between, outline};
use crate::svg::Canvas;
use crate::theme;
use crate::track::{Band, Cell};
use crate::tube::Tube;

/// Up to so many times are drawn apart; more are joined.
const FEW: usize = 60;

/// A quantity with the places of its bounds.
struct Series {
    label: String,
    /// In the history of the times.
    at: usize,
    /// In the track of all times, and of every trajectory.
    since: usize,
    past_use: Option<f64>,
}

impl Tube {
    /// One panel per output.
    pub(crate) fn draw_outputs(&self) -> String {
        let meta = self.history.meta();
        let series = meta.outputs.iter().enumerate().map(|(j, output)| Series {
            label: output.label(),
            at: self.history.output_series(j),
            since: meta.states.len() + j,
            past_use: None,
        });
        let title = "all values of the outputs over time";
        self.draw_panels("outputs", &series.collect::<Vec<_>>(), title)
    }

    /// One panel per state.
    pub(crate) fn draw_states(&self) -> String {
        let states = self.history.meta().states.iter().enumerate();
        let series = states.map(|(i, state)| Series {
            label: state.label(),
            at: self.history.state_series(i),
            since: i,
            past_use: self.past_use.get(i).copied().flatten(),
        });
        let title = "all values of the states over time";
        self.draw_panels("states", &series.collect::<Vec<_>>(), title)
    }

    /// The mode strip.
    pub(crate) fn draw_modes(&self) -> String {
        super::modes::draw(&self.history)
    }

    fn draw_panels(&self, name: &'static str, series: &[Series], title: &str) -> String {
        let history = &self.history;
        let mut canvas = Canvas::new(name, theme::WIDTH);
        let right = right_edge(history);
        let height = panel_height(series.len());
        let rows = series.iter().map(|series| Row {
            name: series.label.clone(),
            remark: final_bounds(history, series.at, NO_PRIOR),
            value: value_axis(&self.all_bands(series), &[], height, theme::SMALL),
            height,
        });
        let mut entries = self.entries();
        if series.iter().any(|series| series.past_use.is_some()) {
            entries.push(Entry {
                swatch: Swatch::Tick(past_use()),
                text: "wider than useful from here on".to_owned(),
            });
        }
        let top = 4.0 + legend::draw(&mut canvas, &entries, (2.0, right), 4.0);
        let frame = Frame {
            top,
            right,
            gap: 0.0,
        };
        let stack = stack(&mut canvas, history, rows.collect(), frame);
        for (series, panel) in series.iter().zip(&stack.panels) {
            panel.grid(&mut canvas);
            canvas.open_clip(panel.area);
            let is_empty = self.draw_bands(&mut canvas, panel, series);
            canvas.close();
            if let Some(t) = series.past_use {
                let x = panel.px(t);
                canvas.line((x, panel.area.y), (x, panel.area.bottom()), &past_use());
            }
            if is_empty {
                mark_empty(&mut canvas, panel, why_empty(history));
            }
            panel.axes(&mut canvas, theme::SMALL);
        }
        canvas.finish(stack.bottom, &history.title(title))
    }

    /// Draws one quantity; returns whether there is nothing.
    fn draw_bands(&self, canvas: &mut Canvas, panel: &Panel, series: &Series) -> bool {
        let whole = outline(
            panel,
            self.since.cells(),
            |cell| cell.band(series.since),
            Between::Moves,
        );
        canvas.path(&whole, &theme::tube());
        let times = self.history.cells();
        let band = |cell: &Cell| cell.band(series.at);
        let at: String = if times.len() > FEW {
            outline(panel, times, band, Between::Moves)
        } else {
            let alone = times.chunks(1);
            alone
                .map(|one| outline(panel, one, band, Between::Rare))
                .collect()
        };
        canvas.path(&at, &theme::band(theme::BLUE));
        for number in 0..self.count {
            let own = self.trajectory_series(number, series.since);
            let cells = self.trajectories.cells();
            let line = outline(panel, cells, |cell| cell.band(own), Between::Moves);
            canvas.path(&line, &format!("fill=\"none\" {}", theme::trajectory()));
        }
        whole.is_empty() && at.is_empty()
    }

    pub(super) fn entries(&self) -> Vec<Entry> {
        let mut entries = vec![
            Entry::area(theme::tube(), "proved at all times"),
            Entry::area(theme::band(theme::BLUE), "proved at the times of the table"),
        ];
        if self.count > 0 {
            entries.push(Entry::line(theme::trajectory(), "true trajectories"));
        }
        entries
    }

    /// The bands that the axis is to show: those before widths grow past use.
    fn all_bands(&self, series: &Series) -> Vec<Band> {
        let last = self.last_useful();
        let is_shown = |cell: &&Cell| cell.t1 <= last;
        let at = self.history.cells().iter().filter(is_shown);
        let since = self.since.cells().iter().filter(is_shown);
        let bands = at.filter_map(|cell| cell.band(series.at));
        bands
            .chain(since.filter_map(|cell| cell.band(series.since)))
            .collect()
    }
}

fn past_use() -> String {
    format!(
        "stroke=\"{}\" stroke-width=\"1.2\" stroke-dasharray=\"4 3\"",
        theme::RED
    )
}
