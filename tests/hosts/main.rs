//! Runs over several hosts: each host is a domain of its own, joined over loopback or, where that is allowed, over
//! network namespaces.
#![allow(missing_docs)]

#[path = "../common/mod.rs"]
mod common;

mod faults;
mod link;
mod map;
mod namespaces;
mod sameness;
mod security;
mod site;
