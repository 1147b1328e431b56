//! Eight boxes of the rig's acceleration `alpha*omega + beta*(u - T_Fs)`: by tape, and by the same four lane
//! operations written out in one kernel.
//!
//! `cargo bench -p veribound-model`: nanoseconds for eight boxes, the fastest of many rounds; the contenders take
//! turns. On a machine with other work only figures of one run can be compared.

use std::hint::black_box;
use std::time::Instant;
use veribound_interval::Interval;
use veribound_interval::lanes::{Arithmetic, Interval8, Kernel, Value};
use veribound_model::{Model, Tape};

const BOXES: usize = 256;
const ROUNDS: usize = 2000;

/// The formula on one batch: what a tape is measured against.
struct Written<'a> {
    quantities: &'a [Interval8],
    result: &'a mut Interval8,
}

impl Kernel<Interval8> for Written<'_> {
    type Output = ();

    #[inline(always)]
    fn run<A: Arithmetic<Value = Interval8>>(self) {
        // In the order of the layout: states, parameters, inputs.
        if let [_, omega, alpha, beta, level, u] = self.quantities {
            let drive = A::sub(u, level);
            *self.result = A::add(&A::mul(omega, alpha), &A::mul(beta, &drive));
        }
    }
}

/// Boxes like those of the observer: some with both signs of a factor.
fn batches(model: &Model) -> Vec<Vec<Interval8>> {
    let mut seed = 7_u64;
    let mut share = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut near = move |lo: f64, hi: f64, width: f64| {
        Interval8::from_fn(|_| {
            let at = lo + share() * (hi - lo);
            Interval::new(at, at + width * share()).unwrap_or(Interval::ZERO)
        })
    };
    let batch = |_| {
        let mut all = vec![near(-1.0, 1.0, 0.1), near(-20.0, 20.0, 1.0)];
        for param in &model.params {
            all.push(near(param.bounds.lo(), param.bounds.hi(), 0.01));
        }
        all.push(near(-1.0, 1.0, 0.01));
        all
    };
    (0..BOXES).map(batch).collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../examples/drive-train/model.toml"
    );
    let model = Model::from_file(path)?;
    let acceleration = model.modes.first().map(|mode| mode.der.as_slice());
    let Some([_, acceleration]) = acceleration else {
        return Err("the rig has two states".into());
    };
    let tape = Tape::compile(&model.graph, model.layout(), &[*acceleration]);
    let mut registers = tape.registers::<Interval8>();
    let batches = batches(&model);
    let mut result = Interval8::EMPTY;
    let (mut by_tape, mut written) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        let start = Instant::now();
        for quantities in &batches {
            black_box(tape.eval(quantities, &mut registers));
            black_box(&registers);
        }
        by_tape = by_tape.min(start.elapsed().as_secs_f64());
        let start = Instant::now();
        for quantities in &batches {
            Interval8::run(Written {
                quantities,
                result: &mut result,
            });
            black_box(&result);
        }
        written = written.min(start.elapsed().as_secs_f64());
    }
    for quantities in &batches {
        tape.eval(quantities, &mut registers);
        Interval8::run(Written {
            quantities,
            result: &mut result,
        });
        assert!(tape.output(0, &registers) == result, "other bits");
    }
    let nanoseconds = |seconds: f64| 1e9 * seconds / BOXES as f64;
    println!(
        "{} instructions: tape {:.1} ns, written out {:.1} ns, ratio {:.2}",
        tape.len(),
        nanoseconds(by_tape),
        nanoseconds(written),
        by_tape / written
    );
    Ok(())
}
