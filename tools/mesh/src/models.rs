//! Three meshes of our own: a mallet and a compass to hold, an organ to press.
//!
//! All are **lofts**: rings of points from one pole to the other, joined by triangles. Sines and roots are `libm`'s, so that every machine makes the
//! same bytes. Lengths in metres.

use std::f64::consts::PI;

use glam::DVec3;
use libm::{asin, cos, sin, sqrt};

use crate::mesh::Mesh;
use crate::tessellate::loft;

/// The models.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// A barrel on its side with a round handle, as in the scene `mallet`; the handle along z.
    Mallet,
    /// Two legs with round tips that a bow joins, as in the scene `compass`; the bow on top.
    Compass,
    /// A convex body without symmetry, of a liver's proportions, rounder above than below.
    Organ,
}

impl Model {
    /// Every model.
    pub const ALL: [Self; 3] = [Self::Mallet, Self::Compass, Self::Organ];

    /// Its name in commands and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mallet => "mallet",
            Self::Compass => "compass",
            Self::Organ => "organ",
        }
    }

    /// Its mesh.
    pub fn mesh(self) -> Mesh {
        match self {
            Self::Mallet => mallet(),
            Self::Compass => compass(),
            Self::Organ => organ(),
        }
    }
}

/// Semi-axes of the mallet's head; radius and upper end of its handle above the head's middle.
const HEAD: DVec3 = DVec3::new(0.04, 0.022, 0.022);
const HANDLE: (f64, f64) = (0.011, 0.14);

/// A head's ellipsoid, from its lowest point to where the handle leaves it, then the handle and its flat end.
fn mallet() -> Mesh {
    const SIDES: u32 = 112;
    // rings of the head, of the handle's side, of its end
    const RINGS: [u32; 3] = [56, 6, 2];
    let (radius, end) = HANDLE;
    let point = |ring: u32, angle: f64| {
        let (c, s) = (cos(angle), sin(angle));
        let around = |r: f64, z: f64| DVec3::new(r * c, r * s, z);
        // half width of the head in this direction, and how far along its arc the handle begins
        let width = 1.0 / sqrt(c * c / (HEAD.x * HEAD.x) + s * s / (HEAD.y * HEAD.y));
        let seam = PI - asin(radius / width);
        let [head, side, top] = RINGS;
        match ring {
            ring if ring <= head => {
                let along = seam * f64::from(ring) / f64::from(head);
                around(width * sin(along), -HEAD.z * cos(along))
            }
            ring if ring <= head + side => {
                let share = f64::from(ring - head) / f64::from(side);
                let foot = -HEAD.z * cos(seam);
                around(radius, foot + (end - foot) * share)
            }
            ring => around(radius * (1.0 - f64::from(ring - head - side) / f64::from(top)), end),
        }
    };
    loft(RINGS.iter().sum(), SIDES, |ring, side| point(ring, 2.0 * PI * f64::from(side) / f64::from(SIDES)))
}

/// Radius of a leg, length of its axis, and how far it leans; radius of the bow that joins the legs' axes.
const LEG: (f64, f64) = (0.006, 0.09);
/// Sine and cosine of 17 degrees.
const LEAN: (f64, f64) = (0.292_371_704_722_736_7, 0.956_304_755_963_035_4);
const BOW: f64 = 0.009;

/// A tube along an axis that goes up one leg, around the bow and down the other, with half balls on its ends.
fn compass() -> Mesh {
    const SIDES: u32 = 72;
    // rings of a tip, of a leg, of the bow
    const RINGS: [u32; 3] = [18, 4, 24];
    let (radius, length) = LEG;
    let (lean_sin, lean_cos) = LEAN;
    // the axes would meet in the middle, half a leg's rise above the middles of the legs; the bow touches both
    let apex = length / 2.0 * lean_cos;
    let centre = apex - BOW / lean_sin;
    let tip = DVec3::new(length * lean_sin, 0.0, -apex);
    let bow_start = DVec3::new(BOW * lean_cos, 0.0, centre + BOW * lean_sin);
    let [tips, legs, bow] = RINGS;
    let total = 2 * (tips + legs) + bow;
    // place on the axis, direction of the axis, radius, for the first half; the second is its mirror image
    let half = |ring: u32| -> (DVec3, DVec3, f64) {
        let up = DVec3::new(-lean_sin, 0.0, lean_cos);
        if ring <= tips {
            let angle = PI / 2.0 * f64::from(ring) / f64::from(tips);
            return (tip - up * (radius * cos(angle)), up, radius * sin(angle));
        }
        if ring <= tips + legs {
            return (tip.lerp(bow_start, f64::from(ring - tips) / f64::from(legs)), up, radius);
        }
        // from the right leg's end over the top: the normal of the leg, turned up
        let lean = asin(lean_sin);
        let angle = lean + (PI / 2.0 - lean) * f64::from(ring - tips - legs) / f64::from(bow / 2);
        let out = DVec3::new(cos(angle), 0.0, sin(angle));
        (DVec3::Z * centre + out * BOW, DVec3::new(-out.z, 0.0, out.x), radius)
    };
    loft(total, SIDES, |ring, side| {
        let mirrored = ring > total / 2;
        let (place, along, radius) = half(if mirrored { total - ring } else { ring });
        let (place, along) =
            if mirrored { (place * DVec3::new(-1.0, 1.0, 1.0), along * DVec3::new(1.0, 1.0, -1.0)) } else { (place, along) };
        let angle = 2.0 * PI * f64::from(side) / f64::from(SIDES);
        place + (DVec3::Y * cos(angle) + along.cross(DVec3::Y) * sin(angle)) * radius
    })
}

/// Semi-axes of the organ before its bumps.
const ORGAN: DVec3 = DVec3::new(0.065, 0.045, 0.032);

/// The surface with the support function h(n) = |D n| + bumps, n the outward normal: convex because every bump is smaller than the ellipsoid's own bend.
/// A point is the gradient of h; each bump is a product of normal components over the power of |n| that makes it of first degree.
fn organ() -> Mesh {
    const SIDES: u32 = 96;
    const RINGS: u32 = 64;
    // size [m] and powers of x, y, z
    const BUMPS: [(f64, [i32; 3]); 7] = [
        (0.0022, [3, 0, 0]),
        (-0.0016, [1, 0, 1]),
        (0.0015, [1, 1, 0]),
        (0.0014, [2, 1, 0]),
        (-0.0012, [0, 1, 2]),
        (0.0010, [1, 0, 2]),
        (0.0020, [0, 0, 3]),
    ];
    let point = |n: DVec3| {
        let stretched = ORGAN * n;
        let mut place = ORGAN * stretched / sqrt(stretched.length_squared());
        for (size, powers) in BUMPS {
            let degree: i32 = powers.iter().sum();
            let [px, py, pz] = powers.map(|power| power as usize);
            let pow = |value: f64, power: usize| (0..power).fold(1.0, |product, _| product * value);
            let product = pow(n.x, px) * pow(n.y, py) * pow(n.z, pz);
            let slope = |value: f64, power: usize| if power == 0 { 0.0 } else { power as f64 * pow(value, power - 1) };
            let gradient = DVec3::new(
                slope(n.x, px) * pow(n.y, py) * pow(n.z, pz),
                pow(n.x, px) * slope(n.y, py) * pow(n.z, pz),
                pow(n.x, px) * pow(n.y, py) * slope(n.z, pz),
            );
            // of a unit normal: the gradient of product / |n|^(degree - 1)
            place += size * (gradient - n * (product * f64::from(degree - 1)));
        }
        place
    };
    loft(RINGS, SIDES, |ring, side| {
        let (polar, angle) = (PI * f64::from(ring) / f64::from(RINGS), 2.0 * PI * f64::from(side) / f64::from(SIDES));
        point(DVec3::new(sin(polar) * cos(angle), sin(polar) * sin(angle), -cos(polar)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{check, convex, crossings, properties, reduce};

    #[test]
    fn every_model_is_one_sound_solid_within_the_capacity() {
        for model in Model::ALL {
            let mesh = model.mesh();
            let findings = check(&mesh);
            assert!(findings.is_solid() && findings.pieces == 1, "{model:?}: {findings:?}");
            assert_eq!(crossings(&mesh).pairs, 0, "{model:?}");
            assert!(mesh.triangles.len() <= reduce::CAPACITY, "{model:?}: {}", mesh.triangles.len());
        }
    }

    #[test]
    fn the_organ_is_convex_and_has_no_symmetry() {
        let organ = Model::Organ.mesh();
        let hollow = convex::hollow(&organ).unwrap();
        // as far as four corners of a ring pair lie off a plane
        assert!(hollow.share < 2e-4, "{hollow:?}");
        let (low, high) = organ.bounds().unwrap();
        let centre = properties(&organ).unwrap().centre;
        let off = (centre - (low + high) / 2.0).abs();
        assert!(off.x > 1e-4 && off.y > 1e-4 && off.z > 1e-4, "{off}");
    }

    #[test]
    fn mallet_and_compass_have_the_measures_of_their_scenes() {
        let (low, high) = Model::Mallet.mesh().bounds().unwrap();
        assert!((low.z + 0.022).abs() < 1e-9 && (high - low).distance(DVec3::new(0.08, 0.044, 0.162)) < 1e-4, "{low} {high}");
        let compass = Model::Compass.mesh();
        let (low, high) = compass.bounds().unwrap();
        // tips 2 x 90 mm x sin 17 degrees apart
        assert!((high.x - low.x - 0.18 * LEAN.0 - 0.012).abs() < 1e-4 && (high.y - 0.006).abs() < 1e-9, "{low} {high}");
        let hollow = convex::hollow(&compass).unwrap();
        // no deeper than half its thickness, because its hull is a slab
        assert!((hollow.depth - 0.006).abs() < 2e-4, "{hollow:?}");
    }
}
