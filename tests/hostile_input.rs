//! Whatever bytes stand in a scenario or launch file, reading it neither panics nor hangs, and a refusal says where and
//! why. `examples/fuzz_inputs.rs` does the same a million times, `fuzz/` guided by coverage.
#![allow(missing_docs)]

#[path = "../fuzz/inputs.rs"]
mod inputs;
#[path = "../fuzz/strategies.rs"]
mod strategies;

use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_scenario_file_is_read_or_refused_with_file_line_and_key(
        bytes in strategies::texts(&strategies::SCENARIO_FILES),
    ) {
        inputs::scenario_file(&bytes.0);
    }

    #[test]
    fn any_launch_file_is_read_or_refused_with_file_line_and_key(
        bytes in strategies::texts(&strategies::LAUNCH_FILES),
    ) {
        inputs::launch_file(&bytes.0);
    }
}

#[test]
fn deep_nesting_and_long_texts_are_refused_or_read() {
    for text in [
        "a=".to_owned() + &"[".repeat(100_000),
        "a=".to_owned() + &"{a=".repeat(100_000),
        "a.".repeat(100_000) + "a=1",
        "[".to_owned() + &"a.".repeat(100_000) + "a]",
        format!("name = \"{}\"", "x".repeat(1_000_000)),
        "\n".repeat(1_000_000),
        "[[propagator]]\nlabel = \"a\"\nnode = \"mc\"\n".repeat(20_000),
    ] {
        inputs::scenario_file(text.as_bytes());
        inputs::launch_file(text.as_bytes());
    }
}
