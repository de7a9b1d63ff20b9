//! What scenes borrow: baked meshes, and a body's own table in any size and of any modulus.

use std::sync::LazyLock;

use glam::{DVec3, Vec3};
use haptor_contact::green::COMPONENTS;
use haptor_contact::{Chart, Green, GreenSpec, Invalid, Material, ObjectShape, ProbeShape};
use haptor_mesh::bake::on_its_base;
use haptor_mesh::{BakeSpec, Baked, Mesh, bake, tessellate};

use crate::bodies;

/// The body of tier `green`: a cube.
pub const CUBE: f32 = 0.125;

/// Its material before any scaling.
pub const STUFF: Material = Material { young_modulus: 4_194_304.0, poisson_ratio: 0.45, density: 1.0e3 };

/// The shape of the body of tier `green` before any scaling.
pub const BODY: ObjectShape<'static> = ObjectShape::Box { size: Vec3::splat(CUBE) };

/// A table of its own: that of [`BODY`] with lengths and moduli multiplied.
#[derive(Clone, Debug)]
pub struct OwnGreen {
    chart: Chart,
    patch_radius: f32,
    own: Vec<f32>,
    table: Vec<f32>,
}

impl OwnGreen {
    /// The table of the body with lengths times `length` and moduli times `modulus`; powers of two keep every digit.
    pub fn scaled(length: f32, modulus: f32) -> Self {
        let spec = bodies::table(BODY, STUFF).spec();
        let side = COMPONENTS * spec.chart.places();
        // displacement per force goes with 1/(E L); a turn or a torque takes a length more
        let per = [1.0 / modulus / length, 1.0 / modulus / length / length, 1.0 / modulus / length / length / length];
        let turns = |row: usize, column: usize| usize::from(row == COMPONENTS - 1) + usize::from(column == COMPONENTS - 1);
        let told = |numbers: &[f32], width: usize| -> Vec<f32> {
            let rows = numbers.chunks_exact(width).enumerate();
            let row = |(i, row): (usize, &[f32])| {
                let own: [f32; COMPONENTS] = std::array::from_fn(|j| per[turns(i % COMPONENTS, j)]);
                row.chunks_exact(COMPONENTS)
                    .flat_map(|block| std::array::from_fn::<_, COMPONENTS, _>(|j| block[j] * own[j]))
                    .collect::<Vec<_>>()
            };
            rows.flat_map(row).collect()
        };
        let (own, table) = (told(spec.own, COMPONENTS), told(spec.table, side));
        let chart = Chart { centre: spec.chart.centre * length, half_size: spec.chart.half_size * length, ..spec.chart };
        Self { chart, patch_radius: spec.patch_radius * length, own, table }
    }

    /// As the core takes it.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn borrowed(&self) -> Result<Green<'_>, Invalid> {
        Green::new(&GreenSpec { chart: self.chart, patch_radius: self.patch_radius, own: &self.own, table: &self.table })
    }
}

/// Sizes of the meshes \[m\]: near both ends of the allowed lengths, and a hand's.
const SIZES: [f64; 3] = [4.0e-6, 0.016, 40.0];

/// Kinds of meshes.
const KINDS: usize = 3;

/// Meshes of every kind and size; a solid of the kinds is a ball, a brick and a pill.
static MESHES: LazyLock<Vec<(Baked, Baked)>> = LazyLock::new(|| {
    let of_size = |size: f64| {
        [
            tessellate::ellipsoid(DVec3::new(size, 0.8 * size, 0.7 * size), 48),
            tessellate::cuboid(DVec3::new(size, 1.3 * size, 0.9 * size)),
            tessellate::capsule(0.5 * size, size, 48),
        ]
    };
    SIZES
        .into_iter()
        .flat_map(of_size)
        .map(|mesh| (baked(&mesh), baked(&on_its_base(&mesh).expect("a solid has bounds").0)))
        .collect()
});

fn baked(mesh: &Mesh) -> Baked {
    bake(mesh, &BakeSpec { cells: 24, samples: 256 }, &mut |_| {}).expect("a solid")
}

/// Meshes there are.
pub const MESH_COUNT: usize = KINDS * SIZES.len();

/// Mesh `i` as a probe's part, and its size \[m\].
///
/// # Panics
/// When the core does not take what was baked.
pub fn probe_mesh(i: usize) -> (ProbeShape<'static>, f32) {
    let i = i % MESH_COUNT;
    (ProbeShape::Mesh(MESHES[i].0.shape().expect("the core takes what was baked")), SIZES[i / KINDS] as f32)
}

/// Mesh `i` as the object, and its size \[m\].
///
/// # Panics
/// As [`probe_mesh`].
pub fn object_mesh(i: usize) -> (ObjectShape<'static>, f32) {
    let i = i % MESH_COUNT;
    (ObjectShape::Mesh(MESHES[i].1.shape().expect("the core takes what was baked")), SIZES[i / KINDS] as f32)
}
