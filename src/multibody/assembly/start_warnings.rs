//! Warnings on the start: bodies without connection to the ground, and contacts with a large initial penetration.

use crate::error::listed;
use crate::multibody::contact::impact_memory::Memory;
use crate::multibody::description::body::Frame;
use crate::multibody::model::MechanismModel;

/// Initial penetration over the circle's radius above which a warning is given.
const PRESSED: f64 = 0.05;

impl MechanismModel {
    /// Return warnings on circles that start behind an open outline. They exert no force until they have left it.
    pub(crate) fn starts_behind(&self, frames: &[Frame]) -> Vec<String> {
        let contacts = self.contacts.iter().zip(&self.contact_names);
        let found = contacts.filter(|(contact, _)| contact.is_behind(frames));
        let found = found.map(|(_, name)| {
            format!(
                "contact {name:?}: its circle starts behind the open outline and has no contact until it is in front: the material \
                 lies on the left of the direction through the points; reverse their order if the \
                 circle is in front"
            )
        });
        found.collect()
    }

    /// Return warnings on contacts whose initial penetration exceeds that of bodies resting on each other.
    pub(crate) fn pressed_starts(&self, frames: &[Frame], memory: &[Memory]) -> Vec<String> {
        let contacts = self.contacts.iter().zip(&self.contact_names);
        let sides = self.sides_of_contact.iter();
        let found = contacts.zip(sides).filter_map(|((contact, name), sides)| {
            let depth = contact.penetration(frames, &memory[sides.clone()]);
            (depth > PRESSED * contact.radius).then(|| {
                format!(
                    "contact {name:?} starts with its circle of radius {} m at a penetration of {depth:.3e} m: it will rebound; \
                     check the position of the body",
                    contact.radius
                )
            })
        });
        found.collect()
    }
}

/// Return warnings on groups of bodies without connection to the ground.
pub(crate) fn loose_parts(model: &MechanismModel) -> Vec<String> {
    let mut part: Vec<usize> = (0..model.bodies.len()).collect();
    let joints = model.equations.iter().map(|e| (e.a.body, e.b.body));
    // The carrier of a gear is 0 where there is none.
    let geared = model.equations.iter().filter(|e| e.carrier != 0);
    let carriers = geared.map(|e| (e.b.body, e.carrier));
    let forces = model.forces.iter().map(|f| (f.a.body, f.b.body));
    let contacts = model.contacts.iter().map(|c| (c.a.body, c.b.body));
    let fixed = (0..part.len()).filter(|&i| model.bodies[i].fixed);
    let pairs = joints.chain(carriers).chain(forces).chain(contacts);
    // Union-find: each joint, force and contact joins the groups of its bodies.
    for (a, b) in pairs.chain(fixed.map(|i| (0, i))) {
        let (a, b) = (root(&mut part, a), root(&mut part, b));
        part[a.max(b)] = a.min(b);
    }
    for i in 0..part.len() {
        part[i] = root(&mut part, i);
    }
    let mut numbers: Vec<usize> = part.iter().copied().filter(|&p| p != 0).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
        .into_iter()
        .map(|number| {
            let members = (0..part.len()).filter(|&i| part[i] == number);
            let moves = match members.clone().count() {
                1 => "it moves by gravity and its own velocity",
                _ => "they move by gravity and their own velocities",
            };
            format!(
                "nothing connects {} to the ground: {moves} only",
                listed(members.map(|i| model.bodies[i].name.as_str()))
            )
        })
        .collect()
}

/// Return the representative of a body's group: its lowest body number. Paths are halved on the way.
fn root(part: &mut [usize], mut body: usize) -> usize {
    while part[body] != body {
        part[body] = part[part[body]];
        body = part[body];
    }
    body
}
