//! Eight links in the lanes of SIMD vectors: inertias, levers of their ends, and elimination of their blocks.

use super::contacts::FrictionArms;
use super::link_ends::HingeCoupling;
use super::ring::BASE;
use super::spatial::Spatial;
use super::teeth::ToothTerms;
use crate::chain::model::Model;
use crate::math::simd::{
    Lanes, Number, Numbers, Pack, Pack8, Vectors, load, packs, parts, read, rounded_part,
    vectors_from, write,
};

/// Eight links. Links of the padding have mass and inertia one.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkGroup<T> {
    pub(super) mass: Pack8<T>,
    pub(super) inertia: Pack8<T>,
    pub(super) inverse_mass: Pack8<T>,
    /// Half the length of every link \[m\].
    arm: Pack8<T>,
    /// One where bushing k is on the front of link k, else zero.
    pub(super) front_bushing: Pack8<T>,
    /// One where bushing k - 1 is on the rear of link k.
    pub(super) rear_bushing: Pack8<T>,
    /// Whether a bushing of one of these links touches a tooth.
    pub(super) touches_teeth: bool,
    /// u and v: velocity of the link's front per angular velocity of the link \[m\].
    pub(super) lever: [Pack8<T>; 2],
    /// Inverse of D: xx, xy, xθ, yy, yθ, θθ. Without tooth contact D is diagonal and only the last entry is used.
    pub(super) inverse: [Pack8<T>; 6],
    /// Scratch of a solution: velocities of the links without changes of the hinge forces.
    pub(super) free: [Pack8<T>; 3],
    /// Scratch: the corresponding velocities of their fronts.
    pub(super) front_velocity: [Pack8<T>; 2],
}

impl<T: Number> LinkGroup<T> {
    /// Return the constants of eight links from link `first` on.
    pub(super) fn new(model: &Model, first: usize) -> Self {
        let n = model.links;
        let lay_out = |value: &dyn Fn(usize) -> f64, rest: f64| {
            let of = |i: usize| if i < n { value(i) } else { rest };
            Pack8(std::array::from_fn(|lane| T::nearest(of(first + lane))))
        };
        let owner = |k: usize| model.link_of_bushing(k % n);
        let none = Pack8::default();
        Self {
            mass: lay_out(&|i| model.chain.mass[i], 1.0),
            inertia: lay_out(&|i| model.chain.inertia[i], 1.0),
            inverse_mass: lay_out(&|i| 1.0 / model.chain.mass[i], 1.0),
            arm: lay_out(&|i| model.chain.arms[i], 0.0),
            front_bushing: lay_out(&|i| f64::from(owner(i) == i), 0.0),
            rear_bushing: lay_out(&|i| f64::from(owner(i + n - 1) == i), 0.0),
            touches_teeth: false,
            lever: [none; 2],
            inverse: [none; 6],
            free: [none; 3],
            front_velocity: [none; 2],
        }
    }

    /// Return values of the bushings on the fronts and on the rears of these links, vector `i`, which is `part` of the group; zero where
    /// that end has no bushing.
    #[inline(always)]
    pub(super) fn of_ends<S: Vectors<Number = T>>(
        &self,
        simd: S,
        of: &Bushings<S>,
        (i, part): (usize, usize),
    ) -> [Lanes<S>; 2] {
        [
            self.front_bushing.at(simd, part) * load(simd, &of.front[i]),
            self.rear_bushing.at(simd, part) * load(simd, &of.rear[i]),
        ]
    }

    /// Return D⁻¹ times `right`.
    #[inline(always)]
    pub(super) fn times_inverse<S: Vectors<Number = T>>(
        &self,
        simd: S,
        right: [Lanes<S>; 3],
        part: usize,
    ) -> [Lanes<S>; 3] {
        if self.touches_teeth {
            return Spatial(read(simd, &self.inverse, part)).times(right);
        }
        let light = self.inverse_mass.at(simd, part);
        let [x, y, turn] = right;
        [light * x, light * y, self.inverse[5].at(simd, part) * turn]
    }

    /// Return the blocks D of links whose bushings touch teeth.
    ///
    /// `D = diag(m, m, J) + F^T H_f F + R^T H_r R` with the stiffness H of the teeth at the front and the rear bushing. J is the
    /// inertia with the geometric stiffness. Friction adds the moments `spun` about the bushings.
    #[inline(always)]
    pub(super) fn held_links<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        (stiffness, spun): (&[Bushings<S>; 3], &[Bushings<S>; 3]),
        [u, v]: [Lanes<S>; 2],
        inertia: Lanes<S>,
        place: (usize, usize),
    ) -> Spatial<S> {
        let mass = self.mass.at(simd, place.1);
        let [front_xx, rear_xx] = self.of_ends(simd, &stiffness[0], place);
        let [front_yy, rear_yy] = self.of_ends(simd, &stiffness[1], place);
        let [front_xy, rear_xy] = self.of_ends(simd, &stiffness[2], place);
        let (xx, yy, xy) = (front_xx + rear_xx, front_yy + rear_yy, front_xy + rear_xy);
        let (dxx, dyy, dxy) = (front_xx - rear_xx, front_yy - rear_yy, front_xy - rear_xy);
        let turned = [u.mul_add(xx, v * xy), u.mul_add(xy, v * yy)];
        let mut block = [
            mass + xx,
            xy,
            u.mul_add(dxx, v * dxy),
            mass + yy,
            u.mul_add(dxy, v * dyy),
            u.mul_add(turned[0], v.mul_add(turned[1], inertia)),
        ];
        if FRICTION {
            let [front_x, rear_x] = self.of_ends(simd, &spun[0], place);
            let [front_y, rear_y] = self.of_ends(simd, &spun[1], place);
            let [front, rear] = self.of_ends(simd, &spun[2], place);
            block[2] = block[2] + (front_x + rear_x);
            block[4] = block[4] + (front_y + rear_y);
            let crossed = u.mul_add(front_x - rear_x, v * (front_y - rear_y));
            block[5] = block[5] + ((crossed + crossed) + (front + rear));
        }
        Spatial(block)
    }
}

/// Array of bushings as vectors of links: bushings on their fronts, and bushings on their rears.
#[derive(Clone, Copy)]
pub(super) struct Bushings<'a, S: Vectors> {
    front: &'a [S::Vector],
    rear: &'a [S::Vector],
}

impl<'a, S: Vectors> Bushings<'a, S> {
    /// Return the first `count` vectors; bushing k is at [`BASE`] + k.
    #[inline(always)]
    pub(super) fn of(array: &'a [S::Number], count: usize) -> Self {
        Self {
            front: vectors_from::<S>(array, BASE, count),
            rear: vectors_from::<S>(array, BASE - 1, count),
        }
    }

    /// Return three arrays.
    #[inline(always)]
    pub(super) fn of_three([x, y, z]: &'a [Numbers<S::Number>; 3], count: usize) -> [Self; 3] {
        [Self::of(x, count), Self::of(y, count), Self::of(z, count)]
    }

    /// Return an array without bushings, for one that is not read.
    #[inline(always)]
    pub(super) fn none() -> Self {
        Self {
            front: &[],
            rear: &[],
        }
    }
}

/// Input of the links' elimination.
pub(super) struct Linked<'a, T: Number> {
    pub(super) links: usize,
    pub(super) gamma: f64,
    /// Cosines and sines of the links.
    pub(super) direction: [&'a [f64]; 2],
    /// Forces on front and rear ends, x and y \[N\].
    pub(super) front_force: [&'a [f64]; 2],
    pub(super) rear_force: [&'a [f64]; 2],
    pub(super) teeth: &'a ToothTerms<T>,
    pub(super) arms: &'a FrictionArms<T>,
}

/// Arrays of the links in vectors.
pub(super) struct LinkRows<'a, S: Vectors> {
    gamma_squared: f64,
    cos: &'a [Pack],
    sin: &'a [Pack],
    front_force: [&'a [Pack]; 2],
    rear_force: [&'a [Pack]; 2],
    /// Arms of the contact points of the hinges at front and rear, see [`FrictionArms`]; empty without friction.
    front_arms: [&'a [S::Vector]; 2],
    rear_arms: [&'a [S::Vector]; 2],
}

impl<'a, S: Vectors> LinkRows<'a, S> {
    /// Return the arrays of `groups` groups of links.
    #[inline(always)]
    pub(super) fn of<const FRICTION: bool>(of: &Linked<'a, S::Number>, groups: usize) -> Self {
        let count = groups * parts::<S>().len();
        let [front_x, front_y] = of.front_force;
        let [rear_x, rear_y] = of.rear_force;
        let none: [&[S::Vector]; 2] = [&[], &[]];
        let (mut front_arms, mut rear_arms) = (none, none);
        if FRICTION {
            let ([front_u, front_v], [rear_u, rear_v]) = (&of.arms.front, &of.arms.rear);
            front_arms = [
                vectors_from::<S>(front_u, BASE, count),
                vectors_from::<S>(front_v, BASE, count),
            ];
            rear_arms = [
                vectors_from::<S>(rear_u, BASE - 1, count),
                vectors_from::<S>(rear_v, BASE - 1, count),
            ];
        }
        Self {
            gamma_squared: of.gamma * of.gamma,
            cos: packs(of.direction[0], groups),
            sin: packs(of.direction[1], groups),
            front_force: [packs(front_x, groups), packs(front_y, groups)],
            rear_force: [packs(rear_x, groups), packs(rear_y, groups)],
            front_arms,
            rear_arms,
        }
    }

    /// Write levers and inverse of vector `part` of group `number`; return the coupling of their hinges.
    #[inline(always)]
    pub(super) fn eliminate<const FRICTION: bool>(
        &self,
        simd: S,
        teeth: (&[Bushings<S>; 3], &[Bushings<S>; 3]),
        (links, levers): (&mut LinkGroup<S::Number>, &mut [Pack8<S::Number>; 4]),
        (number, part): (usize, usize),
    ) -> HingeCoupling<S> {
        let i = number * parts::<S>().len() + part;
        let at = |array: &[Pack]| rounded_part(simd, &array[number], part);
        let own = |array: &[S::Vector]| load(simd, &array[i]);
        let (arm, cos, sin) = (links.arm.at(simd, part), at(self.cos), at(self.sin));
        let lever = [-(arm * sin), arm * cos];
        write(&mut links.lever, part, lever);
        // Geometric stiffness: the moment of the end forces decreases by arm times stretching force per angle of the link.
        let [front_x, front_y] = [at(self.front_force[0]), at(self.front_force[1])];
        let [rear_x, rear_y] = [at(self.rear_force[0]), at(self.rear_force[1])];
        let stretch = cos.mul_add(front_x - rear_x, sin * (front_y - rear_y));
        let gamma_squared = Lanes::splat(simd, self.gamma_squared);
        let inertia = (gamma_squared * arm).mul_add(stretch, links.inertia.at(simd, part));
        let mut contacts = [lever; 2];
        if FRICTION {
            let [u, v] = lever;
            let [front_u, front_v] = [own(self.front_arms[0]), own(self.front_arms[1])];
            let [rear_u, rear_v] = [own(self.rear_arms[0]), own(self.rear_arms[1])];
            contacts = [[u + front_u, v + front_v], [rear_u - u, rear_v - v]];
            let [[fx, fy], [rx, ry]] = contacts;
            write(levers, part, [fx, fy, rx, ry]);
        }
        if links.touches_teeth {
            let inverse = links
                .held_links::<S, FRICTION>(simd, teeth, lever, inertia, (i, part))
                .inverse();
            write(&mut links.inverse, part, inverse.0);
            return if FRICTION {
                HingeCoupling::apart(&inverse, contacts)
            } else {
                HingeCoupling::of_held(&inverse, lever)
            };
        }
        let turn = inertia.constant(1.0) / inertia;
        links.inverse[5].put(part, turn);
        let light = links.inverse_mass.at(simd, part);
        if FRICTION {
            HingeCoupling::apart_and_free(light, turn, contacts)
        } else {
            HingeCoupling::of_free(light, turn, lever)
        }
    }
}
