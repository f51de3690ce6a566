//! The newest scenario that a node knows.
//!
//! A scenario that is published again, for example by a restarted scenario node, is not new.

/// The newest scenario that a node has taken on; scenarios of a run are numbered in ascending order.
#[derive(Debug, Clone, Copy, Default)]
pub struct Newest(Option<u32>);

impl Newest {
    /// Whether `scenario` is newer than all before. If so, it is remembered as the newest.
    pub fn is_news(&mut self, scenario: u32) -> bool {
        let is_news = self.0.is_none_or(|newest| scenario > newest);
        if is_news {
            self.0 = Some(scenario);
        }
        is_news
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scenario_is_news_once_and_older_ones_never() {
        let mut newest = Newest::default();
        assert_eq!([1, 1, 0, 2].map(|scenario| newest.is_news(scenario)), [true, false, false, true]);
    }
}
