//! What a run wrote can be read back to start another one.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use std::path::Path;
use support::{decimal, interval, rig};
use veribound_data::{
    Cell, Column, ParameterSummary, ResultFolder, Start, StateSummary, Summary, TableWriter,
    Verdict, Work,
};
use veribound_interval::Interval;

fn summary(verdict: Verdict, bounds: &[Interval]) -> Summary {
    let model = rig();
    let params = model.params.iter().zip(bounds);
    let states = model.states.iter();
    Summary {
        verdict,
        reason: None,
        refutation: None,
        samples: 3,
        parameters: params
            .map(|(param, bounds)| (param.name.clone(), ParameterSummary::new(param, *bounds)))
            .collect(),
        states: states
            .map(|state| (state.name.clone(), StateSummary::new(state, Interval::ONE)))
            .collect(),
        work: Work::default(),
        interrupted: false,
        assumptions: Vec::new(),
        missing: Vec::new(),
    }
}

fn write(folder: &ResultFolder, summary: &Summary) {
    let text = summary.to_json().unwrap();
    let file = folder.write("summary.json", text.as_bytes()).unwrap();
    file.put_in_place().unwrap();
}

fn refusal(folder: &Path) -> (&'static str, String) {
    let error = Start::read(folder, &rig()).unwrap_err();
    (
        error.code,
        error.message.replace(&folder.display().to_string(), "DIR"),
    )
}

#[test]
fn bounds_and_boxes_come_back_enclosed() {
    let place = tempfile::tempdir().unwrap();
    let folder = ResultFolder::create(place.path()).unwrap();
    let third = Interval::ONE / Interval::point(3.0);
    let bounds = [
        interval("-2.5", "-1") + third,
        interval("100", "150") + third,
    ];
    write(&folder, &summary(Verdict::Consistent, &bounds));
    let start = Start::read(place.path(), &rig()).unwrap();
    assert_eq!(start.boxes, Vec::<Vec<Interval>>::new());
    for (read, proved) in start.params.iter().zip(bounds) {
        assert!(
            proved.is_subset_of(*read),
            "{read:?} does not contain {proved:?}"
        );
        assert!(read.width() < proved.width() + 1e-8);
    }
    let model = rig();
    let mut table = TableWriter::create(&folder, "boxes.csv", Column::of_boxes(&model)).unwrap();
    let mut row = |time: &str, number: usize, alpha: Interval, beta: Interval| {
        let state = Cell::Bounds(Interval::ENTIRE);
        let cells = [
            Cell::Count(number),
            state,
            Cell::Bounds(alpha),
            Cell::Bounds(beta),
            Cell::Text("a,b"),
        ];
        table.row(&decimal(time), &cells).unwrap();
    };
    row("0", 0, Interval::ZERO, Interval::ZERO);
    row("0.5", 0, bounds[0], Interval::ENTIRE);
    row("0.5", 1, third, bounds[1]);
    table.finish().unwrap().put_in_place().unwrap();
    let start = Start::read(place.path(), &model).unwrap();
    for file in &start.files {
        assert_eq!(
            file.sha256,
            veribound_data::sha256_of_file(&file.path).unwrap()
        );
    }
    assert_eq!(start.files.len(), 2);
    assert_eq!(
        start.boxes.len(),
        2,
        "only the boxes of the last sample count"
    );
    assert!(bounds[0].is_subset_of(start.boxes[0][0]));
    assert_eq!(start.boxes[0][1], Interval::ENTIRE);
    assert!(third.is_subset_of(start.boxes[1][0]) && bounds[1].is_subset_of(start.boxes[1][1]));
}

#[test]
fn what_is_no_start_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let folder = ResultFolder::create(place.path()).unwrap();
    let file = place.path().join("summary.json");
    let missing = "`DIR` holds no complete results: it has no summary.json".to_owned();
    assert_eq!(refusal(place.path()), ("E0504", missing));
    assert_eq!(refusal(&place.path().join("nowhere")).0, "E0401");
    std::fs::write(&file, "{\n  \"verdict\": 1\n}").unwrap();
    assert_eq!(refusal(place.path()).0, "E0504");
    std::fs::write(
        &file,
        "{\"verdict\": \"consistent\", \"parameters\": {\"alpha\": {\"lo\": 1, \"hi\": 0}}}",
    )
    .unwrap();
    assert_eq!(refusal(place.path()).0, "E0504");
    std::fs::write(
        &file,
        "{\"verdict\": \"consistent\", \"parameters\": {\"alpha\": {\"lo\": 1, \"hi\": 2}}}",
    )
    .unwrap();
    let (code, message) = refusal(place.path());
    assert_eq!(code, "E0505");
    assert!(
        message.ends_with("has no bounds of the parameter `beta`"),
        "{message}"
    );
    write(
        &folder,
        &summary(Verdict::Inconsistent, &[Interval::EMPTY; 2]),
    );
    let (code, message) = refusal(place.path());
    assert_eq!(code, "E0505");
    assert!(
        message.ends_with("proved the model inconsistent: it left no parameters"),
        "{message}"
    );
    let bounds = [interval("-2", "-1"), interval("100", "200")];
    write(&folder, &summary(Verdict::Consistent, &bounds));
    let boxes = place.path().join("boxes.csv");
    std::fs::write(&boxes, "t,box,alpha.lo,alpha.hi\n").unwrap();
    assert_eq!(refusal(place.path()).0, "E0505");
    std::fs::write(
        &boxes,
        "t,alpha.lo,alpha.hi,beta.lo,beta.hi\n0,-1,x,100,200\n",
    )
    .unwrap();
    assert_eq!(
        refusal(place.path()),
        ("E0504", "`x` is no number".to_owned())
    );
    for cut in ["0,-1,-0.5,100\n", "0,-0.5,-1,100,200\n", "\"0,-1\n"] {
        std::fs::write(
            &boxes,
            format!("t,alpha.lo,alpha.hi,beta.lo,beta.hi\n{cut}"),
        )
        .unwrap();
        assert_eq!(refusal(place.path()).0, "E0504", "{cut}");
    }
}
