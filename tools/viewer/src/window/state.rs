//! The line at the top: what the session is doing, and what is wrong with it.

use eframe::egui::{self, Align, Color32, CornerRadius, Layout, Margin, RichText};

use super::app::App;
use super::keys::Action;
use super::style::{self, faint};
use crate::feed::{Fault, Frame, Mode, Stage, Timing};

/// Share of ticks in time below which a session is to be looked at, and below which it is no good (libfranka's marks).
const IN_TIME: (f64, f64) = (0.95, 0.90);

/// Shows the line; with a fault a second one below.
pub fn show(ui: &mut egui::Ui, app: &mut App) {
    let frame = app.frame.clone();
    let stage = app.scene.stage();
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        // from the right first: whatever is long on the left is cut, the button is not
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.button(format!("Help ({})", Action::Help.key())).clicked() {
                app.help = !app.help;
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                show_mode(ui, app.mode());
                if let (Some(frame), Some(stage)) = (&frame, &stage) {
                    if frame.recording {
                        badge(ui, "REC", style::BAD);
                    }
                    ui.label(RichText::new(&stage.name).strong());
                    show_figures(ui, frame, stage);
                }
            });
        });
    });
    ui.add_space(1.0);
    if let Some(fault) = frame.as_ref().and_then(|frame| frame.fault.as_ref()) {
        show_fault(ui, fault);
    }
}

fn badge(ui: &mut egui::Ui, words: &str, colour: Color32) {
    let frame = egui::Frame::new().fill(colour).corner_radius(CornerRadius::same(4)).inner_margin(Margin::symmetric(8, 2));
    frame.show(ui, |ui| ui.label(RichText::new(words).strong().color(Color32::WHITE)));
}

fn show_mode(ui: &mut egui::Ui, mode: Mode) {
    let (words, colour) = match mode {
        Mode::Disconnected => ("DISCONNECTED", Color32::from_rgb(96, 102, 112)),
        Mode::Running => ("RUNNING", Color32::from_rgb(20, 120, 90)),
        Mode::Frozen => ("FROZEN", Color32::from_rgb(0, 98, 156)),
        Mode::Braked => ("BRAKED", Color32::from_rgb(176, 98, 0)),
        Mode::Replaying(playback) if playback.playing => ("REPLAY", Color32::from_rgb(112, 62, 150)),
        Mode::Replaying(_) => ("REPLAY, HELD", Color32::from_rgb(112, 62, 150)),
    };
    badge(ui, words, colour);
}

/// A figure with what it is.
fn figure(ui: &mut egui::Ui, name: &str, value: String) -> egui::Response {
    ui.label(faint(name));
    let shown = ui.label(RichText::new(value).monospace());
    ui.add_space(5.0);
    shown
}

fn show_figures(ui: &mut egui::Ui, frame: &Frame, stage: &Stage) {
    ui.add_space(5.0);
    figure(ui, "tick", format!("{:>6}", frame.tick));
    figure(ui, "time", format!("{:>7.2} s", frame.time));
    if stage.period > 0.0 {
        figure(ui, "rate", format!("{:.0} Hz", 1.0 / stage.period)).on_hover_text("ticks a second, as set");
    }
    if let Some(Timing { step_us, wake_us, in_time }) = frame.timing {
        let colour = match in_time {
            share if share < IN_TIME.1 => Color32::from_rgb(255, 120, 110),
            share if share < IN_TIME.0 => style::WARNING,
            _ => style::GOOD,
        };
        ui.label(faint("in time"));
        let shown = ui.label(RichText::new(format!("{:.2} %", 100.0 * in_time)).monospace().color(colour));
        shown.on_hover_text("share of the ticks whose wrench left within their period; 95 % and more is good");
        ui.add_space(5.0);
        figure(ui, "step", format!("{step_us:>4.0} \u{b5}s")).on_hover_text("what the last step of the core took");
        figure(ui, "woke", format!("{wake_us:>4.0} \u{b5}s")).on_hover_text("how late the thread woke for the last tick");
    }
    figure(ui, "tier", frame.tier.clone());
    match frame.flags.as_slice() {
        [] => ui.label(faint("no flags")),
        flags => ui.add(egui::Label::new(RichText::new(flags.join(", ")).color(style::WARNING)).truncate()),
    };
}

/// The fault and what to do about it.
fn show_fault(ui: &mut egui::Ui, fault: &Fault) {
    let frame = egui::Frame::new().fill(style::BAD).corner_radius(CornerRadius::same(4)).inner_margin(Margin::symmetric(10, 5));
    frame.show(ui, |ui| {
        ui.set_width(ui.available_width());
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new(format!("FAULT: {}.", fault.what)).strong().color(Color32::WHITE));
            ui.label(RichText::new(&fault.advice).color(Color32::WHITE));
        });
    });
    ui.add_space(3.0);
}
