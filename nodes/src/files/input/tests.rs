use super::*;

#[test]
fn an_error_says_line_and_key() {
    let file = InputFile::from_text(Path::new("a.toml"), "top = 1\n[orbit]\nradiation = \"x\"\n");
    #[derive(Debug, serde::Deserialize)]
    #[expect(dead_code)]
    struct Orbit {
        radiation: f64,
    }
    #[derive(Debug, serde::Deserialize)]
    #[expect(dead_code)]
    struct All {
        top: u32,
        orbit: Orbit,
    }
    let error = file.parse::<All>().unwrap_err();
    assert_eq!((error.line, error.key.as_str()), (3, "orbit.radiation"));
    assert_eq!(error.to_string(), "a.toml:3: orbit.radiation: \"x\" is not allowed, it must be a number");
}

#[test]
fn a_key_that_is_missing_or_stands_there_twice_is_told_so() {
    #[derive(Debug, serde::Deserialize)]
    #[expect(dead_code)]
    struct Orbit {
        radiation: f64,
    }
    #[derive(Debug, serde::Deserialize)]
    #[expect(dead_code)]
    struct All {
        name: String,
        orbit: Orbit,
    }
    for (text, told) in [
        ("[orbit]\nradiation = 1.0\n", "a.toml:1: name: the scenario file lacks the key `name`"),
        ("other = 1\n", "a.toml:1: name: the file lacks the key `name`"),
        ("name = \"a\"\n[orbit]\n", "a.toml:2: orbit.radiation: the table `orbit` lacks the key `radiation`"),
        ("name = \"a\"\n\nname = \"b\"\n", "a.toml:3: name: stands in its table for the second time"),
        ("name = \"a\"\n[orbit]\nradiation = 1.0\nradiation = 1.0\n", "a.toml:4: orbit.radiation: stands in its table"),
        ("name = \"a\"\n[orbit]\n[initial]\n[orbit]\n", "a.toml:4: orbit: stands in its table for the second time"),
        (
            "name = \"a\"\n[propagator]\nx = 1\n[propagator]\nx = 2\n",
            "a.toml:4: propagator: there may be several of these: write [[propagator]] above each, in double brackets",
        ),
        ("[propagator]\n[[propagator]]\n", "a.toml:2: propagator: there may be several of these"),
        ("propagator = 1\npropagator = 2\n", "a.toml:2: propagator: stands in its table for the second time"),
        ("hello\n", "a.toml:1: is not TOML: "),
    ] {
        let error = InputFile::from_text(Path::new("a.toml"), text).parse::<All>().unwrap_err().to_string();
        assert!(error.starts_with(told), "{error}");
    }
}

#[test]
fn names_cannot_leave_their_folder() {
    for bad in ["", "..", "a/b", ".hidden", "ä", "a\0", &"x".repeat(32)] {
        assert!(!is_plain_name(bad), "{bad}");
    }
    assert!(is_plain_name("dee-1e5"));
}
