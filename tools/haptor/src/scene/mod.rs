//! The scene file: TOML in SI units, read completely or refused with file, line, key, value, what is allowed and what to do.
//!
//! Three steps: [`document`] knows lines, [`body`] and [`settings`] know keys, the core's constructors know ranges. A value that
//! the core refuses is traced back to its line.

mod bake;
mod body;
mod coupling;
mod document;
#[cfg(test)]
mod kept_inputs;
mod settings;
mod skin;

use std::path::Path;

use haptor_contact::{GuardSpec, Invalid, Model, ModelSpec, Params, ParamsSpec};

pub use bake::grid_contents;
pub use body::{Object, Probe};
pub use document::SceneError;
pub use document::{Document, Key, key};
pub use settings::Extras;
pub use skin::{Skin, fetch_body};

use crate::failure::Failure;

/// Largest scene file read \[bytes\]: a hand-written scene has a few kilobytes.
const MAX_FILE_BYTES: u64 = 1 << 20;

const OBJECT: Key = key("object", "the section of the elastic body", "{ shape = \"box\", ... }");
const PROBE: Key = key("probe", "the section of the rigid body", "{ shape = \"sphere\", ... }");
const FRICTION: Key = key("friction", "the section of the coefficients", "{ dynamic = 0.75 }");
const CONTACT: Key = key("contact", "the section of the regions", "{ region_distance = 0.004, max_regions = 10 }");
const MODEL: Key = key("model", "the section of the fidelity", "{ tier = \"bristle\", samples = 64 }");
const GUARD: Key = key("guard", "the section of the limits", "{ max_force = 8.5, max_torque = 0.188 }");

/// The scene of the demonstration: the paper's ball on a rubber cube.
const DEFAULT: (&str, &str) = ("cube-twist.toml", include_str!("../../../../tests/scenes/cube-twist.toml"));

/// The scene of a file, or the ball on the cube when none is named.
///
/// # Errors
/// As [`Scene::load`].
pub fn load_or_default(path: Option<&Path>) -> Result<Scene, Failure> {
    match path {
        Some(path) => Scene::load(path),
        None => Scene::parse(DEFAULT.0, DEFAULT.1).map_err(|error| Failure::BadInput(error.into())),
    }
}

/// A scene whose every value the core accepts.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The elastic body.
    pub object: Object,
    /// The rigid body.
    pub probe: Probe,
    /// Friction, regions, tier, guard.
    pub params: ParamsSpec,
    /// What the core does not need.
    pub extras: Extras,
}

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// [`Failure::BadInput`] naming the file and, where there is one, the line.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        let text = read_text(path)?;
        Self::parse(&path.display().to_string(), &text).map_err(|error| Failure::BadInput(error.into()))
    }

    /// Reads a scene from text; `file` is its name in messages.
    ///
    /// # Errors
    /// [`SceneError`] at the first thing that is wrong.
    pub fn parse(file: &str, text: &str) -> Result<Self, SceneError> {
        let document = Document::new(file, text);
        let table = document.parse()?;
        let root = document.root(&table);
        let mut params = ParamsSpec::default();
        let object = body::object(&root.section(OBJECT)?)?;
        let probe = body::probe(&root.section(PROBE)?)?;
        settings::friction(&root.section(FRICTION)?, &mut params)?;
        if let Some(section) = root.optional_section(CONTACT)? {
            settings::contact(&section, &mut params)?;
        }
        let mut extras = settings::model(&root, root.optional_section(MODEL)?.as_ref(), &mut params)?;
        if let Some(section) = root.optional_section(GUARD)? {
            settings::guard(&section, &mut params, &mut extras)?;
        }
        root.finish("a scene")?;
        let scene = Self { object, probe, params, extras };
        scene.validate().map_err(|Refused { name, invalid }| document.refused(&name, invalid.value, invalid.allowed))?;
        Ok(scene)
    }

    /// The spec of the core's model, which borrows the probe's parts.
    pub fn model_spec(&self) -> ModelSpec<'_> {
        let mut spec = ModelSpec::new(self.object.shape, self.object.material, &self.probe.parts);
        spec.fixed_below = self.object.fixed_below;
        spec.compliance = self.object.compliance;
        spec.mass = self.probe.mass;
        spec.inertia = self.probe.inertia;
        if let Some(length) = self.extras.paper_length {
            spec.paper_length = length;
        }
        spec
    }

    /// The skins that bodies of the scene have, in the order in which a baked file carries them: the object's, then those of the probe's parts.
    pub fn skins(&self) -> impl Iterator<Item = &Skin> {
        self.object.skin.iter().chain(self.probe.skins.iter().flatten())
    }

    /// The scene's parameters with a guard that does nothing, for whoever wants the contact's own wrench: no limit, no ramp, no damping, and
    /// no flag that speaks of one.
    pub fn contact_only(&self) -> ParamsSpec {
        ParamsSpec { guard: GuardSpec::OPEN, ..self.params }
    }

    fn validate(&self) -> Result<(), Refused> {
        let spec = self.model_spec();
        if self.probe.compound {
            for (index, part) in self.probe.parts.iter().enumerate() {
                let alone = ModelSpec { probe: std::slice::from_ref(part), ..spec };
                Model::new(&alone).map_err(|invalid| Refused { name: part_name(invalid.name, index), invalid })?;
            }
        }
        let whole = |invalid: Invalid| Refused { name: invalid.name.to_owned(), invalid };
        Model::new(&spec).map_err(whole)?;
        // a number that a device's lower one would hide is checked as it is written
        Params::new(&ParamsSpec { coupling: coupling::as_written(&self.extras.coupling), ..self.params }).map_err(whole)?;
        Params::new(&self.params).map_err(whole)?;
        Ok(())
    }
}

/// A value that the core refuses, under the name it has in the file.
struct Refused {
    name: String,
    invalid: Invalid,
}

/// `probe.radius` of part 2 is `probe.part[2].radius` in the file.
fn part_name(name: &str, index: usize) -> String {
    let bare = name.split(' ').next().unwrap_or(name);
    match bare.strip_prefix("probe.").filter(|key| *key != "mass") {
        Some(key) => format!("probe.part[{index}].{key}"),
        None => name.to_owned(),
    }
}

/// The text of a scene file.
fn read_text(path: &Path) -> Result<String, Failure> {
    let shown = path.display();
    let unreadable = |error| Failure::bad_input(format!("{shown}: cannot be read: {error}; give the path of a scene file"));
    let size = std::fs::metadata(path).map_err(unreadable)?.len();
    if size > MAX_FILE_BYTES {
        let what = format!("{shown}: is {size} bytes, allowed is up to {MAX_FILE_BYTES}; is this a scene file?");
        return Err(Failure::bad_input(what));
    }
    let bytes = std::fs::read(path).map_err(unreadable)?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let line = crate::text::line_of(error.as_bytes(), error.utf8_error().valid_up_to());
        Failure::bad_input(format!("{shown}:{line}: is not UTF-8 text; save the file as UTF-8"))
    })?;
    Ok(text.strip_prefix('\u{feff}').map_or(text.clone(), str::to_owned))
}
