//! Contacts beyond the end of their force law: the first hinge or roller, and the first tooth contact, with a message each.

use super::Dynamics;
use crate::chain::report::OutputRequest;
use crate::force_law::{ElasticLaw, Regions, past_range};
use crate::geometry::Surface;
use crate::integrator::Adams;

/// Messages on the first contacts beyond the end of their law.
#[derive(Debug, Clone, Default)]
pub(super) struct PastRanges {
    /// First hinge or roller.
    pub(super) hinge: Option<String>,
    /// First tooth contact.
    pub(super) tooth: Option<String>,
}

impl Dynamics {
    /// Record the first joint and the first tooth contact beyond the end of their law at the end of a step.
    pub(super) fn note_ranges(&mut self, adams: &Adams) {
        let model = &self.model;
        // Bushings in rollers have the law of the hinges.
        if model.hinges.law.elastic.has_an_end() && self.past_ranges.hinge.is_none() {
            let hinges = self.kernels.hinge_depths(model);
            let rollers = self.kernels.roller_depths(model);
            self.past_ranges.hinge = self.joint_past_its_end(hinges, rollers);
        }
        let model = &self.model;
        if model.teeth.law.elastic.has_an_end() && self.past_ranges.tooth.is_none() {
            let law = &model.teeth.law.pairs;
            let ends = law.pairs().iter().map(|pair| law.form().range_end(pair));
            let nearest_end = ends.fold(f64::INFINITY, f64::min);
            let beyond = |(_, _, depth, _): (usize, usize, f64, f64)| depth > nearest_end;
            if self.kernels.tooth_contacts(model).any(beyond) {
                self.evaluate(adams.time(), adams.y());
                self.past_ranges.tooth = self.tooth_past_its_end();
            }
        }
    }

    /// Record the same for the last evaluation, that of a report of `request`: penetrations inside a step may exceed those at its ends.
    pub(crate) fn note_reported_ranges(&mut self, request: OutputRequest) {
        let model = &self.model;
        if request.hinges
            && model.hinges.law.elastic.has_an_end()
            && self.past_ranges.hinge.is_none()
        {
            let (hinges, rollers) = (
                &self.evaluated.hinges.penetration,
                &self.evaluated.rollers.penetration,
            );
            self.past_ranges.hinge = self.joint_past_its_end(hinges, rollers);
        }
        if request.teeth && model.teeth.law.elastic.has_an_end() && self.past_ranges.tooth.is_none()
        {
            self.past_ranges.tooth = self.tooth_past_its_end();
        }
    }

    /// Return a message on the first hinge, or bushing in its roller, beyond the end of its law. A law without an end has an infinite one.
    fn joint_past_its_end(&self, hinges: &[f64], rollers: &[f64]) -> Option<String> {
        let model = &self.model;
        let law = &model.hinges.law;
        let pair = law.pairs.pair(0);
        let end = pair.range_end();
        let force = pair.force(end);
        let end_of = |k: usize| {
            end + model
                .hinges
                .compliance_at(k)
                .map_or(0.0, |given| given * force)
        };
        // Elastic plates in series: the total approach at the end of the law is δ_end + C f(δ_end).
        if let Some(k) = (0..hinges.len()).find(|&k| hinges[k] > end_of(k)) {
            let name = format!("hinge {}", k + 1);
            return Some(past_range(law.elastic, &name, hinges[k], end_of(k)));
        }
        let law = &model.rollers.as_ref()?.law;
        let end = law.pairs.pair(0).range_end();
        let k = rollers.iter().position(|&depth| depth > end)?;
        let name = format!("bushing {0} in roller {0}", k + 1);
        Some(past_range(law.elastic, &name, rollers[k], end))
    }

    /// Return a message on the first tooth contact of the last evaluation beyond the end of the law for its surface.
    fn tooth_past_its_end(&self) -> Option<String> {
        let model = &self.model;
        self.evaluated.teeth.near.iter().find_map(|&pair| {
            let pair = pair as usize;
            let depth = self.evaluated.teeth.penetration[pair];
            let (s, k) = (pair / model.links, pair % model.links);
            let number = model.tooth_pair(s, self.stiffness_surface(pair));
            let end = model.teeth.law.pairs.pair(number).range_end();
            let name = || format!("{} on {}", model.on_teeth_name(k), model.wheel_name(s));
            (depth > end).then(|| past_range(model.teeth.law.elastic, &name(), depth, end))
        })
    }

    /// Return the messages on the first contacts beyond the end of their law, one line each.
    pub fn past_range(&self) -> impl Iterator<Item = &String> {
        self.past_ranges.hinge.iter().chain(&self.past_ranges.tooth)
    }

    /// Return the surface that determines the stiffness of a pair: that at the contact onset with kept regions, else the present one.
    pub(super) fn stiffness_surface(&self, pair: usize) -> Surface {
        if self.model.teeth.law.regions == Regions::Kept
            && self.memory.tooth_impact_velocity[pair] > 0.0
        {
            self.memory.tooth_surface[pair]
        } else {
            self.evaluated.teeth.surface(pair)
        }
    }
}
