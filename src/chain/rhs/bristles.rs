//! Bristles over vectors: deflections taken from the state, their rates put beside the accelerations.
//!
//! In a step of Newton's method an evaluation solves for them: a deflection is what was predicted of it and γ times its rate, one
//! scalar equation that is linear once the slip is known.

use pulp::Simd;

use crate::chain::model::Model;
use crate::force_law::{Ahead, BristleLaw, LuGre};
use crate::math::simd::{Lanes, Mask, Numbers, load, padded_zeros, vectors_mut};

/// Kinds of contacts, which have loops and arrays of their own.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ContactKind {
    Hinges,
    Rollers,
    /// Candidates of one sprocket, slot by slot.
    Teeth,
}

/// Deflections \[m\] of some contacts, or what was predicted of them, and their rates \[m/s\].
#[derive(Debug, Clone)]
struct BristleArrays {
    deflection: Numbers,
    rate: Numbers,
}

/// All bristles of a drive.
#[derive(Debug, Clone)]
pub(crate) struct BristleState {
    /// γ of the implicit step under way; none: deflections are those of the state.
    gamma: Option<f64>,
    /// What was predicted for it \[m\].
    predicted: Vec<f64>,
    /// What the last evaluation solved for \[m\].
    solved: Vec<f64>,
    /// By [`ContactKind`].
    arrays: [BristleArrays; 3],
}

impl BristleState {
    /// Room for the bristles of `model`, where it has any; `slots`: most candidates of a sprocket.
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

    /// Lets evaluations solve for the deflections, from what is `predicted` of them, with γ.
    pub(crate) fn begin_implicit_stage(&mut self, predicted: &[f64], gamma: f64) {
        self.predicted.copy_from_slice(predicted);
        self.gamma = Some(gamma);
    }

    /// Lets evaluations take deflections as they are.
    pub(crate) fn end_implicit_stage(&mut self) {
        self.gamma = None;
    }

    /// What the last evaluation of an implicit step solved for.
    pub(crate) fn solved(&self) -> &[f64] {
        &self.solved
    }

    /// Before an evaluation: only those move that it finds in contact.
    pub(crate) fn begin(&mut self, rates: &mut [f64]) {
        rates.fill(0.0);
        if self.gamma.is_some() {
            self.solved.copy_from_slice(&self.predicted);
        }
    }

    /// Takes the deflections of a loop from `all`: pairs of a place in its arrays and a number among all.
    pub(crate) fn take(
        &mut self,
        kind: ContactKind,
        all: &[f64],
        slots: impl Iterator<Item = (usize, usize)>,
    ) {
        let from = if self.gamma.is_some() {
            &self.predicted
        } else {
            all
        };
        let to = &mut self.arrays[kind as usize].deflection;
        for (slot, number) in slots {
            to[slot] = from[number];
        }
    }

    /// Puts the rates of a loop where they belong among all, and what it solved for.
    pub(crate) fn put(
        &mut self,
        kind: ContactKind,
        rates: &mut [f64],
        slots: impl Iterator<Item = (usize, usize)>,
    ) {
        let from = &self.arrays[kind as usize];
        for (slot, number) in slots {
            rates[number] = from.rate[slot];
            if self.gamma.is_some() {
                self.solved[number] = from.deflection[slot];
            }
        }
    }

    /// The arrays of a loop, and what else it needs.
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

/// What a loop needs of the bristles of its contacts.
pub(crate) struct Bristling<'a> {
    law: &'a LuGre,
    /// Of the body whose outermost point is the contact \[m\].
    radius: f64,
    gamma: Option<f64>,
    deflection: &'a mut [f64],
    rate: &'a mut [f64],
}

impl<'a> Bristling<'a> {
    /// The same as vectors, from contact `first` on.
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
            deflection: vectors_mut::<S>(&mut self.deflection[first..], blocks),
            rate: vectors_mut::<S>(&mut self.rate[first..], blocks),
        }
    }

    /// The same for a loop over all that there are.
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

/// Bristles of a loop's contacts as vectors.
pub(crate) struct BristleLanes<'a, S: Simd> {
    law: BristleLaw<Lanes<S>>,
    pub(crate) radius: Lanes<S>,
    gamma: Option<Lanes<S>>,
    deflection: &'a mut [S::f64s],
    rate: &'a mut [S::f64s],
}

impl<S: Simd> BristleLanes<'_, S> {
    /// Friction of vector `i` of contacts and its slope with the slip; those that do not touch keep their deflections.
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

    /// Vector `i` of contacts of which none touches.
    #[inline(always)]
    pub(crate) fn rest(&mut self, i: usize) {
        let simd = self.radius.simd();
        self.rate[i] = Lanes::splat(simd, 0.0).values();
    }
}
