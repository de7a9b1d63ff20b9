//! What the loop and the workshop hand back, passed on to the viewers that it is for.

use std::sync::Arc;
use std::time::{Duration, Instant};

use haptor_contact::{Patch, Pose, Wrench, patch_report};
use haptor_engine::OwnedEngine;
use haptor_wire::{Deformation, Denial, PatchLook, SceneNow, Snapshot, Summary, ToViewer};

use super::peer::Peer;
use super::server::Server;
use super::surfaces::{Done, SurfaceJob};
use super::workshop::{Job, Made};
use crate::rt::desk::{Activation, Look, Note, Order, is_due};

impl Server {
    /// What the loop has to say.
    pub(super) fn pass_notes(&mut self) {
        while let Ok(note) = self.counter.notes.pop() {
            match note {
                Note::Answer { number, result, retired } => self.answered(number, result, retired),
                Note::Stopped => {
                    for (viewer, number) in self.requests.take_stops() {
                        self.tell(viewer, &ToViewer::Done(number));
                    }
                }
                Note::Device(hello) => {
                    self.device = Some(hello);
                    self.tell_all(&ToViewer::Device(hello));
                }
                Note::Event(event) => self.tell_all(&ToViewer::Event(event)),
                Note::Fault(fault) => self.tell_all(&ToViewer::Fault(fault)),
            }
        }
    }

    fn answered(&mut self, number: u64, result: Result<(), Denial>, retired: Option<OwnedEngine>) {
        retired.into_iter().for_each(|engine| self.job(Job::Drop(engine)));
        let Some(waiting) = self.requests.close(number) else { return };
        if let Some(scene) = &waiting.scene {
            match result {
                Ok(()) => {
                    self.job(Job::Runs(scene.number));
                    self.tell_all(&ToViewer::Scene(SceneNow { digest: scene.digest, length: scene.file.len() as u32 }));
                    self.scene = scene.clone();
                }
                Err(_) => self.job(Job::Forget(scene.number)),
            }
        }
        self.conclude(&waiting, result.map_err(|why| (why, String::new())));
    }

    /// What the workshop has made.
    pub(super) fn pass_made(&mut self) {
        while let Ok(made) = self.made.try_recv() {
            match made {
                Made::Built { number, scene, result: Ok(engine) } => {
                    let Some(coming) = self.requests.scene(number) else { continue };
                    self.recorder.scene(Arc::clone(&coming.file));
                    let digest = coming.digest;
                    self.give(number, Order::Activate(Activation { engine, scene, digest }));
                }
                Made::Built { number, result: Err(why), .. } => self.not_made(number, why),
                Made::Checked { number, scene, result: Ok(tuned) } => self.give(number, Order::Tune { scene, tuned: *tuned }),
                Made::Checked { number, result: Err(why), .. } => self.not_made(number, why),
                Made::Limited { number, result: Ok(limit) } => self.give(number, Order::Limit(limit)),
                Made::Limited { number, result: Err(why) } => self.not_made(number, why),
                Made::Surface(done) => self.pass_surface(&done),
            }
        }
    }

    fn not_made(&mut self, number: u64, why: (Denial, String)) {
        let Some(waiting) = self.requests.close(number) else { return };
        if let (Some(scene), Denial::Digest) = (&waiting.scene, why.0) {
            self.uploads.forget(scene.digest);
        }
        self.conclude(&waiting, Err(why));
    }

    fn pass_surface(&mut self, done: &Done) {
        let mine = |peer: &Peer| peer.serial == done.viewer && peer.surface_under_way == Some(done.tick);
        // one that was given up meanwhile is nobody's
        let Some(peer) = self.peers.iter_mut().find(|peer| mine(peer)) else { return };
        peer.surface_under_way = None;
        let watched = &mut peer.watched;
        watched.surfaces += 1;
        watched.passes += u64::from(done.passes);
        watched.points += done.points as u64;
        peer.dropped += u64::from(!peer.outbox.offer(&done.frames));
    }

    /// Ticks that somebody wants to see.
    pub(super) fn pass_looks(&mut self) {
        while let Ok(look) = self.counter.looks.pop() {
            self.counts = look.counts;
            let snapshot = ToViewer::Snapshot(snapshot(&look));
            let jobs = &self.jobs;
            for peer in self.peers.iter_mut().filter(|peer| peer.place().is_some()) {
                if let Some(job) = show(peer, &look, &snapshot) {
                    // a workshop that is gone was told to go
                    let _ = jobs.send(Job::Surface(Box::new(job)));
                }
            }
            // as many places as boxes: there is room
            let _ = self.counter.spare.push(look);
        }
    }

    /// Statistics for those whose time has come.
    pub(super) fn tell_statistics(&mut self, now: Instant) {
        let viewers = self.peers.iter().filter(|peer| peer.place().is_some()).count() as u8;
        let due = |peer: &Peer| peer.place().is_some() && peer.subscription.statistics_ms > 0 && now >= peer.statistics_due;
        if !self.peers.iter().any(|peer| due(peer)) {
            return;
        }
        let [lost, rejected, out_of_order, recorder_dropped] = self.counts;
        let session = Summary { lost, rejected, out_of_order, recorder_dropped, ..self.figures.summary() };
        let missed = self.counter.wanted.missed();
        for peer in self.peers.iter_mut().filter(|peer| due(peer)) {
            peer.statistics_due = now + Duration::from_millis(peer.subscription.statistics_ms.into());
            let statistics = peer.statistics(session, viewers, missed);
            peer.outbox.offer_message(&ToViewer::Statistics(statistics));
        }
    }

    /// Files on their way.
    pub(super) fn pump(&mut self) {
        for peer in &mut self.peers {
            let Peer { outbox, recording, download, .. } = &mut **peer;
            let ended = recording.as_mut().is_some_and(|recording| !recording.pump(outbox));
            if let Some(number) = recording.take_if(|_| ended).and_then(|recording| recording.ended_by()) {
                outbox.put(&ToViewer::Done(number));
            }
            let ended = download.as_mut().is_some_and(|download| !download.pump(outbox));
            if let Some(download) = download.take_if(|_| ended) {
                outbox.put(&ToViewer::Done(download.number));
            }
        }
    }
}

/// Shows a viewer a tick if it is one it asked for; yields the surface to compute for it.
fn show(peer: &mut Peer, look: &Look, snapshot: &ToViewer) -> Option<SurfaceJob> {
    let tick = look.record.tick;
    if !is_due(tick, peer.last_tick.replace(tick), peer.subscription.every) {
        return None;
    }
    if !peer.outbox.offer_message(snapshot) {
        peer.dropped += 1;
        return None;
    }
    peer.sent += 1;
    let wanted = peer.subscription.surface > 0 && (peer.sent - 1).is_multiple_of(peer.subscription.surface.into());
    let job = wanted.then(|| surface_job(peer, look)).flatten()?;
    if peer.surface_under_way.is_some() {
        peer.watched.behind += 1;
        return None;
    }
    if !peer.outbox.has_room() {
        peer.dropped += 1;
        return None;
    }
    peer.surface_under_way = Some(tick);
    Some(job)
}

fn surface_job(peer: &Peer, look: &Look) -> Option<SurfaceJob> {
    let deformation = look.deformation.filter(|amount| *amount != Deformation::None)?;
    Some(SurfaceJob {
        viewer: peer.serial,
        tick: look.record.tick,
        scene: look.scene,
        patches: look.patches.clone(),
        params: look.params?,
        work: look.work,
        p_wp: look.x_wp?.position,
        body: deformation == Deformation::Full,
        rest: peer.rest()?,
    })
}

/// A tick as viewers get it.
fn snapshot(look: &Look) -> Snapshot {
    let Look { record, .. } = look;
    let x_wp = look.x_wp.unwrap_or(Pose::IDENTITY);
    let sent = look.sent.unwrap_or(Wrench::ZERO);
    let q = x_wp.rotation;
    Snapshot {
        tick: record.tick,
        t_us: record.t_us,
        position: x_wp.position.to_array(),
        rotation: [q.w, q.x, q.y, q.z],
        contact_force: record.contact_force,
        contact_torque: record.contact_torque,
        sent_force: sent.force.to_array(),
        sent_torque: sent.torque.to_array(),
        patches: look.patches.iter().map(patch_look).collect(),
        depth: record.depth,
        tier: record.tier,
        flags: record.flags,
        wake_ns: record.wake_ns,
        step_ns: record.step_ns,
        round_trip_ns: record.round_trip_ns,
        in_time_permille: look.in_time_permille,
        mode: look.mode,
        output: look.output,
        fault: look.fault,
    }
}

fn patch_look(patch: &Patch) -> PatchLook {
    let report = patch_report(patch);
    PatchLook {
        region: report.region,
        centre: report.centre.to_array(),
        normal: report.normal.to_array(),
        radius: report.radius,
        stick_radius: report.radius * report.stick.clamp(0.0, 1.0).sqrt(),
        force: report.force.to_array(),
        torque: report.torque.to_array(),
        depth: report.depth,
    }
}
