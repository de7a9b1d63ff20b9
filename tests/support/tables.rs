//! Tables of truth that more than one proof reads.

use serde::Deserialize;

/// Histories of shift and twist together, of half-space boundary elements (B6).
#[derive(Deserialize)]
#[allow(non_snake_case, reason = "the table's own names")]
pub struct Combined {
    pub Qmax_N: f64,
    pub Tmax_Nm: f64,
    pub dt0_m: f64,
    pub phi_unit_rad: f64,
    pub mu: f64,
    pub R_m: f64,
    pub delta_m: f64,
    pub nu: f64,
    pub paths: Vec<CombinedPath>,
}

/// One history of [`Combined`]; lengths \[m\], turns \[rad\], answers \[N\] and \[N m\].
#[derive(Deserialize)]
#[allow(non_snake_case, reason = "the table's own names")]
pub struct CombinedPath {
    pub name: String,
    pub dx_m: Vec<f64>,
    pub phi_rad: Vec<f64>,
    pub Q_N: Vec<f64>,
    pub T_Nm: Vec<f64>,
}

/// The histories of B6.
pub fn combined_table() -> Combined {
    serde_json::from_str(include_str!("../truth/B6_combined.json")).expect("the table parses")
}

/// A sphere pressed on the cube and dragged, by finite elements (B5).
#[derive(Deserialize)]
#[allow(non_snake_case, reason = "the table's own names")]
pub struct DragTable {
    pub R_m: f64,
    pub rows: Vec<DragRow>,
}

/// One depth and friction of [`DragTable`].
#[derive(Deserialize)]
#[allow(non_snake_case, reason = "the table's own names")]
pub struct DragRow {
    pub nu: f64,
    pub delta_m: f64,
    pub mu: f64,
    pub F_N: f64,
    pub dt_m: Vec<f64>,
    pub Q_N: Vec<f64>,
}

/// The drags of B5.
pub fn drag_table() -> DragTable {
    serde_json::from_str(include_str!("../truth/B5_drag_cube.json")).expect("the table parses")
}

/// Histories of shift, twist and load together, of half-space boundary elements, in the units of the contact of radius 1.
#[derive(Deserialize)]
pub struct PressedTable {
    pub unconverged: usize,
    pub histories: Vec<PressedPath>,
}

/// One history of [`PressedTable`]: radius, shift and turn, and the answer to each.
#[derive(Deserialize)]
pub struct PressedPath {
    pub name: String,
    pub state: Vec<[f64; 4]>,
    pub answer: Vec<[f64; 3]>,
}

/// The histories under changing loads.
pub fn pressed_table() -> PressedTable {
    serde_json::from_str(include_str!("../truth/pressed_paths.json")).expect("the table parses")
}
