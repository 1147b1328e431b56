//! The program `veribound`: proved parameter and state bounds from a model file and a record.

mod program;

use std::process::ExitCode;

fn main() -> ExitCode {
    program::main()
}
