//! Chain drives as mechanisms: bodies in the drive's order, and an arm that leaves weight and inertia about its pivot what they are.

use crate::common::layouts::{guided_shafts, three_shafts};
use crate::common::tensioner;
use rustchain::drive::{Drive, HingeKind, Tensioner};
use rustchain::force_law::ForceLaw;
use rustchain::geometry::Vec2;
use rustchain::multibody::{DriveContacts, JointKind, Mechanism, Tribology};

fn mechanism(drive: &Drive) -> rustchain::Result<Mechanism> {
    let contacts = DriveContacts {
        law: ForceLaw::default(),
        min_impact_velocity: 1e-3,
        tribology: Tribology::default(),
    };
    Mechanism::from_drive(drive, &contacts, None)
}

/// Four sprockets, the third of them on an arm.
fn with_an_arm() -> Drive {
    let mut drive = three_shafts();
    drive.hinge_kind = HingeKind::Ideal;
    drive.tensioner = Some(Tensioner {
        sprocket: 3,
        pivot: Some(Vec2::new(0.155, 0.25)),
        arm_inertia: 2e-3,
        ..tensioner(60.0, 0.01)
    });
    drive
}

#[test]
fn bodies_follow_the_drive_and_an_arm_comes_last_wherever_its_sprocket_stands() {
    let drive = with_an_arm();
    let links = drive.chain.links as usize;
    let made = mechanism(&drive).unwrap();
    let names: Vec<&str> = made.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names[..2], ["link_1", "link_2"]);
    assert_eq!(
        names[links..],
        [
            "sprocket_1",
            "sprocket_2",
            "sprocket_3",
            "sprocket_4",
            "arm_3"
        ]
    );
}

#[test]
fn an_arm_leaves_the_moment_of_weight_and_the_inertia_about_its_pivot_what_they_are() {
    let drive = with_an_arm();
    let made = mechanism(&drive).unwrap();
    let body = |name: &str| made.bodies.iter().find(|body| body.name == name).unwrap();
    let (arm, wheel) = (body("arm_3"), body("sprocket_3"));
    let (mass, inertia) = drive.sprockets[2].mass_properties(&drive.chain);
    let tensioner = drive.tensioner.unwrap();
    let length = (drive.sprockets[2].center - tensioner.pivot.unwrap()).norm();
    assert!(arm.mass > 0.0 && wheel.mass > 0.0);
    let moment = 0.5 * length * arm.mass + length * wheel.mass;
    assert!((moment - length * mass).abs() < 1e-14 * moment);
    let about_pivot = arm.inertia + (0.25 * arm.mass + wheel.mass) * length * length;
    let expected = tensioner.arm_inertia + mass * length * length;
    assert!((about_pivot - expected).abs() < 1e-14 * expected);
    assert_eq!(wheel.inertia, inertia);
}

#[test]
fn hinges_are_joints_or_contacts_and_each_bushing_may_touch_each_sprocket() {
    let mut drive = with_an_arm();
    let links = drive.chain.links as usize;
    let revolute = |made: &Mechanism| {
        let joints = made
            .joints
            .iter()
            .filter(|joint| joint.name.starts_with("hinge_"));
        joints
            .filter(|joint| joint.kind == JointKind::Revolute)
            .count()
    };
    let ideal = mechanism(&drive).unwrap();
    assert_eq!((revolute(&ideal), ideal.contacts.len()), (links, 4 * links));
    drive.hinge_kind = HingeKind::Clearance;
    let clearance = mechanism(&drive).unwrap();
    assert_eq!(
        (revolute(&clearance), clearance.contacts.len()),
        (0, 5 * links)
    );
    // Clearance lets a tensioned chain be longer, so that its pull is another.
    let pull = |made: &Mechanism| {
        let found = made.forces.iter().find(|force| force.name == "tensioner_3");
        found.unwrap().kind.clone()
    };
    assert_ne!(pull(&ideal), pull(&clearance));
}

#[test]
fn a_part_that_a_mechanism_has_no_counterpart_for_is_refused() {
    let refused = mechanism(&guided_shafts()).unwrap_err().to_string();
    assert!(
        refused.contains("ChainDrive.guides: 2 of them"),
        "{refused}"
    );
}
