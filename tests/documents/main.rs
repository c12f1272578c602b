//! Pages, commands and messages that a user reads.

#[path = "../common/documents.rs"]
mod documents;
#[path = "../../cpp/find.rs"]
mod find;
#[path = "../common/marked.rs"]
mod marked;
#[path = "../bench/results/pages/mod.rs"]
mod pages;

mod build_message;
mod constants;
mod guide;
mod results;
mod structure;
