//! Texts on which a reader of TOML files must not fail: noise, good files with changes, and nonsense in the right
//! places.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};

/// The bytes of a file, shown as text.
#[derive(Clone)]
pub struct Bytes(pub Vec<u8>);

impl std::fmt::Debug for Bytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "\"{}\"", self.0.escape_ascii())
    }
}

/// Good scenario files.
pub const SCENARIO_FILES: [&str; 4] = [
    include_str!("../launch/scenarios/scenario-1.toml"),
    include_str!("../launch/models/vectorial.toml"),
    include_str!("../launch/models/osculating.toml"),
    "name = \"mine\"\norbit = { semi_major_axis = 2.5, area_to_mass = 10, reflectivity = 1.2 }\ninitial.phi = 1.0\n\
     initial.e = 0.1\ninitial.delta_phi = 0.1\ninitial.delta_e = 0.01\n[times]\nend = 1\nstep = 0.25\n\
     [disposal]\ncritical_e = 0.5\n",
];

/// Good launch files.
pub const LAUNCH_FILES: [&str; 3] = [
    include_str!("../launch/scenario-1.toml"),
    include_str!("../launch/as-printed.toml"),
    "name = \"l\"\nscenarios = [\n  \"s.toml\", # one\n]\nreference = \"a\"\nbins = [10, 20]\npatience = 5.0\n\
     propagator = [{ label = \"a\", command = [\"./a\", \"-x\"] }, { label = \"b\", node = \"dee\", degree = 2 }]\n",
];

/// What a mutation may put at any place.
const TOKENS: [&str; 72] = [
    "0",
    "-0",
    "-1",
    "1",
    "1.5",
    "1e400",
    "-1e400",
    "1e-400",
    "1e308",
    "5e-324",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "0.1.2",
    "1_000_000_000_000",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775808",
    "0x7fffffffffffffff",
    "18446744073709551616",
    "0b11",
    "0o777",
    "1979-05-27T07:32:00Z",
    "07:32:00",
    "true",
    "false",
    "\"\"",
    "\"mc\"",
    "''",
    "\"x",
    "\"\"\"",
    "'''",
    "\"\\u0000\"",
    "\"\\u001b[2J\"",
    "\"\\uD800\"",
    "\"../../etc/passwd\"",
    "\"/dev/zero\"",
    "\"a/b\"",
    "\"..\"",
    "\"ä\u{202e}\u{0301}\"",
    "\u{feff}",
    "\0",
    "\u{7f}",
    "\r",
    "\r\n",
    "\n",
    "\t",
    "#",
    "=",
    ".",
    ",",
    "[",
    "]",
    "[[",
    "]]",
    "{",
    "}",
    "[]",
    "{}",
    "[[propagator]]",
    "[orbit]",
    "[times]",
    "\norbit.",
    "\nname = 1\n",
    "\nbins = [1, 1]\n",
    "\nlabel = \"mc\"\n",
    "\nnode = \"mc\"\n",
    "\ncommand = [\"x\"]\n",
    "\nsamples = -5\n",
    "\npatience = nan\n",
    "\nseed = 1.5\n",
];

/// What a mutation may put at any place, many times over.
const MANY: [&str; 8] = ["[", "{a=", "a.", "x", "\"", "\n", "[[a]]\n", "ä"];

/// One change to a text.
#[derive(Debug, Clone)]
enum Change {
    Delete(Index, u8),
    Repeat(Index, u8),
    SetByte(Index, u8),
    Insert(Index, &'static str),
    InsertMany(Index, &'static str, u16),
    SetValue(Index, &'static str),
    SwapLines(Index, Index),
    DeleteLine(Index),
    RepeatLine(Index),
    Truncate(Index),
}

fn change() -> impl Strategy<Value = Change> {
    let token = || select(&TOKENS[..]);
    prop_oneof![
        1 => any::<(Index, u8)>().prop_map(|(at, length)| Change::Delete(at, length)),
        1 => any::<(Index, u8)>().prop_map(|(at, length)| Change::Repeat(at, length)),
        1 => any::<(Index, u8)>().prop_map(|(at, byte)| Change::SetByte(at, byte)),
        1 => (any::<Index>(), token()).prop_map(|(at, token)| Change::Insert(at, token)),
        1 => (any::<Index>(), select(&MANY[..]), 0u16..2000)
            .prop_map(|(at, token, times)| Change::InsertMany(at, token, times)),
        4 => (any::<Index>(), token()).prop_map(|(at, token)| Change::SetValue(at, token)),
        1 => any::<(Index, Index)>().prop_map(|(a, b)| Change::SwapLines(a, b)),
        2 => any::<Index>().prop_map(Change::DeleteLine),
        1 => any::<Index>().prop_map(Change::RepeatLine),
        1 => any::<Index>().prop_map(Change::Truncate),
    ]
}

fn apply(change: &Change, bytes: &mut Vec<u8>) {
    let size = bytes.len() + 1;
    let end = |start: usize, length: u8| (start + usize::from(length)).min(size - 1);
    match change {
        Change::Delete(at, length) => drop(bytes.drain(at.index(size)..end(at.index(size), *length))),
        Change::Repeat(at, length) => bytes.extend_from_within(at.index(size)..end(at.index(size), *length)),
        Change::SetByte(at, byte) if size > 1 => bytes[at.index(size - 1)] = *byte,
        Change::SetByte(..) => {}
        Change::Insert(at, token) => drop(bytes.splice(at.index(size)..at.index(size), token.bytes())),
        Change::InsertMany(at, token, times) => {
            let many = token.repeat(usize::from(*times));
            drop(bytes.splice(at.index(size)..at.index(size), many.bytes()));
        }
        Change::Truncate(at) => bytes.truncate(at.index(size)),
        Change::SetValue(..) | Change::SwapLines(..) | Change::DeleteLine(..) | Change::RepeatLine(..) => {
            let mut lines: Vec<Vec<u8>> = bytes.split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
            change_lines(change, &mut lines);
            *bytes = lines.join(&b'\n');
        }
    }
}

fn change_lines(change: &Change, lines: &mut Vec<Vec<u8>>) {
    let count = lines.len();
    match change {
        Change::SetValue(at, token) => {
            let with_value: Vec<usize> = (0..count).filter(|&k| lines[k].contains(&b'=')).collect();
            if !with_value.is_empty() {
                let line = &mut lines[*at.get(&with_value)];
                let equals = line.iter().position(|&byte| byte == b'=').unwrap_or(0);
                line.truncate(equals + 1);
                line.extend(token.bytes());
            }
        }
        Change::SwapLines(a, b) => lines.swap(a.index(count), b.index(count)),
        Change::DeleteLine(at) => drop(lines.remove(at.index(count))),
        Change::RepeatLine(at) => {
            let line = lines[at.index(count)].clone();
            lines.push(line);
        }
        _ => {}
    }
}

/// A good file with some changes.
fn gone_bad(files: &'static [&'static str]) -> impl Strategy<Value = Vec<u8>> {
    (select(files), vec(change(), 1..6)).prop_map(|(file, changes)| {
        let mut bytes = file.as_bytes().to_vec();
        for change in &changes {
            apply(change, &mut bytes);
        }
        bytes
    })
}

/// Bytes, tokens in any order, and good files with changes; mostly the latter.
pub fn texts(files: &'static [&'static str]) -> impl Strategy<Value = Bytes> {
    let soup = vec(select(&TOKENS[..]), 0..40).prop_map(|tokens| tokens.concat().into_bytes());
    prop_oneof![1 => vec(any::<u8>(), 0..300), 1 => soup, 8 => gone_bad(files)].prop_map(Bytes)
}
