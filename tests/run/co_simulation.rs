//! An FMU holds the whole scene, and its steps are those of a run.

use crate::common::layouts::{guided_shafts, three_shafts};
use crate::common::scenes::{VARIED, varied_drive};
use crate::common::{advance, control, paper_drive, roller_drive, simulation, tensioner};
use rustchain::ForceLaws;
use rustchain::drive::{Drive, InputQuantity};
use rustchain::fmu::{Contents, InputVariable, Instance, OutputVariable};
use rustchain::layout::InitialConfiguration;
use rustchain::math::Signal;

const SPEED: InputVariable = InputVariable {
    sprocket: 0,
    quantity: InputQuantity::Speed,
};
const FORCE: InputVariable = InputVariable {
    sprocket: 1,
    quantity: InputQuantity::TensionerForce,
};

fn contents(drive: Drive, inputs: &[InputVariable]) -> Contents {
    let angle = |element| OutputVariable {
        channel: "sprocket_angle".to_string(),
        element: Some(element),
    };
    Contents {
        laws: ForceLaws::default(),
        control: control(1e-5),
        start: InitialConfiguration::generate(&drive).unwrap().0,
        drive,
        state: None,
        inputs: inputs.to_vec(),
        outputs: vec![angle(0), angle(1)],
    }
}

#[test]
fn a_scene_is_the_same_from_its_bytes() {
    let mut drives = vec![roller_drive(), three_shafts(), guided_shafts()];
    drives.extend((0..VARIED).map(varied_drive));
    for drive in drives {
        let contents = contents(drive, &[]);
        let (bytes, token) = contents.to_bytes().unwrap();
        assert_eq!(Contents::from_bytes(&bytes, &token).unwrap(), contents);
        let mut damaged = bytes.clone();
        damaged[40] ^= 1;
        let error = Contents::from_bytes(&damaged, &token).unwrap_err();
        assert!(error.to_string().contains("instantiation token"), "{error}");
    }
}

#[test]
fn steps_with_inputs_have_the_bits_of_a_run() {
    let drive = Drive {
        tensioner: Some(tensioner(25.0, 0.01)),
        ..paper_drive()
    };
    let mut run = simulation(&drive, &ForceLaws::default(), control(1e-5));
    let mut instance = Instance::new(contents(drive, &[SPEED, FORCE])).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    let changes = [
        None,
        Some((0, 14.0)),
        None,
        Some((1, 80.0)),
        Some((1, 20.0)),
    ];
    for (i, change) in changes.into_iter().enumerate() {
        if let Some((number, value)) = change {
            let InputVariable { sprocket, quantity } = [SPEED, FORCE][number];
            instance
                .set_value(u32::try_from(number).unwrap() + 1, value)
                .unwrap();
            run.set_input(sprocket, quantity, Signal::Constant(value))
                .unwrap();
        }
        let (time, size) = (1e-3 * i as f64, 1e-3);
        instance.step(time, size).unwrap();
        advance(&mut run, time + size);
        let positions = run.motion().positions();
        let [.., [.., first], [.., second]] = positions[..] else {
            unreachable!()
        };
        assert_eq!(instance.values()[3..], [first, second], "step {i}");
    }
}

#[test]
fn inputs_and_outputs_that_do_not_exist_are_refused() {
    let refused = |contents| Instance::new(contents).unwrap_err().to_string();
    assert!(refused(contents(paper_drive(), &[FORCE])).contains("has no tensioner"));
    let torque = InputVariable {
        sprocket: 0,
        quantity: InputQuantity::Torque,
    };
    assert!(refused(contents(paper_drive(), &[torque])).contains("prescribed speed"));
    let mut unknown = contents(paper_drive(), &[SPEED]);
    unknown.outputs[1].element = Some(2);
    assert!(refused(unknown).contains("sprocket_angle[2]"));
}
