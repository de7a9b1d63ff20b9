//! What the signs and colours of a picture mean, with figures and units; whoever shows the picture writes it beside.

use super::batch::Colour;

/// The legend.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Legend {
    /// Signs, from the top.
    pub rows: Vec<Row>,
    /// The colour scale of the object.
    pub bar: Option<Bar>,
}

/// A sign and what it means.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What the sign looks like.
    pub sign: Sign,
    /// Its colour.
    pub colour: Colour,
    /// What it means and how large it is.
    pub words: String,
    /// Its scale; empty when it has none.
    pub scale: String,
}

/// What a sign looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// A straight arrow.
    Arrow,
    /// A bent arrow.
    Arc,
    /// A filled disc.
    Disc,
    /// A ring.
    Ring,
    /// A tile of the ground.
    Tile,
}

/// A scale of colours from zero to an end.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Value at its upper end \[SI\].
    pub end: f64,
    /// What is measured, with its unit.
    pub title: String,
    /// Marks: share of the scale, 0 to 1, and the figure.
    pub ticks: Vec<(f64, String)>,
}
