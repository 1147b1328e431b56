//! Long records: reading takes little time, and memory that does not grow with the length.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use std::io::Write;
use std::time::Instant;
use support::rig;
use veribound_data::{Record, RecordOptions};

fn write(path: &std::path::Path, rows: u32) {
    let mut file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    writeln!(file, "t_s,u_Nm,phi_m,still").unwrap();
    for i in 0..rows {
        let (seconds, rest) = (i / 1000, i % 1000);
        writeln!(
            file,
            "{seconds}.{rest:03},0.{:03},-{}.{:04},{}",
            i % 331,
            i % 97,
            i % 9973,
            i % 2
        )
        .unwrap();
    }
    file.flush().unwrap();
}

/// Most memory this process ever held, in bytes, where the system tells.
fn peak_memory() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: usize = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

#[test]
fn a_long_record_needs_no_more_memory_than_a_short_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    let read = |rows: u32| {
        write(&path, rows);
        let start = Instant::now();
        let record = Record::open(&path, &rig(), RecordOptions::default()).unwrap();
        assert_eq!(record.len(), rows as usize);
        assert_eq!(
            record.samples().unwrap().map(Result::unwrap).count(),
            rows as usize
        );
        start.elapsed()
    };
    read(10_000);
    let before = peak_memory();
    let time = read(100_000);
    println!(
        "checked and read 100 000 rows in {:.3} s",
        time.as_secs_f64()
    );
    // Generous, because tests share the machine; a release build needs about a tenth of it.
    assert!(time.as_secs_f64() < 2.0, "{time:?}");
    read(1_000_000);
    match (before, peak_memory()) {
        (Some(before), Some(after)) => {
            println!(
                "1 000 000 rows (29 MB) took {} KiB more than 10 000",
                (after - before) / 1024
            );
            assert!(after - before < 2_000_000, "{before} bytes grew to {after}");
        }
        _ => println!("SKIPPED: this system does not tell the memory of a process"),
    }
}
