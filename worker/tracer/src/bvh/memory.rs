//! Arrays that rays jump about in.

use std::ops::Deref;

use bytemuck::Pod;

/// The size of a huge page.
#[cfg(target_os = "linux")]
const HUGE: usize = 2 << 20;

/// A read-only array, on huge pages where it is large and the system has them: otherwise rays in random directions wait
/// for address translations, and through a million triangles a fifth fewer of them are traced.
pub(super) enum Pages<T> {
    Heap(Vec<T>),
    #[cfg(target_os = "linux")]
    Mapped {
        map: memmap2::MmapMut,
        /// The bytes of the array within the map.
        bytes: std::ops::Range<usize>,
    },
}

impl<T: Pod> Pages<T> {
    pub fn new(items: Vec<T>) -> Self {
        #[cfg(target_os = "linux")]
        if size_of_val(items.as_slice()) >= HUGE
            && let Some(mapped) = Self::map(&items)
        {
            return mapped;
        }
        Self::Heap(items)
    }

    /// `None` where the system refuses the memory, or the advice.
    #[cfg(target_os = "linux")]
    fn map(items: &[T]) -> Option<Self> {
        let from: &[u8] = bytemuck::cast_slice(items);
        let mut map = memmap2::MmapMut::map_anon(from.len() + HUGE).ok()?;
        map.advise(memmap2::Advice::HugePage).ok()?;
        let start = map.as_ptr().align_offset(HUGE);
        let bytes = start..start + from.len();
        map.get_mut(bytes.clone())?.copy_from_slice(from);
        Some(Self::Mapped { map, bytes })
    }
}

impl<T: Pod> Deref for Pages<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        match self {
            Self::Heap(items) => items,
            #[cfg(target_os = "linux")]
            Self::Mapped { map, bytes } => bytemuck::cast_slice(&map[bytes.clone()]),
        }
    }
}
