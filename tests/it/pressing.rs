//! Cases in which a part that is pressed deeper once lost its force: each by the cause that was mended.

use haptor_tests::extremes::laws::Law;
use haptor_tests::extremes::run::judge;

/// Every case measures its law and keeps it.
fn keep(law: Law, seeds: &[u64]) {
    for &seed in seeds {
        let (case, outcome) = judge(law, seed);
        let (figure, bound) = (outcome.figure.expect("a figure"), law.bound(case.twin.params.tier));
        assert!(outcome.seen.fault.is_none() && figure <= bound, "{seed:016x}: {figure} above {bound}, {:?}", outcome.seen.fault);
    }
}

/// The near face of a pair became the far one at once: over the middle of a small box the normal leaned to one side of a wide flat.
#[test]
fn a_wide_flat_over_a_small_box_keeps_its_force() {
    keep(Law::Deeper, &[0xda63_4176_5591_0c44, 0xf0a7_7881_747e_eb4b, 0x4734_4ad9_b037_10fe]);
    keep(Law::Continuous, &[0x14da_a310_d743_fa2b, 0x88cf_3458_fbf5_e323]);
}

/// A sliver of a slice, hundreds of times longer than wide, was seen by twelve rays from its middle: an edge that it crosses elsewhere was missed.
#[test]
fn a_rim_or_an_edge_across_an_edge_keeps_its_force() {
    keep(Law::Deeper, &[0x6d50_da9a_2e50_de5d, 0xe977_cd9e_103d_9f44, 0x381e_439b_64b9_e5d4, 0x0566_7688_42ad_8569]);
}

/// The lower end of a cylinder was taken for its round side, with whatever curvature the rounding of a normal made.
#[test]
fn a_flat_on_the_lower_end_of_a_cylinder_keeps_its_force() {
    keep(Law::Deeper, &[0x9310_18f6_5c6f_ada6]);
}
