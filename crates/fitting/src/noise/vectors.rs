//! The recursions' inner loops on the widest vectors that the processor has.

/// Runs a kernel compiled for the vectors of the processor at hand. Lanes are columns, and a product is
/// fused with a sum only where the kernel says so: every width computes the same bits. The kernel must be `#[inline(always)]`, or it is compiled for the least of processors.
#[inline(always)]
pub(super) fn wide<R>(kernel: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(kernel)
}
