//! Arrays as pictures: one pixel per bin, in a perceptually uniform or a diverging colour scale.
//!
//! A pixel is transparent where there is nothing to show.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::draw_error::DrawError;

/// Number of colours of a picture; palette entry 0 is transparent.
const SHADES: usize = 255;

/// How values become colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Densities from 0 to this peak in the colours of viridis, transparent below a thousandth of the peak.
    Linear(f64),
    /// Densities from a thousandth of this peak to the peak on a logarithmic scale, as the opacity of a stencil that is
    /// filled with an ink; transparent below.
    Strength(f64),
    /// Differences from minus to plus this limit, from purple to orange; small ones fade.
    Difference(f64),
}

/// Smallest density shown, as a share of the peak.
pub const LEAST: f64 = 1e-3;
/// Opacity of the smallest density shown, where opacity stands for the density.
const FAINTEST: f64 = 0.2;

impl Scale {
    /// Red, green and blue of a shade.
    fn colour(self, shade: usize) -> [u8; 3] {
        let share = shade as f64 / (SHADES - 1) as f64;
        match self {
            Self::Linear(_) => colorous::VIRIDIS.eval_continuous(share).into_array(),
            Self::Difference(_) => colorous::PURPLE_ORANGE.eval_continuous(share).into_array(),
            // A mask lets the ink through where it is white.
            Self::Strength(_) => [u8::MAX; 3],
        }
    }

    /// Opacity of a shade: where differences are small, they fade into the page, whether it is light or dark.
    fn opacity(self, shade: usize) -> u8 {
        let share = shade as f64 / (SHADES - 1) as f64;
        let opacity = match self {
            Self::Linear(_) => 1.0,
            Self::Difference(_) => (2.0 * (2.0 * share - 1.0).abs()).min(1.0),
            Self::Strength(_) => FAINTEST + (1.0 - FAINTEST) * share,
        };
        (255.0 * opacity).round() as u8
    }

    /// Palette entry of a value.
    fn shade(self, value: f64) -> u8 {
        let position = match self {
            Self::Linear(peak) | Self::Strength(peak) if !(value >= LEAST * peak && peak > 0.0) => return 0,
            Self::Linear(peak) => value / peak,
            Self::Strength(peak) => 1.0 - (value / peak).log10() / LEAST.log10(),
            Self::Difference(limit) if !(limit > 0.0 && value.is_finite()) => return 0,
            Self::Difference(limit) => 0.5 + 0.5 * value / limit,
        };
        1 + (position.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as u8
    }
}

/// The colours of a scale from its lower to its upper end, three bytes per colour, in base64.
pub fn colours(scale: Scale) -> String {
    STANDARD.encode((0..SHADES).flat_map(|shade| scale.colour(shade)).collect::<Vec<u8>>())
}

/// The picture of an array over `(phi, e)`, `phi` outermost, as the address of an image. `phi` runs to the right and
/// `e` upwards.
///
/// # Errors
/// If the array does not have `phi_bins` x `e_bins` elements.
pub fn picture(values: &[f64], phi_bins: usize, e_bins: usize, scale: Scale) -> Result<String, DrawError> {
    if values.len() != phi_bins * e_bins || values.is_empty() {
        return Err(DrawError(format!("an array of {} elements is not {phi_bins} x {e_bins}", values.len())));
    }
    let columns: Vec<&[f64]> = values.chunks_exact(e_bins).collect();
    let rows = (0..e_bins).rev();
    let pixels: Vec<u8> = rows.flat_map(|j| columns.iter().map(move |column| scale.shade(column[j]))).collect();
    encode(&pixels, phi_bins, e_bins, scale)
}

/// The colours of a scale, from its lower end at the bottom to its upper end at the top.
///
/// # Errors
/// If the picture cannot be made.
pub fn ramp(scale: Scale) -> Result<String, DrawError> {
    let pixels: Vec<u8> = (0..SHADES).rev().map(|shade| 1 + shade as u8).collect();
    encode(&pixels, 1, SHADES, scale)
}

fn encode(pixels: &[u8], width: usize, height: usize, scale: Scale) -> Result<String, DrawError> {
    let failed = |error: png::EncodingError| DrawError(format!("a picture cannot be made: {error}"));
    let palette: Vec<u8> = [0; 3].into_iter().chain((0..SHADES).flat_map(|shade| scale.colour(shade))).collect();
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(palette);
    encoder.set_trns([0].into_iter().chain((0..SHADES).map(|shade| scale.opacity(shade))).collect::<Vec<u8>>());
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(failed)?;
    writer.write_image_data(pixels).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(file)))
}
