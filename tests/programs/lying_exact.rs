//! The exact propagator with a lie of choice, or something withheld, for the tests of what a run reports about it.

use std::process::ExitCode;

use kit::assignment::Assignment;
use kit::failure::Failure;
use kit::{Form, Passage, Propagator};
use messages::content::{Content, DENSITY_HEAD, Density};
use nodes::methods::exact::{ExactDensity, Settings};

struct Liar {
    exact: ExactDensity,
    lie: String,
    index: usize,
}

fn main() -> ExitCode {
    let lie = std::env::args().nth(1).unwrap_or_default();
    kit::main(Liar { exact: ExactDensity::new(Settings::default()), lie, index: 0 })
}

impl Propagator for Liar {
    fn begin(&mut self, assignment: &Assignment) -> Result<Form, Failure> {
        let form = self.exact.begin(assignment)?;
        assert_eq!(form.content, Content::Density(Density));
        Ok(form)
    }

    fn advance(&mut self, index: usize) -> Result<usize, Failure> {
        self.index = index;
        self.exact.advance(index)
    }

    fn write(&self, columns: &mut [f64]) {
        self.exact.write(columns);
        let (head, joint) = columns.split_at_mut(DENSITY_HEAD);
        let sigma_e = head[3];
        match self.lie.as_str() {
            _ if self.index == 0 => {}
            "mean-e" => head[2] += 0.2 * sigma_e,
            "std-phi" => head[1] *= 1.2,
            "circular-mean" => head[6] += 0.5,
            "probability" => head[5] = 1.0 - head[5],
            "mass" => joint.iter_mut().for_each(|density| *density *= 52.0),
            "withholds-density" => {
                joint.fill(f64::NAN);
                head[11] = 0.3;
            }
            "withholds-all" => {
                head[..8].fill(f64::NAN);
                head[8..].fill(f64::INFINITY);
                joint.fill(f64::NAN);
            }
            "mixes" => joint[0] = f64::NAN,
            _ => {}
        }
    }

    fn first_passage(&mut self, times: &[f64]) -> Result<Passage, Failure> {
        let answer = self.exact.first_passage(times)?;
        let Passage::Curve(mut rows) = answer else { return Ok(answer) };
        for row in &mut rows {
            match self.lie.as_str() {
                "passage" => (row[1], row[2], row[3]) = (0.5 * row[1], 0.5 * row[1], 0.5 * row[1]),
                "withholds-passage" | "withholds-all" => (row[1], row[2], row[3]) = (f64::NAN, 0.0, 1.0),
                _ => {}
            }
        }
        Ok(Passage::Curve(rows))
    }
}
