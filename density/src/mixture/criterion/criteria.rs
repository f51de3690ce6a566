//! The criteria by name.

use super::local_flow::LocalFlow;
use super::spectral::Preferred;
use super::{first_order, second_order, sigma_points};

/// In which direction a Gaussian is split. `x` is a direction in the variables; see the [room's text](super) for the
/// other symbols.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// Along the longest principal axis of the covariance, whatever the flow does.
    Variance,
    /// First-order stretching: `max |G x|` over `|x| = 1`.
    Fos,
    /// Spherical-average first-order stretching: `max E[(u^T x)² |G u|²]` over `|x| = 1`.
    Safos,
    /// Uncertainty-scaled first-order stretching: `max |G x|` over `|S^{-1} x| = 1`.
    Usfos,
    /// Second-order stretching: `max |G² x²|` over `|x| = 1`.
    Sos,
    /// Whitened uncertainty-scaled second-order stretching: `max |S_z^{-1} G² x²|` over `|S^{-1} x| = 1`.
    Wussos,
    /// Second-order linearisation change: `max |G² x|_F` over `|x| = 1`.
    Solc,
    /// Uncertainty-scaled second-order linearisation change: `max |G²(x) S|_F` over `|S^{-1} x| = 1`.
    Ussolc,
    /// Whitened uncertainty-scaled second-order linearisation change: `max |S_z^{-1} G²(x) S|_F` over `|S^{-1} x| = 1`.
    Wussolc,
    /// Spherical-average second-order stretching: `max E[(u^T x)² |G² u²|²]` over `|x| = 1`.
    Sasos,
    /// Whitened spherical-average second-order stretching: `max E[(u^T x)² |S_z^{-1} G² u²|²]` over `|x| = 1`.
    Wsasos,
    /// Adaptive level of detail transform: along the principal axis whose sigma points are furthest from a line.
    Alodt,
    /// Statistical and deterministic linearisation: `max |(G_SL - G) x|` over `|S^{-1} x| = 1`.
    Sadl,
    /// Whitened uncertainty-scaled statistical and deterministic linearisation: `max |S_z^{-1} (G_SL - G) x|` over
    /// `|S^{-1} x| = 1`.
    Wussadl,
}

impl Criterion {
    /// All criteria.
    pub const ALL: [Self; 14] = [
        Self::Variance,
        Self::Fos,
        Self::Safos,
        Self::Usfos,
        Self::Sos,
        Self::Wussos,
        Self::Solc,
        Self::Ussolc,
        Self::Wussolc,
        Self::Sasos,
        Self::Wsasos,
        Self::Alodt,
        Self::Sadl,
        Self::Wussadl,
    ];

    /// The name that the field uses, in small letters.
    pub fn name(self) -> &'static str {
        match self {
            Self::Variance => "variance",
            Self::Fos => "fos",
            Self::Safos => "safos",
            Self::Usfos => "usfos",
            Self::Sos => "sos",
            Self::Wussos => "wussos",
            Self::Solc => "solc",
            Self::Ussolc => "ussolc",
            Self::Wussolc => "wussolc",
            Self::Sasos => "sasos",
            Self::Wsasos => "wsasos",
            Self::Alodt => "alodt",
            Self::Sadl => "sadl",
            Self::Wussadl => "wussadl",
        }
    }

    /// The direction in standardised coordinates.
    pub(super) fn preferred<const N: usize>(self, flow: &LocalFlow<N>) -> Preferred<N> {
        match self {
            Self::Variance => first_order::variance(flow),
            Self::Fos => first_order::fos(flow),
            Self::Safos => first_order::safos(flow),
            Self::Usfos => first_order::usfos(flow),
            Self::Sos => second_order::sos(flow),
            Self::Wussos => second_order::wussos(flow),
            Self::Solc => second_order::solc(flow),
            Self::Ussolc => second_order::ussolc(flow),
            Self::Wussolc => second_order::wussolc(flow),
            Self::Sasos => second_order::sasos(flow),
            Self::Wsasos => second_order::wsasos(flow),
            Self::Alodt => sigma_points::alodt(flow),
            Self::Sadl => sigma_points::sadl(flow),
            Self::Wussadl => sigma_points::wussadl(flow),
        }
    }
}
