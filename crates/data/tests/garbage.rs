//! Whatever the bytes of a record are, reading it ends with samples or with messages.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::rig;
use veribound_data::{Record, RecordOptions};
use veribound_model::model::Model;

/// Pseudo-random numbers; the seed makes every run the same.
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % end
    }
}

/// Reads `bytes` as a record; what comes out does not matter.
fn read(bytes: &[u8], path: &std::path::Path, model: &Model) {
    std::fs::write(path, bytes).unwrap();
    match Record::open(path, model, RecordOptions::default()) {
        Ok(record) => {
            assert_eq!(
                record.samples().unwrap().filter(Result::is_ok).count(),
                record.len()
            );
        }
        Err(problems) => {
            assert!(!problems.0.is_empty());
            assert!(problems.0.len() <= 64);
            assert!(!problems.render(false).is_empty());
        }
    }
}

#[test]
fn random_bytes_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    let model = rig();
    let mut random = Random(1);
    for _ in 0..300 {
        let bytes: Vec<u8> = (0..random.below(400))
            .map(|_| random.below(256) as u8)
            .collect();
        read(&bytes, &path, &model);
    }
}

#[test]
fn random_texts_of_table_characters_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    let model = rig();
    let pieces = [
        "t", "u", "phi_m", "still", ",", ",", ",", ";", "\t", "\"", "\n", "\n", "\r", "0", "1",
        ".5", "-", "e9", "e99999", "NaN", "inf", "[", "]", " ", "#", "ä", "\u{feff}", ".lo", ".hi",
        "_ms", "(",
    ];
    let mut random = Random(2);
    for _ in 0..1200 {
        let start = if random.below(2) == 0 {
            "t,u,phi_m,still\n"
        } else {
            ""
        };
        let body: String = (0..random.below(60))
            .map(|_| pieces[random.below(pieces.len())])
            .collect();
        read(format!("{start}{body}").as_bytes(), &path, &model);
    }
}

#[test]
fn damaged_records_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    let model = rig();
    let whole = "t,u,phi_m,still\n0.00,0.22,-0.0282,1\n0.01,-1,,0\n\"0.025\",3,2e0,\n".as_bytes();
    let mut random = Random(3);
    for _ in 0..1000 {
        let mut bytes = whole.to_vec();
        for _ in 0..=random.below(4) {
            let at = random.below(bytes.len());
            match random.below(3) {
                0 => bytes[at] = random.below(256) as u8,
                1 => drop(bytes.remove(at)),
                _ => bytes.insert(at, b",;\"\n\r\t0eE.-#x"[random.below(13)]),
            }
        }
        read(&bytes, &path, &model);
    }
}
