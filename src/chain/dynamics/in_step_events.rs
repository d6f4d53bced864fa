//! Contacts that open or close inside one step, where neither of its ends shows it.

use super::Dynamics;
use crate::chain::contact::{HingePath, RollerPath, ToothPath};
use crate::integrator::event_location::{Cubic, crossing_between};
use crate::integrator::{Adams, Step};

/// No step moves a bushing farther along a sprocket than this part of a pitch: a tooth is not passed unseen.
const FARTHEST: f64 = 0.1;

impl Dynamics {
    /// How long the next step may be \[s\].
    #[must_use]
    pub fn longest_step(&self) -> f64 {
        FARTHEST * 2.0 * self.model.half_pitch / self.fastest
    }

    /// Touches inside steps, between two ends apart, that were within the accuracy and let pass.
    #[must_use]
    pub fn unseen_touches(&self) -> u64 {
        self.unseen_touches
    }

    /// Depth \[m\] of the deepest touch inside a step of `length` \[s\], watched just now, of contacts apart at both of its ends.
    pub(super) fn deepest_unseen(&self, length: f64) -> f64 {
        let watch = &self.kernels.watch;
        let hinges = (0..self.model.links).map(|k| watch.hinge(k));
        let hinges = hinges.filter_map(|ends| touch(ends, length));
        let teeth = watch.candidates(self.model.links);
        let teeth = teeth.filter_map(|(.., ends)| touch_of_tip(ends, length));
        let rollers = (0..self.model.roller_count()).map(|k| watch.roller(k));
        let rollers = rollers.filter_map(|ends| touch(ends, length));
        hinges.chain(rollers).chain(teeth).fold(0.0, f64::max)
    }

    /// Counts touches, and begins anew the memory of contacts that were apart for a part of the step just made.
    pub(super) fn look_inside(&mut self, adams: &Adams, step: &Step) {
        let length = step.end - step.start;
        let times = [step.start, step.end];
        let (model, watch) = (&self.model, &self.kernels.watch);
        for k in 0..model.links {
            let ends = watch.hinge(k);
            self.unseen_touches += u64::from(touch(ends, length).is_some());
            let Some(part) = parting(ends, length).filter(|_| self.memory.hinge_speed()[k] > 0.0)
            else {
                continue;
            };
            let path = HingePath::new(model, adams, k);
            let contact = |t| path.at(t);
            if path.at(step.start + part * length).penetration < 0.0 {
                let (_, rate) = crossing_between(contact, times, ends);
                self.memory.begin_hinge(k, rate);
            }
        }
        for k in 0..model.roller_count() {
            let ends = watch.roller(k);
            self.unseen_touches += u64::from(touch(ends, length).is_some());
            let Some(part) = parting(ends, length).filter(|_| self.memory.roller_speed()[k] > 0.0)
            else {
                continue;
            };
            let Some(path) = RollerPath::new(model, adams, k) else {
                continue;
            };
            let contact = |t| path.at(t);
            if path.at(step.start + part * length).penetration < 0.0 {
                let (_, rate) = crossing_between(contact, times, ends);
                self.memory.begin_roller(k, rate);
            }
        }
        for (s, k, ends) in watch.candidates(model.links) {
            self.unseen_touches += u64::from(touch_of_tip(ends, length).is_some());
            let pair = s * model.links + k;
            let Some(part) = parting(ends, length).filter(|_| self.memory.tooth_speed[pair] > 0.0)
            else {
                continue;
            };
            let path = ToothPath::new(model, adams, k, s);
            let contact = |t| path.at(t).contact;
            if contact(step.start + part * length).penetration < 0.0 {
                let (t, rate) = crossing_between(contact, times, ends);
                self.memory.begin_tooth(pair, rate, path.at(t).surface);
                self.begun.push((s, k));
            }
        }
        for (s, k) in self.begun.drain(..) {
            self.kernels
                .candidates
                .update_memory(&self.model, &self.memory, s, k);
        }
    }
}

/// Whether a contact is apart at both `ends` of a step and came nearer in between.
fn has_turned([start, end]: [[f64; 2]; 2]) -> bool {
    start[0] < 0.0 && end[0] < 0.0 && start[1] > 0.0 && end[1] < 0.0
}

/// Depth \[m\] of a touch inside a step of `length` \[s\] between two `ends` apart, where two tangents meet: the tip of a tooth is
/// a corner, which no cubic follows.
fn touch_of_tip(ends: [[f64; 2]; 2], length: f64) -> Option<f64> {
    let [[start, rise], [end, fall]] = ends;
    let depth = (end * rise - start * fall - length * rise * fall) / (rise - fall);
    (has_turned(ends) && depth > 0.0).then_some(depth)
}

/// The same of a smooth path.
fn touch(ends: [[f64; 2]; 2], length: f64) -> Option<f64> {
    if !has_turned(ends) {
        return None;
    }
    let [start, end] = ends;
    let cubic = Cubic::through(start, end, length);
    cubic.highest_inside().filter(|&depth| depth > 0.0)
}

/// Where a contact was farthest apart inside a step of `length` \[s\] between two `ends` in touch, as a part of the step.
fn parting([start, end]: [[f64; 2]; 2], length: f64) -> Option<f64> {
    if start[0] <= 0.0 || end[0] <= 0.0 {
        return None;
    }
    Cubic::through(start, end, length).lowest_inside()
}
