//! What a person can ask for, and by which key: the one table that keys, buttons and the help are made from.

use eframe::egui::{self, Key};

/// Something a person can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Brake the device.
    EStop,
    /// Let forces through again.
    Rearm,
    /// Begin or end a recording.
    Record,
    /// Hold the picture or let it go.
    Freeze,
    /// Take the wrench for zero.
    Tare,
    /// The next thing that colours say.
    Colours,
    /// An arrow for each region.
    RegionForces,
    /// Arrows longer.
    Longer,
    /// Arrows shorter.
    Shorter,
    /// Scales by what is seen from now on.
    Rescale,
    /// Probe translucent, solid, hidden.
    Probe,
    /// The whole scene from the usual side.
    Reset,
    /// The contact, near.
    Contact,
    /// From the front.
    Front,
    /// From the right.
    Side,
    /// From above.
    Top,
    /// Play or hold the recording.
    Play,
    /// A tick back.
    Back,
    /// A tick on.
    On,
    /// Half the speed.
    Slower,
    /// Twice the speed.
    Faster,
    /// This list.
    Help,
}

/// When a key means something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// Always.
    Always,
    /// With a live session.
    Live,
    /// With a recording.
    Replay,
}

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// What is asked for.
    pub action: Action,
    /// Any of these keys.
    pub keys: &'static [Key],
    /// When they mean it.
    pub when: When,
    /// What happens, for the help.
    pub words: &'static str,
}

const fn row(action: Action, keys: &'static [Key], when: When, words: &'static str) -> Binding {
    Binding { action, keys, when, words }
}

/// Every key of the window.
pub const BINDINGS: [Binding; 22] = [
    row(Action::EStop, &[Key::Space], When::Live, "E-stop: release the device to its brake"),
    row(Action::Rearm, &[Key::A], When::Live, "Re-arm: let forces through again"),
    row(Action::Record, &[Key::R], When::Live, "Begin or end a recording"),
    row(Action::Freeze, &[Key::F], When::Live, "Fade the force to zero and let contact and picture stand, or go on"),
    row(Action::Tare, &[Key::T], When::Live, "Place the probe where the scene starts it; without contact only"),
    row(Action::Play, &[Key::Enter, Key::K], When::Replay, "Play or hold the recording"),
    row(Action::Back, &[Key::ArrowLeft], When::Replay, "One tick back"),
    row(Action::On, &[Key::ArrowRight], When::Replay, "One tick on"),
    row(Action::Slower, &[Key::OpenBracket], When::Replay, "Half the speed"),
    row(Action::Faster, &[Key::CloseBracket], When::Replay, "Twice the speed"),
    row(Action::Colours, &[Key::C], When::Always, "Colours: displacement, pressure, none"),
    row(Action::RegionForces, &[Key::G], When::Always, "Show the force of each region"),
    row(Action::Longer, &[Key::Plus, Key::Equals], When::Always, "Longer arrows"),
    row(Action::Shorter, &[Key::Minus], When::Always, "Shorter arrows"),
    row(Action::Rescale, &[Key::S], When::Always, "Choose scales anew"),
    row(Action::Probe, &[Key::P], When::Always, "Probe: translucent, solid, hidden"),
    row(Action::Reset, &[Key::Num0, Key::Home], When::Always, "Whole scene"),
    row(Action::Contact, &[Key::Z], When::Always, "Zoom on the contact"),
    row(Action::Front, &[Key::Num1], When::Always, "From the front"),
    row(Action::Side, &[Key::Num2], When::Always, "From the right"),
    row(Action::Top, &[Key::Num3], When::Always, "From above"),
    row(Action::Help, &[Key::F1, Key::Questionmark], When::Always, "This list"),
];

/// What the mouse does over the scene, for the help.
pub const MOUSE: [(&str, &str); 4] = [
    ("drag", "Turn"),
    ("right or middle drag, Shift + drag", "Move"),
    ("wheel", "Nearer, farther"),
    ("double click", "Whole scene"),
];

impl Action {
    /// Its row of the table.
    pub fn binding(self) -> &'static Binding {
        let found = BINDINGS.iter().find(|binding| binding.action == self);
        // a test holds that every action has a row
        found.unwrap_or(&BINDINGS[BINDINGS.len() - 1])
    }

    /// Its keys as they are written on a keyboard.
    pub fn keys(self) -> String {
        self.binding().keys.iter().map(|key| sign(*key)).collect::<Vec<_>>().join(" or ")
    }

    /// Its first key.
    pub fn key(self) -> &'static str {
        self.binding().keys.first().map_or("", |key| sign(*key))
    }
}

/// A key as it is written on a keyboard.
fn sign(key: Key) -> &'static str {
    match key {
        Key::OpenBracket => "[",
        Key::CloseBracket => "]",
        Key::ArrowLeft => "Left",
        Key::ArrowRight => "Right",
        Key::Minus => "-",
        key => key.symbol_or_name(),
    }
}

/// What the keys pressed since the last picture ask for; the keys then count as used. While a person types into a field only the e-stop counts.
pub fn pressed(context: &egui::Context, replay: bool) -> Vec<Action> {
    let typing = context.text_edit_focused();
    let now = if replay { When::Replay } else { When::Live };
    let fits = |binding: &&Binding| [When::Always, now].contains(&binding.when) && (!typing || binding.action == Action::EStop);
    context.input_mut(|input| {
        let mut take = |binding: &&Binding| {
            // signs such as + and ? need Shift on some keyboards
            let mut used =
                |key: Key| input.consume_key(egui::Modifiers::NONE, key) || input.consume_key(egui::Modifiers::SHIFT, key);
            binding.keys.iter().any(|&key| used(key))
        };
        BINDINGS.iter().filter(fits).filter(|binding| take(binding)).map(|binding| binding.action).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_action_has_one_row_and_every_key_one_meaning() {
        for (number, binding) in BINDINGS.iter().enumerate() {
            assert_eq!(BINDINGS.iter().filter(|other| other.action == binding.action).count(), 1, "{:?}", binding.action);
            assert!(!binding.keys.is_empty() && !binding.words.is_empty(), "{:?}", binding.action);
            for other in &BINDINGS[..number] {
                assert!(binding.keys.iter().all(|key| !other.keys.contains(key)), "{:?} and {:?}", binding.action, other.action);
            }
        }
        // the last action's number tells how many there are
        assert_eq!(Action::Help as usize + 1, BINDINGS.len());
    }

    fn press(key: Key, replay: bool) -> Vec<Action> {
        let context = egui::Context::default();
        let event = egui::Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: egui::Modifiers::NONE };
        let input = egui::RawInput { events: vec![event], ..egui::RawInput::default() };
        let mut actions = Vec::new();
        context.run_ui(input, |ui| actions.extend(pressed(ui.ctx(), replay))).drop_without_applying_deltas();
        actions
    }

    #[test]
    fn every_key_of_the_table_does_what_it_says() {
        for binding in &BINDINGS {
            for &key in binding.keys {
                for replay in [false, true] {
                    let means = binding.when == When::Always || (binding.when == When::Replay) == replay;
                    let expected = if means { vec![binding.action] } else { Vec::new() };
                    assert_eq!(press(key, replay), expected, "{key:?}, replay {replay}");
                }
            }
        }
    }
}
