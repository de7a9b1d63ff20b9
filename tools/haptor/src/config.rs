//! The user's configuration: what `run` and its kin take where the command line says nothing.
//!
//! A TOML file in the place where such files lie, `$XDG_CONFIG_HOME/haptor/config.toml` or `~/.config/haptor/config.toml`; `HAPTOR_CONFIG`
//! names another. The command line goes before the file, the file before the built-in defaults. Unknown keys are errors.

use std::env;
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;

use crate::failure::Failure;
use crate::scene::{Document, Key, key};

/// The variable that names another file.
pub const VARIABLE: &str = "HAPTOR_CONFIG";

/// Ticks a second when nobody says otherwise \[Hz\].
pub const RATE: u32 = 1000;

/// Real-time rights when nobody says otherwise.
pub const RT: &str = "enforce";

/// The devices that can be simulated, as `--preset` spells them.
pub const PRESETS: [&str; 4] = ["premium15", "sigma7", "omega6", "touch"];

/// The simulated device when nobody says otherwise: the smallest that renders torque.
pub const PRESET: &str = "premium15";

/// What `config --init` writes: every key, commented out, with its default.
pub const TEMPLATE: &str = "\
# haptor: defaults of `haptor run` and `haptor record`. The command line goes before this file.
# device = \"usb\"              # sim, usb, usb:SERIAL, serial:PORT, serial:NUMBER or tcp:HOST:PORT; none: must be given
# rate = 1000                 # ticks per second, 100 to 8000 Hz
# rt = \"enforce\"              # enforce: refuse to start without real-time rights; ignore: take what is granted
# preset = \"premium15\"        # what `--device sim` simulates: premium15, sigma7, omega6, touch
";

const DEVICE: Key = key("device", "sim, usb, usb:SERIAL, serial:PORT, serial:NUMBER or tcp:HOST:PORT", "\"usb\"");
const RATE_KEY: Key = key("rate", "100 to 8000 Hz", "1000");
const RT_KEY: Key = key("rt", "enforce or ignore", "\"enforce\"");
const PRESET_KEY: Key = key("preset", "premium15, sigma7, omega6 or touch", "\"premium15\"");

/// What the file says; `None` where it says nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Config {
    /// The device, as `--device` spells it.
    pub device: Option<String>,
    /// Ticks a second \[Hz\].
    pub rate: Option<u32>,
    /// `enforce` or `ignore`.
    pub rt: Option<String>,
    /// The device that is simulated.
    pub preset: Option<String>,
}

/// Where the file is looked for; `None` without a home. The flag says that somebody named it.
pub fn path() -> (Option<PathBuf>, bool) {
    use etcetera::BaseStrategy;
    if let Some(named) = env::var_os(VARIABLE).filter(|name| !name.is_empty()) {
        return (Some(named.into()), true);
    }
    let base = etcetera::choose_base_strategy().ok();
    (base.map(|base| base.config_dir().join("haptor").join("config.toml")), false)
}

impl Config {
    /// Reads the file; without one, nothing is said.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when a file that was named is missing, one cannot be read, or a key or value is wrong.
    pub fn load() -> Result<Self, Failure> {
        let (path, named) = path();
        let Some(path) = path else { return Ok(Self::default()) };
        let shown = path.display().to_string();
        match fs::read_to_string(&path) {
            Ok(text) => Self::parse(&shown, &text),
            Err(error) if error.kind() == ErrorKind::NotFound && !named => Ok(Self::default()),
            Err(error) => Err(Failure::bad_input(format!("{shown}: cannot be read: {error}"))),
        }
    }

    /// Reads the text of a file called `name` in messages.
    fn parse(name: &str, text: &str) -> Result<Self, Failure> {
        let document = Document::new(name, text);
        let table = document.parse().map_err(Failure::bad_input)?;
        let root = document.root(&table);
        let config = || {
            let config = Self {
                device: root.optional_text(DEVICE)?.map(str::to_owned),
                // one that is too large for the type is too large for the range
                rate: root.optional_count(RATE_KEY)?.map(|rate| u32::try_from(rate).unwrap_or(u32::MAX)),
                rt: root.optional_word(RT_KEY, &words(&["enforce", "ignore"]))?.map(str::to_owned),
                preset: root.optional_word(PRESET_KEY, &words(&PRESETS))?.map(str::to_owned),
            };
            root.finish("the configuration")?;
            if config.rate.is_some_and(|rate| !(100..=8000).contains(&rate)) {
                return Err(root.error("rate", "allowed is 100 to 8000 Hz"));
            }
            if let Some(Err(allowed)) = config.device.as_deref().map(crate::command::device_kind) {
                return Err(root.error("device", &allowed));
            }
            Ok(config)
        };
        config().map_err(Failure::bad_input)
    }
}

/// Words that mean themselves.
fn words<'w>(words: &[&'w str]) -> Vec<(&'w str, &'w str)> {
    words.iter().map(|&word| (word, word)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_read_and_the_template_says_nothing() {
        let text = "device = \"serial:/dev/ttyACM0\"\nrate = 2000\nrt = \"ignore\"\npreset = \"sigma7\"\n";
        let config = Config::parse("config.toml", text).unwrap();
        assert_eq!((config.device.as_deref(), config.rate), (Some("serial:/dev/ttyACM0"), Some(2000)));
        assert_eq!((config.rt.as_deref(), config.preset.as_deref()), (Some("ignore"), Some("sigma7")));
        assert_eq!(Config::parse("config.toml", TEMPLATE).unwrap(), Config::default());
    }

    #[test]
    fn the_template_names_every_key_with_a_good_value() {
        let spoken: String = TEMPLATE.lines().skip(1).map(|line| format!("{}\n", line.trim_start_matches("# "))).collect();
        let config = Config::parse("config.toml", &spoken).unwrap();
        let defaults = (Some(RATE), Some(RT), Some(PRESET));
        assert!(config.device.is_some());
        assert_eq!((config.rate, config.rt.as_deref(), config.preset.as_deref()), defaults);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let table = [
            ("rate = 99", "config.toml:1: rate = 99: allowed is 100 to 8000 Hz"),
            ("rate = 5000000000", "rate = 5000000000: allowed is 100 to 8000 Hz"),
            ("\nrate = \"fast\"", "config.toml:2: rate = \"fast\""),
            ("device = \"hid\"", "allowed is sim, usb"),
            ("rt = \"force\"", "allowed is enforce or ignore"),
            ("preset = \"omega7\"", "omega6"),
            ("speed = 1", "speed"),
            ("rate = ", "not TOML"),
        ];
        for (text, part) in table {
            let failure = Config::parse("config.toml", text).unwrap_err();
            let said = failure.error().to_string();
            assert!(said.contains(part) && failure.exit_code() == 2, "{text}: {said}");
        }
    }
}
