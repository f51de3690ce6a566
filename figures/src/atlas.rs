//! All figures of a run, in the order of the report.

use rayon::prelude::*;

use crate::draw_error::DrawError;
use crate::drawings::{
    accuracy, cloud_evolution, difference, effort, first_passage, joint_density, marginals, moment_errors,
    phase_portrait, probability_above,
};
use crate::figure::Figure;
use crate::scene::{Method, Scene};
use crate::words::reentry;

/// Figures that belong together.
#[derive(Debug)]
pub struct Group {
    /// The part of a name that stays the same from run to run.
    pub key: String,
    /// Its heading.
    pub heading: String,
    /// A text that applies to all of its figures; empty if their captions say everything.
    pub text: &'static str,
    /// How its figures lie.
    pub layout: Layout,
    /// The figures.
    pub figures: Vec<Figure>,
    /// Which figures could not be drawn, and why.
    pub missing: Vec<String>,
}

/// How the figures of a group lie on the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// One below the other.
    Large,
    /// In pairs.
    Pairs,
    /// Small, with one column for each case.
    CaseByCase,
    /// Small, with one column for each case that is compared with the reference.
    OtherByOther,
}

type Job<'a> = Box<dyn Fn() -> Result<Figure, DrawError> + Send + Sync + 'a>;

/// The contents of a group before its figures are drawn.
struct FigurePlan<'a> {
    key: String,
    heading: String,
    text: &'static str,
    layout: Layout,
    jobs: Vec<Job<'a>>,
}

const SEPARATE: &str = "One row per snapshot; the colour scale of a row ends at the peak of the reference, so the cases can be \
                        compared along it. Corresponds to Figs. 4, 11 and 15 of Sun et al. (2022).";
const DIFFERENCES: &str = "Orange: the density is too high, purple: too low. Each map has a scale of its own; mind the numbers \
                           beside it. Not in Sun et al. (2022).";

fn plan<'a>(key: &str, heading: &str, jobs: Vec<Job<'a>>) -> FigurePlan<'a> {
    FigurePlan { key: key.into(), heading: heading.into(), text: "", layout: Layout::Large, jobs }
}

/// The figures of a scenario that show no density.
fn plans<'a>(scene: &'a Scene<'a>) -> Vec<FigurePlan<'a>> {
    let job = |draw: fn(&Scene<'_>) -> Result<Figure, DrawError>| -> Job<'a> { Box::new(move || draw(scene)) };
    let dynamics = scene.plane.map(|_| vec![job(phase_portrait::draw), job(cloud_evolution::draw)]);
    let passage = scene.methods.iter().any(|m| !m.passage.is_empty()).then(|| job(first_passage::draw));
    let probabilities = passage.into_iter().chain([job(probability_above::draw)]).collect();
    let critical = format!("Critical {}", reentry(scene.description).0);
    let compared = |draw| if scene.others().next().is_some() { vec![job(draw)] } else { Vec::new() };
    vec![
        plan("dynamics", "The flow and the cloud", dynamics.unwrap_or_default()),
        plan("passage", &critical, probabilities),
        plan("moment-errors", "Errors of the moments", compared(moment_errors::draw)),
        plan("accuracy", "Accuracy against effort", compared(accuracy::draw)),
        plan("effort-shares", "Where the effort goes", vec![job(effort::draw_shares)]),
    ]
}

/// The figures that show the density of a pair of variables.
fn density_plans<'a>(scene: &'a Scene<'a>) -> Vec<FigurePlan<'a>> {
    if scene.pair.is_none() {
        return Vec::new();
    }
    // A case whose model does not have these variables has no density of them at any time, and no figures.
    let has_any = |m: &&Method<'a>| m.densities.iter().any(|density| !density.is_withheld());
    let stated = || scene.methods.iter().filter(has_any);
    let every = |draw: fn(&Scene<'_>, &Method<'_>) -> Result<Figure, DrawError>, with_reference: bool| {
        let methods = stated().filter(move |m| with_reference || m.label != scene.reference);
        methods.map(|method| -> Job<'a> { Box::new(move || draw(scene, method)) }).collect::<Vec<_>>()
    };
    let indices = || 0..scene.times.len();
    let separate = indices().flat_map(|index| {
        stated().map(move |m| -> Job<'a> { Box::new(move || joint_density::draw_one(scene, m, index)) })
    });
    let differences = indices().flat_map(move |index| {
        let subtracted = difference::subtrahend(scene, index).map(|subtrahend| subtrahend.label);
        // If the exact case withholds its density, another case stands in, and neither of the two has a difference to
        // show.
        let differs =
            move |m: &&Method<'a>| subtracted.is_some_and(|label| label != m.label) && !difference::is_exact(scene, m);
        let others = stated().filter(differs);
        others.map(move |m| -> Job<'a> { Box::new(move || difference::draw(scene, m, index)) })
    });
    let of_pair = |key: &str, heading: &str, jobs| match scene.pair_name() {
        None => plan(key, heading, jobs),
        Some(pair) => plan(&format!("{key}-{}", pair.replace(", ", "-")), &format!("{heading}: {pair}"), jobs),
    };
    let joint = of_pair("joint", "Joint densities, all snapshots in one frame", every(joint_density::draw_all, true));
    let separate = of_pair("separate", "Joint densities, each snapshot by itself", separate.collect());
    let differences = of_pair("differences", "Differences of the joint densities", differences.collect());
    vec![
        FigurePlan { layout: Layout::Pairs, ..joint },
        FigurePlan { layout: Layout::CaseByCase, text: SEPARATE, ..separate },
        FigurePlan { layout: Layout::OtherByOther, text: DIFFERENCES, ..differences },
        of_pair("marginals", "Marginal densities", every(marginals::draw, false)),
    ]
}

/// Draws all figures of a scenario, those of the densities in the pair of variables of `scene` among them, on all
/// threads.
pub fn of_scene(scene: &Scene<'_>) -> Vec<Group> {
    plans(scene).into_par_iter().chain(density_plans(scene)).map(finish).collect()
}

/// Draws the figures of the densities in a further pair of variables.
pub fn of_pair(scene: &Scene<'_>) -> Vec<Group> {
    density_plans(scene).into_par_iter().map(finish).collect()
}

/// Draws the figure that compares the scenarios of the run.
pub fn of_run(scenes: &[Scene<'_>]) -> Group {
    finish(plan("effort", "Effort of the cases", vec![Box::new(|| effort::draw_normalised(scenes))]))
}

fn finish(plan: FigurePlan<'_>) -> Group {
    let FigurePlan { key, heading, text, layout, jobs } = plan;
    let drawn: Vec<Result<Figure, DrawError>> = jobs.into_par_iter().map(|job| job()).collect();
    let (mut figures, mut missing) = (Vec::new(), Vec::new());
    for result in drawn {
        match result {
            Ok(figure) => figures.push(figure),
            Err(error) => missing.push(format!("{heading}: {error}")),
        }
    }
    Group { key, heading, text, layout, figures, missing }
}
