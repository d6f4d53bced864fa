//! What of a mechanism is worth a second look: parts that nothing holds, masses and lengths in different units.

use super::model::MechanismModel;

/// Bodies that nothing ties to the rest.
pub(super) fn loose_parts(model: &MechanismModel) -> Vec<String> {
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

/// Bodies whose mass and inertia do not belong to a body of their size.
pub(super) fn odd_bodies(model: &MechanismModel) -> Vec<String> {
    let mut reach = vec![0.0f64; model.bodies.len()];
    for equation in &model.equations {
        for end in [equation.a, equation.b] {
            reach[end.body] = reach[end.body].max(end.point.norm());
        }
    }
    let odd = |i: usize| {
        let body = &model.bodies[i];
        let gyration = (body.inertia / body.mass).sqrt();
        let ratio = gyration / reach[i];
        (!body.fixed && reach[i] > 0.0 && ratio.is_finite() && !(1e-3..30.0).contains(&ratio) && ratio > 0.0)
            .then(|| {
                format!(
                    "body {:?} has a radius of gyration of {gyration:.3e} m, its joints are {:.3e} m from its centre \
                     of mass: are mass, inertia and lengths in kg, kg m^2 and m?",
                    body.name, reach[i]
                )
            })
    };
    (1..model.bodies.len()).filter_map(odd).collect()
}
