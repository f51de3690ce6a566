//! The pages in Markdown: every link within the project leads to a file and a heading that are there, and every page is
//! in the book.

use pulldown_cmark::{Event, LinkType, Options, Parser, Tag, TagEnd};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn every_link_between_pages_leads_to_a_file_and_a_heading() {
    let pages = pages();
    assert!(pages.len() > 20, "{pages:?}");
    let headings: HashMap<PathBuf, Vec<String>> =
        pages.iter().map(|page| (page.clone(), anchors(&read(page)))).collect();
    let mut broken = Vec::new();
    let mut checked = 0;
    for page in &pages {
        for link in links(&read(page)) {
            if link.contains("://") || link.starts_with("mailto:") {
                continue;
            }
            checked += 1;
            if let Err(why) = follow(page, &link, &headings) {
                broken.push(format!("{}: ({link}) {why}", page.display()));
            }
        }
    }
    assert!(checked > 80, "only {checked} links were found");
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn every_page_of_the_documentation_is_a_chapter_of_the_book() {
    let book = Path::new(ROOT).join("docs");
    let chapters: Vec<PathBuf> = links(&read(&book.join("SUMMARY.md"))).iter().map(|link| book.join(link)).collect();
    let mut pages: Vec<PathBuf> = markdown_in(&book);
    pages.retain(|page| !page.ends_with("SUMMARY.md"));
    for page in &pages {
        assert_eq!(
            chapters.iter().filter(|chapter| *chapter == page).count(),
            1,
            "{} in docs/SUMMARY.md",
            page.display()
        );
    }
    assert_eq!(chapters.len(), pages.len());
}

/// A link that cannot be followed is told from one that can, or the test above could not fail.
#[test]
fn a_missing_file_or_heading_is_found() {
    let page = Path::new(ROOT).join("README.md");
    let headings = HashMap::from([(page.clone(), anchors("# One\n\n## `code` & Two, three!\n\n## One\n"))]);
    let tried = |link: &str| follow(&page, link, &headings).is_ok();
    assert!(tried("#one") && tried("#one-1") && tried("README.md#code--two-three") && tried("docs/maps.md"));
    assert!(!tried("#four") && !tried("README.md#Two") && !tried("docs/none.md") && !tried("docs/maps.md#none"));
}

fn follow(page: &Path, link: &str, headings: &HashMap<PathBuf, Vec<String>>) -> Result<(), String> {
    let (file, heading) = link.split_once('#').map_or((link, None), |(file, heading)| (file, Some(heading)));
    let target = match file {
        "" => page.to_path_buf(),
        file => page.parent().unwrap().join(file).canonicalize().map_err(|error| error.to_string())?,
    };
    let Some(heading) = heading else { return Ok(()) };
    let known = headings.get(&target).ok_or("leads to a heading of what is no page")?;
    if known.iter().any(|anchor| anchor == heading) {
        Ok(())
    } else {
        Err(format!("has no such heading; there are {known:?}"))
    }
}

/// The pages of the project: those at its root, in `docs/`, and of its examples and its Python package.
fn pages() -> Vec<PathBuf> {
    let folders = ["", "docs", "examples/python", "examples/stt-gaussian", "python"];
    folders.iter().flat_map(|folder| markdown_in(&Path::new(ROOT).join(folder))).collect()
}

fn markdown_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    pages.sort();
    pages.iter().map(|page| page.canonicalize().unwrap()).collect()
}

fn read(page: &Path) -> String {
    std::fs::read_to_string(page).unwrap()
}

fn links(text: &str) -> Vec<String> {
    let of_event = |event| match event {
        Event::Start(Tag::Link { link_type, dest_url, .. }) if link_type != LinkType::Autolink => {
            Some(dest_url.to_string())
        }
        Event::Start(Tag::Image { dest_url, .. }) => Some(dest_url.to_string()),
        _ => None,
    };
    Parser::new_ext(text, Options::ENABLE_TABLES).filter_map(of_event).collect()
}

/// The anchors of a page's headings, as GitHub and mdBook make them: small letters, blanks as dashes, no other
/// punctuation, a number behind those that are there already.
fn anchors(text: &str) -> Vec<String> {
    let mut anchors: Vec<String> = Vec::new();
    let mut seen: HashMap<String, usize> = HashMap::new();
    let mut heading: Option<String> = None;
    for event in Parser::new_ext(text, Options::ENABLE_TABLES) {
        match (event, &mut heading) {
            (Event::Start(Tag::Heading { .. }), _) => heading = Some(String::new()),
            (Event::Text(words) | Event::Code(words), Some(heading)) => heading.push_str(&words),
            (Event::End(TagEnd::Heading(_)), said) => {
                let anchor = slug(&said.take().unwrap_or_default());
                let before = seen.entry(anchor.clone()).or_default();
                anchors.push(if *before == 0 { anchor } else { format!("{anchor}-{before}") });
                *before += 1;
            }
            _ => {}
        }
    }
    anchors
}

fn slug(heading: &str) -> String {
    let kept = heading
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .collect::<String>();
    kept.replace(' ', "-")
}
