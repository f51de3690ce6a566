//! The kinds of snapshots: what their columns are, and which further fields their headers have.
//!
//! Every kind of snapshot has a code and an entry in the registry in this file. All else about a kind is in a file of
//! its own: the names of its columns, the fields that it has beyond those of all kinds (its details), the conversion
//! between these fields and a value, and how its columns are written. The details are sent in an area of
//! [`SnapshotHeader`] that is the same for all kinds; at the beginning of that area each kind has a `repr(C)`
//! structure of its own. A receiver of a snapshot decodes it once, to a [`Content`].

mod characteristics;
mod density;
mod header;
mod mixture;
mod reduced;
mod samples;

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::describe::{Described, Field, FieldType, codes, header};

pub use characteristics::{Characteristics, Lattice, MOST_RESOLUTION};
pub use density::{DENSITY_HEAD, Density};
pub use header::SnapshotHeader;
pub use mixture::Mixture;
pub use reduced::Reduced;
pub use samples::Samples;

codes! {
    /// What a snapshot's columns are.
    pub mod kind {
        /// Equally weighted samples: `phi` \[rad\], `e`.
        pub const SAMPLES: u32 = 1;
        /// Characteristics: `phi` \[rad\], `e`, density `n` \[1/rad\] carried along.
        pub const CHARACTERISTICS: u32 = 2;
        /// A density on the comparison grid, in one column: [`DENSITY_HEAD`](super::DENSITY_HEAD) numbers in the plane
        /// (the six moments, circular mean \[rad\] and resultant length of `phi`, error estimates of the moments in
        /// standard deviations, of the resultant vector, of the probability and of the joint density in L1), then the
        /// joint density \[1/rad\], `phi` outermost. NaN in place of any of the first eight numbers, or of the whole
        /// joint density, means that the method withholds it. The error estimates give the accuracy that was reached: 0
        /// or more, infinity if it is not known, never NaN.
        pub const DENSITY: u32 = 4;
        /// Samples that their propagator has reduced to counts and sums, in one column of whole numbers: the number
        /// of samples, how many of them are above the critical eccentricity, how many sectors of the circle hold any;
        /// four sums over all samples; for each such sector its number, its number of samples, and ten sums; the
        /// number of samples in each bin of the comparison grid, `phi` outermost. A sum is two numbers,
        /// `high * 2^52 + low`, in units of 2^-60; `density/src/sample_sums/` says which sums.
        pub const REDUCED: u32 = 5;
        /// A Gaussian mixture: weight, mean `phi` \[rad\], mean `e`, variance of `phi` \[rad²\], covariance \[rad\],
        /// variance of `e`.
        pub const MIXTURE: u32 = 3;
    }
}

codes! {
    /// How the estimator computes a density from characteristics.
    pub mod treatment {
        /// Triangles of the initial points, carried by the flow, each with its probability.
        pub const CARRIED_MESH: u32 = 0;
        /// Delaunay triangulation of the final points and linear interpolation of `n`.
        pub const HULL_MESH: u32 = 1;
        /// As `HULL_MESH`, but with `phi` cut open at 0, as the paper printed it.
        pub const HULL_MESH_AS_PRINTED: u32 = 2;
    }
}

/// 64-bit words of the area that holds the details.
pub const DETAIL_WORDS: usize = 8;

/// The details of a snapshot as they are sent: the structure of its kind, then zeros.
pub type Details = [u64; DETAIL_WORDS];

/// A kind of snapshot.
pub trait Kind: Sized {
    /// Its code, see [`kind`].
    const CODE: u32;
    /// The names of its columns in the plane, with units.
    const COLUMNS: &'static [&'static str];
    /// Its fields beyond those of all snapshots.
    type Details: Described;

    /// How many columns it has in a space of `variables` variables.
    fn column_count(variables: usize) -> usize;

    /// Its fields as they are sent.
    fn to_details(self) -> Self::Details;

    /// The value that the fields stand for.
    ///
    /// # Errors
    /// If a field has a value that is not allowed: which one.
    fn from_details(details: Self::Details) -> Result<Self, String>;
}

/// The properties of a kind that are the same for all its snapshots.
#[derive(Debug, Clone, Copy)]
pub struct KindTable {
    /// The kind.
    pub kind: SnapshotKind,
    /// The names of its columns, with units.
    pub columns: &'static [&'static str],
    /// The name of its details.
    pub details_name: &'static str,
    /// The doc comment of its details, line by line.
    pub details_doc: &'static [&'static str],
    /// The fields of its details, with offsets from the beginning of the area.
    pub details: &'static [Field],
}

/// The registry: an enumeration of all kinds.
macro_rules! kinds {
    ($($(#[doc = $doc:literal])* $kind:ident),+ $(,)?) => {
        /// The kind of a snapshot, with the fields that this kind has.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Content {
            $($(#[doc = $doc])* $kind($kind)),+
        }

        /// A kind of snapshot, without the fields that it has.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum SnapshotKind {
            $($(#[doc = $doc])* $kind),+
        }

        impl SnapshotKind {
            /// All kinds.
            pub const ALL: &[Self] = &[$(Self::$kind),+];

            /// Its code, see [`kind`].
            pub const fn code(self) -> u32 {
                match self { $(Self::$kind => <$kind as Kind>::CODE),+ }
            }

            /// The kind with this code; `None` for a code that this version does not know.
            pub fn of_code(code: u32) -> Option<Self> {
                Self::ALL.iter().copied().find(|kind| kind.code() == code)
            }
        }

        $(impl From<$kind> for Content {
            fn from(kind: $kind) -> Self {
                Self::$kind(kind)
            }
        })+

        /// All kinds.
        pub const KINDS: &[KindTable] = &[$(KindTable {
            kind: SnapshotKind::$kind,
            columns: <$kind as Kind>::COLUMNS,
            details_name: <<$kind as Kind>::Details as Described>::TYPE_NAME,
            details_doc: <<$kind as Kind>::Details as Described>::DOC,
            details: <<$kind as Kind>::Details as Described>::FIELDS,
        }),+];

        $(const _: () = assert!(size_of::<<$kind as Kind>::Details>() <= size_of::<Details>());)+

        impl Content {
            /// Its kind.
            pub const fn kind(self) -> SnapshotKind {
                match self { $(Self::$kind(_) => SnapshotKind::$kind),+ }
            }

            /// How many columns it has in a space of `variables` variables.
            pub fn column_count(self, variables: usize) -> usize {
                match self { $(Self::$kind(_) => <$kind as Kind>::column_count(variables)),+ }
            }

            /// Its details as they are sent.
            pub fn details(self) -> Details {
                match self { $(Self::$kind(kind) => in_area(&kind.to_details())),+ }
            }

            /// The content of kind `code` with these details.
            ///
            /// # Errors
            /// If there is no such kind, or a field has a value that is not allowed.
            pub fn decode(code: u32, details: &Details) -> Result<Self, String> {
                match code {
                    $(<$kind as Kind>::CODE => {
                        <$kind as Kind>::from_details(from_area(details)).map(Self::$kind)
                    })+
                    other => Err(format!("its kind {other} is unknown to this version")),
                }
            }
        }
    };
}

kinds!(
    /// Equally weighted samples.
    Samples,
    /// Points that carry a density along.
    Characteristics,
    /// A Gaussian mixture.
    Mixture,
    /// A density on the comparison grid.
    Density,
    /// Samples that their propagator has reduced to counts and sums.
    Reduced,
);

/// The table of a kind; `None` for a kind that this version does not know.
pub fn table(code: u32) -> Option<&'static KindTable> {
    KINDS.iter().find(|table| table.kind.code() == code)
}

/// The fields that a header has in addition because of its kind, with offsets from the beginning of the header.
pub(crate) fn fields(header: &SnapshotHeader) -> Vec<(String, Field)> {
    let area = std::mem::offset_of!(SnapshotHeader, details);
    let fields = table(header.kind).map_or(&[][..], |kind| kind.details);
    let named = |field: &Field| (field.name.to_owned(), Field { offset: area + field.offset, ..*field });
    fields.iter().filter(|field| field.name != "reserved").map(named).collect()
}

fn in_area<D: Pod>(details: &D) -> Details {
    let mut area = Details::default();
    bytemuck::cast_slice_mut(&mut area)[..size_of::<D>()].copy_from_slice(bytemuck::bytes_of(details));
    area
}

fn from_area<D: Pod>(area: &Details) -> D {
    bytemuck::pod_read_unaligned(&bytemuck::cast_slice(area)[..size_of::<D>()])
}

/// The columns of a snapshot that has `N` of them, all of one length.
fn split<const N: usize>(items: &mut [f64]) -> [&mut [f64]; N] {
    let rows = (items.len() / N).max(1);
    let mut columns = items.chunks_exact_mut(rows);
    std::array::from_fn(|_| columns.next().unwrap_or_default())
}

header! {
    /// The details of a kind that has none of its own.
    #[type_name("phasecloud/SnapshotHeader/5/NoDetails")]
    pub struct NoDetails {
        /// 0.
        pub reserved: u64,
    }
}

#[cfg(test)]
mod tests {
    use super::characteristics::CharacteristicsDetails;
    use super::*;

    #[test]
    fn every_content_survives_the_way_through_a_header() {
        let carried = |lattice| Characteristics::CarriedMesh { lattice };
        let hull = |as_printed| Characteristics::HullMesh { resolution: MOST_RESOLUTION, as_printed };
        let contents: [Content; 8] = [
            Samples { replicates: 3 }.into(),
            carried(None).into(),
            carried(Some(Lattice { side: 31, degree: 7 })).into(),
            hull(false).into(),
            hull(true).into(),
            Mixture { disagreement: 0.25 }.into(),
            Density.into(),
            Reduced.into(),
        ];
        for content in contents {
            let header = SnapshotHeader::default().with(content);
            assert_eq!(header.content(), Ok(content));
            assert_eq!(header.columns as usize, table(header.kind).unwrap().columns.len());
            assert!(content.column_count(3) >= content.column_count(2));
        }
    }

    #[test]
    fn what_no_kind_can_be_is_refused_in_words() {
        let refused = |kind, details, words: &str| {
            let why = SnapshotHeader { kind, details, ..SnapshotHeader::default() }.content().unwrap_err();
            assert!(why.contains(words), "{why}");
        };
        refused(99, Details::default(), "its kind 99 is unknown");
        let characteristics = |details: CharacteristicsDetails| in_area(&details);
        let good = CharacteristicsDetails { treatment: treatment::HULL_MESH, resolution: 10, lattice: 0, degree: 0 };
        let bad = characteristics(CharacteristicsDetails { treatment: 7, ..good });
        refused(kind::CHARACTERISTICS, bad, "its treatment 7 is unknown");
        let bad = characteristics(CharacteristicsDetails { resolution: 20_001, ..good });
        refused(kind::CHARACTERISTICS, bad, "its resolution is 20001, at most 20000");
    }

    #[test]
    fn writers_fill_the_columns_of_their_kind() {
        let mut items = [0.0; 12];
        Mixture::write_row(&mut items, 1, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(items, [0.0, 1.0, 0.0, 2.0, 0.0, 3.0, 0.0, 4.0, 0.0, 5.0, 0.0, 6.0]);
        let [phi, e] = Samples::columns(&mut items);
        assert_eq!((phi.len(), e[0]), (6, 0.0));
        assert_eq!(Characteristics::columns(&mut []).map(|column| column.len()), [0; 3]);
    }
}
