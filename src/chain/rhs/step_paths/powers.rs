//! Kernel of the powers of contacts inside a step, from their interpolated penetrations and sliding velocities.

use std::marker::PhantomData;

use pulp::{Simd, WithSimd};

use super::Ends;
use crate::force_law::{
    ContactLane, ElasticLaw, Friction, RegularizedFriction, RestitutionDamping,
};
use crate::math::Hermite;
use crate::math::simd::{Lanes, Numbers, PartialSums, load, splat_two, vectors};

/// Law constants of the contacts of one loop.
#[derive(Clone, Copy)]
pub(super) enum Constants<'a> {
    /// The same for all contacts.
    Same([f64; 2]),
    /// Of the surfaces at the end of the step, and of the surface at its onset for every contact with a memory, where it keeps them.
    Slots(&'a [Numbers; 2], Option<&'a [Numbers; 2]>),
}

/// Powers of one kind of contacts.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Found {
    /// Power dissipated by damping \[W\].
    pub(super) dissipated: f64,
    /// Power dissipated by friction \[W\].
    pub(super) rubbed: f64,
    /// Moment on the sprocket \[N m\].
    pub(super) moment: f64,
}

/// Kernel of one kind of contacts. `RUBBED`: with friction.
pub(super) struct PowersInside<'a, L, const RUBBED: bool> {
    pub(super) law: PhantomData<L>,
    /// Part of the step, and its length \[s\].
    pub(super) part: f64,
    pub(super) length: f64,
    pub(super) contacts: usize,
    pub(super) start: &'a Ends,
    pub(super) end: &'a Ends,
    pub(super) constants: Constants<'a>,
    pub(super) inverse_onset: &'a [f64],
    pub(super) lambda: f64,
    pub(super) floor: f64,
    pub(super) friction: Option<&'a Friction>,
}

impl<L: ElasticLaw, const RUBBED: bool> WithSimd for PowersInside<'_, L, RUBBED> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Found {
        let blocks = self.contacts.div_ceil(S::F64_LANES);
        let zero = Lanes::splat(simd, 0.0);
        let cubic = Hermite::<Lanes<S>>::new(simd, self.part, self.length);
        let damping = RestitutionDamping {
            lambda: Lanes::splat(simd, self.lambda),
            floor: Lanes::splat(simd, self.floor),
        };
        let friction = self.friction.map(|law| RegularizedFriction::new(simd, law));
        let inverse_onset = vectors::<S>(self.inverse_onset, blocks);
        let (start, end) = (self.start, self.end);
        let since = Lanes::splat(simd, self.part * self.length);
        let until = Lanes::splat(simd, (self.part - 1.0) * self.length);
        let [mut dissipated, mut rubbed, mut moment] = [PartialSums::default(); 3];
        for i in 0..blocks {
            let at = |array: &Numbers| load(simd, &vectors::<S>(array, blocks)[i]);
            let depths = [at(&start.penetration[0]), at(&end.penetration[0])];
            if !depths[0].max(depths[1]).greater(zero).any() {
                continue;
            }
            let rates = [at(&start.penetration[1]), at(&end.penetration[1])];
            let accelerations = [at(&start.penetration[2]), at(&end.penetration[2])];
            let depth = cubic.at([depths[0], rates[0]], [depths[1], rates[1]]);
            let depth = depth.positive_part();
            let rate = cubic.at([rates[0], accelerations[0]], [rates[1], accelerations[1]]);
            let onset = load(simd, &inverse_onset[i]);
            let pair = match self.constants {
                Constants::Same(pair) => splat_two(simd, pair),
                Constants::Slots(surface, None) => [at(&surface[0]), at(&surface[1])],
                Constants::Slots(surface, Some(kept)) => {
                    let remembered = onset.greater(zero);
                    [
                        remembered.select(at(&kept[0]), at(&surface[0])),
                        remembered.select(at(&kept[1]), at(&surface[1])),
                    ]
                }
            };
            let touching = depth.greater(zero);
            let elastic = touching.select(L::elastic(pair, depth), zero);
            let contact = ContactLane::damped(elastic, touching, rate, onset, damping);
            dissipated.add(i, contact.power());
            let force = contact.force;
            let turns = !start.lever[0].is_empty();
            if turns {
                let levers = [at(&start.lever[0]), at(&end.lever[0])];
                let rates = [at(&start.lever[1]), at(&end.lever[1])];
                let surfaces = [at(&start.surface), at(&end.surface)];
                let smooth = cubic.at([levers[0], rates[0]], [levers[1], rates[1]]);
                // Where a contact moves from one surface to the next, the curvature is discontinuous and the lever arm has a kink, which is
                // at the intersection of the tangents at both ends.
                let tangents = [
                    rates[0].mul_add(since, levers[0]),
                    rates[1].mul_add(until, levers[1]),
                ];
                let [lower, upper] = [
                    -(-tangents[0]).max(-tangents[1]),
                    tangents[0].max(tangents[1]),
                ];
                let kinked = rates[1].greater(rates[0]).select(upper, lower);
                let crossed = (surfaces[0] - surfaces[1]).abs().greater(zero);
                let lever = crossed.select(kinked, smooth);
                moment.add(i, force * lever);
            }
            if RUBBED && let Some(friction) = &friction {
                let slip = cubic.at(
                    [at(&start.slip[0]), at(&start.slip[1])],
                    [at(&end.slip[0]), at(&end.slip[1])],
                );
                let [rub, _] = friction.force(force, slip);
                rubbed.add(i, rub * slip);
                if turns {
                    let levers = [at(&start.friction_lever), at(&end.friction_lever)];
                    let part = Lanes::splat(simd, self.part);
                    let lever = part.mul_add(levers[1] - levers[0], levers[0]);
                    moment.add(i, rub * lever);
                }
            }
        }
        Found {
            dissipated: dissipated.total(),
            rubbed: rubbed.total(),
            moment: moment.total(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chain::dynamics::{Losses, Powers};
    use crate::force_law::Hertz;
    use crate::integrator::Step;
    use crate::math::simd::{InstructionSet, padded_zeros};
    use crate::system::EnergyQuadrature;

    /// A mass of 7 g on a contact with f = 1e9 δ^1.5 (1 + λ v/r), pressed by a constant load.
    struct Oscillator {
        load: f64,
        lambda: f64,
    }

    const MASS: f64 = 7e-3;
    const PAIR: [f64; 2] = [1e9, 0.0];
    const SPEED: f64 = 0.1;

    impl Oscillator {
        fn acceleration(&self, [depth, rate]: [f64; 2]) -> f64 {
            let factor = (1.0 + self.lambda * rate / SPEED).max(0.0);
            (self.load - Hertz::force(&PAIR, depth) * factor) / MASS
        }

        fn energy(&self, [depth, rate]: [f64; 2]) -> f64 {
            0.5 * MASS * rate * rate + Hertz::energy(&PAIR, depth) - self.load * depth
        }

        /// The state after `time` \[s\], by 400 steps of the classical Runge-Kutta method.
        fn after(&self, mut state: [f64; 2], time: f64) -> [f64; 2] {
            let h = time / 400.0;
            for _ in 0..400 {
                let slope = |[depth, rate]: [f64; 2]| [rate, self.acceleration([depth, rate])];
                let at = |[d, v]: [f64; 2], part: f64| [state[0] + part * d, state[1] + part * v];
                let a = slope(state);
                let b = slope(at(a, 0.5 * h));
                let c = slope(at(b, 0.5 * h));
                let d = slope(at(c, h));
                for i in 0..2 {
                    state[i] += h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
                }
            }
            state
        }

        fn ends(&self, state: [f64; 2]) -> Ends {
            let mut ends = Ends::new(1, false, false);
            let values = [state[0], state[1], self.acceleration(state)];
            for (array, value) in ends.penetration.iter_mut().zip(values) {
                array[0] = value;
            }
            ends
        }

        /// Error of the dissipated energy over it, in `steps` steps of `length` \[s\].
        fn error(&self, start: [f64; 2], length: f64, steps: u32) -> f64 {
            let mut quadrature = EnergyQuadrature::new();
            quadrature.begin(0.0, Powers::default());
            let mut inverse_onset = padded_zeros(1);
            inverse_onset.fill(1.0 / SPEED);
            let mut state = start;
            for i in 0..steps {
                let next = self.after(state, length);
                let ends = [self.ends(state), self.ends(next)];
                let powers = |part: f64, _| {
                    let found = InstructionSet::detect().run(PowersInside::<Hertz, false> {
                        law: PhantomData,
                        part,
                        length,
                        contacts: 1,
                        start: &ends[0],
                        end: &ends[1],
                        constants: Constants::Same(PAIR),
                        inverse_onset: &inverse_onset,
                        lambda: self.lambda,
                        floor: 1e-3,
                        friction: None,
                    });
                    Powers::of(Losses {
                        hinge_contact: found.dissipated,
                        ..Losses::default()
                    })
                };
                let changed = (state[0] > 0.0) != (next[0] > 0.0);
                let kinks: &[f64] = if changed { &[0.5] } else { &[] };
                let step = Step {
                    start: f64::from(i) * length,
                    end: f64::from(i + 1) * length,
                    order: 2,
                };
                quadrature.add_step(&step, kinks, powers(1.0, step.end), powers);
                state = next;
            }
            let lost = self.energy(start) - self.energy(state);
            quadrature.energies(f64::from(steps) * length).dissipated / lost - 1.0
        }
    }

    /// The exact loss is the lost kinetic energy, 28 % of it at a restitution of 0.8. The onset falls at seven places of a step.
    #[test]
    fn the_loss_of_a_single_impact_is_found_from_a_few_steps() {
        let contact = Oscillator {
            load: 0.0,
            lambda: 0.75 * (1.0 - 0.64),
        };
        let duration = 3.0 * (1.25 * MASS * SPEED * SPEED / PAIR[0]).powf(0.4) / SPEED;
        // Measured: 1.1e-3, 2.0e-4 and 2.4e-5 at most.
        for (steps, bound) in [(6, 2e-3), (10, 4e-4), (20, 5e-5)] {
            let length = duration / f64::from(steps);
            for place in 0..7 {
                let ahead = length * (0.05 + 0.15 * f64::from(place));
                let error = contact.error([-SPEED * ahead, SPEED], length, steps * 8 / 5);
                assert!(
                    error.abs() < bound,
                    "{steps} steps, onset {place}: {error:e}"
                );
            }
        }
    }

    /// A preloaded contact that vibrates without separation, two cycles: the error is of order four.
    #[test]
    fn the_loss_of_a_vibrating_contact_is_found_to_order_four() {
        let contact = Oscillator {
            load: 20.0,
            lambda: 0.27,
        };
        let depth = (contact.load / PAIR[0]).powf(2.0 / 3.0);
        let frequency = (1.5 * PAIR[0] * depth.sqrt() / MASS).sqrt();
        let cycles = 4.0 * std::f64::consts::PI / frequency;
        // Measured: 1.5e-3, 9.2e-5 and 5.7e-6 with 7, 14 and 28 steps a cycle.
        let errors = [14, 28, 56].map(|steps| {
            contact
                .error([1.3 * depth, 0.0], cycles / f64::from(steps), steps)
                .abs()
        });
        assert!(errors[0] < 2e-3, "{errors:?}");
        for pair in errors.windows(2) {
            let quotient = pair[0] / pair[1];
            assert!((14.0..19.0).contains(&quotient), "{errors:?}");
        }
    }
}
