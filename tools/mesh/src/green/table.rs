//! From finite elements to the core's table: unit loads on every place, the core's closed forms taken away.

use glam::Vec3;
use haptor_contact::green::{Chart, Disc as CoreDisc, Load};
use haptor_contact::{Material, Model, ModelSpec, ObjectShape, ProbePart, ProbeShape};

use super::places::{Place, Places, places};
use super::{CONVEX, GreenError, GreenInputs, GreenOptions, GreenTable, RADIUS, WIDE};
use crate::fem::anywhere::{Body, Moved, NEAR, Target, stiffness};
use crate::fem::disc::{Block, Disc, Point, add};
use crate::fem::solid::{Cut, Solid};
use crate::fem::{MAX_POISSON, whole};

/// Signs of the four numbers of a load or a move in the mirrors across x and across y.
const MIRRORED: [[f64; 4]; 2] = [[-1.0, 1.0, 1.0, -1.0], [1.0, -1.0, 1.0, -1.0]];

/// A run: the body in units, and what brings its blocks back to SI.
struct Run<'a> {
    cut: Cut,
    unit: f64,
    shear: f64,
    nu: f64,
    model: Model<'a>,
    chart: Chart,
}

/// Finenesses that fit the solver.
const FINENESS: std::ops::RangeInclusive<usize> = 3..=8;

pub(super) fn compute(inputs: &GreenInputs, progress: &mut dyn FnMut(usize, usize)) -> Result<GreenTable, GreenError> {
    let GreenInputs { shape, material, fixed_below, options } = inputs;
    let ball = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 })];
    let spec = ModelSpec { fixed_below: Some(*fixed_below), ..ModelSpec::new(*shape, *material, &ball) };
    let model = Model::new(&spec).map_err(GreenError::Model)?;
    if !FINENESS.contains(&options.fineness) {
        return Err(GreenError::Option { name: "fineness", value: options.fineness, expected: "3 to 8" });
    }
    if ![3, 5, 7, 9].contains(&options.per_edge) {
        return Err(GreenError::Option { name: "per_edge", value: options.per_edge, expected: "3, 5, 7 or 9" });
    }
    let run = Run::new(shape, material, *fixed_below, options, model)?;
    let nu = f64::from(material.poisson_ratio).min(MAX_POISSON);
    let mesh = whole::mesh(&run.cut, options.fineness);
    let stiffness = stiffness(&mesh, nu)?;
    let body = Body::new(&run.cut, nu, &mesh, &stiffness)?;
    let quarter = run.first_quarter();
    let own = run.own(&body, &quarter, &mut |done| progress(done, 2 * quarter.len()))?;
    let table = run.table(&body, &quarter, &mut |done| progress(quarter.len() + done, 2 * quarter.len()))?;
    Ok(run.finish(&own, &table))
}

impl<'a> Run<'a> {
    fn new(
        shape: &ObjectShape<'_>,
        material: &Material,
        fixed_below: f32,
        options: &GreenOptions,
        model: Model<'a>,
    ) -> Result<Self, GreenError> {
        let metres = Cut::new(Solid::new(shape, 1.0).ok_or(GreenError::NoBody)?, f64::from(fixed_below));
        let unit = metres.half_size.max_element();
        let slender = unit / metres.half_size.min_element();
        if slender > MAX_SLENDER {
            return Err(GreenError::Slender { found: slender, limit: MAX_SLENDER });
        }
        let cut = Cut::new(Solid::new(shape, unit).ok_or(GreenError::NoBody)?, f64::from(fixed_below) / unit);
        let chart = Chart { centre: metres.centre.as_vec3(), half_size: metres.half_size.as_vec3(), per_edge: options.per_edge };
        Ok(Self { cut, unit, shear: f64::from(material.shear_modulus()), nu: f64::from(material.poisson_ratio), model, chart })
    }

    /// The chart's places for discs of `radius`, and the discs.
    fn places(&self, radius: f64) -> (Vec<Place>, Vec<Disc>) {
        let Places { places, spots } = places(&self.cut, &self.chart, radius);
        (places, spots.iter().map(|&spot| Disc::new(&self.cut, spot, radius)).collect())
    }

    /// Numbers of the places that no mirror gives.
    fn first_quarter(&self) -> Vec<usize> {
        let inside = |&place: &usize| self.chart.direction(place).x >= 0.0 && self.chart.direction(place).y >= 0.0;
        (0..self.chart.places()).filter(inside).collect()
    }

    /// The place that the mirrors across x, if `x`, and across y, if `y`, put at `place`.
    fn mirrored(&self, place: usize, x: bool, y: bool) -> usize {
        let mut direction = self.chart.direction(place);
        direction.x *= if x { -1.0 } else { 1.0 };
        direction.y *= if y { -1.0 } else { 1.0 };
        // the cell of a node gives it nearly all the weight
        let cell = self.chart.cell(self.chart.centre + self.chart.half_size * direction);
        let best = cell.place.iter().zip(cell.weight).max_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(place, |(&place, _)| place)
    }

    /// Moves of the loaded places themselves, for discs of the table's radius.
    fn own(&self, body: &Body<'_>, quarter: &[usize], progress: &mut dyn FnMut(usize)) -> Result<Vec<Block>, GreenError> {
        let (places, discs) = self.places(wide(&self.cut));
        let mut own = vec![Block::default(); places.len()];
        for (batch, numbers) in quarter.chunks(AT_ONCE).enumerate() {
            let loaded: Vec<usize> = numbers.iter().flat_map(|&number| places[number].discs.clone()).collect();
            let found = body.own(&loaded.iter().map(|&disc| &discs[disc]).collect::<Vec<_>>())?;
            for &number in numbers {
                let Place { discs: of_place, share, .. } = &places[number];
                for (disc, block) in loaded.iter().zip(&found).filter(|(disc, _)| of_place.contains(disc)) {
                    let weight = share * share / of_place.len() as f64;
                    accumulate(&mut own[number], &self.narrowed(&discs[*disc], block), weight);
                }
            }
            progress(batch * AT_ONCE);
        }
        for number in 0..places.len() {
            let (x, y) = self.beyond(number);
            if x || y {
                own[number] = signed(&own[self.mirrored(number, x, y)], x, y);
            }
        }
        Ok(own)
    }

    /// Own moves of a wide disc as those of one of the table's radius, by what is known in closed form: the convex loss of a twist goes altogether,
    /// since the core's local stiffness has it, and a drag on a surface that falls away draws it along as the logarithm of the radius.
    fn narrowed(&self, disc: &Disc, block: &Block) -> Block {
        let (n, k, a) = (disc.spot.normal, self.cut.curvature(&disc.spot), disc.radius);
        let to = self.radius();
        let mut narrowed = *block;
        narrowed[3][3] -= 3.0 / (16.0 * a.powi(3)) * (1.0 / (1.0 - CONVEX * k * a) - 1.0);
        let softer = 3.0 - 2.0 * self.nu * (1.0 - 2.0 * self.nu);
        let drag = k * softer / (8.0 * std::f64::consts::PI) * (a / to).ln() + SHADED * k.powi(3) * (a * a - to * to);
        for row in 0..3 {
            for column in 0..3 {
                let along = f64::from(u8::from(row == column)) - n[row] * n[column];
                narrowed[row][column] += along * drag;
            }
        }
        narrowed
    }

    /// Radius of the loaded discs, in units.
    fn radius(&self) -> f64 {
        RADIUS * self.cut.half_size.min_element()
    }

    /// Which of the mirrors a place lies beyond.
    fn beyond(&self, place: usize) -> (bool, bool) {
        let direction = self.chart.direction(place);
        (direction.x < 0.0, direction.y < 0.0)
    }

    /// Columns of the table: for each place loaded, the blocks of all places.
    fn table(&self, body: &Body<'_>, quarter: &[usize], progress: &mut dyn FnMut(usize)) -> Result<Vec<Vec<Block>>, GreenError> {
        let (places, discs) = self.places(self.radius());
        // nothing is read on the held base
        let points = places.iter().map(|place| match place.discs[..] {
            [] => body.target(&[]),
            _ => body.target(&[Point::alone(place.point)]),
        });
        let rings = discs.iter().map(|disc| body.target(&disc.ring));
        let targets = points.chain(rings).collect::<Result<Vec<_>, _>>()?;
        let mut columns = vec![vec![Block::default(); places.len()]; places.len()];
        for (batch, numbers) in quarter.chunks(AT_ONCE).enumerate() {
            let loaded: Vec<usize> = numbers.iter().flat_map(|&number| places[number].discs.clone()).collect();
            let moved = body.moves(&loaded.iter().map(|&disc| &discs[disc]).collect::<Vec<_>>(), &targets)?;
            for &number in numbers {
                for (disc, moved) in loaded.iter().zip(&moved).filter(|(disc, _)| places[number].discs.contains(disc)) {
                    let weight = places[number].share / places[number].discs.len() as f64;
                    let rest = self.rest(&places, &discs, &targets, *disc, moved);
                    columns[number].iter_mut().zip(&rest).for_each(|(sum, block)| accumulate(sum, block, weight));
                }
            }
            progress(batch * AT_ONCE);
        }
        for number in 0..places.len() {
            let (x, y) = self.beyond(number);
            if x || y {
                let source = self.mirrored(number, x, y);
                columns[number] = (0..places.len()).map(|row| signed(&columns[source][self.mirrored(row, x, y)], x, y)).collect();
            }
        }
        Ok(columns)
    }

    /// What a loaded disc moves at every place beyond the closed forms: displacement at the node, turn of its discs.
    fn rest(&self, places: &[Place], discs: &[Disc], targets: &[Target], loaded: usize, moved: &Moved) -> Vec<Block> {
        let disc = &discs[loaded];
        let core = self.core(disc);
        let circle = disc.circle(&self.cut, NEAR * disc.radius);
        let (mut near, closed) = (moved.near, self.closed(&core, &circle));
        accumulate(&mut near, &closed, -1.0);
        let at_place = |(number, place): (usize, &Place)| {
            let mut block = if place.point.distance(disc.spot.point) < NEAR * disc.radius {
                near
            } else {
                let mut block = moved.at[number];
                accumulate(&mut block, &self.closed(&core, &targets[number].points), -1.0);
                block
            };
            if place.discs.is_empty() {
                block = Block::default();
            }
            block[3] = [0.0; 4];
            for &other in &place.discs {
                let (turn, closed) = if other == loaded {
                    (near[3], [0.0; 4])
                } else {
                    (moved.at[places.len() + other][3], self.turned(&core, &discs[other]))
                };
                for load in 0..4 {
                    block[3][load] += (turn[load] - closed[load]) * place.share / place.discs.len() as f64;
                }
            }
            block
        };
        places.iter().enumerate().map(at_place).collect()
    }

    /// The core's disc.
    fn core(&self, disc: &Disc) -> CoreDisc {
        let radius = 1.0 / self.cut.curvature(&disc.spot).max(f64::from(f32::MIN_POSITIVE));
        let at = (disc.spot.point * self.unit).as_vec3();
        CoreDisc::new(&self.model, at, disc.spot.normal.as_vec3(), (disc.radius * self.unit) as f32, (radius * self.unit) as f32)
    }

    /// The four unit loads, and what brings the moves under them to units of the body.
    fn loads(&self) -> [(Load, f64); 4] {
        let force = self.shear * self.unit;
        let along = |f: Vec3| (Load { force: f, torque: 0.0 }, force);
        [along(Vec3::X), along(Vec3::Y), along(Vec3::Z), (Load { force: Vec3::ZERO, torque: 1.0 }, force * self.unit)]
    }

    /// Mean move of `points` by the core's closed forms.
    fn closed(&self, disc: &CoreDisc, points: &[Point]) -> Block {
        let mut block = Block::default();
        for point in points {
            let at = (point.at * self.unit).as_vec3();
            add(&mut block, point, &self.loads().map(|(load, scale)| disc.displacement(&load, at).as_dvec3() * scale));
        }
        block
    }

    /// Turn of another disc by the core's closed forms.
    fn turned(&self, disc: &CoreDisc, other: &Disc) -> [f64; 4] {
        let (at, normal) = ((other.spot.point * self.unit).as_vec3(), other.spot.normal.as_vec3());
        self.loads().map(|(load, scale)| f64::from(disc.at(&load, at, normal, 0.0).turn) * scale * self.unit)
    }

    fn finish(&self, own: &[Block], columns: &[Vec<Block>]) -> GreenTable {
        // a move over a load: length over force, turn over force or length over torque, turn over torque
        let force = 1.0 / (self.shear * self.unit);
        let si = |row: usize, column: usize, value: f64| {
            let turns = i32::from(row == 3) + i32::from(column == 3);
            (value * force / self.unit.powi(turns)) as f32
        };
        let mut table = Vec::with_capacity(16 * columns.len() * columns.len());
        for place in 0..columns.len() {
            for row in 0..4 {
                for column in columns {
                    table.extend((0..4).map(|load| si(row, load, column[place][row][load])));
                }
            }
        }
        let own = own.iter().flat_map(|block| (0..16).map(|i| si(i / 4, i % 4, block[i / 4][i % 4]))).collect();
        GreenTable { chart: self.chart, patch_radius: (self.radius() * self.unit) as f32, own, table }
    }
}

/// Places solved at once: some 64 right-hand sides fill the solver's kernels.
const AT_ONCE: usize = 12;

/// How a wide disc shades the curved surface it draws along, times curvature cubed and radius squared: spheres, discs of 0.1 to 0.3 of the radius.
const SHADED: f64 = 1.25;

/// Bodies beyond this degenerate the bricks.
const MAX_SLENDER: f64 = 10.0;

/// Radius of the discs whose own moves are taken, in units.
fn wide(cut: &Cut) -> f64 {
    let share = match cut.solid {
        Solid::Ellipsoid { .. } => WIDE,
        _ => RADIUS,
    };
    share * cut.half_size.min_element()
}

fn accumulate(sum: &mut Block, block: &Block, weight: f64) {
    sum.iter_mut().flatten().zip(block.iter().flatten()).for_each(|(sum, value)| *sum += weight * value);
}

/// The block as the mirrors across x and y show it.
fn signed(block: &Block, x: bool, y: bool) -> Block {
    let sign = |i: usize| (if x { MIRRORED[0][i] } else { 1.0 }) * (if y { MIRRORED[1][i] } else { 1.0 });
    std::array::from_fn(|row| std::array::from_fn(|column| sign(row) * sign(column) * block[row][column]))
}
