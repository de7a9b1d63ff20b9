//! Scripted motions: a list of moves, each from rest to rest, one after the other.
//!
//! The probe is led by four numbers: depth below first touch, angle about world z through its mass centre, shift along x and y.
//! A [`Move`] leads some of them to new values; the others stay. Minimum jerk, so that neither speed nor acceleration jumps.

use std::str::FromStr;

use haptor_contact::geometry::deepest::{deepest, part_pose};
use haptor_contact::{ObjectShape, Pose, ProbePart, Quat, Vec3};

/// Where the probe is led to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Depth below first touch \[m\]; negative is above.
    pub depth: f64,
    /// Angle about z \[rad\].
    pub angle: f64,
    /// Shift along x and y \[m\].
    pub shift: [f64; 2],
}

impl Place {
    /// Above first touch, unturned.
    pub const START: Self = Self { depth: -CLEARANCE, angle: 0.0, shift: [0.0; 2] };

    fn between(self, end: Self, share: f64) -> Self {
        let mix = |from: f64, to: f64| from + (to - from) * share;
        Self {
            depth: mix(self.depth, end.depth),
            angle: mix(self.angle, end.angle),
            shift: [mix(self.shift[0], end.shift[0]), mix(self.shift[1], end.shift[1])],
        }
    }
}

/// Height above first touch where a motion starts and ends \[m\].
pub const CLEARANCE: f64 = 0.001;

/// Time of a move that gives none \[s\].
const MOVE_TIME: f64 = 0.2;

/// Longest move \[s\]: a table of an hour at the highest rate still fits a disk.
const MAX_TIME: f64 = 3600.0;

/// Which numbers a move leads, and where to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Goal {
    Depth(f64),
    Angle(f64),
    Shift([f64; 2]),
    Hold,
}

/// One move, `NAME[=VALUE][@SECONDS]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Move {
    goal: Goal,
    seconds: f64,
}

impl Move {
    fn end(&self, start: Place) -> Place {
        match self.goal {
            Goal::Depth(depth) => Place { depth, ..start },
            Goal::Angle(angle) => Place { angle, ..start },
            Goal::Shift(shift) => Place { shift, ..start },
            Goal::Hold => start,
        }
    }
}

/// Length of a motion \[s\].
pub fn seconds(moves: &[Move]) -> f64 {
    moves.iter().map(|part| part.seconds).sum()
}

/// Where the probe is at time t \[s\].
pub fn place(moves: &[Move], t: f64) -> Place {
    let (mut place, mut left) = (Place::START, t);
    for part in moves {
        let share = if part.seconds > 0.0 { minimum_jerk(left / part.seconds) } else { 1.0 };
        place = place.between(part.end(place), share);
        left -= part.seconds;
        if left <= 0.0 {
            break;
        }
    }
    place
}

/// Share of a move done after the share s of its time: rest to rest with the least jerk (Flash and Hogan 1985).
pub fn minimum_jerk(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
}

impl FromStr for Move {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (goal, seconds) = text.split_once('@').map_or((text, None), |(goal, seconds)| (goal, Some(seconds)));
        let seconds = seconds.map_or(Ok(MOVE_TIME), |text| number(text, 0.0..=MAX_TIME, "0 to 3600 s"))?;
        let (name, value) = goal.split_once('=').map_or((goal, None), |(name, value)| (name, Some(value)));
        let goal = match (name, value) {
            ("press", Some(depth)) => Goal::Depth(number(depth, -1.0..=1.0, "-1 to 1 m")?),
            ("twist", Some(angle)) => Goal::Angle(number(angle, -1.0e3..=1.0e3, "-1e3 to 1e3 rad")?),
            ("slide", Some(shift)) => Goal::Shift(pair(shift)?),
            ("lift", None) => Goal::Depth(-CLEARANCE),
            ("hold", None) => Goal::Hold,
            _ => return Err("allowed is press=M, twist=RAD, slide=M or slide=M,M, hold, lift, each with @SECONDS".to_owned()),
        };
        Ok(Self { goal, seconds })
    }
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let shift = |text| number(text, -10.0..=10.0, "-10 to 10 m");
    let (x, y) = text.split_once(',').unwrap_or((text, "0"));
    Ok([shift(x)?, shift(y)?])
}

fn number(text: &str, range: std::ops::RangeInclusive<f64>, allowed: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("{text:?} is not a number; allowed is {allowed}"))?;
    if range.contains(&value) { Ok(value) } else { Err(format!("{text}: allowed is {allowed}")) }
}

/// Halvings of the bracket of the first touch: from a metre to less than f32 resolves there.
const HALVINGS: u32 = 40;

/// Height of the unturned probe's origin at which a part first touches the object on the way down, x = y = 0 \[m\].
///
/// `clear` is a height at which nothing touches: that of the lowest point level with the object's top will do. Beside the top, as
/// with the legs of a compass on an ellipsoid, first touch is lower.
pub fn first_touch(object: &ObjectShape<'_>, parts: &[ProbePart<'_>], clear: f32) -> f32 {
    let touches = |height: f64| {
        let x_wp = Pose::new(Vec3::new(0.0, 0.0, height as f32), Quat::IDENTITY);
        parts.iter().any(|part| deepest(object, part, &part_pose(part, &x_wp)).gap.distance < 0.0)
    };
    let (mut above, mut below) = (f64::from(clear), f64::from(clear) - f64::from(object.height()));
    if !touches(below) {
        return clear;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (above + below);
        if touches(middle) {
            below = middle;
        } else {
            above = middle;
        }
    }
    above as f32
}

#[cfg(test)]
mod tests {
    use haptor_contact::ProbeShape;

    use super::*;

    fn moves(texts: &[&str]) -> Vec<Move> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn moves_follow_each_other_and_keep_what_they_do_not_lead() {
        let moves = moves(&["press=0.001@0.5", "hold@0.5", "twist=-0.4@1", "slide=0.01,-0.02@1", "lift"]);
        assert_eq!(seconds(&moves), 3.2);
        assert_eq!(place(&moves, 0.0), Place::START);
        assert_eq!(place(&moves, 0.75), Place { depth: 0.001, ..Place::START });
        assert_eq!(place(&moves, 1.5), Place { depth: 0.001, angle: -0.2, ..Place::START });
        assert_eq!(place(&moves, 3.0), Place { depth: 0.001, angle: -0.4, shift: [0.01, -0.02] });
        assert_eq!(place(&moves, 9.0), Place { depth: -CLEARANCE, angle: -0.4, shift: [0.01, -0.02] });
    }

    #[test]
    fn what_is_no_move_is_told() {
        for bad in ["", "press", "press=x", "press=2", "lift=1", "twist=1@-1", "twist=1@", "slide=1,2,3", "jump=1", "press=nan"] {
            assert!(bad.parse::<Move>().unwrap_err().contains("allowed is"), "{bad}");
        }
    }

    #[test]
    fn a_leg_beside_the_top_of_a_ball_touches_lower() {
        let object = ObjectShape::Sphere { radius: 0.05 };
        let leg = |x| ProbePart { position: Vec3::new(x, 0.0, 0.0), ..ProbePart::at_origin(ProbeShape::Sphere { radius: 0.01 }) };
        // two balls touch when their centres are 60 mm apart
        let expected = 0.05 + (0.06_f64.powi(2) - 0.03_f64.powi(2)).sqrt();
        let found = first_touch(&object, &[leg(0.03), leg(-0.03)], 0.11);
        assert!((f64::from(found) - expected).abs() < 1.0e-6, "{found} {expected}");
        assert!((first_touch(&object, &[leg(0.0)], 0.11) - 0.11).abs() < 1.0e-7);
    }
}
