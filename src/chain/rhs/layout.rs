//! What the kernels read of a model and the arrays they write, one array a quantity, padded to whole vectors.

use crate::chain::model::{Model, OpenEnds};
use crate::math::simd::{Numbers, WIDTH, padded_zeros};

/// What the kernels need to know of the links; a link that is not there, in the padding, has no length and no mass.
#[derive(Debug, Clone)]
pub(crate) struct LinkConstants {
    /// Half the length of link k \[m\]: where its front is.
    pub(crate) front_arm: Numbers,
    /// Where the rear of link k + 1 is: minus half its length \[m\].
    pub(crate) rear_arm: Numbers,
    /// 1/mass \[1/kg\].
    pub(crate) inverse_mass: Numbers,
    /// 1/inertia \[1/(kg m²)\].
    pub(crate) inverse_inertia: Numbers,
    /// Square of the distance from which the two ends in a hinge touch \[m²\]; infinite where an open chain is open.
    pub(crate) clearance_squared: Numbers,
    /// What the plates at a hinge give way by \[m/N\], where they are elastic.
    pub(crate) compliance: Option<Numbers>,
    /// One for every hinge, zero in the padding and where an open chain is open.
    pub(crate) there: Numbers,
    /// One where bushing k is on the front of link k, zero where it is on the rear of link k + 1; twice around the chain.
    pub(crate) bushing_on_front: Numbers,
}

impl LinkConstants {
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.links;
        let lay_out = |count: usize, value: &dyn Fn(usize) -> f64| {
            let mut values = padded_zeros(count);
            for (i, place) in values[..count].iter_mut().enumerate() {
                *place = value(i % n);
            }
            values
        };
        let touching = model.clearance * model.clearance;
        let distance = |k: usize| {
            if k < n && model.hinge_is_open(k) {
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
            compliance: (model.link_compliance.as_ref()).map(|given| lay_out(n, &|k| given[k])),
            front_arm: lay_out(n, &|i| model.arms[i]),
            rear_arm: lay_out(n, &|i| -model.arms[(i + 1) % n]),
            inverse_mass: lay_out(n, &|i| model.inverse_mass[i]),
            inverse_inertia: lay_out(n, &|i| model.inverse_inertia[i]),
            there: lay_out(n, &|k| f64::from(!model.hinge_is_open(k))),
            bushing_on_front: lay_out(2 * n + WIDTH, &|k| f64::from(model.link_of_bushing(k) == k)),
        }
    }
}

/// Where arrays of forces on rear ends have that of the first link: that of hinge 0 on the second link is then aligned.
pub(crate) const FIRST: usize = WIDTH - 1;

/// What an evaluation leaves of the chain.
#[derive(Debug, Clone)]
pub(crate) struct ChainArrays {
    /// Angles of the sprockets \[rad\], written before the chain is joined.
    pub(crate) sprocket_angle: Numbers,
    /// Their cosines.
    pub(crate) sprocket_cos: Numbers,
    /// Their sines.
    pub(crate) sprocket_sin: Numbers,
    /// Cosines of the links' angles, that of the first link again behind the last.
    pub(crate) cos: Numbers,
    /// Their sines, likewise.
    pub(crate) sin: Numbers,
    /// Depth of every hinge \[m\]; zero where apart.
    pub(crate) depth: Numbers,
    /// Normal force of every hinge \[N\].
    pub(crate) force: Numbers,
    /// Friction on the rear end of link k + 1, along the normal turned left \[N\]; zero without a law of friction.
    pub(crate) friction: Numbers,
    /// Force of lubricant on the front end of link k, x and y \[N\]; zero without any.
    pub(crate) film: [Numbers; 2],
    /// Squared distance of pin and bushing of every hinge \[m²\].
    pub(crate) distance_squared: Numbers,
    /// Their distance times the rate at which it grows \[m²/s\].
    pub(crate) along: Numbers,
    /// Force on the front of every link, x and y \[N\]; behind the last one what belongs to the first ones.
    pub(crate) front_force: [Numbers; 2],
    /// Force on the rear of link k, x and y \[N\], k from [`FIRST`] on; from link n on what belongs to the first ones.
    pub(crate) rear_force: [Numbers; 2],
    /// Moment on the front of every link about its hinge \[N m\], as the forces; zero without friction.
    pub(crate) front_moment: Numbers,
    /// The same on the rear of link k, k from [`FIRST`] on.
    pub(crate) rear_moment: Numbers,
    /// Angular speeds of the bushings \[rad/s\], written where teeth have friction.
    pub(crate) bushing_spin: Numbers,
    /// Centres of the bushings, x and y \[m\]. Runs of candidates that go past the last one find the first ones again behind it.
    pub(crate) bushing: [Numbers; 2],
    /// Their velocities, x and y \[m/s\].
    pub(crate) bushing_velocity: [Numbers; 2],
}

impl ChainArrays {
    pub(crate) fn new(model: &Model) -> Self {
        let n = model.links;
        let once = || padded_zeros(2 * n + 3 * WIDTH);
        let twice = || [0, 1].map(|_| once());
        let sprockets = || padded_zeros(model.sprockets.len());
        Self {
            sprocket_angle: sprockets(),
            sprocket_cos: sprockets(),
            sprocket_sin: sprockets(),
            cos: padded_zeros(n + WIDTH),
            sin: padded_zeros(n + WIDTH),
            depth: padded_zeros(n),
            force: padded_zeros(n),
            friction: padded_zeros(n),
            film: [0, 1].map(|_| padded_zeros(n)),
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

    /// Lets the hinges that are none keep a distance of zero: nothing turns round there.
    pub(crate) fn forget_open_hinges(&mut self, ends: &OpenEnds) {
        let hinges = ends.bodies.iter().map(|end| end.hinge);
        for k in hinges
            .chain([ends.links])
            .filter(|&k| ends.hinge_is_open(k))
        {
            (self.distance_squared[k], self.along[k]) = (0.0, 0.0);
        }
    }

    /// The same of rollers on bushings that are none.
    pub(crate) fn forget_absent_rollers(&mut self, model: &Model) {
        for k in model.absent_rollers() {
            (self.distance_squared[k], self.along[k]) = (0.0, 0.0);
        }
    }

    /// No moments yet.
    pub(crate) fn clear_moments(&mut self) {
        self.front_moment.fill(0.0);
        self.rear_moment.fill(0.0);
    }

    /// Writes the angular speeds of the bushings, those of links; the first `overhang` ones again behind the last.
    pub(crate) fn spin_bushings(
        &mut self,
        constants: &LinkConstants,
        spin: &[f64],
        overhang: usize,
    ) {
        let n = spin.len();
        let (own, behind) = self.bushing_spin.split_at_mut(n);
        for (k, bushing) in own.iter_mut().enumerate() {
            let on_front = constants.bushing_on_front[k] > 0.0;
            let rear = if k + 1 == n { 0 } else { k + 1 };
            *bushing = spin[if on_front { k } else { rear }];
        }
        behind[..overhang].copy_from_slice(&own[..overhang]);
    }

    /// Puts zeros behind the last of `links` bushings, where longer runs may have left what is no number: vectors at the end of
    /// a run read it, and no number times no force is none.
    pub(crate) fn clear_repeated(&mut self, links: usize) {
        for array in self.bushing.iter_mut().chain(&mut self.bushing_velocity) {
            array[links..].fill(0.0);
        }
    }
}
