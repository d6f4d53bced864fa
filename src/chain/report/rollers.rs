//! Roller contacts: clearance joint between each bushing and its roller, from the last evaluation of the kernels.

use pulp::{Simd, WithSimd};

use super::HingeContacts;
use super::hinges::{pairs, write_bores, write_contact_forces};
use crate::chain::arrays::layout::ChainArrays;
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::math::simd::InstructionSet;

/// Contacts of all rollers on their bushings; empty where rollers are no bodies of their own.
#[derive(Debug, Clone)]
pub struct RollerContacts {
    /// Inverse of the length of `eccentricity` \[1/m\]; zero where the centres coincide.
    over_distance: Vec<f64>,
    /// Penetration δ = |e| - c \[m\].
    pub penetration: Vec<f64>,
    /// Penetration rate dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Normal force \[N\].
    pub force: Vec<f64>,
    /// Centre of the bushing relative to that of the roller, x and y \[m\].
    pub eccentricity: [Vec<f64>; 2],
    /// Force of the bushing on the roller, x and y \[N\]: normal force · n + friction · n turned left.
    pub on_roller: [Vec<f64>; 2],
}

impl RollerContacts {
    /// Create arrays of zeros for `rollers` rollers.
    #[must_use]
    pub fn new(rollers: usize) -> Self {
        let zeros = || vec![0.0; rollers];
        Self {
            over_distance: zeros(),
            penetration: zeros(),
            rate: zeros(),
            force: zeros(),
            eccentricity: [zeros(), zeros()],
            on_roller: [zeros(), zeros()],
        }
    }

    /// Copy all rollers from the arrays of an evaluation; absent rollers have zeros.
    pub(crate) fn read(
        &mut self,
        model: &Model,
        motion: &Motion,
        hinges: &HingeContacts,
        arrays: Option<&ChainArrays>,
        instructions: InstructionSet,
    ) {
        let (Some(rollers), Some(arrays)) = (&model.rollers, arrays) else {
            return;
        };
        self.force.copy_from_slice(&arrays.force[..model.links]);
        instructions.run(ReadRollers {
            bushing: &hinges.bushing,
            roller: [&motion.x[model.links..], &motion.y[model.links..]],
            arrays,
            clearance: rollers.clearance,
            rollers: self,
        });
        for k in model.absent_rollers() {
            let [x, y] = &mut self.eccentricity;
            let [force_x, force_y] = &mut self.on_roller;
            let scalars = [&mut self.penetration, &mut self.rate, &mut self.force];
            for values in scalars.into_iter().chain([x, y, force_x, force_y]) {
                values[k] = 0.0;
            }
        }
    }

    /// Return the force of the bushing on each roller \[N\].
    pub fn forces_on_rollers(&self) -> impl Iterator<Item = [f64; 2]> {
        pairs(&self.on_roller)
    }
}

/// Kernel of [`RollerContacts::read`]: plain loops that the compiler vectorizes for the instruction set.
struct ReadRollers<'a> {
    bushing: &'a [Vec<f64>; 2],
    roller: [&'a [f64]; 2],
    arrays: &'a ChainArrays,
    clearance: f64,
    rollers: &'a mut RollerContacts,
}

impl WithSimd for ReadRollers<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set
    fn with_simd<S: Simd>(self, _: S) {
        let rollers = self.rollers;
        for axis in [0, 1] {
            let centers = self.bushing[axis].iter().zip(self.roller[axis]);
            for (offset, (bushing, roller)) in rollers.eccentricity[axis].iter_mut().zip(centers) {
                *offset = bushing - roller;
            }
        }
        let found = [
            &mut rollers.penetration[..],
            &mut rollers.rate,
            &mut rollers.over_distance,
        ];
        write_bores(found, self.arrays, self.clearance);
        let [x, y] = &rollers.eccentricity;
        let contact = [
            &rollers.force[..],
            &self.arrays.friction,
            &rollers.over_distance,
        ];
        write_contact_forces(&mut rollers.on_roller, [x, y], contact);
    }
}
