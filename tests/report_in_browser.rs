//! The report in a real browser: nothing overlaps and nothing sticks out, in light, in dark and on paper.
//!
//! Needs Chromium; without it the test prints this and is skipped, unless `PHASECLOUD_REQUIRE_CHROMIUM=1`.
#![allow(missing_docs)]

mod common;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::browser::{self, Killed, WATCHDOG, chromium};
use common::{Bench, text};

const CASES: &str = r#"
[[propagator]]
label = "exact"
node = "exact"

[[propagator]]
label = "mc"
node = "mc"
samples = 4_000

[[propagator]]
label = "dee-961"
node = "dee"
samples = 961

[[propagator]]
label = "gmm-ut-as-printed-with-longname" # as long as a label may be
node = "gmm-ut"
mode = "as-printed"
"#;

/// A script that is added to a copy of the page and writes into it which elements overlap or stick out.
const PROBE: &str = r#"<script>
addEventListener("load", () => {
  const found = [];
  const root = document.documentElement;
  if (root.scrollWidth > root.clientWidth) found.push(`the page is ${root.scrollWidth} px wide, the window ${root.clientWidth}`);
  let words = 0;
  for (const svg of document.querySelectorAll("figure > svg")) {
    const frame = svg.getBoundingClientRect();
    const name = svg.parentNode.id;
    const boxes = [...svg.querySelectorAll("text")].map(text => {
      const box = text.getBoundingClientRect();
      // The box has room for accents and descenders that most letters do not use.
      const dx = 0.12 * Math.min(box.width, box.height), dy = 0.12 * Math.min(box.width, box.height);
      return { words: text.textContent, left: box.left + dx, right: box.right - dx, top: box.top + dy, bottom: box.bottom - dy };
    });
    words += boxes.length;
    boxes.forEach((a, i) => {
      if (a.left < frame.left - 0.5 || a.right > frame.right + 0.5 || a.top < frame.top - 0.5 || a.bottom > frame.bottom + 0.5)
        found.push(`${name}: "${a.words}" sticks out`);
      for (const b of boxes.slice(i + 1))
        if (a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)
          found.push(`${name}: "${a.words}" covers "${b.words}"`);
    });
  }
  document.title = `PROBED ${words} words [${found.join("; ")}]`;
});
</script>"#;

/// Opens a page without a window; the browser's output goes to `printed` in the bench.
fn browse(bench: &Bench, chromium: &str, page: &Path, arguments: &[String]) -> String {
    let printed = bench.path("printed.txt");
    let mut command = Command::new(chromium);
    command.args(browser::arguments(&bench.path("browser"))).args(arguments);
    command.arg(format!("file://{}", page.display())).stdin(Stdio::null()).stderr(Stdio::null());
    let mut browser = Killed(command.stdout(std::fs::File::create(&printed).unwrap()).spawn().unwrap());
    let started = Instant::now();
    loop {
        if let Some(status) = browser.0.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            return text(&std::fs::read(printed).unwrap());
        }
        assert!(started.elapsed() < WATCHDOG, "the browser did not end");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What the probe reports of a page in a window of this size.
fn probe(bench: &Bench, chromium: &str, page: &Path, size: &str) -> String {
    let dom = browse(bench, chromium, page, &[format!("--window-size={size}"), "--dump-dom".into()]);
    let (_, rest) = dom.split_once("<title>PROBED").expect("the probe has run");
    rest.split_once("</title>").unwrap().0.to_owned()
}

#[test]
#[ignore = "long; .ci/long runs it"]
fn the_report_is_legible_in_light_dark_and_print() {
    let Some(chromium) = chromium() else { return };
    let bench = Bench::new();
    for (name, text) in [
        ("scenario-2.toml", include_str!("../launch/scenarios/scenario-2.toml")),
        ("scenario-3.toml", include_str!("../launch/scenarios/scenario-3.toml")),
    ] {
        bench.write(name, text);
    }
    let scenarios = "scenarios = [\"scenario-1.toml\", \"scenario-2.toml\", \"scenario-3.toml\"]";
    let head = format!("name = \"three\"\n{scenarios}\nreference = \"exact\"\nbins = [60, 60]\n");
    let launch = bench.write("three.toml", &format!("{head}{CASES}"));
    bench.run_well(&launch, "out");
    let compared = bench.phasecloud().args(["report", "out", "out", "--out", "compared.html"]).output().unwrap();
    assert!(compared.status.success(), "{}", text(&compared.stderr));

    for page in ["out/report.html", "compared.html"] {
        let probed = bench.write("probed.html", &(text(&bench.read(page)) + PROBE));
        for size in ["1366,768", "700,900"] {
            let found = probe(&bench, chromium, &probed, size);
            let (words, problems) = found.split_once(" words ").unwrap();
            assert!(words.trim().parse::<usize>().unwrap() > 1000, "{found}");
            assert_eq!(problems, "[]", "{page} at {size}");
        }
    }

    let page = bench.path("out/report.html");
    let [light, dark] = [("light.png", 1), ("dark.png", 0)].map(|(name, scheme)| {
        let shot = bench.path(name);
        let screenshot = format!("--screenshot={}", shot.display());
        let scheme = format!("--blink-settings=preferredColorScheme={scheme}");
        browse(&bench, chromium, &page, &[screenshot, "--window-size=1366,9000".into(), scheme]);
        common::picture(&std::fs::read(shot).unwrap())
    });
    for ((width, height, colours), paper) in [(light, [0xff; 3]), (dark, [0x15, 0x19, 0x1e])] {
        assert_eq!((width, height), (1366, 9000));
        let share = colours[&paper] as f64 / (f64::from(width) * f64::from(height));
        assert!((0.5..0.99).contains(&share), "{share} of the page is bare");
        assert!(colours.len() > 500, "{} colours", colours.len());
    }

    let paper = bench.path("paper.pdf");
    browse(&bench, chromium, &page, &[format!("--print-to-pdf={}", paper.display()), "--no-pdf-header-footer".into()]);
    let printed = String::from_utf8_lossy(&std::fs::read(paper).unwrap()).into_owned();
    let pages = printed.matches("/Type /Page\n").count();
    assert!(printed.starts_with("%PDF-") && (10..120).contains(&pages), "{pages} pages");
}
