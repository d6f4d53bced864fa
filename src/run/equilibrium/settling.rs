//! Newton's method on the forces of a system at rest, with a step γ that grows while they decrease.

/// First γ \[s\]: a link falls by 10 nm.
const FIRST_GAMMA: f64 = 3e-5;
/// Shortest γ \[s\].
const SHORTEST_GAMMA: f64 = 1e-6;
/// Factor of γ after a singular matrix, a step that is not finite or against the forces, or one that the constraints do not permit.
const GAMMA_AFTER_FAILURE: f64 = 0.25;
/// Factor of γ after a full step whose residual is not [`TOLERATED_GROWTH`] times the one before.
const GAMMA_GROWTH: f64 = 1.5;
/// Factor of γ after a step that is limited to less than [`SHORT_SHARE`], or whose residual is above [`LARGE_GROWTH`] times the one before.
const GAMMA_REDUCTION: f64 = 0.6;
/// Ratio of residuals from which on γ does not grow.
const TOLERATED_GROWTH: f64 = 1.2;
/// Ratio of residuals above which γ shrinks.
const LARGE_GROWTH: f64 = 2.0;
/// Share of a step permitted by the largest displacement below which γ shrinks.
const SHORT_SHARE: f64 = 0.1;
/// Number of iterations between updates of the surface stored for each contact. The force jumps where two surfaces of different
/// stiffness meet, and no equilibrium may exist until one of them is kept.
const BETWEEN_MEMORIES: u32 = 500;
/// Maximum number of renewals of an equilibrium because contacts are on other surfaces than the stored ones. A contact at the junction of
/// two surfaces may alternate between them without end.
const MOST_RENEWALS: u32 = 4;
/// Number of iterations after which the second attempt begins, from the start.
const FIRST_TRY: u32 = 1500;
/// Tolerated unbalanced force, over the largest contact force or external force.
const TOLERANCE: f64 = 1e-7;
/// Tolerated unbalanced force over the same reference where the positions cannot be moved closer. A spring of 1e12 N/m that is 1 m long and
/// bears 10 N has 1e-5 of it.
const TOLERANCE_OF_ROUNDING: f64 = 1e-3;
/// Fraction of the tolerance that refinement aims at. Sagging strands are soft: a force of 1e-7 of their tension moves a link by more than
/// its contacts do.
const SOUGHT: f64 = 0.1;
/// Maximum number of refinement iterations; rounding may prevent their success.
const MOST_REFINEMENTS: u32 = 50;
/// The same where light bodies beside heavy ones are not in balance by their own loads. A pendulum turns by up to 0.1 rad in each.
const MOST_REFINEMENTS_BY_BODY: u32 = 300;

/// System whose positions are iterated to static equilibrium.
pub(super) trait Resting {
    /// Longest γ \[s\].
    fn longest_gamma(&self) -> f64;

    /// Maximum number of iterations.
    fn most_iterations(&self) -> u32;

    /// Return the positions.
    fn positions(&self) -> &[f64];

    /// Move to other positions.
    fn place(&mut self, positions: &[f64]);

    /// Evaluate the accelerations at the present positions, at rest; return the largest unbalanced force \[N\].
    fn unbalanced(&mut self) -> f64;

    /// Return the largest contact force or external force at the last evaluation \[N\]. Reactions of joints are none: near a singular
    /// position they grow beyond any load.
    fn reference_force(&self) -> f64;

    /// Return whether the unbalanced force of each body is at most `tolerance` times its own largest load, which may be far below
    /// [`Self::reference_force`].
    fn is_balanced_by_body(&self, _tolerance: f64) -> bool {
        true
    }

    /// Return whether `step` is within the rounding of the positions.
    fn is_rounding(&self, _step: &[f64]) -> bool {
        false
    }

    /// Return the largest contact force at the last evaluation \[N\].
    fn largest_force(&self) -> f64;

    /// Return whether the description has friction, which equilibrium leaves out.
    fn leaves_friction_out(&self) -> bool;

    /// Store the present surface of each contact.
    fn store_surfaces(&mut self);

    /// Write the step of backward Euler of length `gamma` \[s\] from rest at the last evaluation; return false for a singular matrix.
    fn find_step(&mut self, gamma: f64, step: &mut [f64]) -> bool;

    /// Return whether the unbalanced forces do work along `step`.
    ///
    /// A step against them leads to an equilibrium that is unstable, such as that of a rod on its end. With a shorter γ the masses
    /// determine the step, and it follows the forces.
    fn follows_forces(&self, _step: &[f64]) -> bool {
        true
    }

    /// Return the ratio of unbalanced forces from which on a step of the second attempt is taken back.
    fn most_growth(&self) -> f64 {
        f64::INFINITY
    }

    /// Return the ratio of `step` to the largest permitted step, which is shorter in the second attempt.
    fn excess(&mut self, step: &[f64], second: bool) -> f64;

    /// Move by `share` of `step`; return false, with the positions unchanged, where the constraints do not permit it.
    fn move_by(&mut self, share: f64, step: &[f64]) -> bool;
}

/// Outcome of the iteration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settled {
    /// Largest unbalanced force \[N\].
    pub(super) residual: f64,
    /// [`Resting::largest_force`].
    pub(super) largest_force: f64,
    /// Number of iterations.
    pub(super) iterations: u32,
}

/// Return the outcome of an iteration that ends here.
fn settled(system: &impl Resting, residual: f64, iterations: u32) -> Settled {
    Settled {
        residual,
        largest_force: system.largest_force(),
        iterations,
    }
}

/// Iterate the positions of `system` to equilibrium; the outcome is an error if the iteration ends before.
pub(super) fn settle(
    system: &mut impl Resting,
    give_up: &dyn Fn() -> bool,
) -> Result<Settled, Settled> {
    let mut gamma = FIRST_GAMMA;
    let mut residual = system.unbalanced();
    let begin = system.positions().to_vec();
    let (mut step, mut here) = (vec![0.0; begin.len()], begin.clone());
    let (mut renewals, mut refinements, mut iterations, mut second) = (0, 0, 0, false);
    let mut tolerance = TOLERANCE;
    // Springs that relax leave no force to compare the rounding of their positions with, except that of the start.
    let first = system.reference_force();
    let permitted = |force: f64, tolerance: f64| {
        let rounding = tolerance > TOLERANCE;
        tolerance * if rounding { force.max(first) } else { force }
    };
    loop {
        let allowed = permitted(system.reference_force(), tolerance);
        let refines = residual <= allowed
            && iterations < system.most_iterations()
            && (residual > SOUGHT * allowed && refinements < MOST_REFINEMENTS
                || tolerance == TOLERANCE
                    && refinements < MOST_REFINEMENTS_BY_BODY
                    && !system.is_balanced_by_body(tolerance));
        refinements += u32::from(refines);
        if residual <= allowed && !refines {
            // The forces are in balance on the stored surfaces, which may differ from the present ones.
            let renews = renewals < MOST_RENEWALS;
            if renews {
                renewals += 1;
                system.store_surfaces();
                residual = system.unbalanced();
            }
            if !renews || residual <= permitted(system.reference_force(), tolerance) {
                return Ok(settled(system, residual, iterations));
            }
        }
        if iterations == system.most_iterations() || !residual.is_finite() || give_up() {
            return Err(settled(system, residual, iterations));
        }
        iterations += 1;
        if iterations == FIRST_TRY && !refines {
            // After bushings have been thrown from tooth to tooth, no equilibrium is near any more.
            system.place(&begin);
            second = true;
            gamma = FIRST_GAMMA;
        }
        if iterations == FIRST_TRY || iterations.is_multiple_of(BETWEEN_MEMORIES) {
            system.store_surfaces();
            residual = system.unbalanced();
        }
        // A singular matrix or a step that is not finite: γ is reduced and the iteration repeated. Here γ may fall below the shortest
        // one of other steps: the matrix tends to that of the masses, which is regular, and the next step may return to it.
        if !system.find_step(gamma, &mut step) || !step.iter().all(|step| step.is_finite()) {
            gamma *= GAMMA_AFTER_FAILURE;
            continue;
        }
        tolerance = if gamma == system.longest_gamma() && system.is_rounding(&step) {
            TOLERANCE_OF_ROUNDING
        } else {
            TOLERANCE
        };
        // The step is shortened to the largest permitted displacement.
        let share = (1.0 / system.excess(&step, second)).min(1.0);
        // No equilibrium is reached by shortened steps, which may go against the forces in the second attempt.
        let judged = share == 1.0 || !second;
        here.copy_from_slice(system.positions());
        if judged && !system.follows_forces(&step) || !system.move_by(share, &step) {
            gamma *= GAMMA_AFTER_FAILURE;
            continue;
        }
        let before = residual;
        residual = system.unbalanced();
        if second && residual > system.most_growth() * before && gamma > SHORTEST_GAMMA {
            system.place(&here);
            residual = before;
            gamma *= GAMMA_AFTER_FAILURE;
            continue;
        }
        gamma = if share == 1.0 && residual < TOLERATED_GROWTH * before {
            (GAMMA_GROWTH * gamma).min(system.longest_gamma())
        } else if share < SHORT_SHARE || residual > LARGE_GROWTH * before {
            (GAMMA_REDUCTION * gamma).max(SHORTEST_GAMMA)
        } else {
            gamma
        };
    }
}
