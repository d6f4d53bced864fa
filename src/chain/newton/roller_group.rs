//! Eight rollers in the lanes of SIMD vectors: elimination of their velocities, and solutions with the factors.

use super::blocks::{Block, Symmetric, Vector};
use super::bores::BoreFriction;
use super::spatial::{Spatial, transposed_times};
use crate::chain::model::Model;
use crate::math::simd::{Entries, Lanes, Number, Pack8, Vectors, load, read, write};

/// Eight rollers.
#[derive(Debug, Clone, Copy)]
pub(super) struct RollerGroup<T> {
    /// One where the bushing is on the front of its link, else zero.
    pub(super) front_bushing: Pack8<T>,
    /// Whether a bushing or a tooth touches one of these rollers.
    pub(super) touches: bool,
    /// Whether a tooth touches one of these rollers.
    pub(super) meshes: bool,
    /// A; without friction only xx, yy, xy.
    inverse: [Pack8<T>; 6],
    /// A C in row-major order; without friction only four entries.
    follow: [Pack8<T>; 9],
    /// Scratch of a solution: velocities of the rollers by their own right-hand side only.
    pub(super) free: [Pack8<T>; 3],
}

impl<T: Number> RollerGroup<T> {
    /// Return eight rollers from roller `first` on.
    pub(super) fn new(model: &Model, first: usize) -> Self {
        let on_front =
            |k: usize| f64::from(u8::from(k < model.links && model.link_of_bushing(k) == k));
        let none = Pack8::default();
        Self {
            front_bushing: Pack8(std::array::from_fn(|lane| {
                T::nearest(on_front(first + lane))
            })),
            touches: false,
            meshes: false,
            inverse: [none; 6],
            follow: [none; 9],
            free: [none; 3],
        }
    }

    /// Return A times `right`: velocities of the rollers alone. Without `FRICTION`, that of θ is zero.
    #[inline(always)]
    pub(super) fn solved_rollers<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        part: usize,
        right: [Lanes<S>; 3],
    ) -> [Lanes<S>; 3] {
        if FRICTION {
            return Spatial(read(simd, &self.inverse, part)).times(right);
        }
        let [xx, yy, xy, ..] = &self.inverse;
        let inverse = Symmetric([xx.at(simd, part), yy.at(simd, part), xy.at(simd, part)]);
        let [x, y, _] = right;
        let [x, y] = inverse.of(&Vector([x, y])).0;
        [x, y, x.constant(0.0)]
    }

    /// Return A C without friction.
    #[inline(always)]
    fn follow<S: Vectors<Number = T>>(&self, simd: S, part: usize) -> Block<S> {
        let [xx, xy, yx, yy, ..] = &self.follow;
        Block([
            xx.at(simd, part),
            xy.at(simd, part),
            yx.at(simd, part),
            yy.at(simd, part),
        ])
    }

    /// Return C^T A times `right`: the force on the bushings. Without `FRICTION`, the moment is zero.
    #[inline(always)]
    pub(super) fn on_links<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        part: usize,
        right: [Lanes<S>; 3],
    ) -> [Lanes<S>; 3] {
        if FRICTION {
            return transposed_times(&read(simd, &self.follow, part), right);
        }
        let [x, y, _] = right;
        let [x, y] = self.follow(simd, part).transposed_of(&Vector([x, y])).0;
        [x, y, x.constant(0.0)]
    }

    /// Return the velocities of the rollers with those of their bushings, A C b plus their own; without `FRICTION`, of θ zero.
    #[inline(always)]
    pub(super) fn bound<S: Vectors<Number = T>, const FRICTION: bool>(
        &self,
        simd: S,
        part: usize,
        [x, y, turn]: [Lanes<S>; 3],
    ) -> [Lanes<S>; 3] {
        let own = read(simd, &self.free, part);
        if FRICTION {
            let [a, b, c, d, e, f, g, h, i] = read(simd, &self.follow, part);
            return [
                a.mul_add(x, b.mul_add(y, c.mul_add(turn, own[0]))),
                d.mul_add(x, e.mul_add(y, f.mul_add(turn, own[1]))),
                g.mul_add(x, h.mul_add(y, i.mul_add(turn, own[2]))),
            ];
        }
        let [xx, xy, yx, yy] = self.follow(simd, part).0;
        [
            xx.mul_add(x, xy.mul_add(y, own[0])),
            yx.mul_add(x, yy.mul_add(y, own[1])),
            x.constant(0.0),
        ]
    }
}

/// Stiffness of the teeth at the bushings, vector by vector. On input it acts on the rollers; on output the rollers act on the
/// bushings with it.
pub(super) struct OnTeeth<'a, S: Vectors> {
    pub(super) simd: S,
    pub(super) tooth_stiffness: [&'a mut [S::Vector]; 3],
    pub(super) spun: [&'a mut [S::Vector]; 3],
}

impl<S: Vectors> OnTeeth<'_, S> {
    /// Eliminate vector `i` of rollers without friction: velocities x and y.
    #[inline(always)]
    pub(super) fn eliminate(
        &mut self,
        i: usize,
        mass: Lanes<S>,
        bore: &Symmetric<S>,
        (group, part): (&mut RollerGroup<S::Number>, usize),
    ) {
        let [held_xx, held_yy, held_xy] = &mut self.tooth_stiffness;
        let at = |array: &[S::Vector]| load(self.simd, &array[i]);
        let (xx, yy, xy) = (mass + at(held_xx), mass + at(held_yy), at(held_xy));
        let [bore_xx, bore_yy, bore_xy] = bore.0;
        let (a, d, b) = (xx + bore_xx, yy + bore_yy, xy + bore_xy);
        let over = mass.constant(1.0) / a.mul_add(d, -(b * b));
        let inverse = Symmetric([d * over, a * over, -(b * over)]);
        let follow = inverse.times_block(&Block([bore_xx, bore_xy, bore_xy, bore_yy]));
        // The bore in series with teeth and inertia, since C = B: B - B A B = C A (M + T).
        let left = follow.transposed_times(&Block([xx, xy, xy, yy]));
        held_xx[i] = left.0[0].values();
        held_yy[i] = left.0[1].values();
        held_xy[i] = left.0[2].values();
        for (pack8, entry) in group.inverse.iter_mut().zip(inverse.0) {
            pack8.put(part, entry);
        }
        for (pack8, entry) in group.follow.iter_mut().zip(follow.0) {
            pack8.put(part, entry);
        }
    }

    /// Eliminate vector `i` of rollers with friction: velocities x, y and θ.
    #[inline(always)]
    pub(super) fn eliminate_rubbed(
        &mut self,
        i: usize,
        [mass, inertia]: [Lanes<S>; 2],
        bore: &Symmetric<S>,
        friction: &BoreFriction<S>,
        (group, part): (&mut RollerGroup<S::Number>, usize),
    ) {
        let at = |array: &[S::Vector]| load(self.simd, &array[i]);
        let own = Spatial([
            mass + at(self.tooth_stiffness[0]),
            at(self.tooth_stiffness[2]),
            at(self.spun[0]),
            mass + at(self.tooth_stiffness[1]),
            at(self.spun[1]),
            inertia + at(self.spun[2]),
        ]);
        let inverse = own
            .plus(&friction.block(bore, friction.of_roller, friction.of_roller))
            .inverse();
        let coupling = friction.coupling(bore);
        let follow = inverse.times_general(&coupling);
        // Stiffness that the bushings see: K - C^T A C.
        let left = friction
            .block(bore, friction.of_bushing, friction.of_bushing)
            .less_product(&coupling, &follow);
        let [xx, xy, xz, yy, yz, zz] = left.0;
        for (array, entry) in self.tooth_stiffness.iter_mut().zip([xx, yy, xy]) {
            array[i] = entry.values();
        }
        for (array, entry) in self.spun.iter_mut().zip([xz, yz, zz]) {
            array[i] = entry.values();
        }
        write(&mut group.inverse, part, inverse.0);
        write(&mut group.follow, part, follow);
    }
}

/// Residuals of the rollers times mass and moment of inertia.
pub(super) struct RollerResidual<'a, S: Vectors> {
    pub(super) inertias: [Lanes<S>; 2],
    pub(super) axes: [Entries<'a, S>; 3],
}

impl<S: Vectors> RollerResidual<'_, S> {
    /// Return those of vector `part` of group `number`; without `FRICTION`, that of θ is zero.
    #[inline(always)]
    pub(super) fn at<const FRICTION: bool>(&self, (number, part): (usize, usize)) -> [Lanes<S>; 3] {
        let ([mass, inertia], [x, y, turn]) = (self.inertias, &self.axes);
        let turn = if FRICTION {
            inertia * turn.at(number, part)
        } else {
            mass.constant(0.0)
        };
        [mass * x.at(number, part), mass * y.at(number, part), turn]
    }
}
