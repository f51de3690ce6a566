//! Which scenario is the newest: one that is published again, by a restarted scenario node say, is no news.

/// The newest scenario that a node has taken on; scenarios of a run are numbered in ascending order.
#[derive(Debug, Clone, Copy, Default)]
pub struct Newest(Option<u32>);

impl Newest {
    /// Whether `scenario` is newer than all before, which it then is no longer.
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
