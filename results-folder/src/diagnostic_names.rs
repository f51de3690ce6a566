//! The names that `diagnostics.csv` has for what a method says of its own reliability.

/// Of a density that is carried along characteristics.
pub const OF_A_MESH: [&str; 4] = ["measure_defect", "flipped_mass", "truncated_mass", "misplaced_mass"];
/// Of a mixture.
pub const OF_A_MIXTURE: [&str; 1] = ["disagreement"];
/// Of a density that its method states itself, with estimates of the errors.
pub const OF_A_STATED_DENSITY: [&str; 4] =
    ["moment_error_sigmas", "resultant_vector_error", "prob_above_critical_e_error", "joint_l1_error"];
