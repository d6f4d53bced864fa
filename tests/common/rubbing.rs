//! What tests of friction, bristles and films share: drives under pull, kernels beside the scalar reference, energy by place.

use rustchain::chain::dynamics::{Dynamics, Losses};
use rustchain::drive::Drive;
use rustchain::integrator::{OdeSystem, StepControl};
use rustchain::math::simd::InstructionSet;
use rustchain::{ForceLaws, Groups, Simulation};

use super::checks::largest;
use super::scalar_reference::Reference;

/// With bushings on the teeth, and with rollers.
pub fn both_chains() -> [Drive; 2] {
    [super::paper_drive(), super::roller_drive()]
}

/// A drive whose tensioner has its full pull after two milliseconds; without a pull there is none.
pub fn pulled(mut drive: Drive, laws: &ForceLaws, pretension: f64, how: StepControl) -> Simulation {
    if pretension > 0.0 {
        drive.tensioner = Some(super::tensioner(pretension, 2e-3));
    }
    super::simulation(&drive, laws, how)
}

/// What finds the forces of a run, with its contacts' memory; the time, and the state then.
pub type Standing = (Dynamics, f64, Vec<f64>);

/// How a run stands at a time.
pub fn standing(mut run: Simulation, time: f64) -> Standing {
    super::advance(&mut run, time);
    let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
    (run.dynamics().clone(), t, y)
}

/// What kernels and reference make of one state.
pub struct Beside {
    /// Rates of the state, from the kernels.
    pub slope: Vec<f64>,
    /// The scalar reference.
    pub reference: Reference,
    pub losses: Losses,
}

/// Asserts that each set of instructions gives the accelerations of links and rollers that the reference gives, to 1e-7 of the largest
/// along that axis or of `least`, and the losses to 1e-7; hands on each.
pub fn kernels_beside_reference(
    (dynamics, t, y): &Standing,
    least: f64,
) -> impl Iterator<Item = Beside> {
    InstructionSet::available().into_iter().map(move |set| {
        let mut dynamics = dynamics.clone();
        dynamics.use_instructions(set);
        dynamics.keep_energy(true);
        let mut slope = vec![0.0; y.len()];
        dynamics.derivative(*t, y, &mut slope);
        let losses = dynamics.powers(*t, y).losses;
        let reference = Reference::of(&dynamics, *t, y);
        let model = dynamics.model().clone();
        let (n, rates) = (model.links, &slope[model.coordinates..]);
        let rollers = model.rollers.as_ref().map(|rollers| rollers.first);
        for (axis, expected) in reference.accelerations.iter().enumerate() {
            for (first, body) in [(Some(0), 0), (rollers, n)] {
                let Some(first) = first else { continue };
                let own = &rates[first + axis * n..first + (axis + 1) * n];
                let size = largest(own).max(least);
                for (i, (rate, expected)) in own.iter().zip(&expected[body..]).enumerate() {
                    assert!(
                        (rate - expected).abs() <= 1e-7 * size,
                        "{}, axis {axis}, {i}: {rate:e} for {expected:e}, of {size:e}",
                        set.name()
                    );
                }
            }
        }
        for (loss, expected) in losses.values().iter().zip(reference.losses.values()) {
            assert!(
                (loss - expected).abs() <= 1e-7 * expected.abs(),
                "{losses:?}"
            );
        }
        Beside {
            slope,
            reference,
            losses,
        }
    })
}

/// What a run has lost until each report.
pub struct Lost {
    /// By damping in hinges and on teeth, by friction in hinges and on teeth \[J\].
    pub places: [Vec<f64>; 4],
    /// Everywhere, in the end \[J\].
    pub all: f64,
    /// The largest residual of the balance over that.
    pub missing: f64,
}

/// What is lost in some time from now on; asserts that the places together have no more than all, but for some \[J\].
pub fn lost(run: &mut Simulation, span: f64, rounding: f64) -> Lost {
    let groups = Groups {
        energy: true,
        ..Groups::default()
    };
    let recording = super::record(run, span, 1e-3, groups);
    let of = |name| super::channel(&recording, name);
    let dissipated = of("energy_dissipated");
    let places = [
        "energy_hinge_contact",
        "energy_tooth_contact",
        "energy_hinge_friction",
        "energy_tooth_friction",
    ]
    .map(of);
    for (i, &sum) in dissipated.iter().enumerate() {
        // The rest is the tensioner's dashpot's.
        let contacts: f64 = places.iter().map(|place| place[i]).sum();
        assert!(
            contacts <= sum * (1.0 + 1e-12) + rounding,
            "{contacts} of {sum}"
        );
    }
    let all = *dissipated.last().unwrap();
    Lost {
        places,
        all,
        missing: largest(&of("energy_residual")) / all,
    }
}
