//! Normal force of a contact, f = `f_e(δ)` max(0, 1 + λ δ'/δ'₀), its slopes and its dissipated power.

use crate::math::{Real, Truth};

use super::dissipation::factor;

/// Restitution-based damping of one kind of contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RestitutionDamping<R> {
    /// λ of the damping factor 1 + λ δ'/δ'₀.
    pub(crate) lambda: R,
    /// Minimum impact velocity, the lower bound on δ'₀ of contacts without an impact velocity memory \[m/s\].
    pub(crate) minimum: R,
}

/// Normal forces of contacts, with what their slopes and powers need.
#[derive(Clone, Copy)]
pub(crate) struct ContactLane<R: Real> {
    /// Elastic force \[N\].
    elastic: R,
    /// Normal force \[N\].
    pub(crate) force: R,
    /// Damping data; none for undamped contacts.
    damped: Option<Damped<R>>,
}

/// Operands of the damping factor, kept for slopes and power.
#[derive(Clone, Copy)]
struct Damped<R: Real> {
    damping: RestitutionDamping<R>,
    rate: R,
    inverse_impact_velocity: R,
    factor: R,
    remembered: R::Mask,
}

impl<R: Real> ContactLane<R> {
    /// Return contacts without damping.
    #[inline(always)]
    pub(crate) fn undamped(elastic: R) -> Self {
        Self {
            elastic,
            force: elastic,
            damped: None,
        }
    }

    /// Return contacts with the penetration rate `rate` δ' \[m/s\]. `memory` is 1/δ'₀ of each contact \[s/m\], zero for a contact without
    /// one; its impact velocity is then the present rate, at least `minimum`.
    #[inline(always)]
    pub(crate) fn damped(
        elastic: R,
        touching: R::Mask,
        rate: R,
        memory: R,
        damping: RestitutionDamping<R>,
    ) -> Self {
        let (zero, one) = (rate.constant(0.0), rate.constant(1.0));
        let remembered = memory.greater(zero);
        let mut inverse_impact_velocity = memory;
        // Vectors of contacts with a memory, the common case, skip the division.
        if touching.and(remembered.not()).any() {
            inverse_impact_velocity = remembered.select(memory, one / damping.minimum.max(rate));
        }
        let factor = factor(damping.lambda, rate, inverse_impact_velocity);
        Self {
            elastic,
            force: elastic * factor,
            damped: Some(Damped {
                damping,
                rate,
                inverse_impact_velocity,
                factor,
                remembered,
            }),
        }
    }

    /// Return the dissipated power (f - `f_e`) δ' \[W\].
    #[inline(always)]
    pub(crate) fn power(&self) -> R {
        match &self.damped {
            Some(damped) => (self.force - self.elastic) * damped.rate,
            None => self.elastic.constant(0.0),
        }
    }

    /// Return the slopes of the force with penetration \[N/m\] and rate \[N s/m\]; `stiffness` is the slope of the elastic force.
    #[inline(always)]
    pub(crate) fn slopes(&self, stiffness: R) -> [R; 2] {
        let zero = stiffness.constant(0.0);
        let Some(damped) = &self.damped else {
            return [stiffness, zero];
        };
        // Without a memory and above the minimum impact velocity, δ'₀ = δ' makes the factor the constant 1 + λ.
        let RestitutionDamping { lambda, minimum } = damped.damping;
        let fresh_and_fast = damped.remembered.not().and(damped.rate.greater(minimum));
        let constant = fresh_and_fast.or(damped.factor.greater(zero).not());
        let slope = self.elastic * lambda * damped.inverse_impact_velocity;
        [stiffness * damped.factor, constant.select(zero, slope)]
    }

    /// Return the slopes of [`Self::power`] with penetration \[W/m\] and rate \[W s/m\]. `alone` is the slope of the elastic force, `slopes`
    /// those of the force.
    #[inline(always)]
    pub(crate) fn power_slopes(&self, alone: R, [stiffness, damping]: [R; 2]) -> [R; 2] {
        match &self.damped {
            // P = (f - f_e) v: ∂P/∂δ = (∂f/∂δ - ∂f_e/∂δ) v and ∂P/∂v = f - f_e + v ∂f/∂v.
            Some(Damped { rate, .. }) => [
                (stiffness - alone) * *rate,
                rate.mul_add(damping, self.force - self.elastic),
            ],
            None => [alone.constant(0.0); 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DAMPING: RestitutionDamping<f64> = RestitutionDamping {
        lambda: 0.4,
        minimum: 1e-3,
    };

    /// A contact with f = 1e8 δ.
    fn at(depth: f64, rate: f64, memory: f64) -> ContactLane<f64> {
        ContactLane::damped(1e8 * depth, depth > 0.0, rate, memory, DAMPING)
    }

    #[test]
    fn slopes_are_those_of_differences_with_and_without_memory() {
        let (depth, step) = (1e-6, 1e-9);
        for memory in [0.0, 20.0] {
            for rate in [-0.3, -0.02, 2e-4, 0.04] {
                let [stiffness, damping] = at(depth, rate, memory).slopes(1e8);
                let by_depth =
                    at(depth + step, rate, memory).force - at(depth - step, rate, memory).force;
                let by_rate =
                    at(depth, rate + step, memory).force - at(depth, rate - step, memory).force;
                assert!(
                    (stiffness - by_depth / (2.0 * step)).abs() < 1e-6 * 1e8,
                    "{memory} {rate}"
                );
                assert!(
                    (damping - by_rate / (2.0 * step)).abs() < 1e-4 * 1e5,
                    "{memory} {rate}"
                );
            }
        }
    }

    #[test]
    fn power_is_what_damping_takes_and_never_negative() {
        for rate in [-0.5, -0.03, 0.0, 2e-3, 0.1] {
            let contact = at(1e-6, rate, 20.0);
            let damping = contact.force - 100.0;
            assert_eq!(contact.power(), damping * rate);
            assert!(contact.power() >= 0.0 && contact.force >= 0.0);
        }
        assert_eq!(ContactLane::undamped(100.0).power(), 0.0);
    }

    #[test]
    fn slopes_of_the_power_are_those_of_differences() {
        let (depth, step) = (1e-6, 1e-9);
        for memory in [0.0, 20.0] {
            for rate in [-0.02, 2e-4, 0.04] {
                let contact = at(depth, rate, memory);
                let [by_depth, by_rate] = contact.power_slopes(1e8, contact.slopes(1e8));
                let difference = |to: ContactLane<f64>, from: ContactLane<f64>| {
                    (to.power() - from.power()) / (2.0 * step)
                };
                let deeper = difference(
                    at(depth + step, rate, memory),
                    at(depth - step, rate, memory),
                );
                let faster = difference(
                    at(depth, rate + step, memory),
                    at(depth, rate - step, memory),
                );
                assert!(
                    (by_depth - deeper).abs() < 1e-6 * deeper.abs(),
                    "{memory} {rate}"
                );
                assert!(
                    (by_rate - faster).abs() < 1e-4 * faster.abs(),
                    "{memory} {rate}"
                );
            }
        }
        assert_eq!(
            ContactLane::undamped(100.0).power_slopes(1e8, [1e8, 0.0]),
            [0.0; 2]
        );
    }

    #[test]
    fn a_contact_without_memory_has_the_factor_of_its_present_rate_or_of_the_minimum() {
        // 100 N (1 + λ), then 100 N (1 + λ δ'/minimum), then separation at a rate of -2 minimum.
        for (rate, force) in [(0.04, 140.0), (2e-4, 108.0), (-2e-3, 20.0)] {
            assert!((at(1e-6, rate, 0.0).force - force).abs() < 1e-11, "{rate}");
        }
        assert!((at(1e-6, 0.04, 20.0).force - 132.0).abs() < 1e-11);
    }
}
