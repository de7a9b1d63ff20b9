//! What one unit of work costs, in instructions of the x86-64 release build: the only place where such figures stand.
//!
//! Each is fitted from rows of `tests/bench/COUNTS.md`, column *worst*, and rounded up; the rows are named. `cargo test -p haptor-tests --test it --
//! budget::estimates --nocapture` prints every row beside its estimate and what the difference would make of the figure it was fitted from: after a change
//! of the core that moves counts, run `cargo xtask counts`, then that, and put new values here. The test fails when an estimate is
//! below a counted row, or further above it than it may be.
//!
//! A few lie above what their rows give by more than rounding, and say by how much (rows of 23 November 2026): an estimate must bound contacts that meet otherwise than those
//! of the rows do, ten tips under a plate among them, and a figure whose row has become cheaper bounds it still.
//!
//! Figures of pairs are the dearest of a motion that tilts and walks over edges, not a proof: what is bounded by construction is how often each loop
//! turns (`bounds.md`); what a turn costs is counted.

use crate::model::{ObjectShape, ProbeShape};

/// A tick without a part, the ladder's own work included. "no contact, one part" less [`PART`].
pub const TICK: u32 = 1_720;

/// A tick whose pose is that of the tick before, or is refused, and what its report adds for each patch. "base, held still", and "bristle 64, half space, ten regions, held still" less that, by 9.
pub const STILL: u32 = 670;
/// See [`STILL`].
pub const STILL_PATCH: u32 = 45;

/// A part's bounding ball against the object. "no contact, ten parts" less "no contact, one part", by 9. 16 % above its rows.
pub const PART: u32 = 140;

/// The same on an object given by a mesh. "no contact, ten parts, mesh" less [`TICK`], by 10. 35 % above its row.
pub const PART_ON_MESH: u32 = 1_400;

/// Moving the probe on its coupling. "no friction, virtual coupling" less "no friction, half space, one region, twist".
pub const COUPLING: u32 = 4_200;

/// The guard's account of energy. "base, guard with passivity" less "base". 8 % above its rows.
pub const PASSIVITY: u32 = 400;

/// Objects of [`PAIR`].
pub const OBJECTS: usize = 8;

/// Shapes of [`PAIR`].
pub const SHAPES: usize = 7;

/// Looking at one part, following and pressing its contact once, the samples that a mesh is asked for apart. "SHAPE on OBJECT" less "no contact, one part", the first rows of box and cylinder from "SHAPE on wide OBJECT"; for a mesh
/// "mesh of 32 on OBJECT" less 32 times [`SAMPLE`]. Rows as [`object_row`], columns as [`shape_column`]. On an ellipsoid and
/// under the rim of a cylinder they are the dearest of looks at parts that lie a centimetre deep, which their rows do not; on a box they are looks near edges that do not cut the contact, up to a quarter above their rows.
const PAIR: [[u32; SHAPES]; OBJECTS] = [
    [1_780, 15_500, 2_500, 4_450, 5_950, 4_050, 146_000],
    [2_700, 19_500, 5_500, 8_300, 9_600, 7_700, 156_000],
    [3_350, 42_000, 3_900, 9_800, 13_200, 8_350, 155_000],
    [5_550, 72_000, 38_500, 38_000, 40_500, 43_500, 163_000],
    [3_500, 18_000, 5_000, 6_950, 8_600, 6_700, 159_000],
    [26_600, 88_000, 66_000, 66_500, 70_000, 65_500, 173_000],
    [2_800, 60_000, 34_000, 42_000, 60_000, 80_000, 160_000],
    [6_500, 162_000, 95_000, 157_000, 151_000, 138_500, 260_000],
];

/// The part of [`PAIR`] that is pressing, and each depth that is tried where the body gives way. Bounds of parts pressed at corners, beside others and in tiers of all kinds.
pub const PRESSED: [u32; SHAPES] = [570, 1_600, 900, 1_600, 1_600, 1_600, 1_600];
/// See [`PRESSED`].
pub const TRIAL: [u32; SHAPES] = [100, 450, 300, 450, 450, 450, 450];

/// Trials of a tick of the rows of [`PAIR`] on a body that gives way; on the half space there is none.
const TRIED: u32 = 2;

/// The part of [`PAIR`] that is looking, and following what is seen.
pub const LOOK: [[u32; SHAPES]; OBJECTS] = looks();

const fn looks() -> [[u32; SHAPES]; OBJECTS] {
    let mut looks = PAIR;
    let mut row = 0;
    // bound: OBJECTS
    while row < OBJECTS {
        let mut column = 0;
        // bound: SHAPES
        while column < SHAPES {
            let tried = if row == 0 { 0 } else { TRIED * TRIAL[column] };
            looks[row][column] = PAIR[row][column].saturating_sub(PRESSED[column] + tried);
            column += 1;
        }
        row += 1;
    }
    looks
}

/// A look by the edges of a box: what does not depend on counts, each point that the part is asked for, and each slice that is cut. Bounds of looks at parts that walk over edges and corners, most of them up to 10 %
/// above. Columns as [`shape_column`].
pub const LOOK_BY_EDGES: [u32; SHAPES] = [2_500, 27_500, 9_600, 6_600, 6_500, 5_500, 160_000];
/// See [`LOOK_BY_EDGES`].
pub const ASKED: u32 = 460;
/// See [`LOOK_BY_EDGES`].
pub const CUT: [u32; SHAPES] = [0, 2_800, 0, 4_000, 3_400, 4_200, 6_000];

/// A look at a primitive that turns out to keep apart from a box, the points that it is asked for apart: bounded as [`LOOK_BY_EDGES`] is.
pub const LOOK_APART: u32 = 3_500;

/// Points that a part is asked for where a look needs no search by edges: what proves that it needs none.
pub const ASKED_AT_LEAST: u32 = 4;

/// What a budget costs itself in a tick with parts that are near, and for each of them. "base, work to spare" less "base", and "influence 52, box, ten regions, work 1000000" less its row without, by 10.
pub const BUDGET: u32 = 1_250;
/// See [`BUDGET`].
pub const BUDGET_PART: u32 = 700;

/// Following a contact whose part is not looked at; a third of it by the part's farthest point, once it tips.
/// Columns as [`shape_column`].
pub const CARRIED: [u32; SHAPES] = [800, 1_800, 800, 1_800, 1_800, 1_800, 1_000];

/// One more sample that a mesh is asked for, by all that ask on an object. "mesh on OBJECT" less "mesh of 32 on OBJECT", by 224. Rows as [`object_row`].
pub const SAMPLE: [u32; OBJECTS] = [16, 80, 80, 76, 80, 80, 355, 120];

/// What two patches cost each other beside friction and dents: groups, for each patch and each other. "no friction, half space, ten regions, twist" less
/// ten parts and pairs, by 90, less [`DENT`]. 10 % above its row.
pub const NEIGHBOUR: u32 = 80;

/// Joining two regions beyond the limit: for each patch and each other. Counted as [`NEIGHBOUR`] is, which holds one look at every pair.
pub const EXCESS: u32 = 65;

/// The dent of a neighbour, each time a patch is pressed: for each patch and each other. "no friction, box, ten regions, births" less its steady row and ten [`PRESSED`], by 90.
pub const DENT: u32 = 50;

/// What the body's table adds to pressing a patch. "no friction, box with a table, one region" less "no friction, box, one region, twist". 4 % above its rows.
pub const TABLE: u32 = 4_250;

/// The same for each patch and each other. "no friction, box with a table, ten regions" less "no friction, box, ten regions, twist" and ten [`TABLE`], by 90.
pub const TABLE_NEIGHBOUR: u32 = 8_200;

/// The ground under a patch that friction holds, where there is a body. "bristle 64, box, ten regions, twist" less "bristle 64, half space, ten regions, twist" and what the two differ by without
/// friction, by 10, and what the column of the ground in the table of functions says of ten tips under a plate.
pub const GROUND: u32 = 1_400;

/// How the grips of four patches move the ground of one: for each patch and each four of all. From the same column, by 30.
pub const GROUND_FOUR: u32 = 460;

/// The same by the body's table. "point, box with a table, ten regions" less its row without friction, ten [`POINT`] and ten [`GROUND`], by 90.
pub const GROUND_TABLE_NEIGHBOUR: u32 = 8_300;

/// Tier `point`, a patch. Of a patch that slides and turns at once with turning points behind it, which is up to 1.8 times "point, sphere on half space" less "sphere on half space".
pub const POINT: u32 = 4_900;

/// Tier `paper`, a patch and a sample. "paper 64, half space, one region, slide" and "twist" less their rows without friction.
pub const PAPER: u32 = 300;
/// See [`PAPER`].
pub const PAPER_SAMPLE: u32 = 131;

/// Tier `bristle`, a patch, a sample that the contact reaches, and one of a grid that is laid anew. "base, bristle 16", "base" and "base, bristle 256" less "no friction, half space, one region, twist".
pub const BRISTLE: u32 = 2_000;
/// See [`BRISTLE`].
pub const BRISTLE_SAMPLE: u32 = 238;
/// See [`BRISTLE`].
pub const BRISTLE_LAID: u32 = 60;

/// Tiers `influence` and `green`: a place with its four cells once a tick (loads, laying the grid anew, taking and giving back), a visit of it, and what one other place pulls
/// at it in a visit. "base, influence 52, one sweep", "influence 52, box, one region, slide" and "base, influence 112" less their rows without friction.
pub const PLACE: u32 = 1_720;
/// See [`PLACE`].
pub const VISIT: u32 = 190;
/// See [`PLACE`].
pub const PULL: u32 = 17;

/// A call for the surface: what does not depend on the point. "surface of 64, ..." less 64 vertices; with [`SHOWN_BODY`] for the motion of the body, and
/// [`SHOWN_PATCH`] a patch.
pub const SHOWN: u32 = 1_900;
/// See [`SHOWN`].
pub const SHOWN_BODY: u32 = 35_600;
/// See [`SHOWN`].
pub const SHOWN_PATCH: u32 = 12_000;

/// A vertex of the surface: "surface of 4096, ..." less "surface of 64, ...", by 4032; with [`VERTEX_BODY`] for the motion of the body, and [`VERTEX_PATCH`] a patch.
pub const VERTEX: u32 = 56;
/// See [`VERTEX`].
pub const VERTEX_BODY: u32 = 100;
/// See [`VERTEX`].
pub const VERTEX_PATCH: u32 = 65;

/// Row of an object in [`PAIR`], with an edge of it within the part's reach or without.
pub const fn object_row(object: &ObjectShape<'_>, edge: bool) -> usize {
    match object {
        ObjectShape::HalfSpace => 0,
        ObjectShape::Box { .. } if edge => 6,
        ObjectShape::Cylinder { .. } if edge => 7,
        ObjectShape::Box { .. } => 1,
        ObjectShape::Sphere { .. } => 2,
        ObjectShape::Ellipsoid { .. } => 3,
        ObjectShape::Cylinder { .. } => 4,
        ObjectShape::Mesh(_) => 5,
    }
}

/// Column of a part's shape in [`PAIR`].
pub const fn shape_column(shape: &ProbeShape<'_>) -> usize {
    match shape {
        ProbeShape::Sphere { .. } => 0,
        ProbeShape::Box { .. } => 1,
        ProbeShape::Ellipsoid { .. } => 2,
        ProbeShape::Capsule { .. } => 3,
        ProbeShape::Cylinder { .. } => 4,
        ProbeShape::Cone { .. } => 5,
        ProbeShape::Mesh(_) => 6,
    }
}
