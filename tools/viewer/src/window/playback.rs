//! The bar below the picture, with a recording: play, hold, wind, speed.

use eframe::egui::{self, Button, RichText, vec2};

use super::app::App;
use super::keys::Action;
use super::style::faint;
use crate::feed::Command;

/// Room for time and speed at the right \[points\].
const RIGHT: f32 = 330.0;

/// Shows the bar.
pub fn show(ui: &mut egui::Ui, app: &mut App) {
    let Some(playback) = app.playback() else { return };
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let play = if playback.playing { "\u{23f8} Hold" } else { "\u{25b6} Play" };
        act(ui, app, Action::Play, &format!("{play} ({})", Action::Play.key()), 110.0);
        act(ui, app, Action::Back, "\u{2212}1 tick", 52.0);
        act(ui, app, Action::On, "+1 tick", 52.0);
        let mut at = playback.at;
        ui.spacing_mut().slider_width = (ui.available_width() - RIGHT).max(60.0);
        let bar = egui::Slider::new(&mut at, 0.0..=playback.end).show_value(false).trailing_fill(true);
        if ui.add(bar).changed() {
            app.send(Command::Seek(at));
        }
        ui.label(RichText::new(format!("{:.3} s", playback.at)).monospace());
        ui.label(faint(format!("of {:.3} s", playback.end)));
        ui.separator();
        act(ui, app, Action::Slower, Action::Slower.key(), 22.0);
        ui.label(RichText::new(format!("\u{d7} {}", playback.speed)).monospace()).on_hover_text("seconds of recording a second");
        act(ui, app, Action::Faster, Action::Faster.key(), 22.0);
    });
    ui.add_space(2.0);
}

fn act(ui: &mut egui::Ui, app: &mut App, action: Action, words: &str, width: f32) {
    if ui.add(Button::new(words).min_size(vec2(width, 24.0))).on_hover_text(action.binding().words).clicked() {
        app.act(action);
    }
}
