//! Accelerations of links and rollers from the forces of hinges and teeth, gathered per link from its two ends without write conflicts.

use pulp::{Simd, WithSimd};

use crate::chain::arrays::layout::{ChainArrays, FIRST, LinkConstants};
use crate::math::simd::{Lanes, WIDTH, both, fold_packs, load, splat_two, vectors, vectors_from};

/// Kernel of the accelerations of all links. `FRICTION`: with moments about the hinges.
pub(super) struct AccelerateLinks<'a, const FRICTION: bool> {
    pub(super) constants: &'a LinkConstants,
    pub(super) arrays: &'a mut ChainArrays,
    /// Number of tooth forces behind entry n.
    pub(super) overhang: usize,
    pub(super) gravity: [f64; 2],
    /// d²x/dt², d²y/dt² \[m/s²\] and d²θ/dt² \[rad/s²\] of all links.
    pub(super) accelerations: [&'a mut [f64]; 3],
}

impl<const FRICTION: bool> WithSimd for AccelerateLinks<'_, FRICTION> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            constants,
            arrays,
            overhang,
            gravity,
            accelerations,
        } = self;
        let n = accelerations[0].len();
        let ChainArrays {
            cos,
            sin,
            front_force,
            rear_force,
            front_moment,
            rear_moment,
            ..
        } = arrays;
        // Runs of candidates past the last bushing have written behind it.
        let count = overhang.div_ceil(WIDTH);
        for force in &mut *front_force {
            fold_packs(simd, force, n, count);
        }
        for force in &mut *rear_force {
            fold_packs(simd, &mut force[FIRST + 1..], n, count);
            force[FIRST] = force[FIRST + n];
        }
        if FRICTION {
            fold_packs(simd, front_moment, n, count);
            fold_packs(simd, &mut rear_moment[FIRST + 1..], n, count);
            rear_moment[FIRST] = rear_moment[FIRST + n];
        }
        let [(x, x_rest), (y, y_rest), (angle, angle_rest)] =
            accelerations.map(|array| S::as_mut_simd_f64s(array));
        let whole = x.len();
        let blocks = whole + usize::from(!x_rest.is_empty());
        let loads = Loads::<S, FRICTION> {
            simd,
            // A force of -0.0 may occur in some lanes only. Adding 0.0 turns -0.0 into 0.0. The sign of a zero force depends on the other lanes of its vector; the sum with 0.0
            // does not.
            gravity: splat_two(simd, [gravity[0] + 0.0, gravity[1] + 0.0]),
            cos: vectors::<S>(cos, blocks),
            sin: vectors::<S>(sin, blocks),
            arm: vectors::<S>(&constants.front_arm, blocks),
            inverse_mass: vectors::<S>(&constants.inverse_mass, blocks),
            inverse_inertia: vectors::<S>(&constants.inverse_inertia, blocks),
            front: both::<S>(front_force, 0, blocks),
            rear: both::<S>(rear_force, FIRST, blocks),
            moments: if FRICTION {
                [
                    vectors::<S>(front_moment, blocks),
                    vectors_from::<S>(rear_moment, FIRST, blocks),
                ]
            } else {
                [&[], &[]]
            },
        };
        let (y, angle) = (&mut y[..whole], &mut angle[..whole]);
        for i in 0..whole {
            [x[i], y[i], angle[i]] = loads.accelerations(i);
        }
        if !x_rest.is_empty() {
            let [x, y, angle] = loads.accelerations(whole);
            simd.partial_store_f64s(x_rest, x);
            simd.partial_store_f64s(y_rest, y);
            simd.partial_store_f64s(angle_rest, angle);
        }
    }
}

/// Kernel of the accelerations of all rollers. `FRICTION`: with moments of friction.
pub(super) struct AccelerateRollers<'a, const FRICTION: bool> {
    /// Arrays of the rollers; the forces on them are those on fronts.
    pub(super) arrays: &'a mut ChainArrays,
    /// Number of tooth forces behind entry n.
    pub(super) overhang: usize,
    pub(super) gravity: [f64; 2],
    /// 1/mass \[1/kg\] and 1/inertia \[1/(kg m²)\] of each roller.
    pub(super) inverse_mass: f64,
    pub(super) inverse_inertia: f64,
    /// d²x/dt², d²y/dt² \[m/s²\] and d²θ/dt² \[rad/s²\] of all rollers.
    pub(super) accelerations: [&'a mut [f64]; 3],
}

impl<const FRICTION: bool> WithSimd for AccelerateRollers<'_, FRICTION> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.accelerations[0].len();
        let count = self.overhang.div_ceil(WIDTH);
        let ChainArrays {
            front_force: [x, y],
            front_moment,
            ..
        } = self.arrays;
        for force in [&mut *x, y] {
            fold_packs(simd, force, n, count);
        }
        if FRICTION {
            fold_packs(simd, front_moment, n, count);
        }
        let [to_x, to_y, to_angle] = self.accelerations;
        // Adding 0.0 turns -0.0 into 0.0, as for the links.
        let [gravity_x, gravity_y] = self.gravity.map(|g| g + 0.0);
        accelerate::<S>(simd, x, self.inverse_mass, gravity_x, to_x);
        accelerate::<S>(simd, y, self.inverse_mass, gravity_y, to_y);
        if FRICTION {
            accelerate::<S>(simd, front_moment, self.inverse_inertia, 0.0, to_angle);
        } else {
            to_angle.fill(0.0);
        }
    }
}

/// Write force times inverse mass plus gravity.
#[inline(always)]
fn accelerate<S: Simd>(simd: S, force: &[f64], inverse_mass: f64, gravity: f64, to: &mut [f64]) {
    let [inverse_mass, gravity] = splat_two(simd, [inverse_mass, gravity]);
    let (to, rest) = S::as_mut_simd_f64s(to);
    let force = vectors::<S>(force, to.len() + usize::from(!rest.is_empty()));
    for (to, force) in to.iter_mut().zip(force) {
        *to = load(simd, force).mul_add(inverse_mass, gravity).values();
    }
    if !rest.is_empty() {
        let last = load(simd, &force[force.len() - 1]);
        simd.partial_store_f64s(rest, last.mul_add(inverse_mass, gravity).values());
    }
}

/// Forces, moments and constants of the links in SIMD vectors.
struct Loads<'a, S: Simd, const FRICTION: bool> {
    simd: S,
    gravity: [Lanes<S>; 2],
    cos: &'a [S::f64s],
    sin: &'a [S::f64s],
    arm: &'a [S::f64s],
    inverse_mass: &'a [S::f64s],
    inverse_inertia: &'a [S::f64s],
    front: [&'a [S::f64s]; 2],
    rear: [&'a [S::f64s]; 2],
    /// Moments on fronts and rears \[N m\]; empty without `FRICTION`.
    moments: [&'a [S::f64s]; 2],
}

impl<S: Simd, const FRICTION: bool> Loads<'_, S, FRICTION> {
    /// Return the accelerations of one vector of links: x, y, angle.
    #[inline(always)]
    fn accelerations(&self, i: usize) -> [S::f64s; 3] {
        let at = |array: &[S::f64s]| load(self.simd, &array[i]);
        let (front_x, front_y) = (at(self.front[0]), at(self.front[1]));
        let (rear_x, rear_y) = (at(self.rear[0]), at(self.rear[1]));
        let inverse_mass = at(self.inverse_mass);
        let x = (front_x + rear_x).mul_add(inverse_mass, self.gravity[0]);
        let y = (front_y + rear_y).mul_add(inverse_mass, self.gravity[1]);
        // Moment of the end forces about the centre: arm (cos, sin) × (F_front - F_rear).
        let turn = at(self.cos).mul_add(front_y - rear_y, -(at(self.sin) * (front_x - rear_x)));
        // Adding 0.0 removes the sign of a zero, as for gravity.
        let nothing = Lanes::splat(self.simd, 0.0);
        let mut moment = at(self.arm) * turn;
        if FRICTION {
            moment = moment + (at(self.moments[0]) + at(self.moments[1]));
        }
        let angle = moment.mul_add(at(self.inverse_inertia), nothing);
        [x.values(), y.values(), angle.values()]
    }
}
