//! DEE: characteristics that carry the density along the flow (Sect. 3.2).

mod in_space;
mod layers;
mod passage_rows;
mod settings;

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
use messages::layout::GIVEN_COLUMNS;

use crate::files::input::Mode;
use crate::methods::accuracy::AccuracySetting;
use crate::methods::course::Course;
use crate::methods::{Method, Misfit};
use in_space::InSpace;
use kit::assignment::{Assignment, Uncertain};
use kit::failure::Failure;
use kit::passage::given_row;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};
use layers::LayersWork;
use passage_rows::rows;
use settings::{LAYERS, POINTS, degree_problem};
pub use settings::{MeshChoice, PlacementChoice, Settings};

/// The DEE propagator.
#[derive(Debug)]
pub struct DensityEvolution {
    settings: Settings,
    shard: Shard,
    work: Option<Work>,
    /// What the last first-passage curve says of an uncertain radiation parameter.
    given: Vec<[f64; GIVEN_COLUMNS]>,
}

/// The scenario under way.
#[derive(Debug)]
enum Work {
    Plane(Box<PlaneWork>),
    InSpace(Box<InSpace>),
    /// The radiation parameter is uncertain.
    Layers(Box<LayersWork>),
}

/// The characteristics of a scenario in the plane.
#[derive(Debug)]
struct PlaneWork {
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
        Self { settings, shard: Shard::WHOLE, work: None, given: Vec::new() }
    }
}

impl Method for Settings {
    const NAME: &'static str = "dee";
    type Propagator = DensityEvolution;

    fn propagator(self) -> DensityEvolution {
        DensityEvolution::new(self)
    }

    fn check_scenario(&self, assignment: &Assignment, shard: Shard) -> Result<(), Failure> {
        if assignment.in_space.is_some() {
            return self.check_in_space(shard);
        }
        match assignment.uncertain.is_some() {
            true => self.check_layers().map(drop).map_err(Failure::Refused),
            false => assignment.plane().map(drop),
        }
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

    fn most_numbers(&self, _: (usize, usize), variables: usize) -> usize {
        match variables {
            0..=2 => self.samples.saturating_mul(3),
            3 => self.samples.saturating_mul(LAYERS).saturating_mul(4),
            _ => POINTS.saturating_mul(variables),
        }
    }

    fn rows_to_share(&self) -> Result<usize, String> {
        Ok(self.samples.isqrt().pow(2))
    }
}

impl Propagator for DensityEvolution {
    fn take_shard(&mut self, shard: Shard) -> Result<(), Failure> {
        self.shard = shard;
        Ok(())
    }

    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        self.work = None;
        if let Some(problem) = &assignment.in_space {
            let (work, form) = InSpace::new(problem, &self.settings, self.shard, assignment)?;
            self.work = Some(Work::InSpace(Box::new(work)));
            return Ok(form);
        }
        if let Some(Uncertain { problem, .. }) = &assignment.uncertain {
            let accuracy = self.settings.accuracy.unwrap_or_default().0;
            let work = LayersWork::new(problem, &self.settings, accuracy, |total| self.shard.part(total))?;
            let content = Characteristics::CarriedMesh { lattice: Some(work.lattice()) }.into();
            let form = Form { content, most_rows: work.rows(), total_rows: work.total() };
            self.work = Some(Work::Layers(Box::new(work)));
            return Ok(form);
        }
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
        let work = PlaneWork { problem: problem.clone(), start, range, course, densities: Vec::new() };
        self.work = Some(Work::Plane(Box::new(work)));
        Ok(form)
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        let work = match self.work.as_mut().ok_or_else(Failure::no_scenario)? {
            Work::InSpace(work) => return work.advance(index),
            Work::Layers(work) => return work.advance(index),
            Work::Plane(work) => work,
        };
        let rows = work.course.advance(index)?;
        let orbits = &work.course.orbits;
        let with_jacobian = self.settings.mode == Mode::Corrected;
        let [phi, e] = [&work.start.phi, &work.start.e].map(|column| &column[work.range.clone()]);
        work.densities =
            characteristic_densities(&work.problem.initial, phi, e, orbits.x1(), orbits.x2(), with_jacobian)?;
        Ok(rows)
    }

    fn write(&self, columns: &mut [f64]) {
        let work = match &self.work {
            Some(Work::Plane(work)) => work,
            Some(Work::InSpace(work)) => return work.write(columns),
            Some(Work::Layers(work)) => return work.write(columns),
            None => return,
        };
        let [phi, e, n] = Characteristics::columns(columns);
        work.course.orbits.read_out(phi, e);
        n.copy_from_slice(&work.densities);
    }

    fn trajectories(&self) -> u64 {
        match &self.work {
            Some(Work::InSpace(work)) => work.trajectories(),
            _ => 0,
        }
    }

    fn trajectory_error(&self) -> f64 {
        match &self.work {
            Some(Work::InSpace(work)) => work.error(),
            _ => 0.0,
        }
    }

    /// The curve follows from the flow that a lattice interpolates, or from scattered characteristics, which all have
    /// equal weight. Only the first shard computes it, from all points of the case.
    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        self.given.clear();
        let cannot = |why: &str| Ok(Passage::Cannot(why.into()));
        let work = match self.work.as_ref().ok_or_else(Failure::no_scenario)? {
            Work::InSpace(_) => {
                return cannot(
                    "in space the characteristics say where points are at the snapshots, not where they have been between; take qmc",
                );
            }
            _ if self.shard.index > 0 => return cannot("the first shard computes it for all"),
            Work::Layers(work) => {
                let passed = work.passed(times)?;
                self.given = passed.iter().map(|p| given_row([p.radiation_if_passed, p.radiation_if_not])).collect();
                let (probability, error) = passed.iter().map(|p| (p.probability.value, p.probability.error)).unzip();
                return Ok(Passage::Curve(rows(&PassageCurve { probability, error }, times)));
            }
            Work::Plane(work) => work,
        };
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

    fn given_re_entry(&self) -> Vec<[f64; GIVEN_COLUMNS]> {
        self.given.clone()
    }
}
