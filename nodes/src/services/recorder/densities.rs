//! Which arrays a snapshot has in `densities.npz`.

use density::standard_errors::of_density;
use results::FolderError;
use results::arrays::{ArrayWriter, Place, edges, standard_error};

use crate::services::reading::Reading;
use kit::kind::counted_samples;

/// Adds the densities of `method` at a snapshot, and the edges of their bins.
pub(super) fn add(
    archive: &mut ArrayWriter,
    scenario: &str,
    method: &str,
    reading: &Reading,
) -> Result<(), FolderError> {
    let Reading { header, space, axes, .. } = reading;
    let place = Place::new(scenario, method, header.index as usize);
    for (number, projection) in space.projections.iter().enumerate() {
        let (name, density) = (space.density_name(projection), reading.density(number));
        let shape: Vec<usize> = projection.axes().map(|(_, bins)| bins).collect();
        archive.add(&place.name(&name), &shape, density)?;
        if let Some(samples) = counted_samples(header).filter(|_| shape.len() == 2) {
            let errors = of_density(density, samples as usize, reading.cell(number));
            archive.add(&place.name(&standard_error(&name)), &shape, &errors)?;
        }
    }
    for (variable, axis) in axes.iter().enumerate().filter(|(_, axis)| axis.bins > 0) {
        archive.add(&place.name(&edges(space.symbol(variable))), &[axis.bins + 1], &axis.edges())?;
    }
    Ok(())
}
