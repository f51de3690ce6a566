//! DEE: characteristics that carry the density along the flow (Sect. 3.2).

use std::ops::Range;

use density::first_passage::empirical::empirical_curve;
use density::first_passage::passage_times;
use density::mesh::lattice::MOST_DEGREE;
use density::mesh::passage::{PassageCurve, passage_curve};
use density::mesh::{Placement, Points, characteristic_densities, initial_points};
use density::orbits::Orbits;
use density::problem::Problem;
use messages::layout::{PASSAGE_COLUMNS, kind, treatment};
use serde::{Deserialize, Serialize};

use crate::accuracy::AccuracySetting;
use crate::assignment::Assignment;
use crate::course::Course;
use crate::failure::Failure;
use crate::input::{Mode, positive};
use crate::kit::{Form, Passage, Propagator};
use crate::shard::Shard;
use crate::snapshot_rules::MOST_RESOLUTION;

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
    /// Seed of random draws.
    pub seed: u64,
    /// Where the characteristics start; by default on a lattice, as printed random.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placement: Option<PlacementChoice>,
    /// How the density is put together; by default carried, as printed by hull.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshChoice>,
    /// Interpolation points an axis of a hull mesh, the paper's Ngrid.
    #[serde(deserialize_with = "positive")]
    pub resolution: usize,
    /// Degree to which a carried lattice interpolates the flow between its points; 1 is linear.
    #[serde(deserialize_with = "positive")]
    pub degree: usize,
    /// Corrected, or as the paper printed it: without the Jacobian, random points, hull interpolation.
    pub mode: Mode,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            samples: 100_000,
            seed: 1,
            placement: None,
            mesh: None,
            resolution: 5000,
            degree: 7,
            mode: Mode::default(),
            accuracy: None,
        }
    }
}

impl Settings {
    /// Whether the settings go together.
    pub(crate) fn check(&self) -> Result<(), String> {
        let side = self.samples.isqrt();
        if self.samples < 4 {
            return Err(format!("samples = {} are too few for a mesh; it needs at least 4", self.samples));
        }
        if self.resolution > MOST_RESOLUTION {
            return Err(format!("resolution = {} is too fine; it must be at most {MOST_RESOLUTION}", self.resolution));
        }
        if self.degree > MOST_DEGREE || (self.placement() == Placement::Lattice && self.degree >= side) {
            return Err(format!(
                "degree = {} does not fit; it must be at most {MOST_DEGREE} and less than the {side} points a side",
                self.degree
            ));
        }
        Ok(())
    }

    fn placement(&self) -> Placement {
        let choice = self.placement.unwrap_or(match self.mode {
            Mode::Corrected => PlacementChoice::Lattice,
            Mode::AsPrinted => PlacementChoice::Random,
        });
        match choice {
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

/// The DEE propagator.
#[derive(Debug)]
pub struct DensityEvolution {
    settings: Settings,
    shard: Shard,
    work: Option<Work>,
}

/// Characteristics on their way.
#[derive(Debug)]
struct Work {
    problem: Problem,
    /// All of the case.
    start: Points,
    /// Those that are propagated here.
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
        let problem = &assignment.problem;
        let Settings { samples, seed, resolution, degree, mode, accuracy, .. } = self.settings;
        let start = initial_points(problem, samples, self.settings.placement(), seed)?;
        let range = self.shard.part(start.phi.len())?;
        let flow = AccuracySetting::flow(accuracy, problem.force);
        let orbits = Orbits::from_polar(flow, &start.phi[range.clone()], &start.e[range.clone()]);
        let form = Form {
            kind: kind::CHARACTERISTICS,
            most_rows: orbits.len(),
            total_rows: start.phi.len(),
            treatment: match (self.settings.mesh(), mode) {
                (MeshChoice::Carried, _) => treatment::CARRIED_MESH,
                (MeshChoice::Hull, Mode::Corrected) => treatment::HULL_MESH,
                (MeshChoice::Hull, Mode::AsPrinted) => treatment::HULL_MESH_AS_PRINTED,
            },
            resolution: resolution as u32,
            degree: degree as u32,
            lattice: start.lattice.unwrap_or(0) as u32,
            ..Form::default()
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
            characteristic_densities(&work.problem.initial, phi, e, &orbits.x1, &orbits.x2, with_jacobian)?;
        Ok(rows)
    }

    fn write(&self, columns: &mut [f64]) {
        let Some(work) = &self.work else { return };
        let (phi, rest) = columns.split_at_mut(work.course.orbits.len());
        let (e, n) = rest.split_at_mut(work.course.orbits.len());
        work.course.orbits.read_out(phi, e);
        n.copy_from_slice(&work.densities);
    }

    /// Of the flow that a lattice interpolates, or of scattered characteristics, which all weigh alike; all of them, in the first
    /// shard alone.
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        if self.shard.index > 0 {
            return Ok(Passage::Cannot("the first shard computes it for all".into()));
        }
        let work = self.work.as_ref().ok_or_else(Failure::no_scenario)?;
        let flow = work.course.orbits.flow;
        if work.start.lattice.is_some() {
            let curve = passage_curve(&work.problem, &flow, &work.start, self.settings.degree, times)?;
            return Ok(Passage::Curve(rows(&curve, times)));
        }
        let start = Orbits::from_polar(flow, &work.start.phi, &work.start.e);
        let end = times.last().copied().unwrap_or(0.0);
        let passages = passage_times(&flow, &start.x1, &start.x2, work.problem.critical_e, end)?;
        let mut curve = empirical_curve(&passages, None, times);
        curve.interval = None;
        Ok(Passage::Curve(Passage::rows(&curve)))
    }
}

/// The rows of a curve that estimates its own error.
fn rows(curve: &PassageCurve, times: &[f64]) -> Vec<[f64; PASSAGE_COLUMNS]> {
    let row = |((&time, &p), &error): ((&f64, &f64), &f64)| [time, p, (p - error).max(0.0), (p + error).min(1.0)];
    times.iter().zip(&curve.probability).zip(&curve.error).map(row).collect()
}
