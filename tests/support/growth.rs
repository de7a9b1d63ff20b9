//! Tables of numbers that may not grow: committed, and compared with what is found now.
//!
//! A row is `| name | number | number |`, and words may follow. A number may fall; when it grows by more than 2 % the change that made it grow says so by
//! writing the table anew. Needs nothing but the standard library: tests and developer commands both include this file.

/// How much a number may grow.
const GROWTH: f64 = 1.02;

/// A row: its name, and its numbers.
pub type Row = (String, Vec<u64>);

/// The rows of a text that have `numbers` numbers after their name, and nothing but words after these.
pub fn rows(text: &str, numbers: usize) -> Vec<Row> {
    let number = |field: &&str| field.trim().parse::<u64>().ok();
    let row = |line: &str| {
        let fields: Vec<_> = line.strip_prefix('|')?.strip_suffix('|')?.split('|').collect();
        let (name, rest) = fields.split_first()?;
        let (found, words) = rest.split_at_checked(numbers)?;
        let found = found.iter().map(number).collect::<Option<Vec<_>>>()?;
        words.iter().all(|word| number(word).is_none()).then(|| (name.trim().to_owned(), found))
    };
    text.lines().filter_map(row).collect()
}

/// What is wrong, a line each: numbers that grew, rows that only one side has. `units` names the numbers.
pub fn complaints(table: &[Row], found: &[Row], units: &[&str]) -> Vec<String> {
    let named = |rows: &[Row], name: &str| rows.iter().find(|row| row.0 == name).map(|row| row.1.clone());
    let mut said = Vec::new();
    for (name, numbers) in found {
        let Some(expected) = named(table, name) else {
            said.push(format!("{name}: not in the table"));
            continue;
        };
        for ((unit, &expected), &found) in units.iter().zip(&expected).zip(numbers) {
            if found as f64 > expected as f64 * GROWTH {
                let percent = 100.0 * (found as f64 / expected as f64 - 1.0);
                said.push(format!("{name}: {unit} {found}, the table has {expected} ({percent:+.1} %)"));
            }
        }
    }
    said.extend(table.iter().filter(|row| named(found, &row.0).is_none()).map(|row| format!("{}: only in the table", row.0)));
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "| scene | mean | worst | call |\n|---|---:|---:|---|\n| a, b | 100 | 200 | tick 3 |\n| c | 10 | 10 | |\n| parts | 1 | 2 | 3 |\n";

    fn row(name: &str, numbers: [u64; 2]) -> Row {
        (name.to_owned(), numbers.to_vec())
    }

    #[test]
    fn rows_are_those_with_as_many_numbers() {
        assert_eq!(rows(TABLE, 2), [row("a, b", [100, 200]), row("c", [10, 10])]);
        assert_eq!(rows(TABLE, 3), [("parts".to_owned(), vec![1, 2, 3])]);
    }

    #[test]
    fn growth_and_missing_rows_are_said_and_nothing_else() {
        let table = rows(TABLE, 2);
        for (found, expected) in [
            (vec![row("a, b", [102, 204]), row("c", [0, 0])], vec![]),
            (vec![row("a, b", [103, 200]), row("c", [10, 10])], vec!["a, b: mean 103, the table has 100 (+3.0 %)"]),
            (vec![row("a, b", [100, 205]), row("c", [10, 10])], vec!["a, b: worst 205, the table has 200 (+2.5 %)"]),
            (vec![row("a, b", [100, 200])], vec!["c: only in the table"]),
            (vec![row("a, b", [1, 2]), row("c", [1, 2]), row("d", [1, 2])], vec!["d: not in the table"]),
        ] {
            assert_eq!(complaints(&table, &found, &["mean", "worst"]), expected);
        }
    }
}
