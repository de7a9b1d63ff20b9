//! A recording as a source of pictures: played, held, wound; every moment computed again as it was felt.

use std::sync::Arc;
use std::time::Duration;

use haptor_contact::{PatchReport, Vec3};
use haptor_viewer::feed::{
    self, Command, Displacement, Event, Frame, Mode, News, Pose, Sample, Severity, Source, Stage, Timing, Wrench,
};
use haptor_wire::TickRecord;

use super::stage;
use super::words::{fault, flag_words, rotation, wide};
use crate::failure::Failure;
use crate::session::recording::{Happening, Recording};
use crate::session::replay::{Moment, Player, stick_radius};

/// Ticks of the plots that come with a jump: what a person sees of the past \[ticks\].
const PAST: usize = 10_000;

/// A recording to look at.
#[derive(Debug)]
pub struct Replay {
    player: Player,
    /// One for each scene; `None` where it is not whole.
    stages: Vec<Option<Look>>,
    /// Time shown, from the first tick \[s\].
    at: f64,
    before: Option<Duration>,
    playing: bool,
    speed: f64,
    shown: Option<Shown>,
}

/// A scene to look at.
#[derive(Debug)]
struct Look {
    stage: Arc<Stage>,
    /// The object's vertices at rest \[m\].
    rest: Vec<Vec3>,
}

/// What the window shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shown {
    tick: usize,
    scene: Option<usize>,
}

impl Replay {
    /// Computes a recording called `name` once; `at` hears how many ticks are done.
    ///
    /// # Errors
    /// [`Failure::Problem`] when it holds no tick, or no scene that is whole.
    pub fn new(recording: Recording, name: &str, at: impl FnMut(usize)) -> Result<Self, Failure> {
        if recording.ticks.is_empty() {
            return Err(Failure::problem(format!("{name}: holds no tick to look at")));
        }
        let stages = recording.scenes.iter().zip(&recording.skins).map(|((header, scene), skins)| {
            let scene = scene.as_ref().ok()?;
            let stage = stage(scene, skins, name, header.rate_hz).ok()?;
            let rest = stage.object.vertices.iter().map(|v| v.as_vec3()).collect();
            Some(Look { stage: Arc::new(stage), rest })
        });
        let stages: Vec<_> = stages.collect();
        if stages.iter().all(Option::is_none) {
            return Err(Failure::problem(format!("{name}: carries no whole scene; `haptor export` still gives its ticks")));
        }
        let player = Player::new(recording, at);
        Ok(Self { player, stages, at: 0.0, before: None, playing: false, speed: 1.0, shown: None })
    }

    fn ticks(&self) -> &[TickRecord] {
        &self.player.recording().ticks
    }

    /// Time of a tick, from the first \[s\].
    fn time(&self, tick: &TickRecord) -> f64 {
        let first = self.ticks().first().map_or(0, |tick| tick.t_us);
        tick.t_us.saturating_sub(first) as f64 / 1.0e6
    }

    fn end(&self) -> f64 {
        self.ticks().last().map_or(0.0, |tick| self.time(tick))
    }

    fn move_on(&mut self, now: Duration) {
        let passed = self.before.replace(now).map_or(0.0, |before| now.saturating_sub(before).as_secs_f64());
        if self.playing {
            self.at += passed * self.speed;
        }
        let end = self.end();
        if self.at >= end {
            (self.at, self.playing) = (end, false);
        }
    }

    /// The tick at the time shown, and the scene that it is of.
    fn place(&self) -> Shown {
        let tick = self.ticks().partition_point(|tick| self.time(tick) <= self.at).saturating_sub(1);
        let begun = |(before, what): &(usize, Happening)| match what {
            Happening::Scene(scene) if *before <= tick => Some(*scene),
            _ => None,
        };
        Shown { tick, scene: self.player.recording().happened.iter().filter_map(begun).next_back() }
    }

    fn frame(&mut self, place: Shown) -> Frame {
        let mode = Mode::Replaying(feed::Playback { at: self.at, end: self.end(), playing: self.playing, speed: self.speed });
        let record = self.ticks()[place.tick];
        let mut frame = Frame { mode, ..frame(&record, self.time(&record)) };
        let Some(moment) = self.player.at(place.tick) else { return frame };
        see(&mut frame, &moment);
        if let Some(look) = place.scene.and_then(|scene| self.stages[scene].as_ref()) {
            let mut moved = vec![Vec3::ZERO; look.rest.len()];
            self.player.displacement(&look.rest, &mut moved);
            frame.displacement = Some(Displacement { tick: record.tick, moved: moved.into() });
        }
        frame
    }

    /// Ticks for the plots: those that were passed, or after a jump what came before.
    fn samples(&self, from: Option<usize>, to: usize) -> Vec<Sample> {
        let first =
            from.filter(|&from| from <= to).map_or(to.saturating_sub(PAST), |from| (from + 1).max(to.saturating_sub(PAST)));
        self.ticks()[first..=to].iter().map(|tick| sample(tick, self.time(tick))).collect()
    }

    /// What happened on the way from one tick to a later one.
    fn events(&self, from: Option<usize>, to: usize) -> Vec<Event> {
        let passed = |before: usize| before <= to && from.is_none_or(|from| before > from);
        let happened = self.player.recording().happened.iter().filter(|(before, _)| passed(*before));
        happened.filter_map(|(before, what)| self.event(*before, what)).collect()
    }

    fn event(&self, before: usize, what: &Happening) -> Option<Event> {
        let time = self.ticks().get(before).map_or(0.0, |tick| self.time(tick));
        let (severity, words) = match what {
            Happening::Done(what) => (Severity::Info, what.name().to_owned()),
            Happening::Tuned(tuning) => {
                (Severity::Info, format!("tuned: tier {}, {} samples", tuning.tier.name(), tuning.samples))
            }
            Happening::Fault(record) => (Severity::Fault, fault(record.cause).what),
            Happening::Lost(count) => (Severity::Warning, format!("{count} records were lost here")),
            Happening::Damaged(damage) => (Severity::Warning, damage.to_string()),
            Happening::Scene(_) | Happening::Device(_) | Happening::Placed(_) | Happening::Rested => return None,
        };
        Some(Event { time, severity, words })
    }
}

impl Source for Replay {
    fn poll(&mut self, now: Duration) -> News {
        self.move_on(now);
        let (before, place) = (self.shown, self.place());
        let frame = Some(Arc::new(self.frame(place)));
        if before == Some(place) {
            // the time shown moves between two ticks
            return News { frame, ..News::default() };
        }
        self.shown = Some(place);
        let from = before.map(|shown| shown.tick);
        let other_scene = before.is_none_or(|shown| shown.scene != place.scene);
        let look = place.scene.filter(|_| other_scene).and_then(|scene| self.stages[scene].as_ref());
        News {
            stage: look.map(|look| Arc::clone(&look.stage)),
            frame,
            samples: self.samples(from.filter(|_| !other_scene), place.tick),
            events: self.events(from.filter(|&from| from <= place.tick), place.tick),
        }
    }

    fn send(&mut self, command: Command) {
        match command {
            Command::Seek(at) if at.is_finite() => self.at = at.clamp(0.0, self.end()),
            Command::Play(playing) => {
                if playing && self.at >= self.end() {
                    self.at = 0.0;
                }
                self.playing = playing;
            }
            Command::Speed(speed) if speed > 0.0 && speed.is_finite() => self.speed = speed,
            _ => {}
        }
    }
}

/// A record as a frame, before anything is computed.
fn frame(record: &TickRecord, time: f64) -> Frame {
    Frame {
        tick: record.tick,
        time,
        contact: Wrench { force: wide(record.contact_force), torque: wide(record.contact_torque) },
        depth: record.depth.into(),
        tier: record.tier.name().to_owned(),
        flags: flag_words(record.flags),
        timing: Some(Timing {
            step_us: f64::from(record.step_ns) / 1.0e3,
            wake_us: f64::from(record.wake_ns) / 1.0e3,
            in_time: f64::from(u8::from(record.flags & haptor_wire::flags::LATE == 0)),
        }),
        ..Frame::default()
    }
}

/// Adds what was computed again.
fn see(frame: &mut Frame, moment: &Moment) {
    if let Some(pose) = &moment.pose {
        let [x, y, z, w] = pose.rotation.to_array();
        frame.probe = Pose { position: wide(pose.position.to_array()), rotation: rotation([w, x, y, z]) };
    }
    frame.regions = moment.patches.iter().map(region).collect();
}

/// A patch as a window shows it.
fn region(patch: &PatchReport) -> feed::Region {
    feed::Region {
        centre: wide(patch.centre.to_array()),
        normal: wide(patch.normal.to_array()),
        radius: patch.radius.into(),
        stick_radius: stick_radius(patch).into(),
        force: wide(patch.force.to_array()),
        torque: wide(patch.torque.to_array()),
        pressure: None,
    }
}

fn sample(record: &TickRecord, time: f64) -> Sample {
    Sample {
        time,
        force: wide(record.contact_force),
        torque: wide(record.contact_torque),
        depth: record.depth.into(),
        step_us: f64::from(record.step_ns) / 1.0e3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    use crate::command::bake::bake;
    use crate::scene::Scene;
    use crate::session::offline;
    use crate::trajectory;

    /// The ball on the cube, pressed, twisted, slid.
    fn replay() -> Replay {
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/scenes");
        let folder = tempfile::tempdir().unwrap();
        let (model, file) = (folder.path().join("model"), folder.path().join("recording"));
        bake(&Scene::load(&scenes.join("cube-twist.toml")).unwrap(), "scene", &model).unwrap();
        let rows = trajectory::load(&scenes.join("cube-twist.csv")).unwrap();
        std::fs::write(&file, offline::record(&std::fs::read(&model).unwrap(), &rows, 1000).unwrap()).unwrap();
        Replay::new(Recording::read(&file).unwrap(), "test", |_| {}).unwrap()
    }

    #[test]
    fn a_recording_is_held_wound_and_played() {
        let mut replay = replay();
        let news = replay.poll(Duration::ZERO);
        assert!(news.stage.is_some() && news.samples.len() == 1);
        assert_eq!(news.frame.unwrap().time, 0.0);

        replay.send(Command::Seek(0.6));
        let news = replay.poll(Duration::from_millis(20));
        let frame = news.frame.unwrap();
        assert!(news.stage.is_none() && (frame.time - 0.6).abs() < 2.0e-3, "{}", frame.time);
        assert!(frame.regions.len() == 1 && frame.contact.force.z > 10.0);
        let deepest = frame.displacement.as_ref().unwrap().moved.iter().fold(0.0_f32, |most, u| most.max(u.length()));
        assert!((5.0e-4..2.0e-3).contains(&deepest), "{deepest}");
        let until = |replay: &Replay, at: f64| replay.ticks().iter().filter(|tick| replay.time(tick) <= at).count();
        assert_eq!(news.samples.len(), until(&replay, 0.6) - 1);

        // a jump back brings the past of where it lands
        replay.send(Command::Seek(0.1));
        let news = replay.poll(Duration::from_millis(40));
        assert_eq!(news.samples.len(), until(&replay, 0.1));
        assert!(news.frame.unwrap().time <= 0.1);

        replay.send(Command::Speed(2.0));
        replay.send(Command::Play(true));
        let news = replay.poll(Duration::from_millis(90));
        let frame = news.frame.unwrap();
        assert!((frame.time - 0.2).abs() < 5.0e-3, "{}", frame.time);
        assert!(matches!(frame.mode, Mode::Replaying(playback) if playback.playing && playback.speed == 2.0));
        assert_eq!(news.samples.len(), until(&replay, frame.time) - until(&replay, 0.1));

        // it stops at its end
        let frame = replay.poll(Duration::from_secs(60)).frame.unwrap();
        assert!(matches!(frame.mode, Mode::Replaying(playback) if !playback.playing && playback.at == playback.end));
    }
}
