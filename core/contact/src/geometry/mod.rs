//! Where two bodies touch: signed distances, deepest points, curvatures, slices.

pub mod curvature;
pub mod deepest;
pub mod ellipsoid;
pub mod gap;
pub mod slice;
pub mod support;
