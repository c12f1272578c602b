//! Builds the OpenVDB bridge.

fn main() {}
