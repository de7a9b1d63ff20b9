//! The trajectory file: CSV, one pose of the handle per row, one row per tick. Read completely and checked before anything is
//! computed; a message names file, row (the line of the file, the header is 1), column, value and rule.

use std::fmt::Display;
use std::path::Path;

use haptor_contact::{MAX_DISTANCE, MAX_SPEED, MAX_TURN_RATE, QUATERNION_TOLERANCE, Quat, Vec3};

use crate::failure::Failure;

/// The columns, in order: time \[s\], position \[m\], unit quaternion.
pub const HEADER: [&str; 8] = ["t", "px", "py", "pz", "qw", "qx", "qy", "qz"];

/// Largest time \[s\], 31 years: beyond it an f64 no longer tells a tenth of a microsecond.
const MAX_TIME: f64 = 1.0e9;

/// Tick length of a trajectory of one row \[s\].
const LONE_TICK: f64 = 1.0e-3;

/// One pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Time as it was written, to be printed as given.
    pub written_t: String,
    /// Time \[s\].
    pub t: f64,
    /// Time since the row before \[s\]; the first row takes the interval that follows it.
    pub dt: f32,
    /// Position of the handle in world \[m\].
    pub position: Vec3,
    /// Rotation of the handle in world, unit quaternion.
    pub rotation: Quat,
}

/// Reads a trajectory file.
///
/// # Errors
/// [`Failure::BadInput`] with file, row, column, value and rule.
pub fn load(path: &Path) -> Result<Vec<Row>, Failure> {
    let shown = path.display();
    let unreadable = |error| Failure::bad_input(format!("{shown}: cannot be read: {error}; give the path of a trajectory file"));
    let bytes = std::fs::read(path).map_err(unreadable)?;
    parse(&bytes).map_err(|(line, what)| Failure::bad_input(format!("{shown}:{line}: {what}")))
}

/// Line and what is wrong there.
type Fault = (u64, String);

/// Reads the bytes of a trajectory file; an error is its line and what is wrong there.
pub fn parse(bytes: &[u8]) -> Result<Vec<Row>, Fault> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = crate::text::line_of(bytes, error.valid_up_to());
        (line as u64, "is not UTF-8 text; save the file as UTF-8".to_owned())
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
    let mut records = reader.records();
    check_header(records.next(), text)?;
    let mut rows: Vec<Row> = Vec::new();
    for record in records {
        let record = record.map_err(|error| (1, format!("is not CSV: {error}")))?;
        let row = row(&record, rows.last(), text)?;
        rows.push(row);
    }
    if rows.is_empty() {
        return Err((1, "no rows follow the header; add at least one pose".to_owned()));
    }
    set_intervals(&mut rows);
    Ok(rows)
}

fn check_header(first: Option<csv::Result<csv::StringRecord>>, text: &str) -> Result<(), Fault> {
    let expected = HEADER.join(",");
    let Some(Ok(header)) = first else {
        return Err((1, format!("the file is empty; its first line must be {expected}")));
    };
    if header.iter().eq(HEADER) {
        return Ok(());
    }
    let found: Vec<_> = header.iter().take(2 * HEADER.len()).collect();
    Err((line(&header, text), format!("the header is {:?}, it must be {expected}", found.join(","))))
}

fn row(record: &csv::StringRecord, before: Option<&Row>, text: &str) -> Result<Row, Fault> {
    let at = line(record, text);
    if record.len() != HEADER.len() {
        return Err((at, format!("{} columns, it must be {}: {}", record.len(), HEADER.len(), HEADER.join(","))));
    }
    let number = |column: usize| number(&record[column]).map_err(|rule| (at, refusal(HEADER[column], &record[column], rule)));
    let t = number(0)?;
    check_time(t, before).map_err(|rule| (at, refusal("t", &record[0], rule)))?;
    let position = [number(1)?, number(2)?, number(3)?];
    for (column, value) in (1..).zip(position) {
        if value.abs() > f64::from(MAX_DISTANCE) {
            let rule = format!("allowed is -{MAX_DISTANCE} to {MAX_DISTANCE} m; are these metres?");
            return Err((at, refusal(HEADER[column], &record[column], rule)));
        }
    }
    let rotation = quaternion([number(4)?, number(5)?, number(6)?, number(7)?]).map_err(|what| (at, what))?;
    let position = Vec3::from_array(position.map(|value| value as f32));
    if position.length() > MAX_DISTANCE {
        let rule = format!("allowed is within {MAX_DISTANCE} m of the world's origin; are these metres?");
        return Err((at, format!("px,py,pz lies {} m away: {rule}", position.length())));
    }
    let row = Row { written_t: record[0].to_owned(), t, dt: 0.0, position, rotation };
    before.map_or(Ok(()), |before| check_motion(before, &row)).map_err(|what| (at, what))?;
    Ok(row)
}

/// The core would refuse a pose that jumps; a file that holds one is refused as a whole.
fn check_motion(before: &Row, row: &Row) -> Result<(), String> {
    let time = (row.t - before.t) as f32;
    let speed = (row.position - before.position).length() / time;
    if speed > MAX_SPEED {
        let rule = format!("allowed is up to {MAX_SPEED} m/s from row to row; give the motion more rows or more time");
        return Err(format!("px,py,pz moves at {speed} m/s: {rule}"));
    }
    let rate = before.rotation.normalize().angle_between(row.rotation.normalize()) / time;
    if rate > MAX_TURN_RATE {
        let rule = format!("allowed is up to {MAX_TURN_RATE} rad/s from row to row; give the turn more rows or more time");
        return Err(format!("qw,qx,qy,qz turns at {rate} rad/s: {rule}"));
    }
    Ok(())
}

fn number(text: &str) -> Result<f64, &'static str> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err("must be finite"),
        Err(_) if text.is_empty() => Err("is empty, it must be a number"),
        Err(_) => Err("must be a number"),
    }
}

fn check_time(t: f64, before: Option<&Row>) -> Result<(), String> {
    if t.abs() > MAX_TIME {
        return Err(format!("allowed is -{MAX_TIME:e} to {MAX_TIME:e} s"));
    }
    match before {
        Some(row) if t <= row.t => Err(format!("time must increase, the row before has {}", row.written_t)),
        // below the smallest f32 the core would see no time pass
        Some(row) if ((t - row.t) as f32) < f32::MIN_POSITIVE => {
            Err(format!("time must increase by more than {:e} s", f32::MIN_POSITIVE))
        }
        _ => Ok(()),
    }
}

fn quaternion(wxyz: [f64; 4]) -> Result<Quat, String> {
    let length = wxyz.iter().map(|value| value * value).sum::<f64>().sqrt();
    if (length - 1.0).abs() > f64::from(QUATERNION_TOLERANCE) {
        let rule = format!("a unit quaternion is allowed, length 1 within {QUATERNION_TOLERANCE:e}; normalise it");
        return Err(format!("qw,qx,qy,qz has length {length}: {rule}"));
    }
    let [w, x, y, z] = wxyz.map(|value| value as f32);
    Ok(Quat::from_xyzw(x, y, z, w))
}

fn refusal(column: &str, value: &str, rule: impl Display) -> String {
    let shown: String = value.chars().take(40).collect();
    format!("column {column} = {shown:?}: {rule}")
}

/// Line on which a record begins. The reader's own position is before the blank lines that it skipped.
fn line(record: &csv::StringRecord, text: &str) -> u64 {
    let Some(position) = record.position() else { return 1 };
    let rest = text.as_bytes().get(position.byte() as usize..).unwrap_or_default();
    let blank = rest.iter().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    position.line() + blank.filter(|&&byte| byte == b'\n').count() as u64
}

fn set_intervals(rows: &mut [Row]) {
    let first = if rows.len() > 1 { rows[1].t - rows[0].t } else { LONE_TICK };
    rows[0].dt = first as f32;
    for k in 1..rows.len() {
        rows[k].dt = (rows[k].t - rows[k - 1].t) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "t,px,py,pz,qw,qx,qy,qz\n";

    #[test]
    fn marks_line_ends_and_spaces_of_other_systems_are_taken() {
        let plain = parse(format!("{HEAD}0,0,0,1,1,0,0,0\n0.5,0,0,1,1,0,0,0\n").as_bytes()).unwrap();
        let windows = "\u{feff}t,px,py,pz,qw,qx,qy,qz\r\n0, 0,0,1, 1,0,0,0\r\n\r\n0.5,0,0,1,1,0,0,0";
        assert_eq!(parse(windows.as_bytes()).unwrap(), plain);
        assert_eq!(plain.iter().map(|row| row.dt).collect::<Vec<_>>(), [0.5, 0.5]);
        assert_eq!(plain[1].written_t, "0.5");
    }

    #[test]
    fn jumps_are_refused_with_their_row() {
        let cases =
            [("0.001,0.06,0,1,1,0,0,0", "m/s"), ("0.001,0,0,1,0,0,0,1", "rad/s"), ("0.1,800,800,1,1,0,0,0", "within 1000 m")];
        for (row, expected) in cases {
            let (line, what) = parse(format!("{HEAD}0,0,0,1,1,0,0,0\n{row}\n").as_bytes()).unwrap_err();
            assert!(line == 3 && what.contains(expected), "{row}: {line} {what}");
        }
    }

    #[test]
    fn a_lone_row_lasts_a_millisecond() {
        assert_eq!(parse(format!("{HEAD}7,0,0,1,1,0,0,0").as_bytes()).unwrap()[0].dt, 1e-3);
    }
}
