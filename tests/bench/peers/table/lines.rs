//! The lines that a run leaves: about the run, times, physics, limits.

use std::error::Error;

use serde::Deserialize;

/// About the run.
#[derive(Debug, Deserialize)]
pub struct Run {
    pub machine: String,
    pub date: String,
    pub rounds: usize,
    pub seconds: f64,
    /// Load of the machine in the last minute, at the start and at the end.
    pub load: [f64; 2],
    /// Drag and twist where the rim turns as fast as the centre slides, of the truth.
    pub sliding: [f64; 2],
    /// The truth of each depth and Poisson's ratio that was compared with.
    pub truth: Vec<Truth>,
}

/// Finite elements of the ball at one depth.
#[derive(Debug, Deserialize)]
#[allow(non_snake_case, reason = "the table's own names")]
pub struct Truth {
    pub nu: f64,
    pub depth_mm: f64,
    pub force_N: f64,
    pub torque_Nm: Vec<f64>,
}

/// Times of a case in one round.
#[derive(Clone, Debug, Deserialize)]
pub struct Time {
    pub peer: String,
    pub version: String,
    pub scene: String,
    pub case: String,
    pub round: usize,
    pub n: usize,
    pub median_us: f64,
    pub cpu_median_us: f64,
    pub cpu_p99_us: f64,
    pub cpu_max_us: f64,
}

/// A ball at one depth: what a program finds.
#[derive(Debug, Deserialize)]
#[allow(non_snake_case, reason = "the lines' own names")]
pub struct Press {
    pub peer: String,
    pub case: String,
    pub nu: f64,
    pub depth_mm: f64,
    pub force_N: f64,
    pub torque_Nm: Vec<f64>,
    pub held: f64,
}

/// A ball dragged and twisted at once.
#[derive(Debug, Deserialize)]
#[allow(non_snake_case, reason = "the lines' own names")]
pub struct Drag {
    pub peer: String,
    pub case: String,
    pub nu: f64,
    pub normal_N: f64,
    pub drag_N: f64,
    pub torque_Nm: f64,
}

/// What a program cannot do.
#[derive(Debug, Deserialize)]
pub struct Cannot {
    pub peer: String,
    pub cannot: String,
    pub reason: String,
}

/// All lines of a run.
#[derive(Debug)]
pub struct Lines {
    pub run: Run,
    pub times: Vec<Time>,
    pub presses: Vec<Press>,
    pub drags: Vec<Drag>,
    pub limits: Vec<Cannot>,
}

impl Lines {
    /// Reads a file of lines.
    ///
    /// # Errors
    /// A line that is none of the five kinds, or no line about the run.
    pub fn parse(text: &str) -> Result<Self, Box<dyn Error>> {
        let (mut run, mut times, mut presses, mut drags, mut limits) = (None, Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for line in text.lines() {
            let value: serde_json::Value = serde_json::from_str(line)?;
            match value["physics"].as_str() {
                Some("press-twist") => presses.push(serde_json::from_value(value)?),
                Some(_) => drags.push(serde_json::from_value(value)?),
                None if value.get("machine").is_some() => run = Some(serde_json::from_value(value)?),
                None if value.get("cannot").is_some() => limits.push(serde_json::from_value(value)?),
                None => times.push(serde_json::from_value(value)?),
            }
        }
        Ok(Self { run: run.ok_or("no line about the run")?, times, presses, drags, limits })
    }

    /// Programs and cases of `of`, in the order of their first line.
    pub fn cases<'a, T>(of: &'a [T], name: impl Fn(&'a T) -> (&'a str, &'a str)) -> Vec<(&'a str, &'a str)> {
        let mut cases = Vec::new();
        for case in of.iter().map(name) {
            if !cases.contains(&case) {
                cases.push(case);
            }
        }
        cases
    }

    /// Programs with their versions, in the order of their first line.
    pub fn versions(&self) -> Vec<(&str, &str)> {
        Self::cases(&self.times, |time| (time.peer.as_str(), time.version.as_str()))
    }

    /// The truth of a depth and a Poisson's ratio.
    pub fn truth(&self, nu: f64, depth_mm: f64) -> Option<&Truth> {
        self.run.truth.iter().find(|truth| (truth.nu - nu).abs() < 1.0e-3 && (truth.depth_mm - depth_mm).abs() < 1.0e-6)
    }
}
