//! Scenes, paths and tolerances that the tests share.

pub mod ball;
pub mod drive;
pub mod exact;
pub mod led;
pub mod noise;
pub mod tables;
