//! Orbits on their way, of whichever model.

use std::fmt::Debug;

use crate::flow::Passages;
use crate::model::Model;
use crate::orbits::{LostOrbit, Orbits};

/// Orbits of any model.
pub trait Cloud: Debug + Send {
    /// Moves all orbits to a time \[yr\] and notes when each first reached the critical value.
    ///
    /// # Errors
    /// [`LostOrbit`] names the first orbit that cannot be followed.
    fn advance_watching(&mut self, time: f64, critical: f64, passages: Passages<'_, u8>) -> Result<(), LostOrbit>;

    /// How far it should be moved at a time, if that takes long \[yr\].
    fn stride(&self) -> Option<f64> {
        None
    }

    /// Prepares what is read out where the orbits are now.
    ///
    /// # Errors
    /// [`LostOrbit`] names the first orbit that cannot be followed for it.
    fn settle(&mut self) -> Result<(), LostOrbit> {
        Ok(())
    }

    /// Writes the variables of all orbits, one column after the other; NaN in the columns of variables that the model
    /// does not have.
    fn read_out(&self, columns: &mut [f64]);
}

impl<M: Model> Cloud for Orbits<M> {
    fn advance_watching(&mut self, time: f64, critical: f64, passages: Passages<'_, u8>) -> Result<(), LostOrbit> {
        Orbits::advance_watching(self, time, critical, passages)
    }

    fn read_out(&self, columns: &mut [f64]) {
        self.read_out_columns(&mut columns.chunks_exact_mut(self.len().max(1)).collect::<Vec<_>>());
    }
}
