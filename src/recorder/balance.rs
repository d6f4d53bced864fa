//! The energy balance: its channels, and whether it closes.

use super::rows::Row;
use crate::dynamics::{Dynamics, Energy, Powers};
use crate::model::Model;

/// Energy stored, and the sums of energy dissipated and worked in, when a recording begins \[J\].
#[derive(Debug, Clone, Copy)]
pub(super) struct EnergyAtStart {
    total: f64,
    sums: Powers,
}

/// What passed since the first report, and what is missing \[J\].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Passed {
    pub(crate) dissipated: f64,
    pub(crate) worked_in: f64,
    pub(crate) residual: f64,
}

/// `sums` without what bristles store of the work of friction.
pub(super) fn dissipated_alone(mut sums: Powers, dynamics: &Dynamics) -> Powers {
    if !dynamics.model().bristles.is_empty() {
        let stored = dynamics.stored();
        sums.dissipated -= stored.total();
        sums.losses = stored.taken_off(sums.losses);
    }
    sums
}

pub(super) fn write_energy(
    row: &mut Row,
    model: &Model,
    energy: Energy,
    sums: Powers,
    begin: &mut Option<EnergyAtStart>,
) -> Passed {
    let begin = begin.get_or_insert(EnergyAtStart {
        total: energy.total(),
        sums,
    });
    let since = sums + -1.0 * begin.sums;
    let (dissipated, worked_in) = (since.dissipated, since.worked_in);
    let residual = energy.total() - begin.total + dissipated - worked_in;
    for value in [
        energy.kinetic,
        energy.gravity,
        energy.elastic,
        dissipated,
        worked_in,
        residual,
    ] {
        row.real([value]);
    }
    let [
        hinges,
        teeth,
        hinges_rubbed,
        teeth_rubbed,
        rollers,
        rollers_rubbed,
        film,
    ] = since.losses.values();
    for loss in [hinges, teeth, hinges_rubbed, teeth_rubbed] {
        row.real([loss]);
    }
    // Places that this drive does not have have no channel.
    if model.rollers.is_some() {
        row.real([rollers]);
        row.real([rollers_rubbed]);
    }
    if model.hinge_film.is_some() {
        row.real([film]);
    }
    Passed {
        dissipated,
        worked_in,
        residual,
    }
}

/// Share of the energy dissipated that may be missing.
const OF_DISSIPATED: f64 = 0.05;

/// Share of the energy exchanged that may be missing besides.
const OF_EXCHANGED: f64 = 0.01;

/// Share of the kinetic and elastic energy there is that may be missing besides. In a short run that happens to be quiet, what steps
/// leave is more than was dissipated meanwhile: measured over 1200 runs of the published drive of 0.2 to 1 ms at the default accuracy,
/// the balances need up to 8e-6 besides the shares above; at ten times that accuracy a quarter of those without pretension need more
/// than this.
pub(super) const OF_STORED: f64 = 1e-5;

/// An energy balance in which more is missing than may be \[J\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct OpenBalance {
    pub(crate) missing: f64,
    pub(crate) dissipated: f64,
    pub(crate) exchanged: f64,
    pub(crate) allowed: f64,
}

/// Whether the energy balance closes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Balance {
    /// Least and largest kinetic energy at the reports so far \[J\].
    kinetic: Option<[f64; 2]>,
    /// Largest elastic energy \[J\].
    elastic: f64,
    /// The balance at the last report, where more is missing than may be.
    pub(crate) open: Option<OpenBalance>,
}

impl Balance {
    /// Takes in a report; `besides` may be missing whatever has passed \[J\].
    pub(crate) fn watch(&mut self, energy: Energy, passed: Passed, besides: f64) {
        let [least, most] = self.kinetic.unwrap_or([energy.kinetic; 2]);
        let (least, most) = (least.min(energy.kinetic), most.max(energy.kinetic));
        self.kinetic = Some([least, most]);
        self.elastic = self.elastic.max(energy.elastic);
        let exchanged = passed.dissipated + passed.worked_in.abs() + (most - least) + self.elastic;
        let allowed = OF_DISSIPATED * passed.dissipated + OF_EXCHANGED * exchanged + besides;
        self.open = (passed.residual.abs() > allowed).then_some(OpenBalance {
            missing: passed.residual,
            dissipated: passed.dissipated,
            exchanged,
            allowed,
        });
    }
}
