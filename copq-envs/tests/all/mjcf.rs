//! What MJCF says to different versions of MuJoCo; that it means the right robot is tested where
//! there is a MuJoCo.

use copq_envs::robot::{self, Preset};

const OLD: i32 = 222;
const NEW: i32 = 3_017_000;

/// The values of an attribute in all elements of a kind, in order.
fn values<'a>(text: &'a str, element: &str, attribute: &str) -> Vec<&'a str> {
    let open = format!("<{element} ");
    let name = format!(" {attribute}=\"");
    let lines = text.lines().filter(|line| line.starts_with(&open));
    lines.filter_map(|line| Some(line.split_once(&name)?.1.split_once('"')?.0)).collect()
}

#[test]
fn every_number_parses_back_to_the_same_bits() {
    let ant = robot::ant(Preset::GymV5);
    let text = ant.mjcf(NEW);
    let masses: Vec<f64> =
        values(&text, "inertial", "mass").iter().map(|mass| mass.parse().unwrap()).collect();
    assert_eq!(masses, ant.bodies.iter().map(|body| body.inertial.mass).collect::<Vec<_>>());
    let axes: Vec<Vec<f64>> = values(&text, "joint", "axis")
        .iter()
        .map(|axis| axis.split(' ').map(|component| component.parse().unwrap()).collect())
        .collect();
    assert_eq!(axes, ant.joints[1..].iter().map(|joint| joint.axis.to_vec()).collect::<Vec<_>>());
}

/// Contacts begin at the sum of two margins since MuJoCo 3.5, at the larger one before.
#[test]
fn margins_mean_the_same_to_every_version() {
    for robot in
        [robot::hopper(Preset::GymV5), robot::ant(Preset::GymV5), robot::humanoid(Preset::GymV5)]
    {
        let margins = |version| -> Vec<f64> {
            values(&robot.mjcf(version), "geom", "margin")
                .iter()
                .map(|margin| margin.parse().unwrap())
                .collect()
        };
        let old = margins(OLD);
        let new = margins(NEW);
        for a in 0..old.len() {
            for b in (0..a).filter(|&b| robot.collide(a, b)) {
                assert_eq!(old[a].max(old[b]), new[a] + new[b]);
            }
        }
    }
}

#[test]
fn damping_is_explicit_by_a_flag_or_left_to_the_engine() {
    let gym = robot::halfcheetah(Preset::GymV5);
    let paper = robot::halfcheetah(Preset::Paper);
    for robot in [&gym, &paper] {
        assert_eq!(robot.applied_damping(NEW), None);
        assert_eq!(
            values(&robot.mjcf(NEW), "joint", "damping")[3..],
            ["6", "4.5", "3", "4.5", "3", "1.5"]
        );
    }
    assert!(paper.mjcf(NEW).contains("<flag eulerdamp=\"disable\"/>"));
    assert!(
        [gym.mjcf(NEW), gym.mjcf(OLD), paper.mjcf(OLD)]
            .iter()
            .all(|text| !text.contains("eulerdamp"))
    );
    assert_eq!(gym.applied_damping(OLD), None);
    assert_eq!(paper.applied_damping(OLD).unwrap()[3..], [6.0, 4.5, 3.0, 4.5, 3.0, 1.5]);
    assert_eq!(values(&paper.mjcf(OLD), "joint", "damping"), ["0"; 9]);
}

#[test]
fn names_are_escaped() {
    let mut robot = robot::hopper(Preset::GymV5);
    robot.bodies[0].name = "a \"<b>&".into();
    assert!(robot.mjcf(NEW).contains("<body name=\"a &quot;&lt;b>&amp;\""));
}

/// Masses are written out: MuJoCo rescales them only for an attribute that is deprecated. Tendons
/// would do nothing.
#[test]
fn nothing_deprecated_or_idle_is_written() {
    for preset in [Preset::GymV5, Preset::Paper] {
        for robot in
            [robot::hopper, robot::walker2d, robot::halfcheetah, robot::ant, robot::humanoid]
        {
            let text = robot(preset).mjcf(NEW);
            assert!(!text.contains("settotalmass") && !text.contains("tendon"), "{text}");
            assert_eq!(
                values(&text, "inertial", "mass").len(),
                values(&text, "body", "name").len()
            );
        }
    }
}
