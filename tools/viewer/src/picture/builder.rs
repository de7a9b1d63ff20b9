//! Stage, moment and settings to a picture. Buffers are kept from moment to moment; triangles of bodies are made once.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::batch::{Batch, Colour, Paint};
use super::legend::{Bar, Legend, Row, Sign};
use super::pressure::Profile;
use super::quantity::{self, Quantity, round_end, round_step};
use super::settings::{ColourBy, Settings};
use super::shapes;
use super::signs::{self, FORCE, Room, SLIPS, STICKS, Scales, TORQUE, scale_colour};
use super::skin::{self, Skin};
use crate::feed::{Frame, Pose, Region, Stage};

/// What is drawn, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// Tiles.
    Ground,
    /// The elastic body.
    Object,
    /// The rigid body.
    Probe,
    /// Contact regions: after the probe, so that their colours are those of the legend also where one looks through it.
    Discs,
    /// Forces of the regions.
    RegionForces,
    /// Torque on the probe.
    Torque,
    /// Force on the probe.
    Force,
}

/// How many layers there are.
pub const LAYERS: usize = 7;

/// Triangles and what they mean.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// By [`Layer`].
    pub batches: [Batch; LAYERS],
    /// The legend.
    pub legend: Legend,
    /// Values that were not finite or did not fit, drawn as nothing.
    pub refused: u32,
}

impl Picture {
    /// A layer's triangles.
    pub fn layer(&self, layer: Layer) -> &Batch {
        &self.batches[layer as usize]
    }

    fn layer_mut(&mut self, layer: Layer) -> &mut Batch {
        &mut self.batches[layer as usize]
    }
}

/// The object without a scale.
const OBJECT: Colour = [222, 199, 160, 255];
/// The probe.
const PROBE: Colour = [150, 172, 196, 255];
/// The ground.
const TILES: [Colour; 2] = [[226, 229, 233, 255], [205, 210, 216, 255]];

/// Tiles along the scene's radius, at least.
const TILES_PER_RADIUS: f64 = 6.0;

/// How far the ground reaches: where it begins to fade, and its end, in scene radii.
const GROUND: (f64, f64) = (1.0, 2.6);

/// A disc counts as nearer to the eye than it is by this share of its radius: surface and disc lie on each other.
const DISC_LIFT: f32 = 0.7;

/// The least displacement \[m\] and pressure \[Pa\] that get a scale of their own: below it there is only rounding.
const LEAST: (f64, f64) = (1.0e-6, 1.0);

/// The largest seen so far: scales do not shrink while one looks.
#[derive(Clone, Copy, Debug, Default)]
struct Peaks {
    force: f64,
    torque: f64,
    region_force: f64,
    moved: f64,
    pressure: f64,
}

/// What the object's vertices follow from, beside the regions' pressure.
#[derive(Clone, Debug)]
struct Made {
    moved: Option<Arc<[Vec3]>>,
    by: ColourBy,
    end: f64,
}

impl PartialEq for Made {
    /// A displacement is the same when it is the same one in memory, which stays alive here.
    fn eq(&self, other: &Self) -> bool {
        let same = match (&self.moved, &other.moved) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        same && self.by == other.by && self.end == other.end
    }
}

/// Makes the pictures of one stage.
#[derive(Debug)]
pub struct Builder {
    stage: Arc<Stage>,
    skin: Skin,
    /// Values of the stage that were refused.
    refused: u32,
    /// Half the diagonal of the object \[m\].
    radius: f64,
    /// Edge of a tile \[m\].
    tile: f64,
    /// Distance of the torque's arc from its axis \[m\].
    ring: f64,
    peaks: Peaks,
    scales: Scales,
    picture: Picture,
    /// What the object's vertices were last made from.
    made: Option<Made>,
}

impl Builder {
    /// Prepares a stage.
    pub fn new(stage: Arc<Stage>) -> Self {
        let (skin, mut refused) = Skin::new(&stage.object);
        let radius = half_diagonal(&skin.rest).max(1.0e-6);
        let mut picture = Picture::default();
        *picture.layer_mut(Layer::Object) = skin.batch(OBJECT, Paint::default());
        let through = Paint { one_sided: true, hides: false, ..Paint::default() };
        let mut probe = Batch::new(through);
        for part in &stage.probe {
            let (skin, broken) = Skin::new(part);
            append(&mut probe, &skin.batch(PROBE, through));
            refused += broken;
        }
        let reach = probe.positions.iter().map(|p| p.length()).fold(0.0, f32::max);
        *picture.layer_mut(Layer::Probe) = probe;
        let tile = round_step(1.5 * radius / TILES_PER_RADIUS);
        if !stage.is_ground {
            *picture.layer_mut(Layer::Ground) = ground(&skin.rest, radius, tile);
        }
        for sign in [Layer::RegionForces, Layer::Torque, Layer::Force] {
            picture.layer_mut(sign).paint = Paint { one_sided: true, behind: 0.3, ..Paint::default() };
        }
        let peaks = Peaks { force: stage.force_scale.max(0.0), torque: stage.torque_scale.max(0.0), ..Peaks::default() };
        let ring = (1.25 * f64::from(reach)).clamp(0.12 * radius, 0.32 * radius);
        Self { stage, skin, refused, radius, tile, ring, peaks, scales: Scales::default(), picture, made: None }
    }

    /// The stage it draws.
    pub fn stage(&self) -> &Arc<Stage> {
        &self.stage
    }

    /// Half the diagonal of the object \[m\].
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Scales choose themselves anew from here on.
    pub fn forget_peaks(&mut self) {
        self.peaks =
            Peaks { force: self.stage.force_scale.max(0.0), torque: self.stage.torque_scale.max(0.0), ..Peaks::default() };
        self.made = None;
    }

    /// The picture as it was last built.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// The picture of a moment.
    pub fn build(&mut self, frame: &Frame, settings: &Settings) -> &Picture {
        self.picture.refused = self.refused;
        let regions: Vec<Region> = frame.regions.iter().filter(|region| region.is_finite()).copied().collect();
        self.picture.refused += (frame.regions.len() - regions.len()) as u32;
        let moved = self.moved(frame);
        self.measure(frame, &regions, moved.as_deref());
        let (peaks, tile) = (self.peaks, self.tile);
        self.scales = Scales::of(peaks.force, peaks.torque, self.radius, tile, settings.longer);
        let end = self.colour_end(settings);
        self.build_object(settings, &regions, moved.as_ref(), end);
        self.build_discs(settings, &regions, end);
        self.build_probe(frame, settings);
        self.build_wrench(frame);
        self.build_region_forces(settings, &regions);
        let bar =
            if settings.colour_by == ColourBy::Displacement && moved.is_none() { None } else { bar(settings.colour_by, end) };
        self.picture.legend = Legend { rows: self.rows(frame, settings, &regions), bar };
        &self.picture
    }

    /// The displacement, when it belongs to this object.
    fn moved(&mut self, frame: &Frame) -> Option<Arc<[Vec3]>> {
        let moved = Arc::clone(&frame.displacement.as_ref()?.moved);
        if moved.len() == self.skin.rest.len() {
            return Some(moved);
        }
        self.picture.refused += 1;
        None
    }

    /// Raises the peaks.
    fn measure(&mut self, frame: &Frame, regions: &[Region], moved: Option<&[Vec3]>) {
        // a NaN is never the larger one
        let peaks = &mut self.peaks;
        peaks.force = peaks.force.max(finite(frame.contact.force.length()));
        peaks.torque = peaks.torque.max(finite(frame.contact.torque.length()));
        let largest = |of: fn(&Region) -> f64| regions.iter().map(of).fold(0.0, f64::max);
        peaks.region_force = peaks.region_force.max(largest(|region| region.force.length()));
        peaks.pressure = peaks.pressure.max(largest(Region::peak_pressure));
        if let Some(moved) = moved {
            let most = moved.iter().map(|u| u.length_squared()).filter(|u| u.is_finite()).fold(0.0, f32::max);
            peaks.moved = peaks.moved.max(f64::from(most.sqrt()));
        }
    }

    /// Upper end of the colour scale and the step of its ticks \[SI\].
    fn colour_end(&self, settings: &Settings) -> (f64, f64) {
        let least = if settings.colour_by == ColourBy::Pressure { LEAST.1 } else { LEAST.0 };
        let seen = if settings.colour_by == ColourBy::Pressure { self.peaks.pressure } else { self.peaks.moved };
        let chosen = settings.colour_end.filter(|end| end.is_finite() && *end > 0.0);
        chosen.map_or_else(|| round_end(seen.max(least)), |end| (end, round_end(end).1.min(end)))
    }

    /// The object where it has moved to, in its colours.
    fn build_object(&mut self, settings: &Settings, regions: &[Region], moved: Option<&Arc<[Vec3]>>, (end, _): (f64, f64)) {
        let by =
            if moved.is_none() && settings.colour_by == ColourBy::Displacement { ColourBy::Nothing } else { settings.colour_by };
        let before = self.made.replace(Made { moved: moved.cloned(), by, end });
        if by == ColourBy::Pressure || before != self.made {
            let batch = &mut self.picture.batches[Layer::Object as usize];
            self.skin.place(batch, moved.map(|moved| &**moved));
            skin::shade(batch);
            let profiles: Vec<Profile> = regions.iter().map(Profile::of).collect();
            colour_object(batch, &self.skin, by, moved.map(|moved| &**moved), &profiles, end as f32);
            batch.vertices_version += 1;
        }
        let broken = moved.map_or(0, |moved| moved.iter().filter(|u| !u.is_finite()).count());
        self.picture.refused += broken as u32;
    }

    fn build_discs(&mut self, settings: &Settings, regions: &[Region], (end, _): (f64, f64)) {
        let batch = self.picture.layer_mut(Layer::Discs);
        batch.clear();
        let largest = regions.iter().map(|region| region.radius as f32).fold(0.0, f32::max);
        batch.paint = Paint { lit: false, lift: DISC_LIFT * largest, ..Paint::default() };
        for region in regions.iter().filter(|region| region.radius > 0.0) {
            match settings.colour_by {
                ColourBy::Pressure => signs::draw_profile(batch, region, end),
                _ => signs::draw_disc(batch, region),
            }
        }
    }

    fn build_probe(&mut self, frame: &Frame, settings: &Settings) {
        let batch = self.picture.layer_mut(Layer::Probe);
        let opacity = settings.probe_opacity.clamp(0.0, 1.0);
        batch.paint = Paint { opacity, one_sided: true, hides: opacity >= 1.0, ..Paint::default() };
        if frame.probe.is_finite() {
            batch.place = Pose { rotation: frame.probe.rotation.normalize(), ..frame.probe };
        } else {
            batch.paint.opacity = 0.0;
            self.picture.refused += 1;
        }
    }

    fn room(&self, origin: DVec3) -> Room {
        Room { origin: origin.as_vec3(), radius: self.radius, tile: self.tile, ring: self.ring }
    }

    /// Force and torque on the probe, from its mass centre.
    fn build_wrench(&mut self, frame: &Frame) {
        let room = self.room(frame.probe.position);
        let (force, torque) = (frame.contact.force.as_vec3(), frame.contact.torque.as_vec3());
        for (layer, vector) in [(Layer::Force, force), (Layer::Torque, torque)] {
            let scales = self.scales;
            let batch = self.picture.layer_mut(layer);
            batch.clear();
            batch.paint.axis = Vec3::ZERO;
            if !(vector.is_finite() && room.origin.is_finite()) {
                self.picture.refused += 1;
                continue;
            }
            match layer {
                Layer::Force => {
                    batch.paint.axis = vector.normalize_or_zero();
                    signs::draw_force(batch, &room, vector, &scales, 1.0);
                }
                _ => signs::draw_torque(batch, &room, vector, &scales),
            }
        }
    }

    fn build_region_forces(&mut self, settings: &Settings, regions: &[Region]) {
        let scales = self.region_scales(settings);
        let rooms: Vec<Room> = regions.iter().map(|region| self.room(region.centre)).collect();
        let batch = self.picture.layer_mut(Layer::RegionForces);
        batch.clear();
        if settings.region_forces {
            for (region, room) in regions.iter().zip(&rooms) {
                signs::draw_force(batch, room, region.force.as_vec3(), &scales, 0.6);
            }
        }
    }

    /// Arrows of regions are half as long as the whole one's.
    fn region_scales(&self, settings: &Settings) -> Scales {
        Scales::of(2.0 * self.peaks.region_force, 0.0, self.radius, self.tile, settings.longer)
    }

    fn rows(&self, frame: &Frame, settings: &Settings, regions: &[Region]) -> Vec<Row> {
        let tile = Quantity::Length.words_round(self.tile);
        let force = |force: f64| format!("{tile} = {}", Quantity::Force.words_round(force));
        let row = |sign, colour, words: String, scale: String| Row { sign, colour, words, scale };
        let (f, t) = (frame.contact.force.length(), frame.contact.torque.length());
        let turn = format!("full turn = {}", Quantity::Torque.words_round(self.scales.torque_of_turn));
        let mut rows = vec![
            row(Sign::Arrow, FORCE, format!("force {}", Quantity::Force.words(f)), force(self.scales.force_of_tile)),
            row(Sign::Arc, TORQUE, format!("torque {}", Quantity::Torque.words(t)), turn),
        ];
        if settings.region_forces {
            let scale = force(self.region_scales(settings).force_of_tile);
            rows.push(row(Sign::Arrow, FORCE, "force of each region (thin)".to_owned(), scale));
        }
        if !regions.is_empty() {
            rows.push(row(Sign::Disc, STICKS, "sticks".to_owned(), String::new()));
            rows.push(row(Sign::Ring, SLIPS, "slips".to_owned(), String::new()));
        }
        if !self.stage.is_ground {
            rows.push(row(Sign::Tile, TILES[1], format!("tile {tile}"), String::new()));
        }
        rows
    }

    /// Points that a camera should see: the outermost of object and probe, and room for an arrow \[m\].
    pub fn outline(&self, frame: &Frame) -> Vec<DVec3> {
        let mut points = outermost(&self.skin.rest);
        if frame.probe.is_finite() {
            let Pose { position, rotation } = frame.probe;
            let probe = outermost(&self.picture.layer(Layer::Probe).positions);
            points.extend(probe.into_iter().map(|p| position + rotation * p));
            points.push(position + signs::ARROW * self.radius * DVec3::Z);
        }
        points
    }
}

/// Directions in which a body's outermost points are looked for: between neighbours lie 15 degrees, the outline is within 1 % of its size.
const DIRECTIONS: u32 = 200;

/// The points of a body that reach farthest in some direction.
fn outermost(points: &[Vec3]) -> Vec<DVec3> {
    // an even spread over the sphere: heights in even steps, each turned on by the golden angle
    let direction = |k: u32| {
        let height = 1.0 - (2.0 * k as f32 + 1.0) / DIRECTIONS as f32;
        let (sin, cos) = (2.399_963_2 * k as f32).sin_cos();
        Vec3::new(cos, sin, 0.0) * (1.0 - height * height).sqrt() + height * Vec3::Z
    };
    let finite = || points.iter().filter(|p| p.is_finite());
    let farthest = |along: Vec3| finite().max_by(|a, b| a.dot(along).total_cmp(&b.dot(along)));
    (0..DIRECTIONS).filter_map(|k| farthest(direction(k))).map(|p| p.as_dvec3()).collect()
}

fn bar(by: ColourBy, (end, step): (f64, f64)) -> Option<Bar> {
    let (name, quantity) = match by {
        ColourBy::Displacement => ("displacement", Quantity::Length),
        ColourBy::Pressure => ("pressure", Quantity::Pressure),
        ColourBy::Nothing => return None,
    };
    let unit = quantity.unit(end);
    Some(Bar { end, title: format!("{name} [{}]", unit.name), ticks: quantity::ticks(end, step, unit) })
}

/// Colours of the object's vertices.
fn colour_object(batch: &mut Batch, skin: &Skin, by: ColourBy, moved: Option<&[Vec3]>, profiles: &[Profile], end: f32) {
    let Batch { positions, colours, triangles, .. } = batch;
    match (by, moved) {
        (ColourBy::Displacement, Some(moved)) => {
            let shares = skin.sources.iter().map(|&source| moved[source as usize].length() / end);
            colours.iter_mut().zip(shares).for_each(|(colour, share)| *colour = scale_colour(share));
        }
        (ColourBy::Pressure, _) => {
            let at = |&point: &Vec3| profiles.iter().map(|profile| profile.at(point)).fold(0.0, f32::max);
            let mut pressure: Vec<f32> = positions.iter().map(at).collect();
            keep_inside(&mut pressure, triangles);
            colours.iter_mut().zip(&pressure).for_each(|(colour, pressure)| *colour = scale_colour(pressure / end));
        }
        _ => colours.fill(OBJECT),
    }
}

/// Takes away the pressure of vertices whose triangles reach out of the contact: a coarse mesh would smear it beyond the edge. The region's own disc
/// shows it up to there.
fn keep_inside(pressure: &mut [f32], triangles: &[[u32; 3]]) {
    let leaves = |triangle: &&[u32; 3]| {
        let inside = triangle.iter().filter(|&&corner| pressure[corner as usize] > 0.0).count();
        (1..3).contains(&inside)
    };
    let edge: Vec<[u32; 3]> = triangles.iter().filter(leaves).copied().collect();
    edge.iter().flatten().for_each(|&corner| pressure[corner as usize] = 0.0);
}

/// Tiles below an object.
fn ground(rest: &[Vec3], radius: f64, tile: f64) -> Batch {
    let mut batch = Batch::new(Paint { lit: false, hides: false, ..Paint::default() });
    let (low, high) = bounds(rest);
    let centre = ((low + high) / 2.0).with_z(low.z - 1.0e-3 * radius as f32);
    let [near, far] = [GROUND.0, GROUND.1].map(|share| (share * radius) as f32);
    shapes::ground(&mut batch, centre, tile as f32, near, far, TILES);
    batch.touch();
    batch
}

fn append(batch: &mut Batch, part: &Batch) {
    let first = batch.positions.len() as u32;
    batch.positions.extend(&part.positions);
    batch.normals.extend(&part.normals);
    batch.colours.extend(&part.colours);
    batch.triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
    batch.touch();
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let both = points.iter().filter(|p| p.is_finite()).map(|&p| (p, p)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
    both.unwrap_or_default()
}

fn half_diagonal(points: &[Vec3]) -> f64 {
    let (low, high) = bounds(points);
    f64::from((high - low).length()) / 2.0
}

/// The value, or zero for none.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use haptor_mesh::tessellate;

    use super::super::mako::MAKO;
    use super::*;
    use crate::feed::{Displacement, Wrench};

    const REGION: Region = Region {
        centre: DVec3::new(0.0, 0.0, 0.1),
        normal: DVec3::Z,
        radius: 0.004,
        stick_radius: 0.002,
        force: DVec3::new(0.0, 0.0, 20.0),
        torque: DVec3::ZERO,
        pressure: None,
    };

    fn stage() -> Arc<Stage> {
        let ball = tessellate::ellipsoid(DVec3::splat(0.05), 16).mapped(|v| v + 0.05 * DVec3::Z);
        let probe = vec![tessellate::ellipsoid(DVec3::splat(0.02), 16)];
        Arc::new(Stage { object: ball, probe, ..Stage::default() })
    }

    fn frame(builder: &Builder) -> Frame {
        let mut moved = vec![Vec3::ZERO; builder.stage().object.vertices.len()];
        moved[3] = Vec3::new(0.0, 0.0, -1.2e-3);
        Frame {
            probe: Pose { position: DVec3::new(0.0, 0.0, 0.119), rotation: DQuat::IDENTITY },
            contact: Wrench { force: DVec3::new(0.0, 0.0, 20.0), torque: DVec3::new(0.0, 0.0, -0.04) },
            regions: vec![REGION],
            displacement: Some(Displacement { tick: 0, moved: moved.into() }),
            ..Frame::default()
        }
    }

    /// Colours of the object, with and without duplicates.
    fn colours(builder: &Builder) -> Vec<[u8; 3]> {
        builder.picture().layer(Layer::Object).colours.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
    }

    #[test]
    fn every_layer_is_there_and_numbered_within_its_vertices() {
        let mut builder = Builder::new(stage());
        let frame = frame(&builder);
        let picture = builder.build(&frame, &Settings { region_forces: true, ..Settings::default() });
        assert_eq!(picture.refused, 0);
        for (number, batch) in picture.batches.iter().enumerate() {
            assert!(!batch.triangles.is_empty(), "layer {number} is empty");
            let count = batch.positions.len();
            assert_eq!((batch.normals.len(), batch.colours.len()), (count, count), "layer {number}");
            assert!(batch.triangles.iter().flatten().all(|&corner| (corner as usize) < count), "layer {number}");
        }
        assert_eq!(picture.layer(Layer::Object).triangles.len(), builder.stage().object.triangles.len());
    }

    #[test]
    fn the_scale_ends_where_the_colours_do() {
        let mut builder = Builder::new(stage());
        let frame = frame(&builder);
        let bar = builder.build(&frame, &Settings::default()).legend.bar.clone().unwrap();
        assert_eq!((bar.title.as_str(), bar.ticks.last().unwrap().1.as_str()), ("displacement [mm]", "1.2"));
        let shown = colours(&builder);
        assert!(shown.contains(&MAKO[0]) && shown.contains(&MAKO[255]), "rest and the largest displacement");
        builder.build(&frame, &Settings { colour_end: Some(1.0e-4), ..Settings::default() });
        assert!(colours(&builder).contains(&MAKO[255]), "beyond the end it stays at the last colour");
        builder.build(&frame, &Settings { colour_by: ColourBy::Nothing, ..Settings::default() });
        assert!(colours(&builder).iter().all(|colour| colour[..] == OBJECT[..3]));
        assert_eq!(builder.picture().legend.bar, None);
    }

    #[test]
    fn pressure_colours_the_disc_from_its_peak_to_nothing() {
        let mut builder = Builder::new(stage());
        let frame = frame(&builder);
        let end = REGION.peak_pressure();
        builder.build(&frame, &Settings { colour_by: ColourBy::Pressure, colour_end: Some(end), ..Settings::default() });
        let disc = &builder.picture().layer(Layer::Discs).colours;
        assert_eq!((disc[0][..3].to_vec(), disc[0][3]), (MAKO[255].to_vec(), 255));
        assert!(disc.contains(&STICKS) && disc.contains(&SLIPS), "the edges of core and ring");
    }

    #[test]
    fn what_is_not_finite_is_drawn_as_nothing_and_counted() {
        let mut builder = Builder::new(stage());
        let good = frame(&builder);
        let nan = DVec3::splat(f64::NAN);
        let with = |change: fn(&mut Frame, DVec3)| {
            let mut frame = good.clone();
            change(&mut frame, nan);
            frame
        };
        let table: [(&str, Frame, Option<Layer>); 6] = [
            ("force", with(|frame, nan| frame.contact.force = nan), Some(Layer::Force)),
            ("torque", with(|frame, nan| frame.contact.torque = nan * f64::INFINITY), Some(Layer::Torque)),
            ("pose", with(|frame, nan| frame.probe.rotation = DQuat::from_xyzw(nan.x, 0.0, 0.0, 1.0)), Some(Layer::Probe)),
            ("region", with(|frame, nan| frame.regions[0].centre = nan), Some(Layer::Discs)),
            ("radius", with(|frame, _| frame.regions[0].radius = f64::INFINITY), Some(Layer::Discs)),
            ("length", with(|frame, _| frame.displacement.as_mut().unwrap().moved = vec![Vec3::ZERO; 3].into()), None),
        ];
        for (name, frame, missing) in table {
            let picture = builder.build(&frame, &Settings::default());
            assert_eq!(picture.refused, 1, "{name}");
            assert!(missing.is_none_or(|layer| picture.layer(layer).is_empty()), "{name}");
            let all = picture.batches.iter().flat_map(|batch| &batch.positions);
            assert!(all.into_iter().all(|position| position.is_finite()), "{name}");
        }
        let mut moved = good.displacement.as_ref().unwrap().moved.to_vec();
        moved[7] = Vec3::INFINITY;
        let frame = Frame { displacement: Some(Displacement { tick: 1, moved: moved.into() }), ..good.clone() };
        assert_eq!(builder.build(&frame, &Settings::default()).refused, 1, "one vertex");
        assert_eq!(builder.build(&good, &Settings::default()).refused, 0, "a good frame after bad ones");
    }

    #[test]
    fn only_what_changed_counts_as_changed() {
        let mut builder = Builder::new(stage());
        let frame = frame(&builder);
        let versions = |builder: &Builder, layer| {
            let batch = builder.picture().layer(layer);
            (batch.vertices_version, batch.triangles_version)
        };
        builder.build(&frame, &Settings::default());
        let before = [Layer::Object, Layer::Probe, Layer::Ground].map(|layer| versions(&builder, layer));
        let moved = Frame { probe: Pose { position: DVec3::Z, ..frame.probe }, tick: 1, ..frame.clone() };
        builder.build(&moved, &Settings::default());
        assert_eq!([Layer::Object, Layer::Probe, Layer::Ground].map(|layer| versions(&builder, layer)), before);
        let mut other = frame.clone();
        other.displacement.as_mut().unwrap().moved = frame.displacement.as_ref().unwrap().moved.to_vec().into();
        builder.build(&other, &Settings::default());
        let now = versions(&builder, Layer::Object);
        assert!(now.0 > before[0].0 && now.1 == before[0].1, "new vertices, the same triangles");
    }

    #[test]
    fn scales_are_round_and_do_not_shrink() {
        let mut builder = Builder::new(stage());
        let frame = frame(&builder);
        let row = |builder: &mut Builder, frame: &Frame| builder.build(frame, &Settings::default()).legend.rows[0].clone();
        let high = row(&mut builder, &frame);
        assert_eq!((high.words.as_str(), high.scale.as_str()), ("force 20.0 N", "20 mm = 10 N"));
        let quiet = Frame { contact: Wrench::default(), ..frame.clone() };
        assert_eq!(row(&mut builder, &quiet).scale, high.scale);
        builder.forget_peaks();
        assert_ne!(row(&mut builder, &quiet).scale, high.scale);
    }

    #[test]
    fn an_empty_stage_draws_nothing_and_does_not_fail() {
        let mut builder = Builder::new(Arc::new(Stage::default()));
        let picture = builder.build(&Frame::default(), &Settings::default());
        assert!(picture.layer(Layer::Object).is_empty() && picture.layer(Layer::Probe).is_empty());
        assert!(!builder.outline(&Frame::default()).is_empty());
    }
}
