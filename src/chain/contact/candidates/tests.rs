//! Tests of the runs of candidates.

use super::*;

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
