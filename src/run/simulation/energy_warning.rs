//! Words for an energy balance that does not close: how far it is open, and what closes it.

use crate::integrator::StepControl;
use crate::run::recorder::OpenBalance;

/// Finest accuracy \[m\] and tolerance that are advised: below, steps are near rounding.
const FINEST: f64 = 1e-13;

/// Share of what may be missing that an advised accuracy aims at: rows after the first open one may miss more. Of pins and balls that
/// bounce at an accuracy of 1e-6, 10 of 49 had an open balance with the accuracy advised for the whole of it, 1 of 98 with this.
const AIM: f64 = 0.25;

/// An energy balance that does not close, in words, and what to take for it to close.
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

/// The accuracy, in words, with which the residual should be as small as it may be.
pub(super) fn tighter_accuracy(control: &StepControl, open: &OpenBalance) -> String {
    let ratio = open.allowed / open.residual.abs();
    if control.is_by_component() {
        let finer = power_of_ten_below(control.rtol.max(control.atol) * ratio);
        format!("rtol and atol of {finer:e} or less")
    } else {
        // The residual goes with the root of the accuracy: a third for a tenth of it.
        let aim = AIM * ratio;
        let finer = power_of_ten_below(control.accuracy * aim * aim);
        format!("accuracy = {finer:e} or less")
    }
}

/// The power of ten at or below `value`, not below the finest.
fn power_of_ten_below(value: f64) -> f64 {
    let exponent = value.log10().floor().max(FINEST.log10().round());
    // Through text: a power of ten is then the number nearest to it.
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
