use density::flow::Accuracy;

use super::*;

fn load(text: &str) -> Result<Launch, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("l.toml");
    std::fs::write(folder.path().join("s.toml"), include_str!("../../scenarios/scenario-1.toml")).unwrap();
    std::fs::write(&path, text).unwrap();
    Launch::load(Some(&path), None)
}

const GOOD: &str = "name = \"l\"\nscenarios = [\"s.toml\"]\nreference = \"mc\"\n\
    [[propagator]]\nlabel = \"mc\"\nnode = \"mc\"\nsamples = 10\n\
    [[propagator]]\nlabel = \"mine\"\ncommand = [\"./mine\", \"-x\"]\n";

#[test]
fn the_launch_files_of_the_project_are_good() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("launch");
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        if entry.path().extension().is_some_and(|e| e == "toml") {
            Launch::load(Some(&entry.path()), None).unwrap();
        }
    }
    assert_eq!(Launch::load(None, None).unwrap().cases.len(), 5);
}

#[test]
fn accuracy_is_that_of_the_file_unless_a_case_has_its_own() {
    let accuracy = |text: &str| match load(text).unwrap().cases.remove(0).runs {
        Runs::BuiltIn { mut settings, .. } => settings.accuracy_mut().unwrap().0,
        other => panic!("{other:?}"),
    };
    let of_file = GOOD.replace("[[propagator]]\nlabel = \"mc\"", "accuracy = 1e-9\n[[propagator]]\nlabel = \"mc\"");
    assert_eq!(accuracy(GOOD), Accuracy::Fine);
    assert_eq!(accuracy(&of_file), Accuracy::Medium);
    let another = "[[propagator]]\nlabel = \"dee\"\nnode = \"dee\"\n";
    let both = of_file.replace("samples = 10", "accuracy = 1e-6") + another;
    assert_eq!(accuracy(&both), Accuracy::Coarse);
}

#[test]
fn all_are_compared_with_one_case_or_with_the_first_of_several_that_knows() {
    assert_eq!((load(GOOD).unwrap().references, load(GOOD).unwrap().tolerance), (vec!["mc".to_owned()], 0.01));
    let several = GOOD.replace("reference = \"mc\"", "reference = [\"mine\", \"mc\"]\ntolerance = 0.05");
    let several = load(&several).unwrap();
    assert_eq!((several.references, several.tolerance), (vec!["mine".to_owned(), "mc".to_owned()], 0.05));
}

#[test]
fn an_accuracy_that_no_case_uses_is_refused() {
    let own = GOOD.replace("samples = 10", "samples = 10\naccuracy = 1e-6");
    let error = load(&own.replace("reference = \"mc\"", "reference = \"mc\"\naccuracy = 1e-9")).unwrap_err();
    assert_eq!((error.line, error.key.as_str()), (4, "accuracy"), "{error}");
    assert!(error.to_string().contains("has no effect"), "{error}");
    load(&own).unwrap();
}

#[test]
fn every_mistake_is_told_with_line_and_key() {
    let cases = [
        ("samples = 10", "samples = 0", 7, "propagator.samples", "at least 1"),
        (
            "samples = 10",
            "sample = 10",
            7,
            "propagator.sample",
            "is unknown, did you mean `samples`? There may be `samples`, `seed`, `draws`, `replicates`, `through`, `map_error`, `accuracy`, `model`, `forces` \
             (settings of mc); `label`, `node`, `command`, `shards`, `reduce`, `hosts`, `most_seconds` (of every case)",
        ),
        (
            "samples = 10",
            "shard = 2",
            7,
            "propagator.shard",
            "is unknown, did you mean `shards`? There may be `samples`, ",
        ),
        ("samples = 10", "most_second = 2", 7, "propagator.most_second", "did you mean `most_seconds`?"),
        ("samples = 10", "lable = \"x\"", 7, "propagator.lable", "did you mean `label`?"),
        ("samples = 10", "colour = 3", 7, "propagator.colour", "is unknown; there may be `samples`, "),
        (
            "label = \"mc\"",
            "lable = \"mc\"",
            5,
            "propagator.lable",
            "did you mean `label`? There may be `label`, `node`,",
        ),
        ("node = \"mc\"", "nod = \"mc\"", 6, "propagator.nod", "did you mean `node`?"),
        ("command = ", "shard = 2\ncommand = ", 10, "propagator.shard", "did you mean `shards`?"),
        ("command = ", "samples = 2\ncommand = ", 10, "propagator.samples", "is not allowed beside command"),
        ("samples = 10", "samples = \"x\"", 7, "propagator.samples", "\"x\" is not allowed, it must be a whole number"),
        ("samples = 10", "samples = 2000.0", 7, "propagator.samples", "a whole number, without a decimal point: 2000"),
        ("samples = 10", "draws = true", 7, "propagator.draws", "one of \"independent\", \"antithetic\", \"sobol\""),
        (
            "node = \"mc\"\nsamples = 10",
            "node = \"dee\"\nsamples = 3",
            7,
            "propagator.samples",
            "3 are too few for a mesh; it needs at least 4",
        ),
        ("[\"s.toml\"]", "\"s.toml\"", 2, "scenarios", "\"s.toml\" is not allowed, it must be a list"),
        ("[\"s.toml\"]", "[1]", 2, "scenarios", "1 is not allowed, it must be text, in quotation marks"),
        ("node = \"mc\"", "node = \"nc\"", 6, "propagator.node", "one of mc, qmc, dee, gmm-ut, exact, flow-map"),
        ("label = \"mine\"", "label = \"mc\"", 9, "propagator.label", "labels must differ"),
        ("label = \"mine\"", "label = \"../mine\"", 9, "propagator.label", "letters, digits"),
        ("label = \"mine\"", "label = \"recorder\"", 9, "propagator.label", "own processes"),
        ("reference = \"mc\"", "reference = \"md\"", 3, "reference", "there are mc, mine"),
        ("reference = \"mc\"", "reference = [\"mc\", \"md\"]", 3, "reference", "\"md\"; there are mc, mine"),
        ("reference = \"mc\"", "reference = [\"mc\", \"mc\"]", 3, "reference", "names a case twice"),
        ("reference = \"mc\"", "reference = []", 3, "reference", "names no case"),
        ("reference = \"mc\"", "reference = 1", 3, "reference", "the label of a case, or a list of labels"),
        ("reference = \"mc\"", "reference = \"mc\"\ntolerance = 0", 4, "tolerance", "greater than 0 and at most 1"),
        ("reference = \"mc\"", "reference = \"mc\"\ntolerance = nan", 4, "tolerance", "greater than 0 and at most 1"),
        (
            "reference = \"mc\"",
            "referense = \"mc\"",
            3,
            "referense",
            "is unknown, did you mean `reference`? There may be `name`, `scenarios`, `reference`, ",
        ),
        ("s.toml", "t.toml", 2, "scenarios", "cannot be read"),
        ("[\"./mine\", \"-x\"]", "[]", 10, "propagator.command", "is empty"),
        ("node = \"mc\"\n", "", 5, "propagator.label", "either node or command"),
        ("reference = \"mc\"", "reference = \"mc\"\naccuracy = 1e-7", 4, "accuracy", "1e-6, 1e-9 or 1e-12"),
        ("samples = 10", "accuracy = 0.1", 7, "propagator.accuracy", "1e-6, 1e-9 or 1e-12"),
        ("reference = \"mc\"", "reference = \"mc\"\nbins = [0, 5]", 4, "bins", "between 1 and 2000"),
        ("samples = 10", "reduce = 1", 7, "propagator.reduce", "1 is not allowed, it must be true or false"),
        ("samples = 10", "replicates = 2\nreduce = true", 8, "propagator.reduce", "standard errors of replicates"),
        (
            "node = \"mc\"\nsamples = 10",
            "node = \"dee\"\nreduce = true",
            7,
            "propagator.reduce",
            "only such can be reduced",
        ),
        ("samples = 10", "seed = -1", 7, "propagator.seed", "-1 is not allowed, it must be at least 0"),
        ("samples = 10", "seed = 9223372036854775808", 7, "propagator.seed", "whole numbers lie between"),
        ("samples = 10", "most_seconds = 0.0", 7, "propagator.most_seconds", "greater than 0"),
        ("samples = 10", "most_seconds = nan", 7, "propagator.most_seconds", "greater than 0"),
        (
            "samples = 10",
            "most_seconds = \"5\"",
            7,
            "propagator.most_seconds",
            "\"5\" is not allowed, it must be a number",
        ),
        ("samples = 10", "shards = 0", 7, "propagator.shards", "1 to 64"),
        ("samples = 10", "shards = 65", 7, "propagator.shards", "1 to 64"),
        ("samples = 10", "shards = 2.5", 7, "propagator.shards", "2.5 is not allowed, it must be a whole number"),
        ("samples = 10", "samples = 10\nshards = 11", 8, "propagator.shards", "too many for 10 rows"),
        ("node = \"mc\"\nsamples = 10", "node = \"exact\"\nshards = 2", 7, "propagator.shards", "cannot be split"),
        ("node = \"mc\"\nsamples = 10", "node = \"gmm-ut\"\nshards = 2", 7, "propagator.shards", "cannot be split"),
        (
            "label = \"mine\"",
            "label = \"a-label-of-thirty-characters-xy\"\nshards = 2",
            10,
            "propagator.shards",
            "a shorter label",
        ),
        (
            "samples = 10",
            "shards = 64\n[[propagator]]\nlabel = \"b\"\nnode = \"mc\"\nshards = 64",
            13,
            "propagator.label",
            "more than 128 processes",
        ),
        (
            "reference = \"mc\"",
            "reference = \"mc\"\nrestart = \"ever\"",
            4,
            "restart",
            "it must be \"never\" or \"on-failure\"",
        ),
        (
            "reference = \"mc\"",
            "reference = \"mc\"\nrestart = true",
            4,
            "restart",
            "true is not allowed, it must be \"never\" or \"on-failure\"",
        ),
        ("[[propagator]]", "[propagator]", 8, "propagator", "write [[propagator]] above each, in double brackets"),
    ];
    for (from, to, line, key, words) in cases {
        assert!(GOOD.contains(from), "{from}");
        let error = load(&GOOD.replace(from, to)).unwrap_err();
        assert_eq!((error.line, error.key.as_str()), (line, key), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
    load(GOOD).unwrap();
}
