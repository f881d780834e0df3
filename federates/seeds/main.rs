//! The launcher and toolbox; every federate is a subcommand of it.

use std::process::ExitCode;

fn main() -> ExitCode {
    federates::seeds::main()
}
