//! Marginal densities of a case against the reference (Figs. 5, 12, 16), with the counting error of Monte Carlo.

use density::grid::Axis as Bins;

use super::{at_time, e_axis, phi_axis, steps};
use crate::axis::Axis;
use crate::densities::Density;
use crate::elements::{Element, Point};
use crate::figure::{DrawError, Figure};
use crate::legend::{Entry, Sample};
use crate::palette::Ink;
use crate::panel::{Panel, Surroundings};
use crate::scene::{Method, Scene};

/// Half width of a 95 % interval in standard deviations.
const SIGMAS: f64 = 1.96;
/// Height of a row of panels \[px\].
const ROW: u32 = 165;
const BAND: Ink = Ink::Series(0);

/// Draws both marginals of a case at every snapshot.
pub fn draw(scene: &Scene<'_>, method: &Method<'_>) -> Result<Figure, DrawError> {
    let reference = scene.yardstick().filter(|yardstick| yardstick.label != method.label);
    let band = scene.monte_carlo();
    let mut key: Vec<Entry> = vec![(Sample::Line(method.pen.stroke), method.label.to_owned())];
    key.extend(reference.map(|reference| (Sample::Line(reference.pen.stroke), reference.label.to_owned())));
    key.extend(band.map(|(mc, n)| (Sample::Band(BAND), format!("95 % counting error of {} ({n} samples)", mc.label))));
    let caption = format!(
        "Left the solar angle, on the branch that keeps the cloud whole, right the eccentricity; a row a snapshot.{} Corresponds \
         to Figs. 5, 12 and 16 of Sun et al. (2022).",
        match band {
            Some((mc, _)) =>
                format!(" The band is {SIGMAS} binomial standard deviations of a bin's count about {}.", mc.label),
            None => String::new(),
        }
    );
    let name = scene.figure_name(&format!("marginals-{}", method.label));
    let title = match reference {
        Some(reference) => format!("Marginal densities of {} and {}", method.label, reference.label),
        None => format!("Marginal densities of {}", method.label),
    };
    let rows = method.densities.len();
    Figure::draw(&name, &title, &caption, (760, ROW * rows as u32), &key, |area| {
        let areas = area.split_evenly((rows, 2));
        for (index, (pair, density)) in areas.chunks_exact(2).zip(method.densities).enumerate() {
            let title = scene.times.get(index).map_or(String::new(), |&t| at_time(t));
            let stated = |other: &Method<'_>| other.densities.get(index).filter(|d| !d.is_withheld()).cloned();
            let at = |other: &Method<'_>| stated(other).map(|density| (density, other.pen));
            let (other, mc) = (reference.and_then(at), band.and_then(|(mc, n)| Some((at(mc)?.0, n))));
            for (area, of) in pair.iter().zip([Variable::Phi, Variable::E]) {
                let mut elements = Vec::new();
                elements.extend(mc.as_ref().map(|(mc, n)| of.band(mc, *n)));
                elements.extend(other.as_ref().map(|(other, pen)| Element::curve(of.curve(other), pen.stroke)));
                let own = Some(density).filter(|density| !density.is_withheld());
                elements.extend(own.map(|density| Element::curve(of.curve(density), method.pen.stroke)));
                let highest = [own, other.as_ref().map(|(other, _)| other), mc.as_ref().map(|(mc, _)| mc)];
                let highest = highest.into_iter().flatten().flat_map(|d| of.values(d)).copied().fold(0.0, f64::max);
                let around = Surroundings { title: &title, ..Surroundings::default() };
                let y = Axis::linear(of.label(), 0.0..if highest > 0.0 { 1.06 * highest } else { 1.0 }, 3);
                Panel::new(area, &of.axis(density), &y, around)?.draw(&elements)?;
            }
        }
        Ok(())
    })
}

#[derive(Clone, Copy)]
enum Variable {
    Phi,
    E,
}

impl Variable {
    fn label(self) -> &'static str {
        match self {
            Self::Phi => "density [1/rad]",
            Self::E => "density",
        }
    }

    fn bins(self, density: &Density) -> &Bins {
        match self {
            Self::Phi => &density.grid.phi,
            Self::E => &density.grid.e,
        }
    }

    fn values(self, density: &Density) -> &[f64] {
        match self {
            Self::Phi => &density.marginal_phi,
            Self::E => &density.marginal_e,
        }
    }

    fn axis(self, density: &Density) -> Axis {
        let bins = self.bins(density);
        match self {
            Self::Phi => phi_axis(bins.low..bins.high, 6),
            Self::E => e_axis(bins.low..bins.high, 6),
        }
    }

    fn curve(self, density: &Density) -> Vec<Point> {
        steps(self.bins(density), self.values(density))
    }

    /// The counting error of `n` samples.
    fn band(self, density: &Density, n: f64) -> Element {
        let bins = self.bins(density);
        let limits = self.values(density).iter().enumerate().flat_map(|(i, &value)| {
            let half = SIGMAS * counting_error(value, n, bins.width());
            [bins.edge(i), bins.edge(i + 1)].map(|x| (x, (value - half).max(0.0), value + half))
        });
        Element::band(&limits.collect::<Vec<_>>(), BAND)
    }
}

/// Standard deviation of a density that was counted from `n` samples in bins of this width.
fn counting_error(density: f64, n: f64, width: f64) -> f64 {
    let p = (density * width).clamp(0.0, 1.0);
    (p * (1.0 - p) / n).sqrt() / width
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_counting_error_is_that_of_a_binomial_count() {
        // 100 samples, half of them in a bin 0.1 wide: the count is 50 ± 5, the density 5 ± 0.5.
        assert!((counting_error(5.0, 100.0, 0.1) - 0.5).abs() < 1e-12);
        assert_eq!(counting_error(0.0, 100.0, 0.1), 0.0);
    }
}
