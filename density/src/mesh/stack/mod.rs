//! Carried meshes on top of one another, where the radiation parameter is uncertain.
//!
//! The initial points are a cubic lattice over `phi`, `e` and the third variable, `C` or `ln C` ([`points`]). Its
//! layers are lattices in the plane, each carried by the flow with its own `C`, and each keeps its probability as a
//! carried mesh does ([`super::carried`]). The flow depends on `C` as smoothly as on the start. So the layer of any
//! value of `C` between follows by polynomials through the nearest layers, of the same degree as those between the
//! points of a layer.
//!
//! In each layer a few points to every cell of the lattice follow from the polynomials (`super::quadrature`). Moments
//! are sums over these points. For the joint density each point counts at several places of the part of the cloud for
//! which it stands, and at others in every layer (`super::quadrature`). Means over the third variable
//! are sums over evenly spaced layers (the trapezoidal rule, which for a smooth function under a Gaussian converges
//! faster than any power of the step: Trefethen & Weideman, SIAM Review 56, 2014). The step is halved until moments and
//! joint density stand; where the Gaussian is cut at `C = 0`, the last two sums are combined to Simpson's rule.
//!
//! In cells that the polynomials do not resolve, the points are propagated one by one ([`unresolved`]).
//!
//! Diagnostics are those of a carried mesh: the defect of the measure is taken in the layers halfway between two of the
//! lattice, which are farthest from all points, in the cells where polynomials are used. To it is added twice what the
//! last halving changed the moments by, in standard deviations, and to the misplaced mass twice what it changed the
//! joint density by, with what the local polynomials may misplace. (Where both halves of the layers are off
//! independently of each other, as among orbits that have come apart, the change is about as large as the error of
//! their mean.)
//!
//! | file | idea |
//! |---|---|
//! | `points` | where the characteristics start |
//! | `lattice` | the lattice, its layers where the flow has carried them, and those between them |
//! | `layer` | sums over one layer, and how well its polynomials resolve the flow |
//! | `unresolved` | cells that the polynomials do not resolve, and the orbits in their place |
//! | `figures` | density, moments and diagnostics from the sums of all layers |

mod figures;
mod lattice;
mod layer;
mod points;
mod unresolved;

use rayon::prelude::*;

use self::figures::{Changed, read};
use self::lattice::Carried;
use self::layer::Sums;
use self::unresolved::Unresolved;
use super::quadrature::{Quadrature, Whole};
use super::{MeshDiagnostics, MeshError, check_points};
use crate::angle::{Circular, nearest};
use crate::estimate::Estimate;
use crate::grid::Grid;
use crate::model::plane::State;
use crate::uncertain::ThirdMoments;

pub use self::lattice::Stack;
pub use self::points::{Layers, cubic_lattice, cubic_side, layered_lattice};

/// Largest change of a moment, in standard deviations, by the last halving of the step.
const MOMENTS: f64 = 5e-5;
/// Largest change of the joint density, in total variation.
const JOINT: f64 = 3e-3;
/// Mean resultant length above which a cloud lies on one side of the circle, far from the cut of its branch.
const ON_ONE_SIDE: f64 = 0.9;
/// Largest difference of the circular mean from the angle about which moments are taken \[rad\].
const SAME_CENTRE: f64 = 1e-4;
/// Most halvings of the distance between two layers.
const MOST_HALVINGS: u32 = 3;
/// Layers of which the sums are held at a time.
const BATCH: usize = 16;

/// What is known of a cloud with an uncertain radiation parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct StackEstimate {
    /// Density and moments in `(phi, e)`.
    pub plane: Estimate,
    /// Moments of the third variable.
    pub third: ThirdMoments,
    /// How reliable this is.
    pub diagnostics: MeshDiagnostics,
}

impl Stack {
    /// The density at a snapshot at `time` \[yr\], from the points' present solar angles \[rad\] and eccentricities.
    ///
    /// # Errors
    /// [`MeshError`] if the columns are not those of the stack's points.
    pub fn estimate(&self, phi: &[f64], e: &[f64], grid: &Grid, time: f64) -> Result<StackEstimate, MeshError> {
        check_points(phi, e, self.levels.len() * self.side.pow(2))?;
        let state = |(&phi, &e): (&f64, &f64)| State::from_polar(phi, e);
        let states: Vec<State> = phi.iter().zip(e).map(state).collect();
        let carried = Carried {
            stack: self,
            x1: states.iter().map(|s| s.x1).collect(),
            x2: states.iter().map(|s| s.x2).collect(),
        };
        let direct = Unresolved::find(&carried, time);
        Ok(carried.estimate(grid, &direct))
    }
}

/// What the sums over all layers have in common.
struct Common<'a> {
    grid: &'a Grid,
    centre: [f64; 2],
    start: &'a ThirdMoments,
    direct: &'a Unresolved,
}

/// The sum over all layers of some evenly spaced ones.
#[derive(Debug, Clone)]
struct Total {
    sums: Sums,
    /// Sum of the layers' diagnostics, weighted as the layers are.
    diagnostics: MeshDiagnostics,
    weight: f64,
}

impl Carried<'_> {
    /// Moments are taken about the circular mean of the whole cloud, which the layers of the lattice alone give
    /// roughly: a cloud that reaches round the circle is read once more about the mean that was found.
    fn estimate(&self, grid: &Grid, direct: &Unresolved) -> StackEstimate {
        let gaps = self.stack.levels.len() - 1;
        let whole = |k: usize| self.whole(k as f64, place_of(k, 0), direct).1;
        let wholes = || -> Vec<Whole> { (0..=gaps).into_par_iter().map(whole).collect() };
        let of_lattice = wholes();
        let centre = self.centre(&of_lattice);
        let found = self.about(centre, of_lattice, grid, direct);
        let Circular { mean, resultant } = found.plane.circular;
        if resultant > ON_ONE_SIDE || (nearest(mean, centre[0]) - centre[0]).abs() < SAME_CENTRE {
            return found;
        }
        self.about([mean, found.plane.moments.mean_e], wholes(), grid, direct)
    }

    /// The figures with moments about `centre`; `wholes` are the points of the layers of the lattice.
    fn about(&self, centre: [f64; 2], wholes: Vec<Whole>, grid: &Grid, direct: &Unresolved) -> StackEstimate {
        let Stack { levels, problem, .. } = self.stack;
        let start = ThirdMoments::at_start(problem);
        let gaps = levels.len() - 1;
        let common = Common { grid, centre, start: &start, direct };
        let step = (levels[gaps] - levels[0]) / gaps as f64;
        let ends = |k: usize| if k == 0 || k == gaps { 0.5 } else { 1.0 };
        let at_layers: Vec<Summand> =
            (0..=gaps).map(|k| Summand { position: k as f64, weight: ends(k), place: place_of(k, 0) }).collect();
        let mut sum = self.total(&at_layers, &wholes, &common, false).sums;
        drop(wholes);
        let mut last = read(&sum, step, None, centre, grid);
        let mut judged: Option<MeshDiagnostics> = None;
        let (mut parts, mut changed) = (1usize, Changed::default());
        for halving in 0..MOST_HALVINGS {
            let one = |k: usize| {
                let position = (k as f64 + 0.5) / parts as f64;
                Summand { position, weight: 1.0, place: place_of(k, halving + 1) }
            };
            let between: Vec<Summand> = (0..gaps * parts).map(one).collect();
            let fresh = self.total(&between, &[], &common, halving == 0);
            judged.get_or_insert_with(|| fresh.mean_diagnostics());
            let before = sum.clone();
            sum.add(&fresh.sums, 1.0);
            parts *= 2;
            let finer = step / parts as f64;
            let now = read(&sum, finer, self.stack.is_cut().then_some((&before, 2.0 * finer)), centre, grid);
            changed = Changed::between(&last, &now, &start);
            last = now;
            if changed.moments < MOMENTS && changed.joint < JOINT {
                break;
            }
        }
        let diagnostics = judged.unwrap_or_default();
        let diagnostics = MeshDiagnostics {
            measure_defect: diagnostics.measure_defect + 2.0 * changed.moments,
            misplaced_mass: diagnostics.misplaced_mass + 2.0 * changed.joint + last.misplaced,
            truncated_mass: (1.0 - last.mass / problem.plane.initial.mass_inside()).max(0.0),
            ..diagnostics
        };
        StackEstimate {
            plane: last.plane,
            third: ThirdMoments { with_phi: last.with_third[0], with_e: last.with_third[1], ..start },
            diagnostics,
        }
    }

    /// Circular mean of the solar angle and mean eccentricity, from the layers of the lattice.
    fn centre(&self, wholes: &[Whole]) -> [f64; 2] {
        let mut sum = [0.0; 4];
        for (whole, &z) in wholes.iter().zip(&self.stack.levels) {
            let vector = Quadrature::mean_vector(whole);
            sum.iter_mut().zip(vector).for_each(|(sum, term)| *sum += self.stack.density(z) * term);
        }
        let [total, sin, cos, e] = sum;
        [Circular::from_mean_vector(sin / total, cos / total).mean, e / total]
    }

    /// The states of the layer at a position, and its points, of which some are reached by orbits.
    fn whole(&self, position: f64, place: [f64; 2], direct: &Unresolved) -> ([Vec<f64>; 2], Whole) {
        let Stack { layer, problem, .. } = self.stack;
        let (states, cells) = (self.states(position), direct.at(position));
        let mut whole = layer.whole(&states);
        if !cells.is_empty() {
            let sparse = direct.sparse(place[0]);
            let carry = |starts: &[_]| direct.carry(problem, self.stack.z_at(position), starts);
            layer.quadrature().replace(&mut whole, &cells, sparse, carry);
        }
        (states, whole)
    }

    /// The weighted sum over these layers, and their diagnostics if they are wanted. The layers of the
    /// lattice have their points already.
    fn total(&self, summands: &[Summand], wholes: &[Whole], common: &Common<'_>, is_judged: bool) -> Total {
        let Stack { layer, problem, .. } = self.stack;
        let Common { grid, centre, start, direct } = *common;
        let (mean, sigma) = problem.third();
        let one = |&Summand { position, weight, place }: &Summand| {
            let z = self.stack.z_at(position);
            let (states, whole) = match wholes.get(position as usize) {
                Some(whole) => (self.states(position), whole.clone()),
                None => self.whole(position, place, direct),
            };
            let weight = weight * self.stack.density(z);
            let third = (mean + sigma * z - start.mean, place);
            let diagnostics = match is_judged {
                true => {
                    let rough = self.rough_states(position);
                    layer.judge(&states, rough.as_ref(), grid, direct.of_gap(position as usize))
                }
                false => MeshDiagnostics::default(),
            };
            let sums = layer.sums((&states, whole), grid, centre, problem.plane.critical_e, third);
            (weight, sums, diagnostics)
        };
        let mut total = Total { sums: Sums::zero(grid), diagnostics: MeshDiagnostics::default(), weight: 0.0 };
        for batch in summands.chunks(BATCH) {
            let found: Vec<(f64, Sums, MeshDiagnostics)> = batch.par_iter().map(one).collect();
            found.iter().for_each(|found| total.add(found));
        }
        total
    }
}

/// A layer that is added to the sum over all.
#[derive(Debug, Clone, Copy)]
struct Summand {
    /// Where it is, counted in layers of the lattice.
    position: f64,
    /// Its weight in the rule.
    weight: f64,
    /// Where its points are counted.
    place: [f64; 2],
}

/// Where the points of a layer are counted in the part of the cloud that each stands for: `number` counts the layers of
/// the lattice, or those that a halving adds, which are counted elsewhere. In all of them the places fill the unit
/// square evenly (the additive recurrence by powers of the plastic number, as in [`super::points`]).
fn place_of(number: usize, halving: u32) -> [f64; 2] {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    const OF_HALVING: [f64; 2] = [0.618_033_988_749_895, 0.414_213_562_373_095];
    let steps = [1.0 / PLASTIC, 1.0 / (PLASTIC * PLASTIC)];
    [0, 1].map(|k| (0.5 + number as f64 * steps[k] + f64::from(halving) * OF_HALVING[k]).fract())
}

impl Total {
    fn add(&mut self, (weight, sums, diagnostics): &(f64, Sums, MeshDiagnostics)) {
        self.sums.add(sums, *weight);
        self.weight += weight;
        let (sum, one) = (&mut self.diagnostics, diagnostics);
        sum.elements += one.elements;
        sum.flipped_elements += one.flipped_elements;
        sum.flipped_mass += weight * one.flipped_mass;
        sum.measure_defect += weight * one.measure_defect;
        sum.misplaced_mass += weight * one.misplaced_mass;
    }

    fn mean_diagnostics(&self) -> MeshDiagnostics {
        let MeshDiagnostics { flipped_mass, measure_defect, misplaced_mass, .. } = self.diagnostics;
        let [flipped_mass, measure_defect, misplaced_mass] =
            [flipped_mass, measure_defect, misplaced_mass].map(|sum| sum / self.weight);
        MeshDiagnostics { flipped_mass, measure_defect, misplaced_mass, ..self.diagnostics }
    }
}
