//! GMM-UT: a Gaussian mixture whose components are moved by the unscented transform (Sect. 3.3).

mod course;
mod split_choice;

use density::mixture::adaptive::Fineness;
use density::mixture::library::{self, Variance};
use density::mixture::plan::{Adaptive, LEAST_POINTS};
use density::mixture::unscented::Unscented;
use density::mixture::{self, Split};
use messages::content::{self, Content, Kind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::files::input::{Mode, positive_option};
use crate::files::toml_words::{choice, choice_option};
use crate::methods::accuracy::AccuracySetting;
use crate::methods::{Method, Misfit};
use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::problem_key::by_key;
use kit::shard::Shard;
use kit::{Form, Passage, Propagator};

use course::{Course, InPlane, Planned};

pub use split_choice::SplitChoice;

/// `sigma_points` is multiplied by this to give the most components of a mixture over so many variables. In space
/// orbits take ten times as long, and clouds of satellites are right with a few thousand.
const fn allowance(variables: usize) -> usize {
    if variables == 3 { 12 } else { 1 }
}

/// Settings of a GMM-UT case.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// How the initial Gaussian is split; in mode `as-printed` along the eccentricity unless set.
    #[serde(deserialize_with = "choice_option", skip_serializing_if = "Option::is_none")]
    pub split: Option<SplitChoice>,
    /// Components along the direction of a split that is not adaptive; odd, 39 unless set.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub components: Option<usize>,
    /// Components across that direction; odd, 1 unless set.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub across: Option<usize>,
    /// Whether the library of a split that is not adaptive keeps the variance exactly; false unless set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_variance: Option<bool>,
    /// Most sigma points of an adaptive split; with a third variable a twelfth of its most components, in space that
    /// number.
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub sigma_points: Option<usize>,
    /// Most components that are published; if there are more, they are merged, which keeps mean and covariance
    /// (slow).
    #[serde(deserialize_with = "positive_option", skip_serializing_if = "Option::is_none")]
    pub merge_to: Option<usize>,
    /// Corrected, or as the paper printed it.
    #[serde(deserialize_with = "choice")]
    pub mode: Mode,
    /// How accurately orbits are propagated; the launch file's `accuracy` unless set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracySetting>,
}

impl Settings {
    /// Whether the settings are for a mixture in more than two variables.
    fn check_beyond_plane(&self) -> Result<(), Failure> {
        if self.split() == SplitChoice::Adaptive && self.merge_to.is_none() && self.mode == Mode::Corrected {
            return Ok(());
        }
        let why = "where the radiation parameter is uncertain, and in space, gmm-ut takes split = \"adaptive\" in mode = \"corrected\" \
                   without merge_to alone";
        Err(Failure::Refused(why.into()))
    }

    fn components(&self) -> usize {
        self.components.unwrap_or(39)
    }

    fn across(&self) -> usize {
        self.across.unwrap_or(1)
    }

    fn keeps_variance(&self) -> bool {
        self.keep_variance.unwrap_or(false)
    }

    fn sigma_points(&self) -> usize {
        self.sigma_points.unwrap_or(Adaptive::default().sigma_points)
    }

    /// The most components that a mixture can have.
    pub fn most_components(&self) -> usize {
        match self.split() {
            SplitChoice::Adaptive => self.sigma_points(),
            _ => self.components().saturating_mul(self.across()),
        }
    }

    fn split(&self) -> SplitChoice {
        self.split.unwrap_or(match self.mode {
            Mode::Corrected => SplitChoice::Adaptive,
            Mode::AsPrinted => SplitChoice::Eccentricity,
        })
    }

    /// The same in the terms of science.
    fn for_mixture(&self) -> mixture::MixtureSettings {
        let variance = if self.keeps_variance() { Variance::Kept } else { Variance::Free };
        let library = |along| Split::Library { along, components: self.components(), across: self.across(), variance };
        let planned = || Split::Adaptive(Adaptive { sigma_points: self.sigma_points(), ..Adaptive::default() });
        let split = self.split().direction().map_or_else(planned, library);
        let unscented = match self.mode {
            Mode::AsPrinted => Unscented::PAPER,
            Mode::Corrected => Unscented::default(),
        };
        mixture::MixtureSettings { split, unscented }
    }
}

impl Method for Settings {
    const NAME: &'static str = "gmm-ut";
    type Propagator = GaussianMixture;

    fn propagator(self) -> GaussianMixture {
        GaussianMixture::new(self)
    }

    fn check_scenario(&self, assignment: &Assignment, _: Shard) -> Result<(), Failure> {
        match assignment.in_space.is_some() || assignment.uncertain.is_some() {
            true => self.check_beyond_plane(),
            false => assignment.plane().map(drop),
        }
    }

    fn check(&self) -> Result<(), Misfit> {
        let adaptive = self.split() == SplitChoice::Adaptive;
        let of_library = [
            ("components", self.components.is_some()),
            ("across", self.across.is_some()),
            ("keep_variance", self.keep_variance.is_some()),
        ];
        if let Some((key, _)) = of_library.into_iter().find(|(_, is_set)| adaptive && *is_set) {
            let because =
                "beside split = \"adaptive\", which plans its components itself; set sigma_points, or another split";
            return Err(Misfit::no_effect(key, because));
        }
        if self.split() == SplitChoice::Both && self.across() == 1 {
            let problem = "is needed beside split = \"both\": how many components along phi, 3 or more; with one of them \
                           the split is \"eccentricity\"";
            return Err(Misfit::new("across", problem));
        }
        if self.sigma_points.is_some() && !adaptive {
            return Err(Misfit::no_effect("sigma_points", "on a split that is not adaptive; set components"));
        }
        for (key, count) in [("components", self.components()), ("across", self.across())] {
            if count % 2 == 0 || count > library::MOST {
                let problem = format!("{count} is not allowed, it must be an odd number up to {}", library::MOST);
                return Err(Misfit::new(key, problem));
            }
        }
        if adaptive && self.sigma_points() < LEAST_POINTS {
            let problem =
                format!("{} are too few to plan a split with, it must be at least {LEAST_POINTS}", self.sigma_points());
            return Err(Misfit::new("sigma_points", problem));
        }
        let most = self.most_components();
        if self.merge_to.is_some_and(|merge_to| merge_to >= most) {
            let because = format!("where the mixture has at most {most} components, none of which are merged");
            return Err(Misfit::no_effect("merge_to", &because));
        }
        if self.keep_variance.is_some() && most == 1 {
            return Err(Misfit::no_effect("keep_variance", "on a single component, whose variance is kept anyway"));
        }
        Ok(())
    }

    fn resolved(&self) -> Self {
        let adaptive = self.split() == SplitChoice::Adaptive;
        let of_library = !adaptive;
        Self {
            split: Some(self.split()),
            components: of_library.then(|| self.components()),
            across: of_library.then(|| self.across()),
            keep_variance: (of_library && self.most_components() > 1).then(|| self.keeps_variance()),
            sigma_points: adaptive.then(|| self.sigma_points()),
            ..self.clone()
        }
    }

    fn accuracy_mut(&mut self) -> &mut Option<AccuracySetting> {
        &mut self.accuracy
    }

    fn most_numbers(&self, _: (usize, usize), variables: usize) -> usize {
        let components = allowance(variables).saturating_mul(self.most_components());
        components.saturating_mul(content::Mixture::column_count(variables))
    }

    fn rows_to_share(&self) -> Result<usize, String> {
        Err("a mixture is planned, judged and read out as a whole, and neighbours share their sigma points; gmm-ut cannot be split".into())
    }
}

/// The GMM-UT propagator.
#[derive(Debug)]
pub struct GaussianMixture {
    settings: Settings,
    /// The mixture of the scenario under way.
    course: Option<Box<dyn Course>>,
}

impl GaussianMixture {
    /// A propagator with these settings.
    pub fn new(settings: Settings) -> Self {
        Self { settings, course: None }
    }

    /// The mixture of a scenario.
    fn plan(&self, assignment: &Assignment) -> Result<Box<dyn Course>, Failure> {
        let Settings { accuracy, merge_to, .. } = self.settings;
        if let Some(problem) = &assignment.in_space {
            let planned = problem.perform(self.planned(problem, problem.variables().len())?);
            return planned.unwrap_or_else(|error| Err(Failure::Refused(by_key(&error))));
        }
        if let Some(uncertain) = &assignment.uncertain {
            return uncertain.problem.perform(self.planned(&uncertain.problem, 3)?);
        }
        let problem = &assignment.plane()?.problem;
        let flow = AccuracySetting::flow(accuracy, problem.model);
        let propagator = mixture::PlanarMixturePropagator::new(problem, &flow, &self.settings.for_mixture())?;
        let times = problem.times.clone();
        Ok(Box::new(InPlane { propagator, times, merge_to, mixture: None, disagreement: f64::NAN }))
    }

    /// The task of planning a mixture in more than two variables.
    fn planned<'a, P>(&self, problem: &'a P, variables: usize) -> Result<Planned<'a, P>, Failure> {
        let Settings { accuracy, .. } = self.settings;
        self.settings.check_beyond_plane()?;
        let components = allowance(variables).saturating_mul(self.settings.sigma_points());
        let fineness = Fineness { components, ..Fineness::default() };
        let (accuracy, unscented) = (accuracy.unwrap_or_default().0, self.settings.for_mixture().unscented);
        Ok(Planned { problem, accuracy, unscented, fineness })
    }
}

impl Propagator for GaussianMixture {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let course = self.course.insert(self.plan(assignment)?);
        Ok(Form::whole(content::Mixture::UNJUDGED, course.most_components()))
    }

    fn approach(&mut self, _index: usize) -> Result<Option<f64>, Failure> {
        self.course.as_mut().ok_or_else(Failure::no_scenario)?.plan_on()
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.course.as_mut().ok_or_else(Failure::no_scenario)?.advance(index)
    }

    fn content(&self, planned: Content) -> Content {
        let judged = |course: &dyn Course| content::Mixture { disagreement: course.disagreement() }.into();
        self.course.as_deref().map_or(planned, judged)
    }

    fn trajectories(&self) -> u64 {
        self.course.as_ref().map_or(0, |course| course.trajectories())
    }

    fn first_passage(&mut self, _times: &[f64]) -> Result<Passage, Failure> {
        let reason = "a mixture says where orbits are at a time, not where each has been; take mc, or qmc in space and exact in the plane";
        Ok(Passage::Cannot(reason.into()))
    }

    fn write(&self, columns: &mut [f64]) {
        if let Some(course) = &self.course {
            course.write(columns);
        }
    }
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
            ("components = 39", "components"),
            ("split = \"adaptive\"\nacross = 3", "across"),
            ("keep_variance = false", "keep_variance"),
            ("mode = \"as-printed\"\nsigma_points = 100", "sigma_points"),
            ("split = \"both\"\nacross = 3\nsigma_points = 100", "sigma_points"),
            ("merge_to = 5000", "merge_to"),
            ("sigma_points = 600\nmerge_to = 601", "merge_to"),
            ("split = \"both\"\ncomponents = 5\nacross = 3\nmerge_to = 15", "merge_to"),
            ("mode = \"as-printed\"\ncomponents = 1\nkeep_variance = true", "keep_variance"),
        ] {
            let misfit = settings(text).check().unwrap_err();
            assert!(misfit.key == key && misfit.problem.contains("has no effect"), "{text}: {misfit}");
        }
        for good in [
            "sigma_points = 600",
            "mode = \"as-printed\"\ncomponents = 39",
            "split = \"both\"\nacross = 3\nkeep_variance = true",
            "split = \"wussolc\"\ncomponents = 15\nacross = 3",
            "split = \"usfos\"",
            "sigma_points = 600\nmerge_to = 599",
        ] {
            settings(good).check().unwrap();
        }
        for (text, key) in [
            ("split = \"both\"\nacross = 4", "across"),
            ("split = \"both\"", "across"),
            ("sigma_points = 599", "sigma_points"),
        ] {
            assert_eq!(settings(text).check().unwrap_err().key, key);
        }
    }

    #[test]
    fn what_is_recorded_is_what_has_an_effect() {
        let most = Adaptive::default().sigma_points;
        for (text, lines) in [
            ("", format!("split = \"adaptive\"\nsigma_points = {most}\nmode = \"corrected\"\n")),
            (
                "mode = \"as-printed\"",
                "split = \"eccentricity\"\ncomponents = 39\nacross = 1\nkeep_variance = false\nmode = \"as-printed\"\n"
                    .into(),
            ),
            (
                "split = \"solar-angle\"\ncomponents = 1",
                "split = \"solar-angle\"\ncomponents = 1\nacross = 1\nmode = \"corrected\"\n".into(),
            ),
        ] {
            let resolved = settings(text).resolved();
            assert_eq!(toml::to_string(&resolved).unwrap(), lines);
            resolved.check().unwrap();
            assert_eq!(settings(&lines).for_mixture(), settings(text).for_mixture());
        }
    }
}
