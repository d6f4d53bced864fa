//! Names and shapes of the recorded channels.

use super::Groups;
use crate::chain::model::Model;
use crate::system::Channel;

/// Return the channels of these groups, without rows; rows are written in the same order.
pub(crate) fn channels(model: &Model, groups: Groups) -> Vec<Channel> {
    let mut channels = Vec::new();
    let mut add = |name: &'static str, row_shape: &[usize], whole: bool| {
        channels.push(if whole {
            Channel::whole(name, row_shape)
        } else {
            Channel::real(name, row_shape)
        });
    };
    let (n, s, bodies) = (model.links, model.sprockets.len(), model.bodies());
    if groups.hinges {
        add("hinge_force", &[n], false);
        add("hinge_force_vector", &[n, 2], false);
        add("hinge_penetration", &[n], false);
        add("hinge_eccentricity", &[n, 2], false);
        if !model.hinges.ideal {
            add("hinge_onset_speed", &[n], false);
        }
        add("strand_tension", &[model.strands.len()], false);
        add("peak_hinge_force", &[n], false);
        add("peak_hinge_impulse", &[n], false);
        if model.hinges.film.is_some() {
            add("hinge_film_force", &[n], false);
        }
        if model.ends.is_some() {
            add("end_force", &[2, 2], false);
            add("end_position", &[2, 2], false);
            add("end_velocity", &[2, 2], false);
        }
    }
    if groups.hinges && model.rollers.is_some() {
        add("roller_force", &[n], false);
        add("roller_force_vector", &[n, 2], false);
        add("roller_penetration", &[n], false);
        add("roller_eccentricity", &[n, 2], false);
        add("roller_onset_speed", &[n], false);
        add("peak_roller_force", &[n], false);
        add("peak_roller_impulse", &[n], false);
    }
    if groups.teeth {
        add("tooth_force", &[n], false);
        add("tooth_force_vector", &[n, 2], false);
        add("tooth_penetration", &[n], false);
        add("tooth_onset_speed", &[n], false);
        add("tooth_sprocket", &[n], true);
        add("tooth_index", &[n], true);
        add("tooth_region", &[n], true);
        add("peak_tooth_force", &[n], false);
        add("peak_tooth_impulse", &[n], false);
    }
    if groups.sprockets {
        add("sprocket_angle", &[s], false);
        add("sprocket_speed", &[s], false);
        add("sprocket_torque", &[s], false);
        add("sprocket_center", &[s, 2], false);
    }
    if groups.bodies {
        add("positions", &[bodies, 3], false);
        add("velocities", &[bodies, 3], false);
    }
    channels
}
