//! The coupling as a whole, through `step`.

use glam::{Quat, Vec3};

use crate::*;

const RUBBER: Material = Material { young_modulus: 3.0e6, poisson_ratio: 0.5, density: 1100.0 };
const BALL: [ProbePart<'_>; 1] = [ProbePart::at_origin(ProbeShape::Sphere { radius: 0.02 })];

/// A scene with a virtual coupling.
struct Felt<'a> {
    model: Model<'a>,
    params: Params,
    state: State<16, 64>,
    scratch: Scratch<16>,
    handle: (Vec3, Quat),
    dt: f32,
}

fn soft() -> ParamsSpec {
    ParamsSpec { coupling: CouplingSpec::Virtual(VirtualCoupling::default()), guard: GuardSpec::OPEN, ..ParamsSpec::default() }
}

impl<'a> Felt<'a> {
    fn new(spec: &ModelSpec<'a>, params: &ParamsSpec) -> Self {
        Self {
            model: Model::new(spec).unwrap(),
            params: Params::new(params).unwrap(),
            state: State::new(),
            scratch: Scratch::new(),
            handle: (Vec3::Z * (spec.object.height() + 0.021), Quat::IDENTITY),
            dt: 1.0e-3,
        }
    }

    fn on(young_modulus: f32, mass: f32) -> Felt<'static> {
        let material = Material { young_modulus, ..RUBBER };
        Felt::new(&ModelSpec { mass, ..ModelSpec::new(ObjectShape::HalfSpace, material, &BALL) }, &soft())
    }

    fn tick(&mut self) -> Output {
        let input = Input { pose: Pose::new(self.handle.0, self.handle.1), dt: self.dt };
        step(&self.model, &self.params, &mut self.state, &mut self.scratch, input)
    }

    /// Moves the handle by `by` and turns it by `turn` about `axis` in equal steps.
    fn go(&mut self, by: Vec3, axis: Vec3, turn: f32, ticks: u32) -> Output {
        let (from, facing) = self.handle;
        let mut last = None;
        for i in 1..=ticks {
            let share = i as f32 / ticks as f32;
            self.handle = (from + by * share, (Quat::from_axis_angle(axis, turn * share) * facing).normalize());
            last = Some(self.tick());
        }
        last.unwrap()
    }

    fn hold(&mut self, ticks: u32) -> Output {
        (0..ticks).map(|_| self.tick()).last().unwrap()
    }

    fn probe(&self) -> Pose<World, ProbeFrame> {
        self.state.probe_pose().unwrap()
    }
}

#[test]
fn at_rest_the_hand_feels_the_contact_through_the_spring() {
    for mass in [0.0, 0.01, 1.0] {
        let mut felt = Felt::on(3.0e6, mass);
        felt.go(Vec3::Z * -0.009, Vec3::Z, 0.0, 200);
        let output = felt.hold(3000);
        let stretch = felt.probe().position - felt.handle.0;
        assert!((output.wrench.force - output.contact.force).length() < 2.0e-3, "{mass} kg: {output:?}");
        assert!((output.wrench.force - stretch * 800.0).length() < 1.0e-3, "{mass} kg: {output:?} {stretch}");
        assert!(output.wrench.force.z > 5.0 && output.wrench.torque.length() < 1.0e-6, "{output:?}");
    }
}

#[test]
fn in_free_air_the_hand_at_rest_feels_nothing_at_all() {
    let mut felt = Felt::on(3.0e6, 1.0);
    felt.go(Vec3::new(0.1, -0.02, 0.05), Vec3::new(0.6, 0.0, 0.8), 1.0, 300);
    let output = felt.hold(4000);
    assert_eq!(output.wrench, Wrench::ZERO);
    let probe = felt.probe();
    assert!((probe.position - felt.handle.0).length() < 1.0e-7 && probe.rotation.angle_between(felt.handle.1) < 2.0e-3);
}

#[test]
fn a_twist_reaches_the_object_through_the_torsion_spring() {
    let mut felt = Felt::on(3.0e6, 1.0);
    felt.go(Vec3::Z * -0.009, Vec3::Z, 0.0, 200);
    felt.go(Vec3::ZERO, Vec3::Z, 0.02, 200);
    let output = felt.hold(3000);
    // springs in series: 0.3 N m/rad of the coupling and the stuck patch's 16/3 G a^3
    assert!((output.wrench.torque - output.contact.torque).length() < 1.0e-5, "{output:?}");
    assert!(output.wrench.torque.z < -1.0e-3, "{output:?}");
}

#[test]
fn rest_is_reached_and_kept_to_the_bit() {
    for (e, mass) in [(3.0e6, 1.0), (3.0e6, 0.0), (1.0e9, 0.05), (1.0e4, 0.2)] {
        let mut felt = Felt::on(e, mass);
        felt.go(Vec3::new(0.001, 0.0, -0.009), Vec3::Z, 0.1, 300);
        felt.hold(6000);
        let (pose, output) = (felt.probe(), felt.tick());
        let settled = felt.state.memory.settled_for.is_some();
        assert!(settled, "E {e} Pa, {mass} kg: never comes to rest");
        for _ in 0..20_000 {
            assert_eq!(felt.tick(), output);
        }
        assert_eq!(felt.probe(), pose);
    }
}

/// Ticks of every extreme: nothing may grow, nothing may leave the numbers.
#[test]
fn no_stiffness_mass_or_tick_shakes_the_probe_off() {
    for e in [1.0e2, 3.0e6, 1.0e12] {
        for mass in [0.0, 1.0e-6, 1.0, 1.0e4] {
            for dt in [1.0e-6, 1.25e-4, 1.0e-3, 1.0] {
                let mut felt = Felt { dt, ..Felt::on(e, mass) };
                let height = felt.handle.0.z;
                felt.go(Vec3::Z * -0.004, Vec3::X, 0.2, 50);
                for _ in 0..400 {
                    let output = felt.tick();
                    assert!(output.wrench.is_finite() && output.contact.is_finite());
                    assert!(!output.report.flags.contains(Flags::NON_FINITE), "E {e}, {mass} kg, dt {dt}");
                    let away = (felt.probe().position - felt.handle.0).length();
                    assert!(away < 0.02, "E {e}, {mass} kg, dt {dt}: probe {away} m from a handle at {height}");
                }
            }
        }
    }
}

#[test]
fn parts_with_flats_settle_without_mass() {
    let shapes = [
        ProbeShape::Box { size: Vec3::new(0.04, 0.03, 0.04) },
        ProbeShape::Cylinder { radius: 0.015, height: 0.04 },
        ProbeShape::Capsule { radius: 0.01, height: 0.04 },
        ProbeShape::Cone { radius: 0.02, height: 0.03 },
    ];
    let sides = [
        Quat::IDENTITY,
        Quat::from_xyzw(0.707_106_77, 0.0, 0.0, 0.707_106_77),
        Quat::from_xyzw(0.05, 0.02, 0.0, 1.0).normalize(),
    ];
    for shape in shapes {
        for side in sides {
            for mass in [0.0, 0.1] {
                let parts = [ProbePart { rotation: side, ..ProbePart::at_origin(shape) }];
                let spec = ModelSpec { mass, ..ModelSpec::new(ObjectShape::HalfSpace, RUBBER, &parts) };
                let mut felt = Felt::new(&spec, &soft());
                felt.handle.0.z = 0.04;
                felt.go(Vec3::Z * -0.03, Vec3::Z, 0.0, 300);
                felt.hold(1500);
                let mut least = f32::MAX;
                let mut most = 0.0_f32;
                for _ in 0..200 {
                    let force = felt.tick().wrench.force.length();
                    (least, most) = (least.min(force), most.max(force));
                }
                assert!(most - least <= 1.0e-3 * most, "{shape:?} {side:?} {mass} kg: {least} to {most} N");
            }
        }
    }
}

/// Sliding is resisted by friction and nothing else, with mass and without: the linearised contact adds no drag of its own.
#[test]
fn a_steady_slide_costs_mu_p() {
    for mass in [0.0, 0.1] {
        let mut felt = Felt::on(3.0e6, mass);
        felt.go(Vec3::Z * -0.009, Vec3::Z, 0.0, 200);
        let output = felt.go(Vec3::X * 0.05, Vec3::Z, 0.0, 1000);
        let (across, load) = (output.wrench.force.x, output.contact.force.z);
        assert!((across / (-0.75 * load) - 1.0).abs() < 0.03, "{mass} kg: {output:?}");
    }
}

/// The coupling never pulls harder than it saturates.
#[test]
fn a_saturated_coupling_presses_no_harder() {
    let spring = VirtualCoupling { max_force: 2.0, ..VirtualCoupling::default() };
    let params = ParamsSpec { coupling: CouplingSpec::Virtual(spring), ..soft() };
    let mut felt = Felt::new(&ModelSpec::new(ObjectShape::HalfSpace, RUBBER, &BALL), &params);
    felt.go(Vec3::Z * -0.015, Vec3::Z, 0.0, 400);
    let output = felt.hold(4000);
    assert!((output.contact.force.z - 2.0).abs() < 5.0e-3 && (output.wrench.force.z - 2.0).abs() < 5.0e-3, "{output:?}");
}

/// Weight acts on the probe and reaches the hand through the spring.
#[test]
fn gravity_hangs_on_the_spring() {
    let params = ParamsSpec { gravity: true, ..soft() };
    let spec = ModelSpec { mass: 0.2, ..ModelSpec::new(ObjectShape::HalfSpace, RUBBER, &BALL) };
    let mut felt = Felt::new(&spec, &params);
    felt.handle.0.z = 0.1;
    let output = felt.hold(4000);
    assert!((output.wrench.force.z + 0.2 * 9.806_65).abs() < 1.0e-3, "{output:?}");
}

/// Twenty lost poses of a moving handle: the probe makes up for them with the speed it had, and the damper does not take them for a jump.
#[test]
fn lost_poses_do_not_pull() {
    let mut felt = Felt::on(3.0e6, 1.0);
    felt.go(Vec3::X * 0.2, Vec3::Z, 0.0, 2000);
    let speed = 1.0e-4;
    for _ in 0..20 {
        let nowhere = Input { pose: Pose::new(Vec3::NAN, Quat::IDENTITY), dt: felt.dt };
        let output = step(&felt.model, &felt.params, &mut felt.state, &mut felt.scratch, nowhere);
        assert!(output.report.flags.contains(Flags::POSE_REFUSED));
    }
    felt.handle.0.x += 20.0 * speed;
    for _ in 0..50 {
        felt.handle.0.x += speed;
        let output = felt.tick();
        assert!(output.wrench.force.length() < 0.05, "{output:?}");
    }
}
