//! What a figure shows, read back from its SVG.

use figures::palette::Ink;
use figures::text::text_width;

/// All words of a figure with their places, its description and its number of pictures.
pub struct Drawn {
    pub words: Vec<(String, f64, f64)>,
    pub description: String,
    pub images: usize,
}

impl Drawn {
    pub fn of(svg: &str) -> Self {
        let document = roxmltree::Document::parse(svg).unwrap();
        let named = |name: &'static str| document.descendants().filter(move |node| node.tag_name().name() == name);
        let all = |node: roxmltree::Node<'_, '_>| node.descendants().filter_map(|n| n.text()).collect::<String>();
        // For an element, `text` gives the text of its first child, so only text nodes are taken.
        let own = |node: roxmltree::Node<'_, '_>| {
            node.descendants().filter(roxmltree::Node::is_text).filter_map(|n| n.text()).collect::<String>()
        };
        let number = |node: roxmltree::Node<'_, '_>, name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
        Self {
            words: named("text").map(|node| (own(node), number(node, "x"), number(node, "y"))).collect(),
            description: named("desc").map(all).next().unwrap(),
            images: named("image").count(),
        }
    }

    pub fn has(&self, words: &str) -> bool {
        self.words.iter().any(|(text, ..)| text == words)
    }

    pub fn count(&self, words: &str) -> usize {
        self.words.iter().filter(|(text, ..)| text == words).count()
    }
}

pub fn number(node: roxmltree::Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// The label of a snapshot as it is drawn.
pub struct Written {
    pub index: usize,
    /// Left, top, right and bottom of the words.
    pub place: [f64; 4],
    /// The place where the line that leads to the cloud begins.
    pub led_to: Option<(f64, f64)>,
}

/// The labels at the clouds of a figure of `count` snapshots, which are a quarter of a year apart.
pub fn written(document: &roxmltree::Document<'_>, count: usize) -> Vec<Written> {
    let with_class = |class: String| document.descendants().filter(move |n| n.attribute("class") == Some(&*class));
    let of_index = |index: usize| {
        let (ink, words) = (Ink::of_many(index, count), format!("t = {} yr", 0.25 * index as f64));
        let text = with_class(ink.fill_class().into_owned()).find(|node| node.text() == Some(&*words))?;
        let (width, base) = (0.85 * text_width(&words, 11.0), number(text, "y"));
        let share = match text.attribute("text-anchor") {
            Some("middle") => 0.5,
            Some("end") => 1.0,
            _ => 0.0,
        };
        let left = number(text, "x") - share * width;
        let lines = with_class(ink.stroke_class().into_owned()).filter(|node| node.attribute("fill") == Some("none"));
        let mut starts = lines.filter_map(|line| line.attribute("d")?.strip_prefix('M')?.split('L').next());
        let start = starts.next_back().and_then(|start| start.split_once(' '));
        Some(Written {
            index,
            place: [left, base - 9.0, left + width, base + 3.0],
            led_to: start.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())),
        })
    };
    (0..count).filter_map(of_index).collect()
}

/// Whether no word and no place of a figure is "NaN". Pictures are left out, because their encoding may contain these
/// letters.
pub fn has_numbers_only(svg: &str) -> bool {
    let document = roxmltree::Document::parse(svg).unwrap();
    let is_good = |node: roxmltree::Node<'_, '_>| {
        let mut attributes = node.attributes().filter(|attribute| attribute.name() != "href");
        !node.text().unwrap_or("").contains("NaN") && attributes.all(|attribute| !attribute.value().contains("NaN"))
    };
    document.descendants().all(is_good)
}
