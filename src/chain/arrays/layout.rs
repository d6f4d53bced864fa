//! Constants that the kernels read from a model and arrays that they write: one array per quantity, padded to whole SIMD vectors.

use crate::chain::model::{Model, OpenEnds};
use crate::math::simd::{Numbers, WIDTH, padded_zeros};

/// Constants of the links. Links of the padding have zero length and zero inverse mass.
#[derive(Debug, Clone)]
pub(crate) struct LinkConstants {
    /// Half the length of link k \[m\]: position of its front.
    pub(crate) front_arm: Numbers,
    /// Position of the rear of link k + 1: minus half its length \[m\].
    pub(crate) rear_arm: Numbers,
    /// 1/mass \[1/kg\].
    pub(crate) inverse_mass: Numbers,
    /// 1/inertia \[1/(kg m²)\].
    pub(crate) inverse_inertia: Numbers,
    /// Squared distance of the two ends of a hinge at which they touch \[m²\]; infinite where an open chain is open, and
    /// where hinges are ideal.
    pub(crate) clearance_squared: Numbers,
    /// Compliance of the plates at each hinge \[m/N\], where they are elastic.
    pub(crate) compliance: Option<Numbers>,
    /// One for every hinge, zero in the padding and where an open chain is open.
    pub(crate) exists: Numbers,
    /// One where bushing k is on the front of link k, zero where it is on the rear of link k + 1. The array covers the chain twice.
    pub(crate) bushing_on_front: Numbers,
}

impl LinkConstants {
    /// Return the constants of `model`.
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.links;
        let lay_out = |count: usize, value: &dyn Fn(usize) -> f64| {
            let mut values = padded_zeros(count);
            for (i, place) in values[..count].iter_mut().enumerate() {
                *place = value(i % n);
            }
            values
        };
        let touching = model.hinges.clearance * model.hinges.clearance;
        let distance = |k: usize| {
            if k < n && (model.hinges.ideal || model.hinge_is_open(k)) {
                f64::INFINITY
            } else {
                touching
            }
        };
        Self {
            clearance_squared: {
                let mut values = padded_zeros(n);
                for (k, place) in values.iter_mut().enumerate() {
                    *place = distance(k);
                }
                values
            },
            compliance: (model.hinges.compliance.as_ref()).map(|given| lay_out(n, &|k| given[k])),
            front_arm: lay_out(n, &|i| model.chain.arms[i]),
            rear_arm: lay_out(n, &|i| -model.chain.arms[(i + 1) % n]),
            inverse_mass: lay_out(n, &|i| model.chain.inverse_mass[i]),
            inverse_inertia: lay_out(n, &|i| model.chain.inverse_inertia[i]),
            exists: lay_out(n, &|k| f64::from(!model.hinge_is_open(k))),
            bushing_on_front: lay_out(2 * n + WIDTH, &|k| f64::from(model.link_of_bushing(k) == k)),
        }
    }
}

/// Entry of the first link in arrays of forces on rear ends. The entry of hinge 0, on the rear of the second link, is then aligned.
pub(crate) const FIRST: usize = WIDTH - 1;

/// Arrays of the chain that an evaluation writes.
#[derive(Debug, Clone)]
pub(crate) struct ChainArrays {
    /// Number of sprockets.
    pub(crate) sprockets: usize,
    /// Angles of the sprockets \[rad\], written before the loop over the chain.
    pub(crate) sprocket_angle: Numbers,
    /// Cosines of these angles.
    pub(crate) sprocket_cos: Numbers,
    /// Sines of these angles.
    pub(crate) sprocket_sin: Numbers,
    /// Cosines of the links' angles; a copy of the first follows the last.
    pub(crate) cos: Numbers,
    /// Sines of the links' angles; a copy of the first follows the last.
    pub(crate) sin: Numbers,
    /// Penetration of every hinge \[m\]; zero without contact.
    pub(crate) depth: Numbers,
    /// Normal force of every hinge \[N\].
    pub(crate) force: Numbers,
    /// Friction on the rear end of link k + 1, along the normal turned left \[N\]; zero without a law of friction.
    pub(crate) friction: Numbers,
    /// Force of lubricant on the front end of link k, x and y \[N\]; zero without any.
    pub(crate) film: [Numbers; 2],
    /// Size of the whole force of every hinge with lubricant, of contact, friction and film \[N\]; zero without any.
    pub(crate) lubricated_force: Numbers,
    /// Squared distance of pin and bushing of every hinge \[m²\].
    pub(crate) distance_squared: Numbers,
    /// Product of this distance and its rate \[m²/s\].
    pub(crate) along: Numbers,
    /// Force on the front of every link, x and y \[N\]. Entries behind the last link are forces on the first links.
    pub(crate) front_force: [Numbers; 2],
    /// Force on the rear of link k at entry [`FIRST`] + k, x and y \[N\]. Entries from link n on are forces on the first links.
    pub(crate) rear_force: [Numbers; 2],
    /// Moment on the front of every link about its hinge \[N m\], laid out as the forces; zero without friction.
    pub(crate) front_moment: Numbers,
    /// Moment on the rear of link k at entry [`FIRST`] + k \[N m\].
    pub(crate) rear_moment: Numbers,
    /// Angular velocities of the bushings \[rad/s\], written where teeth have friction.
    pub(crate) bushing_spin: Numbers,
    /// Centres of the bushings, x and y \[m\]. Copies of the first ones follow the last, for runs of candidates past the last
    /// bushing.
    pub(crate) bushing: [Numbers; 2],
    /// Velocities of the bushings, x and y \[m/s\].
    pub(crate) bushing_velocity: [Numbers; 2],
}

impl ChainArrays {
    /// Allocate the arrays for `model`.
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.links;
        let once = || padded_zeros(2 * n + 3 * WIDTH);
        let twice = || [0, 1].map(|_| once());
        let sprockets = || padded_zeros(model.sprockets.len());
        Self {
            sprockets: model.sprockets.len(),
            sprocket_angle: sprockets(),
            sprocket_cos: sprockets(),
            sprocket_sin: sprockets(),
            cos: padded_zeros(n + WIDTH),
            sin: padded_zeros(n + WIDTH),
            depth: padded_zeros(n),
            force: padded_zeros(n),
            friction: padded_zeros(n),
            film: [0, 1].map(|_| padded_zeros(n)),
            lubricated_force: padded_zeros(n),
            distance_squared: padded_zeros(n),
            along: padded_zeros(n),
            front_force: twice(),
            rear_force: twice(),
            front_moment: once(),
            rear_moment: once(),
            bushing_spin: once(),
            bushing: twice(),
            bushing_velocity: twice(),
        }
    }

    /// Set the distances of open hinges of an open chain to zero: event screening then finds no events there.
    pub(crate) fn forget_open_hinges(&mut self, ends: &OpenEnds) {
        for k in ends.open_hinges() {
            (self.distance_squared[k], self.along[k]) = (0.0, 0.0);
        }
    }

    /// Set the distances of missing rollers to zero, for the same reason.
    pub(crate) fn forget_absent_rollers(&mut self, model: &Model) {
        for k in model.absent_rollers() {
            (self.distance_squared[k], self.along[k]) = (0.0, 0.0);
        }
    }

    /// Set the moments to zero.
    pub(crate) fn clear_moments(&mut self) {
        self.front_moment.fill(0.0);
        self.rear_moment.fill(0.0);
    }

    /// Write the angular velocities of the bushings, which are those of the links they belong to; copies of the first `overhang`
    /// ones follow the last.
    pub(crate) fn spin_bushings(
        &mut self,
        constants: &LinkConstants,
        spin: &[f64],
        overhang: usize,
    ) {
        let n = spin.len();
        let (own, behind) = self.bushing_spin.split_at_mut(n);
        // Bushing k belongs to link k or to the next one. Slices of equal length: the loop is vectorized.
        let (last, others) = (n - 1, own[..n - 1].iter_mut());
        let links = spin
            .iter()
            .zip(&spin[1..])
            .zip(&constants.bushing_on_front[..last]);
        for (bushing, ((&here, &next), &on_front)) in others.zip(links) {
            *bushing = if on_front > 0.0 { here } else { next };
        }
        let on_front = constants.bushing_on_front[last] > 0.0;
        own[last] = spin[if on_front { last } else { 0 }];
        behind[..overhang].copy_from_slice(&own[..overhang]);
    }

    /// Set entries behind the last of `links` bushings to zero, where longer runs may have left NaN. Vectors at the end of a run
    /// read these entries, and NaN times a zero force is NaN.
    pub(crate) fn clear_repeated(&mut self, links: usize) {
        for array in self.bushing.iter_mut().chain(&mut self.bushing_velocity) {
            array[links..].fill(0.0);
        }
    }
}
