//! Steps, onsets and evaluations allocate nothing: all room is made when a run is set up.
#![allow(clippy::unwrap_used)]
#![allow(unsafe_code)] // a counting allocator has to be one

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Duration;

use rustchain::force_law::{Damping, Elastic, ForceLaw, Regions};
use rustchain::{ForceLaws, Groups};

/// Counts what this thread asks for.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

fn count() {
    // No thread-local storage any more while a thread ends.
    let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
}

// SAFETY: every call is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn the_counter_counts() {
    let before = ALLOCATIONS.get();
    let room = vec![0u8; 100];
    assert_eq!(ALLOCATIONS.get(), before + 1);
    drop(room);
}

#[test]
fn ten_milliseconds_with_hundreds_of_onsets_allocate_nothing() {
    for elastic in [Elastic::Hertz, Elastic::Johnson, Elastic::EnhancedCylinder] {
        for regions in [Regions::Kept, Regions::Sharp] {
            let law = ForceLaw {
                elastic,
                damping: Damping::LankaraniNikravesh,
                regions,
            };
            let laws = ForceLaws {
                hinge: law,
                tooth: law,
                ..ForceLaws::default()
            };
            let mut simulation =
                common::simulation(&common::paper_drive(), &laws, common::control(1e-5));
            simulation.start_recording(
                1.0,
                1.0,
                Groups {
                    energy: true,
                    ..Groups::default()
                },
            );
            // Past the first report, which makes the room for its row.
            simulation.advance(5e-3, Duration::MAX).unwrap();
            let begun = simulation.statistics();
            let before = ALLOCATIONS.get();
            simulation.advance(15e-3, Duration::MAX).unwrap();
            let allocations = ALLOCATIONS.get() - before;
            let done = simulation.statistics();
            assert!(done.counts.steps > begun.counts.steps + 2000, "{elastic:?}");
            assert!(done.onsets > begun.onsets + 100, "{elastic:?}");
            assert_eq!(allocations, 0, "{elastic:?} {regions:?}");
        }
    }
}
