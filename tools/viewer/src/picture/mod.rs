//! From a stage and a moment to triangles, colours and a legend: one builder, whatever draws them then.
//!
//! Colours (sRGB): the object from light to dark by how far its surface moved or by the pressure on it; a region as a blue core where it sticks
//! within an orange ring where it slips (M. Okabe, K. Ito, Color Universal Design, 2008: told apart in every common colour blindness); force
//! red, torque violet.

pub mod batch;
mod builder;
mod legend;
mod mako;
mod pressure;
mod quantity;
mod settings;
mod shapes;
mod signs;
mod skin;

pub use batch::{Batch, Colour, Paint};
pub use builder::{Builder, LAYERS, Layer, Picture};
pub use legend::{Bar, Legend, Row, Sign};
pub use mako::MAKO;
pub use quantity::{Quantity, Unit, decimals, figure, round_step};
pub use settings::{ColourBy, Settings};
