//! Which effects explain about as much as the best: what these data cannot tell apart is named as a set.

use super::accept::{Comparison, believed};
use crate::evidence::Evidence;
use crate::policy::Policy;

/// Whether one extension of a model explains about as much as the best.
pub(super) fn rivals(own: &Comparison, best: &Comparison, evidence: &Evidence, policy: &Policy) -> bool {
    let (gain, most) = (own.gain(evidence), best.gain(evidence));
    let alike = gain > policy.rival * most;
    let untold = gain > policy.rival_untold * most && !believed(&best.beyond(own), policy.tell_apart);
    // Photos left out that are predicted worse may be the fault of how that is estimated.
    let falls_alike = own.fall(evidence) > policy.rival_fall * best.fall(evidence);
    alike || untold || falls_alike && gain > policy.rival_least * most
}
