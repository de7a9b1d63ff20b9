//! The deepest point of a part under an edge or a corner of a box, where the faces share the depth.
//!
//! The depth (sum s_i^-4)^(-1/4) of the slacks s_i is the least of sum w_i s_i over the weights with sum w_i^(4/5) = 1. The deepest point of a
//! convex part is therefore the least, over the weights, of sum w_i h_i + (the part's support against sum w_i n_i): a search over one share at an
//! edge and two at a corner instead of over the part, which finds the normal on flats too (theory.md, equation 2.6). With w_i ~ r_i^5 the **roots** r_i need no
//! norm, and at the least the **moments** r_i s_i of the support point are even: on smooth parts all at once by Broyden's method, on flats by searches of one root
//! within that of another. A capsule is the deepest of the balls along its **spine**.

use core::cell::Cell;

use glam::{Mat2, Vec3};

use crate::geometry::deepest::{Deepest, count};
use crate::geometry::gap::{self, Gap};
use crate::geometry::share::Share;
use crate::geometry::trial::{Trial, fifth};
use crate::math::{clamp, direction, max, min, root};

/// Trials of a share, at most: secants on smooth parts, ties of two corners on flats.
const EDGE_STEPS: usize = 16;

/// Trials of the third root at a corner: secants, then halvings.
const CORNER_STEPS: usize = 16;

/// Trials of these that are secants.
const CORNER_SECANTS: usize = 4;

/// Steps of Broyden's method over three faces: on smooth parts six to ten level the moments, on flats none do.
const BROYDEN_STEPS: usize = 14;

/// The same for a ball, which always settles: beside corners some take sixteen.
const BALL_STEPS: usize = 18;

/// Trials of the place along a spine, at most.
const SPINE_STEPS: usize = 16;

/// Difference of two such places that are as good as one.
const SPINE_SETTLED: f32 = 1.0e-6;

/// Least slack that is guessed from, as a share of the box's smallest half edge: descent may have ended outside.
const LEAST_GUESS: f32 = 0.02;

/// A root that is lower than this, of a face that the point lies beyond, does not come back.
const LOST: f32 = 0.03;

/// Least component of a normal that is guessed: its root is a thirtieth.
const LEAST_NORMAL: f32 = 1.0e-6;

/// A face farther than this many depths has a weight below 1e-3: descent finds such points, and the bound proves it.
pub const FARTHEST: f32 = 4.0;

/// A face that no point of the part comes nearer to than this many depths changes the depth by less than 1e-4.
const CLEAR: f32 = 8.0;

/// How near an edge, in reaches of the part, a descent that found no overlap is not believed.
pub const MISSED: f32 = 0.25;

/// Share of its depth by which a point may miss the deepest.
pub const SETTLED: f32 = 1.0e-3;

/// Share of its depth, and of the object, by which a point that is taken without descent may miss the deepest.
const SURE: f32 = 1.0e-4;
const SURE_SLACK: f32 = 1.0e-7;

/// Sum of the fourth powers of a depth over the slacks of the far faces: they take a quarter of it, two and a half times what a proof allows.
const FAR: f32 = 1.0e-3;

/// Rounding of a slack, as a share of the object: of coordinates up to its half edge, which are a digit of 6e-8 apart. A search that asks for less never ends.
const ROUNDING: f32 = 6.0e-8;

/// Trials before the first tie: on smooth parts secants alone are faster.
const FIRST_TIE: usize = 3;

/// Trials from a tie to the next, twice as many each time it shows a part that is round there.
const TIE_EVERY: usize = 2;

/// Relative difference of two moments that counts as none.
const LEVEL: f32 = 1.0e-6;

/// How far a flat may stand out over a chord of it, as a share of the chord: round parts stand out by more until the chord is a thousandth of their radius.
const ROUND: f32 = 1.0e-4;

/// Distance at which two support points are one, as a share of the object.
const SAME: f32 = 2.0e-7;

/// What the weights of a ball's trial prove of all balls along a spine: the depth lies below this line over the place.
#[derive(Clone, Copy, Debug)]
struct Line {
    /// Place of the ball, 0 to 1.
    at: f32,
    /// Bound there \[m\], to the weights' scale.
    value: f32,
    /// Its change over the whole spine \[m\].
    rise: f32,
}

impl Line {
    /// The bound at another place.
    fn over(&self, at: f32) -> f32 {
        self.value + self.rise * (at - self.at)
    }

    /// True where it is below zero all along.
    fn is_below_zero(&self) -> bool {
        max(self.over(0.0), self.over(1.0)) < 0.0
    }

    /// The place at which it is zero.
    fn zero(&self) -> f32 {
        clamp(self.at - self.value / self.rise, 0.0, 1.0)
    }

    /// True where one that rises and one that falls leave no place at which both are above zero.
    fn meets_below_zero(&self, falling: &Self) -> bool {
        self.zero() >= falling.zero()
    }
}

/// The next place between a line that rises to its zero and one that falls from its: the middle of what they leave.
fn meeting(rising: Option<Line>, falling: Option<Line>) -> f32 {
    0.5 * (rising.map_or(0.0, |line| line.zero()) + falling.map_or(1.0, |line| line.zero()))
}

/// A box about its centre, the signs of the three faces that are near, and the support of the part in the box's frame.
struct Search<F> {
    half: Vec3,
    sign: Vec3,
    /// Descent found no overlap.
    missed: bool,
    /// About how round the part is \[m\].
    round: f32,
    support: F,
}

/// The segment along the middle of a part that is as thick everywhere: a capsule. In world, about the box's centre where a search has it.
#[derive(Clone, Copy, Debug)]
pub struct Spine<'a> {
    /// Its start \[m\].
    pub start: Vec3,
    /// The way to its end \[m\].
    pub way: Vec3,
    /// Radius of the part about it \[m\].
    pub radius: f32,
    /// How often the part was asked for a point.
    pub asked: &'a Cell<u32>,
}

/// The deepest point and the unit normal there, from one found by descent: `at` is its gap, `centre` the box's, `support` the part's farthest point along a direction, in world.
/// `reach` is the radius of the ball that holds the part \[m\], `spine` what it has of one. `None` where the one given is right: away from edges, with a bound on its depth that proves it.
pub fn under_edge(
    half: Vec3,
    centre: Vec3,
    at: &Deepest,
    reach: f32,
    spine: Option<Spine<'_>>,
    support: impl Fn(Vec3) -> Vec3,
) -> Option<(Vec3, Vec3)> {
    let (search, place) = search_about(half, centre, at, spine.map_or(0.0, |spine| spine.radius), support);
    let (slack, depth) = (search.slack(place), -at.gap.distance);
    // balls along a spine are soon proven to keep apart: what descent missed is looked for wherever that ended
    let is_sought = search.missed && spine.is_some();
    if !is_sought && search.is_settled(slack, depth, reach) || search.is_beyond_a_face() {
        return None;
    }
    let found = search.along_or_over_two(spine, centre, place, depth).or_else(|| search.evened(slack));
    let found = found.unwrap_or_else(|| search.over(slack));
    Some((found.point + centre, search.normal(&found)))
}

/// The same from any point of the part, where two faces share the depth and the bound of their weights proves what was found: no descent is needed then.
pub fn over_edge(
    half: Vec3,
    centre: Vec3,
    at: &Deepest,
    spine: Option<Spine<'_>>,
    support: impl Fn(Vec3) -> Vec3,
) -> Option<Deepest> {
    let (search, place) = search_about(half, centre, at, 0.0, support);
    if search.missed || search.is_beyond_proof(-at.gap.distance) {
        return None;
    }
    let found = search.along_or_over_two(spine, centre, place, -at.gap.distance)?;
    let distance = gap::of_box(half, found.point).distance;
    let is_sure = distance <= at.gap.distance && search.is_proven(&found, -distance);
    is_sure.then(|| Deepest { point: found.point + centre, gap: Gap { distance, normal: search.normal(&found) } })
}

/// A search about a point of the part, and that point from the box's centre; `support` in world.
fn search_about<S: Fn(Vec3) -> Vec3>(
    half: Vec3,
    centre: Vec3,
    at: &Deepest,
    round: f32,
    support: S,
) -> (Search<impl Fn(Vec3) -> Vec3>, Vec3) {
    let place = at.point - centre;
    let sign = place.map(|x| if x < 0.0 { -1.0 } else { 1.0 });
    (Search { half, sign, missed: at.gap.distance >= 0.0, round, support: move |d: Vec3| support(d) - centre }, place)
}

impl<F: Fn(Vec3) -> Vec3> Search<F> {
    /// Slacks of a place.
    fn slack(&self, place: Vec3) -> Vec3 {
        self.half - self.sign * place
    }

    /// What weights with their norm say of the whole part: no point of it is deeper.
    fn bound(&self, weights: Vec3) -> f32 {
        weights.dot(self.slack((self.support)(-(weights * self.sign))))
    }

    /// True when only one face is near and the depth found there meets the bound that its weights give from above.
    fn is_settled(&self, slack: Vec3, depth: f32, reach: f32) -> bool {
        // a descent that found no overlap may have missed a shallow one by an edge
        let far = if depth > 0.0 { FARTHEST * depth } else { MISSED * reach };
        if slack.to_array().into_iter().filter(|&s| s < far).count() > 1 {
            return false;
        }
        if depth <= 0.0 {
            return true;
        }
        let share = Vec3::splat(depth) / slack;
        let weights = share * share * share * share * share;
        self.bound(weights) - depth <= SETTLED * depth
    }

    /// True where the moments of a trial over two faces are even, and the depth of its point meets the bound that its weights give from above.
    fn is_proven(&self, trial: &Trial, depth: f32) -> bool {
        let (moments, weights, size) = (trial.moments(), trial.weights(), self.half.max_element());
        let uneven = 2.0 * moments.max_element() - moments.element_sum();
        let bound = self.bound(weights);
        uneven <= SURE * moments.max_element() + ROUNDING * size && bound - depth <= max(SURE * bound, SURE_SLACK * size)
    }

    /// True where nothing that is at least so deep is proven by near faces alone: the far ones, no farther than the box is wide less the depth, take more of it than a proof allows.
    fn is_beyond_proof(&self, depth: f32) -> bool {
        let share = Vec3::splat(depth) / (2.0 * self.half - depth);
        (share * share).length_squared() > FAR && SURE * depth > SURE_SLACK * self.half.max_element()
    }

    /// True where descent found no overlap because the whole part lies beyond one of the faces.
    fn is_beyond_a_face(&self) -> bool {
        self.missed && [Vec3::X, Vec3::Y, Vec3::Z].into_iter().any(|axis| self.inmost(axis) < 0.0)
    }

    /// Largest slack of the part to the face across this axis.
    fn inmost(&self, axis: Vec3) -> f32 {
        self.slack((self.support)(-(self.sign * axis))).dot(axis)
    }

    /// From a place of the part, inside both where this depth is above zero: along a spine in world, else over two faces.
    fn along_or_over_two(&self, spine: Option<Spine<'_>>, centre: Vec3, place: Vec3, depth: f32) -> Option<Trial> {
        let spine = spine.map(|spine| Spine { start: spine.start - centre, ..spine });
        let along = |spine: Spine<'_>| {
            if depth > 0.0 { self.along(&spine, place, self.inverse(self.slack(place))) } else { self.inside(&spine) }
        };
        spine.and_then(along).or_else(|| self.over_two(self.slack(place), depth))
    }

    /// Over all on a part with a spine of which no point inside is known: where the lines that two balls beside the box prove to lie above the depth meet, until a ball lies inside, or
    /// the lines meet below zero, which proves that the part keeps apart (theory.md, equation 2.10); `None` where a ball does not settle.
    fn inside(&self, spine: &Spine<'_>) -> Option<Trial> {
        let (mut before, mut after) = (None, None);
        for _ in 0..SPINE_STEPS {
            let at = meeting(before, after);
            let trial = self.ball_or_apart(spine, at, None)?;
            if !is_beside(&trial) {
                return self.along(spine, spine.start + spine.way * at, trial.roots);
            }
            let weights = fifth(trial.roots);
            let line = Line { at, value: weights.dot(trial.slack), rise: -weights.dot(self.sign * spine.way) };
            let side = if line.rise > 0.0 { &mut before } else { &mut after };
            *side = Some(line);
            if line.is_below_zero() || before.zip(after).is_some_and(|(one, other)| one.meets_below_zero(&other)) {
                return Some(trial);
            }
        }
        None
    }

    /// Over two faces, where the whole part keeps clear of the third.
    fn over_two(&self, slack: Vec3, depth: f32) -> Option<Trial> {
        let clear = |axis: Vec3| self.slack((self.support)(self.sign * axis)).dot(axis) > CLEAR * depth;
        if depth > 0.0 && clear(Vec3::Z) {
            Some(self.split::<X, Y>(Vec3::ZERO, even(slack.x, slack.y)))
        } else if depth > 0.0 && clear(Vec3::X) {
            Some(self.split::<Y, Z>(Vec3::ZERO, even(slack.y, slack.z)))
        } else if depth > 0.0 && clear(Vec3::Y) {
            Some(self.split::<Z, X>(Vec3::ZERO, even(slack.z, slack.x)))
        } else {
            None
        }
    }

    /// Over all at once, by Broyden's method from a guess of the slacks; `None` where the moments do not settle, as on flats.
    fn evened(&self, slack: Vec3) -> Option<Trial> {
        self.evened_from(self.inverse(slack), BROYDEN_STEPS)
    }

    /// The roots, to their scale, that these slacks make even.
    fn inverse(&self, slack: Vec3) -> Vec3 {
        let least = LEAST_GUESS * self.half.min_element();
        slack.map(|s| 1.0 / max(s, least))
    }

    /// The same from a guess of the roots, to their scale, in so many steps.
    fn evened_from(&self, guess: Vec3, steps: usize) -> Option<Trial> {
        let mut last = self.trial(guess / guess.element_sum());
        let mut lead = last.leads();
        let mut slopes = last.slopes(self.round);
        for _ in 0..steps {
            if self.is_apart(&last) || self.is_level(&last) {
                return Some(last);
            }
            if self.missed && last.slack.min_element() < 0.0 && is_lost(&last) {
                return None;
            }
            let step = last.kept_inside(-(slopes.inverse() * lead));
            last = self.trial(last.roots + Vec3::new(step.x, step.y, -step.x - step.y));
            let (before, now) = (lead, last.leads());
            let missed = now - before - slopes * step;
            let along = step / step.length_squared();
            slopes += Mat2::from_cols(missed * along.x, missed * along.y);
            lead = now;
            if !lead.is_finite() {
                return None;
            }
        }
        None
    }

    /// Over all on a part with a spine, from a point inside both: the deepest of the balls along it, where the depth changes no more or an end is met; `None` where
    /// balls do not settle.
    fn along(&self, spine: &Spine<'_>, place: Vec3, guess: Vec3) -> Option<Trial> {
        let lead = |trial: &Trial| fifth(trial.roots).dot(self.sign * spine.way);
        let mut near = clamp((place - spine.start).dot(spine.way) / spine.way.length_squared(), 0.0, 1.0);
        let mut last = self.ball(spine, near, guess)?;
        // the depth is concave along the spine and grows towards this end
        let mut far = if lead(&last) > 0.0 { 0.0 } else { 1.0 };
        if near == far {
            return Some(last);
        }
        let mut share = spanning(near, far, lead(&last), last);
        if let Some(end) = self.ball(spine, far, last.roots) {
            if (lead(&end) > 0.0) == (lead(&last) > 0.0) {
                return Some(end);
            }
            share.take(far, lead(&end), end);
        }
        for _ in 0..SPINE_STEPS {
            let at = share.next(share.middle());
            let Some(trial) = self.ball(spine, at, last.roots) else {
                // a ball beside the box: the deepest lies on this side of it
                far = at;
                share = spanning(near, far, lead(&last), last);
                continue;
            };
            if (at - near).abs() <= SPINE_SETTLED {
                return Some(trial);
            }
            (near, last) = (at, trial);
            share.take(at, lead(&trial), trial);
        }
        None
    }

    /// The deepest point of the ball at this place of a spine, from a guess of its roots, to their scale, such as those of a ball beside it; `None` where it keeps apart or does not settle.
    fn ball(&self, spine: &Spine<'_>, at: f32, guess: Vec3) -> Option<Trial> {
        self.ball_or_apart(spine, at, Some(guess)).filter(|trial| !is_beside(trial))
    }

    /// The same, or what proves that the ball keeps apart: the face that all of it lies beyond, where there is one.
    fn ball_or_apart(&self, spine: &Spine<'_>, at: f32, guess: Option<Vec3>) -> Option<Trial> {
        let (ball, slack) = (self.of_ball(spine, at), self.slack(spine.start + spine.way * at));
        if slack.min_element() + spine.radius > 0.0 {
            let from_its_middle = || ball.evened_from(self.roots_of_ball(slack, spine.radius), BALL_STEPS);
            return guess.and_then(|guess| ball.evened_from(guess, BALL_STEPS)).or_else(from_its_middle);
        }
        let axes = [Vec3::X, Vec3::Y, Vec3::Z].into_iter();
        axes.reduce(|best, axis| if slack.dot(axis) < slack.dot(best) { axis } else { best }).map(|axis| ball.trial(axis))
    }

    /// A guess of a ball's roots, to their scale, from its middle's slacks: where that lies outside, the normal is about that of the box's point next to it.
    fn roots_of_ball(&self, slack: Vec3, radius: f32) -> Vec3 {
        let outside = (-slack).max(Vec3::ZERO);
        if outside == Vec3::ZERO { self.inverse(slack) } else { outside.map(|n| root(root(max(n / radius, LEAST_NORMAL)))) }
    }

    /// The search for the deepest point of the ball at this place of a spine, which may lie beside the box.
    fn of_ball(&self, spine: &Spine<'_>, at: f32) -> Search<impl Fn(Vec3) -> Vec3> {
        let centre = spine.start + spine.way * at;
        let support = move |d: Vec3| count(spine.asked, 1, centre + direction(d, Vec3::Z) * spine.radius);
        Search { half: self.half, sign: self.sign, missed: true, round: spine.radius, support }
    }

    /// True where a trial proves that part and box keep apart: its weights bound the depth from above.
    fn is_apart(&self, trial: &Trial) -> bool {
        self.missed && trial.slack.min_element() < 0.0 && fifth(trial.roots).dot(trial.slack) < 0.0
    }

    /// True where all three moments are even and the point lies inside.
    fn is_level(&self, trial: &Trial) -> bool {
        let (moments, size) = (trial.moments(), self.half.max_element());
        trial.slack.min_element() > 0.0 && is_even(moments.x, moments.z, size) && is_even(moments.y, moments.z, size)
    }

    /// Over all: the third root by its moment against that of the best split of the rest.
    fn over(&self, slack: Vec3) -> Trial {
        let guess = even(slack.x, slack.y);
        let split = |up: f32| self.split::<X, Y>(Vec3::Z * up, guess);
        let terms = |trial: &Trial| (trial.moments().z, level(trial));
        let mut up = Share::new(0.0, 1.0);
        for step in 0..CORNER_STEPS {
            let at = if step < CORNER_SECANTS { up.next(0.5) } else { up.middle() };
            let trial = split(at);
            let (one, two) = terms(&trial);
            up.take(at, one - two, trial);
            if self.is_apart(&trial) || is_even(one, two, self.half.max_element()) {
                return trial;
            }
        }
        let last = split(up.next(0.5));
        self.between(&up, last, |trial| terms(trial).0 - terms(trial).1)
    }

    /// Best split between two faces of what `rest`, the root of the third, leaves, from a guess of the first one's share.
    fn split<const FIRST: usize, const SECOND: usize>(&self, rest: Vec3, guess: f32) -> Trial {
        let whole = 1.0 - rest.element_sum();
        let roots = |share: f32| put::<SECOND>(put::<FIRST>(rest, share * whole), (1.0 - share) * whole);
        let terms = |trial: &Trial| (pick::<FIRST>(trial.moments()), pick::<SECOND>(trial.moments()));
        let lead = |trial: &Trial| terms(trial).0 - terms(trial).1;
        let mut share = Share::<Trial>::new(0.0, 1.0);
        let mut at = share.next(guess);
        let mut last = self.trial(roots(at));
        let (mut tied, mut wait) = (FIRST_TIE, TIE_EVERY);
        for step in 0..EDGE_STEPS {
            let (one, two) = terms(&last);
            share.take(at, one - two, last);
            if self.is_apart(&last) || is_even(one, two, self.half.max_element()) {
                return last;
            }
            let tie = if step == tied { tie(&share, roots) } else { None };
            at = tie.unwrap_or_else(|| share.next(even(pick::<FIRST>(last.slack), pick::<SECOND>(last.slack))));
            last = self.trial(roots(at));
            let ended = |(before, after)| self.is_same(&before, &last) || self.is_same(&after, &last);
            if tie.is_some() && share.ends().is_some_and(ended) {
                break;
            }
            if step == tied {
                wait = if self.is_flat(&share, &last) { TIE_EVERY } else { 2 * wait };
                tied += wait;
            }
        }
        if self.is_flat(&share, &last) { self.between(&share, last, lead) } else { evenest(&share, last, lead) }
    }

    /// True where the support point of a trial lies on the way between the ends of its bracket, as on a flat, and not out over it, as on a round part.
    fn is_flat(&self, share: &Share<Trial>, trial: &Trial) -> bool {
        share.ends().is_none_or(|(before, after)| {
            let weights = direction(fifth(trial.roots), Vec3::Z);
            let over = weights.dot(trial.slack) - max(weights.dot(before.slack), weights.dot(after.slack));
            let way = root((after.slack - before.slack).length_squared());
            over <= ROUND * way + SAME * self.half.max_element()
        })
    }

    fn is_same(&self, one: &Trial, two: &Trial) -> bool {
        (one.slack - two.slack).abs().max_element() <= SAME * self.half.max_element()
    }

    /// At the last roots, the point between the two ends at which the lead vanishes: where a flat lies on the normal, the support jumps from end to end.
    fn between(&self, share: &Share<Trial>, last: Trial, lead: impl Fn(&Trial) -> f32) -> Trial {
        let Some((before, after)) = share.ends() else { return last };
        let at = |point: Vec3| lead(&self.seen(last.roots, point));
        self.seen(last.roots, between(before.point, at(before.point), after.point, at(after.point)))
    }

    /// The normal that the weights of a trial say, less what the far faces have in the depth. Beside a shallow contact the slacks of its point have few digits, which the gap's normal there takes to the fifth
    /// power; the weights are as sure as the directions that the search told apart, in which a flat lies on its edge.
    fn normal(&self, trial: &Trial) -> Vec3 {
        let near = trial.weights();
        let depth = near.dot(trial.slack);
        let far = fifth(Vec3::splat(depth) / (2.0 * self.half - trial.slack));
        direction((near - far) * self.sign, Vec3::Z)
    }

    fn trial(&self, roots: Vec3) -> Trial {
        self.seen(roots, (self.support)(-(fifth(roots) * self.sign)))
    }

    fn seen(&self, roots: Vec3, point: Vec3) -> Trial {
        Trial { roots, point, slack: self.half - self.sign * point }
    }
}

/// True where a search runs to where a face that its point lies beyond means nothing: the moments are even there, too.
fn is_lost(trial: &Trial) -> bool {
    let lost = |slack: f32, root: f32| slack < 0.0 && root < LOST;
    lost(trial.slack.x, trial.roots.x) || lost(trial.slack.y, trial.roots.y) || lost(trial.slack.z, trial.roots.z)
}

/// True for the trial of a ball that keeps apart: its weights bound the depth from above.
fn is_beside(trial: &Trial) -> bool {
    trial.slack.min_element() <= 0.0 && fifth(trial.roots).dot(trial.slack) <= 0.0
}

/// Where the support points before and after the change of sign are as far against the roots of a share.
fn tie(share: &Share<Trial>, roots: impl Fn(f32) -> Vec3) -> Option<f32> {
    let (before, after) = share.ends()?;
    let more = before.slack - after.slack;
    share.tie(|at| fifth(roots(at)).dot(more))
}

/// Mean moment of the first two faces, by their shares: where one has none, it is the other's.
fn level(trial: &Trial) -> f32 {
    let (moments, squares) = (trial.moments(), trial.roots * trial.roots);
    let shares = squares * squares;
    (moments.x * shares.x + moments.y * shares.y) / max(shares.x + shares.y, f32::MIN_POSITIVE)
}

/// True for moments that are the same to rounding, at an object of this size: on smooth parts the search ends there.
fn is_even(one: f32, two: f32, size: f32) -> bool {
    (one - two).abs() <= LEVEL * max(one.abs(), two.abs()) + ROUNDING * size
}

/// Of the last trial and the ends of a bracket the one whose moments are the most even.
fn evenest(share: &Share<Trial>, last: Trial, lead: impl Fn(&Trial) -> f32) -> Trial {
    let Some((before, after)) = share.ends() else { return last };
    let more_even = |one: Trial, other: Trial| if lead(&other).abs() < lead(&one).abs() { other } else { one };
    more_even(more_even(last, before), after)
}

/// The bracket between two places, of which the near one has been seen.
fn spanning(near: f32, far: f32, lead: f32, seen: Trial) -> Share<Trial> {
    let mut share = Share::new(min(near, far), max(near, far));
    share.take(near, lead, seen);
    share
}

/// The first of two shares whose moments are even for these slacks.
fn even(one: f32, two: f32) -> f32 {
    if one > 0.0 && two > 0.0 {
        two / (one + two)
    } else if one < two {
        1.0
    } else {
        0.0
    }
}

/// The axes by number, for searches that are compiled for a pair of them.
const X: usize = 0;
const Y: usize = 1;
const Z: usize = 2;

fn pick<const AXIS: usize>(v: Vec3) -> f32 {
    match AXIS {
        X => v.x,
        Y => v.y,
        _ => v.z,
    }
}

fn put<const AXIS: usize>(v: Vec3, value: f32) -> Vec3 {
    match AXIS {
        X => v.with_x(value),
        Y => v.with_y(value),
        _ => v.with_z(value),
    }
}

/// The point between two support points at which a lead that is `a` at one and `b` at the other vanishes.
pub fn between(p: Vec3, a: f32, q: Vec3, b: f32) -> Vec3 {
    let share = if a < b { clamp(b / (b - a), 0.0, 1.0) } else { 0.5 };
    p * share + q * (1.0 - share)
}
