//! A finished figure: a separate SVG file, and a part of a page.

use maud::{Markup, PreEscaped, html};

use crate::backend::{Area, FIGURE, canvas};
use crate::draw_error::DrawError;
use crate::legend::{self, Entry};
use crate::panel::units;

/// Similar typefaces, one of which exists on every system.
pub const TYPEFACES: &str = "Helvetica Neue, Arial, Liberation Sans, DejaVu Sans, sans-serif";

/// A figure.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Name of its file, without ending.
    pub name: String,
    /// What it shows, in one line.
    pub title: String,
    /// A description for readers who cannot see the figure, and how to read it.
    pub caption: String,
    elements: String,
    size: (u32, u32),
}

impl Figure {
    /// Draws a figure of `size` pixels below a key, which adds to its height.
    ///
    /// # Errors
    /// `DrawError` if plotters reports an error.
    pub fn draw(
        name: &str,
        title: &str,
        caption: &str,
        (width, height): (u32, u32),
        key: &[Entry],
        paint: impl FnOnce(&Area<'_>) -> Result<(), DrawError>,
    ) -> Result<Self, DrawError> {
        let above = legend::height(key, f64::from(width));
        let size = (width, height + above.ceil() as u32);
        let mut elements = String::new();
        {
            let whole = canvas(&mut elements, size);
            if key.is_empty() {
                paint(&whole)?;
            } else {
                let (head, body) = whole.split_vertically(units(above) as i32);
                legend::draw(&head, key, f64::from(width))?;
                paint(&body)?;
            }
        }
        Ok(Self { name: name.into(), title: title.into(), caption: caption.into(), elements, size })
    }

    /// The figure as a separate file, on white.
    pub fn to_file(&self) -> String {
        let (width, height) = self.size;
        let backdrop = html! { rect width=(width) height=(height) fill="#ffffff" {} };
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}\n", self.svg("", Some(width), &backdrop).0)
    }

    /// The figure as a part of a page: as wide as there is room, at most its own width, in the page's colours. `place`
    /// keeps the names of one run apart from those of another. Below a `brief` figure there is only its title.
    pub fn to_page(&self, place: &str, brief: bool) -> Markup {
        html! {
            figure.flat[self.size.1 < self.size.0] id={ (place) (self.name) } {
                (self.svg(place, None, &html! {}))
                figcaption {
                    @if brief { (self.title) } @else { b { (self.title) "." } " " (self.caption) }
                }
            }
        }
    }

    fn svg(&self, place: &str, width: Option<u32>, backdrop: &Markup) -> Markup {
        let height = width.map(|_| self.size.1);
        let natural = width.is_none().then(|| format!("max-width:{}px", self.size.0));
        let [title, description] = ["title", "description"].map(|part| format!("{place}{}-{part}", self.name));
        html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (self.size.0) " " (self.size.1) } width=[width] height=[height]
                style=[natural] role="img" aria-labelledby={ (title) " " (description) } font-family=(TYPEFACES) {
                title id=(title) { (self.title) }
                desc id=(description) { (self.caption) }
                (backdrop)
                (PreEscaped(self.elements.replace(FIGURE, &format!("{place}{}", self.name))))
            }
        }
    }
}
