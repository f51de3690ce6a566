//! Samples that move by a flow map instead of one by one: what `through = "flow-map"` makes of a Monte Carlo case, and
//! what DEE does in space.

use std::f64::consts::{PI, TAU};
use std::fmt::Debug;
use std::ops::Range;

use density::first_passage::empirical::{EmpiricalCurve, curve_of_counts};
use density::flow::{Accuracy, Flow};
use density::flow_map::draw::one_by_one;
use density::flow_map::{self, AngleMap, AngleOrbits, FlowMap, MappedOrbits, Refused, Settings as MapSettings};
use density::gaussian::Gaussian;
use density::grid::Grid;
use density::in_space::SpaceProblem;
use density::in_space::draws::{Distributed, Start};
use density::in_space::task::SpaceTask;
use density::model::Model;
use density::model::plane::PlanarHamiltonian;
use density::model::uncertain_radiation::{Scale, UncertainRadiation};
use density::model::unfolded::{InSpace, Unfolded};
use density::orbits::LostOrbit;
use density::problem_error::ProblemError;
use density::sample_sums::{SampleSums, TooFar};
use density::sampling::{Draws, SamplingPlan, variables_of};
use density::uncertain::{UncertainProblem, UncertainTask};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::problem_key::by_key;

use crate::methods::Misfit;
use crate::methods::map_refusal::{self, Asked, By};

/// A cell of a map is not halved again if fewer than so many samples lie in it: its halves would take about as many
/// orbits.
const LEAST_SAMPLES: f64 = 1000.0;
/// A map is made of at most so many orbits, and of no more than a quarter of the samples.
const MOST_ORBITS: usize = 1_000_000;
/// Orbits that a map may have for any number of samples.
const LEAST_ORBITS: usize = 20_000;
/// Least share of the samples that a map must move.
const LEAST_MAPPED: f64 = 0.5;

/// The error of a map unless it is set.
pub(super) const MAP_ERROR: f64 = 1e-9;

/// Whether a map may be off by so much at most.
pub(super) fn check_map_error(error: f64) -> Result<(), Misfit> {
    if (1e-11..=1e-3).contains(&error) {
        return Ok(());
    }
    Err(Misfit::new("map_error", format!("{error} is not allowed, it must be between 1e-11 and 1e-3")))
}

/// Checks that orbits are accurate enough, to the end of a scenario, for a map with this error.
pub(super) fn check_map_error_over(map_error: f64, assignment: &Assignment) -> Result<(), Failure> {
    let years = assignment.times.last().copied().unwrap_or(0.0);
    flow_map::check_error(map_error, years).map_err(|refused| Failure::Refused(format!("map_error: {refused}")))
}

/// The samples of a case on their way by a map.
#[derive(Debug)]
pub struct MappedSamples {
    cloud: Box<dyn Cloud>,
    critical: f64,
}

/// Orbits of any model.
trait Cloud: Debug + Send {
    fn advance_watching(&mut self, index: usize, critical: f64) -> Result<(), LostOrbit>;
    fn read_out(&self, columns: &mut [f64]);
    fn reduce(&self, grid: &Grid, critical_e: f64) -> Result<SampleSums, TooFar>;
    fn passage_counts(&self, times: &[f64]) -> Vec<u64>;
    /// Number of samples, and of orbits that were propagated for them.
    fn counts(&self) -> (usize, usize);
    /// The estimate of the map's error.
    fn error(&self) -> f64;
}

impl<M: Model, const N: usize> Cloud for MappedOrbits<M, N> {
    fn advance_watching(&mut self, index: usize, critical: f64) -> Result<(), LostOrbit> {
        MappedOrbits::advance_watching(self, index, critical)
    }

    fn read_out(&self, columns: &mut [f64]) {
        self.read_out_columns(&mut columns.chunks_exact_mut(self.len().max(1)).collect::<Vec<_>>());
    }

    fn reduce(&self, grid: &Grid, critical_e: f64) -> Result<SampleSums, TooFar> {
        MappedOrbits::reduce(self, grid, critical_e)
    }

    fn passage_counts(&self, times: &[f64]) -> Vec<u64> {
        MappedOrbits::passage_counts(self, times)
    }

    fn counts(&self) -> (usize, usize) {
        (self.len(), self.map().summary().orbits + self.direct())
    }

    fn error(&self) -> f64 {
        self.map().summary().error
    }
}

impl<M: PlanarHamiltonian> Cloud for AngleOrbits<M> {
    fn advance_watching(&mut self, index: usize, critical: f64) -> Result<(), LostOrbit> {
        AngleOrbits::advance_watching(self, index, critical)
    }

    fn read_out(&self, columns: &mut [f64]) {
        let (phi, e) = columns.split_at_mut(self.len());
        self.read_out_columns(phi, e);
    }

    fn reduce(&self, grid: &Grid, critical_e: f64) -> Result<SampleSums, TooFar> {
        AngleOrbits::reduce(self, grid, critical_e)
    }

    fn passage_counts(&self, times: &[f64]) -> Vec<u64> {
        AngleOrbits::passage_counts(self, times)
    }

    fn counts(&self) -> (usize, usize) {
        (self.len(), self.map().summary().orbits + self.direct())
    }

    fn error(&self) -> f64 {
        self.map().summary().error
    }
}

/// Orbits in space, whose inclinations are read out as 0 or more also at the start.
#[derive(Debug)]
struct InSpaceCloud<C>(C);

impl<C: Cloud> Cloud for InSpaceCloud<C> {
    fn advance_watching(&mut self, index: usize, critical: f64) -> Result<(), LostOrbit> {
        self.0.advance_watching(index, critical)
    }

    fn read_out(&self, columns: &mut [f64]) {
        self.0.read_out(columns);
        let (rest, nodes) = columns.split_at_mut(3 * self.counts().0);
        let inclinations = &mut rest[2 * self.counts().0..];
        for (inclination, node) in inclinations.iter_mut().zip(nodes).filter(|(inclination, _)| **inclination < 0.0) {
            *inclination = -*inclination;
            *node = (*node + PI).rem_euclid(TAU);
        }
    }

    fn reduce(&self, grid: &Grid, critical_e: f64) -> Result<SampleSums, TooFar> {
        self.0.reduce(grid, critical_e)
    }

    fn passage_counts(&self, times: &[f64]) -> Vec<u64> {
        self.0.passage_counts(times)
    }

    fn counts(&self) -> (usize, usize) {
        self.0.counts()
    }

    fn error(&self) -> f64 {
        self.0.error()
    }
}

/// What moves by a map, and how the map is made.
#[derive(Debug, Clone)]
pub struct Mapping {
    /// What the map is made of.
    pub by: By,
    /// The draws.
    pub plan: SamplingPlan,
    /// The numbers of those of this process.
    pub numbers: Range<usize>,
    /// The accuracy of samples that are propagated directly.
    pub accuracy: Accuracy,
    /// What the map may cost, and how far it may be off.
    pub map: MapSettings,
    /// Whether it must know first passages, which takes a finer one where orbits just touch the critical value.
    pub passages: bool,
}

/// A map for so many samples that is off by at most `error`. What it may cost depends on the whole case, so that all
/// shards have the same one.
pub fn map_for(samples: usize, error: f64) -> MapSettings {
    MapSettings {
        error,
        most_orbits: (samples / 4).clamp(LEAST_ORBITS, MOST_ORBITS),
        smallest_share: LEAST_SAMPLES / samples as f64,
        least_mapped: LEAST_MAPPED,
        ..MapSettings::default()
    }
}

impl MappedSamples {
    /// Whether such draws can move by a flow map.
    ///
    /// # Errors
    /// Why not.
    pub fn check(by: By, plan: &SamplingPlan, map_error: f64, assignment: &Assignment) -> Result<(), Failure> {
        let are_plain = plan.draws == Draws::Independent && plan.replicates.get() == 1;
        if assignment.uncertain.is_some() && !are_plain {
            let why = "where the radiation parameter is uncertain, a flow map takes independent draws without replicates alone";
            return Err(Failure::Refused(why.into()));
        }
        if by == By::ActionAngle && assignment.plane.is_none() {
            let why = "by = \"action-angle\" is for scenarios in the plane whose radiation parameter is certain, where every orbit closes; by = \"cells\" \
                       takes every scenario";
            return Err(Failure::Refused(why.into()));
        }
        if assignment.uncertain.is_none() && assignment.in_space.is_none() {
            assignment.plane()?;
        }
        check_map_error_over(map_error, assignment)
    }

    /// The samples at the start.
    ///
    /// # Errors
    /// A map that is refused, or a scenario whose orbits cannot be drawn.
    pub fn new(mapping: Mapping, assignment: &Assignment) -> Result<Self, Failure> {
        let critical = assignment.description.critical;
        Self::check(mapping.by, &mapping.plan, mapping.map.error, assignment)?;
        let asked = Asked { by: mapping.by, may_be_by_angle: assignment.plane.is_some() };
        let cloud = match (&assignment.uncertain, &assignment.in_space) {
            (_, Some(problem)) => {
                let draw = Distributed::of(problem).map(|distributed| distributed.draw(&mapping.plan));
                let refuse = |why: ProblemError| Failure::Refused(by_key(&why));
                problem.perform(InSpaceTask { problem, mapping, draw: draw.map_err(refuse)? }).map_err(refuse)?
            }
            (Some(uncertain), _) => {
                let problem = &uncertain.problem;
                problem.perform(OnLeaves { problem, mapping, times: &assignment.times, critical })
            }
            (None, None) => {
                let problem = &assignment.plane()?.problem;
                let flow = Flow { model: problem.model, accuracy: mapping.accuracy };
                let critical = mapping.passages.then_some(critical);
                let draw = Box::new(mapping.plan.starts(&problem.initial));
                let Mapping { by, numbers, map: settings, .. } = mapping;
                match by {
                    By::Cells => FlowMap::new(flow, problem.initial.into(), &problem.times, critical, &settings)
                        .map(|map| -> Box<dyn Cloud> { Box::new(MappedOrbits::new(map, numbers, draw)) }),
                    By::ActionAngle => AngleMap::new(flow, &problem.initial, &problem.times, critical, &settings)
                        .map(|map| -> Box<dyn Cloud> { Box::new(AngleOrbits::new(map, numbers, draw)) }),
                }
            }
        };
        let cloud = cloud.map_err(|refused| map_refusal::in_words(&refused, asked))?;
        Ok(Self { cloud, critical })
    }

    /// Moves all samples to snapshot `index` and returns how many there are.
    ///
    /// # Errors
    /// The sample that cannot be followed.
    pub fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.cloud.advance_watching(index, self.critical)?;
        Ok(self.samples())
    }

    /// Writes the variables of all samples, one column after the other.
    pub fn write(&self, columns: &mut [f64]) {
        self.cloud.read_out(columns);
    }

    /// The counts and sums of the samples.
    ///
    /// # Errors
    /// A sample that cannot be summed.
    pub fn reduce(&self, grid: &Grid, critical_e: f64) -> Result<SampleSums, TooFar> {
        self.cloud.reduce(grid, critical_e)
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.cloud.counts().0
    }

    /// Orbits that were propagated: those of the map, and the samples that it left.
    pub fn orbits(&self) -> usize {
        self.cloud.counts().1
    }

    /// The estimate of the map's error.
    pub fn error(&self) -> f64 {
        self.cloud.error()
    }

    /// The first-passage curve of the samples.
    pub fn curve(&self, times: &[f64]) -> EmpiricalCurve {
        curve_of_counts(&self.cloud.passage_counts(times), self.samples() as u64, times)
    }
}

/// Makes the samples where the radiation parameter is uncertain.
struct OnLeaves<'a> {
    problem: &'a UncertainProblem,
    mapping: Mapping,
    times: &'a [f64],
    critical: f64,
}

impl UncertainTask for OnLeaves<'_> {
    type Output = Result<Box<dyn Cloud>, Refused>;

    fn with<S: Scale>(self, model: UncertainRadiation<S>) -> Self::Output {
        let Self { problem, mapping, times, critical } = self;
        let flow = Flow { model, accuracy: mapping.accuracy };
        let map = FlowMap::new(flow, problem.gaussian(), times, mapping.passages.then_some(critical), &mapping.map)?;
        let draw = variables_of(&problem.gaussian(), UncertainRadiation::<S>::VARIABLES, mapping.plan.seed);
        Ok(Box::new(MappedOrbits::new(map, mapping.numbers, Box::new(draw))))
    }
}

/// Makes the samples in space.
struct InSpaceTask<'a, D> {
    problem: &'a SpaceProblem,
    mapping: Mapping,
    draw: D,
}

impl<D: Fn(usize) -> Start + Send + Sync + 'static> SpaceTask for InSpaceTask<'_, D> {
    type Output = Result<Box<dyn Cloud>, Refused>;

    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, initial: Gaussian<N>) -> Self::Output {
        let Self { problem, mapping, draw } = self;
        let flow = Flow { model, accuracy: mapping.accuracy };
        let critical = mapping.passages.then_some(problem.critical_e);
        let map = FlowMap::new(flow, initial, &problem.times, critical, &mapping.map)?;
        let variables = move |number: usize| -> [f64; N] {
            let Start { variables, radiation, .. } = draw(number);
            std::array::from_fn(|k| variables.get(k).copied().unwrap_or(radiation))
        };
        Ok(Box::new(InSpaceCloud(MappedOrbits::new(map, mapping.numbers, one_by_one(variables)))))
    }
}
