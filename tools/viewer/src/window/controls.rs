//! The panel at the left: the e-stop, the session's buttons, what the picture shows, the regions in figures, what happened.

use eframe::egui::{self, Button, Color32, Grid, RichText, vec2};

use super::app::App;
use super::keys::Action;
use super::style::{self, faint};
use crate::feed::{Mode, Region, Severity};
use crate::picture::{ColourBy, Quantity};

/// Width of the panel \[points\].
pub const WIDTH: f32 = 236.0;

/// Height of the e-stop \[points\].
const E_STOP: f32 = 56.0;

/// Events shown.
const EVENTS: usize = 12;

/// Shows the panel.
pub fn show(ui: &mut egui::Ui, app: &mut App) {
    ui.add_space(6.0);
    show_stop(ui, app);
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        show_session(ui, app);
        section(ui, &format!("Colours ({})", Action::Colours.key()), true, |ui| show_colours(ui, app));
        section(ui, "Arrows and probe", true, |ui| show_signs(ui, app));
        section(ui, "View", true, |ui| show_views(ui, app));
        section(ui, "Regions", true, |ui| show_regions(ui, app));
        section(ui, "Events", true, |ui| show_events(ui, app));
    });
}

fn section(ui: &mut egui::Ui, title: &str, open: bool, content: impl FnOnce(&mut egui::Ui)) {
    ui.add_space(2.0);
    egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(open).show_unindented(ui, content);
}

/// A button for an action, its key beside.
fn button(ui: &mut egui::Ui, app: &mut App, action: Action, words: &str, width: f32) {
    let button = Button::new(format!("{words} ({})", action.key())).min_size(vec2(width, 0.0));
    if ui.add(button).on_hover_text(action.binding().words).clicked() {
        app.act(action);
    }
}

/// The e-stop, always in sight; without a device there is nothing to stop.
fn show_stop(ui: &mut egui::Ui, app: &mut App) {
    let replay = app.playback().is_some();
    let braked = app.mode() == Mode::Braked;
    let words = match (replay, braked) {
        (true, _) => "no device in a recording".to_owned(),
        (false, true) => "BRAKED".to_owned(),
        (false, false) => format!("E-STOP ({})", Action::EStop.key()),
    };
    let fill = if replay { Color32::from_rgb(52, 57, 66) } else { Color32::from_rgb(200, 24, 24) };
    let size = if replay { 14.0 } else { 22.0 };
    let button = Button::new(RichText::new(words).size(size).strong().color(Color32::WHITE)).fill(fill);
    let size = vec2(ui.available_width(), E_STOP);
    let stop = ui.vertical_centered(|ui| ui.add_enabled(!replay, button.min_size(size))).inner;
    if stop.on_hover_text(Action::EStop.binding().words).clicked() {
        app.act(Action::EStop);
    }
    ui.add_space(2.0);
}

fn show_session(ui: &mut egui::Ui, app: &mut App) {
    if app.playback().is_some() {
        return;
    }
    let recording = app.frame.as_ref().is_some_and(|frame| frame.recording);
    let half = (ui.available_width() - ui.spacing().item_spacing.x) / 2.0;
    ui.add_enabled_ui(app.frame.is_some() && app.mode() != Mode::Disconnected, |ui| {
        ui.horizontal(|ui| {
            button(ui, app, Action::Rearm, "Re-arm", half);
            button(ui, app, Action::Tare, "Tare", half);
        });
        ui.horizontal(|ui| {
            button(ui, app, Action::Record, if recording { "End recording" } else { "Record" }, half);
            let held = app.mode() == Mode::Frozen;
            button(ui, app, Action::Freeze, if held { "Go on" } else { "Freeze" }, half);
        });
    });
}

fn show_colours(ui: &mut egui::Ui, app: &mut App) {
    let mut by = app.settings.colour_by;
    ui.horizontal(|ui| {
        for choice in ColourBy::ALL {
            ui.selectable_value(&mut by, choice, choice.name());
        }
    });
    if by != app.settings.colour_by {
        (app.settings.colour_by, app.settings.colour_end) = (by, None);
    }
    let Some(end) = app.scene.colour_end() else { return };
    let mut fixed = app.settings.colour_end.is_some();
    let quantity = if by == ColourBy::Pressure { Quantity::Pressure } else { Quantity::Length };
    if ui.checkbox(&mut fixed, format!("keep the scale at {}", quantity.words_round(end))).changed() {
        app.settings.colour_end = fixed.then_some(end);
    }
    button(ui, app, Action::Rescale, "Scales anew", 0.0);
}

fn show_signs(ui: &mut egui::Ui, app: &mut App) {
    ui.horizontal(|ui| {
        button(ui, app, Action::Shorter, "Shorter", 0.0);
        button(ui, app, Action::Longer, "Longer", 0.0);
    });
    let words = format!("force of each region ({})", Action::RegionForces.key());
    ui.checkbox(&mut app.settings.region_forces, words).on_hover_text(Action::RegionForces.binding().words);
    ui.horizontal(|ui| {
        ui.label(format!("probe ({})", Action::Probe.key()));
        ui.spacing_mut().slider_width = 90.0;
        let opacity = egui::Slider::new(&mut app.settings.probe_opacity, 0.0..=1.0);
        ui.add(opacity.custom_formatter(|share, _| format!("{:.0} %", 100.0 * share)));
    });
}

fn show_views(ui: &mut egui::Ui, app: &mut App) {
    ui.horizontal(|ui| {
        button(ui, app, Action::Reset, "Whole", 0.0);
        button(ui, app, Action::Contact, "Contact", 0.0);
    });
    ui.horizontal(|ui| {
        button(ui, app, Action::Front, "Front", 0.0);
        button(ui, app, Action::Side, "Side", 0.0);
        button(ui, app, Action::Top, "Top", 0.0);
    });
}

/// A line a region, oldest first.
fn show_regions(ui: &mut egui::Ui, app: &App) {
    let regions: &[Region] = app.frame.as_ref().map_or(&[], |frame| &frame.regions);
    if regions.is_empty() {
        ui.label(faint("no contact"));
        return;
    }
    Grid::new("regions").num_columns(4).spacing(vec2(8.0, 2.0)).show(ui, |ui| {
        for title in ["", "force [N]", "radius [mm]", "stick [%]"] {
            ui.label(faint(title).small());
        }
        ui.end_row();
        for (number, region) in regions.iter().enumerate() {
            let stuck = if region.radius > 0.0 { (region.stick_radius / region.radius).powi(2) } else { 1.0 };
            ui.label(faint((number + 1).to_string()));
            ui.monospace(format!("{:>6.2}", region.force.length()));
            ui.monospace(format!("{:>6.2}", 1.0e3 * region.radius));
            ui.monospace(format!("{:>4.0}", 100.0 * stuck));
            ui.end_row();
        }
    });
}

/// What happened, newest first.
fn show_events(ui: &mut egui::Ui, app: &App) {
    if app.events.is_empty() {
        ui.label(faint("none"));
    }
    for event in app.events.iter().rev().take(EVENTS) {
        let colour = match event.severity {
            Severity::Info => style::FAINT,
            Severity::Warning => style::WARNING,
            Severity::Fault => Color32::from_rgb(255, 120, 110),
        };
        ui.label(RichText::new(format!("{:.2} s  {}", event.time, event.words)).small().color(colour));
    }
}
