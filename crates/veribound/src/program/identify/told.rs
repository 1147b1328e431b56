//! What the user is told of an identification.

use super::super::numbers::{counted, show_inside, show_prior, show_reached, show_times};
use super::super::table::{Part, push_parts};
use super::page::limit_in_words;
use super::verdict::{in_words, refuted_by};
use super::{Data, Findings};
use std::fmt::Write as _;
use std::path::Path;
use veribound_data::{
    IdentifiedParameter, IdentifiedReset, IdentifiedStart, IdentifiedState, IdentifiedSummary,
    IdentifiedWork, LeastErrors, Paving, RefutedTogether,
};
use veribound_estimate::identify::{Bounds, Conclusion, LeastError, Limit, Status, Tile};
use veribound_interval::Interval;
use veribound_interval::text::{lower, upper};
use veribound_model::Model;

/// The content of `summary.json`.
pub fn summary(
    model: &Model,
    data: &Data,
    found: &Findings,
    assumptions: Vec<String>,
) -> IdentifiedSummary {
    let (verdict, reason) = in_words(found);
    let identified = &found.identified;
    let refutation = match &identified.conclusion {
        Conclusion::Inconsistent(refuted) => Some(RefutedTogether::new(
            data.name(refuted.record),
            (
                refuted.samples.clone(),
                data.lines(refuted.record, &refuted.samples),
            ),
            (&refuted.time, refuted.line),
        )),
        _ => None,
    };
    let params = found.params(model);
    let parameters = model.params.iter().zip(&params).enumerate();
    let parameters = parameters.map(|(at, (param, bounds))| {
        let limit = identified.limits.get(at).map(|limit| match limit {
            Limit::Record => "record",
            Limit::Budget => "sets",
            Limit::Memory => "memory",
            Limit::Enclosure => "enclosure",
            Limit::Inputs => "inputs",
        });
        let entry = IdentifiedParameter::new(
            param,
            (bounds.outer, bounds.inner),
            bounds.tightness(),
            limit,
        );
        (param.name.clone(), entry)
    });
    let starts = (0..data.records.len()).map(|record| {
        let bounds = found.start(model, record);
        let states = model.states.iter().zip(&bounds).map(|(state, bounds)| {
            let both = (bounds.outer, bounds.inner);
            let entry = IdentifiedState::new(state, both, bounds.tightness());
            (state.name.clone(), entry)
        });
        IdentifiedStart {
            record: data.name(record),
            states: states.collect(),
        }
    });
    let [inside, undecided] = shares(model, found);
    let volume = identified.volume.unwrap_or(Interval::ENTIRE);
    IdentifiedSummary {
        verdict,
        reason,
        refutation,
        samples: data.count(),
        parameters: parameters.collect(),
        starts: starts.collect(),
        resets: resets(model, data, found),
        least_error: found
            .least
            .as_ref()
            .map(|least| LeastErrors::new(least.factor, &model.params, least.point.as_deref())),
        least_disturbance: found
            .least_disturbance
            .as_ref()
            .map(|least| LeastErrors::new(least.factor, &model.params, least.point.as_deref())),
        paving: (!identified.tiles.is_empty())
            .then(|| Paving::new(identified.tiles.len(), [inside, undecided], volume)),
        points: identified.points.len(),
        work: IdentifiedWork {
            wall_s: found.seconds,
            sets: identified.sets,
            passes: identified.passes,
        },
        interrupted: identified.interrupted,
        assumptions,
        missing: missing(data),
    }
}

/// Values of parameters after resets, for `summary.json`.
fn resets(model: &Model, data: &Data, found: &Findings) -> Vec<IdentifiedReset> {
    let records = found.identified.resets.iter().enumerate();
    let all = records.flat_map(|(record, list)| list.iter().map(move |reset| (record, reset)));
    all.filter_map(|(record, reset)| {
        let param = model.params.get(reset.param)?;
        let (bounds, times) = (&reset.bounds, (&reset.from, &reset.until));
        let both = (bounds.outer, bounds.inner);
        let name = data.name(record);
        Some(IdentifiedReset::new(
            name,
            param,
            times,
            both,
            bounds.tightness(),
        ))
    })
    .collect()
}

/// Missing values of all records together, in the order in which records tell of them.
fn missing(data: &Data) -> Vec<(String, usize)> {
    let mut all: Vec<(String, usize)> = Vec::new();
    for (name, count) in data.records.iter().flat_map(|record| record.missing()) {
        match all.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += count,
            None => all.push((name.clone(), *count)),
        }
    }
    all
}

/// The volumes of the tiles inside and of those undecided, as shares of the outer box; parameters that are known
/// exactly do not count, nor does what of a tile is proved to lie outside of that box.
fn shares(model: &Model, found: &Findings) -> [Interval; 2] {
    let outer: Vec<Interval> = found.params(model).iter().map(|both| both.outer).collect();
    let width = |x: Interval| Interval::point(x.hi()) - Interval::point(x.lo());
    let is_bounded = |list: &[Interval]| list.iter().all(|x| !x.is_empty() && x.is_bounded());
    let share = |tile: &Tile| {
        if !is_bounded(&tile.params) || !is_bounded(&outer) {
            return Interval::ENTIRE;
        }
        if let Some(turned) = &tile.turned {
            let Some(frame) = found.identified.frames.get(turned.frame) else {
                return Interval::ENTIRE;
            };
            let wide = outer.iter().filter(|whole| whole.lo() < whole.hi());
            return wide.fold(frame.volume(&turned.unknowns), |share, whole| {
                share / width(*whole)
            });
        }
        let parts = { tile.params.iter().zip(&outer) }
            .map(|(part, whole)| (part.intersect(*whole), *whole));
        let parts: Vec<(Interval, Interval)> = parts.collect();
        if parts.iter().any(|(part, _)| part.is_empty()) {
            return Interval::ZERO;
        }
        let wide = parts.iter().filter(|(_, whole)| whole.lo() < whole.hi());
        wide.fold(Interval::ONE, |share, (part, whole)| {
            share * (width(*part) / width(*whole))
        })
    };
    [Status::Inside, Status::Undecided].map(|status| {
        let tiles = found.identified.tiles.iter();
        let sum = tiles
            .filter(|tile| tile.status == status)
            .fold(Interval::ZERO, |sum, tile| sum + share(tile));
        // No part is more than all of it, whatever rounding and turned tiles that reach out add.
        match Interval::new(0.0, 1.0).map(|whole| sum.intersect(whole)) {
            Some(part) if sum.is_bounded() && !part.is_empty() => part,
            _ => sum,
        }
    })
}

/// Verdict, bounds of parameters and start states from both sides, and what limits them.
pub fn bounds(model: &Model, data: &Data, found: &Findings) -> String {
    let mut out = String::new();
    let identified = &found.identified;
    let verdict = match (&identified.conclusion, identified.interrupted) {
        (Conclusion::Inconsistent(_), _) => "inconsistent (proved)",
        (Conclusion::Consistent, false) => "consistent",
        (Conclusion::Consistent, true) => "consistent, interrupted",
        (Conclusion::Undecided, false) => "undecided",
        (Conclusion::Undecided, true) => "interrupted",
    };
    let records = match data.records.len() {
        1 => String::new(),
        count => format!(" of {count} records"),
    };
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "  {verdict}   {}{records} in {:.2} s   {}, {}",
        counted(data.count(), "sample", "samples"),
        found.seconds,
        counted(identified.sets, "set", "sets"),
        counted(identified.passes, "pass", "passes"),
    );
    match &identified.conclusion {
        Conclusion::Inconsistent(refuted) => {
            let _ = writeln!(out, "  {}", refuted_by(data, refuted));
        }
        Conclusion::Undecided => {
            let _ = writeln!(out, "  {}", in_words(found).1.unwrap_or_default());
        }
        Conclusion::Consistent => {}
    }
    if !matches!(identified.conclusion, Conclusion::Inconsistent(_)) {
        push_bounds(&mut out, model, data, found);
    }
    if let Some(least) = &found.least {
        let _ = writeln!(out, "  {}", least_in_words(MEASURED, least));
    }
    if let Some(least) = &found.least_disturbance {
        let _ = writeln!(out, "  {}", least_in_words(DISTURBED, least));
    }
    // Where nothing agrees there is no outer box.
    let is_refuted = matches!(identified.conclusion, Conclusion::Inconsistent(_));
    if !identified.tiles.is_empty() && !is_refuted {
        let [inside, undecided] = shares(model, found);
        let _ = writeln!(
            out,
            "  paving: {}   inside at least {} %, undecided at most {} % of the outer box",
            counted(identified.tiles.len(), "tile", "tiles"),
            lower(100.0 * inside.lo().max(0.0), 3),
            upper(100.0 * undecided.hi(), 3),
        );
        if let Some(volume) = identified.volume.filter(|_| model.params.len() > 1) {
            let _ = writeln!(
                out,
                "  volume of what agrees: at least {}, at most {}",
                lower(volume.lo().max(0.0), 4),
                upper(volume.hi(), 4),
            );
        }
    }
    out
}

/// The same, and where the results are.
pub fn table(
    model: &Model,
    data: &Data,
    found: &Findings,
    (folder, pictures): (&Path, String),
) -> String {
    let mut out = bounds(model, data, found);
    let paving = match (
        found.identified.tiles.is_empty(),
        found.identified.frames.is_empty(),
    ) {
        (true, _) => "",
        (false, true) => "paving.csv, ",
        (false, false) => "paving.csv, turned.csv, frames.csv, ",
    };
    let _ = writeln!(
        out,
        "  results in {}: summary.json, points.csv, {paving}run.toml{pictures}",
        folder.display()
    );
    out
}

/// What the least errors are of.
pub const MEASURED: &str = "measurement errors";
pub const DISTURBED: &str = "errors of inputs and disturbances";

/// How large these errors must be, in one sentence.
pub fn least_in_words(errors: &str, least: &LeastError) -> String {
    let (below, above) = (least.factor.lo(), least.factor.hi());
    let below = match below {
        none if none <= 0.0 => None,
        below => Some(lower(below, 4)),
    };
    let above = above.is_finite().then(|| upper(above, 4));
    match (below, above) {
        (Some(below), Some(above)) => {
            format!(
                "{errors} must be at least {below} times as large as declared; {above} times are enough"
            )
        }
        (Some(below), None) => {
            format!(
                "{errors} must be at least {below} times as large as declared; how much is enough is not known"
            )
        }
        (None, Some(above)) => format!("{errors} {above} times as large as declared are enough"),
        (None, None) => format!("how large {errors} must be could not be found out"),
    }
}

fn push_bounds(out: &mut String, model: &Model, data: &Data, found: &Findings) {
    let row = |name: &str, prior: Interval, both: &Bounds, unit: &str, limit: &str| {
        [
            name.to_owned(),
            show_prior(prior),
            show_inside(both.outer, prior),
            show_reached(both.inner, both.tightness()),
            show_times(both.tightness()),
            unit.to_owned(),
            limit.to_owned(),
        ]
    };
    let params = found.params(model);
    let head = ["", "prior", "outer", "inner", "at most", "", "limited by"];
    let mut rows = vec![head.map(str::to_owned)];
    for (at, (param, both)) in model.params.iter().zip(&params).enumerate() {
        let limit = found
            .identified
            .limits
            .get(at)
            .map_or("", |limit| limit_in_words(*limit));
        rows.push(row(&param.name, param.bounds, both, &param.unit, limit));
    }
    let starts = (0..data.records.len()).map(|record| {
        let bounds = found.start(model, record);
        let states = model.states.iter().zip(&bounds);
        let rows = states.map(|(state, both)| row(&state.name, state.init, both, &state.unit, ""));
        let above = format!("at the start of {}", data.name(record));
        (above, rows.collect::<Vec<_>>())
    });
    let resets = found.identified.resets.iter().enumerate();
    let resets = resets.filter(|(_, list)| !list.is_empty());
    let resets = resets.map(|(record, list)| {
        let rows = list.iter().filter_map(|reset| {
            let param = model.params.get(reset.param)?;
            let name = format!("{} from {} s to {} s", param.name, reset.from, reset.until);
            Some(row(&name, param.bounds, &reset.bounds, &param.unit, ""))
        });
        let above = format!("after resets in {}", data.name(record));
        (above, rows.collect::<Vec<_>>())
    });
    let starts: Vec<_> = resets.chain(starts).collect();
    let mut parts: Vec<Part<'_, 7>> = vec![(None, &rows)];
    parts.extend(
        starts
            .iter()
            .map(|(above, rows)| (Some(above.as_str()), rows.as_slice())),
    );
    push_parts(out, &parts);
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::super::ending::Ending;
    use super::*;
    use std::fs;
    use veribound_data::{Record, RecordOptions};
    use veribound_estimate::identify::{Identified, Reason, Refuted};
    use veribound_interval::Decimal;

    /// A cart with two parameters, `x' = k u`.
    pub fn model() -> Model {
        let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = [-1, 1]\ninputs = [\"u [V]\"]\n\
            params.k = { unit = \"m/(V*s)\", bounds = [0, 4] }\nparams.c = { unit = \"m\", bounds = [-0.5, 0.3] }\n\
            der.x = \"k * u\"\noutputs.pos = \"x + c +- 0.1 [m]\"\n";
        Model::from_text("m.toml", text).unwrap()
    }

    /// Records of so many samples of a cart with `k = 2`, one every 0.1 s.
    pub fn data(place: &Path, counts: &[usize]) -> Data {
        let records = counts.iter().enumerate().map(|(number, count)| {
            let path = place.join(format!("r{number}.csv"));
            let row = |k: usize| format!("0.{k},1,0.{}\n", 2 * k);
            let rows: String = (0..*count).map(row).collect();
            fs::write(&path, format!("t,u,pos\n{rows}")).unwrap();
            Record::open(&path, &model(), RecordOptions::default()).unwrap()
        });
        let records: Vec<Record> = records.collect();
        Data {
            samples: { records.iter() }
                .map(|r| r.all_samples().unwrap())
                .collect(),
            records,
        }
    }

    fn interval(lo: f64, hi: f64) -> Interval {
        Interval::new(lo, hi).unwrap()
    }

    /// What an identification may have found.
    pub fn found() -> Findings {
        let third = -1.0 / 3.0;
        let priors: Vec<Interval> = model().params.iter().map(|param| param.bounds).collect();
        let (k, c) = (priors[0], priors[1]);
        let tile = |k: Interval, c: Interval, status: Status, reason: Reason| Tile {
            params: vec![k, c],
            turned: None,
            status,
            reason,
        };
        let lines = Reason::Samples {
            record: 1,
            samples: vec![0, 1],
        };
        let one = Reason::Sample {
            record: 0,
            sample: 2,
        };
        let low = interval(0.0, 1.5);
        Findings {
            identified: Identified {
                conclusion: Conclusion::Consistent,
                resets: Vec::new(),
                params: vec![
                    Bounds {
                        outer: interval(1.652_81, 2.537_49),
                        inner: Some(interval(1.702_81, 2.502_49)),
                    },
                    Bounds {
                        outer: interval(third, c.hi()),
                        inner: Some(interval(third / 2.0, third / 2.0)),
                    },
                ],
                starts: vec![
                    vec![Bounds {
                        outer: interval(-0.1, 0.2),
                        inner: Some(interval(0.0, 0.125)),
                    }],
                    vec![Bounds {
                        outer: interval(-0.3, 0.2),
                        inner: None,
                    }],
                ],
                points: vec![vec![interval(1.75, 1.75), interval(third, third)]],
                tiles: vec![
                    tile(low, c, Status::Outside, one),
                    tile(
                        interval(1.5, 4.0),
                        interval(c.lo(), third),
                        Status::Outside,
                        lines,
                    ),
                    tile(
                        interval(1.5, 2.0),
                        interval(third, c.hi()),
                        Status::Inside,
                        Reason::Met,
                    ),
                    tile(interval(2.0, k.hi()), c, Status::Undecided, Reason::Budget),
                    tile(low, c, Status::Undecided, Reason::Budget),
                ],
                sets: 12,
                passes: 30,
                interrupted: false,
                limits: vec![Limit::Record, Limit::Budget],
                frames: Vec::new(),
                volume: Some(interval(0.25, 2.5)),
            },
            least: None,
            least_disturbance: None,
            seconds: 1.234,
            ending: Ending::Done,
        }
    }

    fn shown(data: &Data, found: &Findings, place: &Path) -> String {
        let text = table(
            &model(),
            data,
            found,
            (Path::new("out"), ", figures in fig/".to_owned()),
        );
        text.replace(&format!("{}/", place.display()), "")
    }

    #[test]
    fn the_table_tells_both_sides() {
        let place = tempfile::tempdir().unwrap();
        let data = data(place.path(), &[5, 3]);
        let mut found = found();
        found.identified.tiles.clear();
        let wanted = "  consistent   8 samples of 2 records in 1.23 s   12 sets, 30 passes
      prior         outer             inner             at most             limited by
  k   [0, 4]        [1.65, 2.54]      [1.71, 2.5]       1.107 x   m/(V*s)   the record
  c   [-0.5, 0.3]   [-0.334, 0.3]     about -0.166667             m         the number of sets
  at the start of r0.csv
  x   [-1, 1]       [-0.101, 0.201]   [0, 0.125]        2.401 x   m
  at the start of r1.csv
  x   [-1, 1]       [-0.3, 0.201]                                 m
  results in out: summary.json, points.csv, run.toml, figures in fig/
";
        assert_eq!(shown(&data, &found, place.path()), wanted);
    }

    #[test]
    fn the_table_tells_why_there_are_no_bounds() {
        let place = tempfile::tempdir().unwrap();
        let data = data(place.path(), &[5]);
        let mut found = found();
        found.identified.conclusion = Conclusion::Inconsistent(Refuted {
            record: 0,
            samples: vec![1, 3],
            time: Decimal::parse("0.3").unwrap(),
            line: 5,
        });
        found.identified.tiles.clear();
        assert_eq!(
            shown(&data, &found, place.path()),
            "  inconsistent (proved)   5 samples in 1.23 s   12 sets, 30 passes\n  nothing agrees with r0.csv up \
             to t = 0.3 s (line 5); lines 3 and 5 refute together\n  results in out: summary.json, points.csv, \
             run.toml, figures in fig/\n"
        );
        // Nothing was found at all.
        found.identified = Identified {
            conclusion: Conclusion::Undecided,
            params: Vec::new(),
            starts: Vec::new(),
            points: Vec::new(),
            limits: Vec::new(),
            sets: 1,
            ..found.identified
        };
        let told = shown(&data, &found, place.path());
        let reason = "  1 set was looked at, and no point is proved to agree with the record\n";
        assert!(told.contains(reason), "{told}");
        assert!(told.contains("  k   [0, 4]        [0, 4]"), "{told}");
    }

    #[test]
    fn a_paving_is_told_in_shares_of_the_outer_box() {
        let place = tempfile::tempdir().unwrap();
        let data = data(place.path(), &[5]);
        let mut found = found();
        let tile = |lo: f64, hi: f64, status: Status| Tile {
            params: vec![interval(lo, hi), interval(-0.5, 0.25)],
            turned: None,
            status,
            reason: Reason::Met,
        };
        found.identified.params = vec![
            Bounds {
                outer: interval(1.0, 3.0),
                inner: None,
            },
            Bounds {
                outer: interval(-0.5, 0.25),
                inner: None,
            },
        ];
        found.identified.tiles = vec![
            tile(0.0, 1.0, Status::Outside),
            tile(1.0, 2.75, Status::Inside),
            tile(2.75, 3.0, Status::Undecided),
            tile(3.0, 4.0, Status::Outside),
        ];
        let told = shown(&data, &found, place.path());
        let line = "  paving: 4 tiles   inside at least 87.4 %, undecided at most 12.5 % of the outer box\n";
        assert!(
            told.contains(line) || told.contains(&line.replace("87.4", "87.5")),
            "{told}"
        );
        assert!(told.contains("points.csv, paving.csv, run.toml"), "{told}");
        let line = "  volume of what agrees: at least 0.25, at most 2.5\n";
        assert!(told.contains(line), "{told}");
        // What lies outside of the outer box is proved not to agree.
        found.identified.tiles[2] = tile(2.75, 4.0, Status::Undecided);
        assert!(shares(&model(), &found)[1].hi() < 0.125_001);
        // No bounds, no shares.
        found.identified.params[0].outer = Interval::ENTIRE;
        let [inside, undecided] = shares(&model(), &found);
        assert_eq!((inside, undecided), (Interval::ENTIRE, Interval::ENTIRE));
    }

    #[test]
    fn the_summary_tells_all_of_it() {
        let place = tempfile::tempdir().unwrap();
        let data = data(place.path(), &[5, 3]);
        let json = summary(&model(), &data, &found(), vec!["x".to_owned()]);
        let json = json.to_json().unwrap();
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert_eq!(json["verdict"], "consistent");
        assert_eq!((&json["samples"], &json["points"]), (&8.into(), &1.into()));
        let k = &json["parameters"]["k"];
        assert_eq!(k["limited_by"], "record");
        assert_eq!(k["inner"]["lo"], 1.702_81);
        assert!(k["tightness"].as_f64().unwrap() >= 0.884_68 / 0.799_68);
        let c = &json["parameters"]["c"];
        assert_eq!(c["tightness"], serde_json::Value::Null);
        assert_eq!(c["hi"], 0.3);
        assert_eq!(json["starts"][1]["record"], data.name(1));
        assert_eq!(
            json["starts"][1]["states"]["x"]["inner"],
            serde_json::Value::Null
        );
        assert_eq!(json["paving"]["tiles"], 5);
        assert_eq!(json["paving"]["volume"]["hi"], 2.5);
        assert_eq!(json["work"]["sets"], 12);
    }
}
