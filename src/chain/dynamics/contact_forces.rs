//! Forces and penetrations of all contacts at the last evaluation of the right-hand side.

use super::Dynamics;

impl Dynamics {
    /// Return a description of the contact with the largest force at the last evaluation of the right-hand side: of all contacts, or
    /// of those of one `body`.
    ///
    /// Bodies: links, then rollers, then sprockets. For a body that is not a link, all hinges are included.
    #[must_use]
    pub fn busiest_contact(&self, body: Option<usize>) -> Option<String> {
        let (model, n) = (&self.model, self.model.links);
        let of = |bodies: &[usize]| body.is_none_or(|body| bodies.contains(&body));
        let hinges = (self.kernels.hinge_forces(model).enumerate())
            .filter(|&(k, _)| body.is_none_or(|body| body >= n) || of(&[k, (k + 1) % n]))
            .map(|(k, force)| (force, format!("hinge {}", k + 1)));
        let rollers = (0..model.roller_count())
            .filter(|&k| of(&[n + k, model.link_of_bushing(k)]))
            .map(|k| {
                let name = format!("bushing {0} in roller {0}", k + 1);
                (self.kernels.roller_forces(model)[k], name)
            });
        let meets_teeth = |k: usize| match &model.rollers {
            Some(_) => n + k,
            None => model.link_of_bushing(k),
        };
        let teeth = self
            .kernels
            .tooth_contacts(model)
            .filter(|&(s, k, ..)| of(&[meets_teeth(k), model.wheel_body(s)]))
            .map(|(s, k, _, force)| {
                let gap = self.kernels.candidates.gap(model, s, k).unwrap_or(0);
                let (what, wheel) = (model.on_teeth_name(k), model.wheel_name(s));
                let name = format!("{what} on {wheel}, gap {gap}");
                (force, name)
            });
        hinges
            .chain(rollers)
            .chain(teeth)
            .filter(|(force, _)| *force != 0.0)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(force, name)| format!("{name} pressed by {force:.3e} N"))
    }

    /// Write the force of every hinge that rows have, at the last evaluation of the right-hand side \[N\].
    pub(crate) fn write_hinge_forces(&self, forces: &mut [f64]) {
        self.kernels.write_hinge_forces(&self.model, forces);
    }

    /// Write the normal force of every bushing in its roller at the last evaluation of the right-hand side \[N\].
    pub(crate) fn write_roller_forces(&self, forces: &mut [f64]) {
        forces.copy_from_slice(self.kernels.roller_forces(&self.model));
    }

    /// Write the tooth force on every bushing, summed over all sprockets, at the last evaluation of the right-hand side \[N\].
    pub(crate) fn write_tooth_forces(&self, forces: &mut [f64]) {
        forces.fill(0.0);
        for candidates in &self.kernels.candidates.sprockets {
            for run in &candidates.runs {
                let on_teeth = &candidates.force[run.slot..][..run.length];
                // A run may continue from the last bushing to the first one. Both parts are slices: loops over them are vectorized.
                let (on_last, on_first) =
                    on_teeth.split_at(run.length.min(forces.len() - run.first));
                for (sum, force) in forces[run.first..].iter_mut().zip(on_last) {
                    *sum += force;
                }
                for (sum, force) in forces.iter_mut().zip(on_first) {
                    *sum += force;
                }
            }
        }
    }

    /// Return sprocket, bushing, penetration \[m\] (zero where apart) and normal force \[N\] of every candidate.
    ///
    /// The values are those of the last evaluation of the right-hand side.
    pub fn candidates(&self) -> impl Iterator<Item = (usize, usize, f64, f64)> {
        self.kernels.tooth_contacts(&self.model)
    }

    /// Return the number of candidate lists built so far.
    #[must_use]
    pub fn candidate_refreshes(&self) -> u64 {
        self.kernels.candidates.refreshes()
    }

    /// Return penetration \[m\] (zero where apart) and normal force \[N\] of every hinge at the last evaluation of the right-hand side.
    pub fn hinge_contacts(&self) -> impl Iterator<Item = (f64, f64)> {
        let (kernels, model) = (&self.kernels, &self.model);
        let forces = kernels.normal_hinge_forces(model);
        kernels.hinge_depths(model).iter().copied().zip(forces)
    }

    /// Return penetration \[m\] (zero where apart) and normal force \[N\] of every bushing in its roller.
    ///
    /// The values are those of the last evaluation of the right-hand side.
    pub fn roller_contacts(&self) -> impl Iterator<Item = (f64, f64)> {
        let (kernels, model) = (&self.kernels, &self.model);
        let forces = kernels.roller_forces(model).iter().copied();
        kernels.roller_depths(model).iter().copied().zip(forces)
    }
}
