//! `haptor plot`: the table that `haptor eval` writes as a picture, force above torque over time.

use std::path::{Path, PathBuf};

use crate::command::EVAL_HEADER;
use crate::failure::{Failure, Outcome};
use crate::plot::{Curve, Panel, draw_panels};

/// Draws force and torque over time from a result of `haptor eval` (PNG).
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: haptor plot wrench.csv -o wrench.png --title mallet")]
pub struct Args {
    /// Table as `haptor eval` writes it
    table: PathBuf,
    /// Picture to draw (PNG)
    #[arg(short, value_name = "FILE.png")]
    output: PathBuf,
    /// Words above the picture; the table's name when not given
    #[arg(long)]
    title: Option<String>,
}

/// Columns of the table that are drawn: time, force, torque.
const COLUMNS: usize = 7;

/// Runs the command.
pub fn run(args: &Args) -> Outcome {
    let rows = load(&args.table)?;
    let name = args.table.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let title = args.title.as_ref().unwrap_or(&name);
    let panels: [Panel; 2] = [
        ("force on the probe [N]", curves(&rows, 1, 1.0, ["|f|", "fx", "fy", "fz"])),
        ("torque about its mass centre [mN m]", curves(&rows, 4, 1.0e3, ["|t|", "tx", "ty", "tz"])),
    ];
    draw_panels(&args.output, title, &panels).map_err(Failure::problem)
}

/// Magnitude and components of the vector whose first column is `first`, in units 1/`unit` as large.
fn curves(rows: &[[f64; COLUMNS]], first: usize, unit: f64, names: [&'static str; 4]) -> Vec<Curve> {
    let size = |row: &[f64; COLUMNS]| row[first..first + 3].iter().map(|part| part * part).sum::<f64>().sqrt();
    let value = |row: &[f64; COLUMNS], k: usize| unit * if k == 0 { size(row) } else { row[first + k - 1] };
    let points = |k: usize| rows.iter().map(|row| (row[0], value(row, k))).collect();
    names.into_iter().enumerate().map(|(k, name)| Curve { name, points: points(k) }).collect()
}

fn load(path: &Path) -> Result<Vec<[f64; COLUMNS]>, Failure> {
    let shown = path.display();
    let bad =
        |line: usize, what: &str| Failure::bad_input(format!("{shown}:{line}: {what}; give a table as `haptor eval` writes it"));
    let text = std::fs::read_to_string(path).map_err(|error| Failure::bad_input(format!("{shown}: cannot be read: {error}")))?;
    let mut lines = text.lines();
    if lines.next() != Some(EVAL_HEADER) {
        return Err(bad(1, &format!("the header is not {EVAL_HEADER}")));
    }
    let row = |line: &str| -> Option<[f64; COLUMNS]> {
        let mut fields = line.split(',').map(|field| field.parse::<f64>().ok().filter(|value| value.is_finite()));
        let mut row = [0.0; COLUMNS];
        for value in &mut row {
            *value = fields.next()??;
        }
        Some(row)
    };
    let rows: Result<Vec<_>, Failure> = lines
        .enumerate()
        .map(|(index, line)| row(line).ok_or_else(|| bad(index + 2, "a time, force or torque is no number")))
        .collect();
    rows.and_then(|rows| if rows.is_empty() { Err(bad(2, "no rows follow the header")) } else { Ok(rows) })
}
