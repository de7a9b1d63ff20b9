//! An allocator that counts, thread by thread, so that tests running side by side do not disturb each other.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    /// Calls to the allocator by this thread: allocate, free, resize.
    static CALLS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counted.
struct Counting;

fn count() {
    // a thread that is ending has no counter any more, and nobody asks for it
    let _ = CALLS.try_with(|calls| calls.set(calls.get() + 1));
}

// SAFETY: every call is passed on unchanged; counting neither allocates nor panics
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise, passed on
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promise, passed on
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's promise, passed on
        unsafe { System.realloc(block, layout, size) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller's promise, passed on
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What `body` returns, and how often it called the allocator on this thread.
pub fn counted<T>(body: impl FnOnce() -> T) -> (T, u64) {
    let before = CALLS.with(Cell::get);
    let result = body();
    (result, CALLS.with(Cell::get) - before)
}

#[test]
fn the_counter_counts() {
    let (boxed, calls) = counted(|| Box::new(7));
    assert_eq!((*boxed, calls), (7, 1));
    assert_eq!(counted(|| drop(boxed)).1, 1);
    assert_eq!(counted(|| 3 + 4).1, 0);
}
