//! The observer on the 80 s rig record of `examples/drive-train`, on one core.
//!
//! `cargo bench -p veribound`: box-steps per second, time per box-step, the slowest sample and the
//! final widths, the fastest of several runs. What a later change is measured against; on a machine
//! with other work, compare figures of one run only. `cargo bench -p veribound -- 50` asks for one
//! number of boxes alone.

use std::path::PathBuf;
use std::time::Instant;
use veribound::{Model, Observer, ObserverOptions, Record, RecordOptions, Sample, Verdict};

const RUNS: usize = 5;

struct Measured {
    seconds: f64,
    worst_sample: f64,
    box_steps: u64,
    boxes_max: usize,
    widths: Vec<f64>,
}

fn run(model: &Model, samples: &[Sample], options: &ObserverOptions) -> Result<Measured, String> {
    let mut observer = Observer::new(model, options.clone());
    let mut worst_sample = 0.0_f64;
    let mut widths = Vec::new();
    let start = Instant::now();
    for sample in samples {
        let sample_start = Instant::now();
        let verdict = observer.step(sample).map_err(|misuse| misuse.to_string())?;
        worst_sample = worst_sample.max(sample_start.elapsed().as_secs_f64());
        let Verdict::Consistent(estimate) = verdict else {
            return Err(format!("not consistent at t = {} s", sample.time));
        };
        widths = estimate
            .params
            .iter()
            .map(|bounds| bounds.width())
            .collect();
    }
    Ok(Measured {
        seconds: start.elapsed().as_secs_f64(),
        worst_sample,
        box_steps: observer.box_steps(),
        boxes_max: observer.boxes_max(),
        widths,
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/drive-train");
    let model = Model::from_file(folder.join("model.toml"))?;
    let record = Record::open(folder.join("rig.csv"), &model, RecordOptions::default())?;
    let samples: Vec<Sample> = record.samples()?.collect::<Result<_, _>>()?;
    println!("{} samples, {} runs, fastest shown", samples.len(), RUNS);
    println!(
        "boxes | seconds | box-steps/s | ns/box-step | worst sample ms | longest list | widths"
    );
    let asked: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let counts = if asked.is_empty() {
        vec![10, 50, 200]
    } else {
        asked
    };
    for boxes in counts {
        let options = ObserverOptions {
            boxes,
            ..ObserverOptions::default()
        };
        let mut best: Option<Measured> = None;
        for _ in 0..RUNS {
            let measured = run(&model, &samples, &options)?;
            if best
                .as_ref()
                .is_none_or(|known| measured.seconds < known.seconds)
            {
                best = Some(measured);
            }
        }
        if let Some(m) = best {
            let rate = m.box_steps as f64 / m.seconds;
            println!(
                "{boxes:5} | {:7.3} | {rate:11.0} | {:11.0} | {:15.3} | {:12} | {:?}",
                m.seconds,
                1e9 / rate,
                1e3 * m.worst_sample,
                m.boxes_max,
                m.widths
            );
        }
    }
    Ok(())
}
