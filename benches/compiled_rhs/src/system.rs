//! What an integrator of this crate integrates: a right-hand side, and what is looked at between its steps.

use rustchain::integrator::OdeSystem;

/// One step that was accepted: both ends, with the slopes there.
pub(crate) struct Accepted<'a> {
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) y_start: &'a [f64],
    pub(crate) y_end: &'a [f64],
    pub(crate) slope_start: &'a [f64],
    pub(crate) slope_end: &'a [f64],
}

impl Accepted<'_> {
    /// The solution at `t` inside the step: the cubic through both ends and their slopes.
    pub(crate) fn at(&self, t: f64, y: &mut [f64]) {
        let h = self.end - self.start;
        let s = (t - self.start) / h;
        let (rest, ends) = (1.0 - s, s * (1.0 - s));
        for (i, y) in y.iter_mut().enumerate() {
            let (a, b) = (self.y_start[i], self.y_end[i]);
            let rise = b - a;
            let bend = rest * (h * self.slope_start[i] - rise) + s * (rise - h * self.slope_end[i]);
            *y = a + s * rise + ends * bend;
        }
    }
}

/// A system with events between steps.
pub(crate) trait Evolving: OdeSystem {
    /// What a tolerance of one stands for in every component; infinite where no error is watched.
    fn scale(&self) -> Vec<f64>;

    /// Whether anything happened in an accepted step, at whose end the right-hand side was evaluated last.
    fn crossed(&mut self, step: &Accepted<'_>) -> bool;

    /// Makes what happened part of the right-hand side.
    fn remember(&mut self, step: &Accepted<'_>);

    /// Takes note of a step in which nothing happened.
    fn pass(&mut self, _: &Accepted<'_>) {}

    /// For implicit methods: the order in which the components make a narrow band, and blocks of it.
    fn pattern(&self) -> Option<&Pattern> {
        None
    }
}

/// The components in an order in which the Jacobian is a band, but for what couples to the last blocks.
pub(crate) struct Pattern {
    /// Component at each place of the band's order.
    pub(crate) component: Vec<usize>,
    /// Half the band's width.
    pub(crate) half_width: usize,
    /// Places whose columns have no row in common and are found by one evaluation.
    pub(crate) groups: Vec<Vec<usize>>,
}
