//! Text of the energy warning: the residual, and the remedy.

use crate::integrator::StepControl;
use crate::run::recorder::OpenBalance;

/// Smallest accuracy \[m\] and tolerance that are proposed; below, steps are near rounding.
const FINEST: f64 = 1e-13;

/// Fraction of the permitted residual aimed at by a proposed accuracy, because later rows may have larger residuals. Bouncing pins and
/// balls at an accuracy of 1e-6 were tested: 10 of 49 still had an open balance with a fraction of one, and 1 of 98 with this value.
const AIM: f64 = 0.25;

/// Return the warning of an energy balance that does not close, with its remedy.
pub(super) fn describe_open_balance(open: &OpenBalance, remedy: &str) -> String {
    let OpenBalance {
        time,
        residual,
        dissipated,
        exchanged,
        allowed,
    } = open;
    format!(
        "the energy balance is off: its residual is {residual:.1e} J at t = {time:.6} s; expected {allowed:.1e} J or less, beside \
         {dissipated:.1e} J dissipated and {exchanged:.1e} J exchanged; take {remedy}"
    )
}

/// Return the accuracy, in words, with which the residual should be within its limit.
pub(super) fn tighter_accuracy(control: &StepControl, open: &OpenBalance) -> String {
    let ratio = open.allowed / open.residual.abs();
    if control.is_by_component() {
        // With rtol and atol the residual falls about with the tolerance; no margin was measured.
        let finer = power_of_ten_below(control.rtol.max(control.atol) * ratio);
        format!("rtol and atol of {finer:e} or less")
    } else {
        // The residual is about proportional to the square root of the accuracy: a tenth of the accuracy gives a third of the residual
        // (figures in decision 20).
        let aim = AIM * ratio;
        let finer = power_of_ten_below(control.accuracy * aim * aim);
        format!("accuracy = {finer:e} or less")
    }
}

/// Return the power of ten at or below `value`, not below the smallest accuracy.
fn power_of_ten_below(value: f64) -> f64 {
    let exponent = value.log10().floor().max(FINEST.log10().round());
    // The conversion from text gives the number nearest to the power of ten.
    format!("1e{exponent:.0}").parse().unwrap_or(FINEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(control: &StepControl, residual: f64) -> String {
        let open = OpenBalance {
            time: 0.5,
            residual,
            dissipated: 1e-3,
            exchanged: 2e-3,
            allowed: 7e-5,
        };
        describe_open_balance(&open, &tighter_accuracy(control, &open))
    }

    #[test]
    fn the_advice_is_finer_by_as_much_as_the_residual_asks() {
        let default = StepControl::default();
        assert!(told(&default, 1e-4).ends_with("take accuracy = 1e-12 or less"));
        assert!(told(&default, -1e-3).ends_with("take accuracy = 1e-13 or less"));
        let by_component = StepControl {
            rtol: 1e-5,
            atol: 1e-6,
            ..default
        };
        assert!(told(&by_component, 1e-3).ends_with("take rtol and atol of 1e-7 or less"));
    }
}
