//! The session that also runs on the emulated Cortex-M7 (`cargo xtask m7`) gives the same bits here, in every profile.

#[path = "../support/bits.rs"]
mod session;

#[test]
fn the_session_of_the_cortex_m7_gives_its_digest_here() {
    let found = session::session();
    assert_eq!(found, session::EXPECTED, "found {found:#018x}: the physics changed, or a machine's own arithmetic slipped in");
}
