//! What whoever looks may choose.

/// What the object's colours say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourBy {
    /// How far the surface has moved.
    #[default]
    Displacement,
    /// Pressure on the surface.
    Pressure,
    /// Nothing: one colour.
    Nothing,
}

impl ColourBy {
    /// All, in the order in which they are offered.
    pub const ALL: [Self; 3] = [Self::Displacement, Self::Pressure, Self::Nothing];

    /// As a command line spells it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Pressure => "pressure",
            Self::Nothing => "none",
        }
    }
}

/// How a picture is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What the object's colours say.
    pub colour_by: ColourBy,
    /// Value at the upper end of the colour scale \[m or Pa\]; `None` = round, by the largest seen.
    pub colour_end: Option<f64>,
    /// Steps of the ladder 1, 2, 5, 10 by which arrows and arcs are longer than they choose themselves.
    pub longer: i32,
    /// An arrow for the force of each region as well.
    pub region_forces: bool,
    /// How much the probe covers of what is behind it, 0 to 1.
    pub probe_opacity: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self { colour_by: ColourBy::default(), colour_end: None, longer: 0, region_forces: false, probe_opacity: 0.45 }
    }
}
