//! Stage 5: displacement of the object's surface, where another region asks for it. Without a second region it costs nothing.
//!
//! Closed forms of a half space loaded on a disc (PHYSICS section 4; theory.md, section 4).

use glam::Vec3;

use crate::math::{PI, asin, root};
use crate::model::Model;
use crate::patch::Patch;

/// Displacement into the object \[m\] that `patch` makes at the surface point `p_wq`: the dent of a paraboloid with the same load
/// and radius. Inside the radius the surface follows the probe.
pub fn dent(model: &Model<'_>, patch: &Patch, p_wq: Vec3) -> f32 {
    let (a, load) = (patch.footprint.radius, patch.footprint.load);
    if a <= 0.0 || load <= 0.0 {
        return 0.0;
    }
    let offset = p_wq - patch.centre;
    let along = offset.dot(patch.normal);
    let r2 = offset.length_squared() - along * along;
    // 1/R of the paraboloid with this load and radius: a^3 / R = 3 P / (4 E*)
    let curvature = 0.75 * load / (model.material.contact_modulus() * a * a * a);
    let a2 = a * a;
    if r2 <= a2 {
        return curvature * (a2 - 0.5 * r2);
    }
    let r = root(r2);
    let ratio = a / r;
    if ratio < FAR {
        return curvature * a2 / PI * far_dent(ratio);
    }
    curvature / PI * ((2.0 * a2 - r2) * asin(ratio) + a * root(r2 - a2))
}

/// Radius over distance below which the series of the dent is exact to f32, and where the closed form loses digits to cancellation.
const FAR: f32 = 0.3;

/// (2 - 1/s^2) asin s + sqrt(1 - s^2)/s for small s: its series to s^7.
fn far_dent(s: f32) -> f32 {
    let s2 = s * s;
    s * (4.0 / 3.0 + s2 * (2.0 / 15.0 + s2 * (3.0 / 70.0 + s2 * (5.0 / 252.0))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_meets_the_closed_form() {
        for ratio in [0.05_f64, 0.1, 0.2, 0.3] {
            let exact = (2.0 - 1.0 / (ratio * ratio)) * libm::asin(ratio) + libm::sqrt(1.0 - ratio * ratio) / ratio;
            let series = f64::from(far_dent(ratio as f32));
            assert!((series / exact - 1.0).abs() < 1.0e-6, "{ratio}: {series} {exact}");
        }
    }
}
