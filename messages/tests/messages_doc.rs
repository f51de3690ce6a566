//! `docs/messages.md` agrees with the layouts.
#![allow(missing_docs)]

#[path = "../examples/messages_doc.rs"]
#[expect(dead_code, reason = "its main is not called here")]
mod messages_doc;

#[test]
fn the_document_is_what_the_layouts_say() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/messages.md");
    let written = std::fs::read_to_string(path).unwrap();
    let how = "write it anew: cargo run -p phasecloud-messages --example messages_doc > docs/messages.md";
    assert!(written == messages_doc::document(), "{path} is stale; {how}");
}
