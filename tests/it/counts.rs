//! A tick costs what the committed table says, and only what its scene requires: counted in instructions, so that no machine's speed
//! and no neighbour on it can change the answer.
//!
//! The table is `tests/bench/COUNTS.md`. A count may fall; when it grows by more than 2 % the change that made it grow says so by
//! writing the table anew.

use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use crate::cli::{released, root};

#[path = "../support/counts.rs"]
pub mod counting;
#[path = "../support/growth.rs"]
mod growth;

use counting::Counted;

/// Command that writes the table.
const COMMAND: &str = "cargo xtask counts";

/// Columns of the table that may not grow \[instructions\].
const UNITS: [&str; 2] = ["mean", "worst"];

/// Every scene by its name, counted once for all tests.
fn counted() -> &'static HashMap<String, Counted> {
    static DONE: OnceLock<HashMap<String, Counted>> = OnceLock::new();
    DONE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let all = counting::count(&released(counting::PROGRAM, counting::PROGRAM), folder.path())
            .unwrap_or_else(|said| panic!("{said}"));
        all.into_iter().map(|case| (case.name.clone(), case)).collect()
    })
}

fn case(name: &str) -> &'static Counted {
    counted().get(name).unwrap_or_else(|| panic!("there is no scene {name:?}; the list is in tests/counts/cases.rs"))
}

fn mean(name: &str) -> u64 {
    case(name).mean()
}

#[test]
fn no_count_grew_beyond_the_table() {
    let file = counting::table_file(Path::new(root()));
    let table = fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}; make it: {COMMAND}", file.display()));
    let table = growth::rows(&table, UNITS.len());
    assert!(!table.is_empty(), "{} has no counts; make it: {COMMAND}", file.display());
    let found: Vec<_> = counted().values().map(|case| (case.name.clone(), vec![case.mean(), case.worst])).collect();
    let grown = growth::complaints(&table, &found, &UNITS);
    assert!(grown.is_empty(), "{}\nif this is the price of something: {COMMAND}", grown.join("\n"));
}

/// Friction, bodies, regions and turns of the combinations.
fn combinations() -> impl Iterator<Item = (&'static str, String)> {
    let frictions = ["no friction", "point", "paper 64", "bristle 64", "influence 52"];
    let rest = ["half space", "box"].into_iter().flat_map(|body| {
        ["one region", "ten regions"]
            .into_iter()
            .flat_map(move |count| ["slide", "twist"].map(|turn| format!("{body}, {count}, {turn}")))
    });
    rest.flat_map(move |rest| frictions.map(|friction| (friction, rest.clone())))
}

/// Files of the core in which a scene without the feature spends not one instruction.
fn unused(friction: &str, rest: &str) -> Vec<&'static str> {
    let mut files = match friction {
        "no friction" => vec!["tier/"],
        "point" => vec!["tier/paper", "tier/bristle", "tier/influence"],
        "paper 64" => vec!["tier/point", "tier/bristle", "tier/influence"],
        "bristle 64" => vec!["tier/paper", "tier/influence"],
        _ => vec!["tier/paper", "tier/point", "tier/bristle/slip", "tier/bristle/stiffness"],
    };
    // every scene here has handle and probe in one
    files.extend(["coupling/spring", "coupling/integrate", "coupling/stiffness", "coupling/sym", "coupling/inertia"]);
    if rest.contains("one region") {
        // coupling of regions, and the surface that nobody looks at
        files.extend(["stage/deform", "surface/"]);
    }
    if rest.contains("half space, one region") {
        files.push("green/");
    }
    files
}

#[test]
fn a_feature_that_a_scene_does_not_use_costs_it_no_instruction() {
    for (friction, rest) in combinations() {
        let name = format!("{friction}, {rest}");
        for file in unused(friction, &rest) {
            assert_eq!(case(&name).within(&[file]), 0, "{name}: instructions of {file}");
        }
    }
    for name in ["no contact, one part", "no contact, ten parts", "base, held still"] {
        for file in ["tier/", "stage/deform", "surface/", "green/", "footprint", "profile/", "body.rs"] {
            assert_eq!(case(name).within(&[file]), 0, "{name}: instructions of {file}, which acts in contacts that move");
        }
    }
}

/// The tier of a scene without friction means nothing to it, to the instruction.
#[test]
fn without_friction_every_tier_costs_the_same() {
    let [default, influence] = ["no friction, half space, one region, twist", "base, no friction, tier influence"].map(case);
    assert_eq!((default.total, default.worst), (influence.total, influence.worst));
}

/// What remains of a feature that is off: the look whether it is on, and what the compiler put elsewhere because it is there.
const TO_LOOK: u64 = 64;

#[test]
fn less_never_costs_more() {
    for (friction, rest) in combinations() {
        let without = mean(&format!("no friction, {rest}"));
        assert!(without <= mean(&format!("{friction}, {rest}")), "{friction}, {rest}: {without} without friction");
    }
    for friction in ["no friction", "point", "paper 64", "bristle 64", "influence 52"] {
        for turn in ["slide", "twist"] {
            let of = |rest: &str| mean(&format!("{friction}, {rest}, {turn}"));
            assert!(of("half space, one region") <= of("box, one region"), "{friction} {turn}: the box costs less than no body");
            assert!(
                of("half space, ten regions") <= of("box, ten regions"),
                "{friction} {turn}: the box costs less than no body"
            );
            assert!(
                of("half space, one region") <= of("half space, ten regions") / 2,
                "{friction} {turn}: one region as much as ten"
            );
        }
    }
    let base = mean("base");
    assert!(base <= mean("base, gravity") + TO_LOOK && mean("base, gravity") <= base + TO_LOOK, "gravity is one sum");
    assert!(mean("base, guard without limits") <= base + TO_LOOK, "a guard without limits costs more than one with");
    assert!(mean("base, bristle 16") < base && base < mean("base, bristle 256"), "samples cost");
}

/// Most instructions of a tick that only looks, follows and presses: a tenth of a tick of tier `bristle`.
const WITHOUT_FRICTION: u64 = 4_500;

/// Most instructions of a tick whose pose is that of the tick before.
const STILL: u64 = 800;

#[test]
fn what_does_little_costs_little() {
    for rest in
        ["half space, one region, slide", "half space, one region, twist", "box, one region, slide", "box, one region, twist"]
    {
        let worst = case(&format!("no friction, {rest}")).worst;
        assert!(worst <= WITHOUT_FRICTION, "no friction, {rest}: {worst}");
    }
    let still = case("base, held still").worst;
    assert!(still <= STILL, "held still: {still}");
}

/// Instructions of body and ground in a tick on a half space, which has neither: the looks whether there is one.
#[test]
fn a_half_space_pays_for_no_body() {
    for friction in ["no friction", "point", "bristle 64", "influence 52"] {
        let case = case(&format!("{friction}, half space, one region, twist"));
        let spent = case.within(&["body.rs", "stage/ground"]) / case.calls;
        assert!(spent <= 2 * TO_LOOK, "{friction}: {spent} instructions");
    }
}
