//! The drive train rig, built in Rust code: the same model as `model-friction.toml`, and the same bounds.
//!
//! `cargo run --release -p veribound --example drive-train` reads 10 s of the record and prints what is proved.

use std::path::Path;
use veribound::build::{ModelBuilder, friction};
use veribound::{Diagnostics, Model, Observer, ObserverOptions, Record, RecordOptions, Verdict};

/// A motor turns a shaft against friction.
pub fn rig() -> Result<Model, Diagnostics> {
    let mut model = ModelBuilder::new("drive train rig");

    // What moves, and where it starts. Numbers are whole or text: "0.2" is a fifth, exactly.
    let phi = model.state("phi").unit("rad").init("-0.2", "0.2").symbol();
    let omega = model.state("omega").unit("rad/s").init(0, 0).symbol();

    // What the record says of the motor.
    let u = model.input("u").unit("N*m").symbol();

    // What is not known, with what is believed before the record.
    let alpha = model.param("alpha", -6, "-0.05").symbol();
    let beta = model.param("beta", 1, 400).symbol();
    let level = model.param("T_Fs", 0, "0.3").symbol();

    // The equations. Friction stands for three modes: forward, stick, backward.
    model.der(&phi, &omega);
    model.der(
        &omega,
        &alpha * &omega + &beta * (&u - friction(&omega, &u, &level)),
    );

    // What is measured, and how wrong it can be.
    model.output("phi_m", &phi, "0.1");
    model.signal("still").proves(omega.equals(0), 0);

    model.build()
}

#[allow(dead_code, reason = "the test of this example needs the model alone")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = rig()?;
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/drive-train");
    let record = Record::open(folder.join("rig.csv"), &model, RecordOptions::default())?;
    let mut observer = Observer::new(&model, ObserverOptions::default());
    let mut params: Vec<_> = model.params.iter().map(|param| param.bounds).collect();
    for sample in record.samples()?.take(1000) {
        match observer.step(&sample?)? {
            Verdict::Consistent(estimate) => params = estimate.params,
            Verdict::Inconsistent(proof) => {
                println!("model and record contradict each other at {} s", proof.time);
                return Ok(());
            }
            Verdict::Undecided(why) => {
                println!("no statement from {} s on: {:?}", why.time, why.reason);
                return Ok(());
            }
        }
    }
    for (param, bounds) in model.params.iter().zip(params) {
        println!("{} lies in {bounds}", param.name);
    }
    Ok(())
}
