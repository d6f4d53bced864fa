//! Channels of a drive with ideal hinges, from the recording of its mechanism.

use super::IdealGroups;
use crate::geometry::Vec2;
use crate::multibody::MechanismModel;
use crate::multibody::from_drive::channels::{BushingContact, DriveView, MechanismRow};
use crate::system::{Channel, Recording, Values};

/// Recording of a mechanism, row by row.
pub(crate) struct IdealRows<'a> {
    recording: &'a Recording,
    bodies: usize,
    joints: usize,
    contacts: usize,
    forces: usize,
}

impl<'a> IdealRows<'a> {
    pub(crate) fn new(recording: &'a Recording, model: &MechanismModel) -> Self {
        Self {
            recording,
            bodies: model.body_names().len(),
            joints: model.joint_names().len(),
            contacts: model.contact_names().len(),
            forces: model.force_names().count(),
        }
    }

    /// Return row `i`.
    pub(crate) fn row(&self, i: usize) -> MechanismRow<'a> {
        let (from, contacts) = (self.recording, self.contacts);
        MechanismRow {
            positions: part(from.real("positions"), i, 3 * self.bodies),
            velocities: part(from.real("velocities"), i, 3 * self.bodies),
            reactions: part(from.real("joint_reaction"), i, 3 * self.joints),
            applied_torque: part(from.real("applied_torque"), i, self.forces),
            contact_force: part(from.real("contact_force"), i, contacts),
            contact_force_vector: part(from.real("contact_force_vector"), i, 2 * contacts),
            penetration: part(from.real("contact_penetration"), i, contacts),
            contact_gap: part(from.whole("contact_gap"), i, contacts),
            contact_region: part(from.whole("contact_region"), i, contacts),
        }
    }

    fn count(&self) -> usize {
        self.recording.time.len()
    }

    /// Return the accelerations of the mechanism's bodies in all rows.
    #[cfg(feature = "python")]
    pub(crate) fn accelerations(&self) -> &'a [f64] {
        self.recording.real("accelerations")
    }

    /// Return the last row of a channel used by stop conditions; none without rows.
    pub(crate) fn last(&self, view: &DriveView, name: &str) -> Option<Vec<f64>> {
        let i = self.count().checked_sub(1)?;
        match name {
            "peak_hinge_force" => {
                Some(self.peak_of_hinges(view, self.recording.real("peak_joint_force"), i))
            }
            "peak_tooth_force" => Some(self.largest_of_bushings(view, i)),
            "strand_tension" => Some(view.strand_tensions(&self.row(i))),
            _ => None,
        }
    }

    fn peak_of_hinges(&self, view: &DriveView, values: &[f64], i: usize) -> Vec<f64> {
        part(values, i, self.joints)[view.hinges()].to_vec()
    }

    /// Return the largest force of each bushing on any sprocket since the previous row.
    fn largest_of_bushings(&self, view: &DriveView, i: usize) -> Vec<f64> {
        let forces = part(self.recording.real("peak_contact_force"), i, self.contacts);
        let largest = |forces: &[f64]| forces.iter().copied().fold(0.0, f64::max);
        forces.chunks_exact(view.sprockets()).map(largest).collect()
    }

    /// Return a channel of real numbers with a row of `shape` at each time.
    fn real<V: IntoIterator<Item = f64>>(
        &self,
        name: &'static str,
        shape: &[usize],
        values: impl Fn(usize) -> V,
    ) -> Channel {
        Channel {
            name,
            row_shape: shape.to_vec(),
            values: Values::Real((0..self.count()).flat_map(values).collect()),
        }
    }

    /// Return all channels of `groups`.
    pub(crate) fn channels(&self, view: &DriveView, groups: IdealGroups) -> Recording {
        let mut channels = Vec::new();
        let IdealGroups {
            drive: groups,
            joints,
            contacts,
        } = groups;
        if groups.hinges {
            channels.extend(self.hinge_channels(view));
        }
        if groups.teeth {
            channels.extend(self.tooth_channels(view));
        }
        if groups.sprockets {
            channels.extend(self.sprocket_channels(view));
        }
        if groups.bodies {
            let own = [view.bodies(), 3];
            let first = 3 * view.bodies();
            let positions = |i| self.row(i).positions[..first].iter().copied();
            let velocities = |i| self.row(i).velocities[..first].iter().copied();
            channels.push(self.real("positions", &own, positions));
            channels.push(self.real("velocities", &own, velocities));
        }
        // These have the same names in the recording of the mechanism.
        let kept = [
            (joints, "joint"),
            (contacts, "contact"),
            (groups.energy, "energy"),
        ];
        for (_, part) in kept.into_iter().filter(|(wanted, _)| *wanted) {
            let all = self.recording.channels.iter();
            channels.extend(all.filter(|channel| channel.name.contains(part)).cloned());
        }
        Recording {
            time: self.recording.time.clone(),
            channels,
        }
    }

    /// Return hinge forces, pin positions, strand tensions and peaks.
    fn hinge_channels(&self, view: &DriveView) -> [Channel; 7] {
        let n = view.links();
        let vectors = |values: Vec<Vec2>| values.into_iter().flat_map(<[f64; 2]>::from);
        let sizes = |values: Vec<Vec2>| values.into_iter().map(|v| v.x.hypot(v.y));
        let forces = |i| view.on_pins(self.row(i).reactions);
        let places = |i| view.eccentricities(self.row(i).positions);
        [
            self.real("hinge_force", &[n], |i| sizes(forces(i))),
            self.real("hinge_force_vector", &[n, 2], |i| vectors(forces(i))),
            self.real("hinge_penetration", &[n], |i| sizes(places(i))),
            self.real("hinge_eccentricity", &[n, 2], |i| vectors(places(i))),
            self.real("strand_tension", &[view.strands()], |i| {
                view.strand_tensions(&self.row(i))
            }),
            self.real("peak_hinge_force", &[n], |i| {
                self.peak_of_hinges(view, self.recording.real("peak_joint_force"), i)
            }),
            self.real("peak_hinge_impulse", &[n], |i| {
                self.peak_of_hinges(view, self.recording.real("peak_joint_impulse"), i)
            }),
        ]
    }

    /// Return the contact of largest penetration of each bushing, and peaks over all sprockets.
    fn tooth_channels(&self, view: &DriveView) -> Vec<Channel> {
        let n = view.links();
        let deepest: Vec<Vec<BushingContact>> = (0..self.count())
            .map(|i| view.deepest_contacts(&self.row(i)))
            .collect();
        let real = |name, shape: &[usize], value: fn(&BushingContact) -> Vec<f64>| {
            self.real(name, shape, |i| deepest[i].iter().flat_map(value))
        };
        let whole = |name, value: fn(&BushingContact) -> i32| Channel {
            name,
            row_shape: vec![n],
            values: Values::Whole(deepest.iter().flatten().map(value).collect()),
        };
        let impulses = self.recording.real("peak_contact_impulse");
        vec![
            real("tooth_force", &[n], |found| vec![found.force]),
            real("tooth_force_vector", &[n, 2], |found| found.vector.to_vec()),
            real("tooth_penetration", &[n], |found| vec![found.penetration]),
            whole("tooth_sprocket", BushingContact::number),
            whole("tooth_index", |found| found.gap),
            whole("tooth_region", |found| found.region),
            self.real("peak_tooth_force", &[n], |i| {
                self.largest_of_bushings(view, i)
            }),
            self.real("peak_tooth_impulse", &[n], |i| {
                part(impulses, i, self.contacts)
                    .chunks_exact(view.sprockets())
                    .map(|impulses| impulses.iter().sum())
            }),
        ]
    }

    /// Return angle, speed, shaft torque and centre of each sprocket.
    fn sprocket_channels(&self, view: &DriveView) -> [Channel; 4] {
        let s = view.sprockets();
        let wheels = view.links()..view.bodies();
        let angles = |rows: &'a [f64]| wheels.clone().map(move |body| rows[3 * body + 2]);
        [
            self.real("sprocket_angle", &[s], |i| angles(self.row(i).positions)),
            self.real("sprocket_speed", &[s], |i| angles(self.row(i).velocities)),
            self.real("sprocket_torque", &[s], |i| {
                let row = self.row(i);
                (0..s).map(move |wheel| view.shaft_torque(&row, wheel))
            }),
            self.real("sprocket_center", &[s, 2], |i| {
                let positions = self.row(i).positions;
                wheels
                    .clone()
                    .flat_map(move |body| [positions[3 * body], positions[3 * body + 1]])
            }),
        ]
    }
}

/// Return row `i` of values with `width` numbers per row.
fn part<T>(values: &[T], i: usize, width: usize) -> &[T] {
    &values[i * width..(i + 1) * width]
}
