//! Contact onsets and ends inside one step that leave no difference between its two ends.

use super::Dynamics;
use super::contact_events::Onset;
use crate::chain::contact::{ContactId, ContactPath};
use crate::integrator::event_location::Cubic;
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
    pub fn in_step_contacts(&self) -> u64 {
        self.events.in_step_contacts
    }

    /// Return the largest penetration inside the last step of `length` \[s\] of contacts that are open at both of its ends \[m\].
    ///
    /// Call after the event screening of this step.
    pub(super) fn deepest_in_step_contact(&self, length: f64) -> f64 {
        let contacts = self.kernels.screening.contacts(&self.model);
        let depths = contacts.filter_map(|(contact, ends)| touch(contact, ends, length));
        depths.fold(0.0, f64::max)
    }

    /// Count contacts inside the last step, and restart the memory of contacts that were open for a part of it.
    pub(super) fn record_in_step_events(&mut self, adams: &Adams, step: &Step) {
        let length = step.end - step.start;
        let (model, memory, events) = (&self.model, &self.memory, &mut self.events);
        for (contact, ends) in self.kernels.screening.contacts(model) {
            events.in_step_contacts += u64::from(touch(contact, ends, length).is_some());
            let Some(part) = parting(ends, length).filter(|_| memory.has(contact)) else {
                continue;
            };
            // The cubic is an estimate: only a separation confirmed by the dense output is an event.
            let path = ContactPath::new(model, adams, contact);
            let open = |path: &ContactPath| path.at(step.start + part * length).penetration < 0.0;
            if path.is_some_and(|path| open(&path)) {
                let onset = Onset::locate((model, adams, step), contact, Some(ends));
                events.begun.extend(onset);
            }
        }
        self.begin_located_contacts();
    }
}

/// Return whether a contact is open at both `ends` of a step, approaching at the start and separating at the end.
fn reverses_while_open([start, end]: [[f64; 2]; 2]) -> bool {
    start[0] < 0.0 && end[0] < 0.0 && start[1] > 0.0 && end[1] < 0.0
}

/// Return the penetration inside a step of `length` h \[s\] of a contact between two open `ends` \[m\]; `None` without one.
///
/// Hinges and rollers: maximum of the cubic Hermite interpolant. The tip of a tooth is a corner, which a cubic does not approximate.
/// There it is the intersection of the tangents, with values a, b and slopes a', b': δ = (b a' - a b' - h a' b')/(a' - b').
fn touch(contact: ContactId, ends: [[f64; 2]; 2], length: f64) -> Option<f64> {
    if !reverses_while_open(ends) {
        return None;
    }
    let [start, end] = ends;
    let depth = if let ContactId::Tooth(_) = contact {
        let ([start, rise], [end, fall]) = (start, end);
        Some((end * rise - start * fall - length * rise * fall) / (rise - fall))
    } else {
        Cubic::through(start, end, length).highest_inside()
    };
    depth.filter(|&depth| depth > 0.0)
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
