//! Links eliminated: the inverse of every link's own 3x3 block, and what remains between its two hinges.
//!
//! Row of link i: `D_i w_i + F_i q_i + R_i q_(i-1) = M_i r_i`, where `q_i` are the changes of the force of hinge i in its own
//! frame, F and R the levers of the link's front and rear there. Of hinge k: `P_k q_k = F_k^T w_k + R_(k+1)^T w_(k+1)`, with
//! 1/α and 1/η on the diagonal of P.

use pulp::{Simd, WithSimd};

use super::contacts::{BASE, HingeTerms};
use super::ring::RingBlocks;
use super::teeth::ToothTerms;
use crate::model::Model;
use crate::vector::{
    Lanes, Numbers, WIDTH, lane_numbers, load, padded_zeros, partial_load, vectors, vectors_mut,
};

/// What does not change from matrix to matrix; a link of the padding has mass and inertia one.
#[derive(Debug, Clone)]
pub(super) struct LinkInertia {
    mass: Numbers,
    inertia: Numbers,
    /// One where bushing k is on the front of link k, else zero.
    front_bushing: Numbers,
    /// One where bushing k - 1 is on the rear of link k.
    rear_bushing: Numbers,
}

impl LinkInertia {
    pub(super) fn new(model: &Model) -> Self {
        let n = model.links;
        let lay_out = |value: &dyn Fn(usize) -> f64, rest: f64| {
            let mut values = padded_zeros(n);
            values.fill(rest);
            for (i, place) in values[..n].iter_mut().enumerate() {
                *place = value(i);
            }
            values
        };
        let owner = |k: usize| model.link_of_bushing(k % n);
        Self {
            mass: lay_out(&|i| model.mass[i], 1.0),
            inertia: lay_out(&|i| model.inertia[i], 1.0),
            front_bushing: lay_out(&|i| f64::from(owner(i) == i), 0.0),
            rear_bushing: lay_out(&|i| f64::from(owner(i + n - 1) == i), 0.0),
        }
    }

    /// What belongs to a register of links, from what belongs to the bushings.
    #[inline(always)]
    pub(super) fn of_link<S: Simd>(&self, simd: S, of: &[f64], links: usize, i: usize) -> Lanes<S> {
        let (front, rear) = (at(simd, of, i), at_before(simd, of, links, i));
        let on_rear = at(simd, &self.rear_bushing, i);
        at(simd, &self.front_bushing, i).mul_add(front, on_rear * rear)
    }
}

/// Whether a bushing of a register of links touches a tooth.
#[inline(always)]
pub(super) fn touched<S: Simd>(teeth: &ToothTerms, links: usize, i: usize) -> bool {
    // Whole groups, so that every width takes the same way.
    let first = i * S::F64_LANES / WIDTH * WIDTH;
    teeth.touches(first, WIDTH) || teeth.touches(if first > 0 { first - 1 } else { links - 1 }, 1)
}

/// Links after elimination, one array an entry.
#[derive(Debug, Clone)]
pub(super) struct LinkTerms {
    /// Inverse of D.
    inverse: [Numbers; 6],
    /// Turning the link moves its front along n and t of its hinge, its rear along those of the hinge before \[m\].
    lever: [Numbers; 4],
    /// `F^T D⁻¹ F` and `R^T D⁻¹ R`, entries as in the ring's blocks.
    own: [[Numbers; 3]; 2],
    /// The ring of the hinges.
    pub(super) ring: RingBlocks,
    /// Scratch of a solution: what links alone do to the hinges of their fronts, and to the ones before; the first link once
    /// more behind the last.
    push: [[Numbers; 2]; 2],
    /// Scratch: changes of hinge forces; hinge k at [`BASE`] + k.
    hinge: [Numbers; 2],
}

impl LinkTerms {
    pub(super) fn new(links: usize) -> Self {
        let zeros = || padded_zeros(links);
        let with_first = || padded_zeros(links + WIDTH);
        let hinges = || padded_zeros(BASE + links);
        Self {
            inverse: [(); 6].map(|()| zeros()),
            lever: [(); 4].map(|()| zeros()),
            own: [(); 2].map(|()| [(); 3].map(|()| with_first())),
            ring: RingBlocks::new(links),
            push: [(); 2].map(|()| [(); 2].map(|()| with_first())),
            hinge: [hinges(), hinges()],
        }
    }

    /// The unknowns of the ring, which hold its right-hand sides.
    pub(super) fn ring_unknowns(&mut self, links: usize) -> [&mut [f64]; 2] {
        let [normal, tangential] = &mut self.hinge;
        [
            &mut normal[BASE..BASE + links],
            &mut tangential[BASE..BASE + links],
        ]
    }

    /// Puts the last hinge before the first as well, once the ring is solved.
    pub(super) fn close_ring(&mut self, links: usize) {
        for hinge in &mut self.hinge {
            hinge[BASE - 1] = hinge[BASE + links - 1];
        }
    }
}

#[inline(always)]
pub(super) fn at<S: Simd>(simd: S, array: &[f64], i: usize) -> Lanes<S> {
    load(simd, &vectors::<S>(array, i + 1)[i])
}

#[inline(always)]
pub(super) fn put<S: Simd>(array: &mut [f64], i: usize, values: Lanes<S>) {
    vectors_mut::<S>(array, i + 1)[i] = values.values();
}

/// Entries k - 1 of a register of links k, the last one before the first.
#[inline(always)]
fn at_before<S: Simd>(simd: S, array: &[f64], links: usize, i: usize) -> Lanes<S> {
    if i > 0 {
        return load(simd, &vectors::<S>(&array[i * S::F64_LANES - 1..], 1)[0]);
    }
    let first = lane_numbers(simd).less(Lanes::splat(simd, 0.5));
    first.select(
        Lanes::splat(simd, array[links - 1]),
        at(simd, array, 0).turned_back(),
    )
}

#[inline(always)]
fn dot<S: Simd>(a: &[Lanes<S>; 3], b: &[Lanes<S>; 3]) -> Lanes<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// A symmetric matrix, entries as in [`ENTRIES`].
#[derive(Clone, Copy)]
struct Symmetric<S: Simd>([Lanes<S>; 6]);

impl<S: Simd> Symmetric<S> {
    #[inline(always)]
    fn load(simd: S, arrays: &[Numbers; 6], i: usize) -> Self {
        let mut entries = [Lanes::splat(simd, 0.0); 6];
        for (entry, array) in entries.iter_mut().zip(arrays) {
            *entry = at(simd, array, i);
        }
        Self(entries)
    }

    #[inline(always)]
    fn inverse(&self) -> Self {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        let a = yy.mul_add(zz, -(yz * yz));
        let b = xz.mul_add(yz, -(xy * zz));
        let c = xy.mul_add(yz, -(xz * yy));
        let over = xx.constant(1.0) / xx.mul_add(a, xy.mul_add(b, xz * c));
        Self([
            a * over,
            b * over,
            c * over,
            xx.mul_add(zz, -(xz * xz)) * over,
            xy.mul_add(xz, -(xx * yz)) * over,
            xx.mul_add(yy, -(xy * xy)) * over,
        ])
    }

    #[inline(always)]
    fn times(&self, v: &[Lanes<S>; 3]) -> [Lanes<S>; 3] {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        [
            dot(&[xx, xy, xz], v),
            dot(&[xy, yy, yz], v),
            dot(&[xz, yz, zz], v),
        ]
    }
}

/// How the coordinates of a register of links move one of their ends along n and t of its hinge.
struct End<S: Simd> {
    normal: [Lanes<S>; 3],
    tangent: [Lanes<S>; 3],
}

impl<S: Simd> End<S> {
    /// The front of links `i` (`SIDE` 1) or the rear (`SIDE` -1), whose hinge is the one before.
    #[inline(always)]
    fn new<const SIDE: i8>(
        simd: S,
        terms: &HingeTerms,
        [cos, sin]: [Lanes<S>; 2],
        arm: Lanes<S>,
        i: usize,
    ) -> Self {
        let first = if SIDE > 0 { BASE } else { BASE - 1 };
        let nx = at(simd, &terms.normal[0][first..], i);
        let ny = at(simd, &terms.normal[1][first..], i);
        let lever = [
            arm * cos.mul_add(ny, -(sin * nx)),
            arm * cos.mul_add(nx, sin * ny),
        ];
        if SIDE > 0 {
            Self {
                normal: [nx, ny, lever[0]],
                tangent: [-ny, nx, lever[1]],
            }
        } else {
            Self {
                normal: [-nx, -ny, lever[0]],
                tangent: [ny, -nx, lever[1]],
            }
        }
    }
}

/// Eliminates all links; the ring remains.
pub(super) struct EliminateLinks<'a> {
    pub(super) links: usize,
    pub(super) gamma: f64,
    pub(super) inertia: &'a LinkInertia,
    /// Cosines and sines of the links.
    pub(super) direction: [&'a [f64]; 2],
    /// Half the pitch of every link \[m\].
    pub(super) arm: &'a [f64],
    /// Forces on front and rear ends, x and y \[N\].
    pub(super) front_force: [&'a [f64]; 2],
    pub(super) rear_force: [&'a [f64]; 2],
    pub(super) hinges: &'a HingeTerms,
    pub(super) teeth: &'a ToothTerms,
    pub(super) terms: &'a mut LinkTerms,
}

impl WithSimd for EliminateLinks<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.links;
        let blocks = n.div_ceil(S::F64_LANES);
        let gamma_squared = Lanes::splat(simd, self.gamma * self.gamma);
        let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
        let terms = self.terms;
        for i in 0..blocks {
            let direction = [
                at(simd, self.direction[0], i),
                at(simd, self.direction[1], i),
            ];
            let arm = at(simd, self.arm, i);
            let front = End::<S>::new::<1>(simd, self.hinges, direction, arm, i);
            let rear = End::<S>::new::<-1>(simd, self.hinges, direction, arm, i);

            let mass = at(simd, &self.inertia.mass, i);
            let pull = [
                at(simd, self.front_force[0], i) - at(simd, self.rear_force[0], i),
                at(simd, self.front_force[1], i) - at(simd, self.rear_force[1], i),
            ];
            let stretch = direction[0].mul_add(pull[0], direction[1] * pull[1]);
            let inertia =
                (gamma_squared * arm).mul_add(stretch, at(simd, &self.inertia.inertia, i));
            let inverse = if touched::<S>(self.teeth, n, i) {
                let mut own = [mass, zero, zero, mass, zero, inertia];
                for (entry, of) in own.iter_mut().zip(&self.teeth.block) {
                    *entry = *entry + self.inertia.of_link(simd, of, n, i);
                }
                Symmetric(own).inverse()
            } else {
                let light = one / mass;
                Symmetric([light, zero, zero, light, zero, one / inertia])
            };
            for (array, entry) in terms.inverse.iter_mut().zip(inverse.0) {
                put(array, i, entry);
            }
            let (front_n, front_t) = (inverse.times(&front.normal), inverse.times(&front.tangent));
            let (rear_n, rear_t) = (inverse.times(&rear.normal), inverse.times(&rear.tangent));
            put(&mut terms.lever[0], i, front.normal[2]);
            put(&mut terms.lever[1], i, front.tangent[2]);
            put(&mut terms.lever[2], i, rear.normal[2]);
            put(&mut terms.lever[3], i, rear.tangent[2]);
            let [own_front, own_rear] = &mut terms.own;
            put(&mut own_front[0], i, dot(&front.normal, &front_n));
            put(&mut own_front[1], i, dot(&front.tangent, &front_t));
            put(&mut own_front[2], i, dot(&front.normal, &front_t));
            put(&mut own_rear[0], i, dot(&rear.normal, &rear_n));
            put(&mut own_rear[1], i, dot(&rear.tangent, &rear_t));
            put(&mut own_rear[2], i, dot(&rear.normal, &rear_t));
            let before = &mut terms.ring.before;
            put(&mut before[0], i, dot(&front.normal, &rear_n));
            put(&mut before[1], i, dot(&front.normal, &rear_t));
            put(&mut before[2], i, dot(&front.tangent, &rear_n));
            put(&mut before[3], i, dot(&front.tangent, &rear_t));
        }
        let [own_front, own_rear] = &mut terms.own;
        for (entry, diagonal) in terms.ring.diagonal.iter_mut().enumerate() {
            own_rear[entry][n] = own_rear[entry][0];
            for i in 0..blocks {
                let links = at(simd, &own_front[entry], i) + at(simd, &own_rear[entry][1..], i);
                let all = match self.hinges.softness.get(entry) {
                    Some(softness) => links + at(simd, softness, i),
                    None => links,
                };
                put(diagonal, i, all);
            }
        }
    }
}

/// Residuals of accelerations times masses and inertias: right-hand sides of links.
pub(super) struct TimesInertia<'a> {
    pub(super) links: usize,
    /// All x, all y, all θ.
    pub(super) residual: &'a [f64],
    pub(super) inertia: &'a LinkInertia,
    pub(super) right: &'a mut [Numbers; 3],
}

impl WithSimd for TimesInertia<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.links;
        let inertia = &self.inertia;
        let factors = [&inertia.mass, &inertia.mass, &inertia.inertia];
        for (axis, factor) in factors.into_iter().enumerate() {
            let (whole, rest) = S::as_simd_f64s(&self.residual[axis * n..(axis + 1) * n]);
            let right = &mut self.right[axis];
            for (i, residual) in whole.iter().enumerate() {
                put(right, i, load(simd, residual) * at(simd, factor, i));
            }
            if !rest.is_empty() {
                let i = whole.len();
                put(right, i, partial_load(simd, rest) * at(simd, factor, i));
            }
        }
    }
}

/// Solves all links as if no hinge force changed, and finds what that does to the hinges: the ring's right-hand sides.
pub(super) struct SolveFree<'a> {
    pub(super) links: usize,
    /// Right-hand sides of all links, padded: x, y, θ.
    pub(super) right: &'a [Numbers; 3],
    pub(super) hinges: &'a HingeTerms,
    pub(super) terms: &'a mut LinkTerms,
}

impl WithSimd for SolveFree<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.links;
        let blocks = n.div_ceil(S::F64_LANES);
        let terms = self.terms;
        for i in 0..blocks {
            let right = [
                at(simd, &self.right[0], i),
                at(simd, &self.right[1], i),
                at(simd, &self.right[2], i),
            ];
            let w = Symmetric::load(simd, &terms.inverse, i).times(&right);
            push_hinges(simd, terms, self.hinges, 0, i, w);
            push_hinges(simd, terms, self.hinges, 1, i, [-w[0], -w[1], w[2]]);
        }
        let [front, rear] = &mut terms.push;
        for ((hinge, front), rear) in terms.hinge.iter_mut().zip(front).zip(rear) {
            rear[n] = rear[0];
            for i in 0..blocks {
                let both = at(simd, front, i) + at(simd, &rear[1..], i);
                put(&mut hinge[BASE..], i, both);
            }
        }
    }
}

/// How far links that change by `w` move the hinges of their fronts (`side` 0) or, with the signs of x and y changed, those of
/// their rears (1).
#[inline(always)]
fn push_hinges<S: Simd>(
    simd: S,
    terms: &mut LinkTerms,
    hinges: &HingeTerms,
    side: usize,
    i: usize,
    w: [Lanes<S>; 3],
) {
    let first = BASE - side;
    let nx = at(simd, &hinges.normal[0][first..], i);
    let ny = at(simd, &hinges.normal[1][first..], i);
    let lever = &terms.lever[2 * side..];
    let normal = nx.mul_add(w[0], ny.mul_add(w[1], at(simd, &lever[0], i) * w[2]));
    let tangent = ny.negate_mul_add(w[0], nx.mul_add(w[1], at(simd, &lever[1], i) * w[2]));
    put(&mut terms.push[side][0], i, normal);
    put(&mut terms.push[side][1], i, tangent);
}

/// Solves all links with the changes of hinge forces known, in place of their right-hand sides.
pub(super) struct SolveLinks<'a> {
    pub(super) links: usize,
    pub(super) hinges: &'a HingeTerms,
    pub(super) terms: &'a LinkTerms,
    pub(super) unknowns: &'a mut [Numbers; 3],
}

impl WithSimd for SolveLinks<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.links.div_ceil(S::F64_LANES);
        let terms = self.terms;
        let [x, y] = &self.hinges.normal;
        let [normal, tangential] = &terms.hinge;
        for i in 0..blocks {
            let (fx, fy) = (at(simd, &x[BASE..], i), at(simd, &y[BASE..], i));
            let (fn_, ft) = (
                at(simd, &normal[BASE..], i),
                at(simd, &tangential[BASE..], i),
            );
            let (rx, ry) = (at(simd, &x[BASE - 1..], i), at(simd, &y[BASE - 1..], i));
            let (rn, rt) = (
                at(simd, &normal[BASE - 1..], i),
                at(simd, &tangential[BASE - 1..], i),
            );
            let lever = &terms.lever;
            let front = at(simd, &lever[0], i).mul_add(fn_, at(simd, &lever[1], i) * ft);
            let rear = at(simd, &lever[2], i).mul_add(rn, at(simd, &lever[3], i) * rt);
            // Each force, turned from the frame of its hinge; the rear's is the other way round.
            let along_x = rx.mul_add(rn, ry.negate_mul_add(rt, fy * ft)) - fx * fn_;
            let along_y = ry.mul_add(rn, rx.mul_add(rt, -(fx * ft))) - fy * fn_;
            let right = [
                at(simd, &self.unknowns[0], i) + along_x,
                at(simd, &self.unknowns[1], i) + along_y,
                at(simd, &self.unknowns[2], i) - (front + rear),
            ];
            let w = Symmetric::load(simd, &terms.inverse, i).times(&right);
            for (array, w) in self.unknowns.iter_mut().zip(w) {
                put(array, i, w);
            }
        }
    }
}
