//! One trace for what client, coordinator and workers do for an evaluation: spans that name each other across processes.
//!
//! The name is a `traceparent` (<https://www.w3.org/TR/trace-context/>). It travels as metadata of the call, and from the
//! coordinator to workers with the evaluation's setup. Without the feature `otel`, or without a collector, it is empty.

use tracing::Span;

/// The current span's name; empty where nobody records it.
#[must_use]
pub fn trace_parent() -> String {
    #[cfg(feature = "otel")]
    return crate::otel::trace_parent();
    #[cfg(not(feature = "otel"))]
    String::new()
}

/// Makes `span`, which has not been entered yet, a child of the span of that name; one that is none changes nothing.
pub fn follow(span: &Span, trace_parent: &str) {
    #[cfg(feature = "otel")]
    crate::otel::follow(span, trace_parent);
    #[cfg(not(feature = "otel"))]
    let _ = (span, trace_parent);
}
