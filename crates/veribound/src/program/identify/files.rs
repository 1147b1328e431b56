//! The files of an identification.

use super::super::arguments::Format;
use super::super::files::write_figures;
use super::{Data, Findings};
use veribound_data::{Cell, Column, CompleteFile, ResultFolder, RunInfo, TableWriter};
use veribound_estimate::identify::{Reason, Status};
use veribound_interval::Interval;
use veribound_interval::text::exact;
use veribound_model::Model;
use veribound_model::diagnostic::Diagnostic;
use veribound_report::{
    Course, Identification, Page, PavingTile, Plots, ProvedParameter, Quantity, TileStatus,
};

/// Writes all files of the run, and puts them in place together.
pub fn write(
    (folder, formats): (&ResultFolder, &[Format]),
    (model, data, found): (&Model, &Data, &Findings),
    (info, json, page, courses): (&RunInfo, &str, Option<Page>, &[Course]),
) -> Result<(), Diagnostic> {
    let mut files = vec![points(folder, model, found)?, info.write(folder)?];
    if !found.identified.tiles.is_empty() {
        files.push(paving(folder, (model, data, found))?);
    }
    if !found.identified.frames.is_empty() {
        files.push(turned(folder, (data, found))?);
        files.push(frames(folder, (model, found))?);
    }
    let figures = figures(model, found);
    files.extend(write_figures(folder, formats, || figures.render_all())?);
    if let Some(mut page) = page {
        page.plots = Plots::of_identification(&figures, courses);
        files.push(folder.write("report.html", page.render().as_bytes())?);
    }
    files.push(folder.write("summary.json", json.as_bytes())?);
    folder.publish(files)
}

/// Points that are proved to agree with model and records: one lies inside the bounds of each row.
fn points(
    folder: &ResultFolder,
    model: &Model,
    found: &Findings,
) -> Result<CompleteFile, Diagnostic> {
    let mut table = TableWriter::timeless(folder, "points.csv", Column::of_points(model))?;
    for (number, point) in found.identified.points.iter().enumerate() {
        let mut row = vec![Cell::Count(number + 1)];
        row.extend(point.iter().map(|x| Cell::Bounds(*x)));
        table.timeless_row(&row)?;
    }
    table.finish()
}

/// The tiles that are not turned, with every digit of their ends: together they cover the prior.
fn paving(
    folder: &ResultFolder,
    (model, data, found): (&Model, &Data, &Findings),
) -> Result<CompleteFile, Diagnostic> {
    let mut table = TableWriter::timeless(folder, "paving.csv", Column::of_paving(model))?;
    let upright = found.identified.tiles.iter();
    for tile in upright.filter(|tile| tile.turned.is_none()) {
        let reason = reason(data, &tile.reason);
        let mut row: Vec<Cell> = tile.params.iter().map(|x| Cell::Exact(*x)).collect();
        row.extend([Cell::Text(name(tile.status)), Cell::Text(&reason)]);
        table.timeless_row(&row)?;
    }
    table.finish()
}

/// The turned tiles, with every digit of the ends of their coordinates.
fn turned(
    folder: &ResultFolder,
    (data, found): (&Data, &Findings),
) -> Result<CompleteFile, Diagnostic> {
    let columns = Column::of_turned(axes(found));
    let mut table = TableWriter::timeless(folder, "turned.csv", columns)?;
    for tile in &found.identified.tiles {
        let Some(turned) = &tile.turned else { continue };
        let reason = reason(data, &tile.reason);
        let mut row = vec![Cell::Count(turned.frame + 1)];
        row.extend(turned.unknowns.iter().map(|y| Cell::Exact(*y)));
        row.extend([Cell::Text(name(tile.status)), Cell::Text(&reason)]);
        table.timeless_row(&row)?;
    }
    table.finish()
}

/// The axes of turned tiles, with every digit.
fn frames(
    folder: &ResultFolder,
    (model, found): (&Model, &Findings),
) -> Result<CompleteFile, Diagnostic> {
    let columns = Column::of_frames(model, axes(found));
    let mut table = TableWriter::timeless(folder, "frames.csv", columns)?;
    for (number, frame) in found.identified.frames.iter().enumerate() {
        let rows = frame.centre.iter().zip(&frame.axes);
        let digits = rows.flat_map(|(centre, row)| std::iter::once(centre).chain(row));
        let digits: Vec<String> = digits.map(|x| exact(*x)).collect();
        let mut row = vec![Cell::Count(number + 1)];
        row.extend(digits.iter().map(|text| Cell::Text(text)));
        table.timeless_row(&row)?;
    }
    table.finish()
}

/// How many axes frames have.
fn axes(found: &Findings) -> usize {
    let first = found.identified.frames.first();
    first
        .and_then(|frame| frame.axes.first())
        .map_or(0, Vec::len)
}

/// The name of a status in results.
pub fn name(status: Status) -> &'static str {
    match status {
        Status::Inside => "inside",
        Status::Outside => "outside",
        Status::Undecided => "undecided",
        Status::Turned => "turned",
    }
}

/// Why a tile has its status.
pub fn reason(data: &Data, reason: &Reason) -> String {
    let of = |record: usize| match data.records.len() {
        1 => String::new(),
        _ => format!(" of {}", data.name(record)),
    };
    let lines = |record: usize, samples: &[usize]| {
        let lines = data.lines(record, samples);
        let texts: Vec<String> = lines.iter().map(usize::to_string).collect();
        texts.join(" ")
    };
    match reason {
        Reason::Sample { record, sample } => {
            format!("line {}{}", lines(*record, &[*sample]), of(*record))
        }
        // The whole way through the record narrowed it.
        Reason::Samples { samples, .. } if samples.is_empty() => "the samples together".to_owned(),
        Reason::Samples { record, samples } if samples.len() == 1 => {
            format!("line {}{}", lines(*record, samples), of(*record))
        }
        Reason::Samples { record, samples } => {
            format!("lines {}{} together", lines(*record, samples), of(*record))
        }
        Reason::Bounds => "outside of the proved bounds".to_owned(),
        Reason::Met => "all samples are met".to_owned(),
        Reason::Budget => "not divided further".to_owned(),
        Reason::Needle { frame } => format!("divided along the axes of frame {}", frame + 1),
    }
}

/// What is drawn of tiles. Of a turned one that is inside this is a box in it, with what is around it as undecided; of others
/// the box around them.
fn drawn(found: &Findings) -> Vec<PavingTile> {
    let tile = |params: &[Interval], status: TileStatus| PavingTile {
        params: params.iter().map(|x| (x.lo(), x.hi())).collect(),
        status,
    };
    let mut all = Vec::with_capacity(found.identified.tiles.len());
    for own in &found.identified.tiles {
        match (own.status, &own.turned) {
            (Status::Turned, _) | (Status::Outside, Some(_)) => {}
            (Status::Inside, Some(turned)) => {
                all.push(tile(&own.params, TileStatus::Undecided));
                let frame = found.identified.frames.get(turned.frame);
                let inner = frame.and_then(|frame| frame.inner_box(&turned.unknowns));
                all.extend(inner.map(|inner| tile(&inner, TileStatus::Inside)));
            }
            (Status::Inside, None) => all.push(tile(&own.params, TileStatus::Inside)),
            (Status::Outside, None) => all.push(tile(&own.params, TileStatus::Outside)),
            (Status::Undecided, _) => all.push(tile(&own.params, TileStatus::Undecided)),
        }
    }
    all
}

/// What is drawn.
fn figures(model: &Model, found: &Findings) -> Identification {
    let pair = |x: Interval| (x.lo(), x.hi());
    let bounds = found.params(model);
    let params = model.params.iter().zip(bounds);
    let params = params.map(|(param, bounds)| ProvedParameter {
        quantity: Quantity::new(param.name.as_str(), param.unit.as_str()),
        prior: pair(param.bounds),
        outer: (!bounds.outer.is_empty()).then(|| pair(bounds.outer)),
        inner: bounds.inner.map(pair),
        tightness: bounds.tightness(),
    });
    Identification {
        title: model.name.clone(),
        params: params.collect(),
        tiles: drawn(found),
    }
}

#[cfg(test)]
mod tests {
    use super::super::told::tests::{data, found, model};
    use super::*;
    use std::fs;
    use veribound_data::{FileInfo, Platform, Program};

    fn info() -> RunInfo {
        RunInfo {
            program: Program {
                version: String::new(),
                command: Vec::new(),
            },
            platform: Platform::current(),
            model: FileInfo {
                path: String::new(),
                sha256: String::new(),
            },
            record: None,
            records: Vec::new(),
            profile: None,
            start: Vec::new(),
            overlay: None,
            options: toml::Table::new(),
        }
    }

    fn names(folder: &std::path::Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn every_file_is_there_and_says_why() {
        let place = tempfile::tempdir().unwrap();
        let (model, data, mut found) = (model(), data(place.path(), &[5, 3]), found());
        let out = place.path().join("out");
        let folder = ResultFolder::create(&out).unwrap();
        let formats = [Format::Svg];
        let info = info();
        let run = (&info, "{}", None, &[][..]);
        write((&folder, &formats), (&model, &data, &found), run).unwrap();
        let files = [
            "fig",
            "paving.csv",
            "points.csv",
            "run.toml",
            "summary.json",
        ];
        assert_eq!(names(&out), files);
        assert_eq!(names(&out.join("fig")), ["bounds.svg", "paving_k_c.svg"]);
        let second = data.name(1);
        let third = "-0.333333333333333314829616256247390992939472198486328125";
        assert_eq!(
            fs::read_to_string(out.join("paving.csv")).unwrap(),
            format!(
                "k.lo,k.hi,c.lo,c.hi,status,reason\n0,1.5,-0.5,0.3,outside,line 4\n\
                 1.5,4,-0.5,{third},outside,lines 2 3 of {second} together\n\
                 1.5,2,{third},0.3,inside,all samples are met\n2,4,-0.5,0.3,undecided,not divided further\n\
                 0,1.5,-0.5,0.3,undecided,not divided further\n"
            )
            .replace("line 4\n", &format!("line 4 of {}\n", data.name(0)))
        );
        assert_eq!(
            fs::read_to_string(out.join("points.csv")).unwrap(),
            "point,k.lo,k.hi,c.lo,c.hi\n1,1.75,1.75,-0.333333333334,-0.333333333333\n"
        );
        // Without a paving nothing of an earlier one is left.
        found.identified.tiles.clear();
        let run = (&info, "{}", None, &[][..]);
        write((&folder, &formats), (&model, &data, &found), run).unwrap();
        assert_eq!(
            names(&out),
            ["fig", "points.csv", "run.toml", "summary.json"]
        );
        assert_eq!(names(&out.join("fig")), ["bounds.svg"]);
    }
}
