//! Contact onsets and ends inside one step that leave no difference between its two ends.

use super::Dynamics;
use crate::chain::contact::{HingePath, RollerPath, ToothPath};
use crate::integrator::event_location::{Cubic, onset_between};
use crate::integrator::{Adams, Step};

/// Largest displacement of a bushing relative to a sprocket within one step, as a fraction of the pitch.
///
/// It prevents a step that passes a whole tooth without contact. Doubled or halved, the scenes of docs/development/constants.md give equal
/// runs.
const FARTHEST: f64 = 0.1;

impl Dynamics {
    /// Return the longest permitted next step \[s\]: h = 0.1 p/v, for the largest relative speed v of a bushing and a sprocket.
    #[must_use]
    pub fn longest_step_past_teeth(&self) -> f64 {
        FARTHEST * 2.0 * self.model.half_pitch / self.events.fastest
    }

    /// Return the number of accepted contacts inside steps between two open ends; their penetration was within the accuracy.
    #[must_use]
    pub fn unseen_touches(&self) -> u64 {
        self.events.unseen_touches
    }

    /// Return the largest penetration inside the last step of `length` \[s\] of contacts that are open at both of its ends \[m\].
    ///
    /// Call after the event screening of this step.
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

    /// Count contacts inside the last step, and restart the memory of contacts that were open for a part of it.
    pub(super) fn look_inside(&mut self, adams: &Adams, step: &Step) {
        let length = step.end - step.start;
        let times = [step.start, step.end];
        let (model, watch) = (&self.model, &self.kernels.watch);
        for k in 0..model.links {
            let ends = watch.hinge(k);
            self.events.unseen_touches += u64::from(touch(ends, length).is_some());
            let Some(part) =
                parting(ends, length).filter(|_| self.memory.hinge_impact_velocity()[k] > 0.0)
            else {
                continue;
            };
            let path = HingePath::new(model, adams, k);
            let contact = |t| path.at(t);
            // The cubic is an estimate: only a separation confirmed by the dense output is an event.
            if path.at(step.start + part * length).penetration < 0.0 {
                let (_, rate) = onset_between(contact, times, ends);
                self.memory.begin_hinge(k, rate);
            }
        }
        for k in 0..model.roller_count() {
            let ends = watch.roller(k);
            self.events.unseen_touches += u64::from(touch(ends, length).is_some());
            let Some(part) =
                parting(ends, length).filter(|_| self.memory.roller_impact_velocity()[k] > 0.0)
            else {
                continue;
            };
            let Some(path) = RollerPath::new(model, adams, k) else {
                continue;
            };
            let contact = |t| path.at(t);
            if path.at(step.start + part * length).penetration < 0.0 {
                let (_, rate) = onset_between(contact, times, ends);
                self.memory.begin_roller(k, rate);
            }
        }
        for (s, k, ends) in watch.candidates(model.links) {
            self.events.unseen_touches += u64::from(touch_of_tip(ends, length).is_some());
            let pair = s * model.links + k;
            let Some(part) =
                parting(ends, length).filter(|_| self.memory.tooth_impact_velocity[pair] > 0.0)
            else {
                continue;
            };
            let path = ToothPath::new(model, adams, k, s);
            let contact = |t| path.at(t).contact;
            if contact(step.start + part * length).penetration < 0.0 {
                let (t, rate) = onset_between(contact, times, ends);
                self.memory.begin_tooth(pair, rate, path.at(t).surface);
                self.events.begun.push((s, k));
            }
        }
        for (s, k) in self.events.begun.drain(..) {
            self.kernels
                .candidates
                .update_memory(&self.model, &self.memory, s, k);
        }
    }
}

/// Return whether a contact is open at both `ends` of a step, approaching at the start and separating at the end.
fn reverses_while_open([start, end]: [[f64; 2]; 2]) -> bool {
    start[0] < 0.0 && end[0] < 0.0 && start[1] > 0.0 && end[1] < 0.0
}

/// Return the penetration inside a step of `length` h \[s\] between two open `ends`, at the intersection of their tangents \[m\].
///
/// The tip of a tooth is a corner, which a cubic does not approximate. With values a, b and slopes a', b':
/// δ = (b a' - a b' - h a' b')/(a' - b').
fn touch_of_tip(ends: [[f64; 2]; 2], length: f64) -> Option<f64> {
    let [[start, rise], [end, fall]] = ends;
    let depth = (end * rise - start * fall - length * rise * fall) / (rise - fall);
    (reverses_while_open(ends) && depth > 0.0).then_some(depth)
}

/// Return the same penetration for a smooth path: the maximum of the cubic Hermite interpolant.
fn touch(ends: [[f64; 2]; 2], length: f64) -> Option<f64> {
    if !reverses_while_open(ends) {
        return None;
    }
    let [start, end] = ends;
    let cubic = Cubic::through(start, end, length);
    cubic.highest_inside().filter(|&depth| depth > 0.0)
}

/// Return the relative position of the largest clearance inside a step of `length` \[s\] between two closed `ends`.
///
/// `None`: the cubic Hermite interpolant shows no separation.
fn parting([start, end]: [[f64; 2]; 2], length: f64) -> Option<f64> {
    if start[0] <= 0.0 || end[0] <= 0.0 {
        return None;
    }
    Cubic::through(start, end, length).lowest_inside()
}
