//! The contract as a whole.

use crate::describe::Described;
use crate::payload::Item;
use crate::topic::{Topic, Visitor, for_each};

/// The names of all headers and items, with their versions. Two programs with the same names understand all of each
/// other's messages.
pub fn names() -> Vec<&'static str> {
    struct Names;
    impl Visitor for Names {
        type Out = [&'static str; 2];
        fn visit<T: Topic>(&mut self) -> Self::Out {
            [T::Header::TYPE_NAME, T::Item::NAME]
        }
    }
    for_each(&mut Names).concat()
}
