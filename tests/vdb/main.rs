//! OpenVDB files.

#[path = "../common/vdb.rs"]
mod common;
#[allow(dead_code)]
#[path = "../corpus/mod.rs"]
mod corpus;
#[path = "../common/skip.rs"]
mod skip;

mod files;
mod info;
