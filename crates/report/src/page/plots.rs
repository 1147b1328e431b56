//! What the plots of a page are made of: a description in JSON, and columns of numbers.

use super::pack::Columns;
use crate::history::History;
use crate::identification::{Course, Identification, PavingTile, TileStatus};
use crate::meta::{Parameter, Quantity};
use crate::theme;
use crate::track::Cell;
use crate::tube::Tube;
use serde::Serialize;
use veribound_interval::{Interval, text};

/// The plots of a page.
///
/// Example: [`PavingTile`].
#[derive(Clone, Debug, Default)]
pub struct Plots {
    scene: Scene,
    columns: Columns,
}

/// All that is drawn, in the order of the page. Columns follow in the order of `tracks`, then of `planes`.
#[derive(Clone, Debug, Default, Serialize)]
struct Scene {
    /// Unit of time.
    time: String,
    /// Time of the proved contradiction.
    refuted: Option<f64>,
    tracks: Vec<TrackShape>,
    groups: Vec<Group>,
    modes: Vec<Modes>,
    planes: Vec<Plane>,
}

/// A track: first and last time of every cell, lo and hi of every series, and a byte per mark.
#[derive(Clone, Debug, Serialize)]
struct TrackShape {
    cells: usize,
    series: usize,
    marks: usize,
}

/// Panels over time that belong together.
#[derive(Clone, Debug, Serialize)]
struct Group {
    id: String,
    title: String,
    /// A paragraph above the panels.
    note: String,
    /// What the colours mean: a style and its words.
    legend: Vec<(&'static str, &'static str)>,
    panels: Vec<Panel>,
}

#[derive(Clone, Debug, Default, Serialize)]
struct Panel {
    name: String,
    unit: String,
    color: &'static str,
    layers: Vec<Layer>,
    /// Bounds that the user gave, and as they were spelled.
    prior: Option<Prior>,
    /// A broken line: a nominal value, or a deadline.
    line: Option<f64>,
    /// Marks of resets, of the track of the first layer.
    resets: Option<usize>,
    /// Whether zero belongs to the picture.
    zero: bool,
    /// Two ranges at the time of the contradiction: what the model allows, and what was measured.
    clash: Option<[(f64, f64); 2]>,
}

#[derive(Clone, Debug, Serialize)]
struct Prior {
    ends: (Option<f64>, Option<f64>),
    spelled: (String, String),
}

/// A series as a band.
#[derive(Clone, Debug, Serialize)]
struct Layer {
    track: usize,
    series: usize,
    style: &'static str,
    between: &'static str,
    /// What the hover text calls it; a layer without a name is not told.
    says: &'static str,
}

#[derive(Clone, Debug, Serialize)]
struct Modes {
    id: String,
    title: String,
    track: usize,
    names: Vec<String>,
}

/// Boxes that are shown in two of their dimensions.
#[derive(Clone, Debug, Serialize)]
struct Plane {
    title: String,
    note: String,
    axes: Vec<Axis>,
    /// Number of boxes; lo and hi of every axis, then a status per box follow.
    boxes: usize,
    /// What is painted: `tiles` with their edges, or a `union`.
    look: &'static str,
    /// Words for the status: outside, undecided, inside; none where no box has it. What is outside is not among
    /// the boxes: it is all of the prior that they do not cover.
    legend: [Option<&'static str>; 3],
    /// The axes that are shown first.
    first: [usize; 2],
}

#[derive(Clone, Debug, Serialize)]
struct Axis {
    name: String,
    unit: String,
    prior: (Option<f64>, Option<f64>),
}

const PROVED: (&str, &str) = ("proved", "proved bounds");

impl Plots {
    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// The description, fit to stand in a script element.
    pub(super) fn json(&self) -> String {
        // A description is made of texts and numbers, so that it has a form; `<` would end the element.
        let text = serde_json::to_string(&self.scene).unwrap_or_default();
        text.replace('<', "\\u003c")
    }

    /// The numbers.
    pub(super) fn packed(&self) -> String {
        self.columns.packed()
    }

    /// The plots of an observation.
    pub fn of_history(history: &History) -> Plots {
        let meta = history.meta();
        let mut plots = Plots::default();
        plots.scene.time.clone_from(&meta.time_unit);
        plots.scene.refuted = history.refuted_at;
        plots.track(
            history.detail(),
            history.milliseconds_series() + 1,
            history.marks(),
        );
        plots.course(0, history, &Chapter::default());
        let count = |series, says| Layer {
            track: 0,
            series,
            style: "count",
            between: "holds",
            says,
        };
        let boxes = Panel {
            color: theme::BLUE,
            layers: vec![count(history.boxes_series(), "boxes")],
            zero: true,
            ..Panel::of(&Quantity::new("boxes", ""))
        };
        let spent = Panel {
            color: theme::BLUE,
            layers: vec![count(history.milliseconds_series(), "spent")],
            line: meta.sample_time_ms,
            zero: true,
            ..Panel::of(&Quantity::new("time per sample", "ms"))
        };
        plots.group(
            Chapter::default().named("work", "Work"),
            Vec::new(),
            vec![boxes, spent],
        );
        plots
    }

    /// The plots of an enclosure.
    pub fn of_tube(tube: &Tube) -> Plots {
        let history = &tube.history;
        let meta = history.meta();
        let mut plots = Plots::default();
        plots.scene.time.clone_from(&meta.time_unit);
        plots.track(
            history.detail(),
            history.milliseconds_series() + 1,
            history.marks(),
        );
        let own = meta.states.len() + meta.outputs.len();
        plots.track(tube.since_detail(), own, 0);
        plots.track(tube.trajectories.cells(), tube.count * own, 0);
        let panel = |quantity: &Quantity, now: usize, at: usize| {
            let layer = |track, series, style, between, says| Layer {
                track,
                series,
                style,
                between,
                says,
            };
            let mut layers = vec![
                layer(1, at, "since", "steps", "at all times"),
                layer(0, now, "proved", "moves", "at this time"),
            ];
            let drawn = (0..tube.count).map(|number| tube.trajectory_series(number, at));
            layers.extend(drawn.map(|series| layer(2, series, "trajectory", "moves", "")));
            Panel {
                layers,
                ..Panel::of(quantity)
            }
        };
        let mut legend = vec![
            ("since", "proved at all times"),
            ("proved", "proved at the times of the table"),
        ];
        if tube.count > 0 {
            legend.push(("trajectory", "true trajectories"));
        }
        let states = meta.states.iter().enumerate();
        let states = states.map(|(i, quantity)| panel(quantity, history.state_series(i), i));
        plots.group(
            Chapter::default().named("states", "States"),
            legend.clone(),
            states.collect(),
        );
        let outputs = meta.outputs.iter().enumerate();
        let outputs = outputs
            .map(|(j, quantity)| panel(quantity, history.output_series(j), meta.states.len() + j));
        plots.group(
            Chapter::default().named("outputs", "Outputs"),
            legend,
            outputs.collect(),
        );
        plots.modes(0, &meta.modes, &Chapter::default());
        if meta.states.len() > 1 {
            let cells = tube.since.cells();
            let of = |cell: &Cell, i: usize| cell.band(i).map(|band| (band.lo, band.hi));
            let reached = cells.iter().filter_map(|cell| {
                let params = (0..meta.states.len()).map(|i| of(cell, i));
                Some(PavingTile {
                    params: params.collect::<Option<_>>()?,
                    status: TileStatus::Undecided,
                })
            });
            let first = tube.plane.map_or([0, 1], |(x, y)| [x, y]);
            let axes = meta.states.iter().map(|quantity| Axis::of(quantity, None));
            let words = (
                "Phase plane".to_owned(),
                "States at all times together. What is not coloured is proved to be reached never."
                    .to_owned(),
            );
            let legend = [None, Some("may be reached"), None];
            plots.plane(words, (axes.collect(), first), ("union", legend), reached);
        }
        plots
    }

    /// The plots of an identification: what is known along its records, and its paving.
    pub fn of_identification(found: &Identification, courses: &[Course]) -> Plots {
        let mut plots = Plots::default();
        for (number, course) in courses.iter().enumerate() {
            let history = &course.history;
            plots.scene.time.clone_from(&history.meta().time_unit);
            // Work is not told by sample.
            let series = history.boxes_series();
            plots.track(history.detail(), series, history.marks());
            plots.course(number, history, &Chapter::of(number, course));
        }
        if found.tiles.is_empty() || found.params.len() < 2 {
            return plots;
        }
        let axes =
            { found.params.iter() }.map(|param| Axis::of(&param.quantity, Some(param.prior)));
        let axes: Vec<Axis> = axes.collect();
        let first = Axis::first_open(&axes);
        let words = (
            "Paving".to_owned(),
            "Where there are more than two parameters, a point is shown as inside when it is proved to agree with \
             some values of the others, and as outside when it is proved to agree with none."
                .to_owned(),
        );
        let legend = [
            Some("proved outside"),
            Some("undecided"),
            Some("proved inside"),
        ];
        let known = |tile: &&PavingTile| tile.status != TileStatus::Outside;
        let tiles = found.tiles.iter().filter(known).cloned();
        plots.plane(words, (axes, first), ("tiles", legend), tiles);
        plots
    }

    /// Adds the boxes that an observation left, each a range of every quantity.
    #[must_use]
    pub fn with_boxes(mut self, axes: &[Parameter], boxes: Vec<Vec<(f64, f64)>>) -> Plots {
        if boxes.is_empty() || axes.len() < 2 {
            return self;
        }
        let axes = axes
            .iter()
            .map(|axis| Axis::of(&axis.quantity, Some(axis.prior)));
        let axes: Vec<Axis> = axes.collect();
        let first = Axis::first_open(&axes);
        let words = (
            "What is left".to_owned(),
            format!(
                "The {} after the last sample. What is not coloured is proved to contradict the record.",
                if boxes.len() == 1 {
                    "box".to_owned()
                } else {
                    format!("{} boxes", boxes.len())
                }
            ),
        );
        let tiles = boxes.into_iter().map(|params| PavingTile {
            params,
            status: TileStatus::Undecided,
        });
        let legend = [None, Some("not refuted"), None];
        self.plane(words, (axes, first), ("tiles", legend), tiles);
        self
    }

    fn track(&mut self, cells: &[Cell], series: usize, marks: usize) {
        self.scene.tracks.push(TrackShape {
            cells: cells.len(),
            series,
            marks,
        });
        self.columns.floats(cells.iter().map(|cell| cell.t0));
        self.columns.floats(cells.iter().map(|cell| cell.t1));
        for at in 0..series {
            let band = |cell: &Cell| cell.band(at);
            let lo = cells
                .iter()
                .map(|cell| band(cell).map_or(f64::NAN, |band| band.lo));
            self.columns.floats(lo);
            let hi = cells
                .iter()
                .map(|cell| band(cell).map_or(f64::NAN, |band| band.hi));
            self.columns.floats(hi);
        }
        for at in 0..marks {
            self.columns.bytes(cells.iter().map(|cell| cell.mark(at)));
        }
    }

    /// Outputs, states, parameters and modes along a record.
    fn course(&mut self, track: usize, history: &History, chapter: &Chapter) {
        let meta = history.meta();
        let layer = |series, style, between, says| Layer {
            track,
            series,
            style,
            between,
            says,
        };
        let outputs = meta.outputs.iter().enumerate().map(|(j, quantity)| Panel {
            layers: vec![
                layer(history.measured_series(j), "measured", "rare", "measured"),
                layer(history.output_series(j), "proved", "moves", "proved"),
            ],
            clash: history.clash_of(j),
            ..Panel::of(quantity)
        });
        let measured = ("measured", "what the measurement allows");
        let named = chapter.named("outputs", "Outputs");
        self.group(named, vec![measured, PROVED], outputs.collect());
        let states = meta.states.iter().enumerate().map(|(i, quantity)| Panel {
            layers: vec![layer(history.state_series(i), "proved", "moves", "proved")],
            ..Panel::of(quantity)
        });
        let named = chapter.named("states", "States");
        self.group(named, vec![PROVED], states.collect());
        let params = meta.params.iter().enumerate();
        let params = params.filter(|(i, _)| !chapter.only_resets || history.is_reset(*i));
        let params = params.map(|(i, param)| Panel {
            color: theme::parameter(i),
            layers: vec![layer(history.param_series(i), "proved", "holds", "proved")],
            prior: Some(Prior::of(param)),
            line: param.nominal,
            resets: Some(history.reset_marks(i)),
            ..Panel::of(&param.quantity)
        });
        let legend = vec![PROVED, ("prior", "prior"), ("reset", "reset")];
        let named = chapter.named("parameters", "Parameters");
        self.group(named, legend, params.collect());
        self.modes(track, &meta.modes, chapter);
    }

    fn group(
        &mut self,
        (id, title, note): (String, String, String),
        legend: Vec<(&'static str, &'static str)>,
        panels: Vec<Panel>,
    ) {
        if !panels.is_empty() {
            self.scene.groups.push(Group {
                id,
                title,
                note,
                legend,
                panels,
            });
        }
    }

    fn modes(&mut self, track: usize, names: &[String], chapter: &Chapter) {
        if names.len() > 1 {
            let (id, title, _) = chapter.named("modes", "Modes");
            self.scene.modes.push(Modes {
                id,
                title,
                track,
                names: names.to_vec(),
            });
        }
    }

    fn plane(
        &mut self,
        (title, note): (String, String),
        (axes, first): (Vec<Axis>, [usize; 2]),
        (look, legend): (&'static str, [Option<&'static str>; 3]),
        tiles: impl Iterator<Item = PavingTile>,
    ) {
        let tiles: Vec<PavingTile> = tiles.collect();
        let end = |tile: &PavingTile, at: usize| tile.params.get(at).copied();
        for at in 0..axes.len() {
            let lo = tiles
                .iter()
                .map(|tile| end(tile, at).map_or(f64::NAN, |x| x.0));
            self.columns.floats(lo);
            let hi = tiles
                .iter()
                .map(|tile| end(tile, at).map_or(f64::NAN, |x| x.1));
            self.columns.floats(hi);
        }
        self.columns
            .bytes(tiles.iter().map(|tile| match tile.status {
                TileStatus::Outside | TileStatus::Undecided => 1,
                TileStatus::Inside => 2,
            }));
        self.scene.planes.push(Plane {
            title,
            note,
            axes,
            boxes: tiles.len(),
            look,
            legend,
            first,
        });
    }
}

/// What the plots of a record are called, and say of themselves.
#[derive(Default)]
struct Chapter {
    /// Stands behind ids.
    number: String,
    /// Stands behind titles.
    of: String,
    /// Said of the outputs.
    note: String,
    /// Whether parameters that keep one value are left out.
    only_resets: bool,
}

impl Chapter {
    fn of(number: usize, course: &Course) -> Chapter {
        let mut note = String::from(
            "All that is left at each sample: parameters and start inside the outer bounds, in agreement with all samples \
             until then.",
        );
        if !course.is_whole {
            note.push_str(" Beyond the last time shown nothing is proved.");
        }
        let of = course.record.as_ref();
        Chapter {
            number: match number {
                0 => String::new(),
                _ => format!("-{}", number + 1),
            },
            of: of.map_or_else(String::new, |record| format!(", {record}")),
            note,
            only_resets: true,
        }
    }

    /// Id, title and note of a group.
    fn named(&self, id: &str, title: &str) -> (String, String, String) {
        let note = if id == "outputs" { &*self.note } else { "" };
        let Chapter { number, of, .. } = self;
        (
            format!("{id}{number}"),
            format!("{title}{of}"),
            note.to_owned(),
        )
    }
}

impl Panel {
    fn of(quantity: &Quantity) -> Panel {
        Panel {
            name: quantity.name.clone(),
            unit: quantity.unit.clone(),
            color: theme::BLUE,
            ..Panel::default()
        }
    }
}

impl Prior {
    fn of(param: &Parameter) -> Prior {
        let (lo, hi) = param.prior;
        Prior {
            ends: (finite(lo), finite(hi)),
            spelled: spelled(lo, hi),
        }
    }
}

impl Axis {
    fn of(quantity: &Quantity, prior: Option<(f64, f64)>) -> Axis {
        let (lo, hi) = prior.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        Axis {
            name: quantity.name.clone(),
            unit: quantity.unit.clone(),
            prior: (finite(lo), finite(hi)),
        }
    }

    /// The first two axes that are not known exactly.
    fn first_open(axes: &[Axis]) -> [usize; 2] {
        let is_open = |axis: &Axis| axis.prior.0.is_none() || axis.prior.0 != axis.prior.1;
        let mut open = axes.iter().enumerate().filter(|(_, axis)| is_open(axis));
        let mut next = || open.next().map(|(at, _)| at);
        let x = next().unwrap_or(0);
        [x, next().unwrap_or(usize::from(x == 0))]
    }
}

/// The ends as the user may have spelled them: the shortest decimals that read as these floats, or enclose them.
fn spelled(lo: f64, hi: f64) -> (String, String) {
    Interval::new(lo, hi).map_or_else(Default::default, text::spelled)
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

#[cfg(test)]
mod tests {
    use super::super::pack::tests::{floats, unpacked};
    use super::*;
    use crate::history::SampleRow;
    use crate::meta::FigureMeta;

    /// A run of so many samples, with a name that could end a script.
    fn history(samples: u32) -> History {
        let mut history = History::new(FigureMeta {
            outputs: vec![Quantity::new("</script>", "<rad>")],
            params: vec![Parameter {
                quantity: Quantity::new("k", ""),
                prior: (-0.3, f64::INFINITY),
                nominal: None,
            }],
            modes: vec!["slip".to_owned(), "stick".to_owned()],
            page: true,
            ..FigureMeta::default()
        });
        for k in 0..samples {
            let t = f64::from(k) / 10.0;
            history
                .push(&SampleRow {
                    t,
                    outputs: &[(t - 0.1, t + 1.0 / 3.0)],
                    measured: &[(k != 1).then_some((t - 0.2, t + 0.4))],
                    params: &[(-0.3, f64::INFINITY)],
                    resets: &[k == 2],
                    modes: &[k == 0, true],
                    boxes: 7,
                    milliseconds: 0.5,
                    ..SampleRow::default()
                })
                .unwrap();
        }
        history
    }

    #[test]
    fn the_page_has_the_bounds_bit_by_bit() {
        let history = history(3);
        let plots = Plots::of_history(&history);
        let bytes = unpacked(&plots.packed());
        let mut from = 0;
        let mut next = || floats(&bytes, &mut from, 3);
        assert_eq!(next(), [0.0, 0.1, 0.2]);
        assert_eq!(next(), [0.0, 0.1, 0.2]);
        assert_eq!(next(), [-0.1, 0.1 - 0.1, 0.2 - 0.1]);
        assert_eq!(next(), [1.0 / 3.0, 0.1 + 1.0 / 3.0, 0.2 + 1.0 / 3.0]);
        // Measured; nothing at the second sample.
        let measured = next();
        assert!(measured[1].is_nan() && measured[0] == -0.2);
        next();
        assert_eq!(next(), [-0.3; 3]);
        assert_eq!(next(), [f64::INFINITY; 3]);
        for wanted in [7.0, 7.0, 0.5, 0.5] {
            assert_eq!(next(), [wanted; 3]);
        }
        // Modes: possible beside others at first, then impossible and alone. Then the reset.
        assert_eq!(bytes[from..], [3, 2, 2, 3, 1, 1, 0, 0, 1]);
    }

    #[test]
    fn the_description_cannot_end_its_script() {
        let plots = Plots::of_history(&history(3));
        assert!(!plots.json().contains('<'));
        let scene: serde_json::Value = serde_json::from_str(&plots.json()).unwrap();
        assert_eq!(scene["groups"][0]["panels"][0]["name"], "</script>");
        assert_eq!(
            scene["groups"][1]["panels"][0]["prior"]["ends"][1],
            serde_json::Value::Null
        );
        assert_eq!(
            scene["groups"][1]["panels"][0]["prior"]["spelled"][0],
            "-0.3"
        );
    }

    /// Long records keep far more columns than the figures do, and not more than memory allows.
    #[test]
    fn many_samples_share_cells() {
        let long = history(120_000);
        let cells = long.detail().len();
        assert!((20_000..=100_000).contains(&cells), "{cells}");
        assert_eq!(history(90_000).detail().len(), 90_000);
        assert!(long.cells().len() <= 4000);
        let figures_only = History::new(FigureMeta::default());
        assert_eq!(figures_only.detail().len(), 0);
    }
}
