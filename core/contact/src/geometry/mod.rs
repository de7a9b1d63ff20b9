//! Where two bodies touch: signed distances, deepest points, curvatures, slices.

pub mod align;
pub mod curvature;
pub mod deepest;
pub mod distance_grid;
pub mod edges;
pub mod ellipsoid;
pub mod faces;
pub mod field;
pub mod gap;
pub mod outline;
pub mod rim;
pub mod share;
pub mod slice;
pub mod support;
pub mod trial;
