//! One record in every accepted spelling gives the same samples; windows, missing values and
//! irregular stamps mean what they say.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use std::path::PathBuf;
use support::{decimal, interval, model, rig};
use veribound_data::{Record, RecordOptions};
use veribound_interval::{Decimal, Interval};
use veribound_model::model::{Model, Sample};

/// A record on disk as long as it lives.
struct Written {
    _folder: tempfile::TempDir,
    path: PathBuf,
}

fn write(text: &str) -> Written {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    std::fs::write(&path, text).unwrap();
    Written {
        _folder: folder,
        path,
    }
}

fn open(text: &str, model: &Model, options: RecordOptions) -> (Record, Vec<Sample>) {
    let written = write(text);
    let record = match Record::open(&written.path, model, options) {
        Ok(record) => record,
        Err(problems) => panic!("{}", problems.render(false)),
    };
    let samples: Vec<Sample> = record.samples().unwrap().map(Result::unwrap).collect();
    assert_eq!(samples.len(), record.len());
    assert_eq!(&samples[0].time, record.first());
    assert_eq!(&samples[samples.len() - 1].time, record.last());
    (record, samples)
}

fn read(text: &str) -> Vec<Sample> {
    open(text, &rig(), RecordOptions::default()).1
}

/// Everything but the line.
fn values(samples: &[Sample]) -> Vec<String> {
    samples
        .iter()
        .map(|s| format!("{} {:?} {:?} {:?}", s.time, s.inputs, s.outputs, s.signals))
        .collect()
}

#[test]
fn all_spellings_of_a_record_mean_the_same() {
    let plain = read("t,u,phi_m,still\n0.00,0.22,-0.0282,1\n0.01,-1,,0\n0.025,3,2,\n");
    assert_eq!(plain[0].time, decimal("0"));
    assert_eq!(plain[0].inputs, [decimal("0.22").to_interval()]);
    let measured = decimal("-0.0282").to_interval();
    let reach = decimal("0.1").to_interval();
    assert_eq!(
        plain[0].outputs,
        [Some((measured - reach).hull(measured + reach))]
    );
    assert_eq!(plain[0].signals, [Some(true)]);
    assert_eq!(plain[1].outputs, [None]);
    assert_eq!(plain[1].signals, [Some(false)]);
    assert_eq!(plain[2].signals, [None]);
    assert_eq!(plain.iter().map(|s| s.line).collect::<Vec<_>>(), [2, 3, 4]);
    let spellings = [
        "\u{feff}t,u,phi_m,still\r\n0.00,0.22,-0.0282,1\r\n0.01,-1,NaN,0\r\n0.025,3,2,nan\r\n",
        "# rig, run 1\n\nTime [s] , u [N*m] ,phi_m [rad],still\n\n 0,.22,-2.82e-2,true\n1e-2,-1.,nan,FALSE\n# pause\n0.0250,+3,2.0,\n,,,\n",
        "t_s;u_Nm;phi_m_rad;still\n0.00;0.22;-0.0282;1\n0.01;-1;;0\n0.025;3;2;",
        "timestamp\tu\tphi_m\tstill\n0.00\t0.22\t-0.0282\t1\n0.01\t-1\t\t0\n0.025\t3\t2\t\n",
        "\"still\",\"note\",\"phi_m\",\"u\",\"stamp\"\n1,\"a, \"\"b\"\"\",\"-0.0282\",\"0.22\",\"0.00\"\n0,,\"\",-1,0.01\n,x,2,3,0.025\n",
        "Time (s),u,phi_m,still,temperature\n0.00,0.22,-0.0282,1,warm\n0.01,-1,,0,inf\n0.025,3,2,,\n",
    ];
    for text in spellings {
        assert_eq!(values(&read(text)), values(&plain), "{text}");
    }
}

/// Stamps that look like milliseconds are taken as they are, and a hint says so.
#[test]
fn stamps_far_apart_are_remarked() {
    let record = |head: &str, step: &str| {
        let text = format!("{head},u,phi_m,still\n0,0,0,1\n{step},0,0,1\n");
        open(&text, &rig(), RecordOptions::default()).0
    };
    assert_eq!(
        record("t", "10").hint(),
        Some(
            "the samples are 10 s apart on average, since the column `t` names no unit and stamps without one \
             are seconds; if that is right, call it `t_s`; milliseconds have to be divided by 1000"
        )
    );
    assert_eq!(*record("t", "10").last(), decimal("10"));
    for (head, step) in [("t_s", "10"), ("t [s]", "10"), ("t", "0.01"), ("t", "3600")] {
        assert_eq!(record(head, step).hint(), None, "{head} {step}");
    }
}

#[test]
fn the_user_can_name_every_column() {
    let text = "stamp,clock,torque,angle,other,stop\n9,0,1,2,3,1\n9,1,1,2,3,0\n";
    let pair = |v: &str, c: &str| (v.to_owned(), c.to_owned());
    let mut named = rig();
    named.outputs[0].column = Some("other".to_owned());
    named.signals[0].column = Some("stop".to_owned());
    let options = RecordOptions {
        time: Some("clock".to_owned()),
        columns: vec![pair("u", "torque"), pair("phi_m", "angle")],
        ..RecordOptions::default()
    };
    let (record, samples) = open(text, &named, options);
    assert_eq!(samples[1].time, decimal("1"));
    assert_eq!(samples[1].outputs[0].unwrap().mid(), 2.0);
    let expected = [
        ("time", "clock"),
        ("u", "torque"),
        ("phi_m", "angle"),
        ("still", "stop"),
    ];
    let found: Vec<(&str, &str)> = record
        .columns()
        .iter()
        .map(|(v, c)| (v.as_str(), c.as_str()))
        .collect();
    assert_eq!(found, expected);
    assert_eq!(record.ignored_columns(), ["stamp", "other"]);
    assert_eq!(record.warnings(), [""; 0]);
}

#[test]
fn another_unit_than_the_models_is_converted() {
    let text = "t,u [kN*m],phi_m_deg,still\n0,1.1,90,1\n";
    let (record, samples) = open(text, &rig(), RecordOptions::default());
    assert_eq!(record.warnings(), [""; 0]);
    assert_eq!(
        record.conversions(),
        [
            "the column `u [kN*m]` is in kN*m and converted to N*m: times 1000",
            "the column `phi_m_deg` is in deg and converted to rad: times pi/180",
        ]
    );
    assert_eq!(samples[0].inputs, [decimal("1100").to_interval()]);
    let right_angle = interval(
        "1.57079632679489661923132169",
        "1.57079632679489661923132170",
    );
    let widened = rig().outputs[0].error.enclose(right_angle);
    let angle = samples[0].outputs[0].unwrap();
    assert!(widened.is_subset_of(angle), "{angle}");
    assert!(angle.is_subset_of(widened.inflate(1e-15)), "{angle}");
}

#[test]
fn recorded_bounds_are_converted_too() {
    let text = "t,u [N*m],phi_m.lo [deg],phi_m.hi [deg],still\n0,1,-90,180,1\n";
    let (_, samples) = open(text, &rig(), RecordOptions::default());
    let bounds = samples[0].outputs[0].unwrap();
    assert!(interval("-1.6707963267", "3.2415926535").is_subset_of(bounds));
    assert!(bounds.is_subset_of(interval("-1.6707963268", "3.2415926536")));
}

#[test]
fn the_unit_of_the_model_in_another_spelling_changes_nothing() {
    let plain = "t,u,phi_m,still\n0,0.1,0.3,1\n";
    let (_, expected) = open(plain, &rig(), RecordOptions::default());
    for units in [
        "t,u_Nm,phi_m_rad,still",
        "t,u [J],phi_m (rad),still",
        "t,u [N.m],phi_m [rad],still",
    ] {
        let text = plain.replace("t,u,phi_m,still", units);
        let (record, samples) = open(&text, &rig(), RecordOptions::default());
        assert_eq!(samples[0].inputs, expected[0].inputs);
        assert_eq!(samples[0].outputs, expected[0].outputs);
        assert!(record.warnings().is_empty() && record.conversions().is_empty());
    }
}

#[test]
fn a_unit_that_is_not_known_is_said() {
    let text = "t,u [motor],phi_m [counts],still\n0,1,2,1\n";
    let (record, _) = open(text, &rig(), RecordOptions::default());
    assert_eq!(
        record.warnings(),
        [
            "the column `u [motor]` is in motor, the model says N*m for `u`: the numbers are taken as they are",
            "the column `phi_m [counts]` is in counts, the model says rad for `phi_m`: the numbers are taken as they are",
        ]
    );
}

#[test]
fn recorded_bounds_are_widened_by_the_error_bound() {
    let text = "t,u.lo,u.hi,phi_m.lo,phi_m.hi,still\n0,1,1.5,2,3,1\n1,1,1,,,1\n";
    let (record, samples) = open(text, &rig(), RecordOptions::default());
    assert_eq!(samples[0].inputs, [interval("1", "1.5")]);
    let bounds = samples[0].outputs[0].unwrap();
    assert!(interval("1.9", "3.1").is_subset_of(bounds), "{bounds}");
    assert!(bounds.is_subset_of(interval("1.8999999", "3.1000001")));
    assert_eq!(samples[1].outputs, [None]);
    assert_eq!(
        record.columns()[1],
        ("u".to_owned(), "u.lo, u.hi".to_owned())
    );
}

#[test]
fn every_number_is_enclosed_with_its_error() {
    let torque = "u = { unit = \"N*m\", error = { relative = 0.1 } }";
    let angle =
        "phi_m = { expr = \"x\", unit = \"rad\", error = { absolute = 0.1, relative = 0.01 } }";
    let model = model(torque, angle, "");
    // Every recorded decimal, its tenth and its hundredth: the reach of the two error bounds.
    let numbers = [
        ("0.1", "0.01", "0.001"),
        ("-0.3", "0.03", "0.003"),
        ("1e-7", "1e-8", "1e-9"),
        (
            "123.45678901234567890123456789",
            "12.345678901234567890123456789",
            "1.2345678901234567890123456789",
        ),
        ("0", "0", "0"),
    ];
    for (recorded, tenth, hundredth) in numbers {
        let record = format!("t,u,phi_m\n0,{recorded},{recorded}\n");
        let (_, samples) = open(&record, &model, RecordOptions::default());
        contains_tightly(samples[0].inputs[0], &decimal(recorded), &decimal(tenth));
        let reach = &decimal("0.1") + &decimal(hundredth);
        contains_tightly(samples[0].outputs[0].unwrap(), &decimal(recorded), &reach);
    }
    let (_, samples) = open(
        "t,u,phi_m\n0,1e400,-1e400\n",
        &model,
        RecordOptions::default(),
    );
    assert_eq!(samples[0].inputs[0].hi(), f64::INFINITY);
    assert_eq!(samples[0].outputs[0].unwrap().lo(), f64::NEG_INFINITY);
}

/// Checks `bounds` against the exact numbers `recorded - reach` and `recorded + reach`.
fn contains_tightly(bounds: Interval, recorded: &Decimal, reach: &Decimal) {
    let exact = |x: f64| num_rational::BigRational::from_float(x).unwrap();
    let (lower, upper) = (
        (recorded - reach).to_rational(),
        (recorded + reach).to_rational(),
    );
    assert!(
        exact(bounds.lo()) <= lower && upper <= exact(bounds.hi()),
        "{recorded}: {bounds}"
    );
    let width = 2.0 * reach.to_interval().hi();
    assert!(
        bounds.width() <= width + 1e-15 * bounds.mag(),
        "{recorded}: {bounds}"
    );
}

#[test]
fn irregular_stamps_are_kept_exactly() {
    let text = "t,u,phi_m,still\n-5.5,0,0,1\n0.1,0,0,1\n0.10000000000000000001,0,0,1\n1e3,0,0,1\n";
    let samples = read(text);
    let times: Vec<String> = samples.iter().map(|s| s.time.to_string()).collect();
    assert_eq!(times, ["-5.5", "0.1", "0.10000000000000000001", "1000"]);
}

#[test]
fn a_window_holds_both_its_ends_and_values_outside_it_are_not_read() {
    let text = "t,u,phi_m,still\n0.1,x,0,1\n0.2,0,0,1\n0.25,0,0,1\n0.3,0,0,1\n0.4,0,y,1\n";
    let options = RecordOptions {
        from: Some(decimal("0.20")),
        to: Some(decimal("0.3")),
        ..RecordOptions::default()
    };
    let (record, samples) = open(text, &rig(), options);
    assert_eq!(record.len(), 3);
    assert_eq!(
        samples.iter().map(|s| s.line).collect::<Vec<_>>(),
        [3, 4, 5]
    );
    assert_eq!(
        (record.first(), record.last()),
        (&decimal("0.2"), &decimal("0.3"))
    );
}

#[test]
fn a_record_can_be_read_again_and_again() {
    let written = write("t,u,phi_m,still\n0,0,0,1\n1,0,0,1\n");
    let record = Record::open(&written.path, &rig(), RecordOptions::default()).unwrap();
    for _ in 0..3 {
        assert_eq!(record.samples().unwrap().count(), 2);
    }
    assert_eq!(
        record.sha256(),
        veribound_data::sha256_of_file(&written.path).unwrap()
    );
}

#[test]
fn a_file_that_changes_while_it_is_read_is_an_error_and_the_end() {
    let written = write("t,u,phi_m,still\n0,0,0,1\n1,0,0,1\n");
    let record = Record::open(&written.path, &rig(), RecordOptions::default()).unwrap();
    std::fs::write(
        &written.path,
        "t,u,phi_m,still\n0,0,0,1\n1,oops,0,1\n2,0,0,1\n",
    )
    .unwrap();
    let mut samples = record.samples().unwrap();
    assert!(samples.next().unwrap().is_ok());
    assert_eq!(samples.next().unwrap().unwrap_err().0[0].code, "E0412");
    assert!(samples.next().is_none());
}

#[test]
fn missing_values_are_counted() {
    let text = "t,u,phi_m,still\n0,0,,1\n1,0,NaN,\n2,0,0,1\n3,0,nan,0\n";
    let (record, samples) = open(text, &rig(), RecordOptions::default());
    let expected = [("phi_m".to_owned(), 3), ("still".to_owned(), 1)];
    assert_eq!(record.missing(), expected);
    assert_eq!(samples[1].outputs, [None]);
    let window = RecordOptions {
        from: Some(decimal("2")),
        to: Some(decimal("2")),
        ..RecordOptions::default()
    };
    assert_eq!(open(text, &rig(), window).0.missing(), []);
}

#[test]
fn a_check_tells_how_far_it_is() {
    let rows = (0..5000).map(|row| format!("{row},0,0,1\n"));
    let written = write(&("t,u,phi_m,still\n".to_owned() + &rows.collect::<String>()));
    let mut told = Vec::new();
    Record::open_watched(
        &written.path,
        &rig(),
        RecordOptions::default(),
        &mut |bytes| told.push(bytes),
    )
    .unwrap();
    let whole = std::fs::metadata(&written.path).unwrap().len();
    assert_eq!(told.len(), 5);
    assert!(told.is_sorted() && *told.last().unwrap() <= whole);
}

/// Who takes an error for constant while the same value is recorded sees by the bounds that another one was, even where
/// the difference is lost beside the error.
#[test]
fn other_values_have_other_bounds() {
    let text = "format = 1\nstates = [\"x\"]\ninit.x = 0\ninputs.u = { error = { absolute = 0.1, hold = \"level\" } }\n\
                der.x = \"u\"\noutputs.y = \"x +- 0.1\"\n";
    let model = Model::from_text("lag.toml", text).unwrap();
    let lines = [
        "0,1e-18,0",
        "1,1e-18,0",
        "2,2e-18,0",
        "3,1e-18,0",
        "4,1e-18,0",
    ];
    let text = format!("t,u,y\n{}\n", lines.join("\n"));
    let (_, samples) = open(&text, &model, RecordOptions::default());
    let inputs: Vec<Interval> = samples.iter().map(|sample| sample.inputs[0]).collect();
    let same: Vec<bool> = inputs.windows(2).map(|pair| pair[0] == pair[1]).collect();
    assert_eq!(same, [true, false, false, true]);
    assert!(inputs.iter().all(|x| x.contains(-0.1) && x.contains(0.1)));
}
