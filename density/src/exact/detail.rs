//! How finely the orbits of a cloud are resolved.
//!
//! A yardstick needs all digits. Where a mean over many clouds is taken, one for each value of an uncertain parameter,
//! and each of them needs five digits only, most of the work would go into digits that nobody asks for. What a coarser
//! resolution loses shows: the probability of all orbits is then off 1 by as much, which every error estimate includes.

/// How finely the orbits of a cloud are resolved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Detail {
    /// Distance from the mean within which the cloud is looked for, in standard deviations.
    pub radius: f64,
    /// Number of points of the initial Gaussian in each direction whose orbits show where the cloud lies.
    pub pilots: u32,
    /// Number of parts, with equally many of these points each, into which the range of the orbits is cut at first.
    pub parts: usize,
    /// Whether there are further cuts at the first and at the last of these points.
    pub cuts_ends: bool,
    /// Largest permitted size of the last two Legendre coefficients of the initial probability along an orbit in an
    /// interval, as a share of its size there. The rule's own error is about the square of that size.
    pub tail: f64,
    /// The same for an interval that holds little.
    pub rough_tail: f64,
    /// Share of the whole below which the last coefficients of an interval must be if the interval is to count as
    /// holding little.
    pub little: f64,
    /// Largest number of orbits that are kept for the next snapshot.
    pub kept: usize,
}

impl Detail {
    /// For a yardstick. 2e-16 of the cloud lies beyond the radius.
    pub(crate) const FINE: Self = Self {
        radius: 8.5,
        pilots: 25,
        parts: 6,
        cuts_ends: true,
        tail: 3e-6,
        rough_tail: 1e-4,
        little: 5e-12,
        kept: 20_000,
    };

    /// For one of many clouds, to 1e-6. 2e-8 of the cloud lies beyond the radius.
    pub(crate) const COARSE: Self = Self {
        radius: 6.0,
        pilots: 13,
        parts: 3,
        cuts_ends: false,
        tail: 1e-4,
        rough_tail: 1e-3,
        little: 1e-9,
        kept: 300,
    };
}
