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

#[test]
fn no_step_ends_past_the_stop_time() {
    let fresh = || Instance::new(contents(paper_drive(), &[SPEED])).unwrap();
    let started = |start, stop| {
        let mut instance = fresh();
        instance.set_times(start, stop).unwrap();
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        instance
    };
    let mut instance = started(5.0, Some(5.002));
    instance.step(5.0, 1e-3).unwrap();
    let state = instance.state().unwrap();
    let past = instance.step(5.001, 1.1e-3).unwrap_err().to_string();
    assert!(past.contains("past the stop time, 5.002 s"), "{past}");
    // The refused step changes nothing. Master and instance may round the stop time to different sides.
    assert_eq!(instance.state().unwrap(), state);
    instance.step(5.001, 1e-3 * (1.0 + 5e-4)).unwrap();
    let past = instance.step(5.002, 1e-3).unwrap_err().to_string();
    assert!(past.contains("end of the step"), "{past}");
    // The stop time is a part of the state, and a reset removes it.
    let mut other = started(0.0, None);
    other.set_state(&state).unwrap();
    other.step(5.001, 2e-3).unwrap_err();
    other.step(5.001, 1e-3).unwrap();
    instance.reset().unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    instance.step(0.0, 6e-3).unwrap();

    let refused = |start, stop| {
        let error = fresh().set_times(start, Some(stop)).unwrap_err();
        error.to_string()
    };
    assert!(refused(1.0, 0.5).contains("stop time = 0.5"));
    assert!(refused(0.0, f64::INFINITY).contains("stop time"));
    assert!(refused(0.0, f64::NAN).contains("stop time"));
    fresh().set_times(1.0, Some(1.0)).unwrap();
}
