//! Constants of the teeth of a sprocket, in the form that has its own instances of the loops.

use super::ansi_gap::AnsiGap;
use super::surface_table::SurfaceTable;
use crate::chain::model::Model;
use crate::force_law::Regions;
use crate::geometry::Vec2;

/// Dimensions of a sprocket's teeth, with the law constants of every surface.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ToothConstants {
    pub(crate) form: GapForm,
    /// Whether a contact keeps the stiffness of its onset.
    pub(crate) keeps_stiffness: bool,
}

/// Tooth forms with their own instances of the loops.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum GapForm {
    /// Four surfaces of an undamaged ANSI tooth.
    Ansi(Box<AnsiGap>),
    /// Any surfaces, including damaged and eccentric teeth.
    Table(SurfaceTable),
}

impl ToothConstants {
    /// Return the constants of sprocket `s`; concentric and undamaged ANSI teeth have their own form.
    pub(crate) fn new(model: &Model, s: usize) -> Self {
        let sprocket = &model.sprockets[s];
        let plain = sprocket.offset == Vec2::zeros() && sprocket.profile.damaged().next().is_none();
        let form = match sprocket.profile.ansi_curves().filter(|_| plain) {
            Some(curves) => GapForm::Ansi(Box::new(AnsiGap::new(model, s, curves))),
            None => GapForm::Table(SurfaceTable::new(model, s)),
        };
        Self {
            form,
            keeps_stiffness: model.teeth.law.regions == Regions::Kept,
        }
    }
}
