//! DEE: characteristics that carry the density along the flow (Sect. 3.2).

use std::ops::Range;

use density::first_passage::empirical::empirical_curve;
use density::first_passage::passage_times;
use density::mesh::lattice::MOST_DEGREE;
use density::mesh::passage::{PassageCurve, passage_curve};
use density::mesh::{Placement, Points, characteristic_densities, initial_points};
use density::model::registry::Planar;
use density::orbits::Orbits;
use density::problem::Problem;
use messages::content::{Characteristics, Lattice, MOST_RESOLUTION};
use messages::layout::PASSAGE_COLUMNS;
use serde::{Deserialize, Serialize};

use crate::files::input::{Mode, natural_option, positive, positive_option};
use crate::files::toml_words::{choice, choice_option};
use crate::methods::accuracy::AccuracySetting;
use crate::methods::course::Course;
use crate::methods::{Method, Misfit};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};

/// Where the characteristics start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PlacementChoice {
    /// Random draws from the initial Gaussian, as in the paper.
    Random,
    /// A square lattice.
    Lattice,
    /// A low-discrepancy sequence through the initial Gaussian.
    LowDiscrepancy,
}

/// How scattered densities become a density on the grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MeshChoice {
    /// Triangles of the initial points, carried by the flow, each with its probability.
    Carried,
    /// Delaunay triangulation of the final points and linear interpolation, as in the paper.
    Hull,
}

/// Settings of a DEE case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Number of characteristics; on a lattice the largest square number up to it.
    #[serde(deserialize_with = "positive")]
    pub samples: usize,
    /// Seed of points that are not on a lattice; 1 unless set.
    #[serde(deserialize_with = "natural_option", skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Where the characteristics start; by default on a lattice, in mode `as-printed` at random points.
    #[serde(deserialize_with = "choice_option", skip_serializing_if = "Option::is_none")]
    pub placement: Option<PlacementChoice>,
    /// How the density is computed; by default on a carried mesh, in mode `as-printed` on a hull mesh.
    #[serde(deserialize_with = "choice_option", skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshChoice>,
    /// Interpolation points per axis of a hull mesh, the paper's Ngrid; 5000 unless set.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub resolution: Option<usize>,
    /// Degree to which a lattice interpolates between its points; 1 is linear. Unless set, it is 7, or the largest
    /// that fits.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub degree: Option<usize>,
    /// Corrected, or as the paper printed it: without the Jacobian, random points, hull interpolation.
    #[serde(deserialize_with = "choice")]
    pub mode: Mode,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

/// Degree of a lattice that is large enough for it, unless set.
const USUAL_DEGREE: usize = 7;

/// Why a lattice with `side` points per side cannot have the degree `degree`.
fn degree_problem(degree: usize, side: usize) -> String {
    if degree > MOST_DEGREE {
        return format!("{degree} is not allowed, it must be at most {MOST_DEGREE}");
    }
    let (least, most) = ((degree + 1).pow(2), side - 1);
    format!(
        "{degree} does not fit a lattice of {side} points a side; it must be at most {most}, or samples at least {least}"
    )
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            samples: 100_000,
            seed: None,
            placement: None,
            mesh: None,
            resolution: None,
            degree: None,
            mode: Mode::default(),
            accuracy: None,
        }
    }
}

impl Settings {
    /// Whether all that is set changes something.
    fn check_effects(&self) -> Result<(), Misfit> {
        let on_lattice = self.placement() == Placement::Lattice;
        let carried = self.mesh() == MeshChoice::Carried;
        if self.seed.is_some() && on_lattice {
            return Err(Misfit::no_effect("seed", "where the points are on a lattice (placement = \"lattice\")"));
        }
        if self.degree.is_some() && !on_lattice {
            return Err(Misfit::no_effect("degree", "where the points are not on a lattice"));
        }
        if self.resolution.is_some() && carried {
            return Err(Misfit::no_effect("resolution", "where the mesh is carried; it is that of mesh = \"hull\""));
        }
        if self.mode == Mode::AsPrinted && self.placement.is_some() && carried {
            return Err(Misfit::no_effect("mode", "beside placement and mesh = \"carried\""));
        }
        Ok(())
    }

    fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    fn resolution(&self) -> usize {
        self.resolution.unwrap_or(5000)
    }

    /// Points per side of a lattice.
    fn side(&self) -> usize {
        self.samples.isqrt()
    }

    /// The degree that is set; else `USUAL_DEGREE`, or the largest that fits if the lattice is smaller.
    fn degree(&self) -> usize {
        self.degree.unwrap_or_else(|| USUAL_DEGREE.min(self.side().saturating_sub(1)).max(1))
    }

    fn placement_choice(&self) -> PlacementChoice {
        self.placement.unwrap_or(match self.mode {
            Mode::Corrected => PlacementChoice::Lattice,
            Mode::AsPrinted => PlacementChoice::Random,
        })
    }

    fn placement(&self) -> Placement {
        match self.placement_choice() {
            PlacementChoice::Random => Placement::Random,
            PlacementChoice::Lattice => Placement::Lattice,
            PlacementChoice::LowDiscrepancy => Placement::LowDiscrepancy,
        }
    }

    fn mesh(&self) -> MeshChoice {
        self.mesh.unwrap_or(match self.mode {
            Mode::Corrected => MeshChoice::Carried,
            Mode::AsPrinted => MeshChoice::Hull,
        })
    }
}

impl Method for Settings {
    const NAME: &'static str = "dee";
    type Propagator = DensityEvolution;

    fn propagator(self) -> DensityEvolution {
        DensityEvolution::new(self)
    }

    fn check(&self) -> Result<(), Misfit> {
        self.check_effects()?;
        let (side, resolution, degree) = (self.side(), self.resolution(), self.degree());
        if self.samples < 4 {
            return Err(Misfit::new(
                "samples",
                format!("{} are too few for a mesh; it needs at least 4", self.samples),
            ));
        }
        if resolution > MOST_RESOLUTION as usize {
            let problem = format!("{resolution} is too fine; it must be at most {MOST_RESOLUTION}");
            return Err(Misfit::new("resolution", problem));
        }
        if self.placement() == Placement::Lattice && (degree > MOST_DEGREE || degree >= side) {
            return Err(Misfit::new("degree", degree_problem(degree, side)));
        }
        Ok(())
    }

    fn check_bins(&self, (phi, e): (usize, usize)) -> Result<(), Misfit> {
        let (resolution, bins) = (self.resolution(), phi.max(e));
        if self.mesh() == MeshChoice::Carried || resolution >= bins {
            return Ok(());
        }
        let problem =
            format!("{resolution} is coarser than the {bins} bins of the comparison grid; it must be at least {bins}");
        Err(Misfit::new("resolution", problem))
    }

    fn resolved(&self) -> Self {
        let (on_lattice, hull) = (self.placement() == Placement::Lattice, self.mesh() == MeshChoice::Hull);
        Self {
            seed: (!on_lattice).then(|| self.seed()),
            placement: Some(self.placement_choice()),
            mesh: Some(self.mesh()),
            resolution: hull.then(|| self.resolution()),
            degree: on_lattice.then(|| self.degree()),
            mode: if hull { self.mode } else { Mode::Corrected },
            ..self.clone()
        }
    }

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, _: (usize, usize)) -> usize {
        self.samples.saturating_mul(3)
    }

    fn rows_to_share(&self) -> Result<usize, String> {
        Ok(self.samples.isqrt().pow(2))
    }
}

/// The DEE propagator.
#[derive(Debug)]
pub struct DensityEvolution {
    settings: Settings,
    shard: Shard,
    work: Option<Work>,
}

/// The characteristics of the scenario under way.
#[derive(Debug)]
struct Work {
    problem: Problem<Planar>,
    /// The initial points of the whole case.
    start: Points,
    /// The points that this process propagates.
    range: Range<usize>,
    course: Course,
    densities: Vec<f64>,
}

impl DensityEvolution {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, shard: Shard::WHOLE, work: None }
    }
}

impl Propagator for DensityEvolution {
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        self.shard = shard;
        Ok(())
    }

    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let problem = &assignment.plane()?.problem;
        let Settings { samples, mode, accuracy, .. } = self.settings;
        let (seed, resolution, degree) = (self.settings.seed(), self.settings.resolution(), self.settings.degree());
        let start = initial_points(problem, samples, self.settings.placement(), seed)?;
        let range = self.shard.part(start.phi.len())?;
        let flow = AccuracySetting::flow(accuracy, problem.model);
        let orbits = Orbits::from_polar(flow, &start.phi[range.clone()], &start.e[range.clone()]);
        let form = Form {
            content: match self.settings.mesh() {
                MeshChoice::Carried => {
                    let lattice = start.lattice.map(|side| Lattice { side: side as u32, degree: degree as u32 });
                    Characteristics::CarriedMesh { lattice }
                }
                MeshChoice::Hull => {
                    Characteristics::HullMesh { resolution: resolution as u32, as_printed: mode == Mode::AsPrinted }
                }
            }
            .into(),
            most_rows: orbits.len(),
            total_rows: start.phi.len(),
        };
        let course = Course::new(orbits, range.start, problem);
        self.work = Some(Work { problem: problem.clone(), start, range, course, densities: Vec::new() });
        Ok(form)
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let work = self.work.as_mut().ok_or_else(Failure::no_scenario)?;
        let rows = work.course.advance(index)?;
        let orbits = &work.course.orbits;
        let with_jacobian = self.settings.mode == Mode::Corrected;
        let [phi, e] = [&work.start.phi, &work.start.e].map(|column| &column[work.range.clone()]);
        work.densities =
            characteristic_densities(&work.problem.initial, phi, e, orbits.x1(), orbits.x2(), with_jacobian)?;
        Ok(rows)
    }

    fn write(&self, columns: &mut [f64]) {
        let Some(work) = &self.work else { return };
        let [phi, e, n] = Characteristics::columns(columns);
        work.course.orbits.read_out(phi, e);
        n.copy_from_slice(&work.densities);
    }

    /// The curve follows from the flow that a lattice interpolates, or from scattered characteristics, which all have
    /// equal weight. Only the first shard computes it, from all points of the case.
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        if self.shard.index > 0 {
            return Ok(Passage::Cannot("the first shard computes it for all".into()));
        }
        let work = self.work.as_ref().ok_or_else(Failure::no_scenario)?;
        let flow = work.course.orbits.flow;
        if work.start.lattice.is_some() {
            let curve = passage_curve(&work.problem, &flow, &work.start, self.settings.degree(), times)?;
            return Ok(Passage::Curve(rows(&curve, times)));
        }
        let start = Orbits::from_polar(flow, &work.start.phi, &work.start.e);
        let end = times.last().copied().unwrap_or(0.0);
        let passages = passage_times(&flow, start.x1(), start.x2(), work.problem.critical_e, end)?;
        let mut curve = empirical_curve(&passages, None, times);
        curve.interval = None;
        Ok(Passage::Curve(Passage::rows(&curve)))
    }
}

/// The rows of a curve that estimates its own error. An orbit that has passed stays so: the lower end of an interval
/// is therefore not below that of an earlier time, and the upper end is not above that of a later time.
fn rows(curve: &PassageCurve, times: &[f64]) -> Vec<[f64; PASSAGE_COLUMNS]> {
    let row = |((&time, &p), &error): ((&f64, &f64), &f64)| [time, p, (p - error).max(0.0), (p + error).min(1.0)];
    let mut rows: Vec<_> = times.iter().zip(&curve.probability).zip(&curve.error).map(row).collect();
    for k in 1..rows.len() {
        rows[k][2] = rows[k][2].max(rows[k - 1][2]);
    }
    for k in (1..rows.len()).rev() {
        rows[k - 1][3] = rows[k - 1][3].min(rows[k][3]);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(text: &str) -> Settings {
        toml::from_str(text).unwrap()
    }

    #[test]
    fn a_setting_that_changes_nothing_is_refused_by_name() {
        for (text, key) in [
            ("seed = 2", "seed"),
            ("resolution = 500", "resolution"),
            ("placement = \"random\"\ndegree = 3", "degree"),
            ("mode = \"as-printed\"\ndegree = 3", "degree"),
            ("mode = \"as-printed\"\nmesh = \"carried\"\nresolution = 500", "resolution"),
            ("mode = \"as-printed\"\nmesh = \"carried\"\nplacement = \"lattice\"", "mode"),
        ] {
            let misfit = settings(text).check().unwrap_err();
            assert!(misfit.key == key && misfit.problem.contains("has no effect"), "{text}: {misfit}");
        }
        for good in [
            "placement = \"random\"\nseed = 2",
            "mesh = \"hull\"\nresolution = 500\ndegree = 3",
            "mode = \"as-printed\"",
        ] {
            settings(good).check().unwrap();
        }
    }

    #[test]
    fn what_is_recorded_is_what_has_an_effect_and_means_the_same() {
        for (text, lines) in [
            ("", "samples = 100000\nplacement = \"lattice\"\nmesh = \"carried\"\ndegree = 7\nmode = \"corrected\"\n"),
            (
                "mode = \"as-printed\"",
                "samples = 100000\nseed = 1\nplacement = \"random\"\nmesh = \"hull\"\nresolution = 5000\nmode = \"as-printed\"\n",
            ),
            (
                "mode = \"as-printed\"\nmesh = \"carried\"",
                "samples = 100000\nseed = 1\nplacement = \"random\"\nmesh = \"carried\"\nmode = \"corrected\"\n",
            ),
        ] {
            let resolved = settings(text).resolved();
            assert_eq!(toml::to_string(&resolved).unwrap(), lines);
            resolved.check().unwrap();
            assert_eq!(settings(lines).resolved(), resolved);
        }
    }

    #[test]
    fn the_degree_that_is_not_set_is_the_largest_that_fits_up_to_the_usual_one() {
        for (samples, degree) in [(4, 1), (9, 2), (16, 3), (63, 6), (64, 7), (1_000_000, 7)] {
            let small = settings(&format!("samples = {samples}"));
            small.check().unwrap();
            assert_eq!(small.resolved().degree, Some(degree), "{samples}");
        }
        for (text, words) in [
            (
                "samples = 16\ndegree = 7",
                "does not fit a lattice of 4 points a side; it must be at most 3, or samples at least 64",
            ),
            ("degree = 12", "12 is not allowed, it must be at most 11"),
        ] {
            let misfit = settings(text).check().unwrap_err();
            assert!(misfit.key == "degree" && misfit.problem.contains(words), "{misfit}");
        }
        assert_eq!(settings("samples = 3").check().unwrap_err().key, "samples");
    }

    #[test]
    fn a_hull_is_not_read_more_finely_than_it_is_interpolated() {
        let hull = settings("mesh = \"hull\"\nresolution = 120");
        assert!(hull.check_bins((120, 100)).is_ok() && hull.check_bins((100, 121)).is_err());
        assert!(settings("").check_bins((2000, 2000)).is_ok());
    }
}
