//! Changes made by assembly: displacements and rotations of bodies, and changes of their velocities.

use crate::multibody::description::body::{Body, Frame};
use crate::multibody::model::MechanismModel;

/// Displacement over the mechanism's size, and rotation \[rad\], of a body above which a warning is given.
const MOVED_FAR: f64 = 0.1;
/// See [`MOVED_FAR`].
const TURNED_FAR: f64 = 0.1;
/// Change of a given initial velocity, over the largest velocity, above which a warning is given.
const SPED_FAR: f64 = 0.1;
/// Relative change below which a component counts as unchanged: the size of round-off.
const NOTHING: f64 = 1e-9;
/// Largest number of bodies named in a warning, in order of decreasing change.
const MOST_TOLD: usize = 3;

/// Largest changes over all bodies: displacement \[m\], rotation \[rad\], velocity \[m/s\] and angular velocity \[rad/s\].
pub(crate) struct Changes {
    pub(crate) moved: f64,
    pub(crate) turned: f64,
    pub(crate) velocity: f64,
    pub(crate) spin: f64,
}

impl Changes {
    /// Return the changes between two states (q, then v).
    pub(crate) fn between(placed: &[f64], state: &[f64]) -> Self {
        let bodies = placed.len() / 6;
        let mut found = [[0.0f64; 2]; 2];
        for (i, (old, new)) in placed.chunks(3).zip(state.chunks(3)).enumerate() {
            let [way, turn] = &mut found[usize::from(i >= bodies)];
            *way = way.max((new[0] - old[0]).hypot(new[1] - old[1]));
            *turn = turn.max((new[2] - old[2]).abs());
        }
        let [[moved, turned], [velocity, spin]] = found;
        Self {
            moved,
            turned,
            velocity,
            spin,
        }
    }
}

impl MechanismModel {
    /// Return warnings on bodies whose positions changed by much, or whose initial velocities did where these were given.
    pub(crate) fn far_moves(&self, frames: &[Frame], state: &[f64]) -> Vec<String> {
        let (n, size) = (self.coordinates(), self.size(frames));
        let bodies = self.bodies.iter().zip(&self.first);
        let free: Vec<(&Body, usize)> = bodies
            .filter_map(|(body, first)| first.map(|i| (body, i)))
            .collect();
        // Angular velocities count as velocities at the distance of the mechanism's size.
        let speed = |v: &[f64]| v[0].hypot(v[1]).max(size * v[2].abs());
        let fastest = free.iter().fold(0.0, |most: f64, (body, i)| {
            most.max(speed(&body.velocity))
                .max(speed(&state[n + i..n + i + 3]))
        });
        let mut placed = Vec::new();
        let mut moving = Vec::new();
        for (body, i) in free {
            let (q, v) = (&state[i..i + 3], &state[n + i..n + i + 3]);
            let change = |new: &[f64], old: &[f64; 3]| {
                let way = (new[0] - old[0]).hypot(new[1] - old[1]);
                (way, (new[2] - old[2]).abs())
            };
            let (way, turn) = change(q, &body.position);
            let share = (way / (MOVED_FAR * size)).max(turn / TURNED_FAR);
            if share > 1.0 {
                let parts = [
                    (way, MOVED_FAR * size, "moved", "m"),
                    (turn, TURNED_FAR, "turned", "rad"),
                ];
                placed.push((
                    share,
                    format!("body {:?} had to be {}", body.name, told(&parts)),
                ));
            }
            let (dv, dspin) = change(v, &body.velocity);
            let share = dv.max(size * dspin) / (SPED_FAR * fastest);
            if body.velocity != [0.0; 3] && share > 1.0 {
                let parts = [
                    (dv, fastest, "changed", "m/s"),
                    (dspin, fastest / size, "changed", "rad/s"),
                ];
                moving.push((
                    share,
                    format!(
                        "velocity of body {:?} had to be {}",
                        body.name,
                        told(&parts)
                    ),
                ));
            }
        }
        let mut warnings = largest(
            placed,
            "to assemble: check its position, and that lengths and positions have the same unit",
        );
        warnings.extend(largest(
            moving,
            "to satisfy joints and drivers: check it; velocities of bodies that these determine may be left out",
        ));
        warnings
    }
}

/// Return the texts of the largest changes, each with its `remedy`; the last one has the number of those left out. `found`: (change, text).
fn largest(mut found: Vec<(f64, String)>, remedy: &str) -> Vec<String> {
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let more = found.len().saturating_sub(MOST_TOLD);
    found.truncate(MOST_TOLD);
    let mut texts: Vec<String> = (found.into_iter())
        .map(|(_, text)| format!("{text} {remedy}"))
        .collect();
    if let Some(last) = texts.last_mut().filter(|_| more > 0) {
        *last = format!("{last} (and {more} more bodies)");
    }
    texts
}

/// Return the changes above round-off as text. `parts`: (change, scale, verb, unit).
fn told(parts: &[(f64, f64, &str, &str); 2]) -> String {
    let mut words = Vec::new();
    let mut said = "";
    for &(change, scale, verb, unit) in parts {
        if change > NOTHING * scale {
            words.push(if verb == said {
                format!("{change:.3e} {unit}")
            } else {
                format!("{verb} by {change:.3e} {unit}")
            });
            said = verb;
        }
    }
    words.join(" and ")
}
