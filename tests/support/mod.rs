//! Scenes, paths and tolerances that the tests share.

pub mod drive;
