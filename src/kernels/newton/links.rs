//! Links eliminated: the inverse of every link's own 3x3 block, and what remains between its two hinges.
//!
//! Row of link i: `D_i w_i + F_i q_i + R_i q_(i-1) = M_i r_i`, where q_i are the changes of the force of hinge i in its own
//! frame, F and R the levers of the link's front and rear there. Of hinge k: `q_k = C_k (F_k^T w_k + R_(k+1)^T w_(k+1))`.

use pulp::{Simd, WithSimd};

use super::contacts::{BASE, HingeTerms};
use super::ring::LinkBlocks;
use super::teeth::ToothTerms;
use crate::model::Model;
use crate::vector::{Lanes, Numbers, WIDTH, load, padded_zeros, vectors, vectors_mut};

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
            values[..n].fill_with({
                let mut i = 0;
                move || {
                    i += 1;
                    value(i - 1)
                }
            });
            values
        };
        Self {
            mass: lay_out(&|i| model.mass[i], 1.0),
            inertia: lay_out(&|i| model.inertia[i], 1.0),
            front_bushing: lay_out(&|k| f64::from(model.link_of_bushing(k) == k), 0.0),
            rear_bushing: lay_out(
                &|k| f64::from(model.link_of_bushing((k + n - 1) % n) == k),
                0.0,
            ),
        }
    }

    /// What belongs to a register of links, from what belongs to the bushings at their fronts and at their rears.
    #[inline(always)]
    pub(super) fn of_link<S: Simd>(
        &self,
        simd: S,
        i: usize,
        front: Lanes<S>,
        rear: Lanes<S>,
    ) -> Lanes<S> {
        let on_rear = at(simd, &self.rear_bushing, i);
        at(simd, &self.front_bushing, i).mul_add(front, on_rear * rear)
    }
}

/// Links after elimination, one array an entry.
#[derive(Debug, Clone)]
pub(super) struct LinkTerms {
    /// Inverse of D.
    inverse: [Numbers; 9],
    /// Inverse of D times F: entries (coordinate, part).
    front: [Numbers; 6],
    /// Inverse of D times R.
    rear: [Numbers; 6],
    /// Turning the link moves its front along n and t of its hinge, its rear along those of the hinge before \[m\].
    lever: [Numbers; 4],
    /// What turning adds to the change of the normal force of either hinge, through the velocity of the end.
    turned: [Numbers; 2],
    /// The ring's blocks; see [`LinkBlocks`].
    blocks: [[Numbers; 4]; 4],
    /// Scratch of a solution: inverse of D times its right-hand side.
    free: [Numbers; 3],
    /// Scratch: what that does to the hinge of the front, and to the one before.
    push: [[Numbers; 2]; 2],
    /// Scratch: changes of hinge forces; hinge k at [`BASE`] + k.
    hinge: [Numbers; 2],
}

impl LinkTerms {
    pub(super) fn new(links: usize) -> Self {
        let zeros = || padded_zeros(links + 1);
        let hinges = || padded_zeros(BASE + links);
        Self {
            inverse: [(); 9].map(|()| zeros()),
            front: [(); 6].map(|()| zeros()),
            rear: [(); 6].map(|()| zeros()),
            lever: [(); 4].map(|()| zeros()),
            turned: [(); 2].map(|()| zeros()),
            blocks: [(); 4].map(|()| [(); 4].map(|()| zeros())),
            free: [(); 3].map(|()| zeros()),
            push: [(); 2].map(|()| [(); 2].map(|()| zeros())),
            hinge: [hinges(), hinges()],
        }
    }

    /// The blocks that the ring is made of.
    pub(super) fn ring_blocks(&self) -> LinkBlocks<'_> {
        let [front, rear, front_rear, rear_front] = &self.blocks;
        LinkBlocks {
            front,
            rear,
            front_rear,
            rear_front,
        }
    }

    /// Right-hand sides of the ring, once links have been solved without it: the places of its unknowns.
    pub(super) fn gather_pushes(&mut self, links: usize) -> [&mut [f64]; 2] {
        let [front, rear] = &self.push;
        for ((hinge, front), rear) in self.hinge.iter_mut().zip(front).zip(rear) {
            let hinge = &mut hinge[BASE..BASE + links];
            for ((hinge, front), rear) in hinge.iter_mut().zip(&front[..]).zip(&rear[1..links]) {
                *hinge = front + rear;
            }
            hinge[links - 1] = front[links - 1] + rear[0];
        }
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
fn at<S: Simd>(simd: S, array: &[f64], i: usize) -> Lanes<S> {
    load(simd, &vectors::<S>(array, i + 1)[i])
}

#[inline(always)]
fn put<S: Simd>(array: &mut [f64], i: usize, values: Lanes<S>) {
    vectors_mut::<S>(array, i + 1)[i] = values.values();
}

#[inline(always)]
fn dot<S: Simd>(a: &[Lanes<S>; 3], b: &[Lanes<S>; 3]) -> Lanes<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// A matrix of three rows times a vector.
#[inline(always)]
fn times<S: Simd>(rows: &[[Lanes<S>; 3]; 3], v: &[Lanes<S>; 3]) -> [Lanes<S>; 3] {
    [dot(&rows[0], v), dot(&rows[1], v), dot(&rows[2], v)]
}

#[inline(always)]
fn cross<S: Simd>(a: &[Lanes<S>; 3], b: &[Lanes<S>; 3]) -> [Lanes<S>; 3] {
    [
        a[1].mul_add(b[2], -(a[2] * b[1])),
        a[2].mul_add(b[0], -(a[0] * b[2])),
        a[0].mul_add(b[1], -(a[1] * b[0])),
    ]
}

/// Rows of the inverse.
#[inline(always)]
fn inverse<S: Simd>(rows: &[[Lanes<S>; 3]; 3]) -> [[Lanes<S>; 3]; 3] {
    let [a, b, c] = rows;
    let (bc, ca, ab) = (cross(b, c), cross(c, a), cross(a, b));
    let over = a[0].constant(1.0) / dot(a, &bc);
    let row = |i: usize| [bc[i] * over, ca[i] * over, ab[i] * over];
    [row(0), row(1), row(2)]
}

/// One end of a register of links in the frame of its hinge.
struct End<S: Simd> {
    /// How the link's coordinates move the offset along n and t.
    normal: [Lanes<S>; 3],
    tangent: [Lanes<S>; 3],
    alpha: Lanes<S>,
    beta: Lanes<S>,
    eta: Lanes<S>,
    turned: Lanes<S>,
}

impl<S: Simd> End<S> {
    /// The front of links `i` (`SIDE` 1) or the rear (`SIDE` -1), whose hinge is the one before.
    #[inline(always)]
    fn new<const SIDE: i8>(
        simd: S,
        terms: &HingeTerms,
        [cos, sin]: [Lanes<S>; 2],
        arm: Lanes<S>,
        spin: Lanes<S>,
        i: usize,
    ) -> Self {
        let first = if SIDE > 0 { BASE } else { BASE - 1 };
        let of = |array: &Numbers| at(simd, &array[first..], i);
        let [nx, ny] = [of(&terms.normal[0]), of(&terms.normal[1])];
        let lever = [
            arm * cos.mul_add(ny, -(sin * nx)),
            arm * cos.mul_add(nx, sin * ny),
        ];
        let (normal, tangent) = if SIDE > 0 {
            ([nx, ny, lever[0]], [-ny, nx, lever[1]])
        } else {
            ([-nx, -ny, lever[0]], [ny, -nx, lever[1]])
        };
        Self {
            normal,
            tangent,
            alpha: of(&terms.alpha),
            beta: of(&terms.beta),
            eta: of(&terms.eta),
            turned: -(of(&terms.damping) * spin * lever[1]),
        }
    }

    /// C times how far coordinates that change by `w` move the offset.
    #[inline(always)]
    fn push(&self, w: &[Lanes<S>; 3]) -> [Lanes<S>; 2] {
        let (normal, tangent) = (dot(&self.normal, w), dot(&self.tangent, w));
        let turned = self.turned * w[2];
        [
            self.alpha
                .mul_add(normal, self.beta.mul_add(tangent, turned)),
            self.eta * tangent,
        ]
    }
}

/// Eliminates all links; the ring's blocks remain.
pub(super) struct EliminateLinks<'a> {
    pub(super) links: usize,
    pub(super) gamma: f64,
    pub(super) inertia: &'a LinkInertia,
    /// Cosines and sines of the links.
    pub(super) direction: [&'a [f64]; 2],
    /// Half the pitch of every link \[m\].
    pub(super) arm: &'a [f64],
    /// Angular speeds \[rad/s\].
    pub(super) spin: &'a [f64],
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
        let blocks = self.links.div_ceil(S::F64_LANES);
        let gamma_squared = Lanes::splat(simd, self.gamma * self.gamma);
        let terms = self.terms;
        for i in 0..blocks {
            let direction = [
                at(simd, self.direction[0], i),
                at(simd, self.direction[1], i),
            ];
            let (arm, spin) = (at(simd, self.arm, i), at(simd, self.spin, i));
            let front = End::<S>::new::<1>(simd, self.hinges, direction, arm, spin, i);
            let rear = End::<S>::new::<-1>(simd, self.hinges, direction, arm, spin, i);

            let tooth = |e: usize| {
                let block = &self.teeth.block[e];
                let before = load_before(simd, block, self.links, i);
                self.inertia.of_link(simd, i, at(simd, block, i), before)
            };
            let mass = at(simd, &self.inertia.mass, i);
            let pull = |axis: usize| {
                at(simd, self.front_force[axis], i) - at(simd, self.rear_force[axis], i)
            };
            let stretch = direction[0].mul_add(pull(0), direction[1] * pull(1));
            let bend = (gamma_squared * arm) * stretch;
            let rows = [
                [mass + tooth(0), tooth(1), tooth(2)],
                [tooth(3), mass + tooth(4), tooth(5)],
                [
                    tooth(6),
                    tooth(7),
                    at(simd, &self.inertia.inertia, i) + (bend + tooth(8)),
                ],
            ];
            let rows = inverse(&rows);
            for (e, array) in terms.inverse.iter_mut().enumerate() {
                put(array, i, rows[e / 3][e % 3]);
            }
            let (front_n, front_t) = (times(&rows, &front.normal), times(&rows, &front.tangent));
            let (rear_n, rear_t) = (times(&rows, &rear.normal), times(&rows, &rear.tangent));
            for axis in 0..3 {
                put(&mut terms.front[2 * axis], i, front_n[axis]);
                put(&mut terms.front[2 * axis + 1], i, front_t[axis]);
                put(&mut terms.rear[2 * axis], i, rear_n[axis]);
                put(&mut terms.rear[2 * axis + 1], i, rear_t[axis]);
            }
            put(&mut terms.lever[0], i, front.normal[2]);
            put(&mut terms.lever[1], i, front.tangent[2]);
            put(&mut terms.lever[2], i, rear.normal[2]);
            put(&mut terms.lever[3], i, rear.tangent[2]);
            put(&mut terms.turned[0], i, front.turned);
            put(&mut terms.turned[1], i, rear.turned);
            let [ff, rr, fr, rf] = &mut terms.blocks;
            put_block(ff, i, [front.push(&front_n), front.push(&front_t)]);
            put_block(rr, i, [rear.push(&rear_n), rear.push(&rear_t)]);
            put_block(fr, i, [front.push(&rear_n), front.push(&rear_t)]);
            put_block(rf, i, [rear.push(&front_n), rear.push(&front_t)]);
        }
    }
}

/// Entries k - 1 of a register of links k, the last one before the first.
#[inline(always)]
pub(super) fn load_before<S: Simd>(simd: S, array: &[f64], links: usize, i: usize) -> Lanes<S> {
    if i > 0 {
        return load(simd, &vectors::<S>(&array[i * S::F64_LANES - 1..], 1)[0]);
    }
    let mut before = [0.0; WIDTH];
    before[0] = array[links - 1];
    before[1..].copy_from_slice(&array[..WIDTH - 1]);
    load(simd, &vectors::<S>(&before, 1)[0])
}

#[inline(always)]
fn put_block<S: Simd>(block: &mut [Numbers; 4], i: usize, columns: [[Lanes<S>; 2]; 2]) {
    put(&mut block[0], i, columns[0][0]);
    put(&mut block[1], i, columns[1][0]);
    put(&mut block[2], i, columns[0][1]);
    put(&mut block[3], i, columns[1][1]);
}

/// Solves all links as if no hinge force changed, and finds what that does to the hinges.
pub(super) struct SolveFree<'a> {
    pub(super) links: usize,
    /// Right-hand sides of all links, padded: x, y, θ.
    pub(super) right: &'a [Numbers; 3],
    /// Whether they are still to be multiplied by masses.
    pub(super) by_mass: Option<&'a LinkInertia>,
    pub(super) hinges: &'a HingeTerms,
    pub(super) terms: &'a mut LinkTerms,
}

impl WithSimd for SolveFree<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.links.div_ceil(S::F64_LANES);
        let terms = self.terms;
        for i in 0..blocks {
            let mut right = [
                at(simd, &self.right[0], i),
                at(simd, &self.right[1], i),
                at(simd, &self.right[2], i),
            ];
            if let Some(inertia) = self.by_mass {
                let mass = at(simd, &inertia.mass, i);
                right = [
                    right[0] * mass,
                    right[1] * mass,
                    right[2] * at(simd, &inertia.inertia, i),
                ];
            }
            let mut w = [Lanes::splat(simd, 0.0); 3];
            for (axis, w) in w.iter_mut().enumerate() {
                let row = &terms.inverse[3 * axis..];
                let row = [at(simd, &row[0], i), at(simd, &row[1], i), at(simd, &row[2], i)];
                *w = dot(&row, &right);
                put(&mut terms.free[axis], i, *w);
            }
            let [front, rear] = &mut terms.push;
            for (side, push) in [front, rear].into_iter().enumerate() {
                let of = |array: &Numbers| at(simd, &array[BASE - side..], i);
                let sign = if side == 0 { w } else { [-w[0], -w[1], w[2]] };
                let [nx, ny] = [of(&self.hinges.normal[0]), of(&self.hinges.normal[1])];
                let lever = &terms.lever[2 * side..];
                let normal = nx.mul_add(sign[0], ny.mul_add(sign[1], at(simd, &lever[0], i) * w[2]));
                let tangent = nx.mul_add(sign[1], at(simd, &lever[1], i) * w[2]) - ny * sign[0];
                let turned = at(simd, &terms.turned[side], i) * w[2];
                let (alpha, beta) = (of(&self.hinges.alpha), of(&self.hinges.beta));
                put(
                    &mut push[0],
                    i,
                    alpha.mul_add(normal, beta.mul_add(tangent, turned)),
                );
                put(&mut push[1], i, of(&self.hinges.eta) * tangent);
            }
        }
    }
}

/// Takes the hinges' part off the free solution: the solution of all links.
pub(super) struct TakeHinges<'a> {
    pub(super) links: usize,
    pub(super) terms: &'a LinkTerms,
    pub(super) solution: &'a mut [Numbers; 3],
}

impl WithSimd for TakeHinges<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let blocks = self.links.div_ceil(S::F64_LANES);
        let terms = self.terms;
        let [normal, tangential] = &terms.hinge;
        for i in 0..blocks {
            let front = [at(simd, &normal[BASE..], i), at(simd, &tangential[BASE..], i)];
            let rear = [
                at(simd, &normal[BASE - 1..], i),
                at(simd, &tangential[BASE - 1..], i),
            ];
            for axis in 0..3 {
                let entry = |of: &[Numbers; 6], part: usize| at(simd, &of[2 * axis + part], i);
                let by_front = entry(&terms.front, 0).mul_add(front[0], entry(&terms.front, 1) * front[1]);
                let by_both = entry(&terms.rear, 0).mul_add(
                    rear[0],
                    entry(&terms.rear, 1).mul_add(rear[1], by_front),
                );
                put(
                    &mut self.solution[axis],
                    i,
                    at(simd, &terms.free[axis], i) - by_both,
                );
            }
        }
    }
}
