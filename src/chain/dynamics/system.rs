//! Implementation of `System` for the chain drive: interface between the dynamics and a run.

use std::sync::Arc;

use super::energy::prescribed_energy;
use super::rows::{HINGES, ROLLERS, write_row};
use super::{Checkpoint, Dynamics, Losses, Powers};
use crate::chain::model::{CompiledContactLaw, Model};
use crate::chain::report::{self, Groups};
use crate::error::Result;
use crate::force_law::{Friction, LuGre, Regions};
use crate::integrator::{Adams, OdeSystem, Step};
use crate::system::{Channel, Energy, EventCounts, Identity, Row, System, hash};

/// Remedy for the energy balance with sharp regions of teeth, whose residual does not decrease with the accuracy.
const KEPT_REGIONS: &str = "regions = \"kept\": with \"sharp\", a bushing that crosses into another region of a tooth under \
     load gains or loses elastic energy, at any accuracy";

/// Steps from one projection of ideal hinges to the next.
///
/// In between their ends drift apart by the errors of the steps. Projected after each step, those of the published drive are 7e-13 m apart in
/// place of 4e-11 m, but a step has a third more instructions.
const STEPS_BETWEEN_PROJECTIONS: u64 = 4;

impl System for Dynamics {
    type Groups = Groups;
    type Powers = Powers;
    type Checkpoint = Checkpoint;

    const KIND: &'static str = "chain drive";
    const STEPS_BETWEEN_CLOCK_READINGS: u32 = 64;

    fn identity(&self) -> Vec<Identity> {
        identity(&self.inputs.compiled)
    }

    fn begin_step(&mut self, adams: &mut Adams) {
        self.kernels.begin_step(adams.time());
        self.follow_with_pawls(adams.y());
        self.reset_bristles_of_ended_contacts(adams);
        self.forget_ended_contacts();
        self.restart_at_kink_of_end(adams);
        self.place_ends_on_their_curves(adams);
    }

    fn finish_step(&mut self, adams: &mut Adams, step: &Step) -> Result<()> {
        self.record_contact_events(adams, step);
        if self.projects_hinges(adams) {
            (self.kernels).project_hinges(&self.model, adams.solution_mut());
        }
        self.kernels.end_step();
        Ok(())
    }

    fn longest_step(&mut self, adams: &Adams) -> f64 {
        let of_inputs = self.longest_step_of_inputs(adams.time());
        self.longest_step_past_teeth().min(of_inputs)
    }

    /// Use the contacts of the last evaluation, that of the failed step; without any, those of the dense output at `time`.
    fn culprit(&mut self, adams: &Adams, time: f64, component: usize) -> String {
        let model = Arc::clone(&self.model);
        // Where all errors are zero, the last component is named, which is padding.
        let coordinate = (component % model.coordinates).min(model.used_coordinates - 1);
        let body = model.body_of_coordinate(coordinate);
        let contact = self.busiest_contact(Some(body)).or_else(|| {
            let mut y = vec![0.0; self.dimension()];
            adams.interpolate(time, &mut y);
            self.differentiate(time, &y);
            self.busiest_contact(Some(body))
        });
        let contact = contact.unwrap_or_else(|| "not in contact".to_string());
        format!("{} ({contact})", model.body_names()[body])
    }

    fn busiest(&self) -> String {
        let contact = self.busiest_contact(None);
        contact.unwrap_or_else(|| "nothing in contact".to_string())
    }

    fn event_counts(&self) -> EventCounts {
        let counts = self.memory.counts();
        EventCounts {
            onsets: counts.onsets,
            onsets_at_minimum_velocity: counts.at_minimum,
            in_step_contacts: self.in_step_contacts(),
        }
    }

    fn keeps_energy(&self) -> bool {
        self.keeps_energy
    }

    fn stop_metering(&mut self) {
        self.keep_energy(false);
    }

    fn begin_metering(&mut self, adams: &Adams, now: f64) {
        self.begin_energy_quadrature(adams, now);
    }

    fn resume_metering(&mut self, adams: &Adams) {
        self.resume_energy_quadrature(adams);
    }

    fn reach_step_end(&mut self, adams: &Adams, step: &Step, peaks: bool) {
        if self.keeps_energy || peaks {
            self.reach_end_of_step(adams, step, peaks);
        }
    }

    fn meter_step(&mut self, adams: &Adams, step: &Step) {
        self.add_energies_of_step(adams, step);
    }

    fn sums_at(&self, t: f64) -> Powers {
        self.quadrature.energies(t)
    }

    fn energy_evaluations(&self) -> u64 {
        self.quadrature.evaluations()
    }

    fn energy(&self) -> Energy {
        self.energy()
    }

    fn prescribed_energy(&self) -> f64 {
        prescribed_energy(self)
    }

    /// The work of friction contains the energy stored in bristles, which is not dissipated.
    fn without_stored(&self, mut sums: Powers) -> Powers {
        if !self.model.bristles.is_empty() {
            let stored = self.stored();
            sums.dissipated -= stored.total();
            sums.losses = stored.subtract_from(sums.losses);
        }
        sums
    }

    fn kinetic_energy_at(&self, speed: f64) -> f64 {
        let model = &self.model;
        let links = (0..model.links).filter(|&i| !model.is_held(i));
        let mass: f64 = links.map(|i| model.chain.mass[i]).sum();
        0.5 * mass * speed * speed
    }

    fn energy_remedy(&self) -> Option<&'static str> {
        (self.model.teeth.law.regions == Regions::Sharp).then_some(KEPT_REGIONS)
    }

    fn records_energy(groups: Groups) -> bool {
        groups.energy
    }

    fn channels(&self, groups: Groups) -> Vec<Channel> {
        report::channels(&self.model, groups)
    }

    /// Contacts that this drive does not have have no channel.
    fn losses(&self, powers: &Powers) -> Vec<(&'static str, f64)> {
        let Losses {
            hinge_contact,
            tooth_contact,
            hinge_friction,
            tooth_friction,
            roller_contact,
            roller_friction,
            hinge_film,
        } = powers.losses;
        let mut losses = vec![
            ("energy_hinge_contact", hinge_contact),
            ("energy_tooth_contact", tooth_contact),
            ("energy_hinge_friction", hinge_friction),
            ("energy_tooth_friction", tooth_friction),
        ];
        if self.model.hinges.ideal {
            losses.retain(|(name, _)| name.contains("tooth"));
        }
        if self.model.rollers.is_some() {
            losses.push(("energy_roller_contact", roller_contact));
            losses.push(("energy_roller_friction", roller_friction));
        }
        if self.model.hinges.film.is_some() {
            losses.push(("energy_hinge_film", hinge_film));
        }
        losses
    }

    fn peak_sizes(&self, groups: Groups) -> Vec<usize> {
        let (links, rollers) = (self.model.links, self.model.roller_count());
        let of = |recorded: bool, count: usize| if recorded { count } else { 0 };
        vec![
            of(groups.hinges, links),
            of(groups.hinges, rollers),
            of(groups.teeth, links),
        ]
    }

    fn evaluate_step_end(&mut self, adams: &Adams) {
        self.differentiate(adams.time(), adams.y());
        self.kernels.return_to_step_end();
    }

    fn write_peak_forces(&self, kind: usize, forces: &mut [f64]) {
        match kind {
            HINGES => self.write_hinge_forces(forces),
            ROLLERS => self.write_roller_forces(forces),
            _ => self.write_tooth_forces(forces),
        }
    }

    fn evaluate_report(&mut self, adams: &Adams, t: f64, groups: Groups) {
        let request = groups.request(&self.model);
        let mut y = std::mem::take(&mut self.inside);
        adams.interpolate(t, &mut y);
        self.evaluate_for(request, t, &y);
        self.inside = y;
        self.note_reported_ranges(request);
    }

    fn write_row(&mut self, row: &mut Row, t: f64, groups: Groups) {
        let mut forces = std::mem::take(&mut self.tooth_forces);
        write_row(row, self, t, groups, &mut forces);
        self.tooth_forces = forces;
    }

    fn checkpoint(&self) -> Checkpoint {
        self.to_checkpoint()
    }

    fn restored(&self, checkpoint: &Checkpoint, _adams: &Adams) -> Option<Self> {
        self.with_checkpoint(checkpoint)
    }
}

impl Dynamics {
    /// Return whether the last step ends with a projection of ideal hinges.
    pub(super) fn projects_hinges(&self, adams: &Adams) -> bool {
        self.model.hinges.ideal && (adams.counts().steps).is_multiple_of(STEPS_BETWEEN_PROJECTIONS)
    }
}

/// Return the properties that identify a model and name the differences between two models.
fn identity(model: &Model) -> Vec<Identity> {
    const DRIVE: &str = "make the simulation with the drive of the state";
    const LAWS: &str = "make the simulation with the laws of the state";
    let law = |law: &CompiledContactLaw, friction: Option<Friction>, bristles: Option<LuGre>| {
        let damping = if law.lambda > 0.0 {
            "damped"
        } else {
            "undamped"
        };
        let regions = format!("{:?}", law.regions).to_lowercase();
        let friction = friction.map_or(String::new(), |friction| {
            let name = friction.regularization.name();
            format!(", friction {} ({name})", friction.coefficient)
        });
        let bristles = bristles.map_or(String::new(), |law: LuGre| {
            let (most, least) = (law.static_coefficient, law.kinetic_coefficient);
            format!(", bristles {most} to {least}")
        });
        let elastic = law.elastic.name();
        format!("{elastic}, {damping}, regions {regions}{friction}{bristles}")
    };
    let film = model.hinges.film.map_or(String::new(), |film| {
        format!(", film of {} Pa s", film.viscosity)
    });
    let hinge_law = law(
        &model.hinges.law,
        model.hinges.friction,
        model.hinges.bristles,
    ) + &film;
    let tooth_law = law(&model.teeth.law, model.teeth.friction, model.teeth.bristles);
    let teeth: Vec<u32> = model.sprockets.iter().map(|s| s.profile.teeth).collect();
    let of = |field, value, remedy| Identity {
        field,
        value,
        remedy,
    };
    vec![
        of("links", model.links.to_string(), DRIVE),
        of("teeth", format!("{teeth:?}"), DRIVE),
        of("hinge law", hinge_law, LAWS),
        of("tooth law", tooth_law, LAWS),
        of(
            "min_impact_velocity",
            model.min_impact_velocity.to_string(),
            LAWS,
        ),
        of(
            "drive",
            // The debug text contains every field, later additions included, and every bit of its numbers.
            format!("model {:016x}", hash(format!("{model:?}").as_bytes())),
            "some number of drive, start or laws differs, or the version of rustchain: make the simulation with those of the state",
        ),
    ]
}
