//! What a comparison contains.

use crate::layout::{ComparisonHeader, comparison};

/// What a message of the topic `phasecloud/comparison` contains.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ComparisonKind {
    /// Errors of the quantities of the cloud at one snapshot.
    Moments,
    /// Effort over the whole scenario.
    Effort,
    /// Distances of the densities at one snapshot.
    Distances,
    /// Nothing more comes for this scenario.
    End,
}

impl ComparisonKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Moments, Self::Effort, Self::Distances, Self::End];

    /// The code that stands for it on the wire, one of [`comparison`].
    pub fn code(self) -> u32 {
        match self {
            Self::Moments => comparison::MOMENTS,
            Self::Effort => comparison::EFFORT,
            Self::Distances => comparison::DISTANCES,
            Self::End => comparison::END,
        }
    }
}

impl ComparisonHeader {
    /// What the comparison contains, if its code is known to this version.
    pub fn content(&self) -> Option<ComparisonKind> {
        ComparisonKind::ALL.into_iter().find(|kind| kind.code() == self.kind)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::describe::Code;

    #[test]
    fn every_code_of_the_layout_is_decoded_and_no_other() {
        for Code { name, value, .. } in comparison::CODES.codes {
            let header = ComparisonHeader { kind: *value, ..ComparisonHeader::default() };
            let found = header.content().expect(name);
            assert_eq!((found.code(), format!("{found:?}").to_uppercase().as_str()), (*value, *name));
        }
        for kind in [0, 5, u32::MAX] {
            assert_eq!(ComparisonHeader { kind, ..ComparisonHeader::default() }.content(), None);
        }
    }
}
