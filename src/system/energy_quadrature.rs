//! Energy quadrature: integration of powers along the path of each step, with more points than the steps.
//!
//! Each step has one panel of Simpson's rule or of the Gauss-Lobatto formula of four points. Power has a kink at a contact onset or end.
//! The step is divided there, with a panel for each section. The sums are not part of the integrator's state: they do not affect its error
//! test, and cost nothing while the quadrature is off.

use serde::{Deserialize, Serialize};

use super::PowerSum;
use crate::integrator::Step;

/// Quadrature formula of one panel: its points and weights, as fractions of the panel.
#[derive(Debug)]
pub(crate) struct PanelRule {
    points: &'static [f64],
    weights: &'static [f64],
}

impl PanelRule {
    /// Simpson's rule, exact for powers of degree three.
    pub(crate) const SIMPSON: Self = Self {
        points: &[0.0, 0.5, 1.0],
        weights: &[1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0],
    };

    /// The Gauss-Lobatto formula of four points, exact for powers of degree five.
    pub(crate) const LOBATTO: Self = Self {
        points: &[0.0, 0.276_393_202_250_021, 0.723_606_797_749_979, 1.0],
        weights: &[1.0 / 12.0, 5.0 / 12.0, 5.0 / 12.0, 1.0 / 12.0],
    };

    /// Return the number of points without the first one, which is the last point of the previous panel.
    const fn new_points(&self) -> usize {
        self.points.len() - 1
    }

    /// Return the integral of the polynomial through `powers` from the start of a panel to the fraction `part`, for a panel of length one.
    fn integral_to<P: PowerSum>(&self, part: f64, powers: &[P]) -> P {
        if part >= 1.0 {
            return self.whole(powers);
        }
        let points = self.points;
        // The formula itself, scaled to this fraction, integrates the interpolating polynomial (Lagrange basis) exactly.
        let mut sum = P::default();
        for (point, weight) in points.iter().zip(self.weights) {
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

    fn whole<P: PowerSum>(&self, powers: &[P]) -> P {
        let mut sum = P::default();
        for (&power, &weight) in powers.iter().zip(self.weights) {
            sum += power.scaled(weight);
        }
        sum
    }
}

/// Sums of the energy balance, and the powers along the last step, for reports within the step.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(bound = "P: PowerSum")]
pub struct EnergyQuadrature<P> {
    /// Number of panels in each section of a step.
    fineness: usize,
    /// Ends of the sections of the last step, as fractions of it; the last one is 1.
    sections: Vec<f64>,
    /// Start and end of the last step \[s\].
    start: f64,
    end: f64,
    /// Energies at the start of the last step \[J\].
    at_start: P,
    /// Energies at the end of the last step \[J\].
    at_end: P,
    /// Powers at the points of the panels, from start to end \[W\].
    powers: Vec<P>,
    /// Number of evaluations of the right-hand side by the quadrature.
    evaluations: u64,
}

impl<P: PowerSum> EnergyQuadrature<P> {
    pub(crate) fn new() -> Self {
        let mut quadrature = Self::default();
        quadrature.refine(1);
        quadrature
    }

    /// Divide every section of the following steps into `fineness` panels.
    pub(crate) fn refine(&mut self, fineness: usize) {
        self.fineness = fineness.max(1);
        // Almost all steps have one kink at most.
        let most = PanelRule::LOBATTO.new_points() * 2 * self.fineness + 1;
        self.powers.reserve(most.saturating_sub(self.powers.len()));
        self.sections.reserve(2);
        self.begin(self.end, self.last_power());
    }

    /// Continue at `t` with `powers`, which are assumed constant before.
    pub(crate) fn begin(&mut self, t: f64, powers: P) {
        (self.start, self.end) = (t, t);
        self.at_start = self.at_end;
        self.lay_out(&PanelRule::SIMPSON, &[], powers);
    }

    /// Discard the energies after `t` within the last step.
    pub(crate) fn cut(&mut self, t: f64) {
        self.at_end = self.energies(t);
        self.end = t;
    }

    /// Prepare the powers of a step with `kinks`; the first one is the power at its start.
    fn lay_out(&mut self, rule: &PanelRule, kinks: &[f64], at_start: P) {
        self.sections.clear();
        let inside = kinks.iter().filter(|&&kink| 0.0 < kink && kink < 1.0);
        self.sections.extend(inside);
        self.sections.sort_unstable_by(f64::total_cmp);
        self.sections.dedup();
        self.sections.push(1.0);
        self.powers.clear();
        let count = rule.new_points() * self.panels() + 1;
        self.powers.resize(count, at_start);
    }

    /// Return the formula of the last step, determined from the number of its powers.
    fn rule(&self) -> &'static PanelRule {
        const { [&PanelRule::SIMPSON, &PanelRule::LOBATTO] }
            .into_iter()
            .find(|rule| self.powers.len() == rule.new_points() * self.panels() + 1)
            .unwrap_or(const { &PanelRule::LOBATTO })
    }

    /// Return the number of panels of the last step.
    fn panels(&self) -> usize {
        self.fineness * self.sections.len()
    }

    /// Return the section of a panel of the last step, as two fractions of the step, and the index of the panel in it.
    fn section_of(&self, panel: usize) -> ([f64; 2], usize) {
        let section = panel / self.fineness;
        let begin = section.checked_sub(1).map_or(0.0, |i| self.sections[i]);
        (
            [begin, self.sections[section]],
            panel - section * self.fineness,
        )
    }

    /// Return whether this quadrature may replace `other`.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        self.fineness == other.fineness
            && self.powers.len() == self.rule().new_points() * self.panels() + 1
            && self.sections.first().is_some_and(|&end| end > 0.0)
            && self.sections.is_sorted_by(|a, b| a < b)
            && self.sections.last() == Some(&1.0)
            && self.start <= self.end
    }

    /// Copy `other` within the allocated memory.
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

    /// Return the number of panels in each section of a step.
    pub(crate) fn fineness(&self) -> usize {
        self.fineness
    }

    /// Return the number of evaluations of the right-hand side by the quadrature.
    pub(crate) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Add the energies of a step with the power `at_end` at its end, by this formula; `powers_at` evaluates the powers at a fraction of
    /// the step and its time. The step is divided at the `kinks` of the powers, which are fractions of the step.
    pub(crate) fn add_step(
        &mut self,
        step: &Step,
        (rule, kinks): (&PanelRule, &[f64]),
        at_end: P,
        mut powers_at: impl FnMut(f64, f64) -> P,
    ) {
        let length = step.end - step.start;
        self.lay_out(rule, kinks, self.last_power());
        let new_points = rule.new_points();
        let last = self.powers.len() - 1;
        for i in 1..last {
            let ([begin, end], panel) = self.section_of((i - 1) / new_points);
            let inner = rule.points[1 + (i - 1) % new_points];
            let part = begin + (end - begin) * ((inner + panel as f64) / self.fineness as f64);
            self.evaluations += 1;
            self.powers[i] = powers_at(part, step.start + part * length);
        }
        self.powers[last] = at_end;
        self.at_start = self.at_end;
        (self.start, self.end) = (step.start, step.end);
        // Sum of weights times powers, over the width of each panel.
        for panel in 0..self.panels() {
            let ([begin, end], _) = self.section_of(panel);
            let width = (end - begin) * length / self.fineness as f64;
            self.at_end += rule.whole(self.powers_of(rule, panel)).scaled(width);
        }
    }

    /// Count an evaluation at the end of a step.
    pub(crate) fn count_evaluation(&mut self) {
        self.evaluations += 1;
    }

    /// Return the powers at the points of a panel.
    fn powers_of(&self, rule: &PanelRule, panel: usize) -> &[P] {
        let new_points = rule.new_points();
        &self.powers[new_points * panel..=new_points * (panel + 1)]
    }

    fn last_power(&self) -> P {
        self.powers.last().copied().unwrap_or_default()
    }

    /// Return the dissipated energies and the external work at `t` within the last step \[J\].
    pub(crate) fn energies(&self, t: f64) -> P {
        if t >= self.end || self.end <= self.start {
            return self.at_end + self.last_power().scaled(t - self.end);
        }
        let length = self.end - self.start;
        let rule = self.rule();
        let mut sum = self.at_start;
        for panel in 0..self.panels() {
            let ([begin, end], number) = self.section_of(panel);
            let width = (end - begin) * length / self.fineness as f64;
            // Position in the section in panel widths; panels before it count in full, panels after it not at all.
            let place = (t - self.start) / width - begin * length / width;
            let part = (place - number as f64).clamp(0.0, 1.0);
            let to_here = rule.integral_to(part, self.powers_of(rule, panel));
            sum += to_here.scaled(width);
        }
        sum
    }
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

    /// The quadrature of one step from 0 to 2 s with `panels` in each section, and the dissipated power `power`.
    fn metered(
        panels: usize,
        kinks: (&PanelRule, &[f64]),
        power: impl Fn(f64) -> f64,
    ) -> EnergyQuadrature<Both> {
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
    fn powers_of_degree_five_and_of_degree_three_are_summed_exactly() {
        for (rule, degree) in [(&PanelRule::LOBATTO, 5), (&PanelRule::SIMPSON, 3)] {
            for panels in [1, 3] {
                let quadrature = metered(panels, (rule, &[]), |t| t.powi(degree));
                let exact = 2f64.powi(degree + 1) / f64::from(degree + 1);
                assert!((quadrature.energies(2.0).0 - exact).abs() < 1e-13 * exact);
                assert!((quadrature.energies(2.0).1 - 2.0).abs() < 1e-14);
                let beyond = metered(panels, (rule, &[]), |t| t.powi(degree + 1));
                let exact = 2f64.powi(degree + 2) / f64::from(degree + 2);
                assert!((beyond.energies(2.0).0 - exact).abs() > 1e-6 * exact);
            }
        }
    }

    #[test]
    fn inside_a_step_the_sum_is_that_of_a_cubic_or_a_parabola() {
        for (rule, degree) in [(&PanelRule::LOBATTO, 3), (&PanelRule::SIMPSON, 2)] {
            for panels in [1, 3] {
                let quadrature = metered(panels, (rule, &[]), |t| 1.0 + t.powi(degree));
                for t in [0.0f64, 0.3, 1.0, 1.7, 2.0] {
                    let exact = t + t.powi(degree + 1) / f64::from(degree + 1);
                    assert!((quadrature.energies(t).0 - exact).abs() < 1e-13, "{t}");
                }
            }
        }
    }

    #[test]
    fn powers_with_kinks_are_summed_exactly_where_the_step_is_divided_there() {
        let power = |t: f64| (t - 0.3).max(0.0).powi(3) + (t - 1.4).max(0.0);
        let energy = |t: f64| (t - 0.3).max(0.0).powi(4) / 4.0 + (t - 1.4).max(0.0).powi(2) / 2.0;
        for panels in [1, 3] {
            let quadrature = metered(
                panels,
                (&PanelRule::LOBATTO, &[0.7, 0.15, 0.0, 0.7, 1.2]),
                power,
            );
            for t in [0.0, 0.2, 0.3, 0.9, 1.4, 1.7, 2.0] {
                assert!((quadrature.energies(t).0 - energy(t)).abs() < 1e-13, "{t}");
            }
            let undivided = metered(panels, (&PanelRule::LOBATTO, &[]), power)
                .energies(2.0)
                .0;
            assert!((undivided - energy(2.0)).abs() > 1e-4, "{undivided}");
        }
    }
}
