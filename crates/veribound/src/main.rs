//! The program `veribound`: proved parameter and state bounds from a model file and a record.

use std::process::ExitCode;

fn main() -> ExitCode {
    veribound::program::main()
}
