//! Energy quadrature: powers integrated through each step along its path, finer than the steps themselves.
//!
//! Each step has one panel of the Gauss-Lobatto formula of four points, which is exact for powers of degree five. Power has a kink where
//! a contact begins or ends: such a step is divided there, with a panel for each section. The sums are no part of the integrator's state: they do not enter its error
//! test, and cost nothing while they are off.

use serde::{Deserialize, Serialize};

use super::PowerSum;
use crate::integrator::Step;

/// Inner points of the Gauss-Lobatto formula of four points, as parts of a panel; the others are its ends.
const INNER: [f64; 2] = [0.276_393_202_250_021, 0.723_606_797_749_979];

/// Weights of the four points, as parts of a panel.
const WEIGHTS: [f64; 4] = [1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0];

/// Points of a panel without its first one, which is the last of the panel before.
const POINTS: usize = INNER.len() + 1;

/// The sums of the energy balance, and the powers along the last step, for reports inside it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "P: PowerSum")]
pub struct EnergyQuadrature<P> {
    /// Panels of each section of a step.
    fineness: usize,
    /// Ends of the sections of the last step, as parts of it; the last one is 1.
    sections: Vec<f64>,
    /// The last step \[s\].
    start: f64,
    end: f64,
    /// Energies at its start \[J\].
    at_start: P,
    /// Energies at its end \[J\].
    at_end: P,
    /// Powers at the points of its panels, from start to end \[W\].
    powers: Vec<P>,
    /// Evaluations of the right-hand side that the quadrature took.
    evaluations: u64,
}

impl<P: PowerSum> EnergyQuadrature<P> {
    pub(crate) fn new() -> Self {
        let mut quadrature = Self::default();
        quadrature.refine(1);
        quadrature
    }

    /// Divides every section of a step from now on into `fineness` panels.
    pub(crate) fn refine(&mut self, fineness: usize) {
        self.fineness = fineness.max(1);
        // One kink a step at most, but for a few steps.
        let most = POINTS * 2 * self.fineness + 1;
        self.powers.reserve(most.saturating_sub(self.powers.len()));
        self.sections.reserve(2);
        self.begin(self.end, self.last_power());
    }

    /// Goes on at `t` with `powers`, which are taken to have been the same before.
    pub(crate) fn begin(&mut self, t: f64, powers: P) {
        (self.start, self.end) = (t, t);
        self.at_start = self.at_end;
        self.lay_out(&[], powers);
    }

    /// Forgets what came after `t` inside the last step.
    pub(crate) fn cut(&mut self, t: f64) {
        self.at_end = self.energies(t);
        self.end = t;
    }

    /// Makes room for the powers of a step with `kinks`, the first one that of its start.
    fn lay_out(&mut self, kinks: &[f64], at_start: P) {
        self.sections.clear();
        let inside = kinks.iter().filter(|&&kink| 0.0 < kink && kink < 1.0);
        self.sections.extend(inside);
        self.sections.sort_unstable_by(f64::total_cmp);
        self.sections.dedup();
        self.sections.push(1.0);
        self.powers.clear();
        self.powers.resize(POINTS * self.panels() + 1, at_start);
    }

    /// Panels of the last step.
    fn panels(&self) -> usize {
        self.fineness * self.sections.len()
    }

    /// The section of a panel of the last step, from one part of it to another, and the number of the panel there.
    fn section_of(&self, panel: usize) -> ([f64; 2], usize) {
        let section = panel / self.fineness;
        let begin = section.checked_sub(1).map_or(0.0, |i| self.sections[i]);
        (
            [begin, self.sections[section]],
            panel - section * self.fineness,
        )
    }

    /// Whether it can stand in the place of `other`.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.fineness == other.fineness
            && self.powers.len() == POINTS * self.panels() + 1
            && self.sections.first().is_some_and(|&end| end > 0.0)
            && self.sections.is_sorted_by(|a, b| a < b)
            && self.sections.last() == Some(&1.0)
            && self.start <= self.end
    }

    /// Becomes what `other` is, within its own room.
    pub(crate) fn carry_on(&mut self, other: &Self) {
        let mut powers = std::mem::take(&mut self.powers);
        powers.clear();
        powers.extend_from_slice(&other.powers);
        let mut sections = std::mem::take(&mut self.sections);
        sections.clear();
        sections.extend_from_slice(&other.sections);
        *self = Self {
            sections,
            powers,
            ..other.clone()
        };
    }

    /// Panels of each section of a step.
    pub(crate) fn fineness(&self) -> usize {
        self.fineness
    }

    /// Evaluations of the right-hand side that the quadrature took.
    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Adds the energies of a step whose power at its end is `at_end`; `powers_at` evaluates the powers at a part of the step and its
    /// time. The step is divided at the `kinks` of the powers, which are parts of it.
    pub(crate) fn add_step(
        &mut self,
        step: &Step,
        kinks: &[f64],
        at_end: P,
        mut powers_at: impl FnMut(f64, f64) -> P,
    ) {
        let length = step.end - step.start;
        self.lay_out(kinks, self.last_power());
        let last = self.powers.len() - 1;
        for i in 1..last {
            let ([begin, end], panel) = self.section_of((i - 1) / POINTS);
            let inner = INNER.get((i - 1) % POINTS).map_or(1.0, |inner| *inner);
            let part = begin + (end - begin) * ((inner + panel as f64) / self.fineness as f64);
            self.evaluations += 1;
            self.powers[i] = powers_at(part, step.start + part * length);
        }
        self.powers[last] = at_end;
        self.at_start = self.at_end;
        (self.start, self.end) = (step.start, step.end);
        for panel in 0..self.panels() {
            let ([begin, end], _) = self.section_of(panel);
            let width = (end - begin) * length / self.fineness as f64;
            self.at_end += whole(self.powers_of(panel)).scaled(width);
        }
    }

    /// Counts an evaluation at the end of a step.
    pub(crate) fn count_evaluation(&mut self) {
        self.evaluations += 1;
    }

    /// Powers at the points of a panel.
    fn powers_of(&self, panel: usize) -> &[P] {
        &self.powers[POINTS * panel..=POINTS * (panel + 1)]
    }

    fn last_power(&self) -> P {
        self.powers.last().copied().unwrap_or_default()
    }

    /// Energies dissipated and worked in at `t` inside the last step \[J\].
    pub(crate) fn energies(&self, t: f64) -> P {
        if t >= self.end || self.end <= self.start {
            return self.at_end + self.last_power().scaled(t - self.end);
        }
        let length = self.end - self.start;
        let mut sum = self.at_start;
        for panel in 0..self.panels() {
            let ([begin, end], number) = self.section_of(panel);
            let width = (end - begin) * length / self.fineness as f64;
            let place = (t - self.start) / width - begin * length / width;
            let part = (place - number as f64).clamp(0.0, 1.0);
            sum += integral_to(part, self.powers_of(panel)).scaled(width);
        }
        sum
    }
}

/// Integral of the cubic through the powers of a panel from its start to a `part` of it, for a panel of length one.
fn integral_to<P: PowerSum>(part: f64, powers: &[P]) -> P {
    if part >= 1.0 {
        return whole(powers);
    }
    let points = [0.0, INNER[0], INNER[1], 1.0];
    // The formula's own points, moved into the part: it is exact for what is interpolated there.
    let mut sum = P::default();
    for (point, weight) in points.into_iter().zip(WEIGHTS) {
        let x = part * point;
        for (i, &power) in powers.iter().enumerate() {
            let others = (0..points.len()).filter(|&j| j != i);
            let basis: f64 = others
                .map(|j| (x - points[j]) / (points[i] - points[j]))
                .product();
            sum += power.scaled(part * weight * basis);
        }
    }
    sum
}

fn whole<P: PowerSum>(powers: &[P]) -> P {
    let mut sum = P::default();
    for (&power, weight) in powers.iter().zip(WEIGHTS) {
        sum += power.scaled(weight);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
    struct Both(f64, f64);

    impl std::ops::Add for Both {
        type Output = Self;

        fn add(self, other: Self) -> Self {
            Self(self.0 + other.0, self.1 + other.1)
        }
    }

    impl std::ops::AddAssign for Both {
        fn add_assign(&mut self, other: Self) {
            *self = *self + other;
        }
    }

    impl PowerSum for Both {
        fn scaled(self, factor: f64) -> Self {
            Self(factor * self.0, factor * self.1)
        }

        fn totals(&self) -> [f64; 2] {
            [self.0, self.1]
        }
    }

    /// The quadrature of one step of 0 to 2 s with `panels` in each section, in which the power dissipated is `power`.
    fn metered(panels: usize, kinks: &[f64], power: impl Fn(f64) -> f64) -> EnergyQuadrature<Both> {
        let mut quadrature = EnergyQuadrature::new();
        quadrature.refine(panels);
        quadrature.begin(0.0, Both(power(0.0), 1.0));
        let step = Step {
            start: 0.0,
            end: 2.0,
            order: 1,
        };
        let at = |_, t| Both(power(t), 1.0);
        quadrature.add_step(&step, kinks, at(1.0, 2.0), at);
        quadrature
    }

    #[test]
    fn a_power_of_degree_five_is_summed_exactly() {
        for panels in [1, 3] {
            let quadrature = metered(panels, &[], |t| t.powi(5));
            let exact = 2f64.powi(6) / 6.0;
            assert!((quadrature.energies(2.0).0 - exact).abs() < 1e-13 * exact);
            assert!((quadrature.energies(2.0).1 - 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn inside_a_step_the_sum_is_that_of_a_cubic() {
        for panels in [1, 3] {
            let quadrature = metered(panels, &[], |t| 1.0 + t.powi(3));
            for t in [0.0f64, 0.3, 1.0, 1.7, 2.0] {
                let exact = t + t.powi(4) / 4.0;
                assert!((quadrature.energies(t).0 - exact).abs() < 1e-13, "{t}");
            }
        }
    }

    #[test]
    fn powers_with_kinks_are_summed_exactly_where_the_step_is_divided_there() {
        let power = |t: f64| (t - 0.3).max(0.0).powi(3) + (t - 1.4).max(0.0);
        let energy = |t: f64| (t - 0.3).max(0.0).powi(4) / 4.0 + (t - 1.4).max(0.0).powi(2) / 2.0;
        for panels in [1, 3] {
            let quadrature = metered(panels, &[0.7, 0.15, 0.0, 0.7, 1.2], power);
            for t in [0.0, 0.2, 0.3, 0.9, 1.4, 1.7, 2.0] {
                assert!((quadrature.energies(t).0 - energy(t)).abs() < 1e-13, "{t}");
            }
            let undivided = metered(panels, &[], power).energies(2.0).0;
            assert!((undivided - energy(2.0)).abs() > 1e-4, "{undivided}");
        }
    }
}
