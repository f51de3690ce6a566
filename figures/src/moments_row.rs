//! A row of `moments.csv` in the plane.

use serde::Deserialize;

/// A row of `moments.csv`.
#[derive(Debug, Clone, Deserialize)]
#[expect(missing_docs, reason = "the columns are the documented ones of the results folder")]
pub struct MomentsRow {
    pub scenario: String,
    pub method: String,
    pub t_yr: f64,
    pub mean_phi_rad: f64,
    pub std_phi_rad: f64,
    pub mean_e: f64,
    pub std_e: f64,
    pub prob_above_critical_e: f64,
    pub se_mean_phi_rad: f64,
    pub se_std_phi_rad: f64,
    pub se_mean_e: f64,
    pub se_std_e: f64,
    pub se_prob_above_critical_e: f64,
    pub mass_on_grid: f64,
}
