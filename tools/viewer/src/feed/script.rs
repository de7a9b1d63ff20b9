//! A session from a list of moments: what a table of poses, a test or a demonstration shows.

use std::sync::Arc;
use std::time::Duration;

use super::{Command, Event, Frame, Mode, News, Playback, Sample, Severity, Source, Stage};

/// Moments to be shown one after the other, at their own times. As a session they repeat without end; as a recording they can be held,
/// wound and played at another speed.
#[derive(Clone, Debug)]
pub struct Script {
    stage: Arc<Stage>,
    frames: Vec<Frame>,
    /// Length of the list \[s\]: from the first frame to one period behind the last.
    length: f64,
    is_recording: bool,
    /// Time shown, from the first frame \[s\].
    at: f64,
    /// The call before this one.
    before: Option<Duration>,
    playing: bool,
    speed: f64,
    braked: bool,
    /// The frame that is held.
    frozen: Option<usize>,
    writes: bool,
    /// Seconds shown in earlier rounds.
    rounds: f64,
    told: bool,
    shown: Option<usize>,
    events: Vec<Event>,
}

impl Script {
    /// A session that runs through `frames`, in the order of time, again and again.
    pub fn session(stage: Stage, frames: Vec<Frame>) -> Self {
        let span = frames.first().zip(frames.last()).map_or(0.0, |(first, last)| last.time - first.time);
        Self {
            length: span + stage.period,
            stage: Arc::new(stage),
            frames,
            is_recording: false,
            at: 0.0,
            before: None,
            playing: true,
            speed: 1.0,
            braked: false,
            frozen: None,
            writes: false,
            rounds: 0.0,
            told: false,
            shown: None,
            events: Vec::new(),
        }
    }

    /// The same as a recording, held at its begin.
    pub fn recording(stage: Stage, frames: Vec<Frame>) -> Self {
        Self { is_recording: true, playing: false, ..Self::session(stage, frames) }
    }

    /// Number of the frame shown at a time from the begin.
    fn index(&self, at: f64) -> Option<usize> {
        let start = self.frames.first()?.time;
        Some(self.frames.partition_point(|frame| frame.time - start <= at).saturating_sub(1))
    }

    fn mode(&self) -> Mode {
        match (self.is_recording, self.braked, self.frozen.is_some()) {
            (true, ..) => {
                let end = self.length - self.stage.period;
                Mode::Replaying(Playback { at: self.at.min(end), end, playing: self.playing, speed: self.speed })
            }
            (false, true, _) => Mode::Braked,
            (false, false, true) => Mode::Frozen,
            (false, false, false) => Mode::Running,
        }
    }

    /// Moves the time on; a session begins again at its end, a recording stops there.
    fn advance(&mut self, now: Duration) -> Vec<Sample> {
        let elapsed = self.before.replace(now).map_or(0.0, |before| now.saturating_sub(before).as_secs_f64());
        if !self.playing || self.frames.is_empty() {
            return self.sample_shown();
        }
        let from = self.shown.map_or(0, |shown| shown + 1);
        self.at += elapsed * self.speed;
        let mut samples = Vec::new();
        if self.at >= self.length && self.is_recording {
            (self.at, self.playing) = (self.length - self.stage.period, false);
        } else if self.at >= self.length {
            samples.extend(self.frames[from..].iter().map(|frame| self.sample(frame)));
            self.rounds += self.length * (self.at / self.length).floor();
            self.at %= self.length;
            self.shown = None;
        }
        let from = self.shown.map_or(0, |shown| shown + 1);
        self.shown = self.index(self.at);
        let to = self.shown.map_or(0, |shown| shown + 1);
        samples.extend(self.frames.get(from..to).unwrap_or_default().iter().map(|frame| self.sample(frame)));
        samples
    }

    /// After a winding: the plots show all that led to the moment.
    fn sample_shown(&mut self) -> Vec<Sample> {
        let index = self.index(self.at);
        if index == self.shown {
            return Vec::new();
        }
        self.shown = index;
        let to = index.map_or(0, |index| index + 1);
        self.frames[..to].iter().map(|frame| self.sample(frame)).collect()
    }

    fn sample(&self, frame: &Frame) -> Sample {
        let start = self.frames.first().map_or(0.0, |first| first.time);
        Sample {
            time: frame.time - start + self.rounds,
            force: frame.contact.force,
            torque: frame.contact.torque,
            depth: frame.depth,
            step_us: frame.timing.map_or(f64::NAN, |timing| timing.step_us),
        }
    }

    fn tell(&mut self, severity: Severity, words: &str) {
        self.events.push(Event { time: self.rounds + self.at, severity, words: words.to_owned() });
    }

    fn send_to_recording(&mut self, command: Command) {
        match command {
            Command::Seek(at) if at.is_finite() => self.at = at.clamp(0.0, self.length - self.stage.period),
            Command::Play(playing) => {
                // at the end, play begins again
                if playing && self.at >= self.length - self.stage.period {
                    (self.at, self.shown) = (0.0, None);
                }
                self.playing = playing;
            }
            Command::Speed(speed) if speed.is_finite() && speed > 0.0 => self.speed = speed,
            _ => {}
        }
    }

    fn send_to_session(&mut self, command: Command) {
        match command {
            Command::Record(on) if on != self.writes => {
                self.writes = on;
                self.tell(Severity::Info, if on { "recording" } else { "recording ended" });
            }
            Command::Freeze(on) => self.frozen = if on { self.shown } else { None },
            Command::Tare => self.tell(Severity::Info, "probe placed where the scene starts it"),
            Command::EStop => {
                self.braked = true;
                self.tell(Severity::Fault, "e-stop: the device brakes");
            }
            Command::Rearm if self.braked => {
                self.braked = false;
                self.tell(Severity::Info, "re-armed");
            }
            _ => {}
        }
    }
}

impl Source for Script {
    fn poll(&mut self, now: Duration) -> News {
        let stage = (!std::mem::replace(&mut self.told, true)).then(|| Arc::clone(&self.stage));
        let samples = self.advance(now);
        let mut frame = self.frozen.or(self.shown).map(|index| self.frames[index].clone());
        if let Some(frame) = &mut frame {
            frame.mode = self.mode();
            frame.recording = self.writes;
            frame.time = self.sample(frame).time;
            if self.braked {
                frame.sent = None;
            }
        }
        News { stage, frame: frame.map(Arc::new), samples, events: std::mem::take(&mut self.events) }
    }

    fn send(&mut self, command: Command) {
        if self.is_recording { self.send_to_recording(command) } else { self.send_to_session(command) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames() -> Vec<Frame> {
        (0..10).map(|k| Frame { tick: k, time: 5.0 + k as f64 * 0.1, depth: k as f64, ..Frame::default() }).collect()
    }

    fn stage() -> Stage {
        Stage { period: 0.1, ..Stage::default() }
    }

    fn seconds(now: f64) -> Duration {
        Duration::from_secs_f64(now)
    }

    #[test]
    fn a_session_repeats_and_its_time_goes_on() {
        let mut script = Script::session(stage(), frames());
        let first = script.poll(seconds(0.0));
        assert!(first.stage.is_some() && first.frame.unwrap().tick == 0);
        assert_eq!(script.poll(seconds(0.35)).samples.len(), 3);
        let news = script.poll(seconds(1.25));
        assert!(news.stage.is_none());
        assert_eq!(news.frame.unwrap().tick, 2);
        let times: Vec<i32> = news.samples.iter().map(|sample| (sample.time * 10.0).round() as i32).collect();
        assert_eq!(times, (4..13).collect::<Vec<_>>());
    }

    #[test]
    fn a_session_brakes_freezes_and_records() {
        let mut script = Script::session(stage(), frames());
        script.poll(seconds(0.0));
        script.send(Command::Record(true));
        script.send(Command::Freeze(true));
        let held = script.poll(seconds(0.5));
        let frame = held.frame.unwrap();
        assert_eq!((frame.mode, frame.tick, frame.recording, held.samples.len()), (Mode::Frozen, 0, true, 5));
        script.send(Command::EStop);
        let news = script.poll(seconds(0.5));
        assert_eq!((news.frame.unwrap().mode, news.events[0].severity), (Mode::Braked, Severity::Fault));
        for command in [Command::Rearm, Command::Freeze(false), Command::Seek(0.1)] {
            script.send(command);
        }
        assert_eq!(script.poll(seconds(0.55)).frame.unwrap().mode, Mode::Running);
    }

    #[test]
    fn a_recording_is_wound_held_and_ends() {
        let mut script = Script::recording(stage(), frames());
        script.poll(seconds(0.0));
        script.send(Command::Seek(0.45));
        let news = script.poll(seconds(9.0));
        assert_eq!((news.frame.unwrap().tick, news.samples.len()), (4, 5), "held, and the plots show what led there");
        for command in [Command::Seek(f64::NAN), Command::Speed(-1.0), Command::Speed(2.0), Command::Play(true)] {
            script.send(command);
        }
        assert_eq!(script.poll(seconds(9.1)).frame.unwrap().tick, 6);
        let Mode::Replaying(end) = script.poll(seconds(20.0)).frame.unwrap().mode else { panic!("no recording") };
        assert!(!end.playing && end.speed == 2.0 && (end.at - 0.9).abs() < 1e-9 && (end.end - 0.9).abs() < 1e-9);
        script.send(Command::Play(true));
        assert_eq!(script.poll(seconds(20.0)).frame.unwrap().tick, 0, "play at the end begins again");
    }

    #[test]
    fn an_empty_script_shows_its_stage_alone() {
        for mut script in [Script::session(stage(), Vec::new()), Script::recording(stage(), Vec::new())] {
            for command in [Command::Seek(1.0), Command::Play(true), Command::Freeze(true)] {
                script.send(command);
            }
            let news = script.poll(seconds(1.0));
            assert!(news.stage.is_some() && news.frame.is_none() && news.samples.is_empty());
        }
    }
}
