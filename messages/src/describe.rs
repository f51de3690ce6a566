//! Tables of the layouts: fields, offsets, codes and their meaning, taken from the doc comments in [`layout`].
//!
//! `docs/messages.md`, `phasecloud echo` and recordings all read these tables, so that nothing is written down twice.
//!
//! [`layout`]: crate::layout

use std::fmt;

use bytemuck::Pod;

/// A header or an item of a payload whose fields are known by name.
pub trait Described: Pod {
    /// The name that iceoryx2 compares, with the version.
    const TYPE_NAME: &'static str;
    /// The doc comment, line by line.
    const DOC: &'static [&'static str];
    /// The fields, in order.
    const FIELDS: &'static [Field];
}

/// A field of a header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub kind: FieldKind,
    /// Where it starts, in bytes.
    pub offset: usize,
    /// The unit of a number; empty if it is a pure number, or if it is a list, whose numbers may have different units.
    pub unit: &'static str,
    /// The codes that its values are, if they are some.
    pub codes: Option<&'static Codes>,
    /// The doc comment, line by line.
    pub doc: &'static [&'static str],
}

/// The types that fields may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FieldKind {
    /// 64-bit unsigned integer.
    U64,
    /// 32-bit unsigned integer.
    U32,
    /// 64-bit floating-point number.
    F64,
    /// The given number of 64-bit floating-point numbers.
    F64s(usize),
    /// NUL-padded UTF-8 of the given number of bytes.
    Text(usize),
    /// The given number of 64-bit words, whose meaning depends on another field.
    Words(usize),
    /// A list of structures of one type, of which only the first ones are in use.
    Entries(Entries),
}

/// A list of structures in a header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entries {
    /// The structure's name.
    pub name: &'static str,
    /// How many there are.
    pub count: usize,
    /// How long one is, in bytes.
    pub size: usize,
    /// Its doc comment, line by line.
    pub doc: &'static [&'static str],
    /// Its fields, with offsets from its beginning.
    pub fields: &'static [Field],
}

impl fmt::Display for FieldKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::U64 => write!(f, "u64"),
            Self::U32 => write!(f, "u32"),
            Self::F64 => write!(f, "f64"),
            Self::F64s(count) => write!(f, "f64 x {count}"),
            Self::Text(bytes) => write!(f, "text, {bytes} bytes"),
            Self::Words(count) => write!(f, "{} bytes", 8 * count),
            Self::Entries(Entries { name, count, .. }) => write!(f, "{count} x {name}"),
        }
    }
}

/// A type that a field may have.
pub trait FieldType {
    /// Its kind.
    const KIND: FieldKind;
}

impl FieldType for u64 {
    const KIND: FieldKind = FieldKind::U64;
}
impl FieldType for u32 {
    const KIND: FieldKind = FieldKind::U32;
}
impl FieldType for f64 {
    const KIND: FieldKind = FieldKind::F64;
}
impl<const N: usize> FieldType for [f64; N] {
    const KIND: FieldKind = FieldKind::F64s(N);
}
impl<const N: usize> FieldType for [u8; N] {
    const KIND: FieldKind = FieldKind::Text(N);
}
impl<const N: usize> FieldType for [u64; N] {
    const KIND: FieldKind = FieldKind::Words(N);
}
impl<T: Described, const N: usize> FieldType for [T; N] {
    const KIND: FieldKind = FieldKind::Entries(Entries {
        name: T::TYPE_NAME,
        count: N,
        size: size_of::<T>(),
        doc: T::DOC,
        fields: T::FIELDS,
    });
}

/// The value of a field.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A whole number.
    Whole(u64),
    /// Real numbers.
    Real(Vec<f64>),
    /// Text.
    Text(String),
}

impl Field {
    /// The field's value in a header with these bytes; `None` if there are too few bytes, or if the field is a list
    /// or words, which have fields of their own.
    pub fn value(&self, header: &[u8]) -> Option<Value> {
        let bytes = header.get(self.offset..)?;
        let real = |chunk: &[u8]| chunk.try_into().ok().map(f64::from_ne_bytes);
        Some(match self.kind {
            FieldKind::U64 => Value::Whole(u64::from_ne_bytes(*bytes.first_chunk()?)),
            FieldKind::U32 => Value::Whole(u32::from_ne_bytes(*bytes.first_chunk()?).into()),
            FieldKind::F64 => Value::Real(vec![f64::from_ne_bytes(*bytes.first_chunk()?)]),
            FieldKind::F64s(count) => Value::Real(bytes.get(..8 * count)?.chunks_exact(8).filter_map(real).collect()),
            FieldKind::Text(count) => Value::Text(crate::text::unpack(bytes.get(..count)?)),
            FieldKind::Words(_) | FieldKind::Entries(_) => return None,
        })
    }
}

/// A group of numeric codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Codes {
    /// The name of the group.
    pub name: &'static str,
    /// The doc comment, line by line.
    pub doc: &'static [&'static str],
    /// The codes.
    pub codes: &'static [Code],
}

/// A numeric code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Code {
    /// Its name.
    pub name: &'static str,
    /// The number.
    pub value: u32,
    /// The doc comment, line by line.
    pub doc: &'static [&'static str],
}

impl Codes {
    /// The name of a code.
    pub fn name_of(&self, value: u64) -> Option<&'static str> {
        self.codes.iter().find(|code| u64::from(code.value) == value).map(|code| code.name)
    }
}

/// A doc comment in one line, with its links as plain words.
pub fn plain(doc: &[&str]) -> String {
    let mut text =
        doc.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ").replace("\\[", "{").replace("\\]", "}");
    // [`NAME`](path) and [`NAME`] become `NAME`.
    while let Some(start) = text.find("[`") {
        let Some(end) = text[start..].find("`]").map(|length| start + length) else { break };
        let name = text[start + 1..=end].to_owned();
        let rest = &text[end + 2..];
        let after = match rest.strip_prefix('(').and_then(|rest| rest.find(')')) {
            Some(length) => end + 2 + length + 2,
            None => end + 2,
        };
        text.replace_range(start..after, &name);
    }
    text.replace('{', "[").replace('}', "]")
}

/// The only one of at most one.
pub const fn first(codes: &[&'static Codes]) -> Option<&'static Codes> {
    match codes {
        [] => None,
        [codes, ..] => Some(codes),
    }
}

/// Defines a header: the structure itself, and the table of its fields.
macro_rules! header {
    (
        $(#[doc = $doc:literal])*
        #[type_name($type_name:literal)]
        $(#[$other:meta])*
        pub struct $name:ident {
            $( $(#[doc = $field_doc:literal])* pub $field:ident: $kind:ty $([unit $unit:literal])? $([codes $codes:path])?, )*
        }
    ) => {
        $(#[doc = $doc])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, ZeroCopySend, Pod, Zeroable)]
        #[type_name($type_name)]
        $(#[$other])*
        pub struct $name {
            $( $(#[doc = $field_doc])* pub $field: $kind, )*
        }

        impl Described for $name {
            const TYPE_NAME: &'static str = $type_name;
            const DOC: &'static [&'static str] = &[$($doc),*];
            const FIELDS: &'static [Field] = &[$(
                Field {
                    name: stringify!($field),
                    kind: <$kind as FieldType>::KIND,
                    offset: std::mem::offset_of!($name, $field),
                    unit: concat!($($unit)?),
                    codes: $crate::describe::first(&[$(&$codes)?]),
                    doc: &[$($field_doc),*],
                },
            )*];
        }

        impl Default for $name {
            fn default() -> Self {
                Self::zeroed()
            }
        }
    };
}

/// Defines a module of codes: the codes themselves, and their table.
macro_rules! codes {
    (
        $(#[doc = $doc:literal])*
        pub mod $name:ident {
            $( $(#[doc = $code_doc:literal])* pub const $code:ident: u32 = $value:literal; )*
        }
    ) => {
        $(#[doc = $doc])*
        pub mod $name {
            use crate::describe::{Code, Codes};

            $( $(#[doc = $code_doc])* pub const $code: u32 = $value; )*

            /// The table of these codes.
            pub const CODES: Codes = Codes {
                name: stringify!($name),
                doc: &[$($doc),*],
                codes: &[$( Code { name: stringify!($code), value: $value, doc: &[$($code_doc),*] }, )*],
            };
        }
    };
}

pub(crate) use {codes, header};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{DensityHeader, SnapshotHeader, StatusHeader, event};
    use crate::text::pack;
    use crate::topic::{Snapshot, Topic};

    fn field<T: Described>(name: &str) -> &'static Field {
        T::FIELDS.iter().find(|field| field.name == name).unwrap()
    }

    #[test]
    fn every_field_is_documented_and_fields_cover_the_header_without_gaps() {
        fn check<T: Described>() {
            let mut end = 0;
            for field in T::FIELDS {
                assert_eq!(field.offset, end, "{}.{}", T::TYPE_NAME, field.name);
                assert!(!plain(field.doc).is_empty(), "{}.{}", T::TYPE_NAME, field.name);
                end += match field.kind {
                    FieldKind::U64 | FieldKind::F64 => 8,
                    FieldKind::U32 => 4,
                    FieldKind::F64s(count) => 8 * count,
                    FieldKind::Text(bytes) => bytes,
                    FieldKind::Words(count) => 8 * count,
                    FieldKind::Entries(entries) => entries.count * entries.size,
                };
            }
            assert_eq!(end, size_of::<T>());
        }
        crate::topic::for_each(&mut Check);
        struct Check;
        impl crate::topic::Visitor for Check {
            type Out = ();
            fn visit<T: crate::topic::Topic>(&mut self) {
                check::<T::Header>();
            }
        }
    }

    #[test]
    fn values_units_and_codes_come_from_the_field() {
        let header = StatusHeader { event: event::PROGRESS, node: pack("mc"), ..StatusHeader::default() };
        let bytes = bytemuck::bytes_of(&header);
        assert_eq!(field::<StatusHeader>("event").value(bytes), Some(Value::Whole(2)));
        assert_eq!(field::<StatusHeader>("event").codes.unwrap().name_of(2), Some("PROGRESS"));
        assert_eq!(field::<StatusHeader>("node").value(bytes), Some(Value::Text("mc".into())));
        assert_eq!(field::<SnapshotHeader>("time").unit, "yr");
        assert_eq!(field::<SnapshotHeader>("kind").codes.unwrap().name, "kind");
        assert_eq!(field::<DensityHeader>("diagnostics").unit, "", "its numbers have different units");
        assert_eq!(field::<DensityHeader>("diagnostics").value(&bytes[..40]), None);
    }

    #[test]
    fn the_details_of_a_header_are_told_by_the_names_that_its_kind_has() {
        let header = SnapshotHeader::default().with(crate::content::Samples { replicates: 5 });
        let told =
            |header| Snapshot::values(header).into_iter().map(|(name, _, value)| (name, value)).collect::<Vec<_>>();
        assert!(told(&header).contains(&("replicates".into(), Value::Whole(5))));
        let header = header.with(crate::content::Mixture { disagreement: 0.25 });
        assert!(told(&header).contains(&("disagreement".into(), Value::Real(vec![0.25]))));
        assert!(told(&header).iter().all(|(name, _)| name != "replicates" && name != "details"));
    }

    #[test]
    fn links_in_doc_comments_become_plain_words() {
        assert_eq!(plain(&[" See [`X`](super::X) and", " [`Y`], \\[rad\\]."]), "See `X` and `Y`, [rad].");
    }
}
