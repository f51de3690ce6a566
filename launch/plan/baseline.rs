//! The case in whose effort that of all cases is measured, where nobody names one.

/// The customary label of plain Monte Carlo, whose effort is 1 in Sun et al. (2022), Sect. 4.2.
const CUSTOMARY: &str = "mc";

/// The one of these labels that is the baseline, if it is there.
pub fn among<'l>(labels: impl IntoIterator<Item = &'l str>) -> Option<&'l str> {
    labels.into_iter().find(|label| *label == CUSTOMARY)
}
