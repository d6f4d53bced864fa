//! Names and shapes of the recorded channels.

use super::Groups;
use crate::chain::model::Model;
use crate::system::Channel;

/// Return the channels of these groups, without rows; rows are written in the same order.
pub(crate) fn channels(model: &Model, groups: Groups) -> Vec<Channel> {
    let mut channels = Vec::new();
    let mut add = |channel| channels.push(channel);
    let (real, whole) = (Channel::real, Channel::whole);
    let (n, s, bodies) = (model.links, model.sprockets.len(), model.bodies());
    if groups.hinges {
        add(real("hinge_force", &[n]));
        add(real("hinge_force_vector", &[n, 2]));
        add(real("hinge_penetration", &[n]));
        add(real("hinge_eccentricity", &[n, 2]));
        if !model.hinges.ideal {
            add(real("hinge_onset_speed", &[n]));
        }
        add(real("strand_tension", &[model.strands.len()]));
        add(real("peak_hinge_force", &[n]));
        add(real("peak_hinge_impulse", &[n]));
        if model.hinges.film.is_some() {
            add(real("hinge_film_force", &[n]));
        }
        if model.ends.is_some() {
            add(real("end_force", &[2, 2]));
            add(real("end_position", &[2, 2]));
            add(real("end_velocity", &[2, 2]));
        }
    }
    if groups.hinges && model.rollers.is_some() {
        add(real("roller_force", &[n]));
        add(real("roller_force_vector", &[n, 2]));
        add(real("roller_penetration", &[n]));
        add(real("roller_eccentricity", &[n, 2]));
        add(real("roller_onset_speed", &[n]));
        add(real("peak_roller_force", &[n]));
        add(real("peak_roller_impulse", &[n]));
    }
    if groups.teeth {
        add(real("tooth_force", &[n]));
        add(real("tooth_force_vector", &[n, 2]));
        add(real("tooth_penetration", &[n]));
        add(real("tooth_onset_speed", &[n]));
        add(whole("tooth_sprocket", &[n]));
        add(whole("tooth_index", &[n]));
        add(whole("tooth_region", &[n]));
        add(real("peak_tooth_force", &[n]));
        add(real("peak_tooth_impulse", &[n]));
    }
    if groups.sprockets {
        add(real("sprocket_angle", &[s]));
        add(real("sprocket_speed", &[s]));
        add(real("sprocket_torque", &[s]));
        add(real("sprocket_center", &[s, 2]));
    }
    if groups.bodies {
        add(real("positions", &[bodies, 3]));
        add(real("velocities", &[bodies, 3]));
    }
    channels
}
