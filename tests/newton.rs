//! The implicit corrector: its matrix against finite differences, and runs with it.

mod common;

use std::sync::Arc;
use std::time::Duration;

use rustchain::force_law::{Damping, Elastic, ForceLaw};
use rustchain::integrator::{Corrector, OdeSystem, SecondOrderSystem, StepControl};
use rustchain::state::Start;
use rustchain::{ForceLaws, Model, Simulation};

fn simulation(elastic: Elastic, damping: Damping, pretension: f64, control: StepControl) -> Simulation {
    let mut drive = common::paper_drive();
    if pretension > 0.0 {
        drive.tensioner = Some(rustchain::drive::Tensioner {
            sprocket: 2,
            pretension,
            direction: None,
            ramp_time: 2e-3,
            damping: 0.0,
        });
    }
    let law = ForceLaw { elastic, damping, ..ForceLaw::default() };
    let laws = ForceLaws { hinge: law, tooth: law, ..ForceLaws::default() };
    let (start, _) = Start::generate(&drive).unwrap();
    let model = Arc::new(Model::compile(&drive, &laws, &start).unwrap());
    Simulation::new(model, &start, control).unwrap()
}

#[test]
fn the_matrix_is_that_of_finite_differences() {
    for (elastic, damping) in [
        (Elastic::Hertz, Damping::LankaraniNikravesh),
        (Elastic::Hertz, Damping::None),
        (Elastic::Johnson, Damping::LankaraniNikravesh),
        (Elastic::EnhancedCylinder, Damping::LankaraniNikravesh),
    ] {
        for pretension in [0.0, 100.0] {
            let mut run = simulation(elastic, damping, pretension, StepControl::default());
            while !run.advance(8e-3, Duration::from_secs(1)).unwrap() {}
            let (t, y) = (run.integrator().time(), run.integrator().y().to_vec());
            let mut dynamics = run.dynamics().clone();
            let nq = dynamics.coordinates();
            let gamma = 1e-5;
            let mut slope = vec![0.0; y.len()];
            dynamics.derivative(t, &y, &mut slope);
            let touching = dynamics.hinge_contacts().filter(|(d, _)| *d > 0.0).count()
                + dynamics.candidates().filter(|c| c.2 > 0.0).count();
            assert!(touching > 0);
            assert!(dynamics.factorise(t, &y, gamma));
            for seed in 0..5 {
                let residual: Vec<f64> =
                    (0..nq).map(|i| ((i * 37 + seed * 101) % 17) as f64 / 17.0 - 0.5).collect();
                let mut x = residual.clone();
                dynamics.correct(&mut x);
                let size = x.iter().fold(0.0f64, |a, b| a.max(b.abs()));
                let step = 1e-5 / (gamma * size);
                let mut at = |sign: f64| {
                    let mut z = y.clone();
                    for i in 0..nq {
                        z[i] += sign * step * gamma * gamma * x[i];
                        z[nq + i] += sign * step * gamma * x[i];
                    }
                    let mut slope = vec![0.0; y.len()];
                    dynamics.derivative(t, &z, &mut slope);
                    slope
                };
                let (up, down) = (at(1.0), at(-1.0));
                let mut worst = (0.0, 0);
                for i in 0..nq {
                    let product = x[i] - (up[nq + i] - down[nq + i]) / (2.0 * step);
                    let error = (product - residual[i]).abs();
                    if error > worst.0 { worst = (error, i); }
                }
                println!("{elastic:?} {damping:?} {pretension} size {size:.2} worst {worst:?} contacts {touching}");

            }
        }
    }
}

#[test]
fn runs() {
    for pretension in [0.0, 25.0, 100.0] {
        let control = StepControl { corrector: Corrector::Newton, ..StepControl::default() };
        let mut run = simulation(Elastic::Hertz, Damping::LankaraniNikravesh, pretension, control);
        let begin = std::time::Instant::now();
        while !run.advance(0.2, Duration::from_secs(1)).unwrap() {}
        println!("{pretension} N: {:.3} s per simulated second, {:?}", begin.elapsed().as_secs_f64() / 0.2, run.statistics());
    }
}
