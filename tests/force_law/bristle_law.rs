//! Bristles of one contact: Stribeck's curve, pre-sliding, sticking, break-away, and that they never feed the motion.

use rustchain::force_law::{Bent, LuGre};

fn laws() -> Vec<LuGre> {
    let mut laws = Vec::new();
    for (stiffness, damping) in [(1e5, 0.3), (1e4, 0.0), (3e6, 2.0)] {
        for (exponent, viscous) in [(2.0, 0.0), (0.5, 0.4), (1.0, 0.1)] {
            laws.push(LuGre {
                static_coefficient: 0.15,
                kinetic_coefficient: 0.1,
                stiffness,
                damping,
                viscous_coefficient: viscous,
                stribeck_speed: 1e-3,
                stribeck_exponent: exponent,
            });
        }
    }
    laws
}

/// Follows bristles through a slip of time by steps of the classical Runge-Kutta method; the last state of them.
fn follow(law: &LuGre, slip: impl Fn(f64) -> f64, end: f64, steps: u32) -> (f64, Bent) {
    let h = end / f64::from(steps);
    let mut z = 0.0;
    for i in 0..steps {
        let t = h * f64::from(i);
        let rate = |z: f64, t: f64| law.bent(z, slip(t)).rate;
        let first = rate(z, t);
        let second = rate(z + 0.5 * h * first, t + 0.5 * h);
        let third = rate(z + 0.5 * h * second, t + 0.5 * h);
        let fourth = rate(z + h * third, t + h);
        z += h / 6.0 * (first + 2.0 * (second + third) + fourth);
    }
    (z, law.bent(z, slip(end)))
}

#[test]
fn steady_slip_has_stribecks_curve() {
    for law in laws() {
        for slip in [-0.05, -2e-3, 3e-4, 1e-3, 4e-3, 0.3] {
            // Ten times what bristles take to bend.
            let end = 10.0 * law.breakaway() / f64::abs(slip);
            let (_, bent) = follow(&law, |_| slip, end, 4000);
            let expected = law.coefficient(slip).copysign(slip) + law.viscous_coefficient * slip;
            assert!((bent.share - expected).abs() < 1e-4 * expected.abs());
            assert!(bent.share.abs() <= law.static_coefficient + law.viscous_coefficient);
        }
    }
}

/// Goes to and fro by `size` \[m\]; how far bristles are bent at the end of a quarter, and what a newton of load loses a period \[J/N\].
fn loops(law: &LuGre, size: f64) -> (f64, f64) {
    let (period, steps) = (1e-2, 20_000);
    let (h, omega) = (period / f64::from(steps), std::f64::consts::TAU / period);
    let slip = |i: f64| size * omega * (omega * h * i).cos();
    let (mut z, mut bent, mut lost) = (0.0, 0.0, 0.0);
    for i in 0..3 * steps {
        let (now, half) = (slip(f64::from(i)), slip(f64::from(i) + 0.5));
        let middle = z + 0.5 * h * law.bent(z, now).rate;
        let found = law.bent(middle, half);
        z += h * found.rate;
        if i >= 2 * steps {
            lost += h * found.share * half;
        }
        if i == 2 * steps + steps / 4 {
            bent = z;
        }
    }
    (bent, lost)
}

#[test]
fn small_to_and_fro_bends_without_slipping_and_goes_round_a_loop() {
    for law in laws() {
        let mut before = 0.0;
        for part in [0.01, 0.1, 0.5] {
            let size = part * law.breakaway();
            let (bent, lost) = loops(&law, size);
            assert!(
                bent > (1.0 - 1.5 * part).max(0.5) * size,
                "{law:?}, {part}: {bent:e} of {size:e}"
            );
            // A share of what is stored that grows with the size; what damping and oil lose is little at 100 turns a second.
            let share = lost / law.stored(size);
            assert!(
                share > before && share < 4.0 * part + 0.3,
                "{law:?}, {part}: {share:e}"
            );
            before = if law.damping == 0.0 && law.viscous_coefficient == 0.0 {
                share
            } else {
                0.0
            };
        }
        // In full slip the loop is Coulomb's: four times the way, against the coefficient.
        let size = 200.0 * law.breakaway();
        let (_, lost) = loops(&law, size);
        let least = 4.0 * size * law.kinetic_coefficient;
        assert!(lost > 0.9 * least, "{law:?}: {lost:e} for {least:e}");
    }
}

#[test]
fn a_load_below_static_friction_is_held_without_creep() {
    // A gram pressed by ten newtons, its load put on within a millisecond; where it is after 0.05 s and after 0.4 s. Without any
    // damping it rings on, and vibration walks.
    let damped = |law: &LuGre| law.damping > 0.0 || law.viscous_coefficient > 0.0;
    for law in laws().into_iter().filter(damped) {
        for part in [0.2, 0.9] {
            let load = part * 10.0 * law.kinetic_coefficient;
            let h = 5e-7;
            let (mut x, mut v, mut z, mut places) = (0.0, 0.0, 0.0, Vec::new());
            for i in 1..=800_000 {
                let bent = law.bent(z, v);
                let pull = load * (f64::from(i) * h / 1e-3).min(1.0);
                v += h * (pull - 10.0 * bent.share) / 1e-3;
                z += h * law.bent(z, v).rate;
                x += h * v;
                if i == 100_000 || i == 800_000 {
                    places.push(x);
                }
            }
            let far = law.breakaway();
            // Measured: at most 3 of them, and nothing after.
            assert!(places[0].abs() < 5.0 * far, "{law:?}, {part}: {places:?}");
            let crept = (places[1] - places[0]).abs();
            assert!(crept < 1e-4 * far, "{law:?}, {part}: {places:?}");
        }
    }
}

#[test]
fn what_is_held_is_given_back_or_lost_and_never_made() {
    // Work of friction less what is stored: not negative at any instant, for every slip and deflection that can come about.
    for law in laws() {
        for i in -60_i32..=60 {
            let slip = 10f64.powf(f64::from(i.abs()) / 10.0 - 5.0) * if i < 0 { -1.0 } else { 1.0 };
            for j in -20..=20 {
                let z = f64::from(j) / 20.0 * law.breakaway();
                let bent = law.bent(z, slip);
                let lost = bent.share * slip - law.stiffness * z * bent.rate;
                let size = (bent.share * slip).abs();
                assert!(lost >= -1e-12 * size, "{law:?}, {slip:e}, {z:e}: {lost:e}");
            }
        }
    }
}

#[test]
fn break_away_needs_less_where_the_load_grows_faster() {
    // A body of one kilogram pressed by one newton, pulled by a force that grows steadily: the largest friction before it slides.
    let law = LuGre {
        stiffness: 1e5,
        damping: 316.0,
        viscous_coefficient: 0.4,
        static_coefficient: 1.5,
        kinetic_coefficient: 1.0,
        stribeck_speed: 1e-3,
        stribeck_exponent: 2.0,
    };
    let breakaway = |rate: f64| {
        let (h, mut z, mut v, mut most) = (1e-5, 0.0, 0.0, 0.0);
        let mut t = 0.0;
        while v < 5e-3 {
            let bent = law.bent(z, v);
            most = f64::max(most, bent.share);
            v += h * (rate * t - bent.share);
            z += h * law.bent(z, v).rate;
            t += h;
        }
        most
    };
    let found = [0.5, 2.0, 10.0, 50.0].map(breakaway);
    assert!(found.windows(2).all(|pair| pair[1] < pair[0]), "{found:?}");
    assert!(
        found[0] < 1.5 && found[0] > 1.3 && found[3] > 1.0,
        "{found:?}"
    );
}
