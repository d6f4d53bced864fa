//! Tests of the runs of candidates.

use super::super::tests::{compiled, drive, with_tensioner};
use super::*;
use crate::geometry::unit;
use crate::math::testing::random;

fn runs_of(near: &[usize], n: usize) -> Vec<(usize, usize, usize)> {
    let mut runs = Vec::new();
    find_runs(n, |k| near.contains(&k), |_| true, &mut runs);
    runs.iter().map(|r| (r.first, r.length, r.slot)).collect()
}

#[test]
fn no_run_goes_over_a_bushing_that_is_not_there() {
    let mut runs = Vec::new();
    let near = [0, 1, 2, 36, 37, 38, 39];
    find_runs(40, |k| near.contains(&k), |k| k != 38, &mut runs);
    let found: Vec<_> = runs.iter().map(|r| (r.first, r.length, r.slot)).collect();
    assert_eq!(found, [(36, 2, 0), (39, 4, 8)]);
}

#[test]
fn neighbours_make_one_run_and_distant_ones_two() {
    assert_eq!(runs_of(&[3, 4, 5, 9], 40), [(3, 7, 0)]);
    assert_eq!(runs_of(&[3, 4, 20, 21], 40), [(3, 2, 0), (20, 2, 8)]);
    assert_eq!(runs_of(&[], 40), []);
}

#[test]
fn a_run_goes_past_the_last_bushing_to_the_first() {
    assert_eq!(runs_of(&[0, 1, 15, 38, 39], 40), [(15, 1, 0), (38, 4, 8)]);
    let five_and_five = [0, 1, 2, 3, 4, 35, 36, 37, 38, 39];
    assert_eq!(runs_of(&five_and_five, 40), [(0, 5, 0), (35, 5, 8)]);
    assert_eq!(runs_of(&[0, 1, 2, 3], 4), [(0, 4, 0)]);
}

/// Assert what runs promise for one choice of near and absent bushings.
fn assert_runs(n: usize, near: &[bool], there: &[bool]) {
    let mut runs = Vec::new();
    let slots = find_runs(n, |k| near[k], |k| there[k], &mut runs);
    let mut count = vec![0; n];
    let mut taken = vec![false; slots];
    for run in &runs {
        assert!(run.length > 0 && run.first < n && run.slot.is_multiple_of(WIDTH));
        for i in 0..run.length {
            let k = run.bushing(i, n);
            assert_eq!(k, (run.first + i) % n);
            count[k] += 1;
            assert!(there[k], "{k}");
        }
        // A run begins and ends with near bushings, and loads whole SIMD vectors that no other run loads.
        assert!(near[run.first] && near[run.bushing(run.length - 1, n)]);
        for slot in &mut taken[run.slot..run.slot + padded(run.length)] {
            assert!(!std::mem::replace(slot, true));
        }
    }
    assert!(taken.into_iter().all(|taken| taken));
    for k in 0..n {
        assert!(count[k] <= 1);
        if near[k] && there[k] {
            assert_eq!(count[k], 1, "{k}");
        }
    }
    // Two successive runs have a vector between them or a bushing that is not there, except at the end of the chain.
    for pair in runs.windows(2) {
        let (end, next) = (pair[0].first + pair[0].length, pair[1].first);
        let apart = next - end;
        assert!(apart >= WIDTH || (end..next).any(|k| !there[k]));
    }
    // No run is joined across more than one vector: at least one in eight of its bushings is near.
    for run in &runs {
        let found: Vec<usize> = (0..run.length)
            .filter(|&i| near[run.bushing(i, n)])
            .collect();
        assert!(found.windows(2).all(|pair| pair[1] - pair[0] <= WIDTH));
    }
}

#[test]
fn every_near_bushing_is_in_one_run_and_no_absent_one_in_any() {
    let mut next = random(21);
    for trial in 0..4000 {
        let n = 8 + trial % 60;
        let share = next();
        let near: Vec<bool> = (0..n).map(|_| next() < share).collect();
        let mut there = vec![true; n];
        if trial % 3 == 0 {
            there[trial % n] = false;
        }
        assert_runs(n, &near, &there);
    }
}

#[test]
fn the_last_and_the_first_run_join_where_that_saves_a_vector() {
    // Lengths 2 and 2 over the end: one vector instead of two. Over more than a vector's width of others there are two runs.
    let joined = |first: &[usize], last: &[usize]| {
        let mut near = [first, &[20], last].concat();
        near.sort_unstable();
        runs_of(&near, 60).len() == 2
    };
    assert!(joined(&[0, 1], &[58, 59]));
    assert!(joined(&[2, 3], &[57]));
    assert!(joined(&[3], &[56]));
    assert!(!joined(&[4], &[55]));
    assert!(!joined(&[0, 1, 2, 3, 4], &[55, 56, 57, 58, 59]));
    // Together they need no more vectors than apart: two as before.
    assert!(!joined(&[0, 1, 2, 3, 4, 5, 6, 7], &[59]));
}

/// Positions of bushings \[m\], and centres and angles of sprockets.
struct Places {
    x: Vec<f64>,
    y: Vec<f64>,
    frames: Vec<(Vec2, [f64; 2])>,
}

/// Return the bushings of the drive's chain as rings about its sprockets, at distances about their reach, with sprockets turned.
fn places(model: &Model, seed: u64) -> Places {
    let mut next = random(seed);
    let n = model.links;
    let (mut x, mut y) = (vec![0.0; n], vec![0.0; n]);
    for k in 0..n {
        let s = usize::from(k >= n / 2);
        let sprocket = &model.sprockets[s];
        let distance = sprocket.reach + model.half_pitch * 2.0 * next();
        let place = sprocket.center + distance * unit(0.3 * k as f64 + next());
        (x[k], y[k]) = (place.x, place.y);
    }
    let frames = model.sprockets.iter().enumerate().map(|(s, sprocket)| {
        let angle = 0.4 - s as f64;
        (sprocket.center, [angle.cos(), angle.sin()])
    });
    Places {
        x,
        y,
        frames: frames.collect(),
    }
}

fn refreshed(model: &Model, memory: &ImpactMemory, places: &Places) -> Candidates {
    let mut candidates = Candidates::new(model);
    candidates.refresh(
        model,
        memory,
        [&places.x, &places.y],
        places.frames.iter().copied(),
    );
    candidates
}

fn memory_of(model: &Model) -> ImpactMemory {
    ImpactMemory::new(model.links, 0, model.links * model.sprockets.len(), 1e-3)
}

/// Return the gap nearest to a bushing, by comparison with all gaps.
fn nearest_gap(sprocket: &SprocketModel, arm: Vec2, [cos, sin]: [f64; 2]) -> u32 {
    let seen = Vec2::new(arm.x * cos + arm.y * sin, arm.y * cos - arm.x * sin) - sprocket.offset;
    let towards = |gap: u32| {
        let (x, y) = sprocket.gap_directions[gap as usize];
        seen.x * x + seen.y * y
    };
    (0..sprocket.profile.teeth)
        .max_by(|a, b| towards(*a).total_cmp(&towards(*b)))
        .unwrap()
}

#[test]
fn candidates_are_all_bushings_within_reach_and_margin_each_in_its_nearest_gap() {
    let (model, _) = compiled(&drive());
    let n = model.links;
    for seed in 0..50 {
        let places = places(&model, seed);
        let mut memory = memory_of(&model);
        // A pair with a memory remains a candidate at any distance.
        memory.begin_tooth(3, 0.25, Surface::WORKING);
        memory.begin_tooth(n + 1, 0.5, Surface::TOPPING);
        let candidates = refreshed(&model, &memory, &places);
        assert_eq!(candidates.refreshes(), 1);
        let mut overhang = 0;
        for (s, of_sprocket) in candidates.sprockets.iter().enumerate() {
            let sprocket = &model.sprockets[s];
            let (center, direction) = places.frames[s];
            let slots = of_sprocket.gap.len();
            assert!(slots <= Candidates::most_slots(&model));
            for array in of_sprocket.clone().arrays() {
                assert_eq!(array.len(), slots);
            }
            let mut listed = vec![None; n];
            for (slot, k) in of_sprocket.bushings(n) {
                assert_eq!(listed[k].replace(slot), None);
                assert_eq!(of_sprocket.slot_of(k, n), Some(slot));
                let arm = Vec2::new(places.x[k], places.y[k]) - center;
                let gap = nearest_gap(sprocket, arm, direction);
                assert_eq!(of_sprocket.gap[slot], gap);
                assert_eq!(candidates.gap(&model, s, k), Some(gap));
                let (x, y) = sprocket.gap_directions[gap as usize];
                assert_eq!(
                    (of_sprocket.gap_cos[slot], of_sprocket.gap_sin[slot]),
                    (x, y)
                );
                let speed = memory.tooth_impact_velocity[s * n + k];
                let inverse = if speed > 0.0 { 1.0 / speed } else { 0.0 };
                assert_eq!(of_sprocket.inverse_impact_velocity[slot], inverse);
                let pair = model.tooth_pair(s, memory.tooth_surface[s * n + k]);
                let constants = model.teeth.law.pairs.pairs()[pair];
                assert_eq!(
                    of_sprocket.kept_constants.each_ref().map(|a| a[slot]),
                    constants
                );
            }
            for (k, listed) in listed.iter().enumerate() {
                let distance = (Vec2::new(places.x[k], places.y[k]) - center).norm();
                let has_memory = memory.tooth_impact_velocity[s * n + k] > 0.0;
                if distance < sprocket.reach + model.half_pitch || has_memory {
                    assert!(listed.is_some(), "{s} {k}");
                }
                if listed.is_none() {
                    assert_eq!(of_sprocket.slot_of(k, n), None);
                    assert_eq!(candidates.gap(&model, s, k), None);
                }
            }
            let past = of_sprocket
                .runs
                .iter()
                .map(|run| (run.first + run.length).saturating_sub(n));
            overhang = overhang.max(past.max().unwrap_or(0));
        }
        assert_eq!(candidates.overhang, overhang);
    }
}

#[test]
fn bushings_far_from_all_sprockets_are_no_candidates() {
    let (model, _) = compiled(&drive());
    let mut places = places(&model, 1);
    for (k, x) in places.x.iter_mut().enumerate() {
        // Only every tenth bushing is at its place; others are 1 m away.
        *x += if k % 20 == 0 { 0.0 } else { 1.0 };
    }
    let s = 0;
    (places.x[0], places.y[0]) = (model.sprockets[s].center.x, model.sprockets[s].center.y);
    let candidates = refreshed(&model, &memory_of(&model), &places);
    let listed: Vec<usize> = candidates.sprockets[s]
        .bushings(model.links)
        .map(|(_, k)| k)
        .collect();
    assert_eq!(listed, [0]);
    // Just within the margin and just out of it.
    for (share, count) in [(0.999, 2), (1.001, 1)] {
        let distance = model.sprockets[s].reach + share * model.half_pitch;
        let place = model.sprockets[s].center + distance * unit(2.0);
        (places.x[12], places.y[12]) = (place.x, place.y);
        let candidates = refreshed(&model, &memory_of(&model), &places);
        assert_eq!(candidates.sprockets[s].runs.len(), count);
    }
}

#[test]
fn a_list_holds_while_bushings_and_movable_sprockets_move_less_than_the_margin_together() {
    let (model, _) = compiled(&with_tensioner(None));
    let places = places(&model, 2);
    let candidates = refreshed(&model, &memory_of(&model), &places);
    let margin = model.half_pitch;
    let moved = |bushings: f64, sprocket: f64| {
        candidates.hold(bushings * bushings, |s| {
            // The fixed sprocket is not asked for: its centre is where it was.
            places.frames[s].0
                + if s == 1 {
                    sprocket * unit(2.2)
                } else {
                    Vec2::repeat(1.0)
                }
        })
    };
    assert!(moved(0.0, 0.0) && moved(0.49 * margin, 0.49 * margin));
    // Sufficient for a sum below the margin: (a + b)² is at most 2 (a² + b²).
    for k in 0..200 {
        let (a, b) = (
            f64::from(k % 20) / 19.0 * margin,
            f64::from(k / 20) / 9.0 * margin,
        );
        assert!(!(moved(a, b) && a + b >= margin), "{a} {b}");
    }
    for moves in [(0.7, 0.0), (0.0, 0.7)] {
        assert!(moved(moves.0 * margin, moves.1 * margin), "{moves:?}");
        assert!(!moved(1.1 * moves.0 * margin, 1.1 * moves.1 * margin));
    }
    let mut lost = candidates.clone();
    lost.invalidate();
    assert!(!lost.hold(0.0, |s| places.frames[s].0));
    assert!(!Candidates::new(&model).hold(0.0, |_| Vec2::zeros()));
}

#[test]
fn a_list_built_at_an_undefined_place_is_invalid() {
    let (model, _) = compiled(&with_tensioner(None));
    let memory = memory_of(&model);
    let hold = |change: fn(&mut Places)| {
        let mut places = places(&model, 3);
        change(&mut places);
        let frames = places.frames.clone();
        refreshed(&model, &memory, &places).hold(0.0, |s| {
            let center = frames[s].0;
            if center.x.is_finite() && center.y.is_finite() {
                center
            } else {
                Vec2::zeros()
            }
        })
    };
    assert!(hold(|_| ()));
    assert!(!hold(|places| places.x[5] = f64::NAN));
    assert!(!hold(|places| places.y[39] = f64::INFINITY));
    assert!(!hold(|places| places.frames[1].0.x = f64::NAN));
    assert!(!hold(|places| places.frames[1].0.y = f64::NAN));
    // An undefined bushing is a candidate of every sprocket, so that its forces are undefined.
    let mut places = places(&model, 3);
    places.x[5] = f64::NAN;
    let candidates = refreshed(&model, &memory, &places);
    assert!(
        candidates
            .sprockets
            .iter()
            .all(|c| c.slot_of(5, model.links).is_some())
    );
}

#[test]
fn a_change_of_the_memory_enters_the_slot_of_its_pair() {
    let (model, _) = compiled(&drive());
    let places = places(&model, 4);
    let mut memory = memory_of(&model);
    let mut candidates = refreshed(&model, &memory, &places);
    let (slot, k) = candidates.sprockets[1]
        .bushings(model.links)
        .nth(2)
        .unwrap();
    memory.begin_tooth(model.links + k, 0.2, Surface::FLAT);
    candidates.update_memory(&model, &memory, ContactId::Tooth(model.links + k));
    assert_eq!(candidates.sprockets[1].inverse_impact_velocity[slot], 5.0);
    assert_eq!(
        candidates.sprockets[1]
            .kept_constants
            .each_ref()
            .map(|a| a[slot]),
        surface_constants(&model, 1, Surface::FLAT)
    );
    let others = candidates
        .sprockets
        .iter()
        .flat_map(|c| c.inverse_impact_velocity.iter());
    assert_eq!(others.filter(|&&inverse| inverse != 0.0).count(), 1);
}

#[test]
fn pieces_are_the_bushings_of_all_runs_in_their_order() {
    let (model, _) = compiled(&with_tensioner(None));
    let mut memory = memory_of(&model);
    memory.begin_tooth(model.links - 1, 0.2, Surface::FLAT);
    memory.begin_tooth(0, 0.2, Surface::FLAT);
    let candidates = refreshed(&model, &memory, &places(&model, 5));
    // The last bushing and the first one are in one run: its second piece is not empty.
    let behind = candidates.sprockets[0].pieces(model.links);
    assert!(
        behind
            .into_iter()
            .any(|(k, slots)| k == 0 && !slots.is_empty())
    );
    for of_sprocket in &candidates.sprockets {
        let pieces: Vec<_> = of_sprocket.pieces(model.links).collect();
        let listed = pieces.iter().flat_map(|(k, slots)| slots.clone().zip(*k..));
        assert!(listed.eq(of_sprocket.bushings(model.links)));
        assert!(
            pieces
                .iter()
                .all(|(k, slots)| k + slots.len() <= model.links)
        );
    }
}

#[test]
fn a_copy_and_a_restored_checkpoint_are_the_same_list() {
    let (model, _) = compiled(&with_tensioner(None));
    let mut places = places(&model, 5);
    let mut memory = memory_of(&model);
    memory.begin_tooth(39, 0.2, Surface::FLAT);
    memory.begin_tooth(0, 0.2, Surface::FLAT);
    places.frames[1].0 += Vec2::new(1e-3, -2e-3);
    let original = refreshed(&model, &memory, &places);
    assert!(original.overhang > 0);
    let same = |other: &Candidates| {
        assert_eq!(other.overhang, original.overhang);
        assert_eq!(other.reference, original.reference);
        assert_eq!(other.movable, original.movable);
        for (one, other) in original.sprockets.iter().zip(&other.sprockets) {
            assert_eq!(one.runs, other.runs);
            assert_eq!(one.gap, other.gap);
            let (mut one, mut other) = (one.clone(), other.clone());
            assert_eq!(one.arrays(), other.arrays());
        }
        assert!(other.hold(0.0, |s| places.frames[s].0));
    };
    let mut copy = Candidates::new(&model);
    copy.copy(&original);
    same(&copy);
    let checkpoint = original.to_checkpoint(&model);
    let mut restored = Candidates::new(&model);
    assert!(restored.restore(&model, &memory, &checkpoint).is_some());
    same(&restored);
    assert_eq!(restored.refreshes(), 1);
    assert_eq!(restored.to_checkpoint(&model), checkpoint);
    // An invalid list is not stored, only the count.
    let mut lost = original.clone();
    lost.invalidate();
    let mut restored = original.clone();
    assert!(
        restored
            .restore(&model, &memory, &lost.to_checkpoint(&model))
            .is_some()
    );
    assert!(!restored.hold(0.0, |s| places.frames[s].0));
    assert_eq!(restored.refreshes(), 1);
}

#[test]
fn the_reserved_slots_suffice_where_all_bushings_are_near() {
    let (model, _) = compiled(&drive());
    let mut places = places(&model, 6);
    places.x.fill(model.sprockets[0].center.x);
    places.y.fill(model.sprockets[0].center.y);
    let candidates = refreshed(&model, &memory_of(&model), &places);
    let slots = candidates.sprockets[0].gap.len();
    assert_eq!(slots, padded(model.links));
    assert!(slots <= Candidates::most_slots(&model));
}
