//! Compiled mechanism: names resolved to numbers, and lengths and angles that are not given taken from the initial positions.

use std::collections::HashMap;
use std::ops::Range;

use super::constraints::equation::{Equation, Quantity};
use super::constraints::pin::Pin;
use super::contact::compiled_contact::CompiledContact;
use super::contact::law_ranges::{EndingLaw, ending_laws, range_notes};
use super::contact::step_bound::ContactBodies;
use super::description::body::{Body, End, Frame, Marker};
use super::description::force_element::{Force, ForceKind};
use super::description::joint::{Joint, JointKind};
use super::{GROUND, Mechanism, PrescribedMotion};
use crate::error::{Error, Result, listed};
use crate::geometry::{Vec2, turned_left};
use crate::math::simd::InstructionSet;

/// Compiled mechanism, immutable during a run. Body 0 is the ground.
#[derive(Debug, Clone)]
pub struct MechanismModel {
    pub(crate) bodies: Vec<Body>,
    /// Number of each body's first coordinate; `None` for fixed bodies.
    pub(crate) first: Vec<Option<usize>>,
    /// Mass or moment of inertia of each coordinate.
    pub(crate) mass: Vec<f64>,
    pub(crate) gravity: Vec2,
    pub(crate) equations: Vec<Equation>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) forces: Vec<Force>,
    pub(crate) contacts: Vec<CompiledContact>,
    pub(crate) contact_bodies: ContactBodies,
    pub(crate) contact_names: Vec<String>,
    /// Laws whose range ends at some penetration.
    pub(crate) ending_laws: Vec<EndingLaw>,
    /// Warnings on laws and bristles outside their range at any penetration.
    pub(crate) range_notes: Vec<String>,
    /// Sides of all contacts that may be in contact at once, in order: number of the contact and of the side.
    pub(crate) sides: Vec<(usize, usize)>,
    /// Range of the sides of each contact.
    pub(crate) sides_of_contact: Vec<Range<usize>>,
    /// Number of each body by name.
    numbers: HashMap<String, usize>,
    /// Range of the equations of each joint.
    pub(crate) equations_of_joint: Vec<Range<usize>>,
    /// Number of the bristle of each side, where it has one, and number of bristles.
    pub(crate) bristle_of_side: Vec<Option<usize>>,
    pub(crate) bristles: usize,
    /// Revolute joints with friction.
    pub(crate) pins: Vec<Pin>,
    /// Whether the energy sums are under error control.
    pub(crate) watches_energy: bool,
    /// Lower bound of the size of the mechanism \[m\]: [`Self::size_of_parts`].
    pub(crate) least_size: f64,
    pub(super) instructions: InstructionSet,
}

impl MechanismModel {
    /// Return whether any clearance joint has a lubricant film.
    pub(crate) fn has_film(&self) -> bool {
        self.contacts.iter().any(|contact| contact.film.is_some())
    }

    /// Compile a mechanism in its initial positions.
    ///
    /// # Errors
    /// For invalid input; the error contains the part, the field and the values allowed.
    pub fn compile(mechanism: &Mechanism) -> Result<Self> {
        mechanism.validate()?;
        let mut bodies = vec![Body::new(GROUND, 0.0, 0.0).fixed()];
        let mut numbers = HashMap::from([(GROUND.to_string(), 0)]);
        for body in &mechanism.bodies {
            body.validate()?;
            if numbers.insert(body.name.clone(), bodies.len()).is_some() {
                return Err(Error::invalid(
                    "name of a body",
                    format!("{:?}", body.name),
                    "is taken already: names must be unique, and \"ground\" is the frame that does not move",
                ));
            }
            bodies.push(body.clone());
        }
        let mut first = Vec::with_capacity(bodies.len());
        let mut mass = Vec::new();
        for body in &bodies {
            first.push((!body.fixed).then_some(mass.len()));
            if !body.fixed {
                mass.extend([body.mass, body.mass, body.inertia]);
            }
        }
        let mut model = Self {
            bodies,
            first,
            mass,
            gravity: mechanism.gravity,
            equations: Vec::new(),
            joints: mechanism.joints.clone(),
            forces: Vec::new(),
            contacts: Vec::new(),
            contact_bodies: ContactBodies::default(),
            numbers,
            equations_of_joint: Vec::new(),
            contact_names: mechanism.contacts.iter().map(|c| c.name.clone()).collect(),
            ending_laws: Vec::new(),
            range_notes: Vec::new(),
            bristle_of_side: Vec::new(),
            bristles: 0,
            pins: Vec::new(),
            watches_energy: mechanism
                .contacts
                .iter()
                .any(|c| c.law.may_part_under_load()),
            sides: Vec::new(),
            sides_of_contact: Vec::new(),
            least_size: 0.0,
            // Four angles at once: see `MechanismModel::place`.
            instructions: InstructionSet::detect_for(4),
        };
        let frames = model.start_frames();
        model.add_joints(mechanism, &frames)?;
        model.add_forces(mechanism, &frames)?;
        model.add_contacts(mechanism)?;
        model.least_size = model.size_of_parts();
        Ok(model)
    }

    /// Add the equations and pins of all joints, in the initial `frames`.
    fn add_joints(&mut self, mechanism: &Mechanism, frames: &[Frame]) -> Result<()> {
        for (number, joint) in mechanism.joints.iter().enumerate() {
            joint.validate()?;
            let equations = self.equations_of(number, joint, frames)?;
            let first = self.equations.len();
            self.equations.extend(equations);
            self.equations_of_joint.push(first..self.equations.len());
            if let Some(friction) = joint.friction {
                self.pins
                    .push(Pin::new(number, friction, first, &self.equations));
            }
        }
        Ok(())
    }

    /// Add all forces; free lengths and angles that are not given are those of the initial `frames`.
    fn add_forces(&mut self, mechanism: &Mechanism, frames: &[Frame]) -> Result<()> {
        for force in &mechanism.forces {
            force.validate()?;
            let owner = || format!("force {:?}", force.name);
            let (a, b) = (self.end(&force.a, owner)?, self.end(&force.b, owner)?);
            // A free length or angle that is not given is that of the initial positions.
            let rest = match &force.kind {
                ForceKind::Spring { rest, .. } => rest.unwrap_or_else(|| {
                    (frames[b.body].place(b.point) - frames[a.body].place(a.point)).norm()
                }),
                ForceKind::TorsionSpring { rest, .. } => {
                    rest.unwrap_or(frames[b.body].angle - frames[a.body].angle)
                }
                _ => 0.0,
            };
            self.forces.push(Force {
                name: force.name.clone(),
                a,
                b,
                kind: force.kind.clone(),
                rest,
            });
        }
        Ok(())
    }

    /// Add all contacts with their sides and bristles.
    fn add_contacts(&mut self, mechanism: &Mechanism) -> Result<()> {
        for contact in &mechanism.contacts {
            contact.validate()?;
            let owner = || format!("contact {:?}", contact.name);
            let (a, b) = (self.end(&contact.a, owner)?, self.end(&contact.b, owner)?);
            let compiled = CompiledContact::new(contact, a, b)?;
            let first = self.sides.len();
            let number = self.contacts.len();
            self.sides
                .extend((0..compiled.sides()).map(|side| (number, side)));
            self.sides_of_contact.push(first..self.sides.len());
            // With bristle friction, each side of a contact has one bristle.
            let bristled = contact.tribology.bristles().is_some();
            for _ in 0..compiled.sides() {
                self.bristle_of_side.push(bristled.then_some(self.bristles));
                self.bristles += usize::from(bristled);
            }
            self.contacts.push(compiled);
        }
        self.contact_bodies = ContactBodies::of(&self.contacts);
        self.ending_laws = ending_laws(&mechanism.contacts, &self.contacts);
        self.range_notes = range_notes(&mechanism.contacts);
        Ok(())
    }

    /// Return the names of the bodies, without the ground.
    #[must_use]
    pub fn body_names(&self) -> Vec<String> {
        self.bodies[1..].iter().map(|b| b.name.clone()).collect()
    }

    /// Return the names of the joints.
    #[must_use]
    pub fn joint_names(&self) -> Vec<String> {
        self.joints.iter().map(|j| j.name.clone()).collect()
    }

    /// Return the names of the contacts.
    #[must_use]
    pub fn contact_names(&self) -> &[String] {
        &self.contact_names
    }

    /// Return the number of coordinates of the bodies that are not fixed.
    #[must_use]
    pub fn coordinates(&self) -> usize {
        self.mass.len()
    }

    /// Return the number of scalar constraint equations.
    #[must_use]
    pub fn constraints(&self) -> usize {
        self.equations.len()
    }

    /// Return the initial positions and velocities of the bodies.
    pub(crate) fn start_frames(&self) -> Vec<Frame> {
        (self.bodies.iter())
            .map(|body| Frame::new(body.position, body.velocity))
            .collect()
    }

    /// Return the number of components of the integrator's solution: coordinates and velocities with bristles, two energy sums.
    pub(crate) fn dimension(&self) -> usize {
        2 * self.unknowns() + 2
    }

    /// Return the body of a coordinate of the integrator, or the contact of a bristle, as text.
    pub(crate) fn owner_of(&self, coordinate: usize) -> String {
        let Some(bristle) = coordinate.checked_sub(self.coordinates()) else {
            return format!("body {:?}", self.bodies[self.body_of(coordinate)].name);
        };
        let side = self
            .bristle_of_side
            .iter()
            .position(|&b| b == Some(bristle));
        let contact = side.map_or(0, |side| self.sides[side].0);
        format!("friction of contact {:?}", self.contact_names[contact])
    }

    /// Return the number of the body of a coordinate.
    pub(crate) fn body_of(&self, coordinate: usize) -> usize {
        let found = self
            .first
            .iter()
            .rposition(|&first| first.is_some_and(|f| f <= coordinate));
        found.unwrap_or(0)
    }

    /// Return the body number and point of a marker; an error for an unknown body.
    fn end(&self, marker: &Marker, owner: impl Fn() -> String) -> Result<End> {
        if let Some(&body) = self.numbers.get(&marker.body) {
            let point = marker.point;
            return Ok(End { body, point });
        }
        let known = listed(self.bodies.iter().map(|body| body.name.as_str()));
        Err(Error::invalid(
            format!("body of {}", owner()),
            format!("{:?}", marker.body),
            format!("there is no such body; there are {known}"),
        ))
    }

    /// Return the body that carries a gear joint of two `geared` bodies; the ground where none is named.
    fn carrier(&self, joint: &Joint, geared: [usize; 2]) -> Result<usize> {
        let JointKind::Gear {
            carrier: Some(name),
            ..
        } = &joint.kind
        else {
            return Ok(0);
        };
        let owner = || format!("joint {:?}", joint.name);
        let carrier = self.end(&Marker::new(name.clone(), 0.0, 0.0), owner)?.body;
        if geared.contains(&carrier) {
            return Err(Error::invalid(
                format!("carrier of {}", owner()),
                format!("{name:?}"),
                "must be a third body",
            ));
        }
        Ok(carrier)
    }

    /// Return the scalar equations of a joint; values that are not given are those of the initial positions `frames`.
    fn equations_of(
        &self,
        number: usize,
        joint: &Joint,
        frames: &[Frame],
    ) -> Result<Vec<Equation>> {
        let owner = || format!("joint {:?}", joint.name);
        let (a, b) = (self.end(&joint.a, owner)?, self.end(&joint.b, owner)?);
        let carrier = self.carrier(joint, [a.body, b.body])?;
        let equation = |quantity| Equation {
            joint: number,
            quantity,
            a,
            b,
            carrier,
            offset: 0.0,
            motion: None,
        };
        let at = |quantity, offset| Equation {
            offset,
            ..equation(quantity)
        };
        let placed = |quantity| at(quantity, equation(quantity).quantity(frames));
        let along = |direction: Vec2| Quantity::Along(direction.normalize());
        let across = |direction: Vec2| equation(along(turned_left(direction)));
        let turned = |angle: &Option<f64>| {
            angle.map_or_else(
                || placed(Quantity::Angle),
                |angle| at(Quantity::Angle, angle),
            )
        };
        let both = [0, 1].map(|axis| equation(Quantity::Coincident(axis)));
        Ok(match &joint.kind {
            JointKind::Revolute => both.to_vec(),
            JointKind::Fixed { angle } => [both.to_vec(), vec![turned(angle)]].concat(),
            JointKind::Prismatic { direction, angle } => vec![across(*direction), turned(angle)],
            JointKind::PointOnLine { direction } => vec![across(*direction)],
            JointKind::Distance { length } => {
                let length = length.unwrap_or_else(|| {
                    (frames[b.body].place(b.point) - frames[a.body].place(a.point)).norm()
                });
                if length == 0.0 {
                    return Err(Error::invalid(
                        format!("length of {}", owner()),
                        0.0,
                        "the points coincide as placed: give a length, or use a revolute joint",
                    ));
                }
                vec![equation(Quantity::Distance(length))]
            }
            JointKind::Gear { ratio, .. } => vec![placed(Quantity::Gear(*ratio))],
            JointKind::Rack { direction, radius } => {
                vec![placed(Quantity::Rack(direction.normalize(), *radius))]
            }
            JointKind::DrivenAngle(motion) => {
                vec![driven(equation(Quantity::Angle), motion, frames)]
            }
            JointKind::DrivenPosition { direction, motion } => {
                vec![driven(equation(along(*direction)), motion, frames)]
            }
        })
    }
}

/// Return the equation with its prescribed motion. A motion given by its speed starts from the initial position.
fn driven(mut equation: Equation, motion: &PrescribedMotion, frames: &[Frame]) -> Equation {
    if matches!(motion, PrescribedMotion::Speed(_)) {
        equation.offset = equation.quantity(frames);
    }
    equation.motion = Some(motion.clone());
    equation
}
