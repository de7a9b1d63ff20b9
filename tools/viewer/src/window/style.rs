//! Colours and letters of the panels: dark, readable, none that only a healthy eye tells apart.

use eframe::egui::{self, Color32, CornerRadius, FontId, RichText, Stroke, TextStyle};

/// Curves of x, y, z: vermilion, bluish green, sky blue of Okabe and Ito.
pub const AXES: [Color32; 3] =
    [Color32::from_rgb(230, 110, 40), Color32::from_rgb(30, 185, 140), Color32::from_rgb(86, 180, 233)];

/// A curve without direction.
pub const NORM: Color32 = Color32::from_rgb(236, 238, 242);

/// Words beside figures.
pub const FAINT: Color32 = Color32::from_rgb(160, 167, 178);

/// Something is wrong.
pub const BAD: Color32 = Color32::from_rgb(196, 40, 40);

/// Something needs a look.
pub const WARNING: Color32 = Color32::from_rgb(240, 190, 70);

/// All is well.
pub const GOOD: Color32 = Color32::from_rgb(60, 180, 140);

/// The background of panels.
const PANEL: Color32 = Color32::from_rgb(30, 33, 39);

/// The background of plots and fields.
const DEEP: Color32 = Color32::from_rgb(20, 22, 27);

/// Sets the look of a context.
pub fn apply(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = DEEP;
        visuals.override_text_color = Some(Color32::from_rgb(226, 229, 234));
        visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(52, 57, 66));
        for widget in [&mut visuals.widgets.inactive, &mut visuals.widgets.hovered, &mut visuals.widgets.active] {
            widget.corner_radius = CornerRadius::same(4);
        }
        visuals.widgets.inactive.weak_bg_fill = Color32::from_rgb(52, 57, 66);
        visuals.widgets.hovered.weak_bg_fill = Color32::from_rgb(68, 75, 87);
        style.spacing.item_spacing = egui::vec2(6.0, 5.0);
        style.text_styles.insert(TextStyle::Body, FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Button, FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(12.5));
        style.text_styles.insert(TextStyle::Small, FontId::proportional(11.5));
    });
}

/// A word beside a figure.
pub fn faint(words: impl Into<String>) -> RichText {
    RichText::new(words).color(FAINT)
}
