//! Matrix of the implicit corrector of a mechanism: places of its entries, and its factors.

use nalgebra::{Dyn, LU};

use super::sparse_system::{PairPlaces, Pattern, PointPlaces, RowPlaces, Saddle};
use crate::multibody::constraints::jacobian::{Group, Jacobian};
use crate::multibody::model::MechanismModel;

/// Matrix of the corrector, with the places of its entries and its factors.
#[derive(Debug, Clone)]
pub(crate) struct ImplicitMatrix {
    pub(super) saddle: Saddle,
    pub(super) joints: Vec<(PairPlaces, RowPlaces)>,
    /// Places of the points between free bodies, in the order of their constraints.
    pub(super) points: Vec<PointPlaces>,
    pub(super) forces: Vec<PairPlaces>,
    pub(super) contacts: Vec<PairPlaces>,
    /// Factors of the dense matrix by difference quotients, where it replaces the sparse one.
    pub(super) by_differences: Option<LU<f64, Dyn, Dyn>>,
}

impl ImplicitMatrix {
    /// Return the zero matrix with the places of all forces, contacts and joints.
    pub(super) fn new(model: &MechanismModel) -> Self {
        let n = model.coordinates();
        let mut pattern = Pattern::new(&model.first, n, &model.equations_of_joint);
        let pairs = || {
            let forces = model.forces.iter().map(|f| (f.a.body, f.b.body));
            forces.chain(model.contacts.iter().map(|c| (c.a.body, c.b.body)))
        };
        for (a, b) in pairs().chain(model.equations.iter().map(|e| (e.a.body, e.b.body))) {
            pattern.couple(a, b);
        }
        for (i, equation) in model.equations.iter().enumerate() {
            pattern.constrain(i, [equation.a.body, equation.b.body, equation.carrier]);
        }
        let saddle = pattern.finish();
        let mut places = pairs().map(|(a, b)| pattern.pair_places(&saddle, a, b));
        let forces = places.by_ref().take(model.forces.len()).collect();
        let contacts = places.collect();
        let joints = model.equations.iter().enumerate().map(|(i, e)| {
            let bodies = [e.a.body, e.b.body, e.carrier];
            let pair = pattern.pair_places(&saddle, e.a.body, e.b.body);
            (pair, pattern.row_places(&saddle, i, bodies))
        });
        let groups = Jacobian::of(model).groups.into_iter();
        let points = groups.filter_map(|group| match group {
            Group::Point(point) => Some(pattern.point_places(&saddle, point.row, point.places)),
            Group::Single(_) => None,
        });
        Self {
            joints: joints.collect(),
            points: points.collect(),
            forces,
            contacts,
            by_differences: None,
            saddle,
        }
    }
}
