//! The figures as a user of the crate gets them: complete, the same each time, and sound text.

#![allow(
    clippy::expect_used,
    clippy::indexing_slicing,
    reason = "a test that cannot go on has failed"
)]

use std::collections::BTreeSet;

use veribound_report::{
    Figure, FigureMeta, History, Identification, Parameter, PavingTile, ProvedParameter, Quantity,
    ReportError, SampleRow, TileStatus, Tube, TubeRow, Zoom, png,
};

fn meta() -> FigureMeta {
    FigureMeta {
        title: "a < b & \"c\"".to_owned(),
        outputs: vec![Quantity::new("phi_m", "rad")],
        states: vec![Quantity::new("phi", "rad"), Quantity::new("omega", "rad/s")],
        params: vec![Parameter {
            quantity: Quantity::new("alpha", "1/s"),
            prior: (-6.0, -0.05),
            nominal: Some(-2.5),
        }],
        modes: vec!["forward".to_owned(), "stick".to_owned()],
        sample_time_ms: Some(10.0),
        ..FigureMeta::default()
    }
}

/// A history of `count` samples with the given bounds of everything.
fn history(
    meta: FigureMeta,
    count: u32,
    bounds: impl Fn(f64) -> (f64, f64),
    measured: bool,
) -> History {
    let mut history = History::new(meta);
    for k in 0..count {
        let t = f64::from(k) * 0.01;
        let b = bounds(t);
        let row = SampleRow {
            t,
            outputs: &[b],
            measured: &[measured.then_some((b.0 - 0.1, b.1 + 0.1))],
            states: &[b, b],
            params: &[b],
            resets: &[k == 50],
            modes: &[k % 3 == 0, true],
            boxes: u64::from(k % 7),
            milliseconds: f64::from(k % 5) * 0.1,
        };
        history.push(&row).expect("a row of the right shape");
    }
    history
}

/// The text is sound, and a picture can be made of it.
fn assert_drawable(figures: &[Figure]) {
    assert_sound(figures);
    for Figure { name, svg } in figures {
        assert!(
            png(svg).expect("a picture").starts_with(b"\x89PNG"),
            "{name}"
        );
    }
}

fn assert_sound(figures: &[Figure]) {
    for Figure { name, svg } in figures {
        assert!(
            !svg.contains("NaN") && !svg.contains("inf\"") && !svg.contains("inf "),
            "{name}"
        );
        for data in svg
            .split(" d=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
        {
            let is_plain = |c: char| c.is_ascii_digit() || "MLHVZ .-".contains(c);
            assert!(data.chars().all(is_plain), "{name}: {data}");
        }
        let ids: Vec<&str> = svg
            .split(" id=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .collect();
        assert_eq!(
            ids.len(),
            ids.iter().collect::<BTreeSet<_>>().len(),
            "{name}: ids twice"
        );
    }
}

#[test]
fn every_figure_is_there_and_the_same_each_time() {
    let make = || history(meta(), 3000, |t| (t.sin() - 0.1, t.sin() + 0.1), true);
    let figures = make().render_all();
    let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
    assert_eq!(names, ["outputs", "params", "states", "modes", "work"]);
    assert_eq!(figures, make().render_all());
    assert_drawable(&figures);
    let outputs = &figures[0].svg;
    assert!(outputs.contains(">phi_m [rad]<") && outputs.contains(">time [s]<"));
    assert!(outputs.contains("<title>a &lt; b &amp; &quot;c&quot;"));
    assert!(figures[1].svg.contains(">reset<"));
}

#[test]
fn odd_histories_have_figures() {
    let infinite = |_: f64| (f64::NEG_INFINITY, f64::INFINITY);
    let empty_set = |_: f64| (f64::INFINITY, f64::NEG_INFINITY);
    let unknown = |_: f64| (f64::NAN, f64::NAN);
    let huge = |t: f64| (-f64::MAX, f64::MAX * t.min(1.0));
    let tiny = |_: f64| (5e-324, 5e-324);
    let half = |t: f64| (f64::NEG_INFINITY, t);
    for count in [0, 1, 2, 40, 500] {
        // Drawing takes long: once for each kind of bounds is enough.
        let check = if count == 40 {
            assert_drawable
        } else {
            assert_sound
        };
        for measured in [false, true] {
            check(&history(meta(), count, infinite, measured).render_all());
            check(&history(meta(), count, empty_set, measured).render_all());
            check(&history(meta(), count, unknown, measured).render_all());
        }
        check(&history(meta(), count, huge, true).render_all());
        check(&history(meta(), count, tiny, true).render_all());
        check(&history(meta(), count, half, true).render_all());
    }
    let nothing = History::new(FigureMeta::default()).render_all();
    assert_eq!(nothing.len(), 1);
    assert_drawable(&nothing);
}

#[test]
fn a_zoom_outside_the_record_is_no_zoom() {
    let with =
        |zoom| history(FigureMeta { zoom, ..meta() }, 300, |t| (t, t + 0.1), true).render_all();
    let off = with(Zoom::Off);
    assert_eq!(off, with(Zoom::Window(10.0, 20.0)));
    assert_eq!(off, with(Zoom::Window(f64::NAN, 1.0)));
    assert_ne!(off, with(Zoom::Window(1.0, 1.2)));
    assert_ne!(off, with(Zoom::Auto));
}

#[test]
fn the_zoom_shows_every_sample_of_its_window() {
    // 20 000 samples in 100 columns, one of them with a spike: the window has it at its own time.
    let zoom = Zoom::Window(100.0, 100.3);
    let few = FigureMeta {
        columns: 100,
        zoom,
        ..meta()
    };
    let spike = |t: f64| {
        if (t - 100.15).abs() < 1e-6 {
            (-5.0, 5.0)
        } else {
            (-0.1, 0.1)
        }
    };
    let svg = history(few, 20_000, spike, true)
        .render_all()
        .swap_remove(0)
        .svg;
    assert!(
        svg.contains(">100.1<") && svg.contains(">100.2<"),
        "ticks of the window"
    );
}

#[test]
fn a_compared_run_is_in_the_legend() {
    let label = |text: &str| FigureMeta {
        label: text.to_owned(),
        ..meta()
    };
    let one = history(label("exact input"), 300, |t| (-3.0 + t / 9.0, -1.0), true);
    let two = history(
        label("with 10 % input uncertainty"),
        400,
        |t| (-4.0 + t / 9.0, -1.0),
        true,
    );
    let figures = one.render_compared(&two);
    assert_drawable(&figures);
    assert!(figures[1].svg.contains(">with 10 % input uncertainty<"));
    let stranger = History::new(FigureMeta::default());
    assert_drawable(&one.render_compared(&stranger));
}

#[test]
fn a_refutation_after_the_last_sample_is_inside_the_figure() {
    let mut run = history(meta(), 100, |t| (t, t + 1.0), true);
    run.refute_at(1.5);
    let figures = run.render_all();
    assert!(
        figures
            .iter()
            .all(|figure| figure.svg.contains(">proved inconsistent<"))
    );
    assert_drawable(&figures);
}

#[test]
fn wrong_rows_are_refused_and_leave_no_trace() {
    let mut run = history(meta(), 10, |t| (t, t + 1.0), true);
    let before = run.render_all();
    let row = SampleRow {
        t: 7.0,
        ..SampleRow::default()
    };
    let error = run.push(&row).expect_err("no outputs");
    assert_eq!(
        error,
        ReportError::Shape {
            what: "outputs",
            expected: 1,
            found: 0
        }
    );
    let b = (0.0, 1.0);
    let mut full = SampleRow {
        outputs: &[b],
        measured: &[None],
        states: &[b, b],
        params: &[b],
        modes: &[true, false],
        ..SampleRow::default()
    };
    for t in [f64::NAN, f64::INFINITY, 0.09, -1.0] {
        full.t = t;
        run.push(&full).expect_err("a time that does not increase");
    }
    assert_eq!(before, run.render_all());
    full.t = 0.1;
    run.push(&full).expect("the next time");
}

#[test]
fn the_memory_of_a_picture_does_not_grow_with_the_record() {
    let size = |count| {
        let bounds = |t: f64| ((900.0 * t).sin() - 0.1, (900.0 * t).sin() + 0.1);
        let few = FigureMeta {
            columns: 500,
            ..meta()
        };
        history(few, count, bounds, true)
            .render_all()
            .iter()
            .map(|f| f.svg.len())
            .sum::<usize>()
    };
    assert!(size(100_000) < 2 * size(2_000));
}

#[test]
fn text_is_drawn_without_any_font_of_the_machine() {
    let svg = |text: &str| {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"40\" height=\"20\" \
             font-family=\"Arial, sans-serif\"><text x=\"2\" y=\"15\">{text}</text></svg>"
        )
    };
    let (empty, minus, name) = (
        png(&svg("")),
        png(&svg("\u{2212}")),
        png(&svg("\u{3c6} [rad]")),
    );
    assert_ne!(empty, minus);
    assert_ne!(minus, name);
    assert!(matches!(
        png("no picture"),
        Err(ReportError::NotDrawable { .. })
    ));
}

/// Puts the pictures into the folder `VERIBOUND_FIGURES`, if there is such a variable: for looking at them.
fn keep(figures: &[Figure], which: &str) {
    if let Some(place) = std::env::var_os("VERIBOUND_FIGURES") {
        for figure in figures {
            let path = std::path::Path::new(&place).join(format!("{}-{which}.png", figure.name));
            std::fs::write(path, png(&figure.svg).expect("a picture")).expect("a file");
        }
    }
}

/// An enclosure of two states and their sum, with two trajectories, of so many times.
fn tube(count: u32) -> Tube {
    let meta = FigureMeta {
        outputs: vec![Quantity::new("sum", "m")],
        states: vec![Quantity::new("x", "m"), Quantity::new("v", "m/s")],
        modes: vec!["slip".to_owned(), "stick".to_owned()],
        ..FigureMeta::default()
    };
    let mut tube = Tube::new(meta, Some((0, 1)), 2);
    for k in 0..count {
        let t = f64::from(k) * 0.05;
        let (x, v, width) = (t.sin(), t.cos(), 0.02 + 0.01 * t);
        let around = |x: f64, width: f64| (x - width, x + width);
        let states = [around(x, width), around(v, width)];
        let since = [around(x, width + 0.05), around(v, width + 0.05)];
        let path = |share: f64| {
            [x, v, x + v]
                .map(|x| around(x + share * width, 0.0))
                .to_vec()
        };
        // The second one gets lost.
        let second = if k < count / 2 { path(0.5) } else { Vec::new() };
        tube.push(&TubeRow {
            t,
            states: &states,
            outputs: &[around(x + v, 2.0 * width)],
            states_since: &since,
            outputs_since: &[around(x + v, 2.0 * width + 0.1)],
            modes: &[k % 40 < 30, k % 40 > 20],
            trajectories: &[path(-0.5), second],
        })
        .expect("a row of the right shape");
    }
    tube.past_use(1, 2.0);
    tube
}

#[test]
fn an_enclosure_is_drawn_in_four_figures() {
    for count in [1, 40, 400, 9000] {
        let figures = tube(count).render_all();
        let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
        assert_eq!(names, ["outputs", "states", "modes", "plane"]);
        assert_drawable(&figures);
        assert_eq!(figures, tube(count).render_all());
        keep(&figures, &count.to_string());
    }
}

#[test]
fn rows_of_another_shape_are_refused() {
    let mut tube = tube(3);
    let states = [(0.0, 1.0); 2];
    let row = TubeRow {
        t: 1.0,
        states: &states,
        outputs: &states[..1],
        states_since: &states,
        outputs_since: &states[..1],
        modes: &[true, true],
        trajectories: &[Vec::new(), Vec::new()],
    };
    let wrong = |row: TubeRow<'_>, tube: &mut Tube| {
        let told = tube.push(&row).expect_err("a wrong row");
        assert!(matches!(told, ReportError::Shape { .. }), "{told}");
    };
    wrong(
        TubeRow {
            states_since: &[],
            ..row
        },
        &mut tube,
    );
    wrong(
        TubeRow {
            trajectories: &[],
            ..row
        },
        &mut tube,
    );
    wrong(TubeRow { modes: &[], ..row }, &mut tube);
    tube.push(&row).expect("a row of the right shape");
}

/// The tiles of a bisection of the unit cube, or what is left of it, around a ring.
fn tiles(params: usize, depth: u32) -> Vec<PavingTile> {
    let mut tiles = Vec::new();
    let mut waiting = vec![(vec![(0.0, 1.0); params], 0)];
    while let Some((cube, level)) = waiting.pop() {
        // Of the distance from the middle, least and most.
        let far = |pick: fn(f64, f64) -> f64, inner: bool| {
            let squares = cube.iter().map(|(lo, hi): &(f64, f64)| {
                let (a, b) = ((lo - 0.5).abs(), (hi - 0.5).abs());
                let holds = inner && *lo <= 0.5 && 0.5 <= *hi;
                if holds { 0.0 } else { pick(a, b).powi(2) }
            });
            squares.sum::<f64>().sqrt()
        };
        let (least, most) = (far(f64::min, true), far(f64::max, false));
        let status = if most < 0.3 && least > 0.15 {
            TileStatus::Inside
        } else if least > 0.3 || most < 0.15 {
            TileStatus::Outside
        } else if level < depth {
            let at = (level as usize) % params;
            let (lo, hi) = cube[at];
            let middle = lo / 2.0 + hi / 2.0;
            for half in [(lo, middle), (middle, hi)] {
                let mut part = cube.clone();
                part[at] = half;
                waiting.push((part, level + 1));
            }
            continue;
        } else {
            TileStatus::Undecided
        };
        tiles.push(PavingTile {
            params: cube,
            status,
        });
    }
    tiles
}

fn proved(name: &str, outer: (f64, f64), inner: Option<(f64, f64)>) -> ProvedParameter {
    ProvedParameter {
        quantity: Quantity::new(name, "1/s"),
        prior: (0.0, 1.0),
        outer: Some(outer),
        inner,
        tightness: inner.map_or(f64::INFINITY, |inner| {
            (outer.1 - outer.0) / (inner.1 - inner.0)
        }),
    }
}

#[test]
fn an_identification_is_drawn_with_all_pairs() {
    let wide = proved("a", (0.19, 0.81), Some((0.21, 0.79)));
    let thin = proved("b", (0.489, 0.512), Some((0.492, 0.511)));
    let point = proved("c", (0.3, 0.3001), Some((0.300_05, 0.300_05)));
    let alone = proved("d", (0.2, 0.4), None);
    let two = Identification {
        title: "a < b".to_owned(),
        params: vec![wide.clone(), thin.clone()],
        tiles: tiles(2, 11),
    };
    let names = |figures: &[Figure]| figures.iter().map(|f| f.name.clone()).collect::<Vec<_>>();
    let figures = two.render_all();
    assert_eq!(names(&figures), ["bounds", "paving_a_b"]);
    assert_drawable(&figures);
    assert_eq!(figures, two.render_all());
    keep(&figures, "two");
    let three = Identification {
        params: vec![wide.clone(), thin, point],
        tiles: tiles(3, 12),
        ..two.clone()
    };
    let figures = three.render_all();
    let pairs = ["bounds", "paving_a_b", "paving_a_c", "paving_b_c"];
    assert_eq!(names(&figures), pairs);
    assert_drawable(&figures);
    keep(&figures, "three");
    // No paving, a parameter that is known, nothing reached, nothing left.
    let known = ProvedParameter {
        prior: (0.5, 0.5),
        ..proved("known", (0.5, 0.5), Some((0.5, 0.5)))
    };
    let gone = ProvedParameter {
        outer: None,
        ..proved("gone", (0.0, 1.0), None)
    };
    let odd = Identification {
        params: vec![known, alone, gone],
        ..Identification::default()
    };
    let figures = odd.render_all();
    assert_eq!(names(&figures), ["bounds"]);
    assert_drawable(&figures);
    keep(&figures, "odd");
    // Two pairs with one name between them.
    let named = |name: &str| proved(name, (0.2, 0.8), None);
    let same = Identification {
        params: ["a", "b_c", "a_b", "c"].map(named).to_vec(),
        tiles: vec![PavingTile {
            params: vec![(f64::NEG_INFINITY, f64::INFINITY); 4],
            status: TileStatus::Undecided,
        }],
        ..Identification::default()
    };
    let figures = same.render_all();
    assert_eq!(names(&figures)[1], "paving_a_b_c");
    assert_eq!(names(&figures)[6], "paving_a_b_c_");
    assert_sound(&figures);
}
