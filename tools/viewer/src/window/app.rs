//! What the window knows, and what it does with news and with what a person asks for.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui;

use super::keys::{self, Action};
use super::scene::{Aim, Scene};
use super::{controls, help, playback, plots, state, style};
use crate::feed::{Command, Event, Frame, History, Mode, Playback, Source};
use crate::picture::{ColourBy, Settings};

/// Events kept: more than a person reads back.
const EVENTS: usize = 200;

/// Pictures a second at most: more is seen by nobody, and the processor may be the one that ticks.
const PERIOD: Duration = Duration::from_millis(16);

/// Lengths of the plots \[s\].
pub const SPANS: [f64; 4] = [1.0, 5.0, 20.0, 60.0];

/// Speeds a recording can be played at.
const SPEEDS: std::ops::RangeInclusive<f64> = 1.0 / 64.0..=16.0;

/// What the window knows.
pub struct App {
    source: Box<dyn Source>,
    /// What is drawn.
    pub scene: Scene,
    /// The newest moment.
    pub frame: Option<Arc<Frame>>,
    /// The last ticks.
    pub history: History,
    /// What happened, newest last.
    pub events: VecDeque<Event>,
    /// What colours and arrows say.
    pub settings: Settings,
    /// Length of the plots \[s\].
    pub span: f64,
    /// The list of keys is shown.
    pub help: bool,
}

impl App {
    /// A window on a source.
    pub fn new(source: Box<dyn Source>) -> Self {
        Self {
            source,
            scene: Scene::default(),
            frame: None,
            history: History::default(),
            events: VecDeque::new(),
            settings: Settings::default(),
            span: SPANS[1],
            help: false,
        }
    }

    /// One picture: takes news, obeys keys, shows everything. `now` is the time since the window opened.
    pub fn show(&mut self, ui: &mut egui::Ui, now: Duration) {
        self.take_news(now);
        for action in keys::pressed(ui.ctx(), self.playback().is_some()) {
            self.act(action);
        }
        // also of an old moment: settings may have changed
        if let Some(frame) = &self.frame {
            self.scene.build(frame, &self.settings);
        }
        egui::Panel::top("state").show(ui, |ui| state::show(ui, self));
        if self.playback().is_some() {
            egui::Panel::bottom("playback").show(ui, |ui| playback::show(ui, self));
        }
        egui::Panel::left("controls").exact_size(controls::WIDTH).resizable(false).show(ui, |ui| controls::show(ui, self));
        egui::Panel::right("plots").default_size(plots::WIDTH).size_range(plots::WIDTHS).show(ui, |ui| plots::show(ui, self));
        egui::CentralPanel::no_frame().show(ui, |ui| self.scene.show(ui, self.frame.as_deref()));
        help::show(ui.ctx(), &mut self.help);
    }

    fn take_news(&mut self, now: Duration) {
        let news = self.source.poll(now);
        if let Some(stage) = news.stage {
            self.scene.set_stage(stage);
            self.history.clear();
            self.frame = None;
        }
        if news.frame.is_some() {
            self.frame = news.frame;
        }
        news.samples.into_iter().for_each(|sample| self.history.push(sample));
        self.events.extend(news.events);
        self.events.drain(..self.events.len().saturating_sub(EVENTS));
    }

    /// Where the playing stands, with a recording.
    pub fn playback(&self) -> Option<Playback> {
        match self.frame.as_ref()?.mode {
            Mode::Replaying(playback) => Some(playback),
            _ => None,
        }
    }

    /// What the session is doing.
    pub fn mode(&self) -> Mode {
        self.frame.as_ref().map_or(Mode::Disconnected, |frame| frame.mode)
    }

    /// Asks the source for something.
    pub fn send(&mut self, command: Command) {
        self.source.send(command);
    }

    /// Does what a key or a button asks for.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::EStop => self.send(Command::EStop),
            Action::Rearm => self.send(Command::Rearm),
            Action::Record => self.send(Command::Record(!self.frame.as_ref().is_some_and(|frame| frame.recording))),
            Action::Freeze => self.send(Command::Freeze(self.mode() != Mode::Frozen)),
            Action::Tare => self.send(Command::Tare),
            Action::Colours => self.next_colours(),
            Action::RegionForces => self.settings.region_forces = !self.settings.region_forces,
            Action::Longer => self.settings.longer = (self.settings.longer + 1).min(LONGEST),
            Action::Shorter => self.settings.longer = (self.settings.longer - 1).max(-LONGEST),
            Action::Rescale => self.rescale(),
            Action::Probe => self.next_probe(),
            Action::Reset => self.scene.aim(Aim::Usual),
            Action::Contact => self.scene.aim(Aim::Contact),
            Action::Front => self.scene.aim(Aim::Front),
            Action::Side => self.scene.aim(Aim::Side),
            Action::Top => self.scene.aim(Aim::Top),
            Action::Help => self.help = !self.help,
            Action::Play | Action::Back | Action::On | Action::Slower | Action::Faster => self.wind(action),
        }
    }

    /// Steps through a recording.
    fn wind(&mut self, action: Action) {
        let Some(playback) = self.playback() else { return };
        let tick = self.scene.stage().map_or(0.0, |stage| stage.period);
        let speed = |factor: f64| Command::Speed((playback.speed * factor).clamp(*SPEEDS.start(), *SPEEDS.end()));
        // half a tick more: times of ticks are not exact
        self.send(match action {
            Action::Play => Command::Play(!playback.playing),
            Action::Back => Command::Seek(playback.at - 0.5 * tick),
            Action::On => Command::Seek(playback.at + 1.5 * tick),
            Action::Slower => speed(0.5),
            _ => speed(2.0),
        });
    }

    fn next_colours(&mut self) {
        let all = ColourBy::ALL;
        let at = all.iter().position(|&by| by == self.settings.colour_by).unwrap_or(0);
        self.settings.colour_by = all[(at + 1) % all.len()];
        self.settings.colour_end = None;
    }

    fn next_probe(&mut self) {
        let usual = Settings::default().probe_opacity;
        self.settings.probe_opacity = match self.settings.probe_opacity {
            opacity if opacity >= 1.0 => 0.0,
            0.0 => usual,
            _ => 1.0,
        };
    }

    fn rescale(&mut self) {
        self.settings.colour_end = None;
        self.settings.longer = 0;
        self.scene.forget_peaks();
    }
}

/// Steps by which arrows can be made longer or shorter: a factor of a thousand.
const LONGEST: i32 = 9;

/// An app in a window of the system.
pub struct Host {
    app: App,
    opened: Instant,
}

impl Host {
    /// Sets the look.
    pub fn new(app: App, creation: &eframe::CreationContext<'_>) -> Self {
        style::apply(&creation.egui_ctx);
        Self { app, opened: Instant::now() }
    }
}

impl eframe::App for Host {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.app.show(ui, self.opened.elapsed());
        ui.ctx().request_repaint_after(PERIOD);
    }

    fn on_exit(&mut self, gl: Option<&eframe::glow::Context>) {
        if let Some(gl) = gl {
            self.app.scene.destroy(gl);
        }
    }
}
