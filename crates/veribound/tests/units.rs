//! What is simulated is in the units of the model.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "a test that fails stops"
)]

mod support;

use support::{CART, Place};

#[test]
fn what_is_not_in_the_units_of_the_model_is_not_simulated() {
    let place = Place::new();
    let flags = "--params k=1 --start x=0 --input u.csv -o r.csv";
    let run = |model: &str, profile: &str| {
        let model = place.file("m.toml", model);
        place.file("u.csv", profile);
        let mut all = vec!["simulate", model.as_str()];
        all.extend(flags.split(' '));
        place.run(&all).ended(2).err
    };
    let said = run(CART, "t,u [mV]\n0,1\n1,1\n");
    assert!(
        said.contains("the profile is not in the units of the model"),
        "{said}"
    );
    let column = "outputs.pos = { expr = \"x\", unit = \"m\", error = 0.1, column = \"x [mm]\" }";
    let other = CART.replace("outputs.pos = \"x +- 0.1 [m]\"", column);
    let said = run(&other, "t,u\n0,1\n1,1\n");
    assert!(said.contains("the column `x [mm]` is not in m,"), "{said}");
}
