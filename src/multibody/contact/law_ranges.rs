//! Contacts outside the range of their force law: warnings on the description, and the laws whose range ends at some penetration.

use std::collections::HashMap;

use super::compiled_contact::{CompiledContact, curvatures};
use crate::force_law::Elastic;
use crate::multibody::description::contact_pair::ContactPair;

/// Contacts of one law whose range ends at some penetration.
#[derive(Debug, Clone)]
pub(crate) struct EndingLaw {
    pub(super) law: Elastic,
    /// Number of each contact, and the penetration at which the law ends first on one of its pieces \[m\].
    pub(super) contacts: Vec<(usize, f64)>,
}

/// Return the laws whose range ends, each with its contacts.
pub(crate) fn ending_laws(pairs: &[ContactPair], compiled: &[CompiledContact]) -> Vec<EndingLaw> {
    let mut found: Vec<EndingLaw> = Vec::new();
    for (number, (pair, contact)) in pairs.iter().zip(compiled).enumerate() {
        let Some(law) = pair.law.elastic().filter(|law| law.has_an_end()) else {
            continue;
        };
        let contact = (number, contact.nearest_range_end());
        match found.iter_mut().find(|ending| ending.law == law) {
            Some(ending) => ending.contacts.push(contact),
            None => found.push(EndingLaw {
                law,
                contacts: vec![contact],
            }),
        }
    }
    found
}

/// Contacts with the same note.
struct Noted<'a> {
    /// Law of the contacts.
    law: String,
    note: String,
    first: &'a str,
    last: usize,
    count: usize,
}

/// Return warnings on laws outside their range at any penetration, and on bristles: one line for each note, with its first contact.
pub(crate) fn range_notes(pairs: &[ContactPair]) -> Vec<String> {
    let mut notes: Vec<Noted> = Vec::new();
    let mut places = HashMap::new();
    for (number, pair) in pairs.iter().enumerate() {
        let elastic = pair.law.elastic();
        let of_law = elastic.map_or(String::new(), |law| format!("{} law", law.name()));
        let of_pieces = (curvatures(pair).into_iter())
            .filter_map(|curvature| pair.law.range_note(pair.radius, curvature))
            .map(|note| (of_law.clone(), note));
        let bristles = pair.tribology.bristles();
        let of_bristles = bristles.and_then(|law| law.breakaway_note());
        let of_bristles = of_bristles.map(|note| ("LuGre friction".to_string(), note));
        // Contacts of a drive are alike: one line for all of them.
        for (law, note) in of_pieces.chain(of_bristles) {
            let place = *places
                .entry((law.clone(), note.clone()))
                .or_insert(notes.len());
            match notes.get_mut(place) {
                Some(noted) if noted.last == number => {}
                Some(noted) => (noted.last, noted.count) = (number, noted.count + 1),
                None => notes.push(Noted {
                    law,
                    note,
                    first: &pair.name,
                    last: number,
                    count: 1,
                }),
            }
        }
    }
    notes.iter().map(Noted::line).collect()
}

impl Noted<'_> {
    fn line(&self) -> String {
        let Self {
            law, note, first, ..
        } = self;
        match self.count - 1 {
            0 => format!("{law}, contact {first:?}: {note}"),
            others => format!("{law}, contact {first:?} and {others} more: {note}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{contact, evaluated, frames, model};
    use super::*;
    use crate::force_law::{ForceLaw, LuGre};
    use crate::multibody::description::contact_law::ContactLaw;
    use crate::multibody::description::profile::Profile;
    use crate::multibody::description::tribology::FrictionLaw;

    /// Return a pin of 5 mm in a bore with a radial clearance \[m\] and a law.
    fn pin(name: &str, clearance: f64, elastic: Elastic) -> ContactPair {
        let radius = 5e-3;
        ContactPair {
            name: name.into(),
            law: ContactLaw::Surfaces {
                law: ForceLaw {
                    elastic,
                    ..ForceLaw::default()
                },
                contact_modulus: 1e11,
                restitution: 0.9,
                length: 0.01,
                min_impact_velocity: 1e-3,
            },
            ..contact(
                Profile::Bore {
                    radius: radius + clearance,
                },
                radius,
            )
        }
    }

    #[test]
    fn contacts_with_the_same_note_have_one_line() {
        let (fitted, narrow, narrower) = (1e-4, 2e-6, 1e-6);
        let enhanced = |name, clearance| pin(name, clearance, Elastic::EnhancedCylinder);
        let mut bristled = pin("D", narrow, Elastic::Hertz);
        bristled.tribology.friction = Some(FrictionLaw::LuGre(LuGre {
            static_coefficient: 0.1,
            kinetic_coefficient: 0.1,
            stiffness: 1e2,
            damping: 0.0,
            viscous_coefficient: 0.0,
            stribeck_speed: 1e-3,
            stribeck_exponent: 2.0,
        }));
        let notes = range_notes(&[
            enhanced("A", fitted),
            enhanced("B", narrow),
            enhanced("C", narrower),
            bristled,
            enhanced("E", narrow),
        ]);
        let begins: Vec<&str> = (notes.iter())
            .filter_map(|note| note.split_once(": "))
            .map(|(begin, _)| begin)
            .collect();
        let law = Elastic::EnhancedCylinder.name();
        assert_eq!(
            begins,
            [
                format!("{law} law, contact \"B\" and 1 more"),
                format!("{law} law, contact \"C\""),
                "LuGre friction, contact \"D\"".to_string(),
            ]
        );
        assert!(notes[0].contains("dR = 0.0020 mm") && notes[2].contains("or more"));
    }

    #[test]
    fn the_first_contact_past_the_end_of_each_law_is_noted_once() {
        let clearance = 1e-5;
        let hertz = pin("A", clearance, Elastic::Hertz);
        let [johnson, other] = ["B", "C"].map(|name| pin(name, clearance, Elastic::Johnson));
        let model = model(vec![hertz, johnson, other]);
        let end = model.contacts[1].nearest_range_end();
        assert!((end / (4.0 * clearance * (-2.0f64).exp()) - 1.0).abs() < 1e-12);
        let mut states = super::super::contact_states::ContactStates::new(&model);
        assert_eq!(states.past_ends, [None]);
        for (factor, noted) in [(0.99, false), (1.01, true), (2.0, true)] {
            let ball = [[clearance + factor * end, 0.0, 0.0], [0.0; 3], [0.0; 3]];
            evaluated(&model, &mut states, &frames(&[[0.0; 3]; 3], &ball, 0.0));
            states.note_ranges(&model);
            let message = states.past_ends[0].as_deref();
            assert_eq!(message.is_some(), noted, "{factor}: {message:?}");
        }
        let message = states.past_ends[0].clone().unwrap();
        assert!(
            message.contains("contact \"B\": penetration 5.468e-6 m"),
            "{message}"
        );
        assert!(
            message.contains("the end of the law, 5.413e-6 m"),
            "{message}"
        );
    }
}
