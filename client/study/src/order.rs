//! In which order an observer sees the images.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};
use sha2::{Digest, Sha256};

/// A permutation of 0..`count` that follows from the seed and the observer's name alone, so that a server that starts
/// anew goes on where the observer was (Fisher and Yates, as Durstenfeld 1964 has it).
#[must_use]
pub fn order(seed: u64, observer: &str, count: usize) -> Vec<usize> {
    let digest = Sha256::new().chain_update(seed.to_le_bytes()).chain_update(observer).finalize();
    let mut random = Xoshiro256PlusPlus::from_seed(digest.into());
    let mut order: Vec<usize> = (0..count).collect();
    for i in (1..count).rev() {
        order.swap(i, (random.next_u64() % (i as u64 + 1)) as usize);
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_is_a_permutation_of_its_seed_and_observer() {
        let mut one = order(7, "Ann", 50);
        assert_eq!(one, order(7, "Ann", 50));
        assert_ne!(one, order(8, "Ann", 50));
        assert_ne!(one, order(7, "Bob", 50));
        one.sort_unstable();
        assert_eq!(one, (0..50).collect::<Vec<_>>());
        assert!(order(7, "Ann", 0).is_empty());
    }
}
