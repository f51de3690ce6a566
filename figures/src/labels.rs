//! Words beside clouds, placed so that none covers another.

use plotters::style::text_anchor::{HPos, VPos};

use crate::elements::{Element, Point};
use crate::figure::DrawError;
use crate::palette::Ink;
use crate::panel::{Panel, SMALL, text_style};
use crate::text::text_width;

/// A rectangle in pixels: left, top, right, bottom.
type Box4 = [f64; 4];

fn meet(a: &Box4, b: &Box4) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Words that are to stand beside a cloud.
#[derive(Debug, Clone)]
pub struct Label {
    /// The words.
    pub words: String,
    /// Lower left corner of the cloud.
    pub low: Point,
    /// Its upper right corner.
    pub high: Point,
}

/// Writes each label above, below, right or left of its cloud, where no other cloud or label is if there is such a place,
/// and at least where no other label is.
pub fn write(panel: &Panel<'_, '_>, labels: &[Label]) -> Result<(), DrawError> {
    const HEIGHT: f64 = 1.3 * SMALL;
    const AWAY: f64 = 4.0;
    let frame = panel.frame();
    let clouds: Vec<Box4> = labels.iter().map(|label| cloud_box(panel, label)).collect();
    let mut written: Vec<Box4> = Vec::new();
    for (label, cloud) in labels.iter().zip(&clouds) {
        let width = text_width(&label.words, SMALL) + 4.0;
        let (x, y) = (0.5 * (cloud[0] + cloud[2]), 0.5 * (cloud[1] + cloud[3]));
        let boxed = |left: f64, top: f64| -> Box4 {
            let left = left.clamp(frame[0] + 2.0, (frame[2] - width - 2.0).max(frame[0] + 2.0));
            [left, top, left + width, top + HEIGHT]
        };
        let candidates = [
            boxed(x - 0.5 * width, cloud[1] - AWAY - HEIGHT),
            boxed(x - 0.5 * width, cloud[3] + AWAY),
            boxed(cloud[2] + AWAY, y - 0.5 * HEIGHT),
            boxed(cloud[0] - AWAY - width, y - 0.5 * HEIGHT),
            boxed(cloud[2] - width, cloud[1] - AWAY - HEIGHT),
            boxed(cloud[0], cloud[1] - AWAY - HEIGHT),
            boxed(cloud[2] - width, cloud[3] + AWAY),
            boxed(cloud[0], cloud[3] + AWAY),
            boxed(x - 0.5 * width, cloud[1] + AWAY),
            boxed(x - 0.5 * width, y - 0.5 * HEIGHT),
            boxed(x - 0.5 * width, cloud[3] - AWAY - HEIGHT),
        ];
        let is_inside = |b: &Box4| b[1] > frame[1] + 1.0 && b[3] < frame[3] - 1.0;
        let is_alone = |b: &Box4| is_inside(b) && !written.iter().any(|other| meet(b, other));
        let is_clear = |b: &Box4| is_alone(b) && !clouds.iter().any(|other| meet(b, other));
        let Some(place) = candidates.iter().find(|b| is_clear(b)).or_else(|| candidates.iter().find(|b| is_alone(b)))
        else {
            continue;
        };
        let style = text_style(SMALL, Ink::Text, HPos::Left, VPos::Center);
        let (corner, opposite) = (panel.point(place[0], place[1]), panel.point(place[2], place[3]));
        panel.draw_over(&[Element::block(corner, opposite, Ink::Paper, 0.75)])?;
        panel.write(&label.words, panel.point(place[0] + 2.0, 0.5 * (place[1] + place[3])), style)?;
        written.push(*place);
    }
    Ok(())
}

fn cloud_box(panel: &Panel<'_, '_>, label: &Label) -> Box4 {
    let (left, bottom) = panel.pixels(label.low);
    let (right, top) = panel.pixels(label.high);
    [left, top, right, bottom]
}
