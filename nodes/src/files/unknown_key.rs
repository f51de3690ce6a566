//! An unknown key: which key was probably meant, and which keys are allowed.

/// What the TOML reader reports about an unknown key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownKey {
    key: String,
    known: Vec<String>,
}

impl UnknownKey {
    /// Decodes the message of a TOML reader, if it is about an unknown key.
    pub fn told_by(message: &str) -> Option<Self> {
        let (key, known) = message.strip_prefix("unknown field `")?.rsplit_once("`, expected ")?;
        let known = known.split('`').skip(1).step_by(2).map(str::to_owned).collect();
        Some(Self { key: key.to_owned(), known })
    }

    /// Whether `key` is one that the reader knows.
    pub fn is_beside(&self, key: &str) -> bool {
        self.known.iter().any(|known| known == key)
    }

    /// What is wrong and what would be right.
    pub fn problem(&self) -> String {
        told(&self.key, &[(self.known(), "")])
    }

    /// As [`UnknownKey::problem`], if `others` are allowed beside the keys that the reader knows; `what` and
    /// `what_others` describe the two groups of keys.
    pub fn problem_beside(&self, what: &str, others: &[&str], what_others: &str) -> String {
        told(&self.key, &[(self.known(), what), (others.to_vec(), what_others)])
    }

    fn known(&self) -> Vec<&str> {
        self.known.iter().map(String::as_str).collect()
    }
}

/// The message about an unknown key: lists of the keys that are allowed, each with a description of these keys.
pub fn told(key: &str, known: &[(Vec<&str>, &str)]) -> String {
    let list = |(keys, what): &(Vec<&str>, &str)| {
        let keys = keys.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(", ");
        if what.is_empty() { keys } else { format!("{keys} ({what})") }
    };
    let lists = known.iter().map(list).collect::<Vec<_>>().join("; ");
    match nearest(key, known.iter().flat_map(|(keys, _)| keys.iter().copied())) {
        Some(meant) => format!("is unknown, did you mean `{meant}`? There may be {lists}"),
        None => format!("is unknown; there may be {lists}"),
    }
}

/// The word among `known` that is most similar to `word`, if it is similar enough.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = |word: &str| word.chars().count().min(LONGEST);
    let is_like = |(distance, other): &(usize, &str)| 3 * distance <= length(word).max(length(other));
    known.into_iter().map(|other| (distance(word, other), other)).filter(is_like).min().map(|(_, other)| other)
}

/// Number of letters that must be inserted, deleted, changed or swapped with their neighbour to turn `a` into `b`.
fn distance(a: &str, b: &str) -> usize {
    let [a, b] = [a, b].map(|word| word.chars().take(LONGEST).collect::<Vec<_>>());
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let changed = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = changed.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

/// Largest number of letters of a word that are compared; every key is shorter.
const LONGEST: usize = 64;

#[cfg(test)]
mod tests {
    use super::*;

    const KEYS: [&str; 7] = ["label", "node", "command", "shards", "reduce", "hosts", "most_seconds"];

    #[test]
    fn a_slip_of_the_pen_finds_the_key_that_was_meant_and_another_word_none() {
        for (slip, meant) in [
            ("shard", Some("shards")),
            ("most_second", Some("most_seconds")),
            ("lable", Some("label")),
            ("nod", Some("node")),
            ("Label", Some("label")),
            ("tolerance", None),
            ("x", None),
            ("", None),
        ] {
            assert_eq!(nearest(slip, KEYS), meant, "{slip}");
        }
        assert_eq!(nearest(&"shards".repeat(100_000), KEYS), None);
    }

    #[test]
    fn all_that_may_stand_there_is_told() {
        let message = "unknown field `sead`, expected one of `samples`, `seed`";
        let unknown = UnknownKey::told_by(message).unwrap();
        assert_eq!(unknown.problem(), "is unknown, did you mean `seed`? There may be `samples`, `seed`");
        assert_eq!(
            unknown.problem_beside("settings of mc", &["label", "node"], "of every case"),
            "is unknown, did you mean `seed`? There may be `samples`, `seed` (settings of mc); `label`, `node` (of every case)"
        );
        let only = UnknownKey::told_by("unknown field `q`, expected `critical_e`").unwrap();
        assert_eq!(only.problem(), "is unknown; there may be `critical_e`");
        assert_eq!(UnknownKey::told_by("missing field `x`"), None);
    }
}
