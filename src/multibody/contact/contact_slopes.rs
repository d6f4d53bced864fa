//! Derivatives of contact forces with respect to position and velocity of the circle, for the implicit corrector.

use nalgebra::Matrix2;

use super::contact_state::CompiledContact;
use super::impact_memory::Memory;
use crate::multibody::constraints::relative_kinematics::PairForce;
use crate::multibody::description::body::Frame;

impl CompiledContact {
    /// Call `visit` with the side and the force slopes of each contact point that has a force.
    ///
    /// The force on the circle is F = w f n - E ∇w, with outward normal n and weight w. The penetration rate is δ' = -n·v. The
    /// derivatives are ∂δ/∂x = -n, ∂n/∂x = b (1 - n nᵀ) and ∂f/∂x = -k n - c (∂n/∂x v). Here b is the rotation of the normal.
    pub(crate) fn slopes(
        &self,
        frames: &[Frame],
        memory: &[Memory],
        mut visit: impl FnMut(usize, &PairForce),
    ) {
        let (fa, fb) = (&frames[self.a.body], &frames[self.b.body]);
        let approach = self.approach(fa, fb);
        let local = self.local(fa, fb);
        self.bearings(local, |bearing, _| {
            let memory = memory[bearing.side];
            let depth = self.radius - bearing.distance;
            if depth <= 0.0 || !self.bears(bearing, memory) {
                return;
            }
            let (n, slope) = (fa.turned(bearing.outward), fa.turned(bearing.slope));
            let (law, rate) = (self.pair(bearing, memory), -n.dot(&approach));
            let [force, stiffness, damping] = law.slopes(depth, rate, memory.speed);
            let elastic = law.force(depth, rate, memory.speed).elastic;
            let energy = law.energy(depth);
            let w = bearing.weight;
            let bend = match self.outline {
                Some(_) => bearing.bend,
                None => self.profile().bend(local, self.radius, bearing.outward),
            };
            let across = bend * (Matrix2::identity() - n * n.transpose());
            // The second derivative of the weight is neglected.
            let along = -stiffness * n - damping * (across * approach);
            let slopes = PairForce {
                force: w * force * n - energy * slope,
                by_place: w * (n * along.transpose() + force * across)
                    + force * n * slope.transpose()
                    + elastic * slope * n.transpose(),
                by_velocity: -w * damping * (n * n.transpose()),
            };
            visit(bearing.side, &slopes);
        });
    }
}
