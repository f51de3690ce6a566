//! The files of a results folder: CSV tables with full precision, and the densities as numpy arrays.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use density::grid::Axis;
use messages::layout::{DensityHeader, ERROR_COLUMNS, comparison};
use messages::text::unpack;
use npyz::npz::NpzWriter;
use npyz::zip::{CompressionMethod, DateTime, write::FileOptions};
use npyz::{NpyWriter, WriterBuilder};
use serde::Serialize;

use super::{RecordedDensity, Recording};
use crate::comparator::QUANTITIES;
use crate::failure::Failure;
use crate::roster::Roster;

/// A row of `moments.csv`.
#[derive(Debug, Serialize)]
struct MomentsRow<'a> {
    scenario: &'a str,
    method: &'a str,
    t_yr: f64,
    mean_phi_rad: f64,
    std_phi_rad: f64,
    mean_e: f64,
    std_e: f64,
    cov_phi_e: f64,
    prob_above_critical_e: f64,
    se_mean_phi_rad: f64,
    se_std_phi_rad: f64,
    se_mean_e: f64,
    se_std_e: f64,
    se_cov_phi_e: f64,
    se_prob_above_critical_e: f64,
    circular_mean_phi_rad: f64,
    resultant_length: f64,
    mass_on_grid: f64,
}

/// A row of `errors.csv`.
#[derive(Debug, Serialize)]
struct ErrorRow<'a> {
    scenario: &'a str,
    method: &'a str,
    reference: &'a str,
    t_yr: f64,
    quantity: &'a str,
    value: f64,
    reference_value: f64,
    abs_error: f64,
    rel_error: f64,
}

/// A row of `effort.csv`.
#[derive(Debug, Serialize)]
struct EffortRow<'a> {
    scenario: &'a str,
    method: &'a str,
    t_prop_s: f64,
    t_int_s: f64,
    t_cal_s: f64,
    ratio_to_mc: f64,
}

/// The open files of a results folder.
pub(super) struct Tables {
    folder: PathBuf,
    moments: csv::Writer<File>,
    errors: csv::Writer<File>,
    effort: csv::Writer<File>,
    densities: NpzWriter<BufWriter<File>>,
}

const DENSITIES: &str = "densities.npz";

impl Tables {
    pub(super) fn create(folder: PathBuf) -> Result<Self, Failure> {
        let table = |name: &str| {
            let path = folder.join(name);
            csv::Writer::from_path(&path).map_err(|e| Failure::file(&path, e))
        };
        let path = folder.join(DENSITIES);
        let file = File::create(&path).map_err(|e| Failure::file(&path, e))?;
        Ok(Self {
            moments: table("moments.csv")?,
            errors: table("errors.csv")?,
            effort: table("effort.csv")?,
            densities: NpzWriter::new(BufWriter::new(file)),
            folder,
        })
    }

    /// Writes a scenario, case by case in the roster's order.
    pub(super) fn write(&mut self, recording: &Recording, roster: &Roster) -> Result<(), Failure> {
        let scenario = &recording.assignment.name;
        for (label, _) in &roster.cases {
            let Some(case) = recording.case(label) else { continue };
            for density in case {
                self.moments
                    .serialize(moments_row(scenario, label, &density.header))
                    .map_err(|e| Failure::file(&self.folder.join("moments.csv"), e))?;
                self.write_density(scenario, label, density)?;
            }
            self.write_comparisons(recording, scenario, label)?;
        }
        Ok(())
    }

    fn write_comparisons(&mut self, recording: &Recording, scenario: &str, method: &str) -> Result<(), Failure> {
        for recorded in recording.comparisons.iter().filter(|c| unpack(&c.header.label) == method) {
            let reference = &unpack(&recorded.header.reference);
            let values = &recorded.values;
            if recorded.header.kind == comparison::MOMENTS {
                for (quantity, row) in QUANTITIES.iter().zip(values.chunks_exact(ERROR_COLUMNS)) {
                    let t_yr = recorded.header.time;
                    let (value, reference_value, abs_error, rel_error) = (row[0], row[1], row[2], row[3]);
                    self.errors
                        .serialize(ErrorRow {
                            scenario,
                            method,
                            reference,
                            t_yr,
                            quantity,
                            value,
                            reference_value,
                            abs_error,
                            rel_error,
                        })
                        .map_err(|e| Failure::file(&self.folder.join("errors.csv"), e))?;
                }
            } else if let [t_prop_s, t_int_s, t_cal_s, ratio_to_mc] = values[..] {
                self.effort
                    .serialize(EffortRow { scenario, method, t_prop_s, t_int_s, t_cal_s, ratio_to_mc })
                    .map_err(|e| Failure::file(&self.folder.join("effort.csv"), e))?;
            }
        }
        Ok(())
    }

    fn write_density(&mut self, scenario: &str, method: &str, density: &RecordedDensity) -> Result<(), Failure> {
        let header = &density.header;
        let (phi_bins, e_bins) = (header.phi_bins as usize, header.e_bins as usize);
        let (joint, marginals) = density.values.split_at(phi_bins * e_bins);
        let (marginal_phi, marginal_e) = marginals.split_at(phi_bins);
        let [phi_low, phi_high, e_low, e_high] = header.grid;
        let phi_edges = Axis { low: phi_low, high: phi_high, bins: phi_bins }.edges();
        let e_edges = Axis { low: e_low, high: e_high, bins: e_bins }.edges();
        let group = format!("{scenario}/{method}/{}", header.index);
        let path = self.folder.join(DENSITIES);
        let mut array = |name: &str, shape: &[u64], values: &[f64]| {
            write_array(&mut self.densities, &format!("{group}/{name}"), shape, values)
                .map_err(|e| Failure::file(&path, e))
        };
        array("joint", &[phi_bins as u64, e_bins as u64], joint)?;
        array("marginal_phi", &[phi_bins as u64], marginal_phi)?;
        array("marginal_e", &[e_bins as u64], marginal_e)?;
        array("phi_edges", &[phi_bins as u64 + 1], &phi_edges)?;
        array("e_edges", &[e_bins as u64 + 1], &e_edges)
    }

    /// Closes all files.
    pub(super) fn finish(self) -> Result<(), Failure> {
        let Self { folder, moments, errors, effort, densities } = self;
        for (name, mut table) in [("moments.csv", moments), ("errors.csv", errors), ("effort.csv", effort)] {
            table.flush().map_err(|e| Failure::file(&folder.join(name), e))?;
        }
        drop(densities); // writes the archive's directory
        check_archive(&folder.join(DENSITIES))
    }
}

/// An archive without its directory cannot be opened: dropping the writer cannot report that the disk was full.
fn check_archive(path: &Path) -> Result<(), Failure> {
    npyz::npz::NpzArchive::open(path).map(drop).map_err(|e| Failure::file(path, e))
}

fn write_array(
    archive: &mut NpzWriter<BufWriter<File>>,
    name: &str,
    shape: &[u64],
    values: &[f64],
) -> std::io::Result<()> {
    let options =
        FileOptions::default().compression_method(CompressionMethod::Stored).last_modified_time(DateTime::default());
    let mut writer: NpyWriter<f64, _> = archive.array(name, options)?.default_dtype().shape(shape).begin_nd()?;
    writer.extend(values.iter().copied())?;
    writer.finish()
}

fn moments_row<'a>(scenario: &'a str, method: &'a str, header: &DensityHeader) -> MomentsRow<'a> {
    let [mean_phi_rad, std_phi_rad, mean_e, std_e, cov_phi_e, prob_above_critical_e] = header.moments;
    let errors = header.standard_errors;
    MomentsRow {
        scenario,
        method,
        t_yr: header.time,
        mean_phi_rad,
        std_phi_rad,
        mean_e,
        std_e,
        cov_phi_e,
        prob_above_critical_e,
        se_mean_phi_rad: errors[0],
        se_std_phi_rad: errors[1],
        se_mean_e: errors[2],
        se_std_e: errors[3],
        se_cov_phi_e: errors[4],
        se_prob_above_critical_e: errors[5],
        circular_mean_phi_rad: header.circular_mean,
        resultant_length: header.resultant,
        mass_on_grid: header.mass_on_grid,
    }
}
