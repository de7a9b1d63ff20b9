//! The list of keys, made from the table that the keys are read by.

use eframe::egui::{self, Align2, Grid, RichText, vec2};

use super::keys::{BINDINGS, MOUSE, When};
use super::style::faint;

/// The parts of the list.
const PARTS: [(When, &str); 3] = [(When::Live, "Live session"), (When::Replay, "Recording"), (When::Always, "Picture")];

/// The rows of a part: keys and what they do.
pub fn rows(when: When) -> Vec<(String, &'static str)> {
    BINDINGS.iter().filter(|binding| binding.when == when).map(|binding| (binding.action.keys(), binding.words)).collect()
}

/// Shows the list while it is `open`.
pub fn show(context: &egui::Context, open: &mut bool) {
    let window = egui::Window::new("Keys and mouse").open(open).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(context, |ui| {
        Grid::new("keys").num_columns(2).spacing(vec2(24.0, 4.0)).show(ui, |ui| {
            for (when, title) in PARTS {
                heading(ui, title);
                for (keys, words) in rows(when) {
                    row(ui, &keys, words);
                }
            }
            heading(ui, "Mouse over the picture");
            for (hand, words) in MOUSE {
                row(ui, hand, words);
            }
        });
    });
}

fn heading(ui: &mut egui::Ui, title: &str) {
    ui.label(faint(title));
    ui.label("");
    ui.end_row();
}

fn row(ui: &mut egui::Ui, keys: &str, words: &str) {
    ui.label(RichText::new(keys).strong());
    ui.label(words);
    ui.end_row();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_the_table() {
        let listed: Vec<_> = PARTS.iter().flat_map(|(when, _)| rows(*when)).collect();
        assert_eq!(listed.len(), BINDINGS.len());
        for binding in &BINDINGS {
            assert!(listed.contains(&(binding.action.keys(), binding.words)), "{:?} is not listed", binding.action);
        }
    }
}
