//! Hinge contacts: pin in bushing of every hinge, from the last evaluation of the kernels.

use pulp::{Simd, WithSimd};

use crate::chain::arrays::layout::ChainArrays;
use crate::chain::model::Model;
use crate::chain::motion::Motion;
use crate::drive::bushing_on_front;
use crate::geometry::Vec2;
use crate::math::simd::InstructionSet;

/// Contacts of all hinges. Hinge `k` joins the front end of link `k` and the rear end of link `k + 1`; one is the pin, one the bushing.
#[derive(Debug, Clone)]
pub struct HingeContacts {
    /// One where the pin is on the front of link k, minus one where the bushing is.
    pin_side: Vec<f64>,
    /// Centres of the bushings, x and y \[m\].
    pub bushing: [Vec<f64>; 2],
    /// Front end of link k relative to the rear end of link k + 1, x and y \[m\]; zero at open hinges of an open chain.
    pub offset: [Vec<f64>; 2],
    /// Inverse of the length of `offset` \[1/m\]; zero where the centres coincide.
    over_distance: Vec<f64>,
    /// Penetration δ = |e| - c \[m\].
    pub penetration: Vec<f64>,
    /// Penetration rate dδ/dt \[m/s\].
    pub rate: Vec<f64>,
    /// Normal force \[N\].
    pub force: Vec<f64>,
    /// Size of the whole force with lubricant \[N\]; empty without.
    lubricated_force: Vec<f64>,
    /// Force on the front end of link k, x and y \[N\]: film - normal force · n - friction · n turned left.
    pub on_front: [Vec<f64>; 2],
    /// Force of the lubricant film on the front end of link k, x and y \[N\]; zero without a film.
    pub film: [Vec<f64>; 2],
}

impl HingeContacts {
    /// Create arrays of zeros for `links` hinges.
    #[must_use]
    pub fn new(links: usize) -> Self {
        let zeros = || vec![0.0; links];
        let points = || [zeros(), zeros()];
        let side = |k: usize| {
            if bushing_on_front(k, links) {
                -1.0
            } else {
                1.0
            }
        };
        Self {
            pin_side: (0..links).map(side).collect(),
            bushing: points(),
            offset: points(),
            over_distance: zeros(),
            penetration: zeros(),
            rate: zeros(),
            force: zeros(),
            lubricated_force: Vec::with_capacity(links),
            on_front: points(),
            film: points(),
        }
    }

    /// Copy all hinges from the arrays `chain` of an evaluation at this motion.
    pub(crate) fn read(
        &mut self,
        model: &Model,
        motion: &Motion,
        chain: &ChainArrays,
        instructions: InstructionSet,
    ) {
        let n = model.links;
        self.force.copy_from_slice(&chain.force[..n]);
        for axis in [0, 1] {
            self.bushing[axis].copy_from_slice(&chain.bushing[axis][..n]);
            self.film[axis].copy_from_slice(&chain.film[axis][..n]);
        }
        instructions.run(ReadHinges {
            model,
            motion,
            chain,
            hinges: self,
        });
        if model.hinges.film.is_some() {
            self.lubricated_force.clear();
            // Not by `hypot`, here and below: C libraries round it differently.
            let sizes = pairs(&self.on_front).map(|[x, y]| (x * x + y * y).sqrt());
            self.lubricated_force.extend(sizes);
        }
    }

    /// Return the size of the force of every hinge that rows have \[N\]: the normal force, or the whole force with lubricant.
    #[must_use]
    pub fn recorded_forces(&self) -> &[f64] {
        if self.lubricated_force.is_empty() {
            &self.force
        } else {
            &self.lubricated_force
        }
    }

    /// Take the forces of ideal hinges on fronts \[N\] in the place of those of contacts.
    pub(crate) fn take_forces(&mut self, on_front: &[Vec<f64>; 2]) {
        self.on_front.clone_from(on_front);
        for (force, [x, y]) in self.force.iter_mut().zip(pairs(on_front)) {
            *force = (x * x + y * y).sqrt();
        }
    }

    /// Return the distance of the two ends of every hinge \[m\].
    pub fn distances(&self) -> impl Iterator<Item = f64> {
        pairs(&self.offset).map(|[x, y]| (x * x + y * y).sqrt())
    }

    /// Return the centre of the bushing of hinge `k` \[m\].
    #[must_use]
    pub fn bushing(&self, k: usize) -> Vec2 {
        at(&self.bushing, k)
    }

    /// Return the centre of the pin of each hinge relative to that of its bushing \[m\].
    pub fn eccentricities(&self) -> impl Iterator<Item = [f64; 2]> {
        self.of_pins(&self.offset)
    }

    /// Return the force on the pin of each hinge \[N\].
    pub fn forces_on_pins(&self) -> impl Iterator<Item = [f64; 2]> {
        self.of_pins(&self.on_front)
    }

    /// Return vectors of front ends as those of the pins.
    fn of_pins(&self, of_fronts: &[Vec<f64>; 2]) -> impl Iterator<Item = [f64; 2]> {
        pairs(of_fronts)
            .zip(&self.pin_side)
            .map(|([x, y], &side)| [side * x, side * y])
    }

    /// Return the force on the front end of link `k` at hinge `k` \[N\].
    #[must_use]
    pub fn force_on_front(&self, k: usize) -> Vec2 {
        at(&self.on_front, k)
    }
}

/// Return vector `k` of these arrays.
fn at([x, y]: &[Vec<f64>; 2], k: usize) -> Vec2 {
    Vec2::new(x[k], y[k])
}

/// Return the vectors of these arrays.
pub(crate) fn pairs([x, y]: &[Vec<f64>; 2]) -> impl Iterator<Item = [f64; 2]> {
    x.iter().zip(y).map(|(&x, &y)| [x, y])
}

/// Kernel of [`HingeContacts::read`]: plain loops that the compiler vectorizes for the instruction set.
struct ReadHinges<'a> {
    model: &'a Model,
    motion: &'a Motion,
    chain: &'a ChainArrays,
    hinges: &'a mut HingeContacts,
}

impl WithSimd for ReadHinges<'_> {
    type Output = ();

    #[inline(always)]
    #[allow(clippy::inline_always)] // a function that is not inlined is compiled without the kernel's instruction set
    fn with_simd<S: Simd>(self, _: S) {
        let Self {
            model,
            motion,
            chain,
            hinges,
        } = self;
        let [offset_x, offset_y] = &mut hinges.offset;
        write_offsets(offset_x, &motion.x, &model.chain.arms, &chain.cos);
        write_offsets(offset_y, &motion.y, &model.chain.arms, &chain.sin);
        for k in model.open_hinges() {
            (offset_x[k], offset_y[k]) = (0.0, 0.0);
        }
        let found = [
            &mut hinges.penetration[..],
            &mut hinges.rate,
            &mut hinges.over_distance,
        ];
        write_bores(found, chain, model.hinges.clearance);
        let contact = [&hinges.force[..], &chain.friction, &hinges.over_distance];
        write_contact_forces(&mut hinges.on_front, [offset_x, offset_y], contact);
        for (force, film) in hinges.on_front.iter_mut().zip(&hinges.film) {
            for (force, film) in force.iter_mut().zip(film) {
                *force = film - *force;
            }
        }
    }
}

/// Write `e = x_k - x_next + a_k t_k + a_next t_next` along one axis: front end of link k relative to the rear end of the next link, as
/// in the kernels (chain/rhs/chain/hinges.rs).
#[inline(always)]
#[allow(clippy::inline_always)] // it runs with the kernel's instruction set
fn write_offsets(offset: &mut [f64], center: &[f64], arms: &[f64], direction: &[f64]) {
    let n = offset.len();
    let (center, arms, direction) = (&center[..n], &arms[..n], &direction[..n]);
    for k in 0..n - 1 {
        offset[k] =
            center[k] - center[k + 1] + arms[k] * direction[k] + arms[k + 1] * direction[k + 1];
    }
    let last = n - 1;
    offset[last] = center[last] - center[0] + arms[last] * direction[last] + arms[0] * direction[0];
}

/// Write penetration \[m\], penetration rate \[m/s\] and inverse distance \[1/m\] of all joints of these arrays: cylinders in bores of a
/// radial `clearance` \[m\].
#[inline(always)]
#[allow(clippy::inline_always)] // it runs with the kernel's instruction set
pub(super) fn write_bores(
    [penetration, rate, over_distance]: [&mut [f64]; 3],
    arrays: &ChainArrays,
    clearance: f64,
) {
    let n = penetration.len();
    let (rate, over_distance) = (&mut rate[..n], &mut over_distance[..n]);
    let (squared, along) = (&arrays.distance_squared[..n], &arrays.along[..n]);
    let depth = &arrays.depth[..n];
    for k in 0..n {
        let distance = squared[k].sqrt();
        let over = if distance > 0.0 { 1.0 / distance } else { 0.0 };
        over_distance[k] = over;
        rate[k] = along[k] * over;
        // The kernel's penetration decides on contact: with zero penetration, a positive distance - clearance is rounding.
        let between = distance - clearance;
        let apart = if between < 0.0 { between } else { 0.0 };
        penetration[k] = if depth[k] == 0.0 { apart } else { depth[k] };
    }
}

/// Write force · n + friction · n turned left for each joint, with n = offset / distance.
#[inline(always)]
#[allow(clippy::inline_always)] // it runs with the kernel's instruction set
pub(super) fn write_contact_forces(
    [x, y]: &mut [Vec<f64>; 2],
    [offset_x, offset_y]: [&[f64]; 2],
    contact: [&[f64]; 3],
) {
    write_along(x, [offset_x, offset_y], contact, -1.0);
    write_along(y, [offset_y, offset_x], contact, 1.0);
}

/// Write these forces along one axis. `across`: offset along the other axis; `side`: sign of that component in the turned normal.
#[inline(always)]
#[allow(clippy::inline_always)] // it runs with the kernel's instruction set
fn write_along(
    written: &mut [f64],
    [along, across]: [&[f64]; 2],
    [force, friction, over_distance]: [&[f64]; 3],
    side: f64,
) {
    let n = written.len();
    let (along, across, over) = (&along[..n], &across[..n], &over_distance[..n]);
    let (force, friction) = (&force[..n], &friction[..n]);
    for k in 0..n {
        let turned = side * (over[k] * across[k]);
        written[k] = force[k] * (over[k] * along[k]) + friction[k] * turned;
    }
}
