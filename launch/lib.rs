//! What of the launcher others use as well: the reader of launch files, which tests and fuzzers feed.

pub mod launch_file;
