//! Contact states of the last evaluation: penetrations, forces, changes against the impact velocity memory, and seated bushings.

use super::{Kernels, on_teeth};
use crate::chain::contact::{Seated, SprocketFrame, ToothJumps, seen_from_teeth};
use crate::chain::model::Model;
use crate::geometry::Vec2;

impl Kernels {
    /// Return whether any contact state of the last evaluation differs from the impact velocity memory.
    pub(crate) fn changed(&self) -> bool {
        self.changed.contains(&true)
    }

    /// Return the same by [`ContactKind`].
    pub(crate) fn changes(&self) -> [bool; 3] {
        self.changed
    }

    /// Return position and motion of sprocket `s` at the last evaluation.
    pub(crate) fn sprocket_frame(&self, s: usize) -> SprocketFrame {
        let pose = &self.poses[s];
        SprocketFrame {
            center: pose.center.into(),
            velocity: pose.velocity.into(),
            spin: pose.spin,
            cos: pose.direction[0],
            sin: pose.direction[1],
        }
    }

    /// Return the penetration of every hinge at the last evaluation \[m\]; zero without contact.
    pub(crate) fn hinge_depths(&self, model: &Model) -> &[f64] {
        &self.chain.depth[..model.links]
    }

    /// Return the penetration of every bushing in its roller at the last evaluation \[m\]; zero without contact.
    pub(crate) fn roller_depths(&self, model: &Model) -> &[f64] {
        let rollers = self.rollers.as_ref();
        rollers.map_or(&[], |rollers| &rollers.arrays.depth[..model.links])
    }

    /// Return the normal force of every bushing in its roller at the last evaluation \[N\].
    pub(crate) fn roller_forces(&self, model: &Model) -> &[f64] {
        let rollers = self.rollers.as_ref();
        rollers.map_or(&[], |rollers| &rollers.arrays.force[..model.links])
    }

    /// Return the force of each hinge that rows have, at the last evaluation \[N\]: the normal force, or with lubricant the whole force.
    pub(crate) fn hinge_forces(&self, model: &Model) -> impl Iterator<Item = f64> {
        self.or_ideal(model, self.contact_forces(model))
    }

    /// Write the same forces.
    pub(crate) fn write_hinge_forces(&self, model: &Model, forces: &mut [f64]) {
        if self.ideal.is_none() {
            forces.copy_from_slice(&self.contact_forces(model)[..model.links]);
            return;
        }
        for (to, force) in forces.iter_mut().zip(self.hinge_forces(model)) {
            *to = force;
        }
    }

    /// Return the normal force of each hinge at the last evaluation, or the force of each ideal one \[N\].
    pub(crate) fn normal_hinge_forces(&self, model: &Model) -> impl Iterator<Item = f64> {
        self.or_ideal(model, &self.chain.force)
    }

    /// Return the forces of hinges with contacts that rows have \[N\].
    fn contact_forces(&self, model: &Model) -> &[f64] {
        match model.hinges.film {
            Some(_) => &self.chain.lubricated_force,
            None => &self.chain.force,
        }
    }

    /// Return the forces of ideal hinges, or these `forces` of hinges with contacts \[N\].
    fn or_ideal<'a>(
        &'a self,
        model: &Model,
        forces: &'a [f64],
    ) -> impl Iterator<Item = f64> + use<'a> {
        (0..model.links).map(move |k| match &self.ideal {
            Some(ideal) => {
                let [x, y] = [ideal.force[0][k], ideal.force[1][k]];
                (x * x + y * y).sqrt()
            }
            None => forces[k],
        })
    }

    /// Return sprocket, bushing, penetration \[m\] and normal force \[N\] of every candidate at the last evaluation.
    pub(crate) fn tooth_contacts(
        &self,
        model: &Model,
    ) -> impl Iterator<Item = (usize, usize, f64, f64)> {
        let links = model.links;
        let sprockets = self.candidates.sprockets.iter().enumerate();
        sprockets.flat_map(move |(s, candidates)| {
            candidates
                .bushings(links)
                .map(move |(slot, k)| (s, k, candidates.depth[slot], candidates.force[slot]))
        })
    }

    /// Return the centre of bushing `k`, or of its roller, at the last evaluation \[m\].
    fn place_on_teeth(&self, k: usize) -> Vec2 {
        let [x, y] = &on_teeth(&self.chain, self.rollers.as_deref()).bushing;
        Vec2::new(x[k], y[k])
    }

    /// Detect jumps over the teeth of any sprocket at the last evaluation, which was at time `t` \[s\].
    pub(crate) fn find_tooth_jumps(&mut self, model: &Model, t: f64, jumps: &mut ToothJumps) {
        for s in 0..model.toothed() {
            let (sprocket, frame) = (&model.sprockets[s], self.sprocket_frame(s));
            let limit = sprocket.seated_within();
            self.seated.clear();
            for (_, bushing) in self.candidates.sprockets[s].bushings(model.links) {
                let arm = self.place_on_teeth(bushing) - frame.center;
                let in_body = seen_from_teeth(sprocket, &frame, arm);
                if in_body.norm_squared() < limit * limit {
                    let gap = sprocket.profile.nearest_gap(in_body.y.atan2(in_body.x));
                    self.seated.push(Seated { bushing, gap });
                }
            }
            jumps.look(model, (t, s), &self.seated, |k| {
                self.place_on_teeth(k) - frame.center
            });
        }
    }
}
