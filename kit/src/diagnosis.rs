//! What a method says of its own reliability, as a density message carries it. Only this file knows the codes.

use density::trust::Diagnosis;
use messages::layout::{DensityHeader, diagnostic};

/// What the message says.
pub fn of(header: &DensityHeader) -> Diagnosis {
    match header.diagnostic {
        diagnostic::MESH => Diagnosis::mesh(header.diagnostics),
        diagnostic::MIXTURE => Diagnosis::mixture(header.diagnostics),
        diagnostic::NUMERICAL => Diagnosis::stated(header.diagnostics),
        // Also a code that this version does not know.
        _ => Diagnosis::None,
    }
}

/// The code and the numbers of a message.
pub fn to_parts(diagnosis: Diagnosis) -> (u32, [f64; 4]) {
    match diagnosis {
        Diagnosis::None => (diagnostic::NONE, [f64::NAN; 4]),
        Diagnosis::Mesh { measure_defect, flipped_mass, truncated_mass, misplaced_mass } => {
            (diagnostic::MESH, [measure_defect, flipped_mass, truncated_mass, misplaced_mass])
        }
        Diagnosis::Mixture { disagreement, below_zero, weights, beyond_one } => {
            (diagnostic::MIXTURE, [disagreement, below_zero, weights, beyond_one])
        }
        Diagnosis::Stated { moments, resultant, probability, joint } => {
            (diagnostic::NUMERICAL, [moments, resultant, probability, joint])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagnosis_survives_the_way_through_a_message() {
        for said in [Diagnosis::mesh, Diagnosis::mixture, Diagnosis::stated].map(|of| of([0.1, 0.2, 0.3, 0.4])) {
            let (diagnostic, diagnostics) = to_parts(said);
            assert_eq!(of(&DensityHeader { diagnostic, diagnostics, ..DensityHeader::default() }), said);
        }
        let unknown = DensityHeader { diagnostic: 77, ..DensityHeader::default() };
        assert_eq!((of(&DensityHeader::default()), of(&unknown)), (Diagnosis::None, Diagnosis::None));
    }
}
