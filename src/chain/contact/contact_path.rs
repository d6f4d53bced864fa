//! Relative kinematics of any contact pair along the last step of the integrator.

use super::impact_memory::ContactId;
use super::pair_path::{HingePath, ToothPath};
use super::roller_path::RollerPath;
use crate::chain::model::Model;
use crate::geometry::{Contact, Surface};
use crate::integrator::Adams;

/// Relative kinematics of one contact pair along a step.
#[derive(Debug)]
pub(crate) enum ContactPath<'a> {
    Hinge(HingePath<'a>),
    Roller(RollerPath<'a>),
    Tooth(ToothPath<'a>),
}

impl<'a> ContactPath<'a> {
    /// Create the path of a contact of `model` along the last step of `adams`; `None` for a roller of a chain without.
    pub(crate) fn new(model: &'a Model, adams: &'a Adams, contact: ContactId) -> Option<Self> {
        Some(match contact {
            ContactId::Hinge(k) => Self::Hinge(HingePath::new(model, adams, k)),
            ContactId::Roller(k) => Self::Roller(RollerPath::new(model, adams, k)?),
            ContactId::Tooth(pair) => {
                let (s, k) = (pair / model.links, pair % model.links);
                Self::Tooth(ToothPath::new(model, adams, k, s))
            }
        })
    }

    /// Return the contact at time `t` \[s\] inside the step.
    pub(crate) fn at(&self, t: f64) -> Contact {
        match self {
            Self::Hinge(path) => path.at(t),
            Self::Roller(path) => path.at(t),
            Self::Tooth(path) => path.at(t).contact,
        }
    }

    /// Return the surface of the tooth at time `t` \[s\]; `None` where no tooth is in contact.
    pub(crate) fn surface(&self, t: f64) -> Option<Surface> {
        match self {
            Self::Tooth(path) => Some(path.at(t).surface),
            Self::Hinge(_) | Self::Roller(_) => None,
        }
    }
}
