//! Kernels of the joints: penetrations of hinges and of rollers on their bushings at the end of a step, with their derivatives.

use pulp::{Simd, WithSimd};

use super::{BodyMotion, Ends};
use crate::chain::rhs::chain::{Arms, End, Links, behind_last, last_links};
use crate::chain::rhs::layout::LinkConstants;
use crate::math::simd::{Entries, Lanes, load, vectors, vectors_mut};

/// One end of each link of a SIMD vector, with its acceleration.
struct MovingEnd<S: Simd> {
    end: End<S>,
    /// d²x/dt², d²y/dt² \[m/s²\].
    acceleration: [Lanes<S>; 2],
    /// d²θ/dt² of the link \[rad/s²\].
    spin_rate: Lanes<S>,
}

impl<S: Simd> MovingEnd<S> {
    /// Return the ends at `arm` from the centres, whose accelerations are (ax, ay, d²θ/dt²): a + arm d²θ/dt² (-sin, cos) - arm (dθ/dt)²
    /// (cos, sin).
    #[inline(always)]
    fn new(
        motion: [Lanes<S>; 5],
        [ax, ay, spin_rate]: [Lanes<S>; 3],
        [arm, cos, sin]: [Lanes<S>; 3],
    ) -> Self {
        let spin = motion[4];
        let (across, inward) = (arm * spin_rate, arm * spin * spin);
        Self {
            end: End::new(motion, [arm, cos, sin]),
            acceleration: [
                across.negate_mul_add(sin, inward.negate_mul_add(cos, ax)),
                across.mul_add(cos, inward.negate_mul_add(sin, ay)),
            ],
            spin_rate,
        }
    }
}

/// Clearance of joints, and the radius of the inner body where they have friction.
#[derive(Clone, Copy)]
pub(super) struct Bore {
    pub(super) clearance: f64,
    pub(super) friction_radius: Option<f64>,
}

/// Joints of one loop in SIMD vectors.
struct Joints<'a, S: Simd> {
    clearance: Lanes<S>,
    friction_radius: Option<Lanes<S>>,
    on_front: &'a [S::f64s],
    penetration: [&'a mut [S::f64s]; 3],
    slip: [&'a mut [S::f64s]; 2],
}

impl<'a, S: Simd> Joints<'a, S> {
    #[inline(always)]
    fn new(simd: S, bore: Bore, on_front: &'a [f64], ends: &'a mut Ends, blocks: usize) -> Self {
        let [depth, rate, acceleration] = &mut ends.penetration;
        let [slip, slip_rate] = &mut ends.slip;
        let rubbed = if bore.friction_radius.is_some() {
            blocks
        } else {
            0
        };
        Self {
            clearance: Lanes::splat(simd, bore.clearance),
            friction_radius: bore
                .friction_radius
                .map(|radius| Lanes::splat(simd, radius)),
            on_front: vectors::<S>(on_front, blocks),
            penetration: [
                vectors_mut::<S>(depth, blocks),
                vectors_mut::<S>(rate, blocks),
                vectors_mut::<S>(acceleration, blocks),
            ],
            slip: [
                vectors_mut::<S>(slip, rubbed),
                vectors_mut::<S>(slip_rate, rubbed),
            ],
        }
    }

    /// Write penetrations and sliding velocities of vector `i`, with their derivatives.
    #[inline(always)]
    fn put(&mut self, i: usize, front: &MovingEnd<S>, rear: &MovingEnd<S>) {
        let (zero, one) = (self.clearance.constant(0.0), self.clearance.constant(1.0));
        let (ex, ey) = (front.end.x - rear.end.x, front.end.y - rear.end.y);
        let (vx, vy) = (front.end.vx - rear.end.vx, front.end.vy - rear.end.vy);
        let ax = front.acceleration[0] - rear.acceleration[0];
        let ay = front.acceleration[1] - rear.acceleration[1];
        let distance = ex.mul_add(ex, ey * ey).sqrt();
        let inverse = distance.greater(zero).select(one / distance, zero);
        let (nx, ny) = (ex * inverse, ey * inverse);
        let rate = nx.mul_add(vx, ny * vy);
        let across = nx.mul_add(vy, -(ny * vx));
        // The normal n turns at (t · de/dt)/|e|, so that d²|e|/dt² = n · d²e/dt² + (t · de/dt)²/|e|.
        let turning = across * inverse;
        let acceleration = turning.mul_add(across, nx.mul_add(ax, ny * ay));
        self.penetration[0][i] = (distance - self.clearance).values();
        self.penetration[1][i] = rate.values();
        self.penetration[2][i] = acceleration.values();
        let Some(radius) = self.friction_radius else {
            return;
        };
        // Sliding velocity t · de/dt + from_front ω_front - from_rear ω_rear, with the contact point of the evaluation's friction.
        let on_front = load(zero.simd(), &self.on_front[i]).greater(zero);
        let from_front = on_front.select(-(radius + distance), radius);
        let from_rear = from_front + distance;
        let front_rate = on_front.select(-rate, zero);
        let rear_rate = front_rate + rate;
        let spins = from_front.mul_add(front.end.spin, -(from_rear * rear.end.spin));
        let across_rate = nx.mul_add(ay, -(ny * ax)) - turning * rate;
        let spin_rates = from_front.mul_add(front.spin_rate, -(from_rear * rear.spin_rate))
            + front_rate.mul_add(front.end.spin, -(rear_rate * rear.end.spin));
        self.slip[0][i] = (across + spins).values();
        self.slip[1][i] = (across_rate + spin_rates).values();
    }
}

/// Kernel of the hinges. It writes the motion of the bushings, too.
pub(super) struct TraceHinges<'a> {
    /// x, y \[m\] of the links.
    pub(super) places: [&'a [f64]; 2],
    /// Rates of these coordinates, and that of θ.
    pub(super) speeds: [&'a [f64]; 3],
    /// Rates of these rates.
    pub(super) accelerations: [&'a [f64]; 3],
    pub(super) bore: Bore,
    pub(super) constants: &'a LinkConstants,
    /// Cosines and sines of the links' angles; a copy of the first follows the last.
    pub(super) direction: [&'a [f64]; 2],
    pub(super) ends: &'a mut Ends,
    pub(super) bushings: &'a mut BodyMotion,
}

impl WithSimd for TraceHinges<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.places[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let whole = blocks - 1;
        let from = whole * S::F64_LANES;
        let on_front = &self.constants.bushing_on_front;
        let mut joints = Joints::new(simd, self.bore, on_front, self.ends, blocks);
        let bushings = &mut self.bushings.vectors::<S>(blocks);
        let [x, y] = self.places;
        let [vx, vy, spin] = self.speeds;
        let [ax, ay, spin_rate] = self.accelerations;
        let motion = [x, y, vx, vy, spin];
        let accelerations = [ax, ay, spin_rate];
        let (last, last_rates) = (
            last_links(simd, motion, from),
            last_links(simd, accelerations, from),
        );
        let behind = behind_last(motion, last, from);
        let behind_rates = behind_last(accelerations, last_rates, from);
        let fronts = Links::<S, 5>::of(motion, 0, whole);
        let front_rates = Links::<S, 3>::of(accelerations, 0, whole);
        let rears = Links::<S, 5>::of(motion, 1, whole);
        let rear_rates = Links::<S, 3>::of(accelerations, 1, whole);
        let front_arms = Arms::<S>::of(&self.constants.front_arm, self.direction, 0, blocks);
        let rear_arms = Arms::<S>::of(&self.constants.rear_arm, self.direction, 1, blocks);
        for i in 0..blocks {
            let (front, rear) = if i < whole {
                let front = (fronts.at(simd, i), front_rates.at(simd, i));
                (front, (rears.at(simd, i), rear_rates.at(simd, i)))
            } else {
                ((last, last_rates), (behind, behind_rates))
            };
            let front = MovingEnd::new(front.0, front.1, front_arms.at(simd, i));
            let rear = MovingEnd::new(rear.0, rear.1, rear_arms.at(simd, i));
            joints.put(i, &front, &rear);
            let carried = load(simd, &joints.on_front[i]).greater(Lanes::splat(simd, 0.0));
            let of = |front: Lanes<S>, rear: Lanes<S>| carried.select(front, rear).values();
            let (f, r) = (&front.end, &rear.end);
            bushings.place[0][i] = of(f.x, r.x);
            bushings.place[1][i] = of(f.y, r.y);
            bushings.velocity[0][i] = of(f.vx, r.vx);
            bushings.velocity[1][i] = of(f.vy, r.vy);
            bushings.acceleration[0][i] = of(front.acceleration[0], rear.acceleration[0]);
            bushings.acceleration[1][i] = of(front.acceleration[1], rear.acceleration[1]);
            bushings.spin[0][i] = of(f.spin, r.spin);
            bushings.spin[1][i] = of(front.spin_rate, rear.spin_rate);
        }
    }
}

/// Kernel of the rollers on their bushings. It writes the motion of the rollers, too.
pub(super) struct TraceRollers<'a> {
    /// x, y \[m\] of the rollers.
    pub(super) places: [&'a [f64]; 2],
    /// Rates of these coordinates, and that of θ.
    pub(super) speeds: [&'a [f64]; 3],
    /// Rates of these rates.
    pub(super) accelerations: [&'a [f64]; 3],
    pub(super) bore: Bore,
    pub(super) constants: &'a LinkConstants,
    pub(super) ends: &'a mut Ends,
    pub(super) bushings: &'a mut BodyMotion,
    pub(super) rollers: &'a mut BodyMotion,
}

impl WithSimd for TraceRollers<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.places[0].len();
        let blocks = n.div_ceil(S::F64_LANES);
        let on_front = &self.constants.bushing_on_front;
        let mut joints = Joints::new(simd, self.bore, on_front, self.ends, blocks);
        let bushings = &self.bushings.vectors::<S>(blocks);
        let rollers = &mut self.rollers.vectors::<S>(blocks);
        let [x, y] = self.places;
        let [vx, vy, spin] = self.speeds;
        let [ax, ay, spin_rate] = self.accelerations;
        let x = Entries::<S>::of(simd, x);
        let y = Entries::<S>::of(simd, y);
        let vx = Entries::<S>::of(simd, vx);
        let vy = Entries::<S>::of(simd, vy);
        let spin = Entries::<S>::of(simd, spin);
        let ax = Entries::<S>::of(simd, ax);
        let ay = Entries::<S>::of(simd, ay);
        let spin_rate = Entries::<S>::of(simd, spin_rate);
        for i in 0..blocks {
            let of_bushing = |array: &[S::f64s]| load(simd, &array[i]);
            let roller = MovingEnd {
                end: End {
                    x: x.at(i),
                    y: y.at(i),
                    vx: vx.at(i),
                    vy: vy.at(i),
                    spin: spin.at(i),
                },
                acceleration: [ax.at(i), ay.at(i)],
                spin_rate: spin_rate.at(i),
            };
            let bushing = MovingEnd {
                end: End {
                    x: of_bushing(bushings.place[0]),
                    y: of_bushing(bushings.place[1]),
                    vx: of_bushing(bushings.velocity[0]),
                    vy: of_bushing(bushings.velocity[1]),
                    spin: of_bushing(bushings.spin[0]),
                },
                acceleration: [
                    of_bushing(bushings.acceleration[0]),
                    of_bushing(bushings.acceleration[1]),
                ],
                spin_rate: of_bushing(bushings.spin[1]),
            };
            joints.put(i, &roller, &bushing);
            rollers.place[0][i] = roller.end.x.values();
            rollers.place[1][i] = roller.end.y.values();
            rollers.velocity[0][i] = roller.end.vx.values();
            rollers.velocity[1][i] = roller.end.vy.values();
            rollers.acceleration[0][i] = roller.acceleration[0].values();
            rollers.acceleration[1][i] = roller.acceleration[1].values();
            rollers.spin[0][i] = roller.end.spin.values();
            rollers.spin[1][i] = roller.spin_rate.values();
        }
    }
}
