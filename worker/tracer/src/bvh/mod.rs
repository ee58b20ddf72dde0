//! The ray engine: which triangle a ray meets first, and whether it meets any.
//!
//! [`Bvh`] is a bounding volume hierarchy with eight children per node and up to eight triangles per leaf. `split` builds
//! a binary tree by the surface area heuristic, obvhs improves it by reinsertion, `collapse` makes it eight wide,
//! `layout` writes the arrays. `traverse` takes single rays through them, `packet` bundles of coherent ones, both over
//! `lanes`, which is AVX2 where the processor has it and plain Rust elsewhere.
//!
//! **Hits do not depend on the path.** `triangle` defines whether and where a ray hits a triangle by the two alone, in
//! arithmetic that is the same per lane everywhere, with no fused multiply-add. Boxes only ever cull what that test
//! rejects. Of equally near hits the smallest triangle index wins. So hierarchy, instruction set and packets change how
//! long an answer takes, never a bit of it.

mod bounds;
mod bundle;
mod collapse;
mod lanes;
mod layout;
mod memory;
mod node;
mod octet;
mod packet;
mod ray;
mod split;
mod stack;
mod stream;
#[cfg(test)]
mod tests;
mod traverse;
mod triangle;

pub(crate) use bundle::{Bundle, Hits};
pub use ray::{Hit, Ray};

use glam::Vec3;
use lanes::portable::Portable;
use layout::Layout;

#[cfg(target_arch = "x86_64")]
use lanes::avx2::Avx2;

/// A hierarchy over a triangle mesh. It allocates nothing per ray and may be shared by threads.
///
/// A ray never slips between two triangles that share two vertices. Triangles count from both sides. There is no
/// smallest or largest scale between 1e-12 and 1e12.
pub struct Bvh {
    layout: Layout,
    #[cfg(target_arch = "x86_64")]
    avx2: Option<Avx2>,
}

impl Bvh {
    /// Builds the hierarchy over triangles given by their three vertices, in any unit of length.
    ///
    /// Triangles without an area (less than 1e-14 of the product of two sides), or with a coordinate that is not finite
    /// or beyond 1e12, keep their index and are never hit. So are all after the first 2^28.
    #[must_use]
    pub fn build(triangles: &[[Vec3; 3]]) -> Self {
        Self {
            layout: layout::layout(triangles),
            #[cfg(target_arch = "x86_64")]
            avx2: Avx2::detect(),
        }
    }

    /// The first triangle that the ray meets.
    #[must_use]
    #[inline]
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: the token proves that the processor has what the function enables.
            #[allow(unsafe_code)]
            return unsafe { closest_avx2(avx2, &self.layout, ray) };
        }
        closest_portable(&self.layout, ray)
    }

    /// Whether the ray meets any triangle: quicker than, and always the same as, `closest(ray).is_some()`.
    #[must_use]
    #[inline]
    pub fn occluded(&self, ray: &Ray) -> bool {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: as in `closest`.
            #[allow(unsafe_code)]
            return unsafe { occluded_avx2(avx2, &self.layout, ray) };
        }
        occluded_portable(&self.layout, ray)
    }

    /// The first triangle that each ray meets: the same as [`Bvh::closest`], several times faster where 16 consecutive
    /// rays (16 k to 16 k + 15) start and run close together, as those of a tile of 4 x 4 pixels, or of the samples of
    /// one pixel. Fills the elements of `hits` that have a ray.
    pub fn closest_packet(&self, rays: &[Ray], hits: &mut [Option<Hit>]) {
        for (rays, hits) in rays.chunks(packet::PACKET).zip(hits.chunks_mut(packet::PACKET)) {
            let mut found = Hits::NONE;
            self.closest_bundle(&Bundle::new(rays), &mut found);
            for (lane, (hit, _)) in hits.iter_mut().zip(rays).enumerate() {
                *hit = found.get(lane);
            }
        }
    }

    /// Whether each ray meets any triangle: the same as [`Bvh::occluded`], faster for rays as [`Bvh::closest_packet`]
    /// wants them. Fills the elements of `blocked` that have a ray.
    pub fn occluded_packet(&self, rays: &[Ray], blocked: &mut [bool]) {
        for (rays, blocked) in rays.chunks(packet::PACKET).zip(blocked.chunks_mut(packet::PACKET)) {
            let found = self.occluded_bundle(&Bundle::new(rays));
            for (lane, (blocked, _)) in blocked.iter_mut().zip(rays).enumerate() {
                *blocked = found >> lane & 1 != 0;
            }
        }
    }

    /// [`Bvh::closest_packet`] for at most 16 rays.
    pub(crate) fn closest_bundle(&self, rays: &Bundle, hits: &mut Hits) {
        if !self.closest_coherent(rays, hits) {
            for lane in (0..packet::PACKET).filter(|lane| rays.used >> lane & 1 != 0) {
                hits.set(lane, self.closest(&rays.ray(lane)));
            }
        }
    }

    /// [`Bvh::occluded_packet`] for at most 16 rays: those that meet a triangle, as bits.
    pub(crate) fn occluded_bundle(&self, rays: &Bundle) -> u32 {
        self.occluded_coherent(rays).unwrap_or_else(|| {
            let lanes = (0..packet::PACKET).filter(|lane| rays.used >> lane & 1 != 0);
            lanes.fold(0, |bits, lane| bits | u32::from(self.occluded(&rays.ray(lane))) << lane)
        })
    }

    /// [`Bvh::closest_bundle`], faster for rays that start close together and mostly meet nothing.
    pub(crate) fn closest_stream(&self, rays: &Bundle, hits: &mut Hits) {
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: as in `closest`.
            #[allow(unsafe_code)]
            return unsafe { stream_avx2(avx2, &self.layout, rays, hits) };
        }
        stream_portable(&self.layout, rays, hits);
    }

    /// As [`Bvh::closest_coherent`], by `None`.
    fn occluded_coherent(&self, rays: &Bundle) -> Option<u32> {
        if rays.count() < packet::PACKET / 4 {
            return None;
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: as in `closest`.
            #[allow(unsafe_code)]
            return unsafe { occluded_packet_avx2(avx2, &self.layout, rays) };
        }
        occluded_packet_portable(&self.layout, rays)
    }

    /// False, and nothing done, where the rays are too few or too far apart to share a walk.
    fn closest_coherent(&self, rays: &Bundle, hits: &mut Hits) -> bool {
        if rays.count() < packet::PACKET / 4 {
            return false;
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(avx2) = self.avx2 {
            // SAFETY: as in `closest`.
            #[allow(unsafe_code)]
            return unsafe { packet_avx2(avx2, &self.layout, rays, hits) };
        }
        packet_portable(&self.layout, rays, hits)
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn closest_avx2(avx2: Avx2, layout: &Layout, ray: &Ray) -> Option<Hit> {
    traverse::closest(avx2, &layout.nodes, &layout.leaves, ray)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn occluded_avx2(avx2: Avx2, layout: &Layout, ray: &Ray) -> bool {
    traverse::occluded(avx2, &layout.nodes, &layout.leaves, ray)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn packet_avx2(avx2: Avx2, layout: &Layout, rays: &Bundle, hits: &mut Hits) -> bool {
    packet::closest(avx2, &layout.nodes, &layout.leaves, layout.extent, rays, hits)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn occluded_packet_avx2(avx2: Avx2, layout: &Layout, rays: &Bundle) -> Option<u32> {
    packet::occluded(avx2, &layout.nodes, &layout.leaves, layout.extent, rays)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn stream_avx2(avx2: Avx2, layout: &Layout, rays: &Bundle, hits: &mut Hits) {
    stream::closest(avx2, &layout.nodes, &layout.leaves, rays, hits);
}

// Kept out of line, so that the fast path above carries none of their registers.
#[inline(never)]
fn closest_portable(layout: &Layout, ray: &Ray) -> Option<Hit> {
    traverse::closest(Portable, &layout.nodes, &layout.leaves, ray)
}

#[inline(never)]
fn occluded_portable(layout: &Layout, ray: &Ray) -> bool {
    traverse::occluded(Portable, &layout.nodes, &layout.leaves, ray)
}

#[inline(never)]
fn packet_portable(layout: &Layout, rays: &Bundle, hits: &mut Hits) -> bool {
    packet::closest(Portable, &layout.nodes, &layout.leaves, layout.extent, rays, hits)
}

#[inline(never)]
fn occluded_packet_portable(layout: &Layout, rays: &Bundle) -> Option<u32> {
    packet::occluded(Portable, &layout.nodes, &layout.leaves, layout.extent, rays)
}

#[inline(never)]
fn stream_portable(layout: &Layout, rays: &Bundle, hits: &mut Hits) {
    stream::closest(Portable, &layout.nodes, &layout.leaves, rays, hits);
}
