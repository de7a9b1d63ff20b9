//! Transfers that are made once and used again: the USB link's one file with `unsafe`.
//!
//! libusb reads and writes a transfer from the moment it is submitted until its callback has run. What makes this sound:
//!
//! - transfer, buffer and mark live in places of their own on the heap, which are freed when the transfer is not on its way, or else never;
//! - the mark is set before a submit and taken away by the callback, the last thing that libusb does with a transfer; this file
//!   looks at a transfer and its buffer only while the mark is away;
//! - the handle is closed after its transfers are freed.
//!
//! Callbacks run in whatever thread handles libusb's events: the owner's while it receives or sends, the reopening thread's while it opens or
//! closes. The mark is therefore atomic, and libusb's own locks keep event handling to one thread at a time.

use std::cell::UnsafeCell;
use std::ffi::c_void;
use std::os::fd::{BorrowedFd, RawFd};
use std::ptr::{NonNull, null_mut};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use haptor_wire::PACKET_BYTES;
use haptor_wire::usb::Endpoints;
use rusb::constants::{
    LIBUSB_SUCCESS, LIBUSB_TRANSFER_CANCELLED, LIBUSB_TRANSFER_COMPLETED, LIBUSB_TRANSFER_TYPE_BULK,
    LIBUSB_TRANSFER_TYPE_INTERRUPT,
};
use rusb::{Context, DeviceHandle, UsbContext, ffi};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use super::super::LinkError;

/// Transfers that fetch: what the device says in so many periods is taken even while the thread sleeps.
const FETCHING: usize = 4;

/// Transfers that bring: one on the bus, and one behind it, so that a device that takes a packet late costs no command.
const BRINGING: usize = 2;

/// Time after which a packet that the device does not take is withdrawn: a wrench older than that is no longer meant.
const WITHDRAW_AFTER: Duration = Duration::from_millis(5);

/// Looks at most while closing, each of [`CLOSING_LOOK`]: a kernel hands withdrawn transfers back within milliseconds.
const CLOSING_LOOKS: u32 = 100;

/// Length of such a look.
const CLOSING_LOOK: Duration = Duration::from_millis(10);

/// Which kind of endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The bus reserves turns.
    Interrupt,
    /// What is left.
    Bulk,
}

/// What is not this program's alone while a transfer is on its way.
#[derive(Debug)]
struct Place {
    on_its_way: AtomicBool,
    buffer: UnsafeCell<[u8; PACKET_BYTES]>,
}

/// One transfer and its place.
#[derive(Debug)]
struct Transfer {
    raw: NonNull<ffi::libusb_transfer>,
    place: NonNull<Place>,
}

extern "system" fn came_back(raw: *mut ffi::libusb_transfer) {
    // SAFETY: libusb calls this with a transfer of ours, whose `user_data` is its place; both outlive the transfer's way
    let place = unsafe { &*(*raw).user_data.cast::<Place>() };
    place.on_its_way.store(false, Ordering::Release);
}

impl Transfer {
    fn new(handle: &DeviceHandle<Context>, kind: Kind, endpoint: u8) -> rusb::Result<Self> {
        // SAFETY: no precondition; 0 = not isochronous
        let raw = NonNull::new(unsafe { ffi::libusb_alloc_transfer(0) }).ok_or(rusb::Error::NoMem)?;
        let place = Place { on_its_way: AtomicBool::new(false), buffer: UnsafeCell::new([0; PACKET_BYTES]) };
        let place = NonNull::from(Box::leak(Box::new(place)));
        let transfer = Self { raw, place };
        // SAFETY: allocated above and not submitted, so nobody else looks at it
        let fields = unsafe { &mut *raw.as_ptr() };
        fields.dev_handle = handle.as_raw();
        fields.endpoint = endpoint;
        fields.transfer_type = match kind {
            Kind::Interrupt => LIBUSB_TRANSFER_TYPE_INTERRUPT,
            Kind::Bulk => LIBUSB_TRANSFER_TYPE_BULK,
        };
        // none: how long is waited is this program's business
        fields.timeout = 0;
        fields.buffer = transfer.place().buffer.get().cast();
        fields.length = PACKET_BYTES as i32;
        fields.callback = came_back;
        fields.user_data = place.as_ptr().cast::<c_void>();
        Ok(transfer)
    }

    fn place(&self) -> &Place {
        // SAFETY: lives until `self` is dropped; libusb and the callback touch it through cells only
        unsafe { self.place.as_ref() }
    }

    fn is_on_its_way(&self) -> bool {
        self.place().on_its_way.load(Ordering::Acquire)
    }

    /// How it came back, and the bytes that it carried; before it was ever sent, well and none.
    fn came_back(&self) -> (i32, usize) {
        debug_assert!(!self.is_on_its_way());
        // SAFETY: not on its way, so libusb does not touch it
        let fields = unsafe { self.raw.as_ref() };
        (fields.status, usize::try_from(fields.actual_length).unwrap_or(0).min(PACKET_BYTES))
    }

    /// The buffer, which is this program's while the transfer is not on its way.
    fn buffer(&mut self) -> &mut [u8; PACKET_BYTES] {
        debug_assert!(!self.is_on_its_way());
        // SAFETY: not on its way, so libusb does not touch it; `&mut self` keeps it to one borrower
        unsafe { &mut *self.place().buffer.get() }
    }

    fn submit(&mut self) -> Result<(), LinkError> {
        self.place().on_its_way.store(true, Ordering::Release);
        // SAFETY: complete since `new`, not on its way, its handle open
        let result = unsafe { ffi::libusb_submit_transfer(self.raw.as_ptr()) };
        if result == LIBUSB_SUCCESS {
            return Ok(());
        }
        self.place().on_its_way.store(false, Ordering::Release);
        Err(LinkError::Closed)
    }

    /// Asks for it back; it comes by its callback.
    fn withdraw(&self) {
        if self.is_on_its_way() {
            // SAFETY: allocated, its handle open; one that has just come back is answered by an error that says so
            unsafe { ffi::libusb_cancel_transfer(self.raw.as_ptr()) };
        }
    }
}

impl Drop for Transfer {
    fn drop(&mut self) {
        if self.is_on_its_way() {
            // the kernel never gave it back: libusb may still write to it, so it stays
            return;
        }
        // SAFETY: not on its way; both were allocated in `new` and are not used after this
        unsafe {
            ffi::libusb_free_transfer(self.raw.as_ptr());
            drop(Box::from_raw(self.place.as_ptr()));
        }
    }
}

// SAFETY: no part is bound to a thread; what callbacks in other threads touch is atomic
unsafe impl Send for Transfer {}

/// A claimed device with its transfers. Fields drop in order: the handle is closed last.
#[derive(Debug)]
pub struct Transfers {
    fetching: [Transfer; FETCHING],
    /// Of those, the one that comes back next: an endpoint keeps the order.
    next: usize,
    bringing: [Transfer; BRINGING],
    /// When each of those was last sent.
    sent: [Instant; BRINGING],
    /// Of those, the one that is free first.
    free: usize,
    /// The kernel's descriptor of the device, libusb's own; ready when a transfer has come back.
    descriptor: RawFd,
    handle: DeviceHandle<Context>,
}

impl Transfers {
    /// Makes the transfers and begins to fetch.
    ///
    /// # Errors
    /// No memory, or the device is gone.
    pub fn start(handle: DeviceHandle<Context>, kind: Kind, pair: Endpoints) -> rusb::Result<Self> {
        let fetch = || Transfer::new(&handle, kind, pair.to_host);
        let fetching = [fetch()?, fetch()?, fetch()?, fetch()?];
        let bring = || Transfer::new(&handle, kind, pair.to_device);
        let bringing = [bring()?, bring()?];
        let descriptor = descriptor(&handle).ok_or(rusb::Error::NotSupported)?;
        let sent = [Instant::now(); BRINGING];
        let mut transfers = Self { fetching, next: 0, bringing, sent, free: 0, descriptor, handle };
        for transfer in &mut transfers.fetching {
            transfer.submit().map_err(|_| rusb::Error::NoDevice)?;
        }
        Ok(transfers)
    }

    /// Sends a packet unless those before it are still on their way; never waits.
    ///
    /// # Errors
    /// [`LinkError::Full`] when they are, [`LinkError::Closed`] when one of them came back badly.
    pub fn send(&mut self, packet: &[u8; PACKET_BYTES]) -> Result<(), LinkError> {
        if self.bringing[self.free].is_on_its_way() {
            self.look(Duration::ZERO);
        }
        if self.bringing[self.free].is_on_its_way() {
            if self.sent[self.free].elapsed() > WITHDRAW_AFTER {
                self.bringing.iter().for_each(Transfer::withdraw);
            }
            return Err(LinkError::Full);
        }
        if !self.is_well() {
            return Err(LinkError::Closed);
        }
        let transfer = &mut self.bringing[self.free];
        *transfer.buffer() = *packet;
        transfer.submit()?;
        self.sent[self.free] = Instant::now();
        self.free = (self.free + 1) % BRINGING;
        Ok(())
    }

    /// Takes the next packet, waiting up to `wait` for it; 0 = none came.
    ///
    /// # Errors
    /// [`LinkError::Closed`] when a transfer came back badly, in either direction.
    pub fn receive(&mut self, into: &mut [u8], wait: Duration) -> Result<usize, LinkError> {
        let Some(transfer) = self.await_next(wait)? else { return Ok(0) };
        let (LIBUSB_TRANSFER_COMPLETED, bytes) = transfer.came_back() else { return Err(LinkError::Closed) };
        // a packet without bytes is a damaged one and not "none came": one byte of it, which is no message either, says so
        let carried = bytes.max(1).min(into.len());
        into[..carried].copy_from_slice(&transfer.buffer()[..carried]);
        transfer.submit()?;
        self.next = (self.next + 1) % FETCHING;
        Ok(carried)
    }

    /// The next transfer to come back, once it has; `None` = not within `wait`.
    fn await_next(&mut self, wait: Duration) -> Result<Option<&mut Transfer>, LinkError> {
        let begin = Instant::now();
        let mut left = wait;
        while self.fetching[self.next].is_on_its_way() {
            self.look(left);
            if !self.is_well() {
                return Err(LinkError::Closed);
            }
            let passed = begin.elapsed();
            if passed >= wait {
                break;
            }
            left = wait - passed;
        }
        let next = &mut self.fetching[self.next];
        Ok(if next.is_on_its_way() { None } else { Some(next) })
    }

    /// False when a packet did not reach the device for another reason than that it was withdrawn.
    fn is_well(&self) -> bool {
        self.bringing.iter().all(|sent| {
            sent.is_on_its_way() || matches!(sent.came_back().0, LIBUSB_TRANSFER_COMPLETED | LIBUSB_TRANSFER_CANCELLED)
        })
    }

    /// Lets libusb take what has come back, waiting up to `wait` for the first. libusb itself would wait in whole milliseconds.
    fn look(&self, wait: Duration) {
        if !wait.is_zero() {
            let timeout = Timespec { tv_sec: wait.as_secs() as i64, tv_nsec: wait.subsec_nanos().into() };
            // SAFETY: open as long as the handle
            let descriptor = unsafe { BorrowedFd::borrow_raw(self.descriptor) };
            // a signal or a failure only cuts the wait short
            let _ = poll(&mut [PollFd::from_borrowed_fd(descriptor, PollFlags::OUT)], Some(&timeout));
        }
        let at_once = libc::timeval { tv_sec: 0, tv_usec: 0 };
        // SAFETY: the context lives in the handle, `at_once` through the call. A failure shows at the transfers
        unsafe { ffi::libusb_handle_events_timeout_completed(self.handle.context().as_raw(), &raw const at_once, null_mut()) };
    }
}

/// The descriptor of the device opened last: the last of those that libusb waits for until they can be written.
fn descriptor(handle: &DeviceHandle<Context>) -> Option<RawFd> {
    // SAFETY: the context lives in the handle; the list ends with null and is freed below
    let list = unsafe { ffi::libusb_get_pollfds(handle.context().as_raw()) };
    let mut found = None;
    // SAFETY: as above; each entry before the null is valid until the list is freed
    unsafe {
        let mut at = list;
        while let Some(entry) = at.as_ref().and_then(|entry| entry.as_ref()) {
            if entry.events & libc::POLLOUT != 0 {
                found = Some(entry.fd);
            }
            at = at.add(1);
        }
        if !list.is_null() {
            ffi::libusb_free_pollfds(list);
        }
    }
    found
}

impl Drop for Transfers {
    fn drop(&mut self) {
        let all = || self.fetching.iter().chain(&self.bringing);
        all().for_each(Transfer::withdraw);
        for _ in 0..CLOSING_LOOKS {
            if !all().any(Transfer::is_on_its_way) {
                return;
            }
            self.look(CLOSING_LOOK);
        }
    }
}
