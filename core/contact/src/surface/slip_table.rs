//! Rotation of the surface about a patch that twists in partial slip under Hertz pressure: a universal table.
//!
//! phi(r)/phi0 over z = K_theta phi0/T_max (rows) and r/a (columns), from the superposition of stuck discs that gives Lubkin's curve
//! (theory.md, section 9). Bilinear between the places; below the first row as that row, above the last likewise; beyond the last
//! column the rotation falls as (a/r)^3, the far field of any torque.

use crate::math::{clamp, min};

/// Places along either side of the table.
const PLACES: usize = 25;

/// Rotation of the surface at `q` = r/a over the patch's own, when z = K_theta phi0/T_max is `z`.
pub fn slip_field(z: f32, q: f32) -> f32 {
    along(&columns(z), q)
}

/// The table's row at `z`, place by place.
fn columns(z: f32) -> [f32; PLACES] {
    let (row, down) = place(&TURN, clamp(z, TURN[0], TURN[PLACES - 1]));
    let mut found = FIELD[row];
    for (here, below) in found.iter_mut().zip(&FIELD[row + 1]) {
        *here += (below - *here) * down;
    }
    found
}

/// Between the places of a row: linear near the rim, and beyond `CUBE` linear in the field times q^3, which hardly changes there.
fn along(row: &[f32; PLACES], q: f32) -> f32 {
    let (column, _) = place(&RADIUS, clamp(q, 0.0, LAST));
    between(row, column, min(q, LAST)) * if q <= LAST { 1.0 } else { (LAST / q) * (LAST / q) * (LAST / q) }
}

/// In the interval that starts at `column`.
fn between(row: &[f32; PLACES], column: usize, q: f32) -> f32 {
    let (here, next) = (row[column], row[column + 1]);
    let across = (q - RADIUS[column]) / (RADIUS[column + 1] - RADIUS[column]);
    if q <= CUBE {
        return here + (next - here) * across;
    }
    let cube = |r: f32| r * r * r;
    let (first, last) = (here * cube(RADIUS[column]), next * cube(RADIUS[column + 1]));
    (first + (last - first) * across) / cube(q)
}

/// The rotation about one patch by places of r/a, at places that an index reaches without a search: 0.05 apart up to `CUBE`, then 1/18, as
/// far as the near forms are used. Sums of rows are rows.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Value at the start of each interval, and its growth over it \[rad\]; beyond `CUBE` both times q^3.
    cells: [[f32; 2]; CELLS],
}

/// Intervals of a row: a power of two, so that an index is a mask.
const CELLS: usize = 64;

/// Distance up to which the table is linear.
const CUBE: f32 = 1.5;

/// Intervals of a row up to `CUBE`, and per unit of r/a before and after it.
const FINE: f32 = 30.0;
const FINE_RATE: f32 = 20.0;
const COARSE_RATE: f32 = 18.0;

/// Interval of the last place, 1.5 + 33/18 = 1/0.3.
const END: f32 = 63.0;

/// 1.5 x 2^23: added to a small number, it leaves the nearest integer in the low bits.
const ROUNDER: f32 = 12_582_912.0;

impl Row {
    /// No rotation.
    pub const ZERO: Self = Self { cells: [[0.0; 2]; CELLS] };

    /// Adds the rotation of a patch that turned by `phi` up to z = `z`.
    pub fn add(&mut self, z: f32, phi: f32) {
        let row = columns(z);
        let (mut column, mut start) = (0, phi * row[0]);
        for (i, cell) in self.cells.iter_mut().enumerate() {
            let t = (i + 1) as f32;
            let q = if t <= FINE { t / FINE_RATE } else { CUBE + (t - FINE) / COARSE_RATE };
            // places of a row are closer than the table's, which they pass one by one
            if column + 2 < PLACES && RADIUS[column + 1] < q {
                column += 1;
            }
            let found = phi * between(&row, column, q);
            let cubed = q * q * q;
            let end = if t > FINE { found * cubed } else { found };
            *cell = [cell[0] + start, cell[1] + (end - start)];
            start = if t == FINE { found * cubed } else { end };
        }
    }

    /// The rotations at the places `q`, whose inverse is `s`, as far as the last place.
    pub fn at_all<const N: usize>(&self, q: &[f32; N], s: &[f32; N]) -> [f32; N] {
        let (mut index, mut share, mut scale) = ([0_u32; N], [0.0; N], [0.0; N]);
        for i in 0..N {
            let fine = if q[i] < CUBE { q[i] } else { CUBE };
            let coarse = if q[i] > CUBE { q[i] - CUBE } else { 0.0 };
            let t = fine * FINE_RATE + coarse * COARSE_RATE;
            let t = if t < END { t } else { END };
            // the nearest integer to t - 1/2 is the interval; rounded down but at `FINE`, where the scale changes
            let rounded = (t - 0.499_99) + ROUNDER;
            index[i] = rounded.to_bits();
            share[i] = t - (rounded - ROUNDER);
            scale[i] = if rounded - ROUNDER >= FINE { s[i] * s[i] * s[i] } else { 1.0 };
        }
        let mut found = [0.0; N];
        for i in 0..N {
            let [start, growth] = self.cells[index[i] as usize % CELLS];
            found[i] = (start + growth * share[i]) * scale[i];
        }
        found
    }
}

/// Largest z of the table: beyond it only the innermost tenth of the patch still follows the probe.
pub const LARGEST_TURN: f32 = TURN[PLACES - 1];

/// Smallest z of the table: below it nothing but the rim slips.
pub const SMALLEST_TURN: f32 = TURN[0];

/// Last column.
const LAST: f32 = RADIUS[PLACES - 1];

/// Interval that holds `x`, and the share of the way through it.
fn place(grid: &[f32; PLACES], x: f32) -> (usize, f32) {
    let mut index = 0;
    for (i, &start) in grid[..PLACES - 1].iter().enumerate() {
        index = if x >= start { i } else { index };
    }
    (index, (x - grid[index]) / (grid[index + 1] - grid[index]))
}

#[rustfmt::skip]
const TURN: [f32; PLACES] = [
    0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.6, 2.8, 3.0, 3.5, 4.0, 5.0, 6.0, 8.0, 10.0,
];

#[rustfmt::skip]
const RADIUS: [f32; PLACES] = [
    0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 1.0, 1.05, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.0, 7.0, 10.0,
];

#[rustfmt::skip]
const FIELD: [[f32; PLACES]; PLACES] = [
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.908_098, 0.607_499, 0.478_672, 0.329_997, 0.212_002, 0.146_739, 0.087_834_6, 0.057_130_6, 0.028_330_6, 0.016_13, 0.006_699_92, 0.003_406_48, 0.001_234_02, 0.000_421_943],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.855_235, 0.592_767, 0.469_006, 0.324_296, 0.208_684, 0.144_553, 0.086_581_6, 0.056_334_4, 0.027_945, 0.015_913, 0.006_610_74, 0.003_361_35, 0.001_217_74, 0.000_416_386],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.796_543, 0.570_09, 0.453_715, 0.315_131, 0.203_31, 0.141_002, 0.084_541_4, 0.055_036_5, 0.027_315_8, 0.015_558_7, 0.006_465_07, 0.003_287_62, 0.001_191_13, 0.000_407_307],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.984_579, 0.715_819, 0.530_183, 0.425_77, 0.297_959, 0.193_118, 0.134_231, 0.080_635_5, 0.052_546_5, 0.026_106_4, 0.014_877_1, 0.006_184_6, 0.003_145_61, 0.001_139_87, 0.000_389_811],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.900_91, 0.656_22, 0.495_709, 0.400_749, 0.282_169, 0.183_611, 0.127_875, 0.076_950_3, 0.050_191_3, 0.024_959_6, 0.014_230_1, 0.005_918_09, 0.003_010_61, 0.001_091_12, 0.000_373_17],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.980_731, 0.825_591, 0.607_877, 0.465_324, 0.378_135, 0.267_596, 0.174_729, 0.121_905, 0.073_472_8, 0.047_963_7, 0.023_872_5, 0.013_616, 0.005_664_92, 0.002_882_31, 0.001_044_77, 0.000_357_346],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.864_316, 0.708_453, 0.531_278, 0.413_697, 0.338_719, 0.241_596, 0.158_647, 0.111_016, 0.067_092_6, 0.043_863_9, 0.021_865_5, 0.012_480_7, 0.005_196_22, 0.002_644_66, 0.000_958_88, 0.000_328_013],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.980_491, 0.761_381, 0.620_96, 0.471_581, 0.371_129, 0.305_445, 0.219_125, 0.144_526, 0.101_379, 0.061_406_1, 0.040_196_3, 0.020_063_4, 0.011_459_5, 0.004_773_93, 0.002_430_38, 0.000_881_39, 0.000_301_541],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.901_875, 0.677_427, 0.552_087, 0.422_987, 0.335_287, 0.276_982, 0.199_574, 0.132_087, 0.092_835, 0.056_334_9, 0.036_915_3, 0.018_446_1, 0.010_541_5, 0.004_393_78, 0.002_237_37, 0.000_811_55, 0.000_277_676],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.986_296, 0.821_845, 0.608_314, 0.495_977, 0.382_418, 0.304_684, 0.252_402, 0.182_474, 0.121_101, 0.085_248_2, 0.051_809_8, 0.033_979_6, 0.016_994_9, 0.009_716_72, 0.004_051_79, 0.002_063_62, 0.000_748_655, 0.000_256_178],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.927_697, 0.749_619, 0.550_54, 0.449_204, 0.347_98, 0.278_288, 0.231_023, 0.167_452, 0.111_374, 0.078_501_7, 0.047_769_3, 0.031_352_2, 0.015_693, 0.008_975_88, 0.003_744_26, 0.001_907_31, 0.000_692_044, 0.000_236_824],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.995_587, 0.862_851, 0.686_093, 0.501_582, 0.409_575, 0.318_395, 0.255_345, 0.212_32, 0.154_209, 0.102_745, 0.072_494_1, 0.044_158_7, 0.028_999_8, 0.014_524_9, 0.008_310_46, 0.003_467_76, 0.001_766_71, 0.000_641_106, 0.000_219_407],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.952_926, 0.800_719, 0.630_505, 0.459_635, 0.375_581, 0.292_749, 0.235_279, 0.195_88, 0.142_495, 0.095_072_1, 0.067_136_7, 0.040_929_4, 0.026_892_2, 0.013_476_4, 0.007_712_68, 0.003_219_15, 0.001_640_24, 0.000_595_274, 0.000_203_732],
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.899_779, 0.743_601, 0.581_817, 0.423_362, 0.346_143, 0.270_355, 0.217_637, 0.181_368, 0.132_104, 0.088_236_7, 0.062_351_8, 0.038_038, 0.025_002_4, 0.012_534_9, 0.007_175_43, 0.002_995_55, 0.001_526_46, 0.000_554_025, 0.000_189_623],
    [1.0, 1.0, 1.0, 1.0, 1.0, 0.979_699, 0.845_985, 0.691_927, 0.539_045, 0.391_754, 0.320_455, 0.250_684, 0.202_056, 0.168_511, 0.122_86, 0.082_134_7, 0.058_071_2, 0.035_445_9, 0.023_306_2, 0.011_688_6, 0.006_692_24, 0.002_794_33, 0.001_424_03, 0.000_516_885, 0.000_176_917],
    [1.0, 1.0, 1.0, 1.0, 1.0, 0.938_158, 0.794_672, 0.645_449, 0.501_299, 0.364_02, 0.297_888, 0.233_313, 0.188_237, 0.157_08, 0.114_615, 0.076_675_7, 0.054_235, 0.033_118_9, 0.021_781_9, 0.010_927_3, 0.006_257_26, 0.002_613_08, 0.001_331_75, 0.000_483_416, 0.000_165_467],
    [1.0, 1.0, 1.0, 1.0, 1.0, 0.892_245, 0.746_892, 0.603_727, 0.467_876, 0.339_548, 0.277_952, 0.217_902, 0.175_936, 0.146_883, 0.107_24, 0.071_781_5, 0.050_790_6, 0.031_026_4, 0.020_41, 0.010_241_4, 0.005_865_23, 0.002_449_64, 0.001_248_52, 0.000_453_225, 0.000_155_136],
    [1.0, 1.0, 1.0, 1.0, 0.978_683, 0.846_386, 0.702_962, 0.566_261, 0.438_146, 0.317_845, 0.260_252, 0.204_172, 0.164_947, 0.137_757, 0.100_625, 0.067_383_4, 0.047_691_7, 0.029_141_5, 0.019_173_2, 0.009_622_65, 0.005_511_39, 0.002_302_08, 0.001_173_36, 0.000_425_956, 0.000_145_805],
    [1.0, 1.0, 1.0, 1.0, 0.942_978, 0.802_4, 0.662_799, 0.532_58, 0.411_6, 0.298_496, 0.244_458, 0.191_892, 0.155_095, 0.129_566, 0.094_677_2, 0.063_422, 0.044_897_5, 0.027_440_3, 0.018_056_3, 0.009_063_45, 0.005_191_5, 0.002_168_62, 0.001_105_38, 0.000_401_288, 0.000_137_363],
    [1.0, 1.0, 1.0, 0.982_237, 0.844_42, 0.704_287, 0.577_219, 0.462_076, 0.356_478, 0.258_41, 0.211_7, 0.166_328, 0.134_532, 0.112_438, 0.082_211_8, 0.055_102_8, 0.039_022_2, 0.023_858_2, 0.015_702_7, 0.007_884_01, 0.004_516_51, 0.001_886_9, 0.000_961_833, 0.000_349_194, 0.000_119_534],
    [1.0, 1.0, 1.0, 0.901_963, 0.753_828, 0.623_495, 0.509_138, 0.406_836, 0.313_594, 0.227_274, 0.186_226, 0.146_382, 0.118_444, 0.099_016_4, 0.072_421_6, 0.048_555_5, 0.034_392_1, 0.021_031_6, 0.013_844, 0.006_951_72, 0.003_982_72, 0.001_664, 0.000_848_241, 0.000_307_962, 0.000_105_422],
    [1.0, 1.0, 0.910_619, 0.744_013, 0.611_866, 0.503_155, 0.409_795, 0.327_025, 0.251_908, 0.182_545, 0.149_597, 0.117_634, 0.095_211, 0.079_609_2, 0.058_241_9, 0.039_058, 0.027_669_2, 0.016_923_1, 0.011_140_7, 0.005_594_87, 0.003_205_54, 0.001_339_37, 0.000_682_774, 0.000_247_893, 8.48597e-5],
    [1.0, 0.987_948, 0.775_064, 0.624_443, 0.511_721, 0.420_23, 0.342_029, 0.272_854, 0.210_147, 0.152_277, 0.124_799, 0.098_142_2, 0.079_441, 0.066_426_6, 0.048_600_8, 0.032_594_6, 0.023_091_4, 0.014_123_8, 0.009_298_12, 0.004_669_67, 0.002_675_49, 0.001_117_92, 0.000_569_887, 0.000_206_909, 7.083e-5],
    [1.0, 0.774_992, 0.584_873, 0.469_382, 0.384_222, 0.315_391, 0.256_652, 0.204_72, 0.157_665, 0.114_246, 0.093_630_3, 0.073_634, 0.059_604_3, 0.049_840_5, 0.036_466_4, 0.024_457, 0.017_326_6, 0.010_597_9, 0.006_977, 0.003_503_99, 0.002_007_63, 0.000_838_864, 0.000_427_633, 0.000_155_261, 5.31498e-5],
    [1.0, 0.621_327, 0.468_103, 0.375_534, 0.307_408, 0.252_327, 0.205_327, 0.163_781, 0.126_134, 0.091_399_6, 0.074_906_6, 0.058_908_9, 0.047_684_9, 0.039_873_6, 0.029_174_1, 0.019_566_3, 0.013_861_8, 0.008_478_64, 0.005_581_8, 0.002_803_3, 0.001_606_16, 0.000_671_116, 0.000_342_119, 0.000_124_213, 4.25214e-5],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_met_falls_and_joins_its_far_field() {
        assert_eq!(slip_field(1.0, 0.7), FIELD[8][7]);
        assert_eq!(slip_field(100.0, 0.0), 1.0);
        for z in [0.0, 0.02, 0.37, 2.0, 9.9, 50.0] {
            let mut last = 1.0;
            for step in 0..=400 {
                let now = slip_field(z, 0.05 * step as f32);
                assert!(now >= 0.0 && now <= last + 1.0e-6, "{z} {step}: {now} after {last}");
                last = now;
            }
            assert!((slip_field(z, 10.001) / slip_field(z, 9.999) - 1.0).abs() < 2.0e-3);
        }
    }

    #[test]
    fn rows_are_the_table_between_its_places() {
        for z in [0.02, 0.37, 2.0, 9.9] {
            let mut row = Row::ZERO;
            row.add(z, 0.2);
            let q: [f32; 256] = core::array::from_fn(|i| (i as f32 + 1.0) / 77.0);
            for (q, found) in q.into_iter().zip(row.at_all(&q, &q.map(|q| 1.0 / q))) {
                let exact = 0.2 * slip_field(z, q);
                let allowed = if q < CUBE { 1.0e-6 } else { 2.0e-5 };
                assert!((found - exact).abs() < allowed, "{z} {q}: {found} {exact}");
            }
        }
    }
}
