//! The tables in space, against quasi-Monte Carlo: the density in the solar angle and the eccentricity.

use density::distance::between;
use density::flow::{Accuracy, Flow};
use density::gaussian::Gaussian;
use density::in_space::pilot;
use density::in_space::sampled::Sampled;
use density::in_space::task::SpaceTask;
use density::in_space::{REENTRY, SpaceProblem};
use density::mixture::adaptive::{AdaptiveMixture, Fineness};
use density::mixture::any_model::MixturePropagator;
use density::mixture::component::Component;
use density::mixture::criterion::{Criterion, search};
use density::mixture::library::Library;
use density::mixture::unscented::Unscented;
use density::model::unfolded::{InSpace, Unfolded};
use density::projected::{self, Projection, Question, of_mixture, of_samples};

use crate::space_support::{plan, scenario};
use crate::{COMPONENTS, cell, head, row};

const CLOUDS: [&str; 2] = ["medium", "sun-synchronous"];
const TIMES: [f64; 2] = [3.0, 10.0];
/// Bins along each axis, and orbits of each of the two samples. Their average is the reference.
const BINS: usize = 30;
const ORBITS: usize = 1 << 19;
/// Components of the larger trees of parts.
const LARGER: [usize; 2] = [500, 2_000];

/// The reference of a cloud at each of the times.
struct Reference {
    problem: SpaceProblem,
    projections: Vec<Projection>,
    densities: Vec<Vec<f64>>,
    /// L1 distance between the two samples, half of which is about that of their average from the truth.
    apart: Vec<f64>,
}

impl Reference {
    fn new(name: &str) -> Self {
        let problem = SpaceProblem { times: TIMES.into(), ..scenario(name) };
        let bins = vec![BINS; problem.variables().len()];
        let axes = pilot::axes(&problem, &bins).expect("axes");
        let projections: Vec<Projection> =
            axes.iter().map(|axes| Projection { axes: vec![(0, axes[0]), (1, axes[1])] }).collect();
        let [first, second] = [11, 12].map(|seed| sampled(&problem, &projections, seed));
        let average = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        let densities: Vec<Vec<f64>> = first.iter().zip(&second).map(average).collect();
        let apart = (0..TIMES.len()).map(|k| l1(&first[k], &second[k], &projections[k])).collect();
        Self { problem, projections, densities, apart }
    }

    /// L1 error of a mixture at time number `index`.
    fn error<const N: usize>(&self, index: usize, components: &[Component<N>]) -> f64 {
        let component = |c: &Component<N>| projected::AnyComponent {
            weight: c.weight,
            mean: c.mean.to_vec(),
            covariance: c.covariance.iter().map(|row| row.to_vec()).collect(),
        };
        let components: Vec<projected::AnyComponent> = components.iter().map(component).collect();
        let projection = &self.projections[index];
        let cloud = asked(&self.problem, projection, |question| of_mixture(&components, question));
        l1(&cloud.densities[0], &self.densities[index], projection)
    }
}

fn l1(a: &[f64], b: &[f64], projection: &Projection) -> f64 {
    2.0 * between(a, b, projection.cell()).total_variation
}

fn asked<T>(problem: &SpaceProblem, projection: &Projection, answer: impl FnOnce(&Question<'_>) -> T) -> T {
    let circles: Vec<bool> = problem.variables().iter().map(|variable| variable.is_circle()).collect();
    let projections = std::slice::from_ref(projection);
    answer(&Question { circles: &circles, projections, critical: (REENTRY, problem.critical_e) })
}

/// The densities of a sample of orbits at the times.
fn sampled(problem: &SpaceProblem, projections: &[Projection], seed: u64) -> Vec<Vec<f64>> {
    let sampled = Sampled { problem, simplification: None, plan: plan(seed), accuracy: Accuracy::Coarse };
    let mut cloud = sampled.cloud(0..ORBITS).expect("orbits");
    let mut passed = vec![0; ORBITS];
    let at = |(&time, projection): (&f64, &Projection)| {
        let passages = density::flow::Passages { passages: &mut passed, pending: 0, note: &|_| 1 };
        cloud.advance_watching(time, problem.critical_e, passages).expect("no orbit is lost");
        let mut columns = vec![0.0; problem.variables().len() * ORBITS];
        cloud.read_out(&mut columns);
        let columns: Vec<&[f64]> = columns.chunks_exact(ORBITS).collect();
        asked(problem, projection, |question| of_samples(&columns, question, None)).densities.remove(0)
    };
    TIMES.iter().zip(projections).map(at).collect()
}

/// The table of one cloud.
struct Table<'a>(&'a Reference, &'a [Library]);

impl SpaceTask for Table<'_> {
    type Output = ();

    fn with<M: InSpace<N>, const N: usize>(self, model: Unfolded<M, N>, initial: Gaussian<N>) {
        let Self(reference, libraries) = self;
        let flow = Flow { model, accuracy: Accuracy::Medium };
        let along = |index: usize, direction: [f64; N], library: &Library| {
            let unscented = Unscented::default();
            let mut mixture =
                MixturePropagator::split_along(flow, &initial, unscented, library, direction).expect("a split");
            mixture.advance_to(TIMES[index]).expect("no orbit is lost");
            reference.error(index, &mixture.mixture())
        };
        let tree = |index: usize, components: usize| {
            let fineness = Fineness { components, ..Fineness::default() };
            let unscented = Unscented::default();
            let mut mixture =
                AdaptiveMixture::new(flow, &initial, &[TIMES[index]], unscented, fineness).expect("a tree");
            mixture.advance_to(TIMES[index]).expect("no orbit is lost");
            (mixture.components(), reference.error(index, &mixture.mixture()))
        };
        head(&TIMES, false);
        for criterion in Criterion::ALL {
            let mut cells = vec![format!("`{}`", criterion.name())];
            for (index, &time) in TIMES.iter().enumerate() {
                let direction = search(criterion, flow, &initial, &[time]).expect("a direction").preferred.direction;
                cells.extend(libraries.iter().map(|library| cell(along(index, direction, library))));
            }
            row(&cells);
        }
        let of_criteria = |(components, l1): (usize, f64)| format!("{} ({components})", cell(l1));
        let mut cells = vec!["`adaptive`, at most as many (how many)".to_string()];
        for index in 0..TIMES.len() {
            cells.extend(COMPONENTS.map(|count| of_criteria(tree(index, count))));
        }
        row(&cells);
        for (index, time) in TIMES.iter().enumerate() {
            let single = along(index, std::array::from_fn(|k| f64::from(k == 0)), &Library::unsplit());
            let larger = LARGER.map(|count| of_criteria(tree(index, count))).join(" and ");
            let apart = cell(reference.apart[index]);
            println!(
                "\n{time} yr: one component {}; `adaptive` {larger}; the two samples are {apart} apart",
                cell(single)
            );
        }
    }
}

/// Prints all tables.
pub fn tables(libraries: &[Library]) {
    for name in CLOUDS {
        println!("\n{name}: L1 error of the density in (phi, e) by number of components\n");
        let reference = Reference::new(name);
        reference.problem.perform(Table(&reference, libraries)).expect("an averaged model");
    }
}
