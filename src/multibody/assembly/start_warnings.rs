//! What of a mechanism is worth a second look: parts that nothing holds, contacts that begin pressed in.

use crate::multibody::dynamics::MechanismDynamics;
use crate::multibody::model::MechanismModel;

/// Part of its radius by which a circle may be pressed in at the start without a word.
const PRESSED: f64 = 0.05;

impl MechanismDynamics {
    /// Circles that begin behind an open outline, which they then come through without a force.
    pub(crate) fn starts_behind(&self) -> Vec<String> {
        let contacts = self.model.contacts.iter().zip(&self.model.contact_names);
        let found = contacts.filter(|(contact, _)| contact.is_behind(&self.frames));
        let found = found.map(|(_, name)| {
            format!(
                "contact {name:?}: its circle begins behind the open outline, and touches nothing until it has come out \
                 in front: the material lies on the left of the way through the points; reverse their order if the \
                 circle is in front"
            )
        });
        found.collect()
    }

    /// Contacts that begin pressed in by more than bodies do that are laid on each other.
    pub(crate) fn pressed_starts(&self) -> Vec<String> {
        let contacts = self.model.contacts.iter().zip(&self.model.contact_names);
        let sides = self.model.sides_of_contact.iter();
        let found = contacts.zip(sides).filter_map(|((contact, name), sides)| {
            let depth = contact.penetration(&self.frames, &self.memory[sides.clone()]);
            (depth > PRESSED * contact.radius).then(|| {
                format!(
                    "contact {name:?} begins with its circle of radius {} m pressed in by {depth:.3e} m: it will \
                     spring back; is the body placed as it should be?",
                    contact.radius
                )
            })
        });
        found.collect()
    }
}

/// Bodies that nothing ties to the rest.
pub(crate) fn loose_parts(model: &MechanismModel) -> Vec<String> {
    let mut part: Vec<usize> = (0..model.bodies.len()).collect();
    let joints = model
        .equations
        .iter()
        .map(|e| [e.a.body, e.b.body, e.carrier]);
    let forces = model.forces.iter().map(|f| [f.a.body, f.b.body, f.b.body]);
    let contacts = model
        .contacts
        .iter()
        .map(|c| [c.a.body, c.b.body, c.b.body]);
    let fixed = (0..model.bodies.len())
        .filter(|&i| model.bodies[i].fixed)
        .map(|i| [0, i, i]);
    for [a, b, c] in joints.chain(forces).chain(contacts).chain(fixed) {
        let other = if c == 0 { b } else { c };
        for (x, y) in [(a, b), (b, other)] {
            let (x, y) = (root(&mut part, x), root(&mut part, y));
            part[x.max(y)] = x.min(y);
        }
    }
    for i in 0..part.len() {
        part[i] = root(&mut part, i);
    }
    let mut numbers: Vec<usize> = part.iter().copied().filter(|&p| p != 0).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let names = |number: usize| {
        let members = (0..part.len()).filter(|&i| part[i] == number);
        let names: Vec<String> = members
            .map(|i| format!("{:?}", model.bodies[i].name))
            .collect();
        names.join(", ")
    };
    numbers
        .into_iter()
        .map(|number| {
            format!(
                "nothing connects {} to the ground: they move by gravity and their own velocities only",
                names(number)
            )
        })
        .collect()
}

/// The least body of the part that a body belongs to.
fn root(part: &mut [usize], mut body: usize) -> usize {
    while part[body] != body {
        part[body] = part[part[body]];
        body = part[body];
    }
    body
}
