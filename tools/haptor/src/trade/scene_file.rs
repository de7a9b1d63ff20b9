//! Writes a setting into a scene file: the keys change, comments and order stay.

use toml_edit::{DocumentMut, Item, Table, value};

use super::settings::Setting;

/// The scene's text with tier, samples and sweeps of `setting`.
///
/// # Errors
/// What keeps the text from being changed.
pub fn with(text: &str, setting: &Setting) -> Result<String, String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("{error}"))?;
    let model = document.entry("model").or_insert(Item::Table(Table::new()));
    let Some(model) = model.as_table_like_mut() else { return Err("[model] is no table".to_owned()) };
    let mut set = |key: &str, new: toml_edit::Value| match model.get_mut(key).and_then(Item::as_value_mut) {
        // what stands around the old value, a comment say, stays
        Some(old) => {
            let decor = old.decor().clone();
            *old = new;
            *old.decor_mut() = decor;
        }
        None => drop(model.insert(key, value(new))),
    };
    set("tier", setting.tier.name().into());
    if setting.tier != haptor_contact::Tier::Point {
        set("samples", (setting.samples as i64).into());
    }
    if setting.sweeps_cells() {
        set("sweeps", (setting.sweeps as i64).into());
    }
    Ok(document.to_string())
}

#[cfg(test)]
mod tests {
    use super::super::settings::ALL;
    use super::*;

    #[test]
    fn comments_stay_and_keys_change() {
        let scene = "# mine\n[model]   # how\ntier = \"point\" # fast\n\n[friction]\ndynamic = 0.5\n";
        let found = with(scene, &ALL[15]).unwrap();
        assert_eq!(
            found,
            "# mine\n[model]   # how\ntier = \"influence\" # fast\nsamples = 112\nsweeps = 4\n\n[friction]\ndynamic = 0.5\n"
        );
        assert!(with("[object]\n", &ALL[6]).unwrap().ends_with("[model]\ntier = \"bristle\"\nsamples = 64\n"));
        assert!(with("model = 3\n", &ALL[6]).is_err());
    }
}
