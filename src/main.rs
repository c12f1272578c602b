//! The `fogbow` program: everything it does is in the library.

fn main() -> std::process::ExitCode {
    fogbow::cli::main(std::env::args_os()).into()
}
