//! What the memory of a tick takes, on a PC and on a Cortex-M7: one list.

use haptor_contact::{Model, Params, Patch, Scratch, State};

use crate::bench::FullState;

/// What, and its bytes.
pub fn all() -> [(&'static str, usize); 14] {
    [
        ("`Model`", size_of::<Model<'_>>()),
        ("`Params`", size_of::<Params>()),
        ("`Patch`, in `State` once per part", size_of::<Patch>()),
        ("`State<1, 0>`: one part, no friction or tiers `point` and `paper`: no samples", size_of::<State<1, 0, 0>>()),
        ("`State<1, 64>`: one part, `bristle` 64", size_of::<State<1, 64, 0>>()),
        ("`State<1, 80, 80>`: one part, `influence` 52", size_of::<State<1, 80, 80>>()),
        ("`State<10, 0>`: ten parts, no samples", size_of::<State<10, 0, 0>>()),
        ("`State<10, 64>`: ten parts, `bristle` 64", size_of::<State<10, 64, 0>>()),
        ("`State<10, 80, 80>`: ten parts, `influence` 52", size_of::<State<10, 80, 80>>()),
        ("`State<16, 64>`: every probe, `bristle` 64", size_of::<State<16, 64, 0>>()),
        ("`State<16, 256, 256>`: every probe, every tier, the host's", size_of::<FullState>()),
        ("`Scratch<1>`", size_of::<Scratch<1>>()),
        ("`Scratch<10>`", size_of::<Scratch<10>>()),
        ("`Scratch<16>`: the host's", size_of::<Scratch<16>>()),
    ]
}
