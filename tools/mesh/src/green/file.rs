//! A table as the contents of a kept file ([`crate::kept`]): little endian.
//!
//! | bytes | what |
//! |---|---|
//! | 3 f32, 3 f32, f32, u32 | chart: middle, half extents; radius of the discs; nodes along an edge |
//! | f32 each | own moves, then the table, as in [`haptor_contact::green::GreenSpec`] |

use glam::Vec3;
use haptor_contact::green::{BLOCK, COMPONENTS, Chart, Green};

use super::GreenTable;
use crate::kept::{Keep, KeptError, Kind, OVERHEAD};

const CHART: usize = 32;

impl Keep for GreenTable {
    // the most bytes: 9 nodes an edge with room to spare
    const KIND: Kind = Kind { magic: *b"haptgrn\0", format: 1, max_bytes: 16 << 20, name: "green" };

    fn to_contents(&self) -> Vec<u8> {
        let chart = [self.chart.centre, self.chart.half_size];
        let head = chart.iter().flat_map(Vec3::to_array).chain([self.patch_radius]).flat_map(f32::to_le_bytes);
        let mut bytes: Vec<u8> = head.collect();
        bytes.extend((self.chart.per_edge as u32).to_le_bytes());
        bytes.extend(self.own.iter().chain(&self.table).flat_map(|number| number.to_le_bytes()));
        bytes
    }

    fn from_contents(contents: &[u8]) -> Result<Self, KeptError> {
        let wrong = |expected| KeptError::Length { found: contents.len() + OVERHEAD, expected };
        if contents.len() < CHART {
            return Err(wrong(OVERHEAD + CHART));
        }
        let number = |index: usize| f32::from_bits(word(contents, 4 * index));
        let vector = |first: usize| Vec3::new(number(first), number(first + 1), number(first + 2));
        // more nodes than a file may hold bytes must not overflow
        let per_edge = (word(contents, 28) as usize).min(Self::KIND.max_bytes);
        let chart = Chart { centre: vector(0), half_size: vector(3), per_edge };
        let numbers: Vec<f32> = contents[CHART..].chunks_exact(4).map(|four| f32::from_bits(word(four, 0))).collect();
        let (own, table) = split(&chart, &numbers).ok_or_else(|| wrong(length(&chart)))?;
        let table = Self { chart, patch_radius: number(6), own: own.to_vec(), table: table.to_vec() };
        Green::new(&table.spec())?;
        Ok(table)
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let mut four = [0; 4];
    four.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(four)
}

/// Numbers of own moves and of the table.
fn sizes(chart: &Chart) -> Option<(usize, usize)> {
    // places() of a chart of no nodes would run below zero
    if !(2..=MAX_PER_EDGE).contains(&chart.per_edge) {
        return None;
    }
    let side = COMPONENTS * chart.places();
    Some((BLOCK * chart.places(), side * side))
}

/// Beyond this no chart is valid and its size need not be counted.
const MAX_PER_EDGE: usize = haptor_contact::green::chart::MAX_PER_EDGE;

/// Bytes of a whole file with this chart; 0 for charts that are none.
fn length(chart: &Chart) -> usize {
    sizes(chart).map_or(0, |(own, table)| OVERHEAD + CHART + 4 * (own + table))
}

fn split<'n>(chart: &Chart, numbers: &'n [f32]) -> Option<(&'n [f32], &'n [f32])> {
    let (own, table) = sizes(chart)?;
    (numbers.len() == own + table).then(|| numbers.split_at(own))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::green::{GreenInputs, GreenOptions};
    use crate::kept::Key;
    use haptor_contact::{Material, ObjectShape};

    fn inputs() -> GreenInputs {
        let material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
        let shape = ObjectShape::Box { size: Vec3::splat(0.1) };
        GreenInputs { shape, material, fixed_below: 0.0, options: GreenOptions { per_edge: 3, fineness: 3 } }
    }

    fn table() -> GreenTable {
        let chart = Chart { centre: Vec3::Z * 0.05, half_size: Vec3::splat(0.05), per_edge: 3 };
        let (own, table) = sizes(&chart).unwrap();
        let number = |i: usize| (i as f32 * 0.7).sin();
        GreenTable { chart, patch_radius: 0.005, own: (0..own).map(number).collect(), table: (0..table).map(number).collect() }
    }

    #[test]
    fn a_table_comes_back_to_the_bit() {
        assert_eq!(GreenTable::from_contents(&table().to_contents()).unwrap(), table());
        let key = inputs().key();
        let kept = GreenTable::KIND.seal(&key, &table().to_contents());
        assert_eq!(kept.len(), length(&table().chart));
        assert_eq!(GreenTable::KIND.open(&kept).unwrap().0, Key(key.0));
    }

    #[test]
    fn a_chart_of_another_size_is_refused_by_length() {
        for per_edge in [0_u32, 1, 5, u32::MAX] {
            let mut bytes = table().to_contents();
            bytes[28..32].copy_from_slice(&per_edge.to_le_bytes());
            let error = GreenTable::from_contents(&bytes).unwrap_err();
            assert!(matches!(error, KeptError::Length { .. }), "{per_edge}: {error}");
        }
        assert!(GreenTable::from_contents(&table().to_contents()[..20]).is_err());
    }

    #[test]
    fn keys_tell_inputs_apart() {
        let material = Material { poisson_ratio: 0.3, ..inputs().material };
        let options = GreenOptions { per_edge: 5, ..inputs().options };
        let others = [
            GreenInputs { material, ..inputs() },
            GreenInputs { options, ..inputs() },
            GreenInputs { fixed_below: 0.01, ..inputs() },
        ];
        for other in others {
            assert_ne!(other.key(), inputs().key());
        }
        let denser = Material { density: 900.0, ..inputs().material };
        assert_eq!(GreenInputs { material: denser, ..inputs() }.key(), inputs().key());
    }
}
