//! The self test finds every floating-point mode that the proofs do not cover.

#![cfg(target_arch = "x86_64")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::arch::asm;

use veribound_interval::{SelfTestError, self_test};

/// Runs the self test with bits of the control register set, and restores the register.
#[inline(never)]
fn self_test_with(bits: u32) -> Result<(), SelfTestError> {
    let mut usual = 0_u32;
    // SAFETY: stmxcsr stores 4 bytes to a valid address.
    unsafe { asm!("stmxcsr [{}]", in(reg) &mut usual, options(nostack)) };
    let changed = usual | bits;
    // SAFETY: the register keeps its exception masks; only rounding or flushing changes, and the
    // floating-point work before the restoration is the self test alone.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &changed, options(nostack)) };
    let result = self_test();
    // SAFETY: restores the value stored above.
    unsafe { asm!("ldmxcsr [{}]", in(reg) &usual, options(nostack)) };
    result
}

#[test]
fn changed_modes_are_found() {
    self_test_with(0).unwrap();
    for rounding in [1 << 13, 2 << 13, 3 << 13] {
        assert_eq!(
            self_test_with(rounding),
            Err(SelfTestError::NotRoundedToNearest)
        );
    }
    let flush_to_zero = 1 << 15;
    assert_eq!(
        self_test_with(flush_to_zero),
        Err(SelfTestError::SubnormalResultsFlushed)
    );
    let denormals_are_zero = 1 << 6;
    assert_eq!(
        self_test_with(denormals_are_zero),
        Err(SelfTestError::SubnormalOperandsFlushed)
    );
    self_test_with(0).unwrap();
}
