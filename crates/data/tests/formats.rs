//! Records that are no text: MAT, HDF5 and Parquet files give the samples that the same numbers give as CSV.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use hdf5_pure::FileBuilder;
use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use support::shared;
use veribound_data::{Record, RecordOptions, sha256_of_file};
use veribound_interval::Interval;
use veribound_model::model::Model;

fn model() -> Model {
    let text = "format = 1\nstates = [\"x [m]\"]\ninit.x = [-1, 1]\ninputs = [\"u [V]\"]\n\
        params.k = { unit = \"m/(V*s)\", bounds = [0, 4] }\nder.x = \"k * u\"\noutputs.pos = \"x +- 0.1 [m]\"\n";
    Model::from_text("m.toml", text).unwrap()
}

const TIMES: [f64; 4] = [0.0, 0.1, 0.25, 1.0 / 3.0];
const INPUTS: [f64; 4] = [1.0, -0.3, 1e-9, 5.0];
const OUTPUTS: [f64; 4] = [0.1, f64::NAN, 12_345.678_9, -0.7];

/// A matrix of doubles as an element of a MAT file.
fn matrix(name: &str, (rows, width): (u32, u32), values: &[f64]) -> Vec<u8> {
    fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
        let mut all = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
        all.extend(bytes);
        all.resize(all.len().next_multiple_of(8), 0);
        all
    }
    let flags = [6_u32.to_le_bytes(), 0_u32.to_le_bytes()].concat();
    let size = [rows.to_le_bytes(), width.to_le_bytes()].concat();
    let data: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    let parts = [
        element(6, &flags),
        element(5, &size),
        element(1, name.as_bytes()),
        element(9, &data),
    ];
    element(14, &parts.concat())
}

fn mat(parts: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file, made for a test".to_vec();
    bytes.resize(124, b' ');
    bytes.extend([0x00, 0x01, b'I', b'M']);
    bytes.extend(parts.concat());
    bytes
}

fn mat_record() -> Vec<u8> {
    // A row vector, a column, a matrix of two columns, and a number of its own.
    let two: Vec<f64> = OUTPUTS.iter().chain(&INPUTS).copied().collect();
    mat(&[
        matrix("t", (1, 4), &TIMES),
        matrix("u", (4, 1), &INPUTS),
        matrix("y", (4, 2), &two),
        matrix("gain", (1, 1), &[3.0]),
    ])
}

fn hdf5_record(place: &Path) -> PathBuf {
    let mut file = FileBuilder::new();
    file.create_dataset("t")
        .with_f64_data(&TIMES)
        .with_shape(&[4]);
    file.create_dataset("u")
        .with_f64_data(&INPUTS)
        .with_shape(&[4]);
    let rows: Vec<f64> = OUTPUTS
        .iter()
        .zip(&INPUTS)
        .flat_map(|(y, u)| [*y, *u])
        .collect();
    file.create_dataset("y")
        .with_f64_data(&rows)
        .with_shape(&[4, 2]);
    file.create_dataset("gain")
        .with_f64_data(&[3.0])
        .with_shape(&[1]);
    let path = place.join("r.h5");
    file.write(path.to_str().unwrap()).unwrap();
    path
}

fn parquet_record(place: &Path, compression: Compression) -> PathBuf {
    let schema = "message rows { required double t; required double u [V]; optional double pos; optional binary note (UTF8); \
                  required int64 still; }"
        .replace("u [V]", "u_V");
    let schema = Arc::new(parse_message_type(&schema).unwrap());
    let properties = WriterProperties::builder()
        .set_compression(compression)
        .build();
    let path = place.join("r.parquet");
    let file = std::fs::File::create(&path).unwrap();
    let mut writer = SerializedFileWriter::new(file, schema, Arc::new(properties)).unwrap();
    let mut group = writer.next_row_group().unwrap();
    let levels = [1, 0, 1, 1];
    for column in 0..5 {
        let mut next = group.next_column().unwrap().unwrap();
        match column {
            0 => next
                .typed::<DoubleType>()
                .write_batch(&TIMES, None, None)
                .unwrap(),
            1 => next
                .typed::<DoubleType>()
                .write_batch(&INPUTS, None, None)
                .unwrap(),
            2 => {
                let known: Vec<f64> = OUTPUTS.iter().copied().filter(|y| !y.is_nan()).collect();
                next.typed::<DoubleType>()
                    .write_batch(&known, Some(&levels), None)
                    .unwrap()
            }
            3 => {
                let texts: Vec<ByteArray> = ["a", "b,c", "d"].map(ByteArray::from).to_vec();
                next.typed::<ByteArrayType>()
                    .write_batch(&texts, Some(&levels), None)
                    .unwrap()
            }
            _ => next
                .typed::<Int64Type>()
                .write_batch(&[1, 0, 1, 0], None, None)
                .unwrap(),
        };
        next.close().unwrap();
    }
    group.close().unwrap();
    writer.close().unwrap();
    path
}

fn open(path: &Path, columns: &[(&str, &str)]) -> Record {
    let columns = columns
        .iter()
        .map(|(v, c)| ((*v).to_owned(), (*c).to_owned()));
    let options = RecordOptions {
        columns: columns.collect(),
        ..RecordOptions::default()
    };
    Record::open(path, &model(), options)
        .unwrap_or_else(|problems| panic!("{}", problems.render(false)))
}

/// A number of the file means that number exactly.
fn check(record: &Record) {
    assert_eq!(record.len(), 4);
    assert_eq!(record.sha256(), sha256_of_file(record.path()).unwrap());
    assert_eq!(record.missing(), [("pos".to_owned(), 1)]);
    let error = Interval::new(-0.1, 0.1).unwrap();
    for (k, sample) in record.samples().unwrap().enumerate() {
        let sample = sample.unwrap();
        assert_eq!(sample.time.to_interval(), Interval::point(TIMES[k]), "{k}");
        assert_eq!(sample.inputs, [Interval::point(INPUTS[k])]);
        assert_eq!(sample.line, k + 2);
        match sample.outputs[0] {
            None => assert!(OUTPUTS[k].is_nan()),
            Some(found) => {
                let wanted = Interval::point(OUTPUTS[k]) + error;
                assert!(
                    found.contains(OUTPUTS[k]) && (found.width() - wanted.width()).abs() < 1e-11
                );
            }
        }
    }
    // Lines for messages.
    assert!(record.line(1).unwrap().starts_with("t,u"));
    assert!(
        record
            .line(3)
            .unwrap()
            .starts_with("0.1000000000000000055511151231257827021181583404541015625,-0.29999")
    );
    assert_eq!(record.line(6), None);
}

#[test]
fn a_mat_file_is_a_record() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("r.mat");
    std::fs::write(&path, mat_record()).unwrap();
    let record = open(&path, &[("pos", "y(1)")]);
    check(&record);
    assert_eq!(record.ignored_columns(), ["y(2)"]);
}

#[test]
fn an_hdf5_file_is_a_record() {
    let place = tempfile::tempdir().unwrap();
    check(&open(&hdf5_record(place.path()), &[("pos", "y(1)")]));
}

/// MATLAB v7.3: HDF5 behind a head of its own, with dimensions in reverse.
#[test]
fn a_mat_file_of_version_7_3_is_a_record() {
    let place = tempfile::tempdir().unwrap();
    let mut file = FileBuilder::new();
    let head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, made for a test";
    file.with_userblock(512).with_userblock_content(head);
    let mut dataset = |name: &str, values: &[f64], shape: &[u64]| {
        file.create_dataset(name)
            .with_f64_data(values)
            .with_shape(shape);
    };
    let two: Vec<f64> = OUTPUTS.iter().chain(&INPUTS).copied().collect();
    dataset("t", &TIMES, &[1, 4]);
    dataset("u", &INPUTS, &[4, 1]);
    dataset("y", &two, &[2, 4]);
    dataset("gain", &[3.0], &[1, 1]);
    let path = place.path().join("r.mat");
    file.write(path.to_str().unwrap()).unwrap();
    check(&open(&path, &[("pos", "y(1)")]));
}

#[test]
fn a_parquet_file_is_a_record_however_it_is_compressed() {
    let place = tempfile::tempdir().unwrap();
    let zstd = Compression::ZSTD(Default::default());
    let gzip = Compression::GZIP(Default::default());
    for compression in [
        Compression::UNCOMPRESSED,
        Compression::SNAPPY,
        gzip,
        zstd,
        Compression::LZ4_RAW,
    ] {
        let record = open(&parquet_record(place.path(), compression), &[]);
        check(&record);
        assert_eq!(record.ignored_columns(), ["note", "still"]);
    }
}

/// What is wrong inside is told as of a text table.
#[test]
fn messages_name_the_column_and_the_row() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("r.mat");
    std::fs::write(
        &path,
        mat(&[
            matrix("time", (3, 1), &[0.0, 1.0, 0.5]),
            matrix("u", (3, 1), &[1.0, f64::INFINITY, 1.0]),
        ]),
    )
    .unwrap();
    let said = Record::open(&path, &model(), RecordOptions::default())
        .unwrap_err()
        .render(false);
    assert!(
        said.contains("error[E0408]") && said.contains("time,u"),
        "{said}"
    );
    let parts = [
        matrix("time", (3, 1), &[0.0, 1.0, 0.5]),
        matrix("u", (3, 1), &[1.0, f64::INFINITY, 1.0]),
        matrix("pos", (3, 1), &[0.0; 3]),
    ];
    std::fs::write(&path, mat(&parts)).unwrap();
    let said = Record::open(&path, &model(), RecordOptions::default())
        .unwrap_err()
        .render(false);
    for part in ["error[E0412]", "r.mat:3:", "error[E0415]", "r.mat:4:"] {
        assert!(said.contains(part), "no {part} in {said}");
    }
    std::fs::write(&path, mat(&[matrix("gain", (1, 1), &[1.0])])).unwrap();
    let said = Record::open(&path, &model(), RecordOptions::default())
        .unwrap_err()
        .render(false);
    assert!(
        said.contains("error[E0422]: ") && said.contains("holds no columns of numbers"),
        "{said}"
    );
}

/// Files that are cut off or damaged end in messages, or in samples; nothing panics.
#[test]
fn damaged_files_are_told() {
    let place = tempfile::tempdir().unwrap();
    let whole = [
        ("x.mat", mat_record()),
        ("x.h5", std::fs::read(hdf5_record(place.path())).unwrap()),
        (
            "x.parquet",
            std::fs::read(parquet_record(place.path(), Compression::SNAPPY)).unwrap(),
        ),
    ];
    let model = model();
    let mut state = 1_u64;
    let mut random = move |end: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as usize) % end
    };
    for (name, bytes) in &whole {
        let path = place.path().join(name);
        let try_it = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            match Record::open(&path, &model, RecordOptions::default()) {
                Ok(record) => assert_eq!(
                    record.samples().unwrap().filter(Result::is_ok).count(),
                    record.len()
                ),
                Err(problems) => assert!(problems.render(false).contains("error[E0")),
            }
        };
        for cut in (0..bytes.len()).step_by(bytes.len() / 100) {
            try_it(&bytes[..cut]);
        }
        for _ in 0..600 {
            let mut bad = bytes.clone();
            for _ in 0..=random(4) {
                let at = random(bad.len());
                bad[at] = random(256) as u8;
            }
            try_it(&bad);
        }
    }
}

/// The measured axis as its authors published it.
#[test]
fn the_file_of_the_emps_benchmark_is_read_as_it_is() {
    let Some(folder) = shared() else {
        println!(
            "SKIPPED DATA_EMPS.mat: no folder `shared` beside the project; set VERIBOUND_SHARED to it"
        );
        return;
    };
    let path = folder.join("data/emps/DATA_EMPS.mat");
    let record = open(&path, &[("u", "vir"), ("pos", "qm")]);
    assert_eq!(record.len(), 24_841);
    assert_eq!(record.ignored_columns(), ["qg"]);
    let csv = support::model(
        "force = { unit = \"N\" }",
        "position = { expr = \"x\", unit = \"m\", error = { absolute = 0.0002 } }",
        "",
    );
    let same = Record::open(
        folder.join("data/emps/emps.csv"),
        &csv,
        RecordOptions::default(),
    )
    .unwrap();
    for (a, b) in record.samples().unwrap().zip(same.samples().unwrap()) {
        let (a, b) = (a.unwrap(), b.unwrap());
        let middle = |x: Option<Interval>| x.unwrap().mid();
        // The CSV has its time stamps rounded to milliseconds.
        assert!((a.time.to_interval().mid() - b.time.to_interval().mid()).abs() < 1e-5);
        assert!((middle(a.outputs[0]) - middle(b.outputs[0])).abs() < 1e-6);
    }
}
