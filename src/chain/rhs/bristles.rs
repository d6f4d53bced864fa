//! Bristles in SIMD vectors: deflections from the state, and their rates as part of the right-hand side.
//!
//! In a step of Newton's method an evaluation solves for the deflections. A deflection is its predicted value plus γ times its
//! rate. For a given sliding velocity this is one linear scalar equation per contact.

use std::ops::Range;

use pulp::Simd;

use super::Kernels;
use crate::chain::contact::SprocketCandidates;
use crate::chain::model::{BristlePlaces, Model};
use crate::force_law::{Ahead, BristleLaw, LuGre};
use crate::math::simd::{Lanes, Mask, Numbers, load, padded_zeros, vectors_from_mut, vectors_mut};

/// Kinds of contacts; each kind has its own loop and arrays.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ContactKind {
    Hinges,
    Rollers,
    /// Candidates of one sprocket, slot by slot.
    Teeth,
}

/// Deflections of one kind of contacts \[m\], or their predicted values, and their rates \[m/s\].
#[derive(Debug, Clone)]
struct BristleArrays {
    deflection: Numbers,
    rate: Numbers,
}

/// All bristles of a drive.
#[derive(Debug, Clone)]
pub(crate) struct BristleState {
    /// γ of the current implicit step; `None`: deflections are those of the state.
    gamma: Option<f64>,
    /// Predicted deflections of this step \[m\].
    predicted: Vec<f64>,
    /// Deflections that the last evaluation solved for \[m\].
    solved: Vec<f64>,
    /// By [`ContactKind`].
    arrays: [BristleArrays; 3],
}

impl BristleState {
    /// Allocate the bristles of `model`, where it has any; `slots`: maximum number of candidates of a sprocket.
    pub(crate) fn of(model: &Model, slots: usize) -> Option<Self> {
        let places = &model.bristles;
        if places.is_empty() {
            return None;
        }
        let count = places.all().len();
        let slots = if places.teeth.is_empty() { 0 } else { slots };
        let room = [places.hinges.len(), places.rollers.len(), slots];
        Some(Self {
            gamma: None,
            predicted: vec![0.0; count],
            solved: vec![0.0; count],
            arrays: room.map(|count| BristleArrays {
                deflection: padded_zeros(count),
                rate: padded_zeros(count),
            }),
        })
    }

    /// Begin an implicit step: evaluations solve for the deflections from `predicted` values with γ.
    pub(crate) fn begin_implicit_stage(&mut self, predicted: &[f64], gamma: f64) {
        self.predicted.copy_from_slice(predicted);
        self.gamma = Some(gamma);
    }

    /// End the implicit step: evaluations use the deflections of the state.
    pub(crate) fn end_implicit_stage(&mut self) {
        self.gamma = None;
    }

    /// Return the deflections that the last evaluation of an implicit step solved for \[m\].
    pub(crate) fn solved(&self) -> &[f64] {
        &self.solved
    }

    /// Prepare an evaluation: deflections of bristles without contact keep their values, with rate zero.
    pub(crate) fn begin(&mut self, rates: &mut [f64]) {
        rates.fill(0.0);
        if self.gamma.is_some() {
            self.solved.copy_from_slice(&self.predicted);
        }
    }

    /// Copy the deflections of one kind of contacts from `all`; each piece has its first number in `all` and its slots in the arrays of
    /// this kind.
    pub(crate) fn take(
        &mut self,
        kind: ContactKind,
        all: &[f64],
        pieces: impl IntoIterator<Item = (usize, Range<usize>)>,
    ) {
        let from = if self.gamma.is_some() {
            &self.predicted
        } else {
            all
        };
        let to = &mut self.arrays[kind as usize].deflection;
        for (first, slots) in pieces {
            let numbers = first..first + slots.len();
            to[slots].copy_from_slice(&from[numbers]);
        }
    }

    /// Copy the rates of one kind of contacts into `rates`, and in an implicit step the solved deflections.
    pub(crate) fn put(
        &mut self,
        kind: ContactKind,
        rates: &mut [f64],
        pieces: impl IntoIterator<Item = (usize, Range<usize>)>,
    ) {
        let from = &self.arrays[kind as usize];
        for (first, slots) in pieces {
            let numbers = first..first + slots.len();
            rates[numbers.clone()].copy_from_slice(&from.rate[slots.clone()]);
            if self.gamma.is_some() {
                self.solved[numbers].copy_from_slice(&from.deflection[slots]);
            }
        }
    }

    /// Return the arrays and parameters for the loop over one kind of contacts.
    pub(crate) fn lend<'a>(
        &'a mut self,
        kind: ContactKind,
        law: &'a LuGre,
        radius: f64,
    ) -> Bristling<'a> {
        let BristleArrays { deflection, rate } = &mut self.arrays[kind as usize];
        Bristling {
            law,
            radius,
            gamma: self.gamma,
            deflection,
            rate,
        }
    }
}

/// Law and arrays of the bristles of a loop's contacts.
pub(crate) struct Bristling<'a> {
    law: &'a LuGre,
    /// Radius of the body whose outermost point is the contact point \[m\].
    radius: f64,
    gamma: Option<f64>,
    deflection: &'a mut [f64],
    rate: &'a mut [f64],
}

impl<'a> Bristling<'a> {
    /// Return SIMD vectors of `blocks` vectors from contact `first` on.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(
        &mut self,
        simd: S,
        first: usize,
        blocks: usize,
    ) -> BristleLanes<'_, S> {
        BristleLanes {
            law: BristleLaw::new(simd, self.law),
            radius: Lanes::splat(simd, self.radius),
            gamma: self.gamma.map(|gamma| Lanes::splat(simd, gamma)),
            deflection: vectors_from_mut::<S>(self.deflection, first, blocks),
            rate: vectors_from_mut::<S>(self.rate, first, blocks),
        }
    }

    /// Return SIMD vectors of all contacts, for a loop over all of them.
    #[inline(always)]
    pub(crate) fn into_lanes<S: Simd>(self, simd: S, blocks: usize) -> BristleLanes<'a, S> {
        BristleLanes {
            law: BristleLaw::new(simd, self.law),
            radius: Lanes::splat(simd, self.radius),
            gamma: self.gamma.map(|gamma| Lanes::splat(simd, gamma)),
            deflection: vectors_mut::<S>(self.deflection, blocks),
            rate: vectors_mut::<S>(self.rate, blocks),
        }
    }
}

/// Bristles of a loop's contacts as SIMD vectors.
pub(crate) struct BristleLanes<'a, S: Simd> {
    law: BristleLaw<Lanes<S>>,
    pub(crate) radius: Lanes<S>,
    gamma: Option<Lanes<S>>,
    deflection: &'a mut [S::f64s],
    rate: &'a mut [S::f64s],
}

impl<S: Simd> BristleLanes<'_, S> {
    /// Return the friction of vector `i` of contacts and its slope with the sliding velocity. Contacts that do not touch keep their
    /// deflections.
    #[inline(always)]
    pub(crate) fn bend(
        &mut self,
        i: usize,
        touching: Mask<S>,
        force: Lanes<S>,
        slip: Lanes<S>,
    ) -> [Lanes<S>; 2] {
        let given = load(slip.simd(), &self.deflection[i]);
        let ahead = self.gamma.map(|gamma| Ahead {
            predicted: given,
            gamma,
        });
        let bent = self.law.bend(force, slip, given, ahead.as_ref());
        let zero = slip.constant(0.0);
        self.rate[i] = touching.select(bent.rate, zero).values();
        if self.gamma.is_some() {
            self.deflection[i] = touching.select(bent.deflection, given).values();
        }
        [bent.force, bent.slope]
    }

    /// Set the rates of vector `i` of contacts to zero: none of them touches.
    #[inline(always)]
    pub(crate) fn clear_rates(&mut self, i: usize) {
        let simd = self.radius.simd();
        self.rate[i] = Lanes::splat(simd, 0.0).values();
    }
}

impl Kernels {
    /// Copy the deflections of the bristles of hinges and rollers from the state, where there are any.
    pub(super) fn take_bristles(&mut self, model: &Model, y: &[f64], rates: &mut [f64]) {
        if let Some(bristles) = &mut self.bristles {
            let places = &model.bristles;
            let all = &y[model.coordinates..][places.all()];
            bristles.begin(&mut rates[places.all()]);
            let [hinges, rollers] = joint_pieces(places);
            bristles.take(ContactKind::Hinges, all, [hinges]);
            bristles.take(ContactKind::Rollers, all, [rollers]);
        }
    }

    /// Write the rates of the bristles of hinges and rollers into `rates`.
    pub(super) fn put_bristles(&mut self, model: &Model, rates: &mut [f64]) {
        if let Some(bristles) = &mut self.bristles {
            let places = &model.bristles;
            let rates = &mut rates[places.all()];
            let [hinges, rollers] = joint_pieces(places);
            bristles.put(ContactKind::Hinges, rates, [hinges]);
            bristles.put(ContactKind::Rollers, rates, [rollers]);
        }
    }

    /// Copy the deflections of the bristles of sprocket `s` from the state, where teeth have any.
    pub(super) fn take_tooth_bristles(&mut self, model: &Model, s: usize, y: &[f64]) {
        if let (Some(bristles), Some(_)) = (&mut self.bristles, &model.teeth.bristles) {
            let all = &y[model.coordinates..][model.bristles.all()];
            let pieces = tooth_pieces(model, s, &self.candidates.sprockets[s]);
            bristles.take(ContactKind::Teeth, all, pieces);
        }
    }

    /// Write the rates of the bristles of sprocket `s` into `rates`.
    pub(super) fn put_tooth_bristles(&mut self, model: &Model, s: usize, rates: &mut [f64]) {
        if let (Some(bristles), Some(_)) = (&mut self.bristles, &model.teeth.bristles) {
            let rates = &mut rates[model.bristles.all()];
            let pieces = tooth_pieces(model, s, &self.candidates.sprockets[s]);
            bristles.put(ContactKind::Teeth, rates, pieces);
        }
    }
}

/// Return the first number and the slots of the bristles of all hinges, and of all rollers.
fn joint_pieces(places: &BristlePlaces) -> [(usize, Range<usize>); 2] {
    let hinges = places.hinges.len();
    [(0, 0..hinges), (hinges, 0..places.rollers.len())]
}

/// Return the first number and the slots of the bristles of successive candidates of sprocket `s`.
fn tooth_pieces(
    model: &Model,
    s: usize,
    candidates: &SprocketCandidates,
) -> impl Iterator<Item = (usize, Range<usize>)> {
    let places = &model.bristles;
    let first = places.teeth.start - places.hinges.start + s * model.links;
    (candidates.pieces(model.links)).map(move |(bushing, slots)| (first + bushing, slots))
}
