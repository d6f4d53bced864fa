//! Elastic links: how far a strand stretches, and at which frequencies it vibrates along itself.

use crate::common::checks::forces_and_powers_follow_from_a_correction;
use crate::common::open::{at_rest, strand};
use crate::common::scenes::laws;
use crate::common::{advance, control, energies, paper_drive, simulation, tensioner};
use nalgebra::{DMatrix, DVector};
use rustchain::drive::{ChainEnd, Drive, LinkStiffness, Material, Plates};
use rustchain::force_law::{Damping, Elastic, Regions};
use rustchain::geometry::Vec2;
use rustchain::integrator::StepControl;
use rustchain::{ForceLaws, Model, Simulation};

const GRAVITY: f64 = 9.81;

/// Contacts that are springs of this stiffness \[N/m\], without damping.
fn springs(stiffness: f64) -> ForceLaws {
    laws(Elastic::Linear(stiffness), Damping::None, Regions::Kept)
}

/// A chain that hangs from a pin, with a load below.
fn hung(links: u32, load: f64, stiffness: Option<f64>, strands: u32) -> Drive {
    let ends = [
        ChainEnd::anchored(Vec2::zeros()),
        ChainEnd::loaded(load, 1e-4 * load),
    ];
    let mut drive = strand(links, ends);
    drive.chain.strands = strands;
    drive.chain.link_stiffness = stiffness.map(LinkStiffness::Given);
    drive
}

/// Masses from the first link to the load \[kg\].
fn masses(drive: &Drive, load: f64) -> Vec<f64> {
    let links = (0..drive.chain.links as usize).map(|i| drive.chain.strand_link(i).mass);
    links.chain([load]).collect()
}

/// Stiffness of the springs between them, from the pin to the load \[N/m\]: the contact, and half of either link behind it.
fn between(drive: &Drive, contact: f64, stiffness: f64) -> Vec<f64> {
    let links = drive.chain.links as usize;
    let whole = 1.0 / (f64::from(drive.chain.strands) * stiffness);
    let plates = |k: usize| {
        if k == 0 || k == links {
            0.5 * whole
        } else {
            whole
        }
    };
    (0..=links)
        .map(|k| 1.0 / (1.0 / contact + plates(k)))
        .collect()
}

/// How far below the pin the load rests \[m\], and the tensions from the pin to the load \[N\].
fn rest_of(drive: &Drive, load: f64, contact: f64) -> (f64, Vec<f64>) {
    let (_, rest) = at_rest(drive, &springs(contact), StepControl::default());
    let all = masses(drive, load);
    let tensions = (0..all.len()).map(|k| GRAVITY * all[k..].iter().sum::<f64>());
    let place = rest.start.positions[drive.chain.links as usize][1];
    (-place, tensions.collect())
}

#[test]
fn a_chain_under_load_is_longer_by_its_load_over_the_stiffness_of_all_links() {
    for (links, stiffness, strands, load) in [
        (4, 1e7, 1, 20.0),
        (11, 3e8, 1, 500.0),
        (40, 1e6, 2, 5.0),
        (41, 5e7, 3, 2000.0),
    ] {
        let elastic = hung(links, load, Some(stiffness), strands);
        let (long, tensions) = rest_of(&elastic, load, 2e8);
        let (short, _) = rest_of(&hung(links, load, None, strands), load, 2e8);
        // Each link bears the mean of the tensions at its ends.
        let pulls = tensions.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
        let expected = pulls.sum::<f64>() / (f64::from(strands) * stiffness);
        let found = long - short;
        assert!(
            (found / expected - 1.0).abs() < 1e-5,
            "{links} links: {found:e} m of {expected:e} m"
        );
        // With a load that outweighs its chain that is load / stiffness x links.
        let plain = GRAVITY * load * f64::from(links) / (f64::from(strands) * stiffness);
        assert!((found / plain - 1.0).abs() < 0.1, "{found:e} {plain:e}");
    }
}

/// Squared frequencies \[1/s²\] and shapes of masses on springs, from the lowest.
fn modes(masses: &[f64], springs: &[f64]) -> Vec<(f64, DVector<f64>)> {
    let n = masses.len();
    let root = |i: usize| masses[i].sqrt();
    let mut matrix = DMatrix::<f64>::zeros(n, n);
    for (k, spring) in springs.iter().enumerate() {
        matrix[(k, k)] += spring / masses[k];
        if k > 0 {
            matrix[(k - 1, k - 1)] += spring / masses[k - 1];
            matrix[(k - 1, k)] -= spring / (root(k - 1) * root(k));
            matrix[(k, k - 1)] = matrix[(k - 1, k)];
        }
    }
    let eigen = matrix.symmetric_eigen();
    let mut found: Vec<_> = (0..n)
        .map(|j| {
            let shape = DVector::from_fn(n, |i, _| eigen.eigenvectors[(i, j)] / root(i));
            (eigen.eigenvalues[j], shape)
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

#[test]
fn a_strand_vibrates_along_itself_at_the_frequencies_of_contacts_and_plates_in_series() {
    for (links, stiffness, contact, strands, load) in [
        (4, 1e6, 1e9, 1, 10.0),
        (4, 3e8, 1e8, 1, 100.0),
        (5, 1e7, 1e7, 2, 1.0),
        (12, 5e7, 2e8, 1, 30.0),
        (40, 1e7, 5e7, 1, 10.0),
    ] {
        let drive = hung(links, load, Some(stiffness), strands);
        let laws = springs(contact);
        let (_, rest) = at_rest(&drive, &laws, StepControl::default());
        let (masses, springs) = (masses(&drive, load), between(&drive, contact, stiffness));
        let found = modes(&masses, &springs);
        let (_, tensions) = rest_of(&drive, load, contact);
        for (number, (squared, shape)) in found.iter().enumerate().take(3) {
            let omega = squared.sqrt();
            // A tenth of the least stretch, so that no contact opens.
            let opening = springs.iter().enumerate().map(|(k, spring)| {
                let before = if k == 0 { 0.0 } else { shape[k - 1] };
                spring * (shape[k] - before).abs() / tensions[k]
            });
            let amplitude = 0.1 / opening.fold(0.0, f64::max);
            let mut start = rest.start.clone();
            for (i, speed) in shape.iter().enumerate() {
                start.velocities[i][1] = omega * amplitude * speed;
            }
            let model = Model::compile(&drive, &laws, &start).unwrap();
            let mut run = Simulation::new(model.into(), &start, control(1e-10)).unwrap();
            // After four periods and an eighth of one an error of the frequency shows in the place.
            let time = 4.125 * std::f64::consts::TAU / omega;
            advance(&mut run, time);
            let weigh = |moved: &dyn Fn(usize) -> f64| -> f64 {
                (0..masses.len())
                    .map(|i| masses[i] * shape[i] * moved(i))
                    .sum()
            };
            let motion = &run.present().evaluated.motion;
            let moved = weigh(&|i| motion.y[i] - rest.start.positions[i][1]);
            let speed = weigh(&|i| motion.vy[i]);
            let phase = (omega * moved / amplitude).atan2(speed / amplitude);
            let expected = std::f64::consts::FRAC_PI_4;
            assert!(
                (phase - expected).abs() < 2e-4 * omega * time,
                "{links} links, mode {number}: {phase} of {expected}"
            );
            let size = (moved / amplitude).hypot(speed / (omega * amplitude));
            assert!(
                (size - 1.0).abs() < 1e-3,
                "{links} links, mode {number}: {size}"
            );
        }
    }
}

#[test]
fn plates_make_the_stiffness_that_they_have() {
    let plates = Plates {
        inner_section: 3.7e-5,
        outer_section: 3.2e-5,
        elastic_modulus: Some(2.0e11),
    };
    let mut drive = hung(10, 50.0, None, 2);
    drive.chain.link_stiffness = Some(LinkStiffness::Of(plates));
    let given = hung(
        10,
        50.0,
        Some(plates.stiffness(drive.chain.pitch, &Material::default())),
        2,
    );
    assert_eq!(rest_of(&drive, 50.0, 1e8), rest_of(&given, 50.0, 1e8));
    // Steel of 34 mm² at half an inch.
    let stiffness = drive.chain.axial_stiffness().unwrap();
    assert!((stiffness / 1.08e9 - 1.0).abs() < 0.01, "{stiffness:e}");
}

/// The published drive with elastic plates.
fn with_plates(elastic: Elastic, pretension: f64) -> Simulation {
    let laws = laws(elastic, Damping::LankaraniNikravesh, Regions::Kept);
    let mut drive = paper_drive();
    drive.tensioner = Some(tensioner(pretension, 2e-3));
    // Plates softer than the contacts of the hinges.
    drive.chain.link_stiffness = Some(LinkStiffness::Given(1e7));
    simulation(&drive, &laws, StepControl::default())
}

#[test]
fn forces_and_powers_after_a_correction_need_no_evaluation() {
    let scenes = [Elastic::Hertz, Elastic::Johnson].map(|elastic| {
        [25.0, 100.0].map(|pretension| {
            let mut run = with_plates(elastic, pretension);
            advance(&mut run, 8e-3);
            (format!("{elastic:?} {pretension} N"), run)
        })
    });
    // Places are rounded to 3e-17 m. Tooth contacts of 1e8 N/m, which move at 0.4 m/s, then err by 1e-9 W in each state.
    let rounding = 8f64.sqrt() * 1e-9;
    let scenes = scenes.into_iter().flatten();
    let compared = forces_and_powers_follow_from_a_correction(scenes, rounding);
    assert_eq!(compared, 8);
}

#[test]
fn the_powers_at_the_ends_of_steps_take_no_evaluations() {
    let mut run = with_plates(Elastic::Hertz, 100.0);
    energies(&mut run, 0.02, 2e-3);
    let (counts, taken) = (run.statistics().counts, run.statistics().energy_evaluations);
    // One a step with evaluations at the ends.
    assert!(taken < counts.steps / 2, "{taken} {counts:?}");
}
