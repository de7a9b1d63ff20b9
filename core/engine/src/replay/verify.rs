//! A whole recording computed again.

use haptor_wire::{Damage, Digest, Record, RecordHeader, RecordReader, TickRecord, VersionMismatch, check_tool_version};

use super::compare::{Difference, add_to_digest, compare};
use super::follow::{Follower, Step, Unsure};
use super::gather::{Gather, NoScene};
use crate::scene::OwnedEngine;

/// Ticks of a recording, by what could be said of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// All.
    pub ticks: u64,
    /// Computed again and equal to the bit.
    pub verified: u64,
    /// Computed again and different.
    pub different: u64,
    /// No pose came in them: nothing to compute.
    pub idle: u64,
    /// Not verifiable.
    pub unverifiable: u64,
}

/// What came out.
#[derive(Clone, Debug, Default)]
pub struct Verdict {
    /// How many.
    pub counts: Counts,
    /// The first difference.
    pub first: Option<Difference>,
    /// Why the first of the ticks that cannot be verified cannot.
    pub unsure: Option<Unsure>,
    /// Why the last scene could not be had, if one could not.
    pub no_scene: Option<NoScene>,
    /// Of the contact wrenches of all verifiable ticks.
    pub digest: Digest,
    /// Damaged places.
    pub damaged: u64,
    /// Bytes in them.
    pub damaged_bytes: u64,
    /// The first damaged place.
    pub first_damage: Option<Damage>,
}

/// Computes records again as they come.
#[derive(Debug, Default)]
pub struct Verifier {
    scene: Option<Gather>,
    running: Option<(OwnedEngine, Follower)>,
    follower: Option<Follower>,
    verdict: Verdict,
}

impl Verifier {
    /// Takes the next record, or the damage in its place.
    ///
    /// # Errors
    /// [`VersionMismatch`] at a header of another version: what follows cannot be read.
    pub fn take(&mut self, record: &Result<Record<'_>, Damage>) -> Result<(), VersionMismatch> {
        match record {
            Err(damage) => self.damage(damage),
            Ok(Record::Header(header)) => self.header(header)?,
            Ok(Record::Scene(chunk)) => {
                if self.scene.as_mut().is_some_and(|gather| gather.push(chunk)) {
                    self.start();
                }
            }
            Ok(Record::Tick(tick)) => self.tick(tick),
            Ok(other) => self.follow(other),
        }
        Ok(())
    }

    /// What came out of the records taken so far; why there is no scene is only known at the end.
    #[must_use]
    pub const fn so_far(&self) -> &Verdict {
        &self.verdict
    }

    /// What came out.
    #[must_use]
    pub fn verdict(mut self) -> Verdict {
        self.leave_scene();
        self.verdict
    }

    fn header(&mut self, header: &RecordHeader) -> Result<(), VersionMismatch> {
        check_tool_version(header.version, header.schema)?;
        self.leave_scene();
        (self.scene, self.running) = (Some(Gather::new(header)), None);
        self.follower = Some(Follower::new(header));
        Ok(())
    }

    /// A scene that never became whole is told.
    fn leave_scene(&mut self) {
        if let (Some(gather), None) = (self.scene.take(), self.running.take()) {
            self.verdict.no_scene = gather.scene().err().or(self.verdict.no_scene.take());
        }
    }

    fn start(&mut self) {
        let (Some(gather), Some(follower)) = (&self.scene, self.follower) else { return };
        let engine = gather.scene().and_then(|scene| Ok(scene.engine()?));
        match engine {
            Ok(engine) => self.running = Some((engine, follower)),
            Err(why) => self.verdict.no_scene = Some(why),
        }
    }

    fn damage(&mut self, damage: &Damage) {
        self.verdict.damaged += 1;
        self.verdict.damaged_bytes += damage.skipped as u64;
        self.verdict.first_damage.get_or_insert(*damage);
        if let Some((_, follower)) = &mut self.running {
            follower.missed(Unsure::Damaged);
        }
        if let Some(follower) = &mut self.follower {
            follower.missed(Unsure::Damaged);
        }
    }

    fn follow(&mut self, record: &Record<'_>) {
        if let Some((engine, follower)) = &mut self.running {
            engine.with(|engine| follower.take(engine, record));
        }
    }

    fn tick(&mut self, tick: &TickRecord) {
        let counts = &mut self.verdict.counts;
        counts.ticks += 1;
        let Some((engine, follower)) = &mut self.running else {
            counts.unverifiable += 1;
            return;
        };
        match engine.with(|engine| follower.take(engine, &Record::Tick(*tick))) {
            Step::Noted => {}
            Step::Idle => counts.idle += 1,
            Step::Felt(_, Err(why)) => {
                counts.unverifiable += 1;
                self.verdict.unsure.get_or_insert(why);
            }
            Step::Felt(felt, Ok(())) => {
                add_to_digest(&mut self.verdict.digest, &felt);
                match compare(tick, &felt) {
                    None => counts.verified += 1,
                    Some(difference) => {
                        counts.different += 1;
                        self.verdict.first.get_or_insert(difference);
                    }
                }
            }
        }
    }
}

/// Computes a whole file again; `at` hears how far it is \[bytes\]. The bytes are decoded onto themselves.
///
/// # Errors
/// [`VersionMismatch`] at a header of another version.
pub fn verify(file: &mut [u8], mut at: impl FnMut(usize)) -> Result<Verdict, VersionMismatch> {
    let mut verifier = Verifier::default();
    let mut reader = RecordReader::new(file);
    while let Some(record) = reader.next() {
        verifier.take(&record)?;
        at(reader.offset());
    }
    Ok(verifier.verdict())
}
