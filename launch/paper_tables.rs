//! The tables that a run prints: ours, and the paper's Table 3 and Table 4 beside them where they belong.

use std::collections::BTreeMap;
use std::path::Path;

use comfy_table::{CellAlignment, Table, presets};
use serde::Deserialize;

use crate::launch_file::Launch;

/// The tables as printed, for scenario 1.
const TABLE_3: &str = include_str!("paper/table-3.csv");
const TABLE_4: &str = include_str!("paper/table-4.csv");

/// The scenario that they are about.
const PAPER_SCENARIO: &str = "scenario-1";

/// What Table 3 lists, of a results folder's `moments.csv` or of the paper.
#[derive(Debug, Deserialize)]
struct MomentsRow {
    scenario: Option<String>,
    method: String,
    t_yr: f64,
    mean_phi_rad: f64,
    std_phi_rad: f64,
    mean_e: f64,
    std_e: f64,
}

impl MomentsRow {
    fn values(&self) -> [f64; 4] {
        [self.mean_phi_rad, self.std_phi_rad, self.mean_e, self.std_e]
    }
}

/// What Table 4 lists, of a results folder's `effort.csv` or of the paper.
#[derive(Debug, Deserialize)]
struct EffortRow {
    scenario: Option<String>,
    method: String,
    t_prop_s: f64,
    t_int_s: f64,
    t_cal_s: f64,
    ratio_to_mc: f64,
}

impl EffortRow {
    fn values(&self) -> [f64; 4] {
        [self.t_prop_s, self.t_int_s, self.t_cal_s, self.ratio_to_mc]
    }
}

/// Prints the tables of the results in `folder`.
pub fn print(launch: &Launch, folder: &Path) {
    let moments: Vec<MomentsRow> = read_file(&folder.join("moments.csv"));
    let effort: Vec<EffortRow> = read_file(&folder.join("effort.csv"));
    for scenario in &launch.scenarios {
        let name = &scenario.content.name;
        let of_scenario = |row: &Option<String>| row.as_deref() == Some(name.as_str());
        let is_papers = name == PAPER_SCENARIO;
        let beside = if is_papers { ", the paper's Table 3 in brackets" } else { "" };
        println!("\n{name}: mean and standard deviation{beside}");
        println!("{}", moments_table(moments.iter().filter(|row| of_scenario(&row.scenario)), is_papers));
        let beside = if is_papers { ", the paper's Table 4 in brackets" } else { "" };
        println!("\n{name}: computational effort (CPU time){beside}");
        println!("{}", effort_table(effort.iter().filter(|row| of_scenario(&row.scenario)), is_papers));
    }
}

fn read_file<T: for<'de> Deserialize<'de>>(path: &Path) -> Vec<T> {
    csv::Reader::from_path(path).map(|mut reader| reader.deserialize().flatten().collect()).unwrap_or_default()
}

fn read_text<T: for<'de> Deserialize<'de>>(text: &str) -> Vec<T> {
    csv::Reader::from_reader(text.as_bytes()).deserialize().flatten().collect()
}

fn new_table(header: Vec<String>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    let columns = header.len();
    table.set_header(header);
    for column in 2..columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

fn moments_table<'a>(rows: impl Iterator<Item = &'a MomentsRow>, beside_paper: bool) -> Table {
    let paper: Vec<MomentsRow> = if beside_paper { read_text(TABLE_3) } else { Vec::new() };
    let mut methods: Vec<(&str, BTreeMap<u64, &MomentsRow>)> = Vec::new();
    for row in rows {
        if methods.last().is_none_or(|(method, _)| *method != row.method) {
            methods.push((&row.method, BTreeMap::new()));
        }
        if let Some((_, snapshots)) = methods.last_mut() {
            snapshots.insert(row.t_yr.to_bits(), row);
        }
    }
    let times: Vec<f64> =
        methods.first().map(|(_, rows)| rows.values().map(|row| row.t_yr).collect()).unwrap_or_default();
    let header = ["method".to_owned(), String::new()].into_iter();
    let mut table = new_table(header.chain(times.iter().map(|t| format!("t = {t} yr"))).collect());
    for (method, snapshots) in &methods {
        for (quantity, symbol) in ["μ_φ, rad", "σ_φ, rad", "μ_e", "σ_e"].iter().enumerate() {
            let cells = snapshots.values().map(|row| {
                let ours = format!("{:.5}", row.values()[quantity]);
                let printed = paper.iter().find(|p| p.method == *method && p.t_yr == row.t_yr);
                printed.map_or(ours.clone(), |p| format!("{ours} ({:.5})", p.values()[quantity]))
            });
            let name = if quantity == 0 { *method } else { "" };
            table.add_row([name.to_owned(), (*symbol).to_owned()].into_iter().chain(cells).collect::<Vec<_>>());
        }
    }
    table
}

fn effort_table<'a>(rows: impl Iterator<Item = &'a EffortRow>, beside_paper: bool) -> Table {
    let paper: Vec<EffortRow> = if beside_paper { read_text(TABLE_4) } else { Vec::new() };
    let header = ["method", "", "t_prop, s", "t_int, s", "t_cal, s", "t_cal / t_cal-MC"];
    let mut table = new_table(header.map(str::to_owned).to_vec());
    for row in rows {
        let printed = paper.iter().find(|p| p.method == row.method);
        let cells = row.values().into_iter().enumerate().map(|(i, ours)| {
            let ours = format!("{ours:.4}");
            printed.map_or(ours.clone(), |p| format!("{ours} ({})", p.values()[i]))
        });
        table.add_row([row.method.clone(), String::new()].into_iter().chain(cells).collect::<Vec<_>>());
    }
    table
}
