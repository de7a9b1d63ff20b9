//! The list of keys, made from the table that the keys are read by.

use eframe::egui::{self, Align2, Grid, RichText, vec2};

use super::keys::{BINDINGS, MOUSE, When};
use super::style::faint;

/// A part of the list, with its title.
enum Part {
    Keys(When, &'static str),
    Mouse(&'static str),
}

/// The list, side by side: one column would be higher than a small screen.
const COLUMNS: [&[Part]; 2] = [
    &[Part::Keys(When::Live, "Live session"), Part::Keys(When::Replay, "Recording"), Part::Mouse("Mouse over the picture")],
    &[Part::Keys(When::Always, "Picture")],
];

/// The rows of a part: keys and what they do.
pub fn rows(when: When) -> Vec<(String, &'static str)> {
    BINDINGS.iter().filter(|binding| binding.when == when).map(|binding| (binding.action.keys(), binding.words)).collect()
}

/// Shows the list while it is `open`.
pub fn show(context: &egui::Context, open: &mut bool) {
    let window = egui::Window::new("Keys and mouse").open(open).collapsible(false).resizable(false);
    window.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).show(context, |ui| {
        ui.horizontal_top(|ui| {
            for (number, parts) in COLUMNS.iter().enumerate() {
                ui.add_space(if number > 0 { 28.0 } else { 0.0 });
                Grid::new(number)
                    .num_columns(2)
                    .spacing(vec2(20.0, 4.0))
                    .show(ui, |ui| parts.iter().for_each(|part| show_part(ui, part)));
            }
        });
    });
}

fn show_part(ui: &mut egui::Ui, part: &Part) {
    match *part {
        Part::Keys(when, title) => {
            heading(ui, title);
            rows(when).iter().for_each(|(keys, words)| row(ui, keys, words));
        }
        Part::Mouse(title) => {
            heading(ui, title);
            MOUSE.iter().for_each(|(hand, words)| row(ui, hand, words));
        }
    }
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
        let listed = COLUMNS.iter().copied().flatten().flat_map(|part| match part {
            Part::Keys(when, _) => rows(*when),
            Part::Mouse(_) => Vec::new(),
        });
        let listed: Vec<_> = listed.collect();
        assert_eq!(listed.len(), BINDINGS.len());
        for binding in &BINDINGS {
            assert!(listed.contains(&(binding.action.keys(), binding.words)), "{:?} is not listed", binding.action);
        }
    }
}
